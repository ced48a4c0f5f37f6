// Morph targets as attributes of the patches.
#include <cmath>
#include <map>
#include <set>

#include "gltf_ext/json/json_fields.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

constexpr uint32_t kSheetColumns = 20, kSheetRows = 15;

// A sheet with normals, of which the right half has others, so that there is a seam in the middle.
Mesh sheet() {
  Mesh mesh = make_grid(kSheetColumns, kSheetRows);
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  std::vector<uint32_t> twins(mesh.point_count, 0);
  for (uint32_t y = 0; y <= kSheetRows; ++y) {
    const uint32_t point = y * (kSheetColumns + 1) + kSheetColumns / 2;
    twins[point] = mesh.point_count++;
    for (size_t c = 0; c < 3; ++c) positions.push_back(positions[3 * point + c]);
  }
  for (auto& face : mesh.faces) {
    float sum = 0;
    for (const uint32_t point : face) sum += positions[3 * point];
    for (uint32_t& point : face)
      if (sum > 3.0f * kSheetColumns / 2 && twins[point] != 0) point = twins[point];
  }
  std::vector<float> normals;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const bool is_right = positions[3 * i] > kSheetColumns / 2 || i >= (kSheetColumns + 1) * (kSheetRows + 1);
    normals.insert(normals.end(), {is_right ? 0.6f : 0.0f, 0, is_right ? 0.8f : 1.0f});
    positions[3 * i + 2] = 0.3f * std::sin(0.4f * positions[3 * i]);
  }
  mesh.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions),
                     make_attribute("NORMAL", ComponentType::kFloat32, 3, false, normals)};
  return mesh;
}

// Three targets: deltas of a few points, with normals that differ at the seam; small integers everywhere;
// zeros.
Document morphing_sheet() {
  const Mesh mesh = sheet();
  const std::vector<float> positions = values_of<float>(mesh.attributes[0]),
                           normals = values_of<float>(mesh.attributes[1]);
  std::vector<float> bump(3 * mesh.point_count, -0.0f), tilt(3 * mesh.point_count, 0), zeros(tilt);
  std::vector<int8_t> integers(3 * mesh.point_count);
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const float distance = std::hypot(positions[3 * i] - 10, positions[3 * i + 1] - 6);
    integers[3 * i] = static_cast<int8_t>(i % 5 - 2);
    if (distance > 4) continue;
    bump[3 * i + 2] = (4 - distance) / 7;
    tilt[3 * i] = (4 - distance) * normals[3 * i] / 9;
  }
  Document document = document_from_mesh(mesh);
  const auto append = [&](const auto& values, ComponentType type = ComponentType::kFloat32,
                          bool normalized = false) {
    return append_accessor(document, make_data(type, 3, values, normalized), 34962, true);
  };
  const int64_t of_bump = append(bump), of_tilt = append(tilt), of_zeros = append(zeros),
                of_integers = append(integers, ComponentType::kInt8, true);
  primitive_of(document)["targets"] = Json::array({{{"POSITION", of_bump}, {"NORMAL", of_tilt}},
                                                   {{"POSITION", of_bump}, {"NORMAL", of_integers}},
                                                   {{"POSITION", of_zeros}}});
  return document;
}

EncodeDocumentOptions options_with(uint64_t patches, Condense condense = Condense::kNo) {
  EncodeDocumentOptions options;
  options.patches.count = patches;
  options.condense = condense;
  options.morph_targets = MorphTargets::kPatches;
  return options;
}

const Json& extension_of(const Document& document, size_t mesh = 0) {
  return document.json()["meshes"][mesh]["primitives"][0]["extensions"]["PSPLIT_mesh_draco_patches"];
}

// For each position, rounded, and normal the deltas of the points there.
using Deltas = std::map<std::vector<int>, std::multiset<std::vector<float>>>;
Deltas deltas_by_place(const Document& document, const DecodeBackend& backend) {
  Mesh mesh = must(read_primitive(document, {0, 0}, backend, test_pool()));
  std::vector<MorphAttribute> morphs = take_targets(mesh);
  for (MorphAttribute& morph : must(read_morph_targets(document, {0, 0}, mesh.point_count)))
    morphs.push_back(std::move(morph));
  std::ranges::stable_sort(morphs, [](const MorphAttribute& a, const MorphAttribute& b) {
    return std::pair(a.target, a.semantic) < std::pair(b.target, b.semantic);
  });
  const std::vector<float> positions = values_of<float>(*mesh.find("POSITION")),
                           normals = values_of<float>(*mesh.find("NORMAL"));
  Deltas deltas;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    std::vector<float> all;
    for (const MorphAttribute& morph : morphs)
      for (size_t c = 0; c < 3; ++c) {
        const std::byte* const value = morph.data.values.data();
        if (morph.data.component_type == ComponentType::kInt8) {
          all.push_back(static_cast<float>(static_cast<int8_t>(value[3 * i + c])));
          continue;
        }
        float delta = 0;
        std::memcpy(&delta, value + (3 * i + c) * sizeof delta, sizeof delta);
        all.push_back(delta);
      }
    deltas[{static_cast<int>(std::lround(positions[3 * i])),
            static_cast<int>(std::lround(positions[3 * i + 1])), normals[3 * i] > 0.3f ? 1 : 0}]
        .insert(all);
  }
  return deltas;
}

// Deltas are off by no more than half a step of what they change, and zeros stay zeros.
void expect_near(const Deltas& wanted, const Deltas& found) {
  ASSERT_EQ(wanted.size(), found.size());
  const double position_step = kSheetColumns / 16383.0, normal_step = 2 / 1023.0;
  size_t moved = 0;
  for (const auto& [place, deltas] : wanted) {
    ASSERT_EQ(found.at(place).size(), 1u);
    ASSERT_EQ(deltas.size(), 1u);
    const std::vector<float>&expected = *deltas.begin(), &actual = *found.at(place).begin();
    ASSERT_EQ(expected.size(), actual.size());
    for (size_t k = 0; k < expected.size(); ++k) {
      // NORMAL 0, POSITION 0, NORMAL 1 in integers, POSITION 1, POSITION 2
      const double step = k < 3 ? normal_step : k / 3 == 2 ? 0 : position_step;
      EXPECT_NEAR(expected[k], actual[k], step / 2 + 1e-7);
      if (expected[k] == 0) {
        EXPECT_EQ(actual[k], 0);
        EXPECT_FALSE(std::signbit(actual[k]));
      }
      moved += expected[k] != 0;
    }
  }
  EXPECT_GT(moved, 100u);
}

TEST(TargetsInPatches, AreOffByHalfAStepOfWhatTheyChange) {
  const Document input = morphing_sheet();
  const Deltas wanted = deltas_by_place(input, cpu_backend());
  for (const uint64_t patches : {1u, 4u})
    for (const Condense condense : {Condense::kNo, Condense::kFast, Condense::kSmallest})
      for (const int speed : {0, 5, 7}) {
        Document document = input;
        EncodeDocumentOptions options = options_with(patches, condense);
        options.encode_speed = speed;
        options.choose_by_bytes = condense == Condense::kSmallest;
        const auto reports = must(encode_document(document, options, reference_backend(), test_pool()));
        ASSERT_EQ(reports[0].skipped, "");
        const Json& extension = extension_of(document);
        ASSERT_EQ(extension["targets"].size(), 2u);
        const Json &positions = extension["targets"]["POSITION"], &normals = extension["targets"]["NORMAL"];
        ASSERT_EQ(positions.size(), 3u);
        ASSERT_EQ(normals.size(), 3u);
        EXPECT_EQ(positions[2], -1);
        EXPECT_EQ(normals[2], -1);
        // Equal deltas are stored once.
        EXPECT_EQ(positions[0], positions[1]);
        EXPECT_EQ((std::set<Json>{extension["attributes"]["POSITION"], extension["attributes"]["NORMAL"],
                                  positions[0], normals[0], normals[1]}),
                  (std::set<Json>{0, 1, 2, 3, 4}));
        EXPECT_EQ(findings_of(document, reference_backend()), "");
        EXPECT_EQ(findings_of(document, cpu_backend()), "");
        const Deltas by_reference = deltas_by_place(document, reference_backend());
        expect_near(wanted, by_reference);
        EXPECT_EQ(by_reference, deltas_by_place(document, cpu_backend()));
        must(decode(document));
        EXPECT_EQ(count_in(document, "PSPLIT"), 0u);
        EXPECT_EQ(deltas_by_place(document, cpu_backend()), by_reference);
      }
}

TEST(TargetsInPatches, HaveTheSeamsOfOthers) {
  Document document = morphing_sheet();
  must(encode_document(document, options_with(1), reference_backend(), test_pool()));
  const StoredPrimitive stored = must(stored_primitive(document, {0, 0}));
  const PatchContainer container = must(open_container(stored.bytes));
  // NORMAL has seams, and the deltas of normals have the same seams. Deltas of POSITION have none.
  const std::span<const uint8_t> stream = container.streams[0];
  const size_t kind = 11;  // the version, the methods and the flags of the header
  core::ByteReader reader({stream.data(), stream.size()});
  reader.skip(kind + 1);
  reader.varint(), reader.varint();
  EXPECT_EQ(reader.u8(), 1);  // attribute data
}

TEST(TargetsInPatches, EncodingAgainChangesNothing) {
  for (const Condense condense : {Condense::kNo, Condense::kFast}) {
    Document document = morphing_sheet();
    must(encode_document(document, options_with(3, condense), reference_backend(), test_pool()));
    const Deltas once = deltas_by_place(document, cpu_backend());
    must(decode(document));
    must(encode_document(document, options_with(3, condense), reference_backend(), test_pool()));
    EXPECT_TRUE(extension_of(document).contains("targets"));
    EXPECT_EQ(deltas_by_place(document, cpu_backend()), once);
  }
}

// Where the option says nothing, containers have them, and stock Draco has sparse accessors beside it.
TEST(TargetsInPatches, AreTheDefaultOfContainers) {
  for (const bool is_split : {false, true})
    for (const MorphTargets wanted :
         {MorphTargets::kAsFits, MorphTargets::kKeep, MorphTargets::kSparse, MorphTargets::kPatches}) {
      Document document = morphing_sheet();
      EncodeDocumentOptions options = options_with(is_split ? 4 : 0);
      options.morph_targets = wanted;
      must(encode_document(document, options, reference_backend(), test_pool()));
      const bool in_patches = wanted == MorphTargets::kPatches || (is_split && wanted == MorphTargets::kAsFits);
      EXPECT_EQ(count_in(document, "\"targets\":{"), in_patches ? 1u : 0u);
      EXPECT_EQ(count_in(document, "KHR_draco_mesh_compression") > 0, !is_split && !in_patches);
    }
  Document document = morphing_sheet();
  EncodeDocumentOptions options = options_with(4);
  options.compat = Compat::kKhr;
  must(encode_document(document, options, reference_backend(), test_pool()));
  EXPECT_EQ(count_in(document, "\"targets\":{"), 0u);
}

TEST(TargetsInPatches, ExactFloatsStayInAccessors) {
  Document document = morphing_sheet();
  EncodeDocumentOptions options = options_with(4);
  options.lossless = true;
  const Deltas before = deltas_by_place(document, cpu_backend());
  must(encode_document(document, options, reference_backend(), test_pool()));
  EXPECT_EQ(extension_of(document)["targets"], (Json{{"NORMAL", {-1, 2, -1}}}));
  EXPECT_EQ(deltas_by_place(document, cpu_backend()), before);
  // Nor has a grid any place for these.
  document = morphing_sheet();
  const size_t index = primitive_of(document)["targets"][0]["NORMAL"].get<size_t>();
  const float infinite = INFINITY;
  const AccessorRecord& accessor = document.records().accessor(static_cast<int64_t>(index));
  const ViewRecord& view = document.records().view(accessor.elements.view);
  std::memcpy(document.buffers[0].own().data() + view.range.offset, &infinite, sizeof infinite);
  must(encode_document(document, options_with(4), reference_backend(), test_pool()));
  EXPECT_EQ(extension_of(document)["targets"]["NORMAL"][0], -1);
  EXPECT_NE(extension_of(document)["targets"]["POSITION"][0], -1);
}

// Points that are equal but for deltas that no grid holds.
TEST(TargetsInPatches, ExactDeltasKeepPointsApart) {
  const Mesh grid = make_grid(9, 9);
  std::vector<float> corners_of_faces;
  Faces own_corners;
  for (const auto& face : grid.faces) {
    const auto first = static_cast<uint32_t>(corners_of_faces.size() / 3);
    own_corners.push_back({first, first + 1, first + 2});
    for (const uint32_t point : face)
      for (size_t c = 0; c < 3; ++c)
        corners_of_faces.push_back(values_of<float>(grid.attributes[0])[3 * size_t{point} + c]);
  }
  const Mesh mesh = make_mesh(corners_of_faces, own_corners);
  std::vector<float> deltas(3 * mesh.point_count);
  for (uint32_t i = 0; i < mesh.point_count; ++i)
    deltas[3 * i] = i % 3 == 0 ? 1e30f : static_cast<float>(i % 7);
  Document document = document_from_mesh(mesh);
  primitive_of(document)["targets"] = Json::array(
      {{{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 34962, true)}}});
  const auto faces_of = [](const Document& of) {
    const Mesh decoded = must(read(of));
    const AccessorData moved = std::move(read_all_targets(of).at(0).data);
    const std::vector<float> positions = values_of<float>(*decoded.find("POSITION"));
    std::multiset<std::vector<float>> faces;
    for (const auto& face : decoded.faces) {
      std::multiset<std::pair<float, float>> corners;
      for (const uint32_t point : face) {
        float delta = 0;
        std::memcpy(&delta, moved.values.data() + 12 * point, sizeof delta);
        corners.emplace(std::round(positions[3 * point] + 100 * positions[3 * point + 1]), delta);
      }
      std::vector<float> all;
      for (const auto& [place, delta] : corners) all.insert(all.end(), {place, delta});
      faces.insert(all);
    }
    return faces;
  };
  const auto before = faces_of(document);
  must(encode_document(document, options_with(2), reference_backend(), test_pool()));
  EXPECT_EQ(count_in(document, "\"targets\":{"), 0u);
  EXPECT_EQ(faces_of(document), before);
}

// If one primitive of a mesh is split, the targets of all of them are rounded.
TEST(TargetsInPatches, OfPrimitivesThatShareAGridAreStoredAlike) {
  Document document = morphing_sheet();
  const Mesh large = make_grid(120, 120);
  std::vector<float> deltas(3 * large.point_count, 0.25f);
  const int64_t positions = append_accessor(
      document, make_data(ComponentType::kFloat32, 3, values_of<float>(large.attributes[0])), 34962, true);
  std::vector<uint32_t> indices;
  for (const auto& face : large.faces) indices.insert(indices.end(), face.begin(), face.end());
  const int64_t faces = append_accessor(document, make_data(ComponentType::kUint32, 1, indices), 34963, false);
  const int64_t moved = append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 34962, true);
  document.json()["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", positions}}},
       {"indices", faces},
       {"targets", Json::array({{{"POSITION", moved}}, {{"POSITION", moved}}, {{"POSITION", moved}}})}});
  const auto reports = must(encode_document(document, {}, reference_backend(), test_pool()));
  EXPECT_EQ(count_in(document, "\"targets\":{"), 2u);
  for (const PrimitiveReport& report : reports) EXPECT_TRUE(report.warnings.empty());
}

TEST(TargetsInPatches, AttributesWithTheirNamesAreLeft) {
  for (const char* name : {"targets/0/POSITION", "targets/7/NORMAL"}) {
    Document document = morphing_sheet();
    Json& attributes = primitive_of(document)["attributes"];
    attributes[name] = attributes["NORMAL"];
    const auto reports = must(encode_document(document, options_with(2), reference_backend(), test_pool()));
    EXPECT_TRUE(contains(reports[0].skipped, "a name that glTF does not allow")) << reports[0].skipped;
    EXPECT_EQ(read(document).status().code(), StatusCode::kUnsupported);
  }
}

TEST(TargetsInPatches, GivenBitsMakeTheirStep) {
  const auto bytes_with = [](int bits) {
    Document document = morphing_sheet();
    EncodeDocumentOptions options = options_with(1);
    options.morph_bits = bits;
    must(encode_document(document, options, reference_backend(), test_pool()));
    return must(stored_primitive(document, {0, 0})).bytes.size();
  };
  EXPECT_LT(bytes_with(8), bytes_with(0));
  EXPECT_GT(bytes_with(20), bytes_with(0));
  Document document = morphing_sheet();
  EncodeDocumentOptions options = options_with(1);
  options.morph_bits = 31;
  EXPECT_EQ(encode_document(document, options, reference_backend(), test_pool()).status().code(),
            StatusCode::kUsage);
}

// Two primitives of a mesh touch, and their targets move the border by the same deltas.
TEST(TargetsInPatches, BordersOfPrimitivesStayClosed) {
  Document document = morphing_sheet();
  Document other = document;
  // The second primitive is moved by the width of the sheet, and has a larger target of its own.
  Json& meshes = document.json()["meshes"];
  Json second = meshes[0]["primitives"][0];
  const Mesh mesh = sheet();
  std::vector<float> moved = values_of<float>(mesh.attributes[0]), large(3 * mesh.point_count, 0.0f);
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    moved[3 * i] += kSheetColumns;
    large[3 * i + 1] = moved[3 * i] == kSheetColumns ? 0.123456f : 50.0f;
  }
  std::vector<float> small(3 * mesh.point_count, 0.0f);
  const std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  for (uint32_t i = 0; i < mesh.point_count; ++i)
    if (positions[3 * i] == kSheetColumns) small[3 * i + 1] = 0.123456f;
  const auto append = [&](const std::vector<float>& values) {
    return append_accessor(document, make_data(ComponentType::kFloat32, 3, values), 34962, true);
  };
  const int64_t of_small = append(small), of_large = append(large), of_moved = append(moved);
  second["attributes"]["POSITION"] = of_moved;
  second["targets"] = Json::array({{{"POSITION", of_large}}});
  primitive_of(document)["targets"] = Json::array({{{"POSITION", of_small}}});
  document.json()["meshes"][0]["primitives"].push_back(std::move(second));
  must(encode_document(document, options_with(4), reference_backend(), test_pool()));
  std::set<float> at_border;
  for (const size_t primitive : {0u, 1u}) {
    const Mesh decoded = must(read(document, 0, primitive));
    const auto at = values_of<float>(*decoded.find("POSITION")),
               deltas = values_of<float>(*decoded.find("targets/0/POSITION"));
    for (uint32_t i = 0; i < decoded.point_count; ++i)
      if (std::fabs(at[3 * i] - kSheetColumns) < 0.01f) at_border.insert(deltas[3 * i + 1]);
  }
  EXPECT_EQ(at_border.size(), 1u);
}

TEST(TargetsInPatches, WithFallbacksAndCoarsePrimitives) {
  for (const Fallback fallback : {Fallback::kUncompressed, Fallback::kCoarse}) {
    Document document = morphing_sheet();
    const Deltas wanted = deltas_by_place(document, cpu_backend());
    EncodeDocumentOptions options = options_with(4);
    options.fallback = fallback;
    options.coarse_share = 0.3;
    must(encode_document(document, options, reference_backend(), test_pool()));
    EXPECT_EQ(findings_of(document, reference_backend()), "");
    EXPECT_TRUE(extension_of(document).contains("targets"));
    expect_near(wanted, deltas_by_place(document, cpu_backend()));
    must(decode(document));
    expect_near(wanted, deltas_by_place(document, cpu_backend()));
  }
}

// More attributes than a stream has: the rest stays in accessors.
TEST(TargetsInPatches, AreAsManyAsAStreamHas) {
  const Mesh mesh = sheet();
  Document document = document_from_mesh(mesh);
  Json targets = Json::array();
  for (size_t t = 0; t < 300; ++t) {
    std::vector<float> deltas(3 * mesh.point_count, 0);
    deltas[3 * t] = 1;
    targets.push_back(
        {{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 34962, true)}});
  }
  primitive_of(document)["targets"] = std::move(targets);
  must(encode_document(document, options_with(2, Condense::kFast), reference_backend(), test_pool()));
  size_t stored = 0;
  for (const Json& id : extension_of(document)["targets"]["POSITION"]) stored += id != -1;
  EXPECT_EQ(stored, 254u);
  EXPECT_EQ(findings_of(document, cpu_backend()), "");
  EXPECT_EQ(read_all_targets(document).size(), 300u);
}

TEST(TargetsInPatches, WhatContradictsThePrimitiveIsRefused) {
  Document valid = morphing_sheet();
  must(encode_document(valid, options_with(2), reference_backend(), test_pool()));
  const auto expect_refused = [&](const char* why, auto&& change) {
    Document document = valid;
    change(document.json()["meshes"][0]["primitives"][0]["extensions"]["PSPLIT_mesh_draco_patches"]);
    const Status status = read(document).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << why;
    EXPECT_TRUE(contains(status.message(), why)) << status.message();
    EXPECT_FALSE(decode(document).ok());
    EXPECT_NE(findings_of(document, cpu_backend()), "");
  };
  expect_refused("not as many", [](Json& extension) { extension["targets"]["POSITION"].push_back(-1); });
  expect_refused("not as many", [](Json& extension) { extension["targets"]["POSITION"] = 3; });
  expect_refused("not an object", [](Json& extension) { extension["targets"] = Json::array({2, 3, -1}); });
  expect_refused("no unique id", [](Json& extension) { extension["targets"]["POSITION"][0] = -2; });
  expect_refused("no unique id", [](Json& extension) { extension["targets"]["POSITION"][0] = "2"; });
  expect_refused("no accessor", [](Json& extension) { extension["targets"]["TANGENT"] = {2, -1, -1}; });
  expect_refused("is a morph target",
                 [](Json& extension) { extension["attributes"]["targets/0/POSITION"] = 2; });
  expect_refused("", [](Json& extension) { extension["targets"]["POSITION"][0] = 77; });
}

}  // namespace
}  // namespace psplit
