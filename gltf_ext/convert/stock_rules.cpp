#include "gltf_ext/convert/stock_rules.h"

#include <algorithm>
#include <cmath>

#include "gltf_ext/json/json_fields.h"
#include "psplit/decode.h"
#include "src/container/stored_type.h"

namespace psplit {
namespace {

// The range of an index type, without the value that restarts primitives.
uint64_t most_points(ComponentType type) {
  switch (type) {
    case ComponentType::kUint8: return 255;
    case ComponentType::kUint16: return 65535;
    case ComponentType::kUint32: return 4294967295u;
    default: return 0;
  }
}

class StockChecker {
 public:
  StockChecker(const Document& document, PrimitiveId id, const MeshView& mesh)
      : document_(document),
        records_(document.records()),
        primitive_(records_.primitive(id)),
        place_(place_of(document, id)),
        mesh_(mesh) {}

  void check_counts() {
    for (const AttributeRequest& request : primitive_.stock->requests)
      check_count(primitive_.accessor_of(request.semantic), request.semantic, mesh_.point_count);
    if (primitive_.indices >= 0) check_count(primitive_.indices, "indices", mesh_.indices.count);
  }

  void check() {
    if (primitive_.mode != 4 && primitive_.mode != 5)
      report("mode", "stock Draco is a list or a strip of triangles");
    if (records_.view(primitive_.stock->view).meshopt)
      report("exclusion", "the stream's buffer view is compressed");
    check_counts();
    check_indices();
    const auto bytes = buffer_view_bytes(document_, primitive_.stock->view);
    if (!bytes) return;
    const Expected<StreamDescription> stream = describe_stream(*bytes);
    for (const AttributeRequest& request : primitive_.stock->requests) {
      const StreamAttribute* attribute = nullptr;
      if (stream)  // bitstreams before 2.2 cannot be described
        for (const StreamAttribute& other : stream->attributes)
          if (other.unique_id == request.unique_id) attribute = &other;
      if (attribute != nullptr && !document_.from_draco &&
          attribute->type != stored_type(request.component_type))
        report("attribute-type", request.semantic + " is stored in another type than its accessor's");
      if (const ValuesView* const values = mesh_.find(request.semantic))
        check_bounds(primitive_.accessor_of(request.semantic), request.semantic, *values,
                     attribute == nullptr ? kUnknownStep : step_of(*attribute, *values));
    }
  }

  std::vector<Finding> findings() && { return std::move(findings_); }

 private:
  static constexpr double kUnknownStep = 0.01;  // in 1

  void report(const char* rule, std::string message) {
    findings_.push_back({rule, std::move(message), place_, true, StatusCode::kInvalidInput, true});
  }

  void check_count(int64_t accessor, const std::string& what, uint64_t count) {
    const uint64_t stated = records_.accessor(accessor).count;
    if (stated != count)
      report("accessor-count", what + ": the accessor counts " + std::to_string(stated) + ", the stream has " +
                                   std::to_string(count));
  }

  void check_indices() {
    if (primitive_.indices < 0) return report("members", "the primitive has no indices accessor");
    const ElementLayout& layout = records_.accessor(primitive_.indices).layout;
    if (mesh_.point_count > most_points(layout.component_type))
      report("index-type",
             std::to_string(mesh_.point_count) + " points do not fit the indices' component type");
  }

  // How far a value moves when the stream's encoder quantizes it, in units of the accessor's integers if it has
  // integers.
  static double step_of(const StreamAttribute& attribute, const ValuesView& values) {
    if (attribute.bits == 0) return 0;
    const double places = std::ldexp(1.0, attribute.bits) - 1;
    if (!attribute.is_octahedral()) return attribute.range / places;
    constexpr double kDiameter = 2,
                     kStretch = 2;  // of the octahedron, and of its faces where they become round
    const double unit = values.component_type == ComponentType::kFloat32
                            ? 1
                            : std::ldexp(1.0, static_cast<int>(8 * component_bytes(values.component_type)) - 1);
    return kStretch * kDiameter / places * unit;
  }

  // A .drc file states no types and bounds of glTF.
  void check_bounds(int64_t index, const std::string& semantic, const ValuesView& values, double step) {
    if (document_.from_draco || values.count == 0) return;
    const Json& accessor = document_.json()["accessors"][static_cast<size_t>(index)];
    const bool needs_bounds = semantic == "POSITION";
    Json wanted = Json::object();
    for (const char* name : {"min", "max"}) {
      const Json* const stated = field(accessor, name);
      if (stated == nullptr && needs_bounds) report("accessor-bounds", semantic + " has no " + name);
      if (stated == nullptr) continue;
      if (wanted.empty()) describe_decoded(wanted, values, true);
      if (!is_near(*stated, wanted[name], step))
        report("accessor-bounds", semantic + ": " + name + " differs from that of the decoded values");
    }
  }
  static bool is_near(const Json& stated, const Json& decoded, double step) {
    if (!stated.is_array() || stated.size() != decoded.size()) return false;
    for (size_t c = 0; c < decoded.size(); ++c) {
      const auto a = number_value(stated[c]), b = number_value(decoded[c]);
      if (!a || !b) return false;
      constexpr double kFloatError = 1e-6, kMostSteps = 2;  // encoders differ in how they round
      const double rounding = kFloatError * std::max(std::abs(*a), std::abs(*b));
      if (!(std::abs(*a - *b) <= kMostSteps * step + rounding)) return false;
    }
    return true;
  }

  const Document& document_;
  const AssetRecords& records_;
  const PrimitiveRecord& primitive_;
  const Place place_;
  const MeshView& mesh_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_stock_primitive(const Document& document, PrimitiveId id, const MeshView& mesh) {
  StockChecker checker(document, id, mesh);
  checker.check();
  return std::move(checker).findings();
}

std::vector<Finding> check_stock_counts(const Document& document, PrimitiveId id, const MeshView& mesh) {
  StockChecker checker(document, id, mesh);
  checker.check_counts();
  return std::move(checker).findings();
}

}  // namespace psplit
