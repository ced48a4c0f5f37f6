#include "tests/support/patched_samples.h"

#include <cstdio>
#include <cstdlib>

#include "encoder/coding/quantization.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/version_1.h"

namespace psplit {

std::vector<PatchedSample> patched_samples(const ThreadPool& pool) {
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
      Expected<EncodedMesh> encoded = encode_mesh(mesh.mesh, codings, options, pool);
      if (!encoded) {
        std::fprintf(stderr, "%s: %s\n", mesh.name.c_str(), encoded.status().to_string().c_str());
        std::abort();
      }
      PatchedSample sample{mesh.name + (lossless ? ", lossless" : ""), std::move(*encoded), {}};
      sample.requests = sample.encoded.requests;
      made.push_back(std::move(sample));
    }
  for (Version1Container& old : version_1_containers()) {
    PatchedSample sample{old.name + ", version 1", {}, {}};
    sample.encoded.container = std::move(old.bytes);
    sample.requests = std::move(old.requests);
    made.push_back(std::move(sample));
  }
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
