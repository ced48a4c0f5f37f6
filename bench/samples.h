// The meshes of the benchmarks: the built-in shapes, or the file that PSPLIT_BENCH_MESH names (.ply, .obj,
// .stl). Benchmarks decode these meshes in several speeds of Draco, patch sizes and kinds of attributes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "encoder/coding/quantization.h"
#include "encoder/encode_mesh.h"
#include "encoder/libdraco/draco_backend.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {

[[noreturn]] inline void give_up(const Status& status) {
  std::fprintf(stderr, "%s\n", status.to_string().c_str());
  std::exit(1);
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

inline std::vector<std::array<float, 3>> positions_of(const Mesh& mesh) {
  std::vector<std::array<float, 3>> positions(mesh.point_count);
  const Attribute* attribute = mesh.find("POSITION");
  if (attribute->stride() != sizeof positions[0]) give_up(unsupported("positions that are not three floats"));
  std::memcpy(positions.data(), attribute->values.data(), attribute->values.size());
  return positions;
}

template <size_t kComponents>
void add_attribute(Mesh& mesh, const char* semantic,
                   const std::vector<std::array<float, kComponents>>& values) {
  Attribute attribute{semantic, ComponentType::kFloat32, kComponents, false, {}};
  attribute.values.resize(values.size() * attribute.stride());
  std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  mesh.attributes.push_back(std::move(attribute));
}

// Smooth normals: the sum of the faces' normals, weighted by area.
inline void add_normals(Mesh& mesh) {
  const std::vector<std::array<float, 3>> at = positions_of(mesh);
  std::vector<std::array<float, 3>> normals(mesh.point_count);
  for (const auto& [a, b, c] : mesh.faces)
    for (size_t k = 0; k < 3; ++k) {
      const size_t y = (k + 1) % 3, z = (k + 2) % 3;
      const float across =
          (at[b][y] - at[a][y]) * (at[c][z] - at[a][z]) - (at[b][z] - at[a][z]) * (at[c][y] - at[a][y]);
      for (const uint32_t point : {a, b, c}) normals[point][k] += across;
    }
  for (std::array<float, 3>& normal : normals) {
    const float length = std::hypot(normal[0], normal[1], normal[2]);
    if (length > 0)
      for (float& value : normal) value /= length;
    else
      normal = {0, 0, 1};
  }
  add_attribute(mesh, "NORMAL", normals);
}

// Longitude and latitude around the middle, both from 0 to 1. There is a seam where longitude starts again:
// points there are doubled, and the faces use the copies, whose values exceed 1.
inline void add_texcoords(Mesh& mesh) {
  const std::vector<std::array<float, 3>> at = positions_of(mesh);
  std::array<float, 3> low = at[0], high = at[0];
  for (const std::array<float, 3>& position : at)
    for (size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], position[k]);
      high[k] = std::max(high[k], position[k]);
    }
  std::vector<std::array<float, 2>> texcoords;
  for (const std::array<float, 3>& position : at) {
    const float x = position[0] - (low[0] + high[0]) / 2, y = position[1] - (low[1] + high[1]) / 2,
                z = position[2] - (low[2] + high[2]) / 2;
    const float pi = std::numbers::pi_v<float>;
    texcoords.push_back({std::atan2(z, x) / (2 * pi) + 0.5f, std::atan2(y, std::hypot(x, z)) / pi + 0.5f});
  }
  std::map<uint32_t, uint32_t> copies;
  for (std::array<uint32_t, 3>& face : mesh.faces) {
    const auto [least, most] =
        std::minmax({texcoords[face[0]][0], texcoords[face[1]][0], texcoords[face[2]][0]});
    if (most - least <= 0.5f) continue;
    for (uint32_t& point : face)
      if (texcoords[point][0] < 0.5f)
        point =
            copies.try_emplace(point, mesh.point_count + static_cast<uint32_t>(copies.size())).first->second;
  }
  std::vector<uint32_t> source_of_copy(copies.size());
  for (const auto& [source, copy] : copies) source_of_copy[copy - mesh.point_count] = source;
  for (const uint32_t source : source_of_copy) {
    for (Attribute& attribute : mesh.attributes) {
      const auto value = attribute.values.begin() + static_cast<ptrdiff_t>(source * attribute.stride());
      const std::vector<std::byte> copy(value, value + static_cast<ptrdiff_t>(attribute.stride()));
      attribute.values.insert(attribute.values.end(), copy.begin(), copy.end());
    }
    texcoords.push_back({texcoords[source][0] + 1, texcoords[source][1]});
  }
  mesh.point_count = static_cast<uint32_t>(texcoords.size());
  add_attribute(mesh, "TEXCOORD_0", texcoords);
}

// Has positions only, or also normals and texture coordinates, which are computed if a file has none.
inline Mesh bench_mesh(uint64_t faces, bool all_attributes) {
  const ThreadPool pool;
  const char* path = std::getenv("PSPLIT_BENCH_MESH");
  if (path == nullptr) {
    auto meshes = generate_shape({Shape::kBlob, faces, 1, all_attributes, all_attributes}, pool);
    if (!meshes) give_up(meshes.status());
    return std::move(meshes->front());
  }
  const Expected<Asset> asset = read_asset(path, describe_draco_stream);
  if (!asset) give_up(asset.status());
  Expected<Mesh> read = read_primitive(asset->document, {0, 0}, draco_backend(), pool);
  if (!read) give_up(read.status());
  Mesh mesh = std::move(*read);
  std::erase_if(mesh.attributes, [&](const Attribute& attribute) {
    return attribute.semantic != "POSITION" &&
           (!all_attributes || (attribute.semantic != "NORMAL" && attribute.semantic != "TEXCOORD_0"));
  });
  if (all_attributes && mesh.find("NORMAL") == nullptr) add_normals(mesh);
  if (all_attributes && mesh.find("TEXCOORD_0") == nullptr) add_texcoords(mesh);
  return mesh;
}

struct SampleKind {
  bool all_attributes = false;  // also normals and texture coordinates
  uint32_t patch_faces = 0;     // 0 makes the whole mesh one patch
  int speed = 0;
  bool condensed = false;

  std::string attributes() const { return all_attributes ? "positions+normals+texcoords" : "positions"; }
  std::string name() const {
    return attributes() + "/" + (patch_faces == 0 ? "whole" : std::to_string(patch_faces)) + "/speed" +
           std::to_string(speed) + (condensed ? "/condensed" : "");
  }
  auto operator<=>(const SampleKind&) const = default;
};

inline std::vector<SampleKind> sample_kinds() {
  std::vector<SampleKind> kinds;
  for (const bool all_attributes : {false, true})
    for (const uint32_t patch_faces : {4800u, 1200u, 440u, 0u})
      for (const int speed : {0, 5, 7, 10})
        for (const bool condensed : {false, true})
          kinds.push_back({all_attributes, patch_faces, speed, condensed});
  return kinds;
}

struct Sample {
  std::vector<uint8_t> container;
  std::vector<AttributeRequest> requests;
  uint64_t face_count = 0;
};

// Positions have 14 bits, normals 10 and texture coordinates 12.
inline std::vector<AttributeCoding> bench_codings(const Mesh& mesh) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_normal = attribute.semantic == "NORMAL";
    codings.push_back(is_normal ? AttributeCoding{10, true, {}, 0}
                                : *fit_grid(attribute, attribute.semantic == "POSITION" ? 14 : 12));
  }
  return codings;
}

inline Sample encode_sample(const Mesh& mesh, uint32_t patch_count, int speed, bool condensed = false) {
  StreamOptions options;
  options.encode_speed = speed;
  options.patch_count = patch_count;
  options.verify = false;
  options.condense = condensed;
  Expected<EncodedMesh> encoded = encode_mesh(mesh, bench_codings(mesh), options, ThreadPool());
  if (!encoded) give_up(encoded.status());
  Sample sample{std::move(encoded->pieces[0].bytes), std::move(encoded->requests), mesh.faces.size()};
  return sample;
}

// Encodes the sample at its first use, on all threads, and keeps it.
inline const Sample& sample(const SampleKind& kind) {
  static std::map<SampleKind, Sample> samples;
  const auto [at, is_new] = samples.try_emplace(kind);
  if (is_new) {
    const Mesh mesh = bench_mesh(400'000, kind.all_attributes);
    const auto faces = static_cast<uint32_t>(mesh.faces.size());
    at->second =
        encode_sample(mesh, kind.patch_faces == 0 ? 1 : faces / kind.patch_faces, kind.speed, kind.condensed);
  }
  return at->second;
}

}  // namespace psplit
