#include "tools/gltf_psplit/files/output_checks.h"

#include <filesystem>

#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/json/json.h"
#include "system/files.h"
#include "system/io_error.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// Paths that lead to no file yet are compared by their text: "new/../a.glb" is a.glb once there is the folder.
bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  const bool both_exist = fs::exists(a, error) && fs::exists(b, error);
  return !both_exist && whole_name(a) == whole_name(b);
}

}  // namespace

Status check_output_place(const std::string& path, bool force) {
  if (path == "-") return {};
  std::error_code error;
  const fs::file_type type = file_type_at(path);
  if (type == fs::file_type::character || type == fs::file_type::fifo) return {};
  const Place place{.file = path};
  if (type == fs::file_type::directory) return io_failure("is a folder; name a file in it", place);
  if (!force && is_read_only(path)) return io_failure("is read-only; --force replaces it", place);
  // A file is written beside its place and then renamed. So its folder must be writable; for a link, the folder
  // of its target.
  const Expected<fs::path> target = follow_links(path);
  if (!target) return target.status();
  const fs::path folder = target->parent_path().empty() ? fs::path(".") : target->parent_path();
  const fs::file_type folder_type = fs::status(folder, error).type();
  if (folder_type == fs::file_type::not_found)
    return io_failure("there is no folder " + folder.string() + length_hint(folder), place);
  if (folder_type != fs::file_type::directory) return io_failure(folder.string() + " is not a folder", place);
  if (!may_write_into(folder))
    return io_failure("no permission to write into the folder " + folder.string(), place);
  return {};
}

Status check_free_space(const std::string& output, uint64_t bytes) {
  if (output == "-") return {};
  const Expected<fs::path> target = follow_links(output);
  if (!target) return target.status();
  std::error_code error;
  const fs::space_info space =
      fs::space(target->parent_path().empty() ? fs::path(".") : target->parent_path(), error);
  const fs::file_type type = file_type_at(*target);
  const bool is_file = type == fs::file_type::regular || type == fs::file_type::not_found;
  // A file system that knows no sizes has a capacity of 0 or of all bits.
  if (!is_file || space.capacity + 1 <= 1 || space.available >= bytes) return {};
  return may_pass(
      "takes at least " + as_bytes(bytes) + ", but its disk has " + as_bytes(space.available) + " free",
      {.file = output});
}

Status check_output_path(const std::string& path, bool force, const std::string& others) {
  const std::string extension = lower_extension(path);
  if (path != "-" && extension != ".glb" && extension != ".gltf")
    return wrong_usage("the output must end in .glb" + (others.empty() ? "" : ", " + others) +
                           " or .gltf, or be - for a GLB on stdout",
                       {.file = path});
  return check_output_place(path, force);
}

std::string would_be_written(const fs::path& path) {
  return is_disk_file(path) ? " would be replaced" : " would be written";
}

std::optional<AssetFormat> mesh_format_of_output(const std::string& path) {
  const std::string extension = lower_extension(path);
  for (const auto& [name, format] : {std::pair{".obj", AssetFormat::kObj},
                                     {".ply", AssetFormat::kPly},
                                     {".stl", AssetFormat::kStl},
                                     {".drc", AssetFormat::kDraco}})
    if (extension == name) return format;
  return std::nullopt;
}

bool is_glb_output(const std::string& path) { return path == "-" || lower_extension(path) == ".glb"; }

Status check_output_paths(const std::string& output, const std::string& report, bool force, OutputForms forms) {
  const bool mesh_files = forms == OutputForms::kGltfAndMeshFiles;
  Status status = mesh_files && mesh_format_of_output(output)
                      ? check_output_place(output, force)
                      : check_output_path(output, force, mesh_files ? ".obj, .ply, .stl, .drc" : "");
  if (!status.ok()) return status;
  if (report == output) return wrong_usage("--report and the output name the same file: " + output);
  return report.empty() ? Status() : check_output_place(report, force);
}

Status check_not_an_input(const std::string& path, const std::string& option, const Document& document) {
  if (path.empty() || path == "-") return {};
  const auto refuse = [&](const fs::path& file) {
    return wrong_usage(option + " would replace " + file.string() + ", a file of an asset");
  };
  for (const fs::path& file : document.files)
    if (is_same_file(path, file)) return refuse(file);
  for (const LinkedFile& link : linked_files(document))
    if (link.state == LinkState::kFound && is_same_file(path, link.path)) return refuse(link.path);
  return {};
}

Status check_not_an_input(const std::string& path, const std::string& option,
                          std::span<const std::string> inputs) {
  Document named;
  named.json() = Json::object();
  for (const std::string& input : inputs)
    if (input != "-") named.files.emplace_back(input);
  return check_not_an_input(path, option, named);
}

Status check_not_in_place(const std::string& output, const std::string& input, const Document* document,
                          bool force) {
  if (force) return {};
  const std::string inputs[] = {input};
  const Status status = document == nullptr ? check_not_an_input(output, "the output", inputs)
                                            : check_not_an_input(output, "the output", *document);
  return status.ok() ? status : Status(status.code(), status.message() + "; --force replaces it");
}

Status check_not_an_output(const std::string& path, const std::string& option, const WriteReport& written) {
  if (path.empty() || path == "-") return {};
  for (const fs::path& file : written.files)
    if (file != "-" && is_same_file(path, file))
      return wrong_usage(option + " and the output cannot share " + file.string());
  return {};
}

}  // namespace psplit
