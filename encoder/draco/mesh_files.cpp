#include "encoder/draco/mesh_files.h"

#include <draco/compression/decode.h>
#include <draco/io/mesh_io.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <fstream>
#include <new>

namespace psplit {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// glTF's type for a Draco type; 32-bit integers and doubles, which glTF attributes cannot be, become floats.
ComponentType component_type(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8: return ComponentType::kInt8;
    case draco::DT_UINT8:
    case draco::DT_BOOL: return ComponentType::kUint8;
    case draco::DT_INT16: return ComponentType::kInt16;
    case draco::DT_UINT16: return ComponentType::kUint16;
    default: return ComponentType::kFloat32;
  }
}

// A semantic that glTF allows for such data, numbered where several share a name.
std::string semantic_of(const draco::PointAttribute& source, ComponentType type, const Mesh& mesh) {
  const int components = source.num_components();
  const bool is_float = type == ComponentType::kFloat32;
  std::string prefix = "_GENERIC_";
  if (source.attribute_type() == draco::GeometryAttribute::POSITION && is_float && components == 3)
    return "POSITION";
  if (source.attribute_type() == draco::GeometryAttribute::NORMAL && is_float && components == 3 &&
      mesh.find("NORMAL") == nullptr)
    return "NORMAL";
  if (source.attribute_type() == draco::GeometryAttribute::TEX_COORD && is_float && components == 2)
    prefix = "TEXCOORD_";
  if (source.attribute_type() == draco::GeometryAttribute::COLOR && components >= 3 && components <= 4 &&
      type != ComponentType::kInt8 && type != ComponentType::kInt16)
    prefix = "COLOR_";
  int number = 0;
  while (mesh.find(prefix + std::to_string(number)) != nullptr) ++number;
  return prefix + std::to_string(number);
}

Attribute convert(const draco::PointAttribute& source, uint32_t point_count, const Mesh& mesh) {
  Attribute attribute;
  attribute.component_type = component_type(source.data_type());
  attribute.component_count = static_cast<uint8_t>(source.num_components());
  attribute.semantic = semantic_of(source, attribute.component_type, mesh);
  attribute.normalized = attribute.component_type != ComponentType::kFloat32 &&
                         (source.normalized() || attribute.semantic.starts_with("COLOR_"));
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

bool is_draco_point_cloud(std::istream& file) {
  std::array<char, 16> head{};
  file.read(head.data(), head.size());
  draco::DecoderBuffer buffer;
  buffer.Init(head.data(), static_cast<size_t>(file.gcount()));
  const auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
  return type.ok() && type.value() == draco::POINT_CLOUD;
}

bool is_ply_point_cloud(std::istream& file) {
  std::string line;
  if (!std::getline(file, line) || !line.starts_with("ply")) return false;
  while (std::getline(file, line) && !line.starts_with("element face"))
    if (line.starts_with("end_header")) return true;
  return false;
}

// libdraco's mesh readers only say that such a file is broken.
bool is_point_cloud(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string extension = lower_extension(path);
  return extension == ".drc" ? is_draco_point_cloud(file) : extension == ".ply" && is_ply_point_cloud(file);
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".ply" || extension == ".obj" || extension == ".stl" || extension == ".drc";
}

Expected<Mesh> read_mesh_file(const std::filesystem::path& path) {
  const Place place{.file = path.string()};
  std::ifstream file(path, std::ios::binary);
  file.peek();  // a folder opens, but does not read
  if (!file.is_open() || file.bad()) return io_failure("cannot be read", place);
  const Status point_cloud = unsupported("a point cloud: only triangles can be split", place);
  if (is_point_cloud(path)) return point_cloud;
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
  for (int32_t i = 0; i < source->num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *source->attribute(i);
    if (attribute.num_components() < 1 || attribute.num_components() > 16)
      return unsupported("an attribute has " + std::to_string(attribute.num_components()) + " components",
                         place);
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      if (attribute.mapped_index(draco::PointIndex(point)).value() >= attribute.size())
        return invalid_input("a vertex has no value of an attribute", place);
    mesh.attributes.push_back(convert(attribute, mesh.point_count, mesh));
    if (lower_extension(path) == ".obj" && mesh.attributes.back().semantic.starts_with("TEXCOORD_"))
      flip_v(mesh.attributes.back());
  }
  if (mesh.find("POSITION") == nullptr) return invalid_input("has no positions", place);
  return mesh;
}

}  // namespace psplit
