// All forms of primitives that glTF allows, read as triangles.

#include "gltf_ext/primitive/read_primitives.h"

#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

using Triangles = Array<std::array<uint32_t, 3>>;

// Six points. Primitive 0 has this mode, and these indices unless they are empty.
Document six_points(int mode, const std::vector<uint32_t>& indices,
                    ComponentType type = ComponentType::kUint32) {
  std::vector<float> positions;
  for (int i = 0; i < 6; ++i)
    positions.insert(positions.end(), {static_cast<float>(i % 3), static_cast<float>(i / 3), 0});
  Document document = document_from_mesh(make_mesh(positions, {{0, 1, 2}}));
  Json& primitive = primitive_of(document);
  primitive.erase("indices");
  if (mode != 4) primitive["mode"] = mode;
  if (indices.empty()) return document;
  AccessorData data{type, 1, false, static_cast<uint32_t>(indices.size()), {}};
  for (const uint32_t index : indices) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&index);
    data.values.insert(data.values.end(), bytes, bytes + component_bytes(type));
  }
  primitive["indices"] = append_accessor(document, data, 34963, false);
  return document;
}

Triangles faces_of(const Document& document) { return must(read(document)).faces; }

Status status_of(const Document& document) { return read(document).status(); }

TEST(ReadPrimitive, TakesIndicesOfEveryWidth) {
  for (const ComponentType type : {ComponentType::kUint8, ComponentType::kUint16, ComponentType::kUint32})
    EXPECT_EQ(faces_of(six_points(4, {5, 4, 3, 0, 1, 4}, type)), (Triangles{{5, 4, 3}, {0, 1, 4}}));
}

TEST(ReadPrimitive, CountsWhereThereAreNoIndices) {
  EXPECT_EQ(faces_of(six_points(4, {})), (Triangles{{0, 1, 2}, {3, 4, 5}}));
}

// The orientation follows section 3.7.2.1 of the glTF specification.
TEST(ReadPrimitive, MakesListsOfStripsAndFans) {
  EXPECT_EQ(faces_of(six_points(5, {})), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}}));
  EXPECT_EQ(faces_of(six_points(6, {})), (Triangles{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}, {4, 5, 0}}));
  EXPECT_EQ(faces_of(six_points(5, {5, 3, 1, 1, 0})), (Triangles{{5, 3, 1}, {3, 1, 1}, {1, 1, 0}}));
  EXPECT_EQ(faces_of(six_points(6, {5, 3, 1, 0})), (Triangles{{3, 1, 5}, {1, 0, 5}}));
  EXPECT_TRUE(faces_of(six_points(5, {1, 2})).empty());
}

TEST(ReadPrimitive, PointsAndLinesHaveNoTriangles) {
  for (const int mode : {0, 1, 2, 3}) {
    const Document document = six_points(mode, {});
    EXPECT_FALSE(document.records().primitive({0, 0}).has_triangles());
    EXPECT_EQ(status_of(document).code(), StatusCode::kUnsupported);
  }
}

TEST(ReadPrimitive, TakesInterleavedAndSparseAccessors) {
  Document document = new_document();
  // Four points of 3 floats and 2 normalized integers, 16 bytes each.
  std::vector<uint8_t> bytes(64);
  for (uint32_t i = 0; i < 4; ++i) {
    const std::array<float, 3> position = {static_cast<float>(i % 2), static_cast<float>(i / 2), 7};
    const std::array<uint16_t, 2> uv = {static_cast<uint16_t>(i * 1000), 65535};
    std::memcpy(bytes.data() + i * 16, position.data(), 12);
    std::memcpy(bytes.data() + i * 16 + 12, uv.data(), 4);
  }
  append_buffer_view(document, bytes);
  document.json()["bufferViews"][0]["byteStride"] = 16;
  const std::array<float, 3> moved = {9, 8, 7};
  std::vector<uint8_t> sparse(16);
  sparse[0] = 3;
  std::memcpy(sparse.data() + 4, moved.data(), 12);
  append_buffer_view(document, sparse);
  document.json()["accessors"] = Json::parse(R"([
    {"bufferView":0,"componentType":5126,"type":"VEC3","count":4,"sparse":{"count":1,
     "indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":1,"byteOffset":4}}},
    {"bufferView":0,"byteOffset":12,"componentType":5123,"normalized":true,"type":"VEC2","count":4}])");
  document.json()["meshes"] =
      Json::parse(R"([{"primitives":[{"mode":5,"attributes":{"POSITION":0,"TEXCOORD_0":1}}]}])");
  const Mesh mesh = must(read(document));
  EXPECT_EQ(values_of<float>(*mesh.find("POSITION")), (std::vector<float>{0, 0, 7, 1, 0, 7, 0, 1, 7, 9, 8, 7}));
  EXPECT_EQ(values_of<uint16_t>(*mesh.find("TEXCOORD_0")),
            (std::vector<uint16_t>{0, 65535, 1000, 65535, 2000, 65535, 3000, 65535}));
  EXPECT_TRUE(mesh.find("TEXCOORD_0")->normalized);
}

TEST(ReadPrimitive, KeepsEveryKindOfAttribute) {
  const Mesh mesh = rich_mesh();
  const Mesh again = must(read(document_from_mesh(mesh)));
  EXPECT_EQ(compare_meshes(mesh, again), "");
}

TEST(ReadPrimitive, SaysWhereAndWhatIsWrong) {
  const auto with = [](const std::function<void(Document&, Json&)>& change) {
    Document document = six_points(4, {0, 1, 2});
    document.source = "asset.glb";
    change(document, primitive_of(document));
    return status_of(document).to_string();
  };
  const auto names = [](const std::string& text, const char* cause) {
    return text.starts_with("asset.glb: mesh 0, primitive 0: ") && text.find(cause) != std::string::npos;
  };
  const std::string far = with([](Document& document, Json& primitive) {
    primitive["indices"] =
        append_accessor(document, make_data<uint8_t>(ComponentType::kUint8, 1, {0, 1, 6}), 34963, false);
  });
  EXPECT_TRUE(names(far, "index 2 is 6")) << far;
  const std::string restart = with([](Document& document, Json& primitive) {
    primitive["indices"] =
        append_accessor(document, make_data<uint8_t>(ComponentType::kUint8, 1, {0, 255, 1}), 34963, false);
  });
  EXPECT_TRUE(names(restart, "index 1 is 255, which restarts primitives")) << restart;
  const std::string pair = with([](Document& document, Json& primitive) {
    primitive["indices"] =
        append_accessor(document, make_data<uint8_t>(ComponentType::kUint8, 1, {0, 1}), 34963, false);
  });
  EXPECT_TRUE(names(pair, "a triangle list has 2 indices")) << pair;
  const std::string floats =
      with([](Document&, Json& primitive) { primitive["indices"] = primitive["attributes"]["POSITION"]; });
  EXPECT_TRUE(names(floats, "indices are not unsigned scalars")) << floats;
  const std::string shorter = with([](Document& document, Json& primitive) {
    primitive["attributes"]["_A"] =
        append_accessor(document, make_data<float>(ComponentType::kFloat32, 1, {1, 2}), 34962, false);
  });
  EXPECT_TRUE(names(shorter, "attribute _A has 2 elements, others have 6")) << shorter;
  const std::string mode = with([](Document&, Json& primitive) { primitive["mode"] = 7; });
  EXPECT_TRUE(names(mode, "unknown mode")) << mode;
  const std::string number =
      with([](Document&, Json& primitive) { primitive["extensions"][kExtensionName] = 3; });
  EXPECT_TRUE(names(number, "is not an object")) << number;
  const std::string nothing =
      with([](Document&, Json& primitive) { primitive["attributes"] = Json::object(); });
  EXPECT_TRUE(names(nothing, "no POSITION")) << nothing;
}

TEST(ReadMorphTargets, ListsThemInOrder) {
  Document document = six_points(4, {0, 1, 2});
  const AccessorData data = make_data<float>(ComponentType::kFloat32, 3, std::vector<float>(18, 0.5f));
  const int64_t index = append_accessor(document, data, 34962, false);
  primitive_of(document)["targets"] = Json::array({{{"POSITION", index}}, {{"NORMAL", index}, {"_A", index}}});
  const auto morphs = must(read_morph_targets(document, {0, 0}));
  ASSERT_EQ(morphs.size(), 3u);
  EXPECT_EQ(morphs[0].target, 0u);
  EXPECT_EQ(morphs[1].target, 1u);
  EXPECT_EQ(morphs[2].semantic, "_A");
  EXPECT_EQ(morphs[2].data.values, data.values);
}

TEST(GroupEqualPrimitives, JoinsWhatDiffersInMaterialsOnly) {
  Document document = six_points(4, {0, 1, 2});
  Json& primitives = document.json()["meshes"][0]["primitives"];
  for (int i = 0; i < 3; ++i) primitives.push_back(Json(primitives[0]));
  primitives[1]["material"] = 3;
  primitives[2]["mode"] = 6;
  primitives[3]["targets"] = Json::array({{{"POSITION", 0}}});
  const auto groups = group_equal_primitives(document, all_primitives(document));
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].ids.size(), 2u);
}

}  // namespace
}  // namespace psplit
