#include "tests/support/patched_samples.h"

#include <cstdio>
#include <cstdlib>
#include <optional>

#include "encoder/coding/quantization.h"
#include "encoder/condensing/condense.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {

namespace {

// The sample with the container of its condensed streams.
PatchedSample condensed(PatchedSample sample, std::vector<uint8_t> container) {
  sample.name += ", condensed";
  sample.encoded.pieces[0].bytes = std::move(container);
  return sample;
}

std::vector<PatchedSample> encode_samples(const ThreadPool& pool) {
  std::vector<NamedMesh> meshes = all_meshes();
  meshes.push_back({"floats of every kind", floats_of_every_kind()});
  std::vector<PatchedSample> made;
  for (const NamedMesh& mesh : meshes)
    for (const bool lossless : {false, true}) {
      if (!lossless && mesh.name == "floats of every kind") continue;
      std::vector<AttributeCoding> codings;
      for (const Attribute& attribute : mesh.mesh.attributes) {
        AttributeCoding coding;
        if (!lossless && attribute.component_type == ComponentType::kFloat32)
          if (const Expected<AttributeCoding> grid = fit_grid(attribute, 12)) coding = *grid;
        codings.push_back(std::move(coding));
      }
      // Each speed, and the choice by bytes, comes in turn.
      const int way = static_cast<int>(made.size() % 12), speed = way % 11;
      made.push_back(encode_sample(
          mesh.name + (lossless ? ", lossless" : ""), mesh.mesh, codings,
          {.patch_count = 7, .encode_speed = speed, .choose_by_bytes = way != speed, .verify = false}, pool));
    }
  const Mesh fine = long_edges();
  for (const int bits : {17, 21, 22}) {
    const int speed = bits % 4;  // all predict from positions
    made.push_back(encode_sample("long edges, " + std::to_string(bits) + " bits", fine,
                                 fine_codings(fine, bits),
                                 {.patch_count = 3, .encode_speed = speed, .verify = false}, pool));
  }
  const Mesh morphing = with_targets();
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : morphing.attributes)
    codings.push_back(attribute.component_type == ComponentType::kFloat32 ? fit_grid(attribute, 12).value()
                                                                          : AttributeCoding());
  for (const int speed : {0, 5, 6})
    for (const bool by_bytes : {false, true})
      if (!by_bytes || speed == 0)
        made.push_back(encode_sample(
            "morph targets, speed " + std::to_string(speed), morphing, codings,
            {.patch_count = 3, .encode_speed = speed, .choose_by_bytes = by_bytes, .verify = false}, pool));
  // More than a word of flags, several patches; and little more than the deltas.
  for (const auto [size, targets, patches] : {std::array{14u, 40u, 3u}, {9u, 33u, 1u}, {6u, 5u, 1u}}) {
    const Mesh alike = with_alike_targets(size, targets);
    codings.clear();
    for (const Attribute& attribute : alike.attributes) codings.push_back(fit_grid(attribute, 11).value());
    made.push_back(encode_sample("alike targets, " + std::to_string(targets), alike, codings,
                                 {.patch_count = patches, .verify = false}, pool));
  }
  return made;
}

std::vector<CondensedSample> condense_samples(const ThreadPool& pool) {
  std::vector<CondensedSample> samples;
  bool smallest = false;
  for (const PatchedSample& original : patched_samples(pool)) {
    std::vector<uint8_t> container =
        condensed_container(*open_container(original.encoded.pieces[0].bytes), smallest, pool);
    if (container.empty()) continue;
    samples.push_back({original, std::move(container)});
    smallest = !smallest;
  }
  return samples;
}

std::vector<PatchedSample> make_all_samples(const ThreadPool& pool) {
  std::vector<PatchedSample> all = patched_samples(pool);
  for (const CondensedSample& sample : condensed_samples(pool))
    all.push_back(condensed(sample.original, sample.container));
  return all;
}

std::vector<PatchedSample> make_large_samples(const ThreadPool& pool) {
  std::vector<PatchedSample> made;
  for (const auto& [name, mesh] : large_grids()) {
    const AttributeCoding grid = fit_grid(mesh.attributes[0], 12).value();
    made.push_back(encode_sample(name, mesh, std::span(&grid, 1), {.patch_count = 7, .verify = false}, pool));
  }
  const PatchedSample& last = made.back();
  made.push_back(
      condensed(last, condensed_container(*open_container(last.encoded.pieces[0].bytes), false, pool)));
  return made;
}

}  // namespace

PatchedSample encode_sample(std::string name, const Mesh& mesh, std::span<const AttributeCoding> codings,
                            const StreamOptions& options, const ThreadPool& pool) {
  Expected<EncodedMesh> encoded = encode_mesh(mesh, codings, options, pool);
  Expected<Mesh> decoded =
      encoded ? decode_container(draco_backend(), encoded->pieces[0].bytes, encoded->requests, pool)
              : encoded.status();
  if (!decoded) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), decoded.status().to_string().c_str());
    std::abort();
  }
  PatchedSample sample{std::move(name), std::move(*encoded), {}, std::move(*decoded)};
  sample.requests = sample.encoded.requests;
  return sample;
}

std::vector<AttributeCoding> fine_codings(const Mesh& mesh, int bits) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes)
    codings.push_back(attribute.semantic == "NORMAL" ? AttributeCoding{bits, true, {}, 0}
                                                     : fit_grid(attribute, bits).value());
  return codings;
}

const std::vector<PatchedSample>& patched_samples(const ThreadPool& pool) {
  static const std::vector<PatchedSample> made = encode_samples(pool);
  return made;
}

std::vector<uint8_t> condensed_container(const PatchContainer& container, bool smallest,
                                         const ThreadPool& pool) {
  std::optional<CondensedContainer> condensed = condense_container(container, UINT64_MAX, smallest, pool);
  return condensed ? std::move(condensed->bytes) : std::vector<uint8_t>();
}

const std::vector<CondensedSample>& condensed_samples(const ThreadPool& pool) {
  static const std::vector<CondensedSample> made = condense_samples(pool);
  return made;
}

const std::vector<PatchedSample>& all_samples(const ThreadPool& pool) {
  static const std::vector<PatchedSample> made = make_all_samples(pool);
  return made;
}

const std::vector<PatchedSample>& large_samples(const ThreadPool& pool) {
  static const std::vector<PatchedSample> made = make_large_samples(pool);
  return made;
}

}  // namespace psplit
