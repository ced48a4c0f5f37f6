#include "tests/support/patched_samples.h"

#include <cstdio>
#include <cstdlib>

#include "encoder/coding/quantization.h"
#include "src/container/patch_container.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/version_1.h"

namespace psplit {

namespace {

PatchedSample encode_sample(std::string name, const Mesh& mesh, std::span<const AttributeCoding> codings,
                            const EncodeOptions& options, const ThreadPool& pool) {
  Expected<EncodedMesh> encoded = encode_mesh(mesh, codings, options, pool);
  if (!encoded) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), encoded.status().to_string().c_str());
    std::abort();
  }
  PatchedSample sample{std::move(name), std::move(*encoded), {}};
  sample.requests = sample.encoded.requests;
  return sample;
}

std::vector<PatchedSample> encode_samples(bool condense, const ThreadPool& pool) {
  std::vector<NamedMesh> meshes = procedural_meshes();
  for (NamedMesh& nasty : nasty_meshes()) meshes.push_back(std::move(nasty));
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
      EncodeOptions options;
      options.patch_count = 7;
      options.encode_speed = static_cast<int>(made.size() % 11);
      options.verify = false;
      const std::string name = mesh.name + (lossless ? ", lossless" : "");
      options.condense = condense;
      options.condense_smallest = lossless;
      made.push_back(encode_sample(name, mesh.mesh, codings, options, pool));
    }
  const Mesh fine = long_edges();
  for (const int bits : {17, 21, 22}) {
    EncodeOptions options;
    options.patch_count = 3;
    options.encode_speed = bits % 4;  // all predict from positions
    options.verify = false;
    options.condense = condense;
    made.push_back(encode_sample("long edges, " + std::to_string(bits) + " bits", fine,
                                 fine_codings(fine, bits), options, pool));
  }
  return made;
}

std::vector<PatchedSample> make_patched_samples(const ThreadPool& pool) {
  std::vector<PatchedSample> made = encode_samples(false, pool);
  for (Version1Container& old : version_1_containers()) {
    PatchedSample sample{old.name + ", version 1", {}, {}};
    sample.encoded.container = std::move(old.bytes);
    sample.requests = std::move(old.requests);
    made.push_back(std::move(sample));
  }
  return made;
}

std::vector<PatchedSample> make_all_samples(const ThreadPool& pool) {
  std::vector<PatchedSample> all = patched_samples(pool);
  for (PatchedSample& sample : encode_samples(true, pool)) {
    if (sample.encoded.opened->condensed_count() == 0) continue;
    sample.name += ", condensed";
    all.push_back(std::move(sample));
  }
  return all;
}

}  // namespace

std::vector<AttributeCoding> fine_codings(const Mesh& mesh, int bits) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes)
    codings.push_back(attribute.semantic == "NORMAL" ? AttributeCoding{bits, true, {}, 0}
                                                     : fit_grid(attribute, bits).value());
  return codings;
}

std::vector<PatchedSample> patched_samples(const ThreadPool& pool) {
  static const std::vector<PatchedSample> made = make_patched_samples(pool);
  return made;
}

std::vector<PatchedSample> all_samples(const ThreadPool& pool) {
  static const std::vector<PatchedSample> made = make_all_samples(pool);
  return made;
}

bool same_bits(const Mesh& a, const Mesh& b) {
  if (a.point_count != b.point_count || a.faces != b.faces || a.attributes.size() != b.attributes.size())
    return false;
  for (size_t i = 0; i < a.attributes.size(); ++i)
    if (a.attributes[i].values != b.attributes[i].values) return false;
  return true;
}

}  // namespace psplit
