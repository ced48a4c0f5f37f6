// The assets that the tests of this folder start from, and functions that all of them use.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "tests/support/compare_meshes.h"
#include "tests/support/document_options.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {

inline const ThreadPool& test_pool() {
  static const ThreadPool pool(2);
  return pool;
}

// libdraco, or psplit's own decoder in a build without it.
inline DecodeBackend reference_backend() { return has_draco() ? draco_backend() : cpu_backend(); }

inline Json& primitive_of(Document& document, size_t mesh = 0, size_t primitive = 0) {
  return document.json()["meshes"][mesh]["primitives"][primitive];
}

inline Json& accessor_of(Document& document, const char* semantic, size_t mesh = 0, size_t primitive = 0) {
  const Json& holder = primitive_of(document, mesh, primitive);
  const Json& index = holder.contains(semantic) ? holder[semantic] : holder["attributes"][semantic];
  return document.json()["accessors"][index.get<size_t>()];
}

inline Expected<Mesh> read(const Document& document, size_t mesh = 0, size_t primitive = 0) {
  return read_primitive(document, {mesh, primitive}, reference_backend(), test_pool());
}

// All morph targets, first of the container, then of accessors, each in the order of their numbers.
inline std::vector<MorphAttribute> read_all_targets(const Document& document, size_t mesh = 0,
                                                    size_t primitive = 0) {
  Mesh decoded = must(read(document, mesh, primitive));
  std::vector<MorphAttribute> morphs = take_targets(decoded);
  for (MorphAttribute& morph : must(read_morph_targets(document, {mesh, primitive}, decoded.point_count)))
    morphs.push_back(std::move(morph));
  std::ranges::stable_sort(morphs, {}, &MorphAttribute::target);
  return morphs;
}

// Appends a mesh with 32-bit indices.
inline void add_mesh(Document& document, const Mesh& mesh) {
  Json attributes = Json::object();
  for (const Attribute& attribute : mesh.attributes)
    attributes[attribute.semantic] = append_accessor(document,
                                                     {attribute.component_type, attribute.component_count,
                                                      attribute.normalized, mesh.point_count, attribute.values},
                                                     34962, attribute.semantic == "POSITION");
  AccessorData indices{ComponentType::kUint32, 1, false, static_cast<uint32_t>(3 * mesh.faces.size()), {}};
  indices.values.resize(12 * mesh.faces.size());
  std::memcpy(indices.values.data(), mesh.faces.data(), indices.values.size());
  const Json primitive = {{"attributes", attributes},
                          {"indices", append_accessor(document, indices, 34963, false)}};
  document.json()["meshes"].push_back({{"primitives", Json::array({primitive})}});
}

// Options that split every primitive, however small.
inline Expected<std::vector<PrimitiveReport>> encode(Document& document, EncodeDocumentOptions options = {}) {
  options.patches.always = true;
  return encode_document(document, options, reference_backend(), test_pool());
}

// The validator's findings, a line each.
inline std::string findings_of(const Document& document, const DecodeBackend& backend) {
  std::string text;
  for (const Finding& finding : validate_document(document, backend, test_pool()))
    text += finding.rule + ": " + finding.message + "\n";
  return text;
}

inline Status decode(Document& document) { return decode_document(document, reference_backend(), test_pool()); }

// How often `text` occurs in the JSON.
inline size_t count_in(const Document& document, const std::string& text) {
  const std::string json = document.json().dump();
  size_t count = 0;
  for (size_t at = json.find(text); at != std::string::npos; at = json.find(text, at + 1)) ++count;
  return count;
}

template <typename T>
AccessorData make_data(ComponentType type, uint8_t components, const std::vector<T>& values,
                       bool normalized = false) {
  AccessorData data{type, components, normalized, static_cast<uint32_t>(values.size() / components), {}};
  data.values.resize(values.size() * sizeof(T));
  std::memcpy(data.values.data(), values.data(), data.values.size());
  return data;
}

// A wavy grid with an attribute of every kind of glTF.
inline Mesh rich_mesh(uint32_t columns = 12, uint32_t rows = 9) {
  Mesh mesh = make_grid(columns, rows);
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  std::vector<float> normal, tangent, uv, color, weights0, weights1, temperature, matrix;
  std::vector<uint16_t> uv_integers, joints1, feature;
  std::vector<uint8_t> color_bytes, joints0;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const auto t = static_cast<float>(i) / static_cast<float>(mesh.point_count);
    positions[3 * i + 2] = std::sin(9 * t);
    const std::array<float, 8> raw = {t, 1 - t, t * t, 0, 0.3f * t, 0, 0.1f, 0};
    float sum = 0;
    for (const float weight : raw) sum += weight;
    for (size_t c = 0; c < 4; ++c) {
      weights0.push_back(raw[c] / sum);
      weights1.push_back(raw[4 + c] / sum);
      color.push_back(c == 3 ? 1 : t * (0.3f + 0.2f * static_cast<float>(c)));
      color_bytes.push_back(static_cast<uint8_t>(i * (c + 1)));
      joints0.push_back(static_cast<uint8_t>(i % (c + 3)));
      joints1.push_back(static_cast<uint16_t>(300 + i % (c + 2)));
    }
    normal.insert(normal.end(), {std::sin(t), 0, std::cos(t)});
    tangent.insert(tangent.end(), {std::cos(t), 0, -std::sin(t), i % 5 == 0 ? -1.0f : 1.0f});
    uv.insert(uv.end(), {3 * t, -t});
    uv_integers.insert(uv_integers.end(), {static_cast<uint16_t>(i * 31), static_cast<uint16_t>(i * 17)});
    temperature.push_back(100 * t - 20);
    feature.push_back(static_cast<uint16_t>(i / 7));
    for (int k = 0; k < 9; ++k) matrix.push_back(t * static_cast<float>(k));
  }
  const auto floats = [](const char* semantic, uint8_t components, const std::vector<float>& values) {
    return make_attribute(semantic, ComponentType::kFloat32, components, false, values);
  };
  mesh.attributes = {floats("POSITION", 3, positions),
                     floats("NORMAL", 3, normal),
                     floats("TANGENT", 4, tangent),
                     floats("TEXCOORD_0", 2, uv),
                     make_attribute("TEXCOORD_1", ComponentType::kUint16, 2, true, uv_integers),
                     floats("COLOR_0", 4, color),
                     make_attribute("COLOR_1", ComponentType::kUint8, 4, true, color_bytes),
                     make_attribute("JOINTS_0", ComponentType::kUint8, 4, false, joints0),
                     floats("WEIGHTS_0", 4, weights0),
                     make_attribute("JOINTS_1", ComponentType::kUint16, 4, false, joints1),
                     floats("WEIGHTS_1", 4, weights1),
                     floats("_TEMPERATURE", 1, temperature),
                     make_attribute("_FEATURE_ID_0", ComponentType::kUint16, 1, false, feature),
                     floats("_MATRIX", 9, matrix)};
  return mesh;
}

}  // namespace psplit
