#include "tests/support/procedural_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include "tests/support/sanitizers.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {

Mesh take_points(const Mesh& mesh, const std::vector<uint32_t>& points) {
  Mesh taken;
  taken.point_count = static_cast<uint32_t>(points.size());
  for (const Attribute& attribute : mesh.attributes) {
    Attribute& to = taken.attributes.emplace_back(attribute);
    const size_t stride = attribute.stride();
    to.values.resize(points.size() * stride);
    for (size_t i = 0; i < points.size(); ++i)
      std::memcpy(to.values.data() + i * stride, attribute.values.data() + points[i] * stride, stride);
  }
  return taken;
}

void append_points(Mesh& mesh, uint32_t first, uint32_t end) {
  for (Attribute& attribute : mesh.attributes) {
    const size_t stride = attribute.stride(), old = attribute.values.size();
    attribute.values.resize(old + (end - first) * stride);
    std::memcpy(attribute.values.data() + old, attribute.values.data() + first * stride,
                (end - first) * stride);
  }
  mesh.point_count += end - first;
}

void append_mesh(Mesh& to, const Mesh& mesh) {
  for (const auto& [a, b, c] : mesh.faces)
    to.faces.push_back({to.point_count + a, to.point_count + b, to.point_count + c});
  if (to.attributes.empty()) {
    to.attributes = mesh.attributes;
  } else {
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Array<std::byte>& values = mesh.attributes[i].values;
      to.attributes[i].values.insert(to.attributes[i].values.end(), values.begin(), values.end());
    }
  }
  to.point_count += mesh.point_count;
}

Mesh make_mesh(const std::vector<float>& positions, Faces faces) {
  Mesh mesh;
  mesh.point_count = static_cast<uint32_t>(positions.size() / 3);
  mesh.faces = std::move(faces);
  mesh.attributes.push_back(make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions));
  return mesh;
}

Mesh make_grid(uint32_t columns, uint32_t rows) {
  std::vector<float> positions;
  Faces faces;
  for (uint32_t y = 0; y <= rows; ++y)
    for (uint32_t x = 0; x <= columns; ++x) {
      positions.insert(positions.end(), {static_cast<float>(x), static_cast<float>(y), 0});
      if (x == columns || y == rows) continue;
      const uint32_t a = y * (columns + 1) + x, b = a + 1, c = a + columns + 1, d = c + 1;
      faces.push_back({a, b, d});
      faces.push_back({a, d, c});
    }
  return make_mesh(positions, std::move(faces));
}

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// A generator whose numbers are the same in every standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint32_t below(uint32_t bound) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<uint32_t>((state_ >> 32) * bound >> 32);
  }
  float unit() { return static_cast<float>(below(1u << 24)) / static_cast<float>(1u << 24); }

 private:
  uint64_t state_;
};

void add_float(Mesh& mesh, const std::string& semantic, uint8_t component_count,
               const std::vector<float>& values) {
  mesh.attributes.push_back(make_attribute(semantic, ComponentType::kFloat32, component_count, false, values));
}

std::vector<float> positions_of(const Mesh& mesh) { return values_of<float>(*mesh.find("POSITION")); }

// A grid in which each corner has a value that depends on its face. There is a point for each pair (vertex,
// value).
Mesh with_seams(const Mesh& mesh,
                const std::function<std::array<float, 2>(size_t face, uint32_t vertex)>& texcoord) {
  const std::vector<float> old_positions = positions_of(mesh);
  std::map<std::pair<uint32_t, std::array<float, 2>>, uint32_t> points;
  std::vector<float> positions, texcoords;
  Faces faces = mesh.faces;
  for (size_t face = 0; face < faces.size(); ++face)
    for (uint32_t& corner : faces[face]) {
      const uint32_t vertex = corner;
      const std::array<float, 2> value = texcoord(face, vertex);
      const auto [entry, is_new] = points.try_emplace({vertex, value}, static_cast<uint32_t>(points.size()));
      corner = entry->second;
      if (!is_new) continue;
      for (size_t i = 0; i < 3; ++i) positions.push_back(old_positions[size_t{3} * vertex + i]);
      texcoords.insert(texcoords.end(), value.begin(), value.end());
    }
  Mesh seamed = make_mesh(positions, std::move(faces));
  add_float(seamed, "TEXCOORD_0", 2, texcoords);
  return seamed;
}

// A band of rows x columns quads. Its last column meets the first, straight or twisted; its last row meets the
// first, or is a border.
Mesh make_surface(uint32_t columns, uint32_t rows, bool rows_close, bool twisted,
                  const std::function<std::array<double, 3>(double, double)>& place) {
  const uint32_t row_points = rows_close ? rows : rows + 1;
  std::vector<float> positions;
  for (uint32_t x = 0; x < columns; ++x)
    for (uint32_t y = 0; y < row_points; ++y)
      for (const double value : place(double{1} * x / columns, double{1} * y / rows))
        positions.push_back(static_cast<float>(value));
  const auto point = [&](uint32_t x, uint32_t y) {
    if (x == columns && twisted) y = rows - y;
    return x % columns * row_points + (rows_close ? y % rows : y);
  };
  Faces faces;
  for (uint32_t x = 0; x < columns; ++x)
    for (uint32_t y = 0; y < rows; ++y) {
      faces.push_back({point(x, y), point(x + 1, y), point(x + 1, y + 1)});
      faces.push_back({point(x, y), point(x + 1, y + 1), point(x, y + 1)});
    }
  return make_mesh(positions, std::move(faces));
}

Mesh moebius_strip() {
  return make_surface(40, 4, false, true, [](double u, double v) {
    const double half = (u * kTurn) / 2, radius = 2 + (v - 0.5) * std::cos(half);
    return std::array{radius * std::cos(u * kTurn), radius * std::sin(u * kTurn), (v - 0.5) * std::sin(half)};
  });
}

Mesh klein_bottle() {
  return make_surface(36, 20, true, true, [](double u, double v) {
    const double a = u * kTurn, b = v * kTurn;
    const double reach = 3 + std::cos(a / 2) * std::sin(b) - std::sin(a / 2) * std::sin(2 * b);
    return std::array{reach * std::cos(a), reach * std::sin(a),
                      std::sin(a / 2) * std::sin(b) + std::cos(a / 2) * std::sin(2 * b)};
  });
}

Mesh torus(uint32_t columns, uint32_t rows) {
  return make_surface(columns, rows, true, false, [](double u, double v) {
    const double reach = 2 + 0.7 * std::cos(v * kTurn);
    return std::array{reach * std::cos(u * kTurn), reach * std::sin(u * kTurn), 0.7 * std::sin(v * kTurn)};
  });
}

// A slab of size x size blocks, for odd sizes, with a hole through every second block in both directions. Its
// genus is ((size - 1) / 2)^2.
Mesh torus_chain(uint32_t size) {
  const auto solid = [&](int64_t x, int64_t y, int64_t z) {
    return x >= 0 && y >= 0 && z == 0 && x < size && y < size && !(x % 2 == 1 && y % 2 == 1);
  };
  std::map<std::array<int64_t, 3>, uint32_t> points;
  std::vector<float> positions;
  Faces faces;
  const auto point = [&](std::array<int64_t, 3> p) {
    const auto [entry, is_new] = points.try_emplace(p, static_cast<uint32_t>(points.size()));
    if (is_new)
      for (const int64_t value : p) positions.push_back(static_cast<float>(value));
    return entry->second;
  };
  for (int64_t x = 0; x < size; ++x)
    for (int64_t y = 0; y < size; ++y)
      for (size_t axis = 0; axis < 3 && solid(x, y, 0); ++axis)
        for (const int64_t side : {-1, 1}) {
          std::array<int64_t, 3> next = {x, y, 0};
          next[axis] += side;
          if (solid(next[0], next[1], next[2])) continue;
          std::array<int64_t, 3> a = {x, y, 0};
          a[axis] += side > 0;
          std::array<int64_t, 3> b = a, c = a;
          ++b[(axis + 1) % 3];
          ++c[(axis + 2) % 3];
          if (side < 0) std::swap(b, c);
          std::array<int64_t, 3> d = a;
          ++d[(axis + 1) % 3];
          ++d[(axis + 2) % 3];
          faces.push_back({point(a), point(b), point(d)});
          faces.push_back({point(a), point(d), point(c)});
        }
  return make_mesh(positions, std::move(faces));
}

Mesh cones_sharing_a_tip() {
  std::vector<float> positions = {0, 0, 0};
  Faces faces;
  for (uint32_t cone = 0; cone < 2; ++cone) {
    for (uint32_t i = 0; i < 12; ++i) {
      const double angle = i * kTurn / 12;
      positions.insert(positions.end(), {static_cast<float>(std::cos(angle)),
                                         static_cast<float>(std::sin(angle)), cone == 0 ? 1.0f : -1.0f});
      const uint32_t a = 1 + 12 * cone + i, b = 1 + 12 * cone + (i + 1) % 12;
      faces.push_back(cone == 0 ? std::array{0u, a, b} : std::array{0u, b, a});
    }
  }
  return make_mesh(positions, std::move(faces));
}

// Pages of 2 x rows triangles that share one line, like a book.
Mesh book(uint32_t pages, uint32_t rows) {
  std::vector<float> positions;
  Faces faces;
  for (uint32_t y = 0; y <= rows; ++y) positions.insert(positions.end(), {0, static_cast<float>(y), 0});
  for (uint32_t page = 0; page < pages; ++page) {
    const auto first = static_cast<uint32_t>(positions.size() / 3);
    const double angle = page * kTurn / pages;
    for (uint32_t y = 0; y <= rows; ++y) {
      positions.insert(positions.end(), {static_cast<float>(std::cos(angle)), static_cast<float>(y),
                                         static_cast<float>(std::sin(angle))});
      if (y == rows) continue;
      faces.push_back({y, first + y, first + y + 1});
      faces.push_back({y, first + y + 1, y + 1});
    }
  }
  return make_mesh(positions, std::move(faces));
}

Mesh edge_of_triangles(uint32_t count) {
  std::vector<float> positions = {0, 0, 0, 0, 1, 0};
  Faces faces;
  for (uint32_t i = 0; i < count; ++i) {
    const double angle = i * kTurn / count;
    positions.insert(positions.end(),
                     {static_cast<float>(std::cos(angle)), 0.5f, static_cast<float>(std::sin(angle))});
    faces.push_back({0, 1, 2 + i});
  }
  return make_mesh(positions, std::move(faces));
}

Mesh loose_triangles(uint32_t count) {
  Random random(3);
  std::vector<float> positions;
  Faces faces;
  for (uint32_t i = 0; i < count; ++i) {
    for (int j = 0; j < 9; ++j) positions.push_back(random.unit());
    faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return make_mesh(positions, std::move(faces));
}

Mesh triangle_soup(uint32_t points, uint32_t face_count, uint64_t seed) {
  Random random(seed);
  std::vector<float> positions;
  for (uint32_t i = 0; i < 3 * points; ++i) positions.push_back(random.unit());
  Faces faces;
  for (uint32_t i = 0; i < face_count; ++i)
    faces.push_back({random.below(points), random.below(points), random.below(points)});
  return make_mesh(positions, std::move(faces));
}

Mesh hard_edged_cube() {
  std::vector<float> positions, normals;
  Faces faces;
  for (size_t axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const auto first = static_cast<uint32_t>(positions.size() / 3);
      for (const auto& [u, v] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
        std::array<float, 3> p{}, n{};
        p[axis] = n[axis] = side;
        p[(axis + 1) % 3] = u * side;
        p[(axis + 2) % 3] = v;
        positions.insert(positions.end(), p.begin(), p.end());
        normals.insert(normals.end(), n.begin(), n.end());
      }
      faces.push_back({first, first + 1, first + 2});
      faces.push_back({first, first + 2, first + 3});
    }
  Mesh mesh = make_mesh(positions, std::move(faces));
  add_float(mesh, "NORMAL", 3, normals);
  return mesh;
}

// A grid with one attribute of every kind that a skinned asset with colours and labels may have.
Mesh every_attribute() {
  Mesh mesh = make_grid(12, 9);
  const uint32_t count = mesh.point_count;
  Random random(11);
  const auto fill = [&]<typename T>(const char* semantic, ComponentType type, uint8_t components,
                                    bool normalized, uint32_t bound, T) {
    std::vector<T> values;
    for (uint32_t i = 0; i < count * components; ++i) values.push_back(static_cast<T>(random.below(bound)));
    mesh.attributes.push_back(make_attribute(semantic, type, components, normalized, values));
  };
  const auto fill_float = [&](const char* semantic, uint8_t components) {
    std::vector<float> values;
    for (uint32_t i = 0; i < count * components; ++i) values.push_back(random.unit());
    add_float(mesh, semantic, components, values);
  };
  std::vector<float> normals, tangents;
  for (uint32_t i = 0; i < count; ++i) {
    const double angle = i * 0.37, height = -1 + 2.0 * i / count, reach = std::sqrt(1 - height * height);
    const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    normals.insert(normals.end(),
                   {static_cast<float>(reach) * c, static_cast<float>(reach) * s, static_cast<float>(height)});
    tangents.insert(tangents.end(), {-s, c, 0, i % 2 ? 1.0f : -1.0f});
  }
  add_float(mesh, "NORMAL", 3, normals);
  add_float(mesh, "TANGENT", 4, tangents);
  fill_float("TEXCOORD_0", 2);
  fill("TEXCOORD_1", ComponentType::kUint16, 2, true, 65536, uint16_t{});
  fill("COLOR_0", ComponentType::kUint8, 4, true, 256, uint8_t{});
  fill("COLOR_1", ComponentType::kUint16, 3, true, 65536, uint16_t{});
  fill("JOINTS_0", ComponentType::kUint8, 4, false, 200, uint8_t{});
  fill("JOINTS_1", ComponentType::kUint16, 4, false, 900, uint16_t{});
  fill("WEIGHTS_0", ComponentType::kUint8, 4, true, 256, uint8_t{});
  fill_float("WEIGHTS_1", 4);
  fill("_FEATURE_ID_0", ComponentType::kUint16, 1, false, 40, uint16_t{});
  fill_float("_FEATURE_ID_1", 1);
  fill("_SIGNED", ComponentType::kInt8, 2, false, 256, int8_t{});
  fill("_WIDE", ComponentType::kInt16, 3, false, 65536, int16_t{});
  return mesh;
}

Mesh colored(uint8_t components, bool wide) {
  Mesh mesh = torus(14, 9);
  Random random(components);
  const size_t count = size_t{mesh.point_count} * components;
  std::vector<uint8_t> narrow_values(count);
  std::vector<uint16_t> wide_values(count);
  for (size_t i = 0; i < count; ++i) {
    narrow_values[i] = static_cast<uint8_t>(random.below(256));
    wide_values[i] = static_cast<uint16_t>(random.below(65536));
  }
  mesh.attributes.push_back(
      wide ? make_attribute("COLOR_0", ComponentType::kUint16, components, true, wide_values)
           : make_attribute("COLOR_0", ComponentType::kUint8, components, true, narrow_values));
  return mesh;
}

Mesh scaled(Mesh mesh, float factor) {
  std::vector<float> positions = positions_of(mesh);
  for (float& value : positions) value *= factor;
  return make_mesh(positions, std::move(mesh.faces));
}

std::array<float, 2> planar(uint32_t vertex, uint32_t columns) {
  return {static_cast<float>(vertex % (columns + 1)) / 64, static_cast<float>(vertex / (columns + 1)) / 64};
}

void add_topologies(std::vector<NamedMesh>& meshes) {
  meshes.push_back({"one triangle", make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}})});
  meshes.push_back({"one quad", make_grid(1, 1)});
  meshes.push_back({"grid", make_grid(30, 20)});
  meshes.push_back({"tetrahedron", make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
                                             {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}})});
  meshes.push_back({"torus", torus(40, 24)});
  meshes.push_back({"torus chain of genus 144", torus_chain(25)});
  meshes.push_back({"moebius strip", moebius_strip()});
  meshes.push_back({"klein bottle", klein_bottle()});
  meshes.push_back({"two cones sharing a tip", cones_sharing_a_tip()});
  meshes.push_back({"three triangles on one edge", edge_of_triangles(3)});
  meshes.push_back({"five triangles on one edge", edge_of_triangles(5)});
  meshes.push_back({"book of 17 pages", book(17, 30)});
  meshes.push_back({"thousand loose triangles", loose_triangles(1000)});
  meshes.push_back({"soup over 12 points", triangle_soup(12, 300, 1)});
  meshes.push_back({"soup over 400 points", triangle_soup(400, 1500, 2)});

  Mesh turned = make_grid(20, 20);
  for (size_t f = 0; f < turned.faces.size(); f += 3) std::swap(turned.faces[f][1], turned.faces[f][2]);
  meshes.push_back({"inconsistent orientation", std::move(turned)});

  // Every second square of a board, so that each inner vertex joins two fans that share no edge.
  Mesh board = make_grid(16, 16);
  Faces squares;
  for (size_t f = 0; f < board.faces.size(); ++f)
    if ((f / 2 % 16 + f / 32) % 2 == 0) squares.push_back(board.faces[f]);
  board.faces = std::move(squares);
  meshes.push_back({"chessboard of squares that touch at corners", std::move(board)});
}

// Gives each face three points of its own, so that most positions occur several times.
Mesh unshared(const Mesh& mesh) {
  const std::vector<float> shared = positions_of(mesh);
  std::vector<float> positions;
  Faces faces;
  for (const auto& face : mesh.faces) {
    const auto first = static_cast<uint32_t>(positions.size() / 3);
    for (const uint32_t point : face)
      for (size_t i = 0; i < 3; ++i) positions.push_back(shared[size_t{3} * point + i]);
    faces.push_back({first, first + 1, first + 2});
  }
  return make_mesh(positions, std::move(faces));
}

void add_degenerates(std::vector<NamedMesh>& meshes) {
  meshes.push_back({"duplicate points", unshared(make_grid(10, 10))});

  Mesh index_degenerate = make_grid(8, 8);
  for (uint32_t i = 0; i < 20; ++i) {
    const uint32_t a = i * 3, b = a + 1;
    index_degenerate.faces.insert(index_degenerate.faces.begin() + i * 5, i % 4 == 0   ? std::array{a, a, a}
                                                                          : i % 4 == 1 ? std::array{a, a, b}
                                                                          : i % 4 == 2 ? std::array{a, b, a}
                                                                                       : std::array{b, a, a});
  }
  meshes.push_back({"index-degenerate faces", std::move(index_degenerate)});

  // Points 0 and 1 of the middle row are at the same place, but their texture coordinates differ.
  Mesh position_degenerate = make_grid(6, 6);
  std::vector<float> positions = positions_of(position_degenerate), texcoords;
  for (uint32_t p = 0; p < position_degenerate.point_count; ++p) {
    texcoords.insert(texcoords.end(), {positions[3 * p] / 6, positions[3 * p + 1] / 6});
    if (p % 5 == 1) std::copy_n(positions.begin() + 3 * (p - 1), 3, positions.begin() + 3 * p);
  }
  position_degenerate = make_mesh(positions, std::move(position_degenerate.faces));
  meshes.push_back({"position-degenerate faces of equal points", position_degenerate});
  add_float(position_degenerate, "TEXCOORD_0", 2, texcoords);
  meshes.push_back({"position-degenerate faces of different points", std::move(position_degenerate)});

  Mesh repeated = make_grid(9, 9);
  const Faces once = repeated.faces;
  for (size_t f = 0; f < once.size(); f += 2) {
    const auto [a, b, c] = once[f];
    if (f % 3 == 0) repeated.faces.push_back({a, b, c});
    if (f % 3 == 1) repeated.faces.push_back({b, c, a});
    if (f % 5 == 0) repeated.faces.push_back({a, c, b});
  }
  meshes.push_back({"repeated faces", std::move(repeated)});
  meshes.push_back(
      {"one face five times, both ways round",
       make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}, {1, 2, 0}, {0, 2, 1}, {2, 1, 0}, {0, 1, 2}})});

  Mesh unused = make_grid(7, 7);
  for (auto& face : unused.faces)
    for (uint32_t& point : face) point += 5;
  std::vector<float> more = {9, 9, 9, 8, 8, 8, 9, 9, 9, 7, 7, 7, 6, 6, 6};
  const std::vector<float> used = positions_of(unused);
  more.insert(more.end(), used.begin(), used.end());
  more.insert(more.end(), {5, 5, 5, 0, 0, 0});
  meshes.push_back({"unused points", make_mesh(more, std::move(unused.faces))});

  meshes.push_back(
      {"only degenerate faces", make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 0, 1}, {2, 2, 2}, {1, 2, 1}})});
  meshes.push_back({"all points in one place", scaled(make_grid(5, 5), 0)});

  Mesh labelled = scaled(make_grid(5, 5), 0);
  std::vector<uint16_t> labels(labelled.point_count);
  for (size_t i = 0; i < labels.size(); ++i) labels[i] = static_cast<uint16_t>(i);
  labelled.attributes.push_back(make_attribute("_FEATURE_ID_0", ComponentType::kUint16, 1, false, labels));
  meshes.push_back({"all points in one place, told apart by a label", std::move(labelled)});
}

void add_extremes(std::vector<NamedMesh>& meshes) {
  meshes.push_back({"huge coordinates", scaled(torus(20, 12), 1e30f)});
  meshes.push_back({"tiny coordinates", scaled(torus(20, 12), 1e-30f)});
  std::vector<float> far = positions_of(torus(20, 12));
  for (float& value : far) value += 4e6f;
  meshes.push_back({"small object far from the origin", make_mesh(far, torus(20, 12).faces)});
  Mesh zeros = scaled(torus(20, 12), -0.0f);  // zeros of both signs; all points are at one place
  meshes.push_back({"zeros of both signs in one place", std::move(zeros)});
  std::vector<float> signs = positions_of(make_grid(6, 6));
  for (size_t i = 2; i < signs.size(); i += 6) signs[i] = -0.0f;
  meshes.push_back({"negative zero", make_mesh(signs, make_grid(6, 6).faces)});
}

void add_attributes(std::vector<NamedMesh>& meshes) {
  meshes.push_back({"hard-edged cube", hard_edged_cube()});
  meshes.push_back({"every attribute", every_attribute()});
  for (const uint8_t components : {uint8_t{3}, uint8_t{4}})
    for (const bool wide : {false, true})
      meshes.push_back(
          {std::string("colours, ") + (wide ? "16 bits x " : "8 bits x ") + std::to_string(components),
           colored(components, wide)});
  Mesh zero_normals = make_grid(4, 4);
  std::vector<float> normals;
  for (uint32_t p = 0; p < zero_normals.point_count; ++p)
    normals.insert(normals.end(), {0, 0, p % 3 == 0 ? 0.0f : p % 3 == 1 ? 1.0f : -1.0f});
  add_float(zero_normals, "NORMAL", 3, normals);
  meshes.push_back({"normals of no length", std::move(zero_normals)});

  const Mesh grid = make_grid(24, 24);
  meshes.push_back({"texture seams across a grid", with_seams(grid, [](size_t face, uint32_t vertex) {
                      const size_t column = face / 2 % 24, row = face / 48;
                      std::array<float, 2> value = planar(vertex, 24);
                      value[0] += static_cast<float>(column / 7 + 5 * (row / 9));
                      return value;
                    })});
  meshes.push_back({"chessboard of texture seams", with_seams(grid, [](size_t face, uint32_t vertex) {
                      std::array<float, 2> value = planar(vertex, 24);
                      value[1] += static_cast<float>((face / 2 + face / 48) % 2);
                      return value;
                    })});
  // Two colours alternate around each vertex, so that sectors of the same value do not touch.
  meshes.push_back({"equal values in separate sectors", with_seams(grid, [](size_t face, uint32_t) {
                      return std::array{static_cast<float>((face / 2 + face / 48) % 2), 0.5f};
                    })});
  meshes.push_back(
      {"equal values in sectors of a fan",
       with_seams(
           make_mesh({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0, -1, 0, 0, -1, -1, 0, 0, -1, 0, 1, -1, 0},
                     {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 7}, {0, 7, 8}, {0, 8, 1}}),
           [](size_t face, uint32_t vertex) {
             return std::array{vertex == 0 ? static_cast<float>(face % 2) : static_cast<float>(vertex), 0.0f};
           })});
  meshes.push_back({"every corner a seam", with_seams(torus(12, 8), [](size_t face, uint32_t vertex) {
                      return std::array{static_cast<float>(face), static_cast<float>(vertex)};
                    })});
  meshes.push_back(
      {"cones sharing a tip, with seams", with_seams(cones_sharing_a_tip(), [](size_t face, uint32_t vertex) {
         return std::array{static_cast<float>(face / 4), static_cast<float>(vertex)};
       })});
  meshes.push_back({"book with seams", with_seams(book(7, 12), [](size_t face, uint32_t vertex) {
                      return std::array{static_cast<float>(face / 24 % 3), static_cast<float>(vertex)};
                    })});
  meshes.push_back({"moebius strip with seams", with_seams(moebius_strip(), [](size_t face, uint32_t vertex) {
                      return std::array{static_cast<float>(face / 50), static_cast<float>(vertex)};
                    })});
  meshes.push_back({"soup with seams", with_seams(triangle_soup(60, 400, 5), [](size_t face, uint32_t vertex) {
                      return std::array{static_cast<float>(face % 3), static_cast<float>(vertex)};
                    })});
}

std::vector<NamedMesh> generate_shapes() {
  struct Sample {
    const char* name;
    ShapeOptions options;
  };
  const Sample samples[] = {{"terrain", {Shape::kTerrain, 12000, 1, true, true}},
                            {"bare terrain", {Shape::kTerrain, 5000, 2, false, false}},
                            {"blob", {Shape::kBlob, 12000, 3, true, true}},
                            {"bare blob", {Shape::kBlob, 5000, 4, false, false}},
                            {"gyroid", {Shape::kGyroid, 20000, 5, true, false}},
                            {"textured gyroid", {Shape::kGyroid, 9000, 6, false, true}},
                            {"scene", {Shape::kScene, 30000, 7, true, true}}};
  const ThreadPool pool;
  std::vector<NamedMesh> meshes;
  for (const Sample& sample : samples) {
    ShapeOptions options = sample.options;
    if (kHasSanitizers) options.faces /= 5;
    Expected<std::vector<Mesh>> shapes = generate_shape(options, pool);
    if (!shapes) throw std::runtime_error(shapes.status().to_string());
    for (size_t i = 0; i < shapes->size(); ++i)
      meshes.push_back({shapes->size() == 1 ? sample.name : sample.name + (" " + std::to_string(i)),
                        std::move((*shapes)[i])});
  }
  return meshes;
}

}  // namespace

Mesh floats_of_every_kind() {
  Mesh mesh = make_grid(24, 18);
  constexpr uint32_t kBits[] = {0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007fffff, 0x807fffff,
                                0x00800000, 0x80800000, 0x7f7fffff, 0xff7fffff, 0x3f7fffff, 0xbf800001};
  constexpr uint32_t kNotFinite[] = {0x7f800000, 0xff800000, 0x7fc00000, 0xffc12345, 0x7f800001, 0xffbfffff};
  std::mt19937 random(1);
  const auto fill = [&](Attribute& attribute, bool finite) {
    for (size_t at = 0; at < attribute.values.size(); at += 4) {
      auto bits = static_cast<uint32_t>(random());
      if (random() % 2 == 0) bits = kBits[random() % std::size(kBits)];
      if (!finite && random() % 4 == 0) bits = kNotFinite[random() % std::size(kNotFinite)];
      if (finite && (bits & 0x7f800000) == 0x7f800000) bits ^= 0x40000000;
      std::memcpy(attribute.values.data() + at, &bits, 4);
    }
  };
  fill(mesh.attributes[0], true);
  // A subnormal makes each point different.
  for (uint32_t point = 0; point < mesh.point_count; ++point)
    std::memcpy(mesh.attributes[0].values.data() + 12 * size_t{point} + 8, &point, 4);
  const auto add = [&](const char* semantic, uint8_t components) {
    mesh.attributes.push_back({semantic, ComponentType::kFloat32, components, false, {}});
    mesh.attributes.back().values.resize(size_t{4} * components * mesh.point_count);
    fill(mesh.attributes.back(), false);
  };
  add("NORMAL", 3);
  add("TANGENT", 4);
  add("TEXCOORD_0", 2);
  add("COLOR_0", 4);
  add("_ANY", 1);
  return mesh;
}

Mesh long_edges() {
  Mesh mesh = make_grid(12, 9);
  std::mt19937 random(7);
  const auto fill = [&](Attribute& attribute) {
    attribute.values.resize(attribute.stride() * mesh.point_count);
    for (size_t at = 0; at < attribute.values.size(); at += 4) {
      const float value = std::clamp(static_cast<float>(random()) / 2e9f - 0.5f, 0.0f, 1.0f);
      std::memcpy(attribute.values.data() + at, &value, 4);
    }
  };
  fill(mesh.attributes[0]);
  const auto add = [&](const char* semantic, uint8_t components) {
    fill(mesh.attributes.emplace_back(Attribute{semantic, ComponentType::kFloat32, components, false, {}}));
  };
  add("NORMAL", 3);
  add("TEXCOORD_0", 2);
  add("_ANY", 4);
  return mesh;
}

Mesh with_targets() {
  // The texture has two charts, which meet at column 7.
  Mesh mesh = with_seams(make_grid(14, 11), [](size_t face, uint32_t vertex) -> std::array<float, 2> {
    const auto x = static_cast<float>(vertex % 15), y = static_cast<float>(vertex / 15);
    return {(face / 2 % 14 < 7 ? 0.1f : 2.5f) + 0.03f * x, 0.07f * y};
  });
  const std::vector<float> positions = positions_of(mesh), texture = values_of<float>(*mesh.find("TEXCOORD_0"));
  std::vector<float> everywhere, in_one_place, of_texture, with_own_seams;
  std::vector<int8_t> integers;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const float x = positions[3 * i], y = positions[3 * i + 1];
    const bool is_right = texture[2 * i] > 2;
    const float bump = std::max(0.0f, 9 - (x - 4) * (x - 4) - (y - 5) * (y - 5));
    everywhere.insert(everywhere.end(), {0.1f * y, 0.02f * x * y, -0.3f});
    in_one_place.insert(in_one_place.end(), {0, 0.01f * bump, 0.1f * bump});
    of_texture.insert(of_texture.end(), {is_right ? 0.5f : 0.25f, 0.01f * y, 0});
    with_own_seams.push_back(0.01f * static_cast<float>(i));
    for (const int part : {1, 0, 2})
      integers.push_back(static_cast<int8_t>(part * static_cast<int>(2 * x - y)));
  }
  add_float(mesh, name_of_target(0, "POSITION"), 3, everywhere);
  add_float(mesh, name_of_target(0, "NORMAL"), 3, of_texture);
  add_float(mesh, name_of_target(2, "POSITION"), 3, in_one_place);
  mesh.attributes.push_back(
      make_attribute(name_of_target(2, "NORMAL"), ComponentType::kInt8, 3, true, integers));
  add_float(mesh, name_of_target(2, "_OWN"), 1, with_own_seams);
  return mesh;
}

Mesh with_alike_targets(uint32_t size, uint32_t targets) {
  Mesh mesh = make_grid(size, size);
  std::vector<float> positions = positions_of(mesh);
  for (size_t i = 0; i < positions.size(); i += 3)
    positions[i + 2] = 0.05f * positions[i] * positions[i] - 0.1f * positions[i] * positions[i + 1];
  mesh.attributes[0] = make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions);
  std::mt19937 random(5);
  const auto below = [&](uint32_t bound) { return static_cast<float>(random() % bound); };
  std::vector<std::vector<float>> deltas;
  for (uint32_t t = 0; t < targets; ++t) {
    std::vector<float>& of = deltas.emplace_back(positions.size());
    const float x = below(size + 1), y = below(size + 1), reach = 1 + below(size / 2 + 1);
    for (size_t i = 0; i < of.size(); i += 3) {
      const float dx = positions[i] - x, dy = positions[i + 1] - y;
      const float bump = std::max(0.0f, reach * reach - dx * dx - dy * dy) / (reach * reach);
      of[i] = 0.3f * bump, of[i + 1] = -0.1f * bump * dx, of[i + 2] = bump + 0.001f * below(5) * bump;
      if (t % 3 == 2)
        for (size_t k = i; k < i + 3; ++k) of[k] = (t % 2 == 0 ? -0.5f : 1.5f) * deltas[t - 2][k];
    }
    add_float(mesh, name_of_target(t, "POSITION"), 3, of);
  }
  return mesh;
}

const std::vector<NamedMesh>& nasty_meshes() {
  static const std::vector<NamedMesh> made = [] {
    std::vector<NamedMesh> meshes;
    add_topologies(meshes);
    add_degenerates(meshes);
    add_extremes(meshes);
    add_attributes(meshes);
    return meshes;
  }();
  return made;
}

const std::vector<NamedMesh>& large_grids() {
  static const std::vector<NamedMesh> made = {{"65,535 points", make_grid(254, 256)},
                                              {"65,536 points", make_grid(255, 255)}};
  return made;
}

const std::vector<NamedMesh>& procedural_meshes() {
  static const std::vector<NamedMesh> made = generate_shapes();
  return made;
}

const std::vector<NamedMesh>& all_meshes() {
  static const std::vector<NamedMesh> made = [] {
    std::vector<NamedMesh> meshes = procedural_meshes();
    meshes.insert(meshes.end(), nasty_meshes().begin(), nasty_meshes().end());
    return meshes;
  }();
  return made;
}

}  // namespace psplit
