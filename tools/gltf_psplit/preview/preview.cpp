#include "tools/gltf_psplit/preview/preview.h"

#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "src/container/stored_type.h"
#include "src/cpu/convert.h"
#include "tools/gltf_psplit/preview/picture.h"

namespace psplit {
namespace {

// The triangle primitives that the scene contains.
Expected<std::vector<PrimitiveId>> drawn_primitives(const Document& document,
                                                    std::span<const MeshInstance> instances) {
  std::vector<bool> is_drawn(document.records().meshes.size());
  for (const MeshInstance& instance : instances) is_drawn[instance.mesh] = true;
  std::vector<PrimitiveId> drawn;
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (!primitive.status.ok()) return primitive.status;
    if (is_drawn[id.mesh] && primitive.has_triangles() && primitive.accessor_of("POSITION") >= 0)
      drawn.push_back(id);
  }
  return drawn;
}

using Vectors = std::vector<std::array<float, 3>>;

// Converts from any component type (KHR_mesh_quantization). Empty if the values are not vectors of three.
Vectors vectors_of(const Attribute& attribute) {
  Vectors vectors;
  if (attribute.component_count != 3) return vectors;
  const size_t stride = attribute.stride();
  vectors.resize(attribute.values.size() / stride);
  for (size_t i = 0; i < vectors.size(); ++i)
    convert_components(reinterpret_cast<const uint8_t*>(attribute.values.data()) + i * stride,
                       stored_type(attribute.component_type), attribute.normalized, 3, DataType::kFloat32,
                       reinterpret_cast<uint8_t*>(&vectors[i]));
  return vectors;
}

// The normals of the mesh. If it has none: for each point, the mean over its faces, weighted by their areas.
Vectors normals_of(const Mesh& mesh, const Vectors& positions) {
  Vectors normals;
  if (const Attribute* stored = mesh.find("NORMAL")) normals = vectors_of(*stored);
  if (normals.size() == mesh.point_count) return normals;
  normals.assign(mesh.point_count, {});
  for (const auto& face : mesh.faces) {
    std::array<Vec3, 3> corners;
    for (size_t i = 0; i < 3; ++i) {
      const auto [x, y, z] = positions[face[i]];
      corners[i] = {x, y, z};
    }
    const Vec3 normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    for (const uint32_t point : face) {
      normals[point][0] += static_cast<float>(normal.x);
      normals[point][1] += static_cast<float>(normal.y);
      normals[point][2] += static_cast<float>(normal.z);
    }
  }
  return normals;
}

// Where the faces of each patch begin in the decoded mesh, and where the last patch ends.
Expected<std::vector<uint32_t>> face_base_of(const Document& document, PrimitiveId id, const Mesh& mesh) {
  if (document.records().primitive(id).storage() != PrimitiveStorage::kPatches)
    return std::vector<uint32_t>{0, static_cast<uint32_t>(mesh.faces.size())};
  const auto stored = stored_primitive(document, id);
  if (!stored) return stored.status();
  const auto container = open_container(stored->bytes);
  if (!container) return container.status();
  return container->face_base;
}

// Appends a primitive to its mesh. `color_count` is the number of colours in use, and grows.
Status append(const Document& document, PrimitiveId id, const Mesh& mesh, size_t& color_count,
              PictureMesh& out) {
  const Vectors positions = vectors_of(*mesh.find("POSITION"));
  if (positions.size() != mesh.point_count) return invalid_input("POSITION is not a VEC3");
  const Vectors normals = normals_of(mesh, positions);
  const auto face_base = face_base_of(document, id, mesh);
  if (!face_base) return face_base.status();
  const std::vector<Color> colors = patch_colors(mesh.faces, mesh.point_count, *face_base, color_count);
  color_count += colors.size();

  const auto first_point = static_cast<uint32_t>(out.positions.size());
  const auto first_face = static_cast<uint32_t>(out.faces.size());
  out.positions.insert(out.positions.end(), positions.begin(), positions.end());
  out.normals.insert(out.normals.end(), normals.begin(), normals.end());
  for (const auto& [a, b, c] : mesh.faces)
    out.faces.push_back({a + first_point, b + first_point, c + first_point});
  for (size_t patch = 0; patch < colors.size(); ++patch)
    out.patch_end.push_back(first_face + (*face_base)[patch + 1]);
  out.patch_color.insert(out.patch_color.end(), colors.begin(), colors.end());
  return {};
}

}  // namespace

Expected<Image> draw_preview(const Document& document, ImageSize size, const DecodeBackend& backend,
                             const ThreadPool& pool, const Progress& progress) {
  const auto instances = scene_instances(document);
  if (!instances) return instances.status();
  const auto ids = drawn_primitives(document, *instances);
  if (!ids) return ids.status();
  std::vector<Expected<Mesh>> meshes = read_primitives(document, *ids, backend, pool, progress);
  std::vector<PictureMesh> pictured(document.records().meshes.size());
  size_t color_count = 0;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (!meshes[i]) return meshes[i].status();
    const PrimitiveId id = (*ids)[i];
    if (Status status = append(document, id, *meshes[i], color_count, pictured[id.mesh]); !status.ok())
      return std::move(status).at(place_of(id));
    meshes[i] = Mesh();  // frees its memory
  }
  return draw_picture(pictured, *instances, size, pool);
}

}  // namespace psplit
