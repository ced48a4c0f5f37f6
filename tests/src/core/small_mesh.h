// A mesh of a few faces, made by hand, for tests of the stages that read a corner table.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/core/predicted_values.h"

namespace psplit::core {

// Vertex v has value v of the sequence. met[v] is the corner at which the traversal met it: its first corner,
// unless a test changes that.
class SmallMesh {
 public:
  explicit SmallMesh(const std::vector<std::array<uint16_t, 3>>& faces) {
    opposite_.assign(4 * faces.size(), kNone<uint16_t>);
    vertex_.assign(4 * faces.size(), 0);
    for (uint16_t corner = 0; corner < vertex_.size(); ++corner) {
      if (corner % 4 == 3) continue;
      vertex_[corner] = faces[corner / 4][corner % 4];
      if (vertex_[corner] >= met.size()) met.resize(vertex_[corner] + size_t{1}, kNone<uint16_t>);
      if (met[vertex_[corner]] == kNone<uint16_t>) met[vertex_[corner]] = corner;
    }
    // Two faces share an edge if each has it in the other direction.
    for (uint16_t a = 0; a < vertex_.size(); ++a)
      for (uint16_t b = 0; b < vertex_.size(); ++b)
        if (a % 4 != 3 && b % 4 != 3 && vertex_[next(a)] == vertex_[previous(b)] &&
            vertex_[previous(a)] == vertex_[next(b)])
          opposite_[a] = b;
    for (size_t v = 0; v < met.size(); ++v) rank_.push_back(static_cast<uint16_t>(v));
    met.push_back(0);  // see Sequence
  }

  CornerTable<uint16_t> table() {
    return {{opposite_.data(), opposite_.size()}, {vertex_.data(), vertex_.size()}};
  }
  Sequence<uint16_t> sequence() {
    return {{met.data(), met.size()}, {rank_.data(), rank_.size()}, static_cast<uint32_t>(rank_.size())};
  }

  // The values to predict, of kComponents components, or of `components` if kComponents is 0. `corrections` has
  // no gaps.
  template <uint32_t kComponents>
  PredictedValues<uint16_t, kComponents> values(const std::vector<int32_t>& corrections,
                                                uint32_t components = kComponents) {
    corrections_ = corrections;
    corrections_.push_back(0);
    values_.assign(rank_.size() * value_stride(components), 0);
    return {table(),
            sequence(),
            View<const int32_t>(corrections_.data(), corrections_.size()),
            View<int32_t>(values_.data(), values_.size()),
            kZeros,
            components};
  }
  // A value as it was written since the last call of `values`.
  std::vector<int32_t> value(uint32_t vertex, uint32_t components) const {
    const auto at = values_.begin() + static_cast<ptrdiff_t>(vertex * value_stride(components));
    return {at, at + components};
  }

  std::vector<uint16_t> met;

 private:
  static constexpr int32_t kZeros[8] = {};
  std::vector<uint16_t> opposite_, vertex_, rank_;
  std::vector<int32_t> corrections_, values_;
};

}  // namespace psplit::core
