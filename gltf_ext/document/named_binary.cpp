#include "gltf_ext/document/named_binary.h"

#include <algorithm>
#include <string_view>

#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "system/content_hash.h"
#include "system/mapped_file.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr size_t kNameDigits = 16;

// The digits of a name that binary_path made, with the dot before them; empty for other names.
std::string digits_of(const fs::path& binary) {
  const std::string digits = binary.stem().extension().string();
  const bool is_ours = binary.extension() == ".bin" && digits.size() == 1 + kNameDigits &&
                       digits.find_first_not_of("0123456789abcdef", 1) == std::string::npos;
  return is_ours ? digits : "";
}

// Whether binary_path made the name for the .gltf, from the content that the file still has.
bool is_binary_of(const fs::path& binary, const fs::path& gltf) {
  const std::string digits = digits_of(binary);
  if (digits.empty() || binary.filename() != path_with_digits(gltf, digits.substr(1), ".bin").filename())
    return false;
  std::error_code error;
  if (fs::symlink_status(binary, error).type() != fs::file_type::regular) return false;
  const auto file = MappedFile::open(binary);
  if (!file) return false;
  const std::span<const uint8_t> parts[] = {file->bytes()};
  return digits == "." + content_digits(parts);
}

bool holds(const fs::path& path, std::span<const uint8_t> bytes) {
  std::error_code error;
  if (!is_disk_file(path) || fs::file_size(path, error) != bytes.size()) return false;
  const auto there = read_file(path);
  return there && std::equal(there->begin(), there->end(), bytes.begin(), bytes.end());
}

}  // namespace

std::string content_digits(FileParts parts) {
  ContentHash hash;
  for (const std::span<const uint8_t> part : parts)
    visit_and_release(part, [&hash](std::span<const uint8_t> step) {
      hash.add(step);
      return true;
    });
  return hash.hex().substr(0, kNameDigits);
}

fs::path path_with_digits(const fs::path& path, const std::string& digits, const std::string& extension) {
  constexpr size_t kMostNameBytes = 255;  // of common file systems
  const std::string tail = "." + digits + extension;
  std::string name = path.stem().string();
  size_t end = std::min(name.size(), kMostNameBytes - std::min(kMostNameBytes, tail.size()));
  const auto continues = [&](size_t at) { return (static_cast<unsigned char>(name[at]) & 0xc0) == 0x80; };
  while (end > 0 && end < name.size() && continues(end)) --end;  // UTF-8 stays whole
  name.resize(end);
  return path.parent_path() / (name + tail);
}

Expected<fs::path> write_beside(const fs::path& folder, std::span<const fs::path> names,
                                std::span<const uint8_t> bytes) {
  for (const fs::path& name : names) {
    if (holds(folder / name, bytes)) return name;
    const Expected<bool> written = write_new_file(folder / name, bytes);
    if (!written) return written.status();
    if (*written || holds(folder / name, bytes)) return name;
  }
  return fs::path();
}

fs::path binary_path(const fs::path& gltf, FileParts parts) {
  return path_with_digits(gltf, content_digits(parts), ".bin");
}

std::vector<fs::path> own_binaries(const fs::path& path) {
  std::vector<fs::path> binaries;
  if (!is_disk_file(path)) return binaries;
  const auto bytes = read_file(path);
  if (!bytes) return binaries;
  const auto json = parse_json({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!json) return binaries;
  for_each_element(*json, "buffers", [&](const Json& buffer) {
    const std::string* uri = string_field(buffer, "uri");
    if (uri == nullptr || is_data_uri(*uri)) return;
    const fs::path binary = path.parent_path() / path_of_uri(*uri, path.parent_path());
    if (binary.parent_path() == path.parent_path() && is_binary_of(binary, path)) binaries.push_back(binary);
  });
  return binaries;
}

bool is_used(const fs::path& binary) {
  const std::string digits = digits_of(binary);
  const fs::path folder = binary.parent_path().empty() ? "." : binary.parent_path();
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (lower_extension(entry->path()) != ".gltf") continue;
    const auto bytes = read_file(entry->path());
    if (!bytes || std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size()).find(digits) !=
                      std::string_view::npos)
      return true;
  }
  return static_cast<bool>(error);
}

}  // namespace psplit
