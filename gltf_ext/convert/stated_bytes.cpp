#include "gltf_ext/convert/stated_bytes.h"

#include <vector>

#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "src/container/claims.h"

namespace psplit {

StatedBytes stated_bytes(const Document& document, PrimitiveId id) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(id);
  if (primitive.storage() == PrimitiveStorage::kPlain) return {};
  const auto stored = stored_primitive(document, id);
  if (!stored) return {};
  const uint64_t points = records.points_of(primitive), faces = records.faces_of(primitive);
  if (!check_results(points, faces, stored->requests, stored->bytes.size()).ok()) return {};
  return {stored->bytes.size(),
          lay_out(stored->requests, static_cast<uint32_t>(points), static_cast<uint32_t>(faces), 0, {}).end};
}

StatedBytes stated_bytes(const Document& document) {
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveId id : all_primitives(document))
    if (document.records().primitive(id).storage() != PrimitiveStorage::kPlain) compressed.push_back(id);
  StatedBytes sum;
  for (const PrimitiveGroup& group : group_equal_primitives(document, compressed)) {
    const StatedBytes bytes = stated_bytes(document, group.ids.front());
    sum.stored += bytes.stored;
    sum.decoded += bytes.decoded;
  }
  return sum;
}

}  // namespace psplit
