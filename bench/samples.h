// Encoded meshes to decode, with several speeds of Draco, patch sizes and kinds of attributes.
#pragma once

#include <string>
#include <tuple>

#include "bench/sample_meshes.h"
#include "encoder/coding/quantization.h"
#include "encoder/encode_mesh.h"
#include "src/container/decode_backend.h"

namespace psplit {

struct SampleKind {
  bool all_attributes = false;  // also normals and texture coordinates
  uint32_t patch_faces = 0;     // 0 makes the whole mesh one patch
  int speed = 0;
  bool condensed = false;

  std::string name() const {
    return std::string(all_attributes ? "positions+normals+texcoords" : "positions") + "/" +
           (patch_faces == 0 ? "whole" : std::to_string(patch_faces)) + "/speed" + std::to_string(speed) +
           (condensed ? "/condensed" : "");
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

// Quantizes positions to 14 bits, normals to 10 and texture coordinates to 12.
// Cuts the mesh, or takes the given patch of each face.
inline Sample encode_sample(const Mesh& mesh, uint32_t patch_count, int speed, bool condensed = false,
                            std::span<const uint32_t> patch_of_face = {}) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_normal = attribute.semantic == "NORMAL";
    codings.push_back(is_normal ? AttributeCoding{10, true, {}, 0}
                                : *fit_grid(attribute, attribute.semantic == "POSITION" ? 14 : 12));
  }
  EncodeOptions options;
  options.encode_speed = speed;
  options.patch_count = patch_count;
  options.verify = false;
  options.condense = condensed;
  options.patch_of_face = patch_of_face;
  Expected<EncodedMesh> encoded = encode_mesh(mesh, codings, options, ThreadPool());
  if (!encoded) give_up(encoded.status());
  Sample sample{std::move(encoded->container), std::move(encoded->requests), mesh.faces.size()};
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
