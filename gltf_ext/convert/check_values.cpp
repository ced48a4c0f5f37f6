#include "gltf_ext/convert/check_values.h"

#include <cmath>

#include "gltf_ext/json/json_fields.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

// How many values are wrong, and the first of them.
struct Wrong {
  uint64_t count = 0;
  size_t first = 0;

  void add(size_t point) {
    if (count++ == 0) first = point;
  }
};

// Goes through several attributes of the same points together. `is_wrong(point)` is called for each point.
template <typename Check>
Wrong find_wrong(std::span<const ValuesView* const> values, const Check& is_wrong) {
  Wrong wrong;
  if (values.empty()) return wrong;
  for_each_step(*values.front(), [&](size_t first, size_t end) {
    for (size_t point = first; point < end; ++point)
      if (is_wrong(point)) wrong.add(point);
    for (const ValuesView* const other : values.subspan(1))
      release_mapped({reinterpret_cast<const uint8_t*>(other->at(first)), (end - first) * other->step()});
    return true;
  });
  return wrong;
}

double number_at(const ValuesView& values, size_t point, size_t component) {
  return number_of(values.at(point) + component * component_bytes(values.component_type), values.component_type,
                   values.normalized);
}

// The joints of the smallest skin that a node gives the mesh; nothing if it has none.
std::optional<uint64_t> joint_count(const Json& json, size_t mesh) {
  std::optional<uint64_t> least;
  for (size_t i = 0; i < array_size(json, "nodes"); ++i) {
    const Json& node = json["nodes"][i];
    const auto of_node = integer_field(node, "mesh"), skin = integer_field(node, "skin");
    if (!of_node || !skin || *of_node != static_cast<int64_t>(mesh) || *skin < 0 ||
        static_cast<size_t>(*skin) >= array_size(json, "skins"))
      continue;
    const uint64_t joints = array_size(json["skins"][static_cast<size_t>(*skin)], "joints");
    least = std::min(least.value_or(joints), joints);
  }
  return least;
}

class ValueChecker {
 public:
  ValueChecker(const Document& document, PrimitiveId id, const MeshView& mesh)
      : document_(document), id_(id), mesh_(mesh) {}

  std::vector<Finding> check() {
    for (const auto& [semantic, values] : mesh_.attributes) check_finite(semantic, values);
    if (const ValuesView* const normals = mesh_.find("NORMAL")) check_normals(*normals);
    check_weights();
    check_joints();
    return std::move(findings_);
  }

 private:
  void report(const char* rule, const Wrong& wrong, const std::string& what) {
    if (wrong.count == 0) return;
    const std::string message = std::to_string(wrong.count) + " of " + std::to_string(mesh_.point_count) +
                                " points " + what + ", the first is point " + std::to_string(wrong.first);
    findings_.push_back({rule, message, place_of(document_, id_), false});
  }

  void check_finite(const std::string& semantic, const ValuesView& values) {
    if (values.component_type != ComponentType::kFloat32) return;
    const ValuesView* const one[] = {&values};
    const Wrong wrong = find_wrong(one, [&](size_t point) {
      for (size_t c = 0; c < values.component_count; ++c)
        if (!std::isfinite(number_at(values, point, c))) return true;
      return false;
    });
    report("finite", wrong, "have a " + semantic + " that is not finite");
  }

  void check_normals(const ValuesView& normals) {
    if (normals.component_count != 3 || !is_direction(normals)) return;
    constexpr double kTolerance = 0.01;  // half a step of 8 bits in three components, and a little more
    const ValuesView* const one[] = {&normals};
    const Wrong wrong = find_wrong(one, [&](size_t point) {
      double squares = 0;
      for (size_t c = 0; c < 3; ++c) squares += std::pow(number_at(normals, point, c), 2);
      return std::isfinite(squares) && std::abs(std::sqrt(squares) - 1) > kTolerance;
    });
    report("unit-normals", wrong, "have a NORMAL that is no unit vector");
  }
  // Integers without `normalized` are no directions that glTF defines.
  static bool is_direction(const ValuesView& values) {
    return values.component_type == ComponentType::kFloat32 || values.normalized;
  }

  void check_weights() {
    std::vector<const ValuesView*> sets;
    double tolerance = kFloatTolerance;
    for (const auto& [semantic, values] : mesh_.attributes) {
      if (!semantic.starts_with("WEIGHTS_") || !is_direction(values)) continue;
      sets.push_back(&values);
      tolerance = std::max(tolerance, tolerance_of(semantic, values));
    }
    const Wrong wrong = find_wrong(sets, [&](size_t point) {
      double sum = 0;
      for (const ValuesView* const set : sets)
        for (size_t c = 0; c < set->component_count; ++c) sum += number_at(*set, point, c);
      return std::isfinite(sum) && std::abs(sum - 1) > tolerance;
    });
    report("weights-sum", wrong, "have weights that do not sum to one");
  }
  // Weights are rounded one by one: to bytes, to 16 bits, or to the grid of a Draco stream.
  double tolerance_of(const std::string& semantic, const ValuesView& weights) const {
    constexpr double kByteTolerance = 2.5 / 255, kDracoTolerance = 0.01;
    const DracoRecord* const draco = document_.records().primitive(id_).draco();
    if (draco != nullptr && draco->stores(semantic)) return kDracoTolerance;
    return component_bytes(weights.component_type) == 1 ? kByteTolerance : kFloatTolerance;
  }

  void check_joints() {
    const std::optional<uint64_t> count = joint_count(document_.json(), id_.mesh);
    if (!count) return;
    for (const auto& [semantic, of_semantic] : mesh_.attributes) {
      const auto& values = of_semantic;  // older compilers capture no name of a structured binding
      if (!semantic.starts_with("JOINTS_")) continue;
      const ValuesView* const one[] = {&values};
      const Wrong wrong = find_wrong(one, [&](size_t point) {
        for (size_t c = 0; c < values.component_count; ++c)
          if (!(number_at(values, point, c) < static_cast<double>(*count))) return true;
        return false;
      });
      report("joints-range", wrong,
             "have a " + semantic + " beyond the " + std::to_string(*count) + " joints of the skin");
    }
  }

  static constexpr double kFloatTolerance = 0.001;

  const Document& document_;
  const PrimitiveId id_;
  const MeshView& mesh_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_values(const Document& document, PrimitiveId id, const MeshView& mesh) {
  return ValueChecker(document, id, mesh).check();
}

std::vector<Finding> check_target_counts(const Document& document, PrimitiveId id) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(id);
  const int64_t positions = primitive.accessor_of("POSITION");
  std::vector<Finding> findings;
  if (positions < 0) return findings;
  const uint32_t count = records.accessor(positions).count;
  for (size_t t = 0; t < primitive.targets.size(); ++t)
    for (const auto& [semantic, accessor] : primitive.targets[t])
      if (const uint32_t others = records.accessor(accessor).count; others != count)
        findings.push_back({"target-count",
                            "morph target " + std::to_string(t) + ", " + semantic + ", has " +
                                std::to_string(others) + " elements for " + std::to_string(count) + " points",
                            place_of(document, id), false});
  return findings;
}

}  // namespace psplit
