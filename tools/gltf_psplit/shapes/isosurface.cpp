// Doi and Koide, An Efficient Method of Triangulating Equi-Valued Surfaces by Using Tetrahedral Cells (1991),
// on Kuhn's subdivision of the cube: one tetrahedron for each order of the axes, along the path
//
//    corner 0 -> +first axis -> +second axis -> corner 7
//
// A corner of a cube is a mask (x = 1, y = 2, z = 4). So is the direction of a tetrahedron's edge, which goes
// from its lower corner along one, two or three axes. A grid node owns the seven edges that start at it.
#include "tools/gltf_psplit/shapes/isosurface.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace psplit {
namespace {

constexpr size_t kSlabLayers = 16;
// Below 1/6, no tetrahedron can turn inside out: the sum of the changes of its edges is less than the cell.
constexpr double kJitter = 0.15;
// Keeps points away from the ends of edges, so that no two points are equal and no face is degenerate.
constexpr float kEdgeMargin = 0.12f;
// If a node's value is farther from zero than the field can change over this many cells, its edges have no
// crossing.
constexpr double kBandCells = 2.5;
// A rough value is not worth using if it skips fewer nodes than this; a more precise value skips more.
constexpr double kWorthSkipping = 8;

struct TetrahedronEdge {
  uint8_t base, direction;
};
struct TetrahedronCase {
  uint8_t corner_count = 0;  // 0, 3 or 4: the polygon that separates inside from outside
  std::array<TetrahedronEdge, 4> corners{};
};
struct Tetrahedron {
  std::array<uint8_t, 4> nodes{};
  std::array<TetrahedronCase, 16> cases{};  // indexed by the mask of inside nodes
};

constexpr std::array<Tetrahedron, 6> make_tetrahedra() {
  constexpr uint8_t kOrders[6][2] = {{1, 2}, {2, 4}, {4, 1},
                                     {2, 1}, {4, 2}, {1, 4}};  // the last three are odd permutations
  // Even permutations of the four nodes that bring each inside node, or pair, to the front.
  constexpr uint8_t kSingle[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
  constexpr uint8_t kPair[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                   {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
  std::array<Tetrahedron, 6> all{};
  for (size_t t = 0; t < 6; ++t) {
    Tetrahedron& tetrahedron = all[t];
    const uint8_t first = kOrders[t][0], second = kOrders[t][1];
    tetrahedron.nodes = {0, first, static_cast<uint8_t>(first | second), 7};
    const auto edge = [&](uint8_t a, uint8_t b) {
      const uint8_t low = std::min(tetrahedron.nodes[a], tetrahedron.nodes[b]);
      const uint8_t high = std::max(tetrahedron.nodes[a], tetrahedron.nodes[b]);
      return TetrahedronEdge{low, static_cast<uint8_t>(high ^ low)};
    };
    const auto set = [&](unsigned mask, std::array<TetrahedronEdge, 4> polygon, uint8_t count, bool flip) {
      if (flip != (t >= 3)) std::swap(polygon[1], polygon[count - 1u]);
      tetrahedron.cases[mask] = {count, polygon};
    };
    for (const auto& p : kSingle) {
      const std::array<TetrahedronEdge, 4> polygon = {edge(p[0], p[1]), edge(p[0], p[2]), edge(p[0], p[3]), {}};
      set(1u << p[0], polygon, 3, false);
      set(15u ^ (1u << p[0]), polygon, 3, true);
    }
    for (const auto& p : kPair) {
      set(1u << p[0] | 1u << p[1], {edge(p[0], p[2]), edge(p[0], p[3]), edge(p[1], p[3]), edge(p[1], p[2])}, 4,
          false);
    }
  }
  return all;
}
constexpr std::array<Tetrahedron, 6> kTetrahedra = make_tetrahedra();

struct Grid {
  const Field& field;
  double cell;
  uint64_t seed;
  size_t nodes_x, nodes_y, nodes_z;

  Vec3 node(size_t x, size_t y, size_t z) const {
    const uint64_t bits =
        hash_lattice(static_cast<int64_t>(x), static_cast<int64_t>(y), static_cast<int64_t>(z), seed);
    return {field.low.x + (static_cast<double>(x) + kJitter * signed_unit(bits)) * cell,
            field.low.y + (static_cast<double>(y) + kJitter * signed_unit(bits >> 21)) * cell,
            field.low.z + (static_cast<double>(z) + kJitter * signed_unit(bits >> 42)) * cell};
  }
  bool outermost(size_t x, size_t y, size_t z) const {
    return x == 0 || y == 0 || z == 0 || x + 1 == nodes_x || y + 1 == nodes_y || z + 1 == nodes_z;
  }
};

size_t node_count(double low, double high, double cell) {
  return static_cast<size_t>(std::max(2.0, std::ceil((high - low) / cell))) + 1;
}

// The layers of nodes [first, last], and the surface between them.
class Slab {
 public:
  Slab(const Grid& grid, size_t first, size_t last)
      : grid_(grid), first_(first), last_(last), layer_nodes_(grid.nodes_x * grid.nodes_y) {
    for (Layer& layer : layers_) {
      layer.values.resize(layer_nodes_);
      for (std::vector<uint32_t>& points : layer.points) points.resize(layer_nodes_);
    }
    for (std::vector<uint32_t>& points : rising_points_) points.resize(layer_nodes_);
  }

  // Points are numbered from zero. Points on edges within layer `last` belong to the next slab, which numbers
  // them first, and `surface` has no positions for them. Here they come after all others, in the order of the
  // next slab. So adding the number of points of all previous slabs gives the right number for both kinds.
  Surface extract() {
    sample(first_, layers_[0]);
    number_layer(first_, layers_[0], true);
    for (size_t z = first_; z < last_; ++z) {
      sample(z + 1, layers_[1]);
      number_rising(z);
      number_layer(z + 1, layers_[1], z + 1 < last_ || last_ + 1 == grid_.nodes_z);
      connect(z);
      std::swap(layers_[0], layers_[1]);
    }
    return std::move(surface_);
  }

 private:
  struct Layer {
    std::vector<float> values;
    std::array<std::vector<uint32_t>, 4> points;  // by direction; only 1, 2 and 3 are used
  };

  // If the field is far from zero, its value is used for all following nodes where the sign cannot change.
  void sample(size_t z, Layer& layer) const {
    const double slope_per_cell = grid_.field.slope() * grid_.cell;
    const double band = kBandCells * slope_per_cell;
    for (size_t y = 0; y < grid_.nodes_y; ++y) {
      float* row = layer.values.data() + y * grid_.nodes_x;
      for (size_t x = 0; x < grid_.nodes_x;) {
        const double value = grid_.field.at(grid_.node(x, y, z), band + kWorthSkipping * slope_per_cell);
        row[x++] = static_cast<float>(value);
        for (double sure = std::fabs(value) - band - slope_per_cell; sure > 0 && x < grid_.nodes_x;
             sure -= slope_per_cell)
          row[x++] = static_cast<float>(value);
      }
      for (size_t x = 0; x < grid_.nodes_x; ++x)
        if (grid_.field.closed && grid_.outermost(x, y, z))
          row[x] = std::max(row[x], static_cast<float>(grid_.cell));
    }
  }

  void number_layer(size_t z, Layer& layer, bool owned) {
    for_mixed_cubes(layer, layer, [&](size_t x, size_t y, unsigned) {
      for (uint8_t direction = 1; direction < 4; ++direction)
        number_edge(x, y, z, direction, layer, layer, owned);
    });
  }

  void number_rising(size_t z) {
    for_mixed_cubes(layers_[0], layers_[1], [&](size_t x, size_t y, unsigned) {
      for (uint8_t direction = 4; direction < 8; ++direction)
        number_edge(x, y, z, direction, layers_[0], layers_[1], true);
    });
  }

  void number_edge(size_t x, size_t y, size_t z, uint8_t direction, Layer& from, const Layer& to, bool owned) {
    const size_t to_x = x + (direction & 1u), to_y = y + (direction >> 1 & 1u), to_z = z + (direction >> 2);
    if (to_x == grid_.nodes_x || to_y == grid_.nodes_y) return;
    const size_t node = y * grid_.nodes_x + x;
    const float a = from.values[node];
    const float b = to.values[to_y * grid_.nodes_x + to_x];
    if ((a < 0) == (b < 0)) return;
    (direction < 4 ? from.points[direction] : rising_points_[direction - 4u])[node] = point_count_++;
    if (!owned) return;
    const double t = std::clamp(a / (a - b), kEdgeMargin, 1 - kEdgeMargin);
    const Vec3 low = grid_.node(x, y, z);
    const Vec3 point = low + (grid_.node(to_x, to_y, to_z) - low) * t;
    surface_.positions.push_back(
        {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)});
  }

  void connect(size_t z) {
    for_mixed_cubes(layers_[0], layers_[1], [&](size_t x, size_t y, unsigned inside) {
      if (x + 1 < grid_.nodes_x && y + 1 < grid_.nodes_y) connect_cube(x, y, z, inside);
    });
  }

  // Calls visit(x, y, mask of inside corners), in order, for each cube between two layers that the surface
  // passes through. Beyond the last node of a row or column, the last node is repeated.
  template <typename Visit>
  void for_mixed_cubes(const Layer& low, const Layer& high, const Visit& visit) const {
    for (size_t y = 0; y < grid_.nodes_y; ++y) {
      const size_t row = y * grid_.nodes_x, next_row = y + 1 < grid_.nodes_y ? row + grid_.nodes_x : row;
      const std::array<const float*, 4> rows = {low.values.data() + row, low.values.data() + next_row,
                                                high.values.data() + row, high.values.data() + next_row};
      const auto corners = [&](size_t x) {  // 0, 2, 4 and 6
        return unsigned{rows[0][x] < 0} | unsigned{rows[1][x] < 0} << 2 | unsigned{rows[2][x] < 0} << 4 |
               unsigned{rows[3][x] < 0} << 6;
      };
      unsigned right = corners(0);
      for (size_t x = 0; x < grid_.nodes_x; ++x) {
        const unsigned left = right;
        if (x + 1 < grid_.nodes_x) right = corners(x + 1);
        const unsigned inside = left | right << 1;
        if (inside != 0 && inside != 255) visit(x, y, inside);
      }
    }
  }

  void connect_cube(size_t x, size_t y, size_t z, unsigned inside) {
    const uint64_t diagonals =
        hash_lattice(static_cast<int64_t>(x), static_cast<int64_t>(y), static_cast<int64_t>(z), grid_.seed + 1);
    for (size_t t = 0; t < kTetrahedra.size(); ++t) {
      unsigned mask = 0;
      for (unsigned i = 0; i < 4; ++i) mask |= (inside >> kTetrahedra[t].nodes[i] & 1u) << i;
      const TetrahedronCase& polygon = kTetrahedra[t].cases[mask];
      if (polygon.corner_count == 0) continue;
      std::array<uint32_t, 4> points{};
      for (size_t i = 0; i < polygon.corner_count; ++i) {
        const auto [base, direction] = polygon.corners[i];
        const size_t node = (y + (base >> 1 & 1u)) * grid_.nodes_x + x + (base & 1u);
        points[i] =
            direction < 4 ? layers_[base >> 2].points[direction][node] : rising_points_[direction - 4u][node];
      }
      // The diagonal is random, which makes valences more irregular.
      if (polygon.corner_count == 4 && (diagonals >> t & 1))
        std::rotate(points.begin(), points.begin() + 1, points.end());
      surface_.faces.push_back({points[0], points[1], points[2]});
      if (polygon.corner_count == 4) surface_.faces.push_back({points[0], points[2], points[3]});
    }
  }

  const Grid& grid_;
  const size_t first_, last_, layer_nodes_;
  std::array<Layer, 2> layers_;                         // the lower and the upper layer
  std::array<std::vector<uint32_t>, 4> rising_points_;  // by direction - 4, for the lower layer
  uint32_t point_count_ = 0;
  Surface surface_;
};

}  // namespace

Surface extract_surface(const Field& field, double cell, uint64_t seed, const ThreadPool& pool) {
  const Grid grid = {field,
                     cell,
                     seed,
                     node_count(field.low.x, field.high.x, cell),
                     node_count(field.low.y, field.high.y, cell),
                     node_count(field.low.z, field.high.z, cell)};
  const size_t slab_count = (grid.nodes_z - 1 + kSlabLayers - 1) / kSlabLayers;
  std::vector<Surface> parts(slab_count);
  pool.for_each(slab_count, [&](size_t i) {
    const size_t first = i * kSlabLayers;
    parts[i] = Slab(grid, first, std::min(first + kSlabLayers, grid.nodes_z - 1)).extract();
  });

  std::vector<size_t> first_point(slab_count), first_face(slab_count);
  Surface surface;
  surface.cell = cell;
  size_t point_count = 0, face_count = 0;
  for (size_t i = 0; i < slab_count; ++i) {
    first_point[i] = std::exchange(point_count, point_count + parts[i].positions.size());
    first_face[i] = std::exchange(face_count, face_count + parts[i].faces.size());
  }
  surface.positions.resize(point_count);
  surface.faces.resize(face_count);
  pool.for_each(slab_count, [&](size_t i) {
    const Surface part = std::move(parts[i]);
    std::copy(part.positions.begin(), part.positions.end(),
              surface.positions.begin() + static_cast<std::ptrdiff_t>(first_point[i]));
    const auto base = static_cast<uint32_t>(first_point[i]);
    for (size_t f = 0; f < part.faces.size(); ++f)
      for (size_t c = 0; c < 3; ++c) surface.faces[first_face[i] + f][c] = part.faces[f][c] + base;
  });
  return surface;
}

}  // namespace psplit
