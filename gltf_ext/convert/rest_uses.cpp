#include "gltf_ext/convert/rest_uses.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "encoder/coding/quantization.h"
#include "gltf_ext/convert/stated_grids.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

using Kind = RestPrecision::Kind;

// The exponent of the largest power of two that is at most `step`; nothing if the step is not a positive
// number.
std::optional<int> exponent_within(double step) {
  if (!(step > 0) || !std::isfinite(step)) return std::nullopt;
  int exponent = 0;
  std::frexp(step, &exponent);
  return exponent - 1;
}

class UseFinder {
 public:
  UseFinder(const Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool)
      : document_(document), records_(document.records()), options_(options) {
    const auto has_targets = [](const PrimitiveRecord& primitive) { return !primitive.targets.empty(); };
    for (const std::vector<PrimitiveRecord>& mesh : records_.meshes)
      if (!options.lossless && std::ranges::any_of(mesh, has_targets)) {
        grids_ = all_stated_grids(document, pool);
        return;
      }
  }

  std::map<int64_t, RestUse> run() {
    for (size_t mesh = 0; mesh < records_.meshes.size(); ++mesh) add_mesh(mesh);
    const Json& json = document_.json();
    for_each_element(json, "animations", [&](const Json& animation) { add_animation(animation); });
    for_each_element(json, "skins", [&](const Json& skin) {
      visit_field(skin, "inverseBindMatrices", [&](const Json& index) { add(index, {}); });
    });
    for_each_element(json, "nodes", [&](const Json& node) {
      if (const Json* instances = extension_field(node, "EXT_mesh_gpu_instancing"))
        if (const Json* attributes = object_field(*instances, "attributes"))
          for (const auto& [name, index] : attributes->items())
            add(index, {RestView::kPacked, of_instances(name), 1});
    });
    const DataUsers users(json);
    std::erase_if(uses_, [&](const auto& entry) {
      const auto& [index, use] = entry;
      return clashes_.contains(index) || !DataUsers::has(users.accessors, index, counts_[index]);
    });
    return std::move(uses_);
  }

 private:
  void add(int64_t index, const RestUse& use) {
    ++counts_[index];
    const auto [found, is_new] = uses_.try_emplace(index, use);
    if (is_new || found->second == use) return;
    RestUse& before = found->second;
    if (before.view != use.view) {
      clashes_.insert(index);
    } else if (before.precision.kind == Kind::kStep && use.precision.kind == Kind::kStep) {
      before.precision.value = std::min(before.precision.value, use.precision.value);
      before.precision.keeps_apart |= use.precision.keeps_apart;
    } else {
      before.precision = {};
    }
    if (before.period != use.period) before.period = 1;
  }
  void add(const Json& index, const RestUse& use) {
    if (const auto number = integer_value(index)) add(*number, use);
  }

  void add_mesh(size_t index) {
    const std::vector<PrimitiveRecord>& mesh = records_.meshes[index];
    const std::optional<int> step = step_of(index);
    // Beside compressed primitives, positions lie on the grid of these.
    const bool is_plain = std::ranges::all_of(
        mesh, [](const PrimitiveRecord& primitive) { return primitive.draco() == nullptr; });
    for (const PrimitiveRecord& primitive : mesh) {
      const DracoRecord* draco = primitive.draco();
      for (const AttributeRecord& attribute : primitive.attributes)
        if (draco == nullptr || !draco->stores(attribute.semantic))
          add(attribute.accessor,
              {RestView::kVertices,
               is_plain ? of_attribute(primitive, attribute.semantic, step) : RestPrecision(), 1});
      // Attributes in streams may have a fallback in buffer views, which keeps their values.
      for (size_t t = 0; t < primitive.targets.size(); ++t)
        for (const AttributeRecord& attribute : primitive.targets[t])
          if (draco == nullptr || !draco->stores(name_of_target(t, attribute.semantic)))
            add(attribute.accessor, {RestView::kVertices, of_target(attribute.semantic, step), 1});
      if (primitive.indices < 0 || draco != nullptr) continue;
      const bool is_list = primitive.mode == 4 && records_.accessor(primitive.indices).count % 3 == 0;
      add(primitive.indices, {is_list ? RestView::kTriangles : RestView::kIndices, {}, 1});
    }
  }

  // Points and lines have no other grid. Triangles are plain because they were to stay as they were.
  RestPrecision of_attribute(const PrimitiveRecord& primitive, const std::string& semantic,
                             std::optional<int> step) const {
    if (options_.lossless || primitive.has_triangles()) return {};
    if (semantic.starts_with("COLOR_")) return {Kind::kStep, -options_.color_bits, false};
    return semantic == "POSITION" && step ? RestPrecision{Kind::kStep, *step, true} : RestPrecision();
  }

  // Displacements are as exact as what they are added to. Equal ones on both sides of a border stay equal.
  RestPrecision of_target(const std::string& semantic, std::optional<int> step) const {
    if (options_.lossless) return {};
    if (semantic == "POSITION") return step ? RestPrecision{Kind::kStep, *step, false} : RestPrecision();
    if (semantic == "NORMAL" || semantic == "TANGENT") return {Kind::kStep, 1 - options_.normal_bits, false};
    return {};
  }

  // The exponent of a step that is at most the step of each grid of positions in the mesh. Nothing if a stream
  // has no grid. A mesh without streams gets the step that its streams would have.
  std::optional<int> step_of(size_t mesh) const {
    std::optional<double> step;
    const std::vector<PrimitiveRecord>& primitives = records_.meshes[mesh];
    for (size_t i = 0; i < primitives.size(); ++i) {
      const auto grids = grids_.find({mesh, i});
      if (grids == grids_.end()) continue;
      const auto grid = grids->second.find("POSITION");
      if (grid == grids->second.end() || grid->second.bits == 0) return std::nullopt;
      step = std::min(step.value_or(INFINITY), grid_step(grid->second));
    }
    return step ? exponent_within(*step) : step_of_bounds(primitives);
  }

  std::optional<int> step_of_bounds(const std::vector<PrimitiveRecord>& mesh) const {
    if (options_.position_bits_by_edges) return std::nullopt;
    if (options_.max_position_error > 0) return exponent_within(options_.max_position_error);
    double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (const PrimitiveRecord& primitive : mesh) {
      const int64_t index = primitive.accessor_of("POSITION");
      if (index < 0) continue;
      const Json& accessor = document_.json()["accessors"][static_cast<size_t>(index)];
      if (records_.accessor(index).layout.component_type != ComponentType::kFloat32) return std::nullopt;
      for (int axis = 0; axis < 3; ++axis) {
        const std::optional<double> min = bound(accessor, "min", axis), max = bound(accessor, "max", axis);
        if (!min || !max) return std::nullopt;
        least[axis] = std::min(least[axis], *min);
        most[axis] = std::max(most[axis], *max);
      }
    }
    double size = 0;
    for (int axis = 0; axis < 3; ++axis) size = std::max(size, most[axis] - least[axis]);
    return exponent_within(std::ldexp(size, -options_.position_bits));
  }

  static std::optional<double> bound(const Json& accessor, const char* name, int axis) {
    const Json* bounds = array_field(accessor, name);
    const Json* number = bounds == nullptr ? nullptr : element(*bounds, axis);
    return number == nullptr ? std::nullopt : number_value(*number);
  }

  void add_animation(const Json& animation) {
    const Json* samplers = array_field(animation, "samplers");
    if (samplers == nullptr) return;
    std::map<int64_t, std::set<std::string>> paths;
    for_each_element(animation, "channels", [&](const Json& channel) {
      const Json* target = object_field(channel, "target");
      const std::string* path = target == nullptr ? nullptr : string_field(*target, "path");
      paths[integer_field(channel, "sampler").value_or(-1)].insert(path == nullptr ? "" : *path);
    });
    for (size_t i = 0; i < samplers->size(); ++i) {
      const Json& sampler = (*samplers)[i];
      visit_field(sampler, "input", [&](const Json& index) { add(index, {}); });
      visit_field(sampler, "output", [&](const Json& index) {
        const std::set<std::string>& of_sampler = paths[static_cast<int64_t>(i)];
        add(index, output_use(sampler, of_sampler.size() == 1 ? *of_sampler.begin() : ""));
      });
    }
  }

  // Tangents of splines are neither unit quaternions nor as large as the values.
  RestUse output_use(const Json& sampler, const std::string& path) const {
    RestUse use;
    const auto input = integer_field(sampler, "input"), output = integer_field(sampler, "output");
    const std::string* interpolation = string_field(sampler, "interpolation");
    const bool is_spline = interpolation != nullptr && *interpolation == "CUBICSPLINE";
    if (is_spline) use.period = 3;
    if (path == "weights" && input && output) {
      const uint64_t keys = records_.accessor(*input).count, values = records_.accessor(*output).count;
      if (keys > 0 && values % keys == 0) use.period = values / keys;
    }
    if (is_spline || options_.lossless) return use;
    const AnimationBits& bits = options_.animation_bits;
    if (path == "translation") use.precision = {Kind::kBits, bits.translation, false};
    if (path == "rotation") use.precision = {Kind::kTurn, bits.rotation, false};
    if (path == "scale") use.precision = {Kind::kBits, bits.scale, false};
    if (path == "weights") use.precision = {Kind::kStep, -bits.weight, false};
    return use;
  }

  // Instances are as exact as nodes that move.
  RestPrecision of_instances(const std::string& name) const {
    const AnimationBits& bits = options_.animation_bits;
    if (options_.lossless) return {};
    if (name == "TRANSLATION") return {Kind::kBits, bits.translation, false};
    if (name == "ROTATION") return {Kind::kRotation, bits.rotation, false};
    if (name == "SCALE") return {Kind::kBits, bits.scale, false};
    return {};
  }

  const Document& document_;
  const AssetRecords& records_;
  const EncodeDocumentOptions& options_;
  StatedGrids grids_;
  std::map<int64_t, RestUse> uses_;
  std::map<int64_t, size_t> counts_;
  std::set<int64_t> clashes_;
};

}  // namespace

std::map<int64_t, RestUse> rest_uses(const Document& document, const EncodeDocumentOptions& options,
                                     const ThreadPool& pool) {
  return UseFinder(document, options, pool).run();
}

}  // namespace psplit
