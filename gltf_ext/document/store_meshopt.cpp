#include "gltf_ext/document/store_meshopt.h"

#include <utility>
#include <vector>

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

}  // namespace psplit
