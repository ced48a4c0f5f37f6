#include "tests/support/mesh_file_seeds.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace psplit {

std::string binary_stl(std::span<const StlFacet> facets) {
  std::string text(80, ' ');
  const auto count = static_cast<uint32_t>(facets.size());
  text.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const StlFacet& facet : facets) {
    text.append(reinterpret_cast<const char*>(facet.data()), sizeof facet);
    text.append(2, '\0');
  }
  return text;
}

std::vector<std::string> mesh_file_seeds() {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string indices = "property list uchar int vertex_indices\nend_header\n";
  std::vector<std::string> seeds = {
      "mtllib a.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\nvt 1 1\nvn 0 0 "
      "1\n"
      "usemtl red\nf 1/1/1 2/2/1 3/1/1 4/2/1\no two\nusemtl blue\nf -4//1 -3//1 -2//1\nf 1 2 3\nl 1 2\n",
      "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nv -1 2 0\nf 1 2 3 4 5 6\nf 6 5 4 3 2 1\n",
      "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2 255 0 0\n",
      "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255 0.5 0.5\n1 0 0 0 0 1 0 255 0 255 0 0\n0 1 0 0 0 1 0 0 255 255 1 "
      "1\n3 0 1 2\n",
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid a\n"
      "solid b\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid b\n",
      "ply\nformat ascii 1.0\nelement vertex 4\n" + xyz +
          "property uchar red\nproperty uchar green\nproperty uchar blue\n"
          "property float s\nproperty float t\nproperty float quality\nelement face 2\n" +
          indices +
          "0 0 0 255 0 0 0 0 1\n1 0 0 0 255 0 1 0 2\n1 1 0 0 0 255 1 1 3\n0 1 0 9 9 9 0 1 4\n4 0 1 2 3\n3 0 1 "
          "2\n",
      "ply\nformat ascii 1.0\nelement vertex 3\n" + xyz +
          "property float nx\nproperty float ny\nproperty float nz\n"
          "element tristrips 1\n" +
          indices + "0 0 0 0 0 1\n1 0 0 0 0 2\n0 1 0 0 0 0\n5 0 1 2 -1 0\n"};
  std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\n" + xyz + "element face 2\n" + indices;
  std::string big =
      "ply\nformat binary_big_endian 1.0\nelement vertex 4\n" + xyz + "element face 2\n" + indices;
  std::string stl(80, ' ');
  const auto put = [](std::string& to, auto value, bool swap) {
    std::string raw(sizeof(value), '\0');
    std::memcpy(raw.data(), &value, sizeof(value));
    if (swap) std::reverse(raw.begin(), raw.end());
    to += raw;
  };
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) {
    put(binary, value, false);
    put(big, value, true);
  }
  for (const std::vector<int>& face : {std::vector{0, 1, 2, 3}, {2, 1, 0}}) {
    for (std::string* file : {&binary, &big}) *file += static_cast<char>(face.size());
    for (const int corner : face) {
      put(binary, corner, false);
      put(big, corner, true);
    }
  }
  put(stl, uint32_t{2}, false);
  for (int i = 0; i < 2; ++i) {
    for (const float value : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
      put(stl, value, false);
    stl += std::string(2, '\0');
  }
  seeds.insert(seeds.end(), {binary, big, stl});
  return seeds;
}

}  // namespace psplit
