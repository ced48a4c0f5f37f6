#include "gltf_ext/out_of_core/temporary_space.h"

#include "system/io_error.h"

namespace psplit {
namespace {

constexpr uint64_t kMegabyte = 1000000;

std::string as_size(uint64_t megabytes) {
  if (megabytes < 10000) return std::to_string(megabytes) + " MB";
  return std::to_string(megabytes / 1000) + "." + std::to_string(megabytes / 100 % 10) + " GB";
}

uint64_t bytes_of_parts(const ExpectedSizes& sizes) {
  constexpr uint64_t kFace = 12, kNumber = 4;
  return sizes.points * (sizes.record_bytes + kNumber) + sizes.faces * kFace;
}

// And a twentieth for the points at borders.
uint64_t with_borders(uint64_t bytes) { return bytes / 20 * 21; }

// The most bytes of temporary files at one time, except for points that many parts share.
// While the spool is distributed, there are the spool and the cells' files. Then the spool goes and the parts
// come, which take no more than it. The container takes less than the cells' files, which went before.
uint64_t temporary_bytes(const ExpectedSizes& sizes) {
  constexpr uint64_t kFace = 12;
  const uint64_t spool = sizes.points * sizes.record_bytes + (sizes.is_soup ? 0 : sizes.faces * kFace);
  return with_borders(spool + bytes_of_parts(sizes));
}

}  // namespace

Status check_temporary_space(const ExpectedSizes& sizes, const std::filesystem::path& folder,
                             const std::function<void(const std::string&)>& note, bool is_certain) {
  const std::filesystem::path place = folder.empty() ? "." : folder;
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(place, error);
  const uint64_t needed = temporary_bytes(sizes);
  const std::string text =
      "may take " + as_size(needed / kMegabyte + 1) + " of temporary space in " + place.string();
  if (error) {
    if (note) note(text);
    return {};
  }
  const std::string free = as_size(space.available / kMegabyte) + " are free";
  if (space.available < needed && is_certain) return may_pass(text + ", where " + free);
  if (note) note(text + " (" + free + ")" + (is_certain ? "" : ", according to the header"));
  return {};
}

Status check_space_of_parts(const ExpectedSizes& sizes, const std::filesystem::path& folder) {
  const std::filesystem::path place = folder.empty() ? "." : folder;
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(place, error);
  const uint64_t needed = with_borders(bytes_of_parts(sizes));
  if (error || space.available >= needed) return {};
  return may_pass("takes " + as_size(needed / kMegabyte + 1) + " more of temporary space in " + place.string() +
                  ", where " + as_size(space.available / kMegabyte) + " are free");
}

}  // namespace psplit
