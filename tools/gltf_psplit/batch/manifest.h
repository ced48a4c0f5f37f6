// The plan of a batch in a file: a line of JSON for each asset. `batch plan` writes it, and every shard reads
// it line by line, so that its length takes no memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gltf_ext/json/json.h"
#include "psplit/base.h"
#include "system/files.h"
#include "system/text_lines.h"

namespace psplit {

struct BatchItem {
  std::string input{};              // a path; with --fetch any text that the command understands
  std::string name{};               // the output relative to the output folder: "x/y.glb"
  std::optional<uint64_t> bytes{};  // of the input file
  std::string xxh128{};             // the hash of the input file: 32 hexadecimal digits, or empty if unknown
  std::string version{};  // a text that changes whenever the input does, such as an ETag; empty if unknown
};

// {"input", "name", "bytes", "xxh128", "version"} without unknown members. A text that is not UTF-8 is written
// percent-encoded, as "input_uri" or "name_uri".
Json to_json(const BatchItem& item);
// kInvalidInput if a member has the wrong type, if "input" or "name" is missing, or if the name is not a path
// below the output folder.
Expected<BatchItem> item_of(const Json& json);

// "<32 hexadecimal digits>" of a file's bytes. Errors: as for read_file.
Expected<std::string> hash_file(const std::filesystem::path& path);

// The first line of a plan: {"gltf_psplit_plan": 1, "version", "options", "count"}. A manifest from elsewhere
// may lack it.
struct ManifestHead {
  std::string version;               // of the gltf-psplit that planned
  std::vector<std::string> options;  // the words of the command line that every shard has to use
  uint64_t count = 0;                // of assets
};

// Appears whole or not at all; "-" is stdout. Errors: as for io_error.
Status write_manifest(const std::filesystem::path& path, const ManifestHead& head,
                      std::span<const BatchItem> items, IfReadOnly if_read_only = IfReadOnly::kFail);

// A line of a manifest: an asset, or the reason why the line is not one (kInvalidInput, with its number).
struct ManifestLine {
  std::string text;
  uint64_t number = 0;
  Expected<BatchItem> item;
};

class Manifest {
 public:
  // Errors: as for io_error; kInvalidInput for a first line that is neither an asset nor a head that is
  // understood.
  static Expected<Manifest> open(const std::filesystem::path& path);

  const std::optional<ManifestHead>& head() const { return head_; }
  // The next line that is not empty; nothing at the end. Errors: as for io_error; kInvalidInput at the end of
  // a plan that has fewer or more lines than its head says.
  Expected<std::optional<ManifestLine>> next();

 private:
  explicit Manifest(TextLines lines, std::string name) : lines_(std::move(lines)), name_(std::move(name)) {}
  Status invalid(const std::string& why) const;

  TextLines lines_;
  std::string name_;
  std::optional<ManifestHead> head_;
  std::optional<std::string> first_;  // the first line, if it is no head
  uint64_t count_ = 0;
};

}  // namespace psplit
