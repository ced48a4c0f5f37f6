// The meshes of the benchmarks: the built-in shapes, or the file that PSPLIT_BENCH_MESH names (.ply, .obj,
// .stl, .drc).
#pragma once

#include <cstdio>
#include <cstdlib>

#include "encoder/draco/mesh_files.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {

inline const char* bench_mesh_file() { return std::getenv("PSPLIT_BENCH_MESH"); }

// `all_attributes`: normals and texture coordinates as well, which a file has or has not.
inline Mesh bench_mesh(uint64_t faces, bool all_attributes) {
  const ThreadPool pool;
  Expected<Mesh> mesh = Status();
  if (const char* path = bench_mesh_file(); path != nullptr) {
    mesh = read_mesh_file(path);
  } else {
    Expected<std::vector<Mesh>> meshes =
        generate_shape({Shape::kBlob, faces, 1, all_attributes, all_attributes}, pool);
    mesh = meshes ? Expected<Mesh>(std::move(meshes->front())) : meshes.status();
  }
  if (!mesh) {
    std::fprintf(stderr, "%s\n", mesh.status().to_string().c_str());
    std::exit(static_cast<int>(mesh.status().code()));
  }
  return std::move(*mesh);
}

}  // namespace psplit
