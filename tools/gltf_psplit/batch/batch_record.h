// What `batch` has done in an output folder, kept there: what is up to date, whenever the last run ended.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>

#include "gltf_ext/document/document.h"
#include "gltf_ext/files/operating_system.h"

namespace psplit {

// The hash of an asset: its JSON, the bytes of its buffers, and those of the image files that it refers to.
std::string hash_asset(const Document& document);

// A file of lines, one for each asset that was written, of which the last on an output counts. A line that a
// kill cut short counts for nothing. Safe to share between threads; one process at a time has it.
class BatchRecord {
 public:
  struct Entry {
    std::string made_from;  // hash of input and options
    std::string output;     // hash_asset of what was written
  };

  BatchRecord() = default;
  BatchRecord(const BatchRecord&) = delete;
  BatchRecord& operator=(const BatchRecord&) = delete;

  // Makes the folder where there is none. Errors: kIo, also where another process has the record.
  Status open(const std::filesystem::path& folder);
  // Null where nothing is known of the output: if it is there, no batch made it.
  const Entry* find(const std::string& name) const;
  // Before an output is written: a kill may come before add.
  Status begin(const std::string& name) { return add(name, {}); }
  Status add(const std::string& name, const Entry& entry);

 private:
  LockedLog file_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;  // as they were when it was opened
};

}  // namespace psplit
