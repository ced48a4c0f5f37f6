#include "gltf_ext/convert/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "src/mesh/number_of.h"

namespace psplit {
namespace {

// A position, and the number of the mesh.
using Point = std::array<float, 4>;
// The number of faces decides, not the distance between surfaces, which meshoptimizer takes as a share of the
// extent.
constexpr float kAnyError = 1;

// All meshes as one. Points of different meshes at one position are a seam for meshoptimizer.
class JoinedMeshes {
 public:
  explicit JoinedMeshes(std::span<const Mesh> meshes) {
    for (const Mesh& mesh : meshes) {
      const Attribute& position = *mesh.find("POSITION");
      for (uint32_t i = 0; i < mesh.point_count; ++i) add_point(position, i, first_point_.size());
      const auto first = static_cast<unsigned>(first_point_.back());
      for (const auto& face : mesh.faces)
        for (const uint32_t point : face) corners_.push_back(first + point);
      first_point_.push_back(first_point_.back() + mesh.point_count);
      first_corner_.push_back(corners_.size());
    }
  }

  // Three points for each face.
  const std::vector<unsigned>& corners() const { return corners_; }

  // The faces with all points of one position, within each mesh, replaced by one point.
  std::vector<unsigned> without_seams(std::span<const unsigned> corners) const {
    std::vector<unsigned> joined(corners.size());
    meshopt_generateShadowIndexBuffer(joined.data(), corners.data(), corners.size(), points_.data(),
                                      points_.size(), sizeof(Point), sizeof(Point));
    return joined;
  }

  std::vector<unsigned> simplified(std::span<const unsigned> corners, uint64_t target) const {
    std::vector<unsigned> result(corners.size());
    result.resize(meshopt_simplify(result.data(), corners.data(), corners.size(), points_[0].data(),
                                   points_.size(), sizeof(Point), static_cast<size_t>(target) * 3, kAnyError));
    return result;
  }

  // Simplifies each mesh on its own, without regard to its topology.
  std::vector<unsigned> simplified_sloppily(uint64_t target) const {
    const double share = static_cast<double>(target) * 3 / static_cast<double>(corners_.size());
    std::vector<unsigned> all;
    for (size_t m = 0; m + 1 < first_point_.size(); ++m) {
      const auto first = static_cast<unsigned>(first_point_[m]);
      std::vector<unsigned> own(corners_.begin() + static_cast<std::ptrdiff_t>(first_corner_[m]),
                                corners_.begin() + static_cast<std::ptrdiff_t>(first_corner_[m + 1]));
      if (own.empty()) continue;
      for (unsigned& corner : own) corner -= first;
      const auto wanted = static_cast<size_t>(share * static_cast<double>(own.size()) / 3) * 3;
      std::vector<unsigned> result(own.size());
      result.resize(meshopt_simplifySloppy(result.data(), own.data(), own.size(), points_[first].data(),
                                           first_point_[m + 1] - first_point_[m], sizeof(Point),
                                           std::max<size_t>(wanted, 3), kAnyError));
      for (const unsigned corner : result) all.push_back(first + corner);
    }
    return all;
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
  void add_point(const Attribute& position, uint32_t number, size_t mesh) {
    Point& point = points_.emplace_back(Point{0, 0, 0, static_cast<float>(mesh)});
    const std::byte* const value = position.values.data() + number * position.stride();
    const size_t width = component_bytes(position.component_type);
    for (size_t axis = 0; axis < std::min<size_t>(3, position.component_count); ++axis) {
      const double component = number_of(value + axis * width, position.component_type, position.normalized);
      if (std::isfinite(component)) point[axis] = static_cast<float>(component);
    }
  }

  std::vector<Point> points_;
  std::vector<unsigned> corners_;
  std::vector<size_t> first_point_{0}, first_corner_{0};  // of each mesh, then the ends
};

}  // namespace

Expected<std::vector<Faces>> simplify(std::span<const Mesh> meshes, uint64_t target) {
  const JoinedMeshes joined(meshes);
  // Seams are borders that must stay, so twice the wanted faces are good enough.
  const size_t good = static_cast<size_t>(target) * 3 * 2;
  std::vector<unsigned> best = joined.corners();
  const auto take = [&](std::vector<unsigned> corners) {
    if (!corners.empty() && corners.size() < best.size()) best = std::move(corners);
  };
  if (best.size() > good) take(joined.simplified(joined.corners(), target));
  if (best.size() > good) take(joined.simplified(joined.without_seams(best), target));
  // This finds no face if the wanted ones are too few for the shape.
  const size_t before = best.size();
  for (uint64_t more = target; best.size() > good && best.size() == before && more * 3 < before; more *= 2)
    take(joined.simplified_sloppily(more));
  std::vector<Faces> faces = joined.divide(best);
  if (std::ranges::all_of(faces, &Faces::empty)) faces = joined.divide(joined.corners());
  return faces;
}

}  // namespace psplit
