#include "gltf_ext/mesh_files/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gltf_ext/primitive/accessors.h"

namespace psplit {
namespace {

using Vector = std::array<float, 3>;

template <typename T>
T load(const Attribute& attribute, size_t index) {
  T value;
  std::memcpy(&value, attribute.values.data() + index * sizeof(T), sizeof(T));
  return value;
}

template <typename T>
void store(Attribute& attribute, size_t index, const T& value) {
  std::memcpy(attribute.values.data() + index * sizeof(T), &value, sizeof(T));
}

double squared_length(const std::array<double, 3>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

// For each point whose flag in `points` is set, the sum of the area vectors of its faces.
std::vector<std::array<double, 3>> normals_of_faces(const Mesh& mesh, const Attribute& positions,
                                                    const std::vector<uint32_t>& slot_of_point,
                                                    size_t slot_count) {
  std::vector<std::array<double, 3>> sums(slot_count);
  for (const auto& face : mesh.faces) {
    if (std::ranges::all_of(face, [&](uint32_t point) { return slot_of_point[point] == 0; })) continue;
    std::array<Position, 3> p;
    for (size_t i = 0; i < 3; ++i) p[i] = position_at(positions, face[i]);
    std::array<double, 3> normal;
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      normal[axis] = (double{p[1][u]} - p[0][u]) * (double{p[2][v]} - p[0][v]) -
                     (double{p[1][v]} - p[0][v]) * (double{p[2][u]} - p[0][u]);
    }
    for (const uint32_t point : face)
      if (const uint32_t slot = slot_of_point[point]; slot > 0)
        for (size_t axis = 0; axis < 3; ++axis) sums[slot - 1][axis] += normal[axis];
  }
  return sums;
}

Vector unit(const std::array<double, 3>& v, double square) {
  const double scale = 1 / std::sqrt(square);
  return {static_cast<float>(v[0] * scale), static_cast<float>(v[1] * scale), static_cast<float>(v[2] * scale)};
}

// Returns whether any normal has a direction.
bool repair_normals(Mesh& mesh, Attribute& normals, const Attribute& positions, Losses& losses) {
  constexpr double kUnit = 2e-3;  // more than the rounding error of numbers with three decimals
  std::vector<uint32_t> zeros, slot_of_point;
  uint64_t changed = 0;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const Vector value = load<Vector>(normals, i);
    const std::array<double, 3> v{value[0], value[1], value[2]};
    const double square = squared_length(v);
    if (!std::isfinite(square) || square == 0) {
      zeros.push_back(i);
    } else if (std::fabs(square - 1) > kUnit) {
      store(normals, i, unit(v, square));
      ++changed;
    }
  }
  if (zeros.size() == mesh.point_count) return false;
  losses.add("normal was not of unit length: normalized", "normals were not of unit length: normalized",
             changed);
  if (zeros.empty()) return true;
  losses.add("normal had no direction: made from the faces around it",
             "normals had no direction: made from the faces around them", zeros.size());
  slot_of_point.assign(mesh.point_count, 0);
  for (size_t slot = 0; slot < zeros.size(); ++slot)
    slot_of_point[zeros[slot]] = static_cast<uint32_t>(slot + 1);
  const auto sums = normals_of_faces(mesh, positions, slot_of_point, zeros.size());
  for (size_t slot = 0; slot < zeros.size(); ++slot) {
    const double square = squared_length(sums[slot]);
    store(normals, zeros[slot], square > 0 ? unit(sums[slot], square) : Vector{0, 0, 1});
  }
  return true;
}

void repair_floats(Attribute& attribute, Losses& losses) {
  const bool is_color = attribute.semantic.starts_with("COLOR_");
  const size_t count = attribute.values.size() / sizeof(float);
  uint64_t not_finite = 0, clamped = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto value = load<float>(attribute, i);
    if (!std::isfinite(value)) {
      ++not_finite;
      store(attribute, i, 0.0f);
    } else if (is_color && (value < 0 || value > 1)) {
      ++clamped;
      store(attribute, i, std::clamp(value, 0.0f, 1.0f));
    }
  }
  const std::string of = " of " + attribute.semantic;
  losses.add("number" + of + " was not finite: it is 0 now",
             "numbers" + of + " were not finite: they are 0 now", not_finite);
  losses.add("number" + of + " was not between 0 and 1: clamped",
             "numbers" + of + " were not between 0 and 1: clamped", clamped);
}

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

Position position_at(const Attribute& positions, uint32_t point) { return load<Position>(positions, point); }

void repair_values(MeshFile& file) {
  for (MeshFileObject& object : file.objects)
    for (MeshFilePart& part : object.parts) {
      Mesh& mesh = part.mesh;
      const auto named = [&](const char* semantic) {
        return std::ranges::find(mesh.attributes, semantic, &Attribute::semantic);
      };
      const auto positions = named("POSITION"), normals = named("NORMAL");
      const auto end = mesh.attributes.end();
      for (Attribute& attribute : mesh.attributes)
        if (attribute.component_type == ComponentType::kFloat32 && attribute.semantic != "POSITION" &&
            attribute.semantic != "NORMAL")
          repair_floats(attribute, file.losses);
      if (normals == end || positions == end || repair_normals(mesh, *normals, *positions, file.losses))
        continue;
      mesh.attributes.erase(normals);
      file.losses.say("no normal has a direction: all are left out");
    }
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
  document.buffers[0].reserve(stored_bytes(file));
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
