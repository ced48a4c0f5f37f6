// same_mesh ORIGINAL DECODED [--lossless]: are the triangles of two assets the same, primitive by primitive, up
// to order and the default quantization? Exits 0 or says where they first differ and exits 7.
#include <array>
#include <cmath>
#include <cstring>
#include <iostream>

#include "encoder/draco/draco_backend.h"
#include "encoder/draco/mesh_files.h"
#include "encoder/encode_mesh.h"
#include "gltf_ext/convert.h"
#include "tests/support/compare_meshes.h"

namespace {

using namespace psplit;  // NOLINT: a program of one file

Expected<Document> read_asset(const std::string& path) {
  if (!is_mesh_file(path)) return read_document(path);
  const Expected<Mesh> mesh = read_mesh_file(path);
  if (!mesh) return mesh.status();
  return document_from_mesh(*mesh);
}

bool all_unit(const Attribute& attribute) {
  for (size_t at = 0; at + 12 <= attribute.values.size(); at += 12) {
    std::array<float, 3> v{};
    std::memcpy(v.data(), attribute.values.data() + at, 12);
    if (!(std::fabs(std::hypot(double{v[0]}, double{v[1]}, double{v[2]}) - 1.0) <= 1e-2)) return false;
  }
  return true;
}

Tolerance default_tolerance(const Attribute& attribute) {
  if (attribute.component_type != ComponentType::kFloat32) return exact_tolerance();
  const std::string& name = attribute.semantic;
  if (name == "NORMAL" && attribute.component_count == 3)
    return all_unit(attribute) ? octahedral_tolerance(10) : exact_tolerance();
  const int bits = name == "POSITION" ? 14 : name.starts_with("COLOR_") ? 8 : 12;
  const Expected<AttributeCoding> grid = fit_grid(attribute, bits);
  return grid ? grid_tolerance(bits, grid->origin, grid->range) : exact_tolerance();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 1;
  const bool lossless = argc > 3 && std::string(argv[3]) == "--lossless";
  const Expected<Document> original = read_asset(argv[1]), decoded = read_asset(argv[2]);
  if (!original || !decoded) {
    std::cerr << (original ? decoded : original).status().to_string() << "\n";
    return 3;
  }
  const ThreadPool pool(1);
  for (const PrimitiveId id : all_primitives(*original)) {
    const Expected<Mesh> a = read_primitive(*original, id, draco_backend(), pool);
    const Expected<Mesh> b = read_primitive(*decoded, id, draco_backend(), pool);
    const std::string where =
        "mesh " + std::to_string(id.mesh) + ", primitive " + std::to_string(id.primitive) + ": ";
    if (a.ok() != b.ok()) {
      std::cerr << where << (a ? b : a).status().to_string() << "\n";
      return 7;
    }
    if (!a) continue;
    std::vector<Tolerance> tolerances;
    for (const Attribute& attribute : a->attributes)
      tolerances.push_back(lossless ? exact_tolerance() : default_tolerance(attribute));
    if (const std::string difference = compare_meshes(*a, *b, tolerances); !difference.empty()) {
      std::cerr << where << difference << "\n";
      return 7;
    }
  }
  return 0;
}
