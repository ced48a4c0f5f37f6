#include "gltf_ext/document/drop_unused.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/byte_runs.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"

namespace psplit {
namespace {

using IndexSet = std::set<int64_t>;
using Flags = std::vector<bool>;

// Whether all references of an extension to accessors and buffer views are known here. Most have none.
bool is_understood(std::string_view name) {
  constexpr std::string_view kKnown[] = {"KHR_materials_*",
                                         "KHR_texture_*",
                                         "EXT_texture_*",
                                         "MSFT_texture_*",
                                         "MSFT_packing_*",
                                         "MSFT_lod",
                                         "EXT_materials_*",
                                         "ADOBE_materials_*",
                                         "KHR_lights_*",
                                         "EXT_lights_*",
                                         "KHR_mesh_quantization",
                                         "KHR_xmp*",
                                         "KHR_animation_pointer",
                                         "KHR_node_*",
                                         "KHR_techniques_webgl",
                                         "KHR_meshopt_compression",
                                         "EXT_meshopt_compression",
                                         "KHR_draco_mesh_compression",
                                         "PSPLIT_mesh_draco_patches",
                                         "EXT_mesh_gpu_instancing",
                                         "EXT_structural_metadata",
                                         "EXT_mesh_features",
                                         "EXT_instance_features",
                                         "CESIUM_RTC",
                                         "CESIUM_primitive_outline",
                                         "AGI_articulations",
                                         "AGI_stk_metadata",
                                         "FB_ngon_encoding",
                                         "VRM",
                                         "VRMC_*",
                                         "GODOT_single_root"};
  return std::any_of(std::begin(kKnown), std::end(kKnown), [&](std::string_view known) {
    if (!known.ends_with('*')) return name == known;
    known.remove_suffix(1);
    return name.starts_with(known);
  });
}

// Collects every integer of extensions that are not understood: it may be an index. Returns whether there is
// such an extension.
bool collect_suspects(const Json& tree, IndexSet& found) {
  if (!tree.is_structured()) return false;
  bool any = false;
  const bool is_object = tree.is_object();
  for (auto member = tree.begin(); member != tree.end(); ++member) {
    if (is_object && member.key() == "extras") continue;
    if (is_object && member.key() == "extensions" && member->is_object()) {
      for (auto extension = member->begin(); extension != member->end(); ++extension) {
        if (is_understood(extension.key())) {
          any |= collect_suspects(*extension, found);
        } else {
          any = true;
          collect_integers(*extension, found);
        }
      }
    } else {
      any |= collect_suspects(*member, found);
    }
  }
  return any;
}

void mark(Flags& flags, int64_t index) {
  if (index >= 0 && static_cast<uint64_t>(index) < flags.size()) flags[static_cast<size_t>(index)] = true;
}
void mark(Flags& flags, const Json& index) { mark(flags, integer_value(index).value_or(-1)); }

// Removes the elements that are not kept from json[name]; returns the new index of each kept one.
std::vector<int64_t> compact(Json& json, const char* name, const Flags& keep) {
  std::vector<int64_t> new_index(keep.size(), -1);
  Json* array = array_field(json, name);
  if (array == nullptr) return new_index;
  Json kept = Json::array();
  for (size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    new_index[i] = static_cast<int64_t>(kept.size());
    kept.push_back(std::move((*array)[i]));
  }
  *array = std::move(kept);
  if (array->empty()) json.erase(name);  // glTF forbids empty arrays
  return new_index;
}

void renumber(Json& index, const std::vector<int64_t>& new_index) {
  const auto old = integer_value(index);
  if (old && *old >= 0 && static_cast<uint64_t>(*old) < new_index.size())
    index = new_index[static_cast<size_t>(*old)];
}

// Visits all ranges of buffers: those of views, and those of the compressed bytes of views.
template <typename Visit>
void for_each_range(Json& json, Visit&& visit) {
  for_each_element(json, "bufferViews", [&](Json& view) {
    visit(view);
    if (Json* meshopt = meshopt_extension(view)) visit(*meshopt);
  });
}

// Moves the runs together in place; those of a mapped file are copied.
void keep_runs(Buffer& buffer, const ByteRuns& covered) {
  const bool is_mapped = buffer.is_mapped();
  const auto size = static_cast<size_t>(covered.packed_bytes());
  std::vector<uint8_t> copied(is_mapped ? size : 0);
  const std::span<const uint8_t> from = buffer;
  uint8_t* const to = is_mapped ? copied.data() : buffer.own().data();
  for (const ByteRuns::Run& run : covered.runs())
    std::memmove(to + run.packed, from.data() + run.begin, static_cast<size_t>(run.end - run.begin));
  if (is_mapped) buffer = std::move(copied);
  buffer.own().resize(size);
  buffer.own().shrink_to_fit();
}

// Closes the gaps that no view covers, and shortens the buffer.
void pack_buffer(Document& document, size_t buffer) {
  Buffer& packed = document.buffers[buffer];
  const std::span<const uint8_t> bytes = packed;
  if (bytes.empty()) return;
  const auto range_of = [&](const Json& view) {
    std::optional<BufferRange> range = range_in_memory(document, view);
    if (range && range->buffer != static_cast<int64_t>(buffer)) range.reset();
    return range;
  };
  ByteRuns covered(bytes.size());
  for_each_range(document.json(), [&](Json& range) {
    if (const auto found = range_of(range)) covered.keep(found->offset, found->offset + found->bytes);
  });
  covered.close();
  for_each_range(document.json(), [&](Json& range) {
    const auto found = range_of(range);
    if (!found || field(range, "byteOffset") == nullptr) return;
    range["byteOffset"] = found->bytes == 0 ? 0 : covered.packed(found->offset);
  });
  if (covered.packed_bytes() != bytes.size()) keep_runs(packed, covered);
  document.json()["buffers"][buffer]["byteLength"] = packed.size();
}

// Views that start at 0 may omit byteOffset. It is needed before bytes move, so that it can be changed.
void spell_out_offsets(Json& json) {
  for_each_range(json, [](Json& range) {
    if (field(range, "byteOffset") == nullptr) range["byteOffset"] = 0;
  });
}

}  // namespace

void collect_integers(const Json& tree, std::set<int64_t>& found) {
  if (const auto value = integer_value(tree)) found.insert(*value);
  if (tree.is_structured())
    for (const Json& member : tree) collect_integers(member, found);
}

std::set<int64_t> numbers_of_unknown_extensions(const Json& json) {
  std::set<int64_t> found;
  collect_suspects(json, found);
  return found;
}

void drop_unused(Document& document, const std::vector<int64_t>& freed_accessors) {
  Json& json = document.json();
  IndexSet suspects;
  const bool fixed_numbers = collect_suspects(json, suspects);

  Flags keep_accessor(array_size(json, "accessors"), true);
  for (const int64_t freed : freed_accessors)
    if (freed >= 0 && static_cast<uint64_t>(freed) < keep_accessor.size())
      keep_accessor[static_cast<size_t>(freed)] = suspects.contains(freed);
  for_each_accessor_reference(json, [&](const Json& index) { mark(keep_accessor, index); });
  // An accessor that must keep its index but not its data becomes a single zero.
  for (size_t i = 0; i < keep_accessor.size(); ++i)
    if (!keep_accessor[i] && fixed_numbers)
      json["accessors"][i] = {{"componentType", 5121}, {"count", 1}, {"type", "SCALAR"}};
  if (!fixed_numbers) {
    const auto new_index = compact(json, "accessors", keep_accessor);
    for_each_accessor_reference(json, [&](Json& index) { renumber(index, new_index); });
  }

  Flags keep_view(array_size(json, "bufferViews"), false);
  for (const int64_t suspect : suspects) mark(keep_view, suspect);
  for_each_buffer_view_reference(json, [&](const Json& index) { mark(keep_view, index); });
  for (size_t i = 0; i < keep_view.size(); ++i) {
    if (keep_view[i] || !fixed_numbers) continue;
    const auto buffer = integer_field(json["bufferViews"][i], "buffer").value_or(0);
    const auto length = integer_field(json["bufferViews"][i], "byteLength").value_or(0);
    json["bufferViews"][i] = {
        {"buffer", buffer}, {"byteOffset", 0}, {"byteLength", std::min<int64_t>(length, 1)}};
  }
  if (!fixed_numbers) {
    const auto new_index = compact(json, "bufferViews", keep_view);
    for_each_buffer_view_reference(json, [&](Json& index) { renumber(index, new_index); });
  }

  Flags keep_buffer(array_size(json, "buffers"), fixed_numbers);
  keep_buffer.resize(document.buffers.size(), fixed_numbers);
  for_each_range(json, [&](Json& range) { mark(keep_buffer, integer_field(range, "buffer").value_or(-1)); });
  const auto new_index = compact(json, "buffers", keep_buffer);
  std::vector<Buffer> kept;
  for (size_t i = 0; i < document.buffers.size(); ++i)
    if (keep_buffer[i]) kept.push_back(std::move(document.buffers[i]));
  document.buffers = std::move(kept);
  for_each_range(json, [&](Json& range) {
    if (Json* buffer = field(range, "buffer")) renumber(*buffer, new_index);
  });
  spell_out_offsets(json);
  for (size_t i = 0; i < document.buffers.size(); ++i)
    if (!fixed_numbers || !suspects.contains(static_cast<int64_t>(i))) pack_buffer(document, i);
}

}  // namespace psplit
