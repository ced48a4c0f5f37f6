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

// The relative path that a URI names. kInvalidInput where it leaves the folder it starts from, kUnsupported
// where it has a scheme.
Expected<std::filesystem::path> relative_path_of_uri(std::string_view uri);

}  // namespace psplit
