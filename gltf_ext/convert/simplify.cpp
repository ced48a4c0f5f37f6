#include "gltf_ext/convert/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "src/mesh/number_of.h"

namespace psplit {
namespace {

constexpr size_t kPositionBytes = 3 * sizeof(float);
// The number of faces decides, not the distance between surfaces, which meshoptimizer takes as a share of the
// extent.
constexpr float kAnyError = 1;

// All meshes as one. Points of different meshes at one position are a seam for meshoptimizer.
class JoinedMeshes {
 public:
  explicit JoinedMeshes(std::span<const Mesh> meshes) {
    for (const Mesh& mesh : meshes) {
      for (uint32_t i = 0; i < mesh.point_count; ++i) add_position(*mesh.find("POSITION"), i);
      const auto first = static_cast<unsigned>(first_point_.back());
      for (const auto& face : mesh.faces)
        for (const uint32_t point : face) corners_.push_back(first + point);
      first_point_.push_back(first_point_.back() + mesh.point_count);
      first_corner_.push_back(corners_.size());
    }
  }

  // Three points for each face.
  const std::vector<unsigned>& corners() const { return corners_; }

  // The same faces, whose points at one position are one point, within each mesh.
  std::vector<unsigned> corners_without_seams() const {
    return for_each_mesh([](std::span<const unsigned> corners, std::span<const float> positions) {
      std::vector<unsigned> joined(corners.size());
      meshopt_generateShadowIndexBuffer(joined.data(), corners.data(), corners.size(), positions.data(),
                                        positions.size() / 3, kPositionBytes, kPositionBytes);
      return joined;
    });
  }

  std::vector<unsigned> simplified(std::span<const unsigned> corners, uint64_t target) const {
    std::vector<unsigned> result(corners.size());
    result.resize(meshopt_simplify(result.data(), corners.data(), corners.size(), positions_.data(),
                                   positions_.size() / 3, kPositionBytes, static_cast<size_t>(target) * 3,
                                   kAnyError));
    return result;
  }

  // Simplifies each mesh on its own, without regard to its topology.
  std::vector<unsigned> simplified_sloppily(uint64_t target) const {
    const double share = static_cast<double>(target) * 3 / static_cast<double>(corners_.size());
    return for_each_mesh([share](std::span<const unsigned> corners, std::span<const float> positions) {
      const auto wanted = static_cast<size_t>(share * static_cast<double>(corners.size()) / 3) * 3;
      std::vector<unsigned> result(corners.size());
      result.resize(meshopt_simplifySloppy(result.data(), corners.data(), corners.size(), positions.data(),
                                           positions.size() / 3, kPositionBytes, std::max<size_t>(wanted, 3),
                                           kAnyError));
      return result;
    });
  }

  // The faces of each mesh. A face with corners of several, at a border that could not be kept, is left out.
  std::vector<Faces> divide(std::span<const unsigned> corners) const {
    std::vector<Faces> faces(first_point_.size() - 1);
    for (size_t i = 0; i < corners.size(); i += 3) {
      const auto above = std::ranges::upper_bound(first_point_, size_t{corners[i]});
      const auto mesh = static_cast<size_t>(above - first_point_.begin()) - 1;
      std::array<uint32_t, 3> face{};
      bool is_own = true;
      for (size_t k = 0; k < 3; ++k) {
        is_own &= corners[i + k] >= first_point_[mesh] && corners[i + k] < first_point_[mesh + 1];
        face[k] = corners[i + k] - static_cast<unsigned>(first_point_[mesh]);
      }
      if (is_own) faces[mesh].push_back(face);
    }
    return faces;
  }

 private:
  void add_position(const Attribute& position, uint32_t point) {
    const std::byte* const value = position.values.data() + point * position.stride();
    const size_t width = component_bytes(position.component_type);
    for (size_t axis = 0; axis < 3; ++axis) {
      const double number = axis < position.component_count
                                ? number_of(value + axis * width, position.component_type, position.normalized)
                                : 0;
      positions_.push_back(std::isfinite(number) ? static_cast<float>(number) : 0.0f);
    }
  }

  // Joins what work(corners, positions) returns for each mesh, whose points it numbers from 0 on.
  template <typename Work>
  std::vector<unsigned> for_each_mesh(Work&& work) const {
    std::vector<unsigned> all;
    for (size_t m = 0; m + 1 < first_point_.size(); ++m) {
      const auto first = static_cast<unsigned>(first_point_[m]);
      std::vector<unsigned> own(corners_.begin() + static_cast<std::ptrdiff_t>(first_corner_[m]),
                                corners_.begin() + static_cast<std::ptrdiff_t>(first_corner_[m + 1]));
      if (own.empty()) continue;
      for (unsigned& corner : own) corner -= first;
      const auto positions =
          std::span(positions_).subspan(3 * first_point_[m], 3 * (first_point_[m + 1] - first_point_[m]));
      for (const unsigned corner : work(own, positions)) all.push_back(first + corner);
    }
    return all;
  }

  std::vector<float> positions_;  // three for each point
  std::vector<unsigned> corners_;
  std::vector<size_t> first_point_{0}, first_corner_{0};  // of each mesh, then the ends
};

}  // namespace

std::vector<Faces> simplify(std::span<const Mesh> meshes, uint64_t target) {
  const JoinedMeshes joined(meshes);
  // Seams are borders that must stay, so twice the wanted faces are good enough.
  const size_t good = static_cast<size_t>(target) * 3 * 2;
  std::vector<unsigned> best = joined.corners();
  const auto take = [&](std::vector<unsigned> corners) {
    if (!corners.empty() && corners.size() < best.size()) best = std::move(corners);
  };
  if (best.size() > good) take(joined.simplified(joined.corners(), target));
  if (best.size() > good) take(joined.simplified(joined.corners_without_seams(), target));
  if (best.size() > good) take(joined.simplified_sloppily(target));
  std::vector<Faces> faces = joined.divide(best);
  if (std::ranges::all_of(faces, &Faces::empty)) faces = joined.divide(joined.corners());
  return faces;
}

}  // namespace psplit
