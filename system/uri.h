// URIs of buffers and images: data URIs, and files in the asset's folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "psplit/base.h"

namespace psplit {

bool is_data_uri(std::string_view uri);

// The bytes of a data URI, base64 or percent-encoded. Base64 may have spaces and ends of lines, may lack its
// padding, and may be of the alphabet for URLs.
Expected<std::vector<uint8_t>> decode_data_uri(std::string_view uri);

// Escapes like "%20" become bytes; a percent sign that does not start an escape stays.
std::string percent_decode(std::string_view text);
std::string percent_encode(std::string_view text);

// A path as a URI: its parts are percent-encoded, with slashes between them.
std::string uri_of_path(const std::filesystem::path& path);

// The target of a URI that is not a data URI.
enum class UriKind {
  kRelative,  // a path that starts from the asset's folder
  kAbsolute,  // a path of one machine: /x, file:, a drive letter
  kWeb,       // http: and https:
  kUnknown,   // another scheme, or empty
};
UriKind kind_of_uri(std::string_view uri);

// The path of a relative URI, from `folder`. It may leave the folder. A backslash stands between folders, as
// exporters on Windows write it. If there is no file of that name, the one of another reading is taken: "%5C"
// as a slash, the text as it is ("a%20b.bin" is a name, too), or without its query and fragment.
std::filesystem::path path_of_uri(std::string_view uri, const std::filesystem::path& folder);
// Whether a reader that knows only the plain reading finds `path` by the URI.
bool is_plain_uri_of(std::string_view uri, const std::filesystem::path& path);
bool leaves_folder(const std::filesystem::path& relative);

// The path of a URI whose file must be in the folder. Errors: kUnsupported if it leaves the folder, or if the
// URI is no relative path; kInvalidInput if it names no file.
Expected<std::filesystem::path> relative_path_of_uri(std::string_view uri, const std::filesystem::path& folder);

}  // namespace psplit
