// Doi and Koide, An Efficient Method of Triangulating Equi-Valued Surfaces by Using Tetrahedral Cells (1991),
// on Kuhn's subdivision of the cube: one tetrahedron for each order of the axes, along the path
//
//    corner 0 -> +first axis -> +second axis -> corner 7
//
// A corner of a cube is a mask (x = 1, y = 2, z = 4). So is the direction of a tetrahedron's edge, which goes
// from its lower corner along one, two or three axes. A grid node owns the seven edges that start at it.
#include "tools/gltf_psplit/shapes/isosurface.h"

#include <algorithm>
#include <bit>
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
};

size_t node_count(double low, double high, double cell) {
  return static_cast<size_t>(std::max(2.0, std::ceil((high - low) / cell))) + 1;
}

// The values along one row of nodes in x, as runs of equal values.
//
// Far from the surface, one value holds for many nodes. So the rows take no more space and time than there are
// places where the field was evaluated.
struct Row {
  struct Run {
    uint32_t first;
    float value;
  };
  std::vector<Run> runs;
  std::vector<uint32_t> flips;  // the nodes whose sign is not that of the node before them, ascending
  bool starts_inside = false;

  void clear() {
    runs.clear();
    flips.clear();
  }
  void append(uint32_t first, float value) {
    const bool inside = value < 0;
    if (runs.empty())
      starts_inside = inside;
    else if (inside != (runs.back().value < 0))
      flips.push_back(first);
    runs.push_back({first, value});
  }
};

// Reads a row's values at ascending nodes.
class RowValues {
 public:
  explicit RowValues(const Row& row) : runs_(row.runs) {}
  // May also go one node back.
  float at(size_t x) {
    while (at_ + 1 < runs_.size() && runs_[at_ + 1].first <= x) ++at_;
    while (runs_[at_].first > x) --at_;
    return runs_[at_].value;
  }

 private:
  const std::vector<Row::Run>& runs_;
  size_t at_ = 0;
};

// The points on the edges that start at the nodes of one row, ascending. The points of a node have consecutive
// numbers, by direction.
struct RowPoints {
  struct Node {
    uint32_t x, first_point;
    uint8_t directions;  // bit d: the edge in direction d has a point
  };
  std::vector<Node> nodes;
};

// Reads a row's points at ascending nodes.
class PointNumbers {
 public:
  explicit PointNumbers(const RowPoints& row) : nodes_(row.nodes) {}
  // The edge has a point. May also go one node back.
  uint32_t at(size_t x, uint8_t direction) {
    while (nodes_[at_].x < x) ++at_;
    while (nodes_[at_].x > x) --at_;
    const RowPoints::Node& node = nodes_[at_];
    const unsigned before = node.directions & ((1u << direction) - 1);
    return node.first_point + static_cast<uint32_t>(std::popcount(before));
  }

 private:
  const std::vector<RowPoints::Node>& nodes_;
  size_t at_ = 0;
};

// The layers of nodes [first, last], and the surface between them.
class Slab {
 public:
  Slab(const Grid& grid, size_t first, size_t last)
      : grid_(grid), first_(first), last_(last), rising_points_(grid.nodes_y) {
    for (Layer& layer : layers_) {
      layer.rows.resize(grid.nodes_y);
      layer.points.resize(grid.nodes_y);
    }
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
    std::vector<Row> rows;
    std::vector<RowPoints> points;  // on edges in directions 1, 2 and 3
  };

  void sample(size_t z, Layer& layer) const {
    for (size_t y = 0; y < grid_.nodes_y; ++y) sample_row(y, z, layer.rows[y]);
  }

  // If the field is far from zero, its value is used for all following nodes where the sign cannot change.
  void sample_row(size_t y, size_t z, Row& row) const {
    const double slope_per_cell = grid_.field.slope() * grid_.cell;
    const double band = kBandCells * slope_per_cell;
    const bool closed = grid_.field.closed;
    const bool is_side = y == 0 || z == 0 || y + 1 == grid_.nodes_y || z + 1 == grid_.nodes_z;
    const auto cell = static_cast<float>(grid_.cell);
    row.clear();
    for (size_t x = 0; x < grid_.nodes_x;) {
      const size_t first = x++;
      const double exact = grid_.field.at(grid_.node(first, y, z), band + kWorthSkipping * slope_per_cell);
      for (double sure = std::fabs(exact) - band - slope_per_cell; sure > 0 && x < grid_.nodes_x;
           sure -= slope_per_cell)
        ++x;
      // The nodes at the sides of the box are outside a closed field.
      const auto append = [&](size_t at) {
        const bool is_outside = closed && (is_side || at == 0 || at + 1 == grid_.nodes_x);
        const auto value = static_cast<float>(exact);
        row.append(static_cast<uint32_t>(at), is_outside ? std::max(value, cell) : value);
      };
      append(first);
      if (first == 0 && x > 1) append(1);
      if (x == grid_.nodes_x && x - 1 > std::max<size_t>(first, 1)) append(x - 1);
    }
  }

  void number_layer(size_t z, Layer& layer, bool owned) {
    for (size_t y = 0; y < grid_.nodes_y; ++y) number_row(y, z, layer, layer, 1, 4, layer.points[y], owned);
  }

  void number_rising(size_t z) {
    for (size_t y = 0; y < grid_.nodes_y; ++y)
      number_row(y, z, layers_[0], layers_[1], 4, 8, rising_points_[y], true);
  }

  // Numbers the points on the edges that start at the row and go in the directions [begin, end).
  void number_row(size_t y, size_t z, const Layer& from, const Layer& to, unsigned begin, unsigned end,
                  RowPoints& points, bool owned) {
    points.nodes.clear();
    const size_t next_y = std::min(y + 1, grid_.nodes_y - 1);
    RowValues here(from.rows[y]);
    std::array<RowValues, 2> there = {RowValues(to.rows[y]), RowValues(to.rows[next_y])};
    for_mixed_cubes(y, from, to, [&](size_t x, unsigned) {
      const float a = here.at(x);
      RowPoints::Node node{static_cast<uint32_t>(x), point_count_, 0};
      for (unsigned direction = begin; direction < end; ++direction) {
        const size_t to_x = x + (direction & 1u), to_y = y + (direction >> 1 & 1u), to_z = z + (direction >> 2);
        if (to_x == grid_.nodes_x || to_y == grid_.nodes_y) continue;
        const float b = there[direction >> 1 & 1u].at(to_x);
        if ((a < 0) == (b < 0)) continue;
        node.directions = static_cast<uint8_t>(node.directions | 1u << direction);
        ++point_count_;
        if (owned) add_position(grid_.node(x, y, z), grid_.node(to_x, to_y, to_z), a / (a - b));
      }
      if (node.directions != 0) points.nodes.push_back(node);
    });
  }

  void add_position(Vec3 low, Vec3 high, float crossing) {
    const double t = std::clamp(crossing, kEdgeMargin, 1 - kEdgeMargin);
    const Vec3 point = low + (high - low) * t;
    surface_.positions.push_back(
        {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)});
  }

  void connect(size_t z) {
    for (size_t y = 0; y + 1 < grid_.nodes_y; ++y) {
      CubeRow cubes{{PointNumbers(layers_[0].points[y]), PointNumbers(layers_[0].points[y + 1]),
                     PointNumbers(layers_[1].points[y]), PointNumbers(layers_[1].points[y + 1])},
                    {PointNumbers(rising_points_[y]), PointNumbers(rising_points_[y + 1])}};
      for_mixed_cubes(y, layers_[0], layers_[1], [&](size_t x, unsigned inside) {
        if (x + 1 < grid_.nodes_x) connect_cube(x, y, z, inside, cubes);
      });
    }
  }

  // Calls visit(x, mask of inside corners), in order, for each cube that the surface passes through, between
  // the rows y and y + 1 of two layers. Beyond the last node of a row or column, the last node is repeated.
  template <typename Visit>
  void for_mixed_cubes(size_t y, const Layer& low, const Layer& high, const Visit& visit) const {
    const size_t next_y = std::min(y + 1, grid_.nodes_y - 1);
    const std::array<const Row*, 4> rows = {&low.rows[y], &low.rows[next_y], &high.rows[y], &high.rows[next_y]};
    const auto past_end = static_cast<uint32_t>(grid_.nodes_x);
    std::array<size_t, 4> next{};  // for each row: the next flip
    unsigned right = 0;            // corners 0, 2, 4 and 6 of the cube at x
    for (size_t i = 0; i < 4; ++i) right |= unsigned{rows[i]->starts_inside} << (2 * i);
    const auto next_flip = [&] {
      uint32_t least = past_end;
      for (size_t i = 0; i < 4; ++i)
        if (next[i] < rows[i]->flips.size()) least = std::min(least, rows[i]->flips[next[i]]);
      return least;
    };
    for (uint32_t x = 0; x < past_end;) {
      const uint32_t flip = next_flip();
      const unsigned left = right;
      // All cubes below flip - 1 have these corners on both sides.
      const uint32_t last = flip == past_end ? past_end : flip - 1;
      if (left == 0 || left == 0x55)
        x = std::max(x, last);
      else
        for (; x < last; ++x) visit(x, left | left << 1);
      if (flip == past_end) return;
      for (size_t i = 0; i < 4; ++i)
        if (next[i] < rows[i]->flips.size() && rows[i]->flips[next[i]] == flip) {
          right ^= 1u << (2 * i);
          ++next[i];
        }
      visit(x, left | right << 1);
      x = flip;
    }
  }

  // The points of the edges of the cubes between two rows of two layers.
  struct CubeRow {
    std::array<PointNumbers, 4> flat;    // rows y and y + 1 of the lower layer, then of the upper one
    std::array<PointNumbers, 2> rising;  // rows y and y + 1
  };

  void connect_cube(size_t x, size_t y, size_t z, unsigned inside, CubeRow& cubes) {
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
        PointNumbers& row = direction < 4 ? cubes.flat[base >> 1] : cubes.rising[base >> 1 & 1u];
        points[i] = row.at(x + (base & 1u), direction);
      }
      // The diagonal is random, which makes valences more irregular.
      if (polygon.corner_count == 4 && (diagonals >> t & 1))
        std::rotate(points.begin(), points.begin() + 1, points.end());
      surface_.faces.push_back({points[0], points[1], points[2]});
      if (polygon.corner_count == 4) surface_.faces.push_back({points[0], points[2], points[3]});
    }
  }

  const Grid& grid_;
  const size_t first_, last_;
  std::array<Layer, 2> layers_;           // the lower and the upper layer
  std::vector<RowPoints> rising_points_;  // of the lower layer, on edges in directions 4 to 7
  uint32_t point_count_ = 0;
  Surface surface_;
};

}  // namespace

Status stream_surface(const Field& field, double cell, uint64_t seed, const ThreadPool& pool,
                      const std::function<Status(Surface&&)>& take) {
  const Grid grid = {field,
                     cell,
                     seed,
                     node_count(field.low.x, field.high.x, cell),
                     node_count(field.low.y, field.high.y, cell),
                     node_count(field.low.z, field.high.z, cell)};
  const size_t slab_count = (grid.nodes_z - 1 + kSlabLayers - 1) / kSlabLayers;
  std::vector<Surface> slabs(2 * static_cast<size_t>(pool.thread_count()));
  uint64_t first_point = 0;
  for (size_t begin = 0; begin < slab_count; begin += slabs.size()) {
    const size_t count = std::min(slabs.size(), slab_count - begin);
    pool.for_each(count, [&](size_t i) {
      const size_t first = (begin + i) * kSlabLayers;
      slabs[i] = Slab(grid, first, std::min(first + kSlabLayers, grid.nodes_z - 1)).extract();
    });
    for (size_t i = 0; i < count; ++i) {
      for (auto& face : slabs[i].faces)
        for (uint32_t& point : face) point += static_cast<uint32_t>(first_point);
      first_point += slabs[i].positions.size();
      if (Status status = take(std::exchange(slabs[i], {})); !status.ok()) return status;
    }
  }
  return {};
}

}  // namespace psplit
