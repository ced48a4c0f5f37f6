#include "gltf_ext/mesh_files/mesh_file.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/primitive/accessors.h"

namespace psplit {
namespace {

AccessorData accessor_data_of(Attribute attribute, uint32_t count) {
  return {attribute.component_type, attribute.component_count, attribute.normalized, count,
          std::move(attribute.values)};
}

AccessorData indices_of(Array<std::array<uint32_t, 3>> faces, uint32_t point_count) {
  constexpr uint32_t kMostShortPoints = 0xffff;  // index 65535 would restart a strip
  AccessorData data{ComponentType::kUint32, 1, false, static_cast<uint32_t>(faces.size() * 3), {}};
  if (point_count > kMostShortPoints) {
    data.values.resize(faces.size() * sizeof(faces[0]));
    if (!faces.empty()) std::memcpy(data.values.data(), faces.data(), data.values.size());
    return data;
  }
  data.component_type = ComponentType::kUint16;
  data.values.resize(faces.size() * 3 * sizeof(uint16_t));
  for (size_t i = 0; i < faces.size() * 3; ++i) {
    const auto index = static_cast<uint16_t>(faces[i / 3][i % 3]);
    std::memcpy(data.values.data() + i * sizeof(index), &index, sizeof(index));
  }
  return data;
}

size_t stored_bytes(const MeshFile& file) {
  size_t bytes = 0;
  for (const MeshFileObject& object : file.objects)
    for (const MeshFilePart& part : object.parts) {
      for (const Attribute& attribute : part.mesh.attributes)
        bytes += (attribute.stride() + 3) / 4 * 4 * part.mesh.point_count + 4;
      bytes += part.mesh.faces.size() * 12 + 4;
    }
  return bytes;
}

Json primitive_of(Document& document, MeshFilePart& part) {
  constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
  const uint32_t point_count = part.mesh.point_count;
  Json attributes = Json::object();
  for (Attribute& attribute : part.mesh.attributes) {
    const std::string semantic = attribute.semantic;
    attributes[semantic] = append_accessor(document, accessor_data_of(std::move(attribute), point_count),
                                           kArrayBuffer, semantic == "POSITION");
  }
  Json primitive{{"attributes", std::move(attributes)}};
  primitive["indices"] = append_accessor(document, indices_of(std::move(part.mesh.faces), point_count),
                                         kElementArrayBuffer, false);
  if (part.material >= 0) primitive["material"] = part.material;
  part.mesh = {};
  return primitive;
}

// Whether the text is valid UTF-8, which JSON requires.
bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

}  // namespace

void Losses::add(const std::string& singular, const std::string& plural, uint64_t count) {
  if (count == 0 && !plural.empty()) return;
  const auto [found, is_new] = counts_.try_emplace(singular, plural, 0);
  if (is_new) order_.push_back(singular);
  found->second.second += count;
}

std::vector<std::string> Losses::sentences() const {
  std::vector<std::string> sentences;
  for (const std::string& singular : order_) {
    const auto& [plural, count] = counts_.at(singular);
    sentences.push_back(count == 0   ? singular
                        : count == 1 ? "1 " + singular
                                     : std::to_string(count) + " " + plural);
  }
  return sentences;
}

void PolygonReader::add(std::span<const uint32_t> points, std::span<const Position> positions,
                        Array<std::array<uint32_t, 3>>& faces) {
  if (points.size() == 3) {
    faces.push_back({points[0], points[1], points[2]});
  } else if (points.size() < 3) {
    losses_.add("face of fewer than 3 corners is left out", "faces of fewer than 3 corners are left out");
  } else {
    for (const auto& [a, b, c] : triangulator_.triangulate(positions))
      faces.push_back({points[a], points[b], points[c]});
  }
}

void PolygonReader::finish() {
  losses_.add("polygon crosses itself or has no area: its triangles may not cover it",
              "polygons cross themselves or have no area: their triangles may not cover them",
              triangulator_.irregular_count());
}

Position position_at(const Attribute& positions, uint32_t point) {
  Position position;
  std::memcpy(position.data(), positions.values.data() + point * sizeof(position), sizeof(position));
  return position;
}

Expected<Document> document_from_mesh_file(MeshFile file) {
  std::erase_if(file.objects, [](MeshFileObject& object) {
    std::erase_if(object.parts, [](const MeshFilePart& part) { return part.mesh.faces.empty(); });
    return object.parts.empty();
  });
  if (file.objects.empty()) return unsupported("a point cloud: only triangles can be split");
  for (const MeshFileObject& object : file.objects)
    for (const MeshFilePart& part : object.parts)
      if (part.mesh.faces.size() > UINT32_MAX / 3)
        return unsupported("more faces than a glTF accessor can count");

  Document document = new_document();
  Json& json = document.json;
  Json meshes = Json::array(), nodes = Json::array(), roots = Json::array();
  json["buffers"] = Json::array({Json{{"byteLength", 0}}});
  document.buffers.resize(1);
  document.buffers[0].own().reserve(stored_bytes(file));
  for (MeshFileObject& object : file.objects) {
    Json primitives = Json::array();
    for (MeshFilePart& part : object.parts) primitives.push_back(primitive_of(document, part));
    Json mesh = Json::object(), node = Json::object();
    if (!object.name.empty()) mesh["name"] = node["name"] = as_utf8(object.name);
    mesh["primitives"] = std::move(primitives);
    node["mesh"] = meshes.size();
    roots.push_back(nodes.size());
    meshes.push_back(std::move(mesh));
    nodes.push_back(std::move(node));
  }
  json["scenes"] = Json::array({Json{{"nodes", std::move(roots)}}});
  json["nodes"] = std::move(nodes);
  json["meshes"] = std::move(meshes);
  for (auto& [name, list] : {std::pair<const char*, Json&>{"materials", file.materials},
                             {"textures", file.textures},
                             {"images", file.images}})
    if (!list.empty()) json[name] = std::move(list);
  list_extension(document, kTextureTransform, false);
  unlist_unused_extension(document, kTextureTransform);
  return document;
}

std::string as_utf8(const std::string& text) {
  if (is_utf8(text)) return text;
  std::string utf8;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      utf8 += c;
    } else {
      utf8 += static_cast<char>(0xc0 | byte >> 6);
      utf8 += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return utf8;
}

}  // namespace psplit
