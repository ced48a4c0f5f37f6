#include "gltf_ext/document/store_meshopt.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {

size_t meshopt_fallback(Document& document, const std::string& extension) {
  for (size_t i = 0; i < document.buffers.size(); ++i) {
    const Json& buffer = std::as_const(document).json()["buffers"][i];
    if (is_meshopt_fallback(buffer) && name_of_meshopt(buffer) == extension && !document.buffers[i].empty())
      return i;
  }
  Json& buffers = document.json()["buffers"];
  if (!buffers.is_array()) buffers = Json::array();
  const size_t index = append_buffer(document, {});
  document.json()["buffers"][index]["extensions"][extension] = {{"fallback", true}};
  return index;
}

void store_meshopt_rows(Document& document, size_t view, const MeshoptRecord& record,
                        std::span<const uint8_t> compressed, std::span<const uint8_t> decoded) {
  const auto stored = static_cast<size_t>(append_buffer_view(document, compressed));
  Json& json = document.json();
  const Json placed = std::move(json["bufferViews"][stored]);
  json["bufferViews"].erase(stored);
  Json& target = json["bufferViews"][view];
  const auto buffer = static_cast<size_t>(*integer_field(target, "buffer"));
  std::vector<uint8_t>& rows = document.buffers[buffer].own();
  rows.resize((rows.size() + 7) / 8 * 8);
  target["byteOffset"] = rows.size();
  target["byteLength"] = decoded.size();
  rows.insert(rows.end(), decoded.begin(), decoded.end());
  json["buffers"][buffer]["byteLength"] = rows.size();
  Json& meshopt = *meshopt_extension(target);
  meshopt.update(placed);  // buffer, byteOffset, byteLength
  meshopt["byteStride"] = record.stride;
  meshopt["count"] = record.count;
  meshopt["mode"] = record.mode;
  if (record.filter != "NONE" || field(meshopt, "filter") != nullptr) meshopt["filter"] = record.filter;
}

void make_meshopt_khr(Document& document) {
  const char* const kExt = kMeshoptExtensions[0];
  const char* const kKhr = kMeshoptExtensions[1];
  const std::vector<ViewRecord> views = document.records().views;
  std::vector<std::pair<size_t, std::vector<uint8_t>>> renamed;  // with smaller bytes, or none
  for (size_t i = 0; i < views.size(); ++i) {
    if (!views[i].meshopt || views[i].meshopt->is_khr) continue;
    MeshoptRecord record = *views[i].meshopt;
    const auto& [buffer, offset, length] = record.range;
    const std::span<const uint8_t> all = document.buffers[static_cast<size_t>(buffer)];
    if (offset > all.size() || length > all.size() - offset) return;
    const std::span<const uint8_t> bytes =
        all.subspan(static_cast<size_t>(offset), static_cast<size_t>(length));
    std::vector<uint8_t> rows(record.decoded_bytes());
    if (!is_readable_meshopt(record, bytes) || !is_legal_meshopt(record) ||
        !decode_meshopt_rows(record, bytes, rows.data()))
      return;
    record.is_khr = true;
    renamed.emplace_back(
        i, record.mode == "ATTRIBUTES" ? encode_meshopt_rows(record, rows) : std::vector<uint8_t>());
    if (renamed.back().second.size() >= length) renamed.back().second.clear();
  }
  if (renamed.empty()) return;
  const auto rename = [&](Json& object) {
    Json& extensions = object["extensions"];
    Json extension = std::move(extensions[kExt]);
    extensions.erase(kExt);
    extensions[kKhr] = std::move(extension);
  };
  for (const auto& [view, bytes] : renamed) {
    rename(document.json()["bufferViews"][view]);
    if (bytes.empty()) continue;
    Json& list = document.json()["bufferViews"];
    const auto stored = static_cast<size_t>(append_buffer_view(document, bytes));
    const Json placed = std::move(list[stored]);
    list.erase(stored);
    list[view]["extensions"][kKhr].update(placed);  // buffer, byteOffset, byteLength
  }
  for (Json& buffer : document.json()["buffers"])
    if (extension_field(buffer, kExt) != nullptr) rename(buffer);
  const Json* const required = array_field(std::as_const(document).json(), "extensionsRequired");
  list_extension(document, kKhr, required != nullptr && std::ranges::count(*required, Json(kExt)) > 0);
  unlist_unused_extension(document, kExt);
  drop_unused(document, {});  // the bytes of before
}

}  // namespace psplit
