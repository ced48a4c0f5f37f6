// encode_mesh [PATCHES]: encodes a mesh from memory as a patch container, without glTF, and decodes it again.
#include <psplit/encode.h>

#include <cstdlib>
#include <cstring>
#include <iostream>
#include <psplit/psplit.hpp>

namespace {

// A sheet of columns x rows quads.
psplit::Mesh make_sheet(uint32_t columns, uint32_t rows) {
  psplit::Mesh mesh;
  std::vector<float> positions;
  for (uint32_t y = 0; y <= rows; ++y)
    for (uint32_t x = 0; x <= columns; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(columns);
      const float v = static_cast<float>(y) / static_cast<float>(rows);
      positions.insert(positions.end(), {u, v, u * v});
      if (x == columns || y == rows) continue;
      const uint32_t a = y * (columns + 1) + x, b = a + columns + 1;
      mesh.faces.push_back({a, a + 1, b + 1});
      mesh.faces.push_back({a, b + 1, b});
    }
  mesh.point_count = static_cast<uint32_t>(positions.size() / 3);
  psplit::Attribute position{"POSITION", psplit::ComponentType::kFloat32, 3, false, {}};
  position.values.resize(positions.size() * sizeof(float));
  std::memcpy(position.values.data(), positions.data(), position.values.size());
  mesh.attributes.push_back(std::move(position));
  return mesh;
}

int fail(const psplit::Status& status) {
  std::cerr << status.to_string() << "\n";
  return 3;
}

}  // namespace

int main(int argc, char** argv) {
  // By default 14 bits for each component of POSITION, and as many patches as the faces ask for.
  psplit::EncodeOptions options;
  options.storage = psplit::Storage::kContainer;
  options.patches.count = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 4;
  const psplit::ThreadPool pool;
  const psplit::Expected<psplit::EncodedMesh> encoded = psplit::encode(make_sheet(120, 100), options, pool);
  if (!encoded) return fail(encoded.status());

  // A loader knows the container's bytes, and from JSON the attributes.
  psplit::PrimitiveSource source;
  source.bytes = encoded->pieces[0].bytes;
  source.attributes = encoded->requests;
  const auto primitive = psplit::CompressedPrimitive::open(source);
  if (!primitive) return fail(primitive.status());
  std::cout << encoded->statistics.patch_count << " patches, " << source.bytes.size()
            << " bytes: " << primitive->face_count() << " triangles, " << primitive->point_count()
            << " points\n";
}
