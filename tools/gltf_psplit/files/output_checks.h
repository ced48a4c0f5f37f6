// Whether an output may be written, checked before the work whose result it will hold.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "gltf_ext/document/document.h"
#include "mesh_files/asset_format.h"
#include "psplit/base.h"
#include "psplit/document.h"
#include "tools/gltf_psplit/options/file_options.h"

namespace psplit {

// kIo if `path` is a folder or, unless `force` is true, a read-only file, or if its folder is missing or not
// writable. "-", devices and pipes pass.
Status check_output_place(const std::string& path, bool force);

// kMayPass if the output's disk is known to have fewer than `bytes` free.
Status check_free_space(const std::string& output, uint64_t bytes);

// Like check_output_place, and kUsage if write_document does not support the name: it must end in .glb or
// .gltf, or be "-". The message lists those and `others`, endings that the caller supports and has excluded.
Status check_output_path(const std::string& path, bool force, const std::string& others = "");

// Checks the outputs of a command that writes an asset and, if `report` is not empty, a report. kUsage if both
// have the same name.
Status check_output_paths(const std::string& output, const std::string& report, bool force,
                          OutputForms forms = OutputForms::kGltf);

// The format of an output that is a mesh file, according to its name.
std::optional<AssetFormat> mesh_format_of_output(const std::string& path);

// What --dry-run says of a file: " would be written", or " would be replaced" if it exists.
std::string would_be_written(const std::filesystem::path& path);

// Whether the output is a GLB, according to its name. stdout is one.
bool is_glb_output(const std::string& path);

// kUsage if writing `path`, which `option` named, would replace a file that the document was read from or
// refers to (its images, and the files of its extensions), also through links.
Status check_not_an_input(const std::string& path, const std::string& option, const Document& document);
// As above, for inputs that are not read yet, according to their names alone.
Status check_not_an_input(const std::string& path, const std::string& option,
                          std::span<const std::string> inputs);
// As above, for the output itself, which replaces its input only if `force` is true. The input need not be
// read.
Status check_not_in_place(const std::string& output, const std::string& input, const Document* document,
                          bool force);
// As above, for the files of an output.
Status check_not_an_output(const std::string& path, const std::string& option, const WriteReport& written);

}  // namespace psplit
