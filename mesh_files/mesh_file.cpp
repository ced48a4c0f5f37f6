#include "mesh_files/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/mesh_view.h"

namespace psplit {
namespace {

// The corners as floats. False if floats say much less of the polygon: only then do its digits count. Otherwise
// its triangles are as in a file of floats.
bool round_corners(std::span<const PrecisePosition> polygon, std::vector<PrecisePosition>& rounded) {
  constexpr double kMostLoss = 1.0 / 256;  // of the polygon's extent
  rounded.clear();
  PositionSpread spread;
  for (const PrecisePosition& corner : polygon) {
    spread.add(corner);
    rounded.push_back({rounded_to_float(corner[0]), rounded_to_float(corner[1]), rounded_to_float(corner[2])});
  }
  return spread.loss <= kMostLoss * spread.extent();
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

void PolygonReader::add(std::span<const uint32_t> points, std::span<const PrecisePosition> positions,
                        Array<std::array<uint32_t, 3>>& faces) {
  if (points.size() == 3) {
    faces.push_back({points[0], points[1], points[2]});
  } else if (points.size() < 3) {
    losses_.add("face of fewer than 3 corners is left out", "faces of fewer than 3 corners are left out");
  } else {
    if (round_corners(positions, rounded_)) positions = rounded_;
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

bool is_finite(const Position& position) {
  return std::ranges::all_of(position, [](float value) { return std::isfinite(value); });
}

PrecisePosition precise(const Position& position) {
  return {double{position[0]}, double{position[1]}, double{position[2]}};
}

void flip_v(Array<std::byte>& texcoords) {
  for (size_t at = sizeof(float); at < texcoords.size(); at += 2 * sizeof(float)) {
    float v = 0;
    std::memcpy(&v, texcoords.data() + at, sizeof v);
    v = 1 - v;
    std::memcpy(texcoords.data() + at, &v, sizeof v);
  }
}

Status MeshBuilder::begin(std::span<const Attribute> layout, size_t expected_points, bool are_precise) {
  mesh_.attributes.assign(layout.begin(), layout.end());
  are_precise_ = are_precise;
  if (are_precise) positions_.reserve(expected_points);
  for (size_t i = are_precise ? 1 : 0; i < mesh_.attributes.size(); ++i)
    mesh_.attributes[i].values.reserve(expected_points * mesh_.attributes[i].stride());
  return {};
}

Status MeshBuilder::add_points(std::span<const Attribute> block, size_t count,
                               std::span<const PrecisePosition> positions) {
  mesh_.point_count += static_cast<uint32_t>(count);
  positions_.insert(positions_.end(), positions.begin(), positions.end());
  for (size_t i = are_precise_ ? 1 : 0; i < block.size(); ++i) {
    Array<std::byte>& values = mesh_.attributes[i].values;
    const size_t size = values.size();
    values.resize(size + block[i].values.size());
    std::memcpy(values.data() + size, block[i].values.data(), block[i].values.size());
  }
  return {};
}

Status MeshBuilder::add_faces(std::span<const std::array<uint32_t, 3>> faces) {
  if (faces.empty()) return {};
  const size_t size = mesh_.faces.size();
  mesh_.faces.resize(size + faces.size());
  std::memcpy(mesh_.faces.data() + size, faces.data(), faces.size_bytes());
  return {};
}

Expected<PrecisePosition> MeshBuilder::position(uint32_t point) {
  return are_precise_ ? positions_[point] : precise(position_at(mesh_.attributes[0], point));
}

bool has_only_points(const MeshFile& file) {
  return std::ranges::all_of(file.objects, [](const MeshFileObject& object) {
    return std::ranges::all_of(object.parts, [](const MeshFilePart& part) { return part.mesh.faces.empty(); });
  });
}

Expected<Document> document_from_mesh_file(MeshFile file, bool takes_points) {
  const bool are_points = takes_points && has_only_points(file);
  const bool has_points = std::ranges::any_of(file.objects, [](const MeshFileObject& object) {
    return std::ranges::any_of(object.parts,
                               [](const MeshFilePart& part) { return part.mesh.point_count > 0; });
  });
  std::erase_if(file.objects, [&](MeshFileObject& object) {
    std::erase_if(object.parts, [&](const MeshFilePart& part) {
      return are_points ? part.mesh.point_count == 0 : part.mesh.faces.empty();
    });
    return object.parts.empty();
  });
  if (file.objects.empty() && takes_points) return unsupported("has neither triangles nor points");
  if (file.objects.empty())
    return unsupported(has_points ? "has no triangles: only a .drc file is made of points"
                                  : "has no triangles");
  for (const MeshFileObject& object : file.objects)
    for (const MeshFilePart& part : object.parts)
      if (part.mesh.faces.size() > UINT32_MAX / 3)
        return unsupported("more faces than a glTF accessor can count");
  return document_of_objects(std::move(file), are_points);
}

Document document_of_objects(MeshFile file, bool are_points) {
  Document document = new_document();
  Json& json = document.json();
  Json meshes = Json::array(), nodes = Json::array(), roots = Json::array();
  for (MeshFileObject& object : file.objects) {
    Json primitives = Json::array();
    for (MeshFilePart& part : object.parts) {
      primitives.push_back(append_primitive(document, std::move(part.mesh), are_points));
      if (part.material >= 0) primitives.back()["material"] = part.material;
    }
    Json mesh = Json::object(), node = Json::object();
    if (!object.name.empty()) mesh["name"] = node["name"] = as_utf8(object.name);
    mesh["primitives"] = std::move(primitives);
    node["mesh"] = meshes.size();
    if (object.origin != PrecisePosition{}) node["translation"] = object.origin;
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
