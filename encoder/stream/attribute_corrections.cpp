#include "encoder/stream/attribute_corrections.h"

#include <memory>
#include <vector>

#include "encoder/fields/draco_corrections.h"
#include "encoder/stream/crease_choice.h"
#include "src/container/claims.h"
#include "src/core/multi_parallelogram.h"
#include "src/core/normals.h"
#include "src/core/tex_coords.h"

namespace psplit {
namespace {

using core::Scheme;

class Corrections {
 public:
  explicit Corrections(const ValuesToCorrect& of) : of_(of), zeros_(of.attribute.value_components()) {}

  Expected<AttributeFields> make() {
    out_.count = of_.group.sequence.count;
    out_.components = of_.attribute.value_components();
    if (of_.attribute.coding == core::Coding::kRaw) {
      out_.raw.assign(of_.attribute.raw, of_.attribute.raw + size_t{out_.count} * of_.attribute.stride());
      return std::move(out_);
    }
    Status status = correct();
    if (!status.ok()) return status;
    return std::move(out_);
  }

 private:
  Status correct() {
    switch (of_.scheme) {
      case Scheme::kNone:
      case Scheme::kDifference:
      case Scheme::kParallelogram: return correct_plainly();
      case Scheme::kConstrainedMultiParallelogram:
        return out_.components == 3 ? choose_creases<3>() : choose_creases<0>();
      case Scheme::kTexCoords: return correct_texture();
      case Scheme::kGeometricNormal: return correct_normals();
      case Scheme::kMultiParallelogram: break;
    }
    return unsupported("a prediction scheme that no encoder writes");
  }

  static Status range_too_large() { return unsupported("integers whose range has 2^31 numbers"); }

  Status correct_plainly() {
    core::PredictionData data;
    data.scheme = of_.scheme;
    data.transform = of_.transform;
    if (of_.attribute.coding == core::Coding::kNormal) data.grid = core::OctahedralGrid(of_.attribute.bits);
    const bool is_corrected = DracoCorrections(of_.group, of_.attribute, data).write(out_);
    return is_corrected || of_.scheme == Scheme::kNone ? Status() : range_too_large();
  }

  template <uint32_t kComponents>
  Status choose_creases() {
    const auto on = known_values<kComponents>(of_.group, of_.attribute, zeros_.data());
    WrapCorrections<kComponents> wrap;
    if (!wrap.find_range(on)) return range_too_large();
    wrap.write_range(out_);
    core::ParallelogramFinder<uint32_t> finder;
    core::Arena arena = take_arena(core::ParallelogramFinder<uint32_t>::bytes(on.sequence.count));
    if (const core::Fault fault = finder.find(on.table, on.sequence, arena); fault != core::Fault::kNone)
      return status_of(fault);

    std::array<size_t, core::kMaxParallelograms> flag_count{};
    for (uint32_t i = 0; i < on.sequence.count; ++i)
      if (const uint32_t count = finder.count(i); count > 0) flag_count[count - 1] += count;
    for (uint32_t n = 0; n < core::kMaxParallelograms; ++n) out_.creases[n].resize(flag_count[n]);

    const uint32_t components = on.components();
    out_.symbols.resize(size_t{on.sequence.count} * components);
    CreaseChoice chooser(components);
    std::vector<int32_t> parallelograms(size_t{core::kMaxParallelograms} * components);
    for (uint32_t i = on.sequence.count; i-- > 0;) {
      const int32_t *const value = on.at(on.sequence.corner[i]), *predicted = on.zeros;
      if (i > 0) {
        const uint32_t count = finder.count(i);
        for (uint32_t j = 0; j < count; ++j) {
          const core::Parallelogram by = core::parallelogram_at(on, finder.across(i, j));
          for (uint32_t k = 0; k < components; ++k)
            parallelograms[size_t{j} * components + k] = by.predicted<core::Components<1>>(k)[0];
        }
        const CreaseChoice::Choice& choice = chooser.choose(value, on.before(i), parallelograms.data(), count);
        predicted = choice.predicted.data();
        for (uint32_t j = count; j-- > 0;)
          out_.creases[count - 1][--flag_count[count - 1]] = (choice.used >> j & 1) == 0 ? 1 : 0;
      }
      for (uint32_t k = 0; k < components; ++k)
        out_.symbols[size_t{i} * components + k] = wrap.symbol(value[k], predicted[k]);
    }
    return {};
  }

  // The side of an edge that is nearer to the value. Orientations are stored from that of the last value on.
  Status correct_texture() {
    if (!has_positions()) return unsupported("texture coordinates without integer positions");
    const auto on = known_values<2>(of_.group, of_.attribute, zeros_.data());
    WrapCorrections<2> wrap;
    if (!wrap.find_range(on)) return range_too_large();
    wrap.write_range(out_);
    out_.symbols.resize(size_t{2} * on.sequence.count);
    const core::Positions<uint32_t> positions = this->positions();
    bool last_up = true;
    for (uint32_t i = on.sequence.count; i-- > 0;) {
      core::TipPlaces places;
      bool is_placed = false;
      const int32_t* predicted = nullptr;
      if (core::find_texture_places(on, positions, i, places, is_placed, predicted) != core::Fault::kNone)
        return unsupported("texture coordinates whose products with positions overflow");
      const int32_t* const value = on.at(on.sequence.corner[i]);
      int32_t placed[2];
      if (is_placed) {
        int64_t s[2], t[2];
        const auto distance = [&](bool up) {
          places.place(up, s[up], t[up]);
          const int64_t ds = core::wrapping_sub(int64_t{value[0]}, s[up]),
                        dt = core::wrapping_sub(int64_t{value[1]}, t[up]);
          return static_cast<int64_t>(core::product(ds, ds) + core::product(dt, dt));
        };
        const bool up = distance(true) < distance(false);
        placed[0] = static_cast<int32_t>(s[up]), placed[1] = static_cast<int32_t>(t[up]);
        predicted = placed;
        out_.same_orientations.push_back(up == last_up ? 1 : 0);
        last_up = up;
      }
      for (uint32_t k = 0; k < 2; ++k) out_.symbols[size_t{2} * i + k] = wrap.symbol(value[k], predicted[k]);
    }
    return {};
  }

  // The direction whose correction is shorter. Of equal ones the one that is flipped.
  Status correct_normals() {
    if (!has_positions()) return unsupported("normals predicted without integer positions");
    const auto on = known_values<2>(of_.group, of_.attribute, zeros_.data());
    const core::OctahedralGrid grid(of_.attribute.bits);
    const bool canonicalized = of_.transform == core::Transform::kOctahedronCanonicalized;
    const uint32_t count = on.sequence.count, half = static_cast<uint32_t>(grid.center());
    core::Arena arena = take_arena(core::normal_sum_bytes(count));
    const core::Positions<uint32_t> positions = this->positions();
    const core::View<core::Vec3> sums = core::sum_normals(on.table, positions, count, arena);
    out_.symbols.resize(size_t{2} * count);
    out_.flips.resize(count);
    // Corrections are modulo the grid's width. A number is at most half of it away from 0.
    const auto size = [&](int32_t number) {
      const auto positive = static_cast<uint32_t>(number);
      return positive > half ? grid.max_quantized() - positive : positive;
    };
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t corner = on.sequence.corner[i];
      const int32_t* const value = on.at(corner);
      core::Vec3 normal =
          sums.empty() ? core::normal_at(on.table, positions, corner) : sums[on.table.vertex[corner]];
      core::shorten(normal);
      const auto correction = [&](bool flip) {
        return grid.correction(grid.project(normal, flip), {value[0], value[1]}, canonicalized);
      };
      const core::Vec2 kept = correction(false), flipped = correction(true);
      const bool flip = size(kept.s) + size(kept.t) >= size(flipped.s) + size(flipped.t);
      out_.flips[i] = flip ? 1 : 0;
      out_.symbols[size_t{2} * i] = static_cast<uint32_t>(flip ? flipped.s : kept.s);
      out_.symbols[size_t{2} * i + 1] = static_cast<uint32_t>(flip ? flipped.t : kept.t);
    }
    return {};
  }

  bool has_positions() const {
    return of_.position_group != nullptr && of_.positions != nullptr && !of_.positions->values.empty() &&
           of_.positions->value_components() == 3;
  }
  core::Positions<uint32_t> positions() const {
    return {of_.group.table.table, of_.position_group->table.table, of_.group.sequence, of_.positions->values,
            of_.position_group->table.has_seams};
  }

  core::Arena take_arena(size_t bytes) {
    memory_.reset(new uint8_t[bytes]);
    return {memory_.get(), bytes};
  }

  const ValuesToCorrect& of_;
  std::vector<int32_t> zeros_;
  std::unique_ptr<uint8_t[]> memory_;
  AttributeFields out_;
};

}  // namespace

Expected<AttributeFields> correct_values(const ValuesToCorrect& of) { return Corrections(of).make(); }

}  // namespace psplit
