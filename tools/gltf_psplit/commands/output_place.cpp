#include "tools/gltf_psplit/commands/output_place.h"

#include <filesystem>

#include "gltf_ext/files/files.h"
#include "gltf_ext/files/operating_system.h"

namespace psplit {

namespace fs = std::filesystem;

Status check_output_place(const std::string& path) {
  if (path == "-") return {};
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  if (type == fs::file_type::character || type == fs::file_type::fifo) return {};
  const Place place{.file = path};
  if (type == fs::file_type::directory) return io_failure("is a folder; name a file in it", place);
  // Files are written beside and renamed: what must be writable is the folder, of the target where it is a
  // link.
  fs::path target = path;
  if (fs::is_symlink(target, error)) {
    target = fs::weakly_canonical(target, error);
    if (error) return io_failure("a link that leads nowhere", place);
  }
  const fs::path folder = target.parent_path().empty() ? fs::path(".") : target.parent_path();
  const fs::file_type folder_type = fs::status(folder, error).type();
  if (folder_type == fs::file_type::not_found)
    return io_failure("there is no folder " + folder.string(), place);
  if (folder_type != fs::file_type::directory) return io_failure(folder.string() + " is no folder", place);
  if (!may_write_into(folder))
    return io_failure("no permission to write into the folder " + folder.string(), place);
  return {};
}

Status check_output_path(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (path != "-" && extension != ".glb" && extension != ".gltf")
    return {StatusCode::kUsage,
            "the output must end in .glb or .gltf, or be - for a GLB on stdout",
            {.file = path}};
  return check_output_place(path);
}

}  // namespace psplit
