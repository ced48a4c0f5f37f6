// What stays in buffer views is compressed by meshoptimizer, within stated errors, and decode makes it plain.

#include "gltf_ext/convert/compress_rest.h"

#include <algorithm>
#include <set>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

constexpr uint32_t kKeys = 60;
constexpr uint32_t kTargets = 3;

std::vector<float> floats_of(const Document& document, int64_t index) {
  const AccessorData data = must(read_accessor(document, index));
  std::vector<float> values(data.values.size() / sizeof(float));
  std::memcpy(values.data(), data.values.data(), data.values.size());
  return values;
}

// An animated grid with morph targets, bones, instances and points.
struct AnimatedAsset {
  Document document;
  int64_t times = 0, translation = 0, rotation = 0, scale = 0, weights = 0, spline = 0, bones = 0,
          instances = 0, rotated = 0, points = 0, shorts = 0;
  std::vector<int64_t> targets{};
  size_t sampler_count = 0;

  AnimatedAsset() : document(document_from_mesh(make_grid(40, 30))) {
    Json& json = document.json();
    json["nodes"].push_back({{"children", Json::array({0})}});
    json["scenes"][0]["nodes"] = Json::array({1});
    json["animations"] = Json::array({{{"samplers", Json::array()}, {"channels", Json::array()}}});
    std::vector<float> keys, moves, turns, scales, shapes, splines;
    for (uint32_t i = 0; i < kKeys; ++i) {
      const float t = static_cast<float>(i) / 30, a = 0.4f * std::sin(3 * t);
      keys.push_back(t);
      moves.insert(moves.end(), {2 * std::sin(t), 0.1f * t, std::cos(5 * t)});
      turns.insert(turns.end(), {0.6f * std::sin(a), 0, 0.8f * std::sin(a), std::cos(a)});
      scales.insert(scales.end(), {1, 1 + 0.1f * t, 1});
      for (uint32_t k = 0; k < kTargets; ++k) shapes.push_back(std::fabs(std::sin(t + static_cast<float>(k))));
      for (int k = 0; k < 9; ++k)
        splines.push_back(static_cast<float>(k % 3) * std::sin(t * static_cast<float>(k)));
    }
    times = append_accessor(document, floats(1, keys), 0, true);
    translation = append_accessor(document, floats(3, moves), 0, false);
    rotation = append_accessor(document, floats(4, turns), 0, false);
    scale = append_accessor(document, floats(3, scales), 0, false);
    weights = append_accessor(document, floats(1, shapes), 0, false);
    spline = append_accessor(document, floats(3, splines), 0, false);
    animate("translation", translation);
    animate("rotation", rotation);
    animate("scale", scale);
    animate("weights", weights);
    animate("translation", spline, "CUBICSPLINE");
    add_targets();
    std::vector<float> matrices;
    for (int bone = 0; bone < 20; ++bone)
      for (int k = 0; k < 16; ++k)
        matrices.push_back(k % 5 == 0 ? 1 : k >= 12 ? 0.1f * static_cast<float>(bone) : 0);
    bones = append_accessor(document, {ComponentType::kFloat32, 16, false, 20, floats(16, matrices).values}, 0,
                            false);
    document.json()["skins"] = Json::array({{{"joints", Json::array({0})}, {"inverseBindMatrices", bones}}});
    add_instances();
    add_points();
  }

  static AccessorData floats(uint8_t components, const std::vector<float>& values) {
    return make_data(ComponentType::kFloat32, components, values);
  }

  void animate(const char* path, int64_t output, const char* interpolation = "LINEAR") {
    Json& animation = document.json()["animations"][0];
    animation["samplers"].push_back({{"input", times}, {"output", output}, {"interpolation", interpolation}});
    const bool is_shape = std::string(path) == "weights";
    animation["channels"].push_back(
        {{"sampler", sampler_count++}, {"target", {{"node", is_shape ? 0 : 1}, {"path", path}}}});
  }

  void add_targets() {
    const uint32_t count = make_grid(40, 30).point_count;
    Json list = Json::array();
    for (uint32_t k = 0; k < kTargets; ++k) {
      std::vector<float> moves;
      for (uint32_t i = 0; i < count; ++i) {
        const bool moved = k != 1 || i % 17 == 3;  // the second is sparse
        const float d = moved ? 0.01f * std::sin(0.03f * static_cast<float>(i * (k + 1))) : 0;
        moves.insert(moves.end(), {d, 0.5f * d, -d});
      }
      const AccessorData data = floats(3, moves);
      Json accessor = describe_stored(data);
      describe_decoded(accessor, data, true);
      if (k == 1)
        store_values_sparse(document, accessor, data, kArrayBuffer);
      else
        store_values(document, accessor, data, kArrayBuffer);
      document.json()["accessors"].push_back(accessor);
      targets.push_back(static_cast<int64_t>(document.json()["accessors"].size()) - 1);
      list.push_back({{"POSITION", targets.back()}});
    }
    primitive_of(document)["targets"] = list;
  }

  void add_instances() {
    std::vector<float> places, turned;
    for (int i = 0; i < 100; ++i) {
      const float a = static_cast<float>(i);  // each is far from the one before
      places.insert(places.end(), {a, 0, 0.37f * a});
      turned.insert(turned.end(), {0, std::sin(1.5f * a), 0, std::cos(1.5f * a)});
    }
    instances = append_accessor(document, floats(3, places), 0, false);
    rotated = append_accessor(document, floats(4, turned), 0, false);
    document.json()["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", instances}, {"ROTATION", rotated}};
  }

  void add_points() {
    std::vector<float> places;
    std::vector<int16_t> numbers;
    for (int i = 0; i < 500; ++i) {
      const float t = 0.01f * static_cast<float>(i);
      places.insert(places.end(), {t, std::sin(t), 0});
      numbers.insert(numbers.end(), {static_cast<int16_t>(i), static_cast<int16_t>(-3 * i), 7});
    }
    points = append_accessor(document, floats(3, places), kArrayBuffer, true);
    shorts = append_accessor(document, make_data(ComponentType::kInt16, 3, numbers), kArrayBuffer, false);
    document.json()["meshes"].push_back(
        {{"primitives", Json::array({{{"mode", 0}, {"attributes", {{"POSITION", points}, {"_N", shorts}}}}})}});
  }
};

Document encoded_asset(const AnimatedAsset& asset, const DocumentOptions& options) {
  Document document = asset.document;
  must(encode_document(document, options, reference_backend(), test_pool()));
  return document;
}

Document reread(const Document& document) {
  const TestFolder folder;
  EXPECT_TRUE(write_document(document, folder / "asset.glb").ok());
  return must(read_document(folder / "asset.glb"));
}

// The accessor of a sampler's output, of a morph target ..., found again after numbers changed.
int64_t output_of(const Document& document, size_t sampler) {
  return document.json()["animations"][0]["samplers"][sampler]["output"].get<int64_t>();
}
int64_t target_of(const Document& document, size_t target) {
  return document.json()["meshes"][0]["primitives"][0]["targets"][target]["POSITION"].get<int64_t>();
}

int64_t instances_of(const Document& document, const char* name) {
  return document.json()["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"][name]
      .get<int64_t>();
}

// All values that the asset has in buffer views beside its meshes.
std::vector<std::vector<std::byte>> rest_of(const Document& document) {
  const Json& json = document.json();
  std::vector<int64_t> indices;
  for (const Json& sampler : json["animations"][0]["samplers"])
    indices.insert(indices.end(), {sampler["input"].get<int64_t>(), sampler["output"].get<int64_t>()});
  for (size_t k = 0; k < kTargets; ++k) indices.push_back(target_of(document, k));
  indices.push_back(json["skins"][0]["inverseBindMatrices"].get<int64_t>());
  for (const char* name : {"TRANSLATION", "ROTATION"}) indices.push_back(instances_of(document, name));
  for (const char* name : {"POSITION", "_N"})
    indices.push_back(json["meshes"][1]["primitives"][0]["attributes"][name].get<int64_t>());
  std::vector<std::vector<std::byte>> values;
  for (const int64_t index : indices) {
    const AccessorData data = must(read_accessor(document, index));
    values.emplace_back(data.values.begin(), data.values.end());
  }
  return values;
}

size_t compressed_views(const Document& document) {
  return static_cast<size_t>(std::ranges::count_if(
      document.records().views, [](const ViewRecord& view) { return view.meshopt.has_value(); }));
}

TEST(CompressRest, LosslessKeepsEveryBitWithBothExtensions) {
  const AnimatedAsset asset;
  const Document plain = encoded_asset(asset, {.lossless = true});
  for (const auto& [meshopt, name] : {std::pair(MeshoptRest::kExt, "EXT_meshopt_compression"),
                                      std::pair(MeshoptRest::kKhr, "KHR_meshopt_compression")}) {
    const Document document = encoded_asset(asset, {.lossless = true, .meshopt = meshopt});
    EXPECT_GT(compressed_views(document), 3u);
    EXPECT_EQ(count_in(document, "EXPONENTIAL") + count_in(document, "QUATERNION"), 0u);
    for (const char* list : {"extensionsUsed", "extensionsRequired"})
      EXPECT_EQ(std::count(document.json()[list].begin(), document.json()[list].end(), Json(name)), 1) << list;
    EXPECT_LT(glb_bytes(document), glb_bytes(plain));
    Document again = reread(document);
    EXPECT_EQ(rest_of(again), rest_of(plain));
    EXPECT_EQ(findings_of(again, reference_backend()), findings_of(plain, reference_backend()));
    ASSERT_TRUE(decode(again).ok());
    EXPECT_EQ(count_in(again, "meshopt"), 0u);
    EXPECT_EQ(rest_of(again), rest_of(plain));
  }
}

TEST(CompressRest, EachLossIsWithinItsBound) {
  const AnimatedAsset asset;
  const AnimationBits bits;
  const Document document = reread(encoded_asset(asset, {.meshopt = MeshoptRest::kExt}));
  const Document plain = encoded_asset(asset, {});  // with the points in the same order
  const auto expect_near = [&](int64_t before, int64_t after, double most) {
    const std::vector<float> a = floats_of(plain, before), b = floats_of(document, after);
    ASSERT_EQ(a.size(), b.size());
    double worst = 0;
    for (size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::fabs(double{a[i]} - double{b[i]}));
    EXPECT_LE(worst, most);
    EXPECT_GT(worst, 0);
  };
  // The largest translation and the largest scale are between 1 and 2, the weights between 0 and 1.
  expect_near(output_of(plain, 0), output_of(document, 0), std::ldexp(1, -bits.translation + 1));
  expect_near(output_of(plain, 2), output_of(document, 2), std::ldexp(1, -bits.scale + 1));
  expect_near(output_of(plain, 3), output_of(document, 3), std::ldexp(1, -bits.weight - 1));
  const auto expect_same_rotations = [&](int64_t before, int64_t after) {
    const std::vector<float> turns = floats_of(plain, before);
    const AccessorData shorts = must(read_accessor(document, after));
    ASSERT_EQ(shorts.component_type, ComponentType::kInt16);
    EXPECT_TRUE(shorts.normalized);
    for (size_t i = 0; i < turns.size(); i += 4) {
      int16_t turn[4];
      std::memcpy(turn, shorts.values.data() + i * sizeof(int16_t), sizeof turn);
      double dot = 0, length = 0;
      for (size_t k = 0; k < 4; ++k) {
        dot += turn[k] / 32767.0 * double{turns[i + k]};
        length += turn[k] / 32767.0 * turn[k] / 32767.0;
      }
      EXPECT_NEAR(length, 1, 1e-3);
      EXPECT_GT(std::fabs(dot) / std::sqrt(length), 1 - 1e-6);  // an angle of 0.16 degrees
    }
  };
  expect_same_rotations(output_of(plain, 1), output_of(document, 1));
  // Nothing is interpolated between instances, so they may be half a turn apart.
  expect_same_rotations(instances_of(plain, "ROTATION"), instances_of(document, "ROTATION"));
  expect_near(instances_of(plain, "TRANSLATION"), instances_of(document, "TRANSLATION"),
              std::ldexp(128, -bits.translation));  // the largest component is between 64 and 128
  // The grid is 39 units wide.
  for (size_t k = 0; k < kTargets; ++k)
    expect_near(target_of(plain, k), target_of(document, k),
                std::ldexp(39.0, -CodingOptions().position_bits - 1));
  // The points are 5 units wide.
  const Json& attributes = document.json()["meshes"][1]["primitives"][0]["attributes"];
  expect_near(plain.json()["meshes"][1]["primitives"][0]["attributes"]["POSITION"].get<int64_t>(),
              attributes["POSITION"].get<int64_t>(), std::ldexp(5.0, -CodingOptions().position_bits - 1));
  // Exact is what nobody gave a precision.
  EXPECT_EQ(floats_of(document, output_of(document, 4)), floats_of(plain, output_of(plain, 4)));
  const auto rest = rest_of(document), exact = rest_of(plain);
  for (const size_t i : {0u, 8u, 9u, 13u, 17u}) EXPECT_EQ(rest[i], exact[i]) << i;
}

TEST(CompressRest, BoundsAreThoseOfTheRoundedValues) {
  const Document document = encoded_asset(AnimatedAsset(), {.meshopt = MeshoptRest::kExt});
  for (size_t k = 0; k < kTargets; ++k) {
    const Json& accessor = document.json()["accessors"][static_cast<size_t>(target_of(document, k))];
    const AccessorData data = must(read_accessor(document, target_of(document, k)));
    Json exact = Json::object();
    describe_decoded(exact, data, true);
    EXPECT_EQ(accessor["min"], exact["min"]);
    EXPECT_EQ(accessor["max"], exact["max"]);
  }
}

TEST(CompressRest, TracksShareViewsAndEqualOnesAreOne) {
  AnimatedAsset asset;
  const std::vector<float> turns = floats_of(asset.document, asset.rotation);
  for (int track = 0; track < 50; ++track) {
    std::vector<float> turned = turns;
    std::rotate(turned.begin(), turned.begin() + 4 * (track / 2), turned.end());  // each twice
    asset.animate("rotation", append_accessor(asset.document, AnimatedAsset::floats(4, turned), 0, false));
  }
  const Document document = encoded_asset(asset, {.meshopt = MeshoptRest::kExt});
  std::set<int64_t> views, accessors;
  for (size_t i = 0; i < 50; ++i) {
    const int64_t output = output_of(document, 5 + i);
    accessors.insert(output);
    views.insert(document.records().accessor(output).elements.view);
  }
  EXPECT_EQ(views.size(), 1u);
  EXPECT_EQ(accessors.size(), 25u);
  EXPECT_LE(compressed_views(document), 12u);
}

TEST(CompressRest, ViewsFollowTheRulesOfGltf) {
  const Document document = encoded_asset(AnimatedAsset(), {.meshopt = MeshoptRest::kExt});
  const AssetRecords& records = document.records();
  for (size_t i = 0; i < records.views.size(); ++i) {
    const ViewRecord& view = records.views[i];
    if (!view.meshopt) continue;
    EXPECT_TRUE(is_legal_meshopt(*view.meshopt));
    const Json& json = document.json()["bufferViews"][i];
    const bool is_vertices = integer_field(json, "target") == kArrayBuffer;
    EXPECT_EQ(view.stride, is_vertices ? view.meshopt->stride : 0);
    EXPECT_EQ(view.range.bytes, view.meshopt->decoded_bytes());
    EXPECT_TRUE(is_placeholder(document, static_cast<size_t>(view.range.buffer)));
  }
  for (const AccessorRecord& accessor : records.accessors) EXPECT_EQ(accessor.elements.offset % 4, 0u);
}

TEST(CompressRest, TurnsOfAboutHalfACircleStayExact) {
  AnimatedAsset asset;
  std::vector<float> turns;
  for (uint32_t i = 0; i < kKeys; ++i)
    turns.insert(turns.end(), {i % 2 == 0 ? 0.0f : 1.0f, 0, 0, i % 2 == 0 ? 1.0f : 0.0f});
  std::vector<float> longer(turns.size(), 0.9f);  // no unit quaternions
  for (size_t i = 0; i < longer.size(); ++i) longer[i] += 0.001f * static_cast<float>(i % 7);
  asset.animate("rotation", append_accessor(asset.document, AnimatedAsset::floats(4, turns), 0, false));
  asset.animate("rotation", append_accessor(asset.document, AnimatedAsset::floats(4, longer), 0, false));
  const Document document = encoded_asset(asset, {.meshopt = MeshoptRest::kExt});
  EXPECT_EQ(floats_of(document, output_of(document, 5)), turns);
  EXPECT_EQ(floats_of(document, output_of(document, 6)), longer);
}

TEST(CompressRest, PointsThatWouldBecomeOneStayExact) {
  AnimatedAsset asset;
  std::vector<float> places = floats_of(asset.document, asset.points);
  for (size_t i = 0; i < 3; ++i) places[3 + i] = places[i] + 1e-6f;
  const int64_t close = append_accessor(asset.document, AnimatedAsset::floats(3, places), kArrayBuffer, true);
  asset.document.json()["meshes"].push_back(
      {{"primitives", Json::array({{{"mode", 0}, {"attributes", {{"POSITION", close}}}}})}});
  const Document document = encoded_asset(asset, {.meshopt = MeshoptRest::kExt});
  const Json& primitive = document.json()["meshes"][2]["primitives"][0];
  EXPECT_EQ(floats_of(document, primitive["attributes"]["POSITION"].get<int64_t>()), places);
}

TEST(CompressRest, ValuesWithTwoMeaningsAndWhatUnknownDataNamesStayExact) {
  AnimatedAsset asset;
  asset.animate("rotation", asset.rotation, "CUBICSPLINE");
  asset.document.json()["extras"] = {{"accessor", asset.translation}};
  const Document before = encoded_asset(asset, {});
  const Document document = encoded_asset(asset, {.meshopt = MeshoptRest::kExt});
  EXPECT_EQ(floats_of(document, output_of(document, 1)), floats_of(before, output_of(before, 1)));
  EXPECT_EQ(output_of(document, 0), asset.translation);
  EXPECT_EQ(floats_of(document, asset.translation), floats_of(asset.document, asset.translation));
  EXPECT_FALSE(document.records().view(document.records().accessor(asset.translation).elements.view).meshopt);
}

TEST(CompressRest, NothingGrows) {
  // A few values take less than the JSON of the extension.
  Document document = document_from_mesh(make_grid(3, 3));
  primitive_of(document)["mode"] = 0;
  const Json before = document.json();
  const uint64_t bytes = glb_bytes(document);
  EncodeDocumentOptions options;
  options.meshopt = MeshoptRest::kExt;
  must(encode_document(document, options, reference_backend(), test_pool()));
  EXPECT_EQ(document.json(), before);
  EXPECT_EQ(glb_bytes(document), bytes);
}

TEST(CompressRest, EncodingAgainChangesNothing) {
  Document document = reread(encoded_asset(AnimatedAsset(), {.meshopt = MeshoptRest::kExt}));
  const Json before = document.json();
  must(encode_document(document, DocumentOptions{.meshopt = MeshoptRest::kExt}, reference_backend(),
                       test_pool()));
  EXPECT_EQ(document.json(), before);
}

// The first bytes of the streams that compressed views have in the file, for views of attributes.
std::set<uint8_t> versions_of(const Document& document) {
  std::set<uint8_t> versions;
  for (const ViewRecord& view : document.records().views) {
    if (!view.meshopt || view.meshopt->mode != "ATTRIBUTES") continue;
    const std::span<const uint8_t> bytes = document.buffers[static_cast<size_t>(view.meshopt->range.buffer)];
    versions.insert(bytes[static_cast<size_t>(view.meshopt->range.offset)]);
  }
  return versions;
}

TEST(CompressRest, OnlyKhrHasVersion1AndIsSmaller) {
  const AnimatedAsset asset;
  const Document ext = encoded_asset(asset, {.meshopt = MeshoptRest::kExt});
  const Document khr = encoded_asset(asset, {.meshopt = MeshoptRest::kKhr});
  EXPECT_EQ(versions_of(ext), std::set<uint8_t>{0xa0});
  EXPECT_EQ(versions_of(khr), std::set<uint8_t>{0xa1});
  EXPECT_LT(glb_bytes(khr), glb_bytes(ext));
  EXPECT_EQ(rest_of(khr), rest_of(ext));
  // What is compressed by the one becomes the other, without loss, and nothing else changes.
  Document renamed = reread(ext);
  must(encode_document(renamed, DocumentOptions{.meshopt = MeshoptRest::kKhr}, reference_backend(),
                       test_pool()));
  EXPECT_EQ(versions_of(renamed), std::set<uint8_t>{0xa1});
  EXPECT_EQ(count_in(renamed, "EXT_meshopt_compression"), 0u);
  EXPECT_LT(glb_bytes(renamed), glb_bytes(ext));
  EXPECT_EQ(rest_of(reread(renamed)), rest_of(ext));
  EXPECT_EQ(findings_of(reread(renamed), reference_backend()), findings_of(ext, reference_backend()));
}

// A target that moves most points by about a step of the grid: sparse takes fewer bytes in memory, dense fewer
// in the file.
TEST(CompressRest, SparseTargetsBecomeDenseWhereThatIsSmaller) {
  AnimatedAsset asset;
  const size_t count = make_grid(40, 30).point_count;
  std::vector<float> moves(3 * count);
  for (size_t i = 0; i < count; ++i)
    if (i * i % 11 > 2) moves[3 * i] = i % 5 < 3 ? 0.0021f : -0.0018f;
  const AccessorData data = AnimatedAsset::floats(3, moves);
  Json accessor = describe_stored(data);
  describe_decoded(accessor, data, true);
  store_values_sparse(asset.document, accessor, data, kArrayBuffer);
  asset.document.json()["accessors"].push_back(accessor);
  primitive_of(asset.document)["targets"][1]["POSITION"] = asset.document.json()["accessors"].size() - 1;
  const Document plain = encoded_asset(asset, {});
  ASSERT_TRUE(plain.records().accessor(target_of(plain, 1)).sparse);
  const Document document = reread(encoded_asset(asset, {.meshopt = MeshoptRest::kKhr}));
  EXPECT_FALSE(document.records().accessor(target_of(document, 1)).sparse);
  const std::vector<float> before = floats_of(plain, target_of(plain, 1)),
                           after = floats_of(document, target_of(document, 1));
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_LE(std::fabs(before[i] - after[i]), std::ldexp(39.0f, -CodingOptions().position_bits - 1));
  EXPECT_EQ(findings_of(document, reference_backend()), findings_of(plain, reference_backend()));
}

TEST(CompressRest, ExtrasOfViewsStay) {
  AnimatedAsset asset;
  const auto view_of = [](const Document& document) {
    return static_cast<size_t>(
        document.records().accessor(instances_of(document, "TRANSLATION")).elements.view);
  };
  asset.document.json()["bufferViews"][view_of(asset.document)]["extras"] = {{"name", "places"}};
  const Document document = encoded_asset(asset, {.meshopt = MeshoptRest::kExt});
  EXPECT_TRUE(document.records().views[view_of(document)].meshopt);
  EXPECT_EQ(document.json()["bufferViews"][view_of(document)]["extras"], Json({{"name", "places"}}));
  EXPECT_EQ(count_in(document, "places"), 1u);
}

TEST(CompressRest, ColorsOfPointsAreRounded) {
  AnimatedAsset asset;
  std::vector<float> colors;
  for (int i = 0; i < 500; ++i)
    for (int c = 0; c < 3; ++c)
      colors.push_back(0.5f + 0.5f * std::sin(0.01f * static_cast<float>(i * (c + 1))));
  Json& attributes = asset.document.json()["meshes"][1]["primitives"][0]["attributes"];
  attributes["COLOR_0"] =
      append_accessor(asset.document, AnimatedAsset::floats(3, colors), kArrayBuffer, false);
  const auto worst_of = [&](DocumentOptions options) {
    options.meshopt = MeshoptRest::kKhr;
    const Document document = encoded_asset(asset, options);
    const Json& primitive = document.json()["meshes"][1]["primitives"][0];
    const std::vector<float> after = floats_of(document, primitive["attributes"]["COLOR_0"].get<int64_t>());
    float worst = 0;
    for (size_t i = 0; i < colors.size(); ++i) worst = std::max(worst, std::fabs(after[i] - colors[i]));
    return worst;
  };
  EXPECT_LE(worst_of({}), 1.0f / 512);
  EXPECT_GT(worst_of({}), 0);
  EXPECT_EQ(worst_of({.lossless = true}), 0);
}

TEST(CompressRest, OptionsAreChecked) {
  const auto code_of = [](DocumentOptions options, uint64_t memory) {
    Document document = document_from_mesh(make_grid(3, 3));
    options.meshopt = MeshoptRest::kExt;
    OutOfCoreOptions limits;
    limits.memory = memory;
    return encode_document(document, options, reference_backend(), test_pool(), {}, limits).status().code();
  };
  EXPECT_EQ(code_of({}, kLeastMemory), StatusCode::kUsage);
  EXPECT_EQ(code_of({.animation_bits = {.translation = 25}}, 0), StatusCode::kUsage);
  EXPECT_EQ(code_of({.animation_bits = {.rotation = 3}}, 0), StatusCode::kUsage);
}

// A fallback is equal to what the patches decode to.
TEST(CompressRest, LeavesFallbacksOfTargets) {
  const Mesh mesh = make_grid(12, 12);
  Document document = document_from_mesh(mesh);
  std::vector<float> deltas(3 * mesh.point_count);
  for (size_t i = 0; i < deltas.size(); ++i) deltas[i] = std::sin(0.3f * static_cast<float>(i));
  primitive_of(document)["targets"] = Json::array(
      {{{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 34962, true)}}});
  EncodeDocumentOptions options;
  options.morph_targets = MorphTargets::kPatches;
  options.fallback = Fallback::kUncompressed;
  options.meshopt = MeshoptRest::kExt;
  must(encode(document, options));
  EXPECT_EQ(count_in(document, "\"targets\":{"), 1u);
  EXPECT_EQ(findings_of(document, reference_backend()), "");
}

}  // namespace
}  // namespace psplit
