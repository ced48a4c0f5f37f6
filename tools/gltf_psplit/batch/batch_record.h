// The record of what `batch` wrote into an output folder. It is kept in that folder, so that a later run knows
// which outputs are up to date, no matter how the last run ended.
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

// A file with one line for each asset that was written. The last line of an output counts. A line that a kill
// cut short is ignored. Thread-safe, except `open`; only one process at a time can open the record.
class BatchRecord {
 public:
  struct Entry {
    std::string made_from;  // hash of input and options
    std::string output;     // hash_asset of the written asset
  };

  BatchRecord() = default;
  BatchRecord(const BatchRecord&) = delete;
  BatchRecord& operator=(const BatchRecord&) = delete;

  // Makes the folder if it does not exist. Errors: kIo, also if another process has opened the record.
  Status open(const std::filesystem::path& folder);
  // Null if the output is not in the record: if it exists, no batch made it.
  const Entry* find(const std::string& name) const;
  // Call it before the output is written, because a kill may come before `add`.
  Status begin(const std::string& name) { return add(name, {}); }
  Status add(const std::string& name, const Entry& entry);

 private:
  LockedLog file_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;  // as they were when the record was opened
};

}  // namespace psplit
