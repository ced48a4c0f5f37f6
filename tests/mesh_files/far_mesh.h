// A grid of cells of a centimetre, 5400 kilometres away from the origin of its coordinates, as texts of mesh
// files.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace psplit {

inline constexpr std::array<double, 3> kFarCorner = {500000.123, 5400000.456, 300.789};
inline constexpr double kFarStep = 0.01;

inline std::vector<std::array<double, 3>> far_points(int side = 30) {
  std::vector<std::array<double, 3>> points;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      points.push_back({kFarCorner[0] + kFarStep * x, kFarCorner[1] + kFarStep * y,
                        kFarCorner[2] + 0.05 * std::sin(0.03 * x) * std::cos(0.05 * y)});
  return points;
}

inline std::vector<std::array<uint32_t, 3>> far_faces(int side = 30) {
  std::vector<std::array<uint32_t, 3>> faces;
  const auto at = [&](int x, int y) { return static_cast<uint32_t>(x * side + y); };
  for (int x = 0; x + 1 < side; ++x)
    for (int y = 0; y + 1 < side; ++y) {
      faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
      faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return faces;
}

inline std::string far_digits(const std::array<double, 3>& point) {
  char text[100];
  std::snprintf(text, sizeof(text), "%.4f %.4f %.4f", point[0], point[1], point[2]);
  return text;
}

// `normals`: some of them have no direction.
inline std::string far_ply(bool is_binary, int side = 30, bool normals = false) {
  const auto points = far_points(side);
  const auto faces = far_faces(side);
  std::string text = std::string("ply\nformat ") + (is_binary ? "binary_big_endian" : "ascii") +
                     " 1.0\nelement vertex " + std::to_string(points.size()) + "\n";
  for (const char* name : {"x", "y", "z"}) text += "property double " + std::string(name) + "\n";
  for (const char* name : {"nx", "ny", "nz"})
    if (normals) text += "property float " + std::string(name) + "\n";
  text += "element face " + std::to_string(faces.size()) +
          "\nproperty list uchar uint vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    for (size_t i = sizeof value; i-- > 0;) text += raw[i];
  };
  for (size_t i = 0; i < points.size(); ++i) {
    const float normal = i % 7 == 0 ? 0.0f : 1.0f;
    if (is_binary) {
      for (const double value : points[i]) put(value);
      if (normals)
        for (const float value : {0.0f, 0.0f, normal}) put(value);
    } else {
      text += far_digits(points[i]) + (normals ? i % 7 == 0 ? " 0 0 0" : " 0 0 1" : "") + "\n";
    }
  }
  for (const auto& face : faces) {
    if (is_binary) {
      text += '\3';
      for (const uint32_t point : face) put(point);
    } else {
      text +=
          "3 " + std::to_string(face[0]) + " " + std::to_string(face[1]) + " " + std::to_string(face[2]) + "\n";
    }
  }
  return text;
}

inline std::string far_obj(int side = 30) {
  std::string text;
  for (const auto& point : far_points(side)) text += "v " + far_digits(point) + "\n";
  for (const auto& [a, b, c] : far_faces(side))
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
  return text;
}

inline std::string far_off() {
  const auto points = far_points();
  const auto faces = far_faces();
  std::string text = "OFF\n" + std::to_string(points.size()) + " " + std::to_string(faces.size()) + " 0\n";
  for (const auto& point : points) text += far_digits(point) + "\n";
  for (const auto& [a, b, c] : faces)
    text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  return text;
}

// `normals`: some facets have none.
inline std::string far_stl(int side = 30, bool normals = false) {
  const auto points = far_points(side);
  std::string text = "solid far\n";
  size_t number = 0;
  for (const auto& face : far_faces(side)) {
    text += std::string("facet normal 0 0 ") + (normals && number++ % 5 == 0 ? "0" : "1") + "\nouter loop\n";
    for (const uint32_t point : face) text += "vertex " + far_digits(points[point]) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid far\n";
}

}  // namespace psplit
