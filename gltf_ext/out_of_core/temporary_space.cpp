#include "gltf_ext/out_of_core/temporary_space.h"

#include "gltf_ext/files/io_error.h"

namespace psplit {
namespace {

constexpr uint64_t kMegabyte = 1000000;

std::string as_size(uint64_t megabytes) {
  if (megabytes < 10000) return std::to_string(megabytes) + " MB";
  return std::to_string(megabytes / 1000) + "." + std::to_string(megabytes / 100 % 10) + " GB";
}

}  // namespace

// While the spool is distributed, there are the spool and the cells' files. Then the spool goes and the parts
// come, which take no more than it. The container takes less than the cells' files, which went before.
uint64_t temporary_bytes(const ExpectedSizes& sizes) {
  constexpr uint64_t kFace = 12, kNumber = 4;
  const uint64_t spool = sizes.points * sizes.record_bytes + (sizes.is_soup ? 0 : sizes.faces * kFace);
  const uint64_t cells = sizes.points * (sizes.record_bytes + kNumber) + sizes.faces * kFace;
  return (spool + cells) / 20 * 21;  // and a twentieth for the points at borders
}

Status check_temporary_space(const ExpectedSizes& sizes, const std::filesystem::path& folder,
                             const std::function<void(const std::string&)>& note) {
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
  if (space.available < needed)
    return may_pass(text + ", where " + as_size(space.available / kMegabyte) + " are free");
  if (note) note(text + " (" + as_size(space.available / kMegabyte) + " are free)");
  return {};
}

}  // namespace psplit
