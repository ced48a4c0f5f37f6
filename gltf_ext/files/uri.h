// URIs of buffers and images: data URIs, and files under the asset's folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "src/status.h"

namespace psplit {

bool is_data_uri(std::string_view uri);

// The bytes of a data URI, base64 or percent-encoded.
Expected<std::vector<uint8_t>> decode_data_uri(std::string_view uri);

// "%20" and its like as bytes; a percent sign that starts no escape stays.
std::string percent_decode(std::string_view text);
std::string percent_encode(std::string_view text);

// A path as a URI: every part of it percent-encoded, slashes between them.
std::string uri_of_path(const std::filesystem::path& path);

// What a URI that is not data leads to.
enum class UriKind {
  kRelative,  // a path that starts from the asset's folder
  kAbsolute,  // a path of one machine: /x, file:, a drive's letter
  kWeb,       // http: and https:
  kUnknown,   // any other scheme, or no name at all
};
UriKind kind_of_uri(std::string_view uri);

// The path that a relative URI names, which may leave the folder it starts from.
std::filesystem::path path_of_uri(std::string_view uri);
bool leaves_folder(const std::filesystem::path& relative);

// The same of a file that must be in the folder. kInvalidInput where it leaves the folder, kUnsupported where
// it has a scheme.
Expected<std::filesystem::path> relative_path_of_uri(std::string_view uri);

}  // namespace psplit
