// The record of what `batch` wrote into an output folder. It is kept in that folder, so that a later run knows
// which outputs are up to date, no matter how the last run ended, and how many shards it had.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/json/json.h"
#include "system/content_hash.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/batch/shard.h"
#include "tools/gltf_psplit/report/asset_bytes.h"

namespace psplit {

// The hash of an asset: its JSON, and the bytes of its buffers and of the image files that it refers to.
std::string hash_asset(const Document& document);

// The files of an output, with the images and other files that it refers to, and the hash of their bytes. Whole
// files are hashed, because a reader need not see bytes that were appended to them.
struct OutputFiles {
  std::string hash;
  std::vector<std::string> paths;
  AssetBytes bytes;
};
// Reads the output to find its files. Errors: as for read_document.
Expected<OutputFiles> hash_output(const std::filesystem::path& path);
// Hashes an output that write_document has just written; does not parse it if it is one file.
Expected<OutputFiles> hash_output(const std::filesystem::path& path, const Document& document,
                                  const WriteReport& written);

// The folder below the output folder that holds the records and the reports of all shards.
std::filesystem::path record_folder(const std::filesystem::path& output_folder);

// The name of an asset in the record. `check` is empty if the asset was written; otherwise it names the check
// that it passed (validate, diff).
std::string record_name(const std::string& name, const std::string& check = "");

// Each shard writes a file of its own, "<index>-of-<count>.jsonl", with a line for each asset that it wrote,
// and reads the files of all. A line is a fact: an output with this hash was made from an input and options
// with that hash. So the order of lines and files does not matter, and a fact that is lost costs time only. A
// line that a kill cut short is ignored. The lines about one output are numbered: only one shard at a time
// writes about it, and that shard has read all earlier lines. Thread-safe, except `open` and `load`.
class BatchRecord {
 public:
  struct Entry {
    std::string made_from;  // hash of input and options
    std::string output;     // that of hash_output; empty before it was written
    // What else the line says: "figures", which a later run reports, and the "input", absolute and
    // percent-encoded.
    Json details = Json::object();
  };

  BatchRecord() = default;
  BatchRecord(const BatchRecord&) = delete;
  BatchRecord& operator=(const BatchRecord&) = delete;

  // Makes the folders if they do not exist, and locks the shard's file. kMayPass if another process has locked
  // it, or if shards of another count run. Other errors: as for io_error.
  Status open(const std::filesystem::path& folder, const Shard& shard);

  // Opens the record in a process that works for the one that has opened it.
  Status join(const std::filesystem::path& folder, const Shard& shard);

  // Reads what all files say about the outputs of a shard. Memory: 72 bytes for each line about them.
  Status load(const std::filesystem::path& folder, const Shard& shard);

  // Whether a batch made the output, or began to and was killed. Otherwise, if it exists, it is not a batch's.
  bool knows(const std::string& name) const;
  // Whether the output with hash `output` is known to be made from `made_from`.
  bool has(const std::string& name, const Entry& entry) const;
  // Whether the line that was written last says that the output was made from `made_from`.
  bool is_newest(const std::string& name, const std::string& made_from) const;
  // The newest line that says that the output was made from `made_from`, as it was when the record was loaded.
  // Null if there is none.
  Json line(const std::string& name, const std::string& made_from) const;
  // The newest line about each output that was written and not removed since. Errors: as for io_error.
  Status for_each_written(const std::function<void(const Json& line)>& visit) const;
  // The folders of outputs whose writing was begun and not ended: a kill may have left temporary files there.
  // Relative to the output folder.
  std::set<std::filesystem::path> unfinished_folders() const;

  // Call it before the output is written, because a kill may come before `add`.
  Status begin(const std::string& name) { return add(name, {}); }
  // Call it if the output could not be written.
  Status withdraw(const std::string& name);
  // Call it after the output was removed. A file that appears there later is not a batch's.
  Status forget(const std::string& name);
  Status add(const std::string& name, Entry entry);
  // Waits until all lines are on the disk.
  Status sync();

 private:
  struct Fact {
    Hash128 name, made_from, output;
    int64_t number = 0;  // 0 if the line has none
    size_t file = 0;     // index in files_
    uint64_t at = 0;     // the line's place in the file
    auto operator<=>(const Fact&) const = default;
  };
  Status load_file(const std::filesystem::path& file, const Shard& shard);
  std::pair<std::vector<Fact>::const_iterator, std::vector<Fact>::const_iterator> facts(
      const std::string& name) const;

  static std::vector<Fact>::const_iterator newest_of(std::vector<Fact>::const_iterator begin,
                                                     std::vector<Fact>::const_iterator end);
  void forget_removed();
  Expected<Json> line_of(const Fact& fact) const;

  GroupLock division_;
  LockedLog file_;
  std::mutex mutex_;
  int64_t last_number_ = 0;
  std::vector<std::filesystem::path> files_;
  std::vector<Fact> facts_;      // sorted; as they were when the record was loaded
  std::set<std::string> begun_;  // names that a file begins and does not end
};

// Joins the files of all shards into one, and keeps only the newest facts about each asset. The caller holds
// the division's file alone. Errors: as for io_error.
Status merge_records(const std::filesystem::path& folder);
// The file that shards of one count hold together (GroupLock).
std::filesystem::path division_file(const std::filesystem::path& folder);

}  // namespace psplit
