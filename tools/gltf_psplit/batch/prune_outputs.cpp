// Finds, and removes, the outputs of a batch whose inputs are gone.
#include <set>

#include "gltf_ext/document/named_binary.h"
#include "gltf_ext/json/json_fields.h"
#include "mesh_files/asset_format.h"
#include "system/io_error.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/batch/batch_record.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The folder that the name of an output is relative to: "/in" for "/in/x/a.ply" and "x/a.glb".
std::optional<std::string> base_of(const BatchItem& item) {
  const std::string input =
      without_asset_extensions(fs::absolute(item.input).lexically_normal()).generic_string();
  const std::string end = "/" + without_asset_extensions(item.name).generic_string();
  if (!input.ends_with(end)) return std::nullopt;
  return input.substr(0, input.size() - end.size());
}

// Whether the file is what the batch wrote, byte for byte.
bool is_unchanged(const fs::path& file, const Json& line) {
  const Expected<OutputFiles> found = hash_output(file);
  const std::string* output = string_field(line, "output");
  return found && output != nullptr && found->hash == *output;
}

Status remove_output(const fs::path& file, const std::string& name, BatchRecord& record) {
  const std::vector<fs::path> binaries =
      lower_extension(file) == ".gltf" ? own_binaries(file) : std::vector<fs::path>();
  std::error_code error;
  if (!fs::remove(file, error)) return io_error("cannot remove", error, {.file = file.string()});
  for (const fs::path& binary : binaries)
    if (!is_used(binary)) fs::remove(binary, error);
  return record.forget(record_name(name));
}

}  // namespace

Status prune_outputs(const BatchArguments& arguments, const Session& session) {
  const fs::path& folder = arguments.request.folder;
  const Expected<std::vector<BatchItem>> planned = plan_batch(arguments.request);
  if (!planned) return planned.status();
  std::error_code error;
  if (!fs::is_directory(record_folder(folder), error))
    return io_failure("no batch has run in " + folder.string());
  BatchRecord record;
  if (Status status = record.open(folder, {}); !status.ok()) return status;
  if (Status status = record.load(folder, {}); !status.ok()) return status;

  std::set<std::string> names;
  std::optional<std::string> base;
  for (const BatchItem& item : *planned) {
    names.insert(item.name);
    if (!base) base = base_of(item);
  }
  const bool removes = arguments.force && !arguments.dry_run;
  uint64_t count = 0;
  Status failure;
  Status status = record.for_each_written([&](const Json& line) {
    const std::string *name = string_field(line, "name"), *input = string_field(line, "input");
    if (name == nullptr || input == nullptr || !failure.ok()) return;
    const Expected<BatchItem> item = item_of({{"input_uri", *input}, {"name_uri", *name}});
    if (!item || names.contains(item->name) || !base || base_of(*item) != base) return;
    const fs::path file = folder / item->name;
    if (fs::symlink_status(item->input, error).type() != fs::file_type::not_found) return;
    if (!fs::is_regular_file(fs::symlink_status(file, error))) return;
    if (!is_unchanged(file, line)) {
      session.log.warning(file.string() + " stays: its input is gone, but it has changed since batch made it");
      return;
    }
    failure = write_text("-", file.string() + "\n");
    if (failure.ok() && removes) failure = remove_output(file, item->name, record);
    ++count;
  });
  if (!status.ok() || !failure.ok()) return status.ok() ? failure : status;
  session.log.note(arguments.folder + ": " + counted(count, "output") + " whose inputs are gone" +
                   (count == 0 ? ""
                    : removes  ? ", removed"
                               : "; --force removes them"));
  return {};
}

}  // namespace psplit
