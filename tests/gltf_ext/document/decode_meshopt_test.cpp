// Buffer views that meshoptimizer compressed are decoded on reading, and stay compressed in what is written.

#include <meshoptimizer.h>

#include <algorithm>
#include <functional>
#include <map>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/meshopt_vertices.h"
#include "gltf_ext/document/pack_buffers.h"
#include "gltf_ext/json/json_fields.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

template <typename T>
Bytes bytes_of(const std::vector<T>& values) {
  Bytes bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// Releases from 1.0 on write the codec's version 1 unless they are told not to, and ask for a mode.
Bytes compress_attributes(const Bytes& plain, size_t stride) {
  const size_t count = plain.size() / stride;
  meshopt_encodeVertexVersion(0);
  Bytes packed(meshopt_encodeVertexBufferBound(count, stride));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), plain.data(), count, stride));
  return packed;
}

void filter_exponential(void* rows, size_t count, size_t stride, int bits, const std::vector<float>& values) {
#if MESHOPTIMIZER_VERSION >= 1000
  meshopt_encodeFilterExp(rows, count, stride, bits, values.data(), meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(rows, count, stride, bits, values.data());
#endif
}

Bytes compress_triangles(const std::vector<uint32_t>& indices) {
  Bytes packed(meshopt_encodeIndexBufferBound(indices.size(), 70000));
  packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
  return packed;
}

Bytes compress_sequence(const std::vector<uint32_t>& indices) {
  Bytes packed(meshopt_encodeIndexSequenceBound(indices.size(), 70000));
  packed.resize(meshopt_encodeIndexSequence(packed.data(), packed.size(), indices.data(), indices.size()));
  return packed;
}

// An asset whose buffer 0 holds compressed bytes and whose buffer 1 is a fallback.
class CompressedAsset {
 public:
  explicit CompressedAsset(const char* extension = "EXT_meshopt_compression") : extension_(extension) {
    json_ = Json::parse(R"({"asset":{"version":"2.0"},"buffers":[],"bufferViews":[],"accessors":[]})");
    json_["extensionsUsed"] = Json::array({extension});
    json_["extensionsRequired"] = json_["extensionsUsed"];
  }

  // Returns the index of the buffer view, which is also that of its accessor.
  size_t add(const Bytes& packed, size_t stride, size_t count, const char* mode, const char* filter,
             const Json& accessor) {
    Json meshopt = {{"buffer", 0},
                    {"byteOffset", bytes_.size()},
                    {"byteLength", packed.size()},
                    {"byteStride", stride},
                    {"count", count},
                    {"mode", mode}};
    if (filter != nullptr) meshopt["filter"] = filter;
    Json view = {{"buffer", 1}, {"byteOffset", fallback_bytes_}, {"byteLength", stride * count}};
    if (std::string(mode) == "ATTRIBUTES") view["byteStride"] = stride;
    view["extensions"][extension_] = meshopt;
    const size_t index = json_["bufferViews"].size();
    json_["bufferViews"].push_back(view);
    json_["accessors"].push_back(accessor);
    json_["accessors"].back().update({{"bufferView", index}, {"count", count}});
    bytes_.insert(bytes_.end(), packed.begin(), packed.end());
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    fallback_bytes_ += (stride * count + 3) / 4 * 4;
    return index;
  }

  Json& json() { return json_; }

  Expected<Document> read() const {
    Json json = json_;
    json["buffers"].push_back({{"byteLength", bytes_.size()}});
    json["buffers"].push_back(
        {{"byteLength", fallback_bytes_}, {"extensions", {{extension_, {{"fallback", true}}}}}});
    const TestFolder folder;
    Document document;
    document.json() = json;
    document.buffers = {bytes_, {}};
    if (Status status = write_document(document, folder / "asset.glb"); !status.ok()) return status;
    return read_document(folder / "asset.glb");
  }

 private:
  std::string extension_;
  Json json_;
  Bytes bytes_;
  size_t fallback_bytes_ = 0;
};

const Json kPositions = {{"componentType", 5126}, {"type", "VEC3"}, {"min", {0, 0, 0}}, {"max", {1, 1, 1}}};
const Json kIndices32 = {{"componentType", 5125}, {"type", "SCALAR"}};
const Json kIndices16 = {{"componentType", 5123}, {"type", "SCALAR"}};

TEST(Meshopt, EveryModeIsDecodedAndNothingOfItIsLeftByEncode) {
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const Mesh mesh = make_grid(20, 15);
    std::vector<uint32_t> indices;
    for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
    CompressedAsset asset(extension);
    asset.add(compress_attributes(bytes_of(values_of<float>(mesh.attributes[0])), 12), 12, mesh.point_count,
              "ATTRIBUTES", nullptr, kPositions);
    asset.add(compress_triangles(indices), 2, indices.size(), "TRIANGLES", "NONE", kIndices16);
    asset.add(compress_sequence(indices), 4, indices.size(), "INDICES", nullptr, kIndices32);
    asset.json()["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0},"indices":1},
                                                            {"attributes":{"POSITION":0},"indices":2}]}])");
    Document document = must(asset.read());
    for (const size_t primitive : {0u, 1u}) EXPECT_EQ(compare_meshes(mesh, *read(document, 0, primitive)), "");
    const auto reports = must(encode(document));
    EXPECT_EQ(reports[0].skipped, "");
    EXPECT_EQ(count_in(document, "meshopt"), 0u);
    EXPECT_EQ(document.buffers.size(), 1u);  // the compressed bytes and the fallback are gone
    EXPECT_EQ(document.json()["extensionsUsed"], Json::array({kExtensionName}));
    document = must(asset.read());
    ASSERT_TRUE(decode(document).ok());
    EXPECT_EQ(count_in(document, "meshopt"), 0u);
    EXPECT_FALSE(document.json().contains("extensionsUsed"));
    EXPECT_EQ(document.buffers.size(), 1u);
    for (const size_t primitive : {0u, 1u}) EXPECT_EQ(compare_meshes(mesh, *read(document, 0, primitive)), "");
  }
}

TEST(Meshopt, FiltersAreUndone) {
  const size_t count = 50;
  std::vector<float> normals, rotations, values;
  for (size_t i = 0; i < count; ++i) {
    const float a = 0.1f * static_cast<float>(i), b = 0.07f * static_cast<float>(i);
    normals.insert(normals.end(), {std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b), 0});
    rotations.insert(rotations.end(), {std::sin(a) * 0.6f, std::sin(a) * 0.8f, 0, std::cos(a)});
    values.insert(values.end(), {a * 1000, -b, 0.001f * b});
  }
  std::vector<int8_t> octahedral(count * 4);
  meshopt_encodeFilterOct(octahedral.data(), count, 4, 8, normals.data());
  std::vector<int16_t> quaternions(count * 4);
  meshopt_encodeFilterQuat(quaternions.data(), count, 8, 16, rotations.data());
  std::vector<uint32_t> exponential(count * 3);
  filter_exponential(exponential.data(), count, 12, 15, values);

  CompressedAsset asset;
  asset.add(compress_attributes(bytes_of(octahedral), 4), 4, count, "ATTRIBUTES", "OCTAHEDRAL",
            {{"componentType", 5120}, {"type", "VEC3"}, {"normalized", true}});
  asset.add(compress_attributes(bytes_of(quaternions), 8), 8, count, "ATTRIBUTES", "QUATERNION",
            {{"componentType", 5122}, {"type", "VEC4"}, {"normalized", true}});
  asset.add(compress_attributes(bytes_of(exponential), 12), 12, count, "ATTRIBUTES", "EXPONENTIAL",
            {{"componentType", 5126}, {"type", "VEC3"}});
  asset.json()["meshes"] =
      Json::parse(R"([{"primitives":[{"attributes":{"NORMAL":0,"_Q":1,"_V":2},"mode":0}]}])");
  const Document document = must(asset.read());
  const auto normal = read_accessor(document, 0), rotation = read_accessor(document, 1),
             value = read_accessor(document, 2);
  ASSERT_TRUE(normal && rotation && value);
  // meshoptimizer rounds estimates.
  std::vector<int8_t> estimated_normals = octahedral;
  meshopt_decodeFilterOct(estimated_normals.data(), count, 4);
  std::vector<int16_t> estimated_rotations = quaternions;
  meshopt_decodeFilterQuat(estimated_rotations.data(), count, 8);
  for (size_t i = 0; i < count; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(static_cast<int8_t>(normal->values[3 * i + c]) / 127.0, double{normals[4 * i + c]}, 0.02);
      EXPECT_NEAR(static_cast<int8_t>(normal->values[3 * i + c]), estimated_normals[4 * i + c], 1);
      float decoded = 0;
      std::memcpy(&decoded, value->values.data() + (3 * i + c) * 4, 4);
      // All components of an element have the same exponent.
      EXPECT_NEAR(decoded, values[3 * i + c], 1e-3 * std::fabs(values[3 * i]));
    }
    double dot = 0;  // q and -q are the same rotation
    for (size_t c = 0; c < 4; ++c) {
      int16_t decoded = 0;
      std::memcpy(&decoded, rotation->values.data() + (4 * i + c) * 2, 2);
      EXPECT_NEAR(decoded, estimated_rotations[4 * i + c], 1);
      dot += decoded / 32767.0 * double{rotations[4 * i + c]};
    }
    EXPECT_NEAR(std::fabs(dot), 1, 1e-3);
  }
}

// The rows that a view decodes to.
template <typename T>
std::vector<T> undone(const char* filter, const std::vector<T>& rows) {
  CompressedAsset asset;
  const size_t stride = 4 * sizeof(T);
  asset.add(compress_attributes(bytes_of(rows), stride), stride, rows.size() / 4, "ATTRIBUTES", filter,
            {{"componentType", sizeof(T) == 1 ? 5120 : 5122}, {"type", "VEC4"}, {"normalized", true}});
  asset.json()["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"_V":0},"mode":0}]}])");
  const AccessorData read = must(read_accessor(must(asset.read()), 0));
  std::vector<T> values(rows.size());
  EXPECT_EQ(read.values.size(), rows.size() * sizeof(T));
  std::memcpy(values.data(), read.values.data(), read.values.size());
  return values;
}

// The extension's formulas, calculated with fifty digits. Among the rows are some that no encoder writes.
TEST(Meshopt, FiltersAreTheFormulasOnEveryProcessor) {
  EXPECT_EQ(undone<int8_t>("OCTAHEDRAL", {10, 20, 63, 5, -40, -50, 63,   7,   60,  3, 63, -1,   0,    0,
                                          0,  9,  0,  0, -5,  1,   -128, 127, 127, 0, 1,  -128, -128, 3}),
            (std::vector<int8_t>{32, 64, 105, 5,   -44, -77, -91, 7,  127,  6, 0,   -1, 0,   0,
                                 0,  9,  -73, -73, -73, 1,   0,   -1, -127, 0, -84, 43, -85, 3}));
  EXPECT_EQ(undone<int16_t>("OCTAHEDRAL", {100,   200, 511, 5, -4000, -5000, 6000,  7,      -32768, 32767,
                                           32767, 0,   0,   0, 0,     9,     12345, -23456, 32767,  2}),
            (std::vector<int16_t>{10658,  21316, 22488, 5, -8757, -17515, -26272, 7,      0,     -1,
                                  -32767, 0,     0,     0, 0,     9,      13471,  -29546, -4389, 2}));
  EXPECT_EQ(undone<int16_t>("QUATERNION", {100, -200, 300,   509,   32767, -32768, 1, 0, 5, 6,
                                           7,   -1,   20000, 10000, -5000, 32766,  0, 0, 0, 2}),
            (std::vector<int16_t>{13603,  28033, 4534, -9068, 0,     32767, -32768, 7723, -32768, -32768,
                                  -32768, 0,     7071, -3536, 28481, 14142, 0,      0,    32767,  0}));
}

TEST(Meshopt, HostileViewsAreRefused) {
  const Bytes packed = compress_attributes(Bytes(64 * 12, 7), 12);
  const auto refusal = [&](const std::function<void(Json & meshopt, Json & view)>& change) {
    CompressedAsset asset;
    asset.add(packed, 12, 64, "ATTRIBUTES", nullptr, kPositions);
    Json& view = asset.json()["bufferViews"][0];
    change(view["extensions"]["EXT_meshopt_compression"], view);
    const Expected<Document> document = asset.read();
    if (document) return std::string("loads");
    EXPECT_EQ(document.status().code(), StatusCode::kInvalidInput) << document.status().to_string();
    EXPECT_TRUE(contains(document.status().to_string(), "asset.glb: "));
    return document.status().message();
  };
  const auto has = [](const std::string& message, const char* text) {
    return message.find(text) != std::string::npos ? "" : message;
  };
  EXPECT_EQ(has(refusal([](Json&, Json&) {}), "loads"), "");
  for (size_t length = 0; length < packed.size(); ++length)
    EXPECT_EQ(has(refusal([&](Json& meshopt, Json&) { meshopt["byteLength"] = length; }), "buffer view 0"), "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["count"] = 100000000; }), "more elements"), "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["count"] = 63; }), "fewer elements"), "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["count"] = -1; }), "has no valid"), "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["byteStride"] = 0; }), "has no valid"), "");
  EXPECT_EQ(
      has(refusal([](Json& meshopt, Json&) { meshopt["byteStride"] = 13; }), "an illegal combination of mode"),
      "");
  EXPECT_EQ(
      has(refusal([](Json& meshopt, Json&) { meshopt["mode"] = "POINTS"; }), "an illegal combination of mode"),
      "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["mode"] = "TRIANGLES"; }),
                "an illegal combination of mode"),
            "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["filter"] = "OCTAHEDRAL"; }),
                "an illegal combination of mode"),
            "");
  EXPECT_EQ(
      has(refusal([](Json& meshopt, Json&) { meshopt["filter"] = "ELSE"; }), "an illegal combination of mode"),
      "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt.erase("mode"); }), "has no valid"), "");
  EXPECT_EQ(has(refusal([](Json& meshopt, Json&) { meshopt["byteLength"] = 1000000; }), "reaches past"), "");
}

TEST(Meshopt, ASmallFileDoesNotBecomeALargeOne) {
  // Each view alone is valid, but all of them share the same bytes.
  CompressedAsset asset;
  const size_t count = 4096;
  asset.add(compress_attributes(Bytes(count * 4, 0), 4), 4, count, "ATTRIBUTES", nullptr,
            {{"componentType", 5121}, {"type", "VEC4"}});
  const Json view = asset.json()["bufferViews"][0];
  for (int i = 0; i < 200; ++i) asset.json()["bufferViews"].push_back(view);
  const Expected<Document> document = asset.read();
  ASSERT_FALSE(document);
  EXPECT_EQ(document.status().code(), StatusCode::kInvalidInput);
  EXPECT_TRUE(contains(document.status().message(), "shares its bytes"));
}

TEST(Meshopt, AFallbackThatWasNotShippedIsNotMissed) {
  CompressedAsset asset;
  const Mesh mesh = make_grid(6, 6);
  asset.add(compress_attributes(bytes_of(values_of<float>(mesh.attributes[0])), 12), 12, mesh.point_count,
            "ATTRIBUTES", nullptr, kPositions);
  asset.json()["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0},"mode":0}]}])");
  asset.json()["scenes"] =
      Json::parse(R"([{"extensions":{"ANY_thing":{"view":0}}}])");  // an unknown extension: every index stays
  const Document document = must(asset.read());
  EXPECT_EQ(document.json()["accessors"].size(), 1u);
  EXPECT_EQ(read_accessor(document, 0)->values, mesh.attributes[0].values);
  // The document can be written and read again.
  const TestFolder folder;
  const std::filesystem::path path = folder / "asset.glb";
  ASSERT_TRUE(write_document(document, path).ok());
  const Document again = must(read_document(path));
  EXPECT_EQ(read_accessor(again, 0)->values, mesh.attributes[0].values);
  EXPECT_EQ(count_in(again, "meshopt"), count_in(document, "meshopt"));
}

// The compressed bytes of a view.
Bytes compressed_of(const Document& document, size_t view) {
  const ViewRecord& record = document.records().views[view];
  if (!record.meshopt) return {};
  const auto& [buffer, offset, bytes] = record.meshopt->range;
  const auto all = document.buffers[static_cast<size_t>(buffer)].bytes();
  const auto found = all.subspan(static_cast<size_t>(offset), static_cast<size_t>(bytes));
  return {found.begin(), found.end()};
}

Document written_and_read(const Document& document, const char* name, uint64_t* bytes = nullptr) {
  const TestFolder folder;
  EXPECT_TRUE(write_document(document, folder / name).ok());
  if (bytes != nullptr)
    for (const auto& file : std::filesystem::directory_iterator(folder / "")) *bytes += file.file_size();
  return must(read_document(folder / name));
}

// A mesh with a morph target, whose views other meshes share: `count` points in all.
class MorphedAsset : public CompressedAsset {
 public:
  // Moves of the points, as a filter makes them from `moves`.
  MorphedAsset(const char* filter, size_t stride, const Bytes& rows, Json accessor, const char* extension)
      : CompressedAsset(extension), mesh(make_grid(30, 20)) {
    std::vector<uint32_t> indices;
    for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
    add(compress_attributes(bytes_of(values_of<float>(mesh.attributes[0])), 12), 12, mesh.point_count,
        "ATTRIBUTES", nullptr, kPositions);
    add(compress_triangles(indices), 2, indices.size(), "TRIANGLES", nullptr, kIndices16);
    add(compress_attributes(rows, stride), stride, rows.size() / stride, "ATTRIBUTES", filter, accessor);
    // Accessor 2 is the target. 3 has as many values for points that stay plain, 4 is for another target.
    Json& accessors = json()["accessors"];
    accessors[2]["count"] = mesh.point_count;
    for (const size_t i : {3u, 4u}) {
      accessors.push_back(accessors[2]);
      accessors[i]["byteOffset"] = (i - 2) * mesh.point_count * stride;
    }
    json()["meshes"] = Json::parse(
        R"([{"primitives":[{"attributes":{"POSITION":0},"indices":1,"targets":[{"NORMAL":2},{"NORMAL":4}]}]},
            {"primitives":[{"attributes":{"_V":3},"mode":0}]}])");
  }
  Mesh mesh;
};

// Encodes the asset, and the same asset after it became plain: both must get the same values.
void expect_same_as_plain(const CompressedAsset& asset, const char* name) {
  Document compressed = must(asset.read()), plain = compressed;
  make_meshopt_views_plain(plain);
  EXPECT_EQ(count_in(plain, "meshopt"), 0u);
  EXPECT_EQ(must(encode(compressed))[0].skipped, "");
  // Targets that are compressed stay so. Others would become attributes of the patches.
  EncodeDocumentOptions sparse;
  sparse.morph_targets = MorphTargets::kSparse;
  must(encode(plain, sparse));
  const Document again = written_and_read(compressed, name);
  ASSERT_EQ(again.records().accessors.size(), plain.records().accessors.size());
  for (size_t i = 0; i < again.records().accessors.size(); ++i) {
    const auto index = static_cast<int64_t>(i);
    if (!plain.records().accessor(index).has_view()) continue;
    EXPECT_EQ(must(read_accessor(again, index)).values, must(read_accessor(plain, index)).values) << i;
  }
  EXPECT_EQ(again.json()["accessors"].size(), compressed.json()["accessors"].size());
  EXPECT_EQ(compare_meshes(*read(plain), *read(again)), "");
}

// How many views each filter has.
std::map<std::string, size_t> filters_of(const Document& document) {
  std::map<std::string, size_t> filters;
  for (const ViewRecord& view : document.records().views)
    if (view.meshopt) ++filters[view.meshopt->filter + std::to_string(view.meshopt->count)];
  return filters;
}

TEST(Meshopt, ViewsThatNothingChangesKeepTheirBytes) {
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    for (const char* name : {"asset.glb", "asset.gltf"}) {
      std::vector<float> values(300);
      for (size_t i = 0; i < values.size(); ++i) values[i] = std::sin(0.01f * static_cast<float>(i));
      std::vector<int8_t> octahedral(400);
      for (size_t i = 0; i < 100; ++i) octahedral[4 * i] = static_cast<int8_t>(i), octahedral[4 * i + 2] = 127;
      CompressedAsset asset(extension);
      const Bytes packed[] = {compress_attributes(bytes_of(values), 12),
                              compress_attributes(bytes_of(octahedral), 4)};
      asset.add(packed[0], 12, 100, "ATTRIBUTES", nullptr, kPositions);
      asset.add(packed[1], 4, 100, "ATTRIBUTES", "OCTAHEDRAL",
                {{"componentType", 5120}, {"type", "VEC3"}, {"normalized", true}});
      asset.json()["meshes"] =
          Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"mode":0}]}])");
      Document document = must(asset.read());
      const Json before = document.json();
      must(encode(document));
      EXPECT_EQ(document.json(), before);
      const Document again = written_and_read(document, name);
      for (const size_t view : {0u, 1u}) {
        const auto index = static_cast<int64_t>(view);
        EXPECT_EQ(compressed_of(again, view), packed[view]);
        EXPECT_TRUE(std::ranges::equal(*buffer_view_bytes(again, index), *buffer_view_bytes(document, index)));
      }
      EXPECT_EQ(again.records().views[1].meshopt->filter, "OCTAHEDRAL");
      EXPECT_EQ(again.json()["extensionsRequired"], Json::array({extension}));
    }
}

TEST(Meshopt, ValuesThatMoveAreCompressedAgain) {
  const size_t points = make_grid(30, 20).point_count;
  std::vector<float> floats(3 * 4 * points);
  std::vector<int8_t> directions(3 * 4 * points);
  for (size_t i = 0; i < floats.size(); ++i) {
    floats[i] = std::sin(0.01f * static_cast<float>(i));
    directions[i] = static_cast<int8_t>(i % 4 == 2 ? 127 : i % 4 == 3 ? 0 : i / 16 % 60);
  }
  std::vector<float> moves(3 * 3 * points);
  for (size_t i = 0; i < moves.size(); ++i) moves[i] = floats[i];
  std::vector<uint32_t> exponential(moves.size());
  filter_exponential(exponential.data(), 3 * points, 12, 15, moves);
  const Json float_type = {{"componentType", 5126}, {"type", "VEC3"}};
  const Json byte_type = {{"componentType", 5120}, {"type", "VEC3"}, {"normalized", true}};
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    for (const char* name : {"asset.glb", "asset.gltf"}) {
      const MorphedAsset plain(nullptr, 12, bytes_of(moves), float_type, extension),
          filtered("EXPONENTIAL", 12, bytes_of(exponential), float_type, extension),
          octahedral("OCTAHEDRAL", 4, bytes_of(directions), byte_type, extension);
      for (const MorphedAsset* asset : {&plain, &filtered, &octahedral}) {
        expect_same_as_plain(*asset, name);
        Document document = must(asset->read());
        const std::string filter = document.records().views[2].meshopt->filter;
        must(encode(document));
        // One view as before, with as many rows.
        EXPECT_EQ(filters_of(written_and_read(document, name)),
                  (std::map<std::string, size_t>{{filter + std::to_string(3 * points), 1}}));
      }
    }
}

// The second mesh alone needs a third of the view.
TEST(Meshopt, WhatIsLeftOfAViewIsCompressedAgain) {
  const size_t points = make_grid(30, 20).point_count;
  std::vector<float> values(2 * 3 * points);
  for (size_t i = 0; i < values.size(); ++i) values[i] = std::sin(0.37f * static_cast<float>(i * i % 1009));
  CompressedAsset asset;
  const Mesh mesh = make_grid(30, 20);
  Bytes rows = bytes_of(values);
  const Bytes positions = bytes_of(values_of<float>(mesh.attributes[0]));
  std::copy(positions.begin(), positions.end(), rows.begin());
  std::vector<uint32_t> indices;
  for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
  asset.add(compress_attributes(rows, 12), 12, 2 * points, "ATTRIBUTES", nullptr, kPositions);
  asset.add(compress_triangles(indices), 2, indices.size(), "TRIANGLES", nullptr, kIndices16);
  Json& accessors = asset.json()["accessors"];
  accessors[0]["count"] = points;
  accessors.push_back(accessors[0]);
  accessors[2]["byteOffset"] = 12 * points;
  asset.json()["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0},"indices":1}]},
                                           {"primitives":[{"attributes":{"POSITION":2},"mode":0}]}])");
  expect_same_as_plain(asset, "asset.glb");
  Document document = must(asset.read());
  must(encode(document));
  EXPECT_EQ(filters_of(written_and_read(document, "asset.glb")),
            (std::map<std::string, size_t>{{"NONE" + std::to_string(points), 1}}));
}

// What gltfpack 1.x writes with -cz: version 1 of the codec of attributes, and colours by their filter.
TEST(Meshopt, Version1AndColorsAreRead) {
  const Mesh mesh = make_grid(20, 15);
  const std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  Bytes colors;
  for (size_t i = 0; i < mesh.point_count; ++i)
    colors.insert(colors.end(), {static_cast<uint8_t>(i % 200), 20, 0xf6, 0xff});
  CompressedAsset asset("KHR_meshopt_compression");
  asset.add(encode_vertices(bytes_of(positions), 12), 12, mesh.point_count, "ATTRIBUTES", nullptr, kPositions);
  asset.add(encode_vertices(colors, 4), 4, mesh.point_count, "ATTRIBUTES", "COLOR",
            {{"componentType", 5121}, {"type", "VEC4"}, {"normalized", true}});
  asset.json()["meshes"] =
      Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1},"mode":0}]}])");
  const Document document = must(asset.read());
  const AccessorData position = must(read_accessor(document, 0)), color = must(read_accessor(document, 1));
  EXPECT_EQ(std::memcmp(position.values.data(), positions.data(), position.values.size()), 0);
  for (size_t i = 0; i < mesh.point_count; ++i) {
    const auto at = [&](size_t c) { return static_cast<size_t>(color.values[4 * i + c]); };
    const size_t luma = i % 200;
    EXPECT_EQ(at(0), luma + 30);
    EXPECT_EQ(at(1), luma < 10 ? 0 : luma - 10);
    EXPECT_EQ(at(2), luma < 10 ? 0 : luma - 10);
    EXPECT_EQ(at(3), 255u);
  }
}

TEST(Meshopt, HostileViewsOfVersion1AreRefused) {
  const Bytes packed = encode_vertices(Bytes(64 * 12, 7), 12);
  const auto refusal = [&](size_t length, size_t count, const char* filter) {
    CompressedAsset asset("KHR_meshopt_compression");
    asset.add(packed, 12, 64, "ATTRIBUTES", filter, kPositions);
    Json& meshopt = asset.json()["bufferViews"][0]["extensions"]["KHR_meshopt_compression"];
    meshopt["byteLength"] = length;
    meshopt["count"] = count;
    const Expected<Document> document = asset.read();
    return document ? std::string("loads") : document.status().message();
  };
  EXPECT_EQ(refusal(packed.size(), 64, nullptr), "loads");
  for (size_t length = 0; length < packed.size(); ++length)
    EXPECT_TRUE(contains(refusal(length, 64, nullptr), "buffer view 0")) << length;
  EXPECT_TRUE(contains(refusal(packed.size(), 3 * 256, nullptr), "cannot be decoded"));
  EXPECT_TRUE(contains(refusal(packed.size(), 100000000, nullptr), "more elements"));
  EXPECT_TRUE(contains(refusal(packed.size(), 64, "COLOR"), "an illegal combination of mode"));
}

// Nothing is known of a newer codec, so its views stay as they are, in one buffer without bytes, while other
// views are decoded. It may store more zeros in a byte than the known codec.
TEST(Meshopt, ViewsOfANewerCodecStayAsTheyAre) {
  const Mesh mesh = make_grid(20, 15);
  std::vector<uint32_t> indices;
  for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
  Bytes newer(40, 0);
  newer[0] = 0xa2;
  CompressedAsset asset("KHR_meshopt_compression");
  asset.add(newer, 12, mesh.point_count, "ATTRIBUTES", nullptr, kPositions);
  asset.add(compress_triangles(indices), 2, indices.size(), "TRIANGLES", nullptr, kIndices16);
  asset.add(newer, 12, mesh.point_count, "ATTRIBUTES", nullptr, kPositions);
  asset.json()["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0},"indices":1},
                                                          {"attributes":{"POSITION":2},"indices":1}]}])");
  const Document before = must(asset.read());
  Document document = before;
  const auto reports =
      must(encode_document(document, EncodeDocumentOptions(), reference_backend(), test_pool()));
  EXPECT_TRUE(contains(reports[0].skipped, "newer meshoptimizer"));
  PackedDocument packed = pack_buffers(document, false);
  list_buffers(packed);
  EXPECT_EQ(packed.json["buffers"].size(), 2u);
  const Document again = written_and_read(document, "asset.glb");
  for (const size_t view : {0u, 1u, 2u}) EXPECT_EQ(compressed_of(again, view), compressed_of(before, view));
  EXPECT_TRUE(std::ranges::equal(*buffer_view_bytes(again, 1), *buffer_view_bytes(before, 1)));
}

// The targets move points in the order of the file, which takes few bytes in that order alone.
TEST(Meshopt, AnAssetStaysAsItIsIfAnotherOrderMakesItLarger) {
  constexpr size_t kTargets = 12;
  Mesh mesh = make_grid(30, 20);
  std::vector<uint32_t> order(mesh.point_count);
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i * 1009 % mesh.point_count;
  std::vector<float> positions(3 * order.size()), moves(3 * order.size());
  const std::vector<float> from = values_of<float>(mesh.attributes[0]);
  for (size_t i = 0; i < order.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      positions[3 * order[i] + c] = from[3 * i + c];
      moves[3 * i + c] = static_cast<float>(i / 64);
    }
  std::vector<uint32_t> indices;
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) indices.push_back(order[point]);
  CompressedAsset asset;
  asset.add(compress_attributes(bytes_of(positions), 12), 12, order.size(), "ATTRIBUTES", nullptr, kPositions);
  asset.add(compress_triangles(indices), 2, indices.size(), "TRIANGLES", nullptr, kIndices16);
  Json targets = Json::array();
  for (size_t i = 0; i < kTargets; ++i)
    targets.push_back(
        {{"NORMAL", asset.add(compress_attributes(bytes_of(moves), 12), 12, order.size(), "ATTRIBUTES", nullptr,
                              {{"componentType", 5126}, {"type", "VEC3"}})}});
  asset.json()["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"targets", targets}}}}}};
  Document document = must(asset.read());
  const Json before = document.json();
  const auto reports =
      must(encode_document(document, EncodeDocumentOptions(), reference_backend(), test_pool()));
  EXPECT_TRUE(contains(reports[0].skipped, "the asset would take "));
  EXPECT_EQ(document.json(), before);
}

// Loaders without the extension read the plain bytes, which the file has as well.
TEST(Meshopt, AFallbackThatWasShippedIsShipped) {
  const TestFolder folder;
  CompressedAsset asset;
  const Bytes rows = bytes_of(std::vector<float>(300, 0.5f));
  asset.add(compress_attributes(rows, 12), 12, 100, "ATTRIBUTES", nullptr, kPositions);
  asset.json()["meshes"] = Json::parse(R"([{"primitives":[{"attributes":{"POSITION":0},"mode":0}]}])");
  asset.json().erase("extensionsRequired");
  Document document = must(asset.read());
  document.json()["buffers"][1].erase("extensions");  // its bytes are written
  const Document shipped = written_and_read(document, "asset.gltf");
  for (const char* name : {"asset.glb", "asset.gltf"}) {
    const Document again = written_and_read(shipped, name);
    EXPECT_EQ(compressed_of(again, 0), compressed_of(document, 0));
    EXPECT_EQ(again.json()["extensionsUsed"], Json::array({"EXT_meshopt_compression"}));
    EXPECT_FALSE(again.json().contains("extensionsRequired"));
    EXPECT_FALSE(is_placeholder(again, static_cast<size_t>(again.records().views[0].range.buffer)));
    EXPECT_EQ(must(read_accessor(again, 0)).values.size(), rows.size());
    for (const auto& buffer : again.json()["buffers"]) EXPECT_FALSE(is_meshopt_fallback(buffer));
  }
}

}  // namespace
}  // namespace psplit
