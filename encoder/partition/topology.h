// The topology model: positions dropped, only who touches whom.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

inline constexpr uint32_t kNoFace = 0xffffffffu;

// Faces around vertices and across edges, for any input: an edge may have one face, two or many.
class Topology {
 public:
  Topology(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count);

  std::span<const std::array<uint32_t, 3>> faces() const { return faces_; }
  uint32_t vertex_count() const { return static_cast<uint32_t>(first_.size() - 1); }
  std::span<const uint32_t> around(uint32_t vertex) const {
    return std::span(around_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

  // Calls visit(face) for every other face that has both a and b.
  template <typename Visit>
  void across(uint32_t face, uint32_t a, uint32_t b, Visit visit) const {
    const bool a_is_hub = first_[a + 1] - first_[a] > first_[b + 1] - first_[b];
    const uint32_t far = a_is_hub ? a : b;
    for (const uint32_t other : around(a_is_hub ? b : a)) {
      const auto& o = faces_[other];
      if (other != face && (o[0] == far || o[1] == far || o[2] == far)) visit(other);
    }
  }

 private:
  std::span<const std::array<uint32_t, 3>> faces_;
  std::vector<uint32_t> first_, around_;
};

// Faces that vertices connect, and those vertices.
struct Component {
  std::vector<uint32_t> faces, vertices;
};
std::vector<Component> connected_components(const Topology& topology);

}  // namespace psplit
