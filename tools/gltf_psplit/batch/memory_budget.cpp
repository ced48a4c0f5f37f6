#include "tools/gltf_psplit/batch/memory_budget.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <memory>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "gltf_ext/files/files.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/mesh_files/byte_stream.h"
#include "tools/gltf_psplit/report/asset_bytes.h"

namespace psplit {
namespace {

struct Counts {
  uint64_t points = 0, faces = 0;
  uint64_t values = 0;  // bytes of all attributes of all points, with 4 bytes for a number
};

uint64_t components(const std::string& type) {
  if (type == "SCALAR") return 1;
  return type.starts_with("VEC") && type.size() == 4 ? static_cast<uint64_t>(type[3] - '0') : 16;
}

// Each pair of positions and indices counts once, however many primitives share it.
Counts counts_of_gltf(const Json& json) {
  const auto accessor = [&](const Json& index) {
    const std::optional<int64_t> number = integer_value(index);
    return number ? top_level_object(json, "accessors", *number) : nullptr;
  };
  const auto count_of = [&](const Json* found) -> uint64_t {
    // A count may be wrong. This one is enough for any memory, and products of it do not overflow.
    constexpr int64_t kMost = int64_t{1} << 40;
    const std::optional<int64_t> count = found == nullptr ? std::nullopt : integer_field(*found, "count");
    return count && *count > 0 ? static_cast<uint64_t>(std::min(*count, kMost)) : 0;
  };
  Counts counts;
  std::set<std::pair<const Json*, const Json*>> seen;
  const auto add = [&](const Json& primitive) {
    const Json* const attributes = object_field(primitive, "attributes");
    const Json* const indices = field(primitive, "indices");
    const Json* const position = attributes == nullptr ? nullptr : field(*attributes, "POSITION");
    if (position == nullptr) return;
    const Json* const index_accessor = indices == nullptr ? nullptr : accessor(*indices);
    const uint64_t points = count_of(accessor(*position));
    if (!seen.emplace(accessor(*position), index_accessor).second) return;
    counts.points += points;
    counts.faces += (indices == nullptr ? points : count_of(index_accessor)) / 3;
    for (const Json& attribute : *attributes) {
      const Json* const found = accessor(attribute);
      const std::string* const type = found == nullptr ? nullptr : string_field(*found, "type");
      counts.values += points * 4 * (type == nullptr ? 4 : components(*type));
    }
  };
  if (const Json* meshes = array_field(json, "meshes"))
    for (const Json& mesh : *meshes)
      if (const Json* primitives = array_field(mesh, "primitives"))
        for (const Json& primitive : *primitives) add(primitive);
  return counts;
}

// The number after `words` in a header; 0 if there is none.
uint64_t number_after(std::string_view text, std::string_view words) {
  const size_t at = text.find(words);
  uint64_t number = 0;
  if (at != std::string_view::npos)
    std::from_chars(text.data() + at + words.size(), text.data() + text.size(), number);
  return number;
}

// A gzip file ends with the size of what it packs, modulo 2^32.
uint64_t unpacked_bytes(const std::string& path, uint64_t bytes) {
  std::ifstream file(path, std::ios::binary);
  unsigned char size[4] = {};
  if (bytes < 4 || !file.seekg(static_cast<std::streamoff>(bytes - 4)) ||
      !file.read(reinterpret_cast<char*>(size), 4))
    return bytes;
  uint64_t low = 0;
  for (size_t i = 4; i-- > 0;) low = low << 8 | size[i];
  return std::max(low, bytes);
}

bool is_stl_name(const std::filesystem::path& path) {
  return lower_extension(lower_extension(path) == ".gz" ? path.stem() : path) == ".stl";
}

// Of a mesh file. The header of a PLY has the counts. In other formats a face takes at least so many bytes.
Counts counts_of_mesh_file(const std::string& path, uint64_t file_bytes) {
  constexpr size_t kHead = 4096;
  constexpr uint64_t kBinaryStlFace = 50, kTextStlFace = 100, kTextFace = 16, kPosition = 12, kPointOfText = 32;
  std::vector<uint8_t> head(kHead);
  const Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(path);
  if (!stream) return {};
  head.resize((*stream)->read(head));
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (text.starts_with("ply")) {
    constexpr uint64_t kMost = uint64_t{1} << 40;
    Counts counts{std::min(number_after(text, "element vertex "), kMost),
                  std::min(number_after(text, "element face "), kMost), 0};
    uint64_t properties = 0;
    for (size_t at = text.find("element vertex "), end = text.find("element face "); at < end;
         at = text.find("property ", at + 1))
      ++properties;
    counts.values = counts.points * 4 * std::max<uint64_t>(properties, 3);
    return counts;
  }
  if (text.starts_with("DRACO")) return {file_bytes, 2 * file_bytes, 2 * kPosition * file_bytes};
  const uint64_t bytes = lower_extension(path) == ".gz" ? unpacked_bytes(path, file_bytes) : file_bytes;
  const bool is_stl = is_stl_name(path);
  const uint64_t face_bytes = !is_stl ? kTextFace : text.starts_with("solid") ? kTextStlFace : kBinaryStlFace;
  const uint64_t faces = bytes / face_bytes;
  return is_stl ? Counts{3 * faces, faces, 3 * faces * kPosition} : Counts{faces, faces, faces * kPointOfText};
}

}  // namespace

// The factors were fitted to the peaks of 100,000 to 2 million faces with 12 to 48 bytes of attributes, on two
// threads; then a fifth was added.
uint64_t estimate_memory(const std::string& path, BatchVerb verb) {
  struct Factors {
    uint64_t file, face, value;  // for each byte of the files, each face, each byte of attributes
  };
  const Factors factors = verb == BatchVerb::kEncode     ? Factors{2, 100, 5}
                          : verb == BatchVerb::kDecode   ? Factors{2, 45, 7}
                          : verb == BatchVerb::kValidate ? Factors{2, 20, 6}
                                                         : Factors{2, 65, 7};
  const uint64_t bytes = bytes_on_disk(path).files;
  const Expected<Json> json = read_asset_json(path);
  const Counts counts = json ? counts_of_gltf(*json) : counts_of_mesh_file(path, bytes);
  constexpr uint64_t kLeast = uint64_t{1} << 20;
  return kLeast + (factors.file * bytes + factors.face * counts.faces + factors.value * counts.values) / 5 * 6;
}

MemoryBudget::Share MemoryBudget::take(uint64_t bytes, const std::function<void()>& wait) {
  if (limit_ != 0) bytes = std::min(bytes, limit_);  // it runs alone
  std::unique_lock lock(mutex_);
  const uint64_t ticket = next_ticket_++;
  const auto fits = [&] { return ticket == turn_ && (limit_ == 0 || taken_ + bytes <= limit_); };
  if (!fits()) {
    wait();
    changed_.wait(lock, fits);
  }
  ++turn_;
  taken_ += bytes;
  changed_.notify_all();
  return Share(*this, bytes);
}

void MemoryBudget::give_back(uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  taken_ -= bytes;
  changed_.notify_all();
}

}  // namespace psplit
