// One asset of a batch.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "gltf_ext/json/json.h"
#include "src/status.h"

namespace psplit {

struct BatchItem {
  std::string input{};              // a path; with --fetch any text that the command understands
  std::string name{};               // the output relative to the output folder: "x/y.glb"
  std::optional<uint64_t> bytes{};  // of the input file
  std::string xxh128{};             // the hash of the input file: 32 hexadecimal digits, or empty if unknown
  std::string version{};  // a text that changes whenever the input does, such as an ETag; empty if unknown
};

// {"input", "name", "bytes", "xxh128", "version"} without what is unknown. A text that is not UTF-8 is written
// percent-encoded, as "input_uri" or "name_uri".
Json to_json(const BatchItem& item);
// kInvalidInput if a member has the wrong type, if "input" or "name" is missing, or if the name is not a path
// below the output folder.
Expected<BatchItem> item_of(const Json& json);

// "<32 hexadecimal digits>" of a file's bytes. Errors: those of read_file.
Expected<std::string> hash_file(const std::filesystem::path& path);

}  // namespace psplit
