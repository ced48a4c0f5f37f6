#include <algorithm>

#include "gltf_ext/document/named_binary.h"
#include "gltf_ext/document/pack_buffers.h"
#include "gltf_ext/document/place_images.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_text.h"
#include "psplit/document.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

Status write_glb(const PackedDocument& packed, const fs::path& path, IfReadOnly if_read_only,
                 WriteReport& report) {
  const auto head = glb_head(json_line(packed.json), packed.bytes.size());
  if (!head) return head.status();
  std::vector<std::span<const uint8_t>> parts{*head};
  parts.insert(parts.end(), packed.bytes.parts().begin(), packed.bytes.parts().end());
  report.files.push_back(path);
  return write_file(path, FileParts(parts), if_read_only);
}

// Writes the binaries first, under new names: an older .gltf at `path` stays whole until it is replaced.
Status write_gltf(const Document& document, PackedDocument& packed, const fs::path& path,
                  IfReadOnly if_read_only, WriteReport& report) {
  std::error_code error;
  // Files that were read stay: a user who names the input as the output does not want to lose files.
  const bool is_input = std::any_of(document.files.begin(), document.files.end(),
                                    [&](const fs::path& file) { return fs::equivalent(file, path, error); });
  const std::vector<fs::path> before = is_input ? std::vector<fs::path>() : own_binaries(path);
  size_t number = 0;
  for (const PackedBuffer* buffer : {&packed.bytes, &packed.fallback}) {
    if (buffer->size() == 0) continue;
    const fs::path binary = binary_path(path, buffer->parts());
    packed.json["buffers"][number++]["uri"] = percent_encode(binary.filename().string());
    report.files.push_back(binary);
    if (Status status = write_file(binary, FileParts(buffer->parts()), if_read_only); !status.ok())
      return status;
  }
  // For people in lines, unless that makes the text larger than it was.
  std::string text = json_lines(packed.json);
  const uint64_t most = document.text_bytes > 0 ? document.text_bytes : UINT64_MAX;
  if (text.size() > most) text = json_line(packed.json);
  if (text.size() < most) text += "\n";
  report.files.push_back(path);
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(text.data()), text.size());
  if (Status status = write_file(path, {bytes}, if_read_only); !status.ok()) return status;
  for (const fs::path& binary : before)
    if (!is_used(binary) && !is_read_only(binary)) fs::remove(binary, error);
  return {};
}

}  // namespace

uint64_t glb_bytes(const Document& document) {
  PackedDocument packed = pack_buffers(document, /*fallback_apart=*/false);
  list_buffers(packed);
  const std::string text = json_line(packed.json);
  const auto head = glb_head(text, packed.bytes.size());
  return head ? head->size() + packed.bytes.size() : UINT64_MAX;
}

Status write_document(const Document& document, const fs::path& path, const WriteOptions& options,
                      WriteReport* report) {
  const bool to_stdout = path == "-";
  const Expected<fs::path> target = follow_links(path);
  if (!target) return target.status();
  // The other files of the output are beside the target of a link.
  if (*target != path) return write_document(document, *target, options, report);
  const bool glb = to_stdout || lower_extension(path) == ".glb";
  const Place place{.file = to_stdout ? "stdout" : path.string()};
  if (!glb && lower_extension(path) != ".gltf")
    return Status(StatusCode::kUsage, "the name of an output must end in .glb or .gltf", place);

  WriteReport unheard;
  if (report == nullptr) report = &unheard;
  *report = {};
  PackedDocument packed = pack_buffers(document, /*fallback_apart=*/!glb);
  report->warnings = packed.warnings;
  const ImagePlacement images = options.images.value_or(glb ? ImagePlacement::kEmbed : ImagePlacement::kCopy);
  if (to_stdout && images == ImagePlacement::kCopy)
    return Status(StatusCode::kUsage, "stdout has no folder to copy images to", place);
  if (Status status = place_images(document, path, images, packed, *report); !status.ok())
    return std::move(status).at(place);
  list_buffers(packed);
  const IfReadOnly if_read_only = options.replace_read_only ? IfReadOnly::kReplace : IfReadOnly::kFail;
  return (glb ? write_glb(packed, path, if_read_only, *report)
              : write_gltf(document, packed, path, if_read_only, *report))
      .at(place);
}

}  // namespace psplit
