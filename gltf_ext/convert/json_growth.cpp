#include "gltf_ext/convert/json_growth.h"

#include <algorithm>
#include <set>
#include <string>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/mesh_view.h"

namespace psplit {
namespace {

int64_t text_bytes(const Json& json) { return std::ssize(json_line(json)); }

// Counts the comma before or after the element, too.
int64_t element_bytes(const Json& json) { return text_bytes(json) + 1; }

// Offsets and indices have about as many digits as this number.
constexpr int64_t kOffset = 99999;
int64_t view_bytes(uint64_t bytes) {
  return element_bytes({{"buffer", 0}, {"byteOffset", kOffset}, {"byteLength", bytes}});
}

class GrowthOfJob {
 public:
  GrowthOfJob(const Document& document, const GeometryOwners::Freed& freed, std::set<int64_t>& edited)
      : document_(document), freed_(freed), edited_(edited) {}

  int64_t of(const EncodeJob& job) {
    const PrimitiveRecord& record = document_.records().primitive(job.group.ids.front());
    int64_t growth = 0;
    for (const EncodedPiece& stored : job.encoded.pieces)
      growth += piece(record, stored.decoded, stored.bytes.size());
    for (const PrimitiveId id : job.group.ids) growth += primitive(job, id);
    std::set<int64_t> targets;
    for (const MorphAttribute& morph : job.morphs) {
      const auto& of_target = record.targets[morph.target];
      const auto found = std::ranges::find(of_target, morph.semantic, &AttributeRecord::semantic);
      if (targets.insert(found->accessor).second)
        growth += (morph.sparse ? 2 : 1) * view_bytes(morph.data.values.size());
    }
    return growth;
  }

 private:
  // The accessors and the view of a stream or a container.
  int64_t piece(const PrimitiveRecord& record, const Mesh& mesh, uint64_t bytes) {
    int64_t growth = view_bytes(bytes);
    for (const MeshView::Values& attribute : view_of(mesh).attributes)
      growth +=
          accessor(record.accessor_of(attribute.semantic), attribute.values, attribute.semantic == "POSITION");
    return growth + accessor(record.indices, IndexData(mesh), false);
  }

  int64_t accessor(int64_t index, const ValuesView& values, bool needs_bounds) {
    Json json{{"componentType", static_cast<int>(values.component_type)}, {"type", "SCALAR"}};
    int64_t growth = 0;
    if (index >= 0) {
      json = document_.json()["accessors"][static_cast<size_t>(index)];
      // Otherwise the accessor stays, and another is made.
      if (freed_.accessors.contains(index) && edited_.insert(index).second) growth -= element_bytes(json);
    }
    describe_decoded(json, values, needs_bounds || field(json, "min") != nullptr);
    json["componentType"] = static_cast<int>(values.component_type);
    return growth + element_bytes(json);
  }

  int64_t primitive(const EncodeJob& job, PrimitiveId id) const {
    const Json& before = primitive_json(document_, id);
    Json after = before;
    if (Json* extensions = object_field(after, "extensions"))
      for (const char* other : {kExtensionName, kStockExtensionName}) extensions->erase(other);
    const char* const name = job.stored_as == StoredAs::kPatches ? kExtensionName : kStockExtensionName;
    const AssetRecords& records = document_.records();
    after["extensions"][name] = draco_extension(static_cast<int64_t>(records.views.size()),
                                                job.encoded.requests, records.primitive(id).targets.size());
    if (field(after, "indices") == nullptr) after["indices"] = document_.records().accessors.size();
    const auto pieces = static_cast<int64_t>(job.piece_count());
    return pieces * text_bytes(after) - text_bytes(before) + pieces - 1;
  }

  const Document& document_;
  const GeometryOwners::Freed& freed_;
  std::set<int64_t>& edited_;  // accessors that are counted
};

}  // namespace

int64_t json_growth(const Document& document, const GeometryOwners& owners,
                    std::span<const EncodeJob* const> jobs) {
  GeometryOwners::Groups groups;
  for (const EncodeJob* job : jobs) groups.push_back(&job->group);
  const GeometryOwners::Freed freed = owners.freed_by(groups);
  int64_t growth = 0;
  for (const int64_t view : freed.views)
    growth -= element_bytes(document.json()["bufferViews"][static_cast<size_t>(view)]);
  std::set<int64_t> edited;
  for (const EncodeJob* job : jobs) growth += GrowthOfJob(document, freed, edited).of(*job);
  return growth;
}

int64_t list_growth(const Document& document, const char* extension) {
  int64_t growth = 0;
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    if (array_field(document.json(), list) == nullptr)
      growth += text_bytes({{list, Json::array({extension})}}) - 1;  // a comma for two braces
    else if (!lists_extension(document.json(), list, extension))
      growth += element_bytes(extension);
  }
  return growth;
}

}  // namespace psplit
