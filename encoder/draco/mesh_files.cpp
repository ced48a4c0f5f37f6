#include "encoder/draco/mesh_files.h"

#include <draco/io/mesh_io.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <fstream>
#include <new>
#include <stdexcept>

#include "encoder/draco/describe_attribute.h"

namespace psplit {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

Attribute convert(const draco::PointAttribute& source, const AttributeRequest& request, uint32_t point_count) {
  Attribute attribute{
      request.semantic, request.component_type, request.component_count, request.normalized, {}};
  const size_t stride = attribute.stride();
  attribute.values.resize(stride * point_count);
  const bool copies =
      attribute.component_type != ComponentType::kFloat32 || source.data_type() == draco::DT_FLOAT32;
  for (uint32_t i = 0; i < point_count; ++i) {
    const draco::AttributeValueIndex index = source.mapped_index(draco::PointIndex(i));
    if (copies) {
      std::memcpy(attribute.values.data() + i * stride, source.GetAddress(index), stride);
    } else {
      std::array<float, 16> value{};
      source.ConvertValue<float>(index, static_cast<int8_t>(attribute.component_count), value.data());
      std::memcpy(attribute.values.data() + i * stride, value.data(), stride);
    }
  }
  return attribute;
}

// OBJ counts v from the bottom of the image, glTF from the top.
void flip_v(Attribute& texcoord) {
  for (size_t at = sizeof(float); at < texcoord.values.size(); at += 2 * sizeof(float)) {
    float v = 0;
    std::memcpy(&v, texcoord.values.data() + at, sizeof(float));
    v = 1.0f - v;
    std::memcpy(texcoord.values.data() + at, &v, sizeof(float));
  }
}

// libdraco's reader only says that such a file is broken.
bool is_ply_point_cloud(std::istream& file) {
  std::string line;
  if (!std::getline(file, line) || !line.starts_with("ply")) return false;
  while (std::getline(file, line) && !line.starts_with("element face"))
    if (line.starts_with("end_header")) return true;
  return false;
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".ply" || extension == ".obj" || extension == ".stl";
}

Expected<Mesh> read_mesh_file(const std::filesystem::path& path) {
  const Place place{.file = path.string()};
  std::ifstream file(path, std::ios::binary);
  file.peek();  // a folder opens, but does not read
  if (!file.is_open() || file.bad()) return io_failure("cannot be read", place);
  const Status point_cloud = unsupported("a point cloud: only triangles can be split", place);
  if (lower_extension(path) == ".ply" && is_ply_point_cloud(file)) return point_cloud;
  std::unique_ptr<draco::Mesh> source;
  // libdraco's readers size arrays from what the file claims.
  try {
    auto read = draco::ReadMeshFromFile(path.string());
    if (!read.ok()) {
      const std::string reason = read.status().error_msg();
      return invalid_input(reason.empty() ? "libdraco cannot read it" : "libdraco cannot read it: " + reason,
                           place);
    }
    source = std::move(read).value();
  } catch (const std::bad_alloc&) {
    return invalid_input("claims more data than memory can hold", place);
  } catch (const std::length_error&) {
    return invalid_input("claims more data than memory can hold", place);
  }
  if (source == nullptr) return invalid_input("libdraco cannot read it", place);
  if (source->num_faces() == 0) return point_cloud;

  Mesh mesh;
  mesh.point_count = source->num_points();
  for (uint32_t i = 0; i < source->num_faces(); ++i) {
    const draco::Mesh::Face& face = source->face(draco::FaceIndex(i));
    for (const draco::PointIndex& point : face)
      if (point.value() >= mesh.point_count)
        return invalid_input("a face names a vertex that is not there", place);
    mesh.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  std::vector<StreamAttribute> descriptions;
  for (int32_t i = 0; i < source->num_attributes(); ++i)
    descriptions.push_back(describe_attribute(*source->attribute(i)));
  const Expected<std::vector<AttributeRequest>> requests = gltf_attributes(descriptions);
  if (!requests) return requests.status().at(place);
  for (int32_t i = 0; i < source->num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *source->attribute(i);
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      if (attribute.mapped_index(draco::PointIndex(point)).value() >= attribute.size())
        return invalid_input("a vertex has no value of an attribute", place);
    mesh.attributes.push_back(convert(attribute, (*requests)[static_cast<size_t>(i)], mesh.point_count));
    if (lower_extension(path) == ".obj" && mesh.attributes.back().semantic.starts_with("TEXCOORD_"))
      flip_v(mesh.attributes.back());
  }
  return mesh;
}

}  // namespace psplit
