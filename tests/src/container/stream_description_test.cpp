// The glTF attributes that Draco attributes become.
#include "psplit/decode.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

StreamAttribute attribute(uint32_t unique_id, DracoSemantic semantic, DataType type, uint8_t components,
                          bool normalized = false) {
  return {unique_id, semantic, type, components, normalized, 0};
}

const StreamAttribute kPositions = attribute(0, DracoSemantic::kPosition, DataType::kFloat32, 3);

// "COLOR_0 5121x4 normalized" for the attribute after the positions.
std::string named(const StreamAttribute& second) {
  const StreamAttribute both[] = {kPositions, second};
  const auto requests = gltf_attributes(both);
  if (!requests) return requests.status().message();
  EXPECT_EQ((*requests)[0].semantic, "POSITION");
  const AttributeRequest& request = (*requests)[1];
  EXPECT_EQ(request.unique_id, second.unique_id);
  return request.semantic + " " + std::to_string(static_cast<int>(request.component_type)) + "x" +
         std::to_string(request.component_count) + (request.normalized ? " normalized" : "");
}

TEST(GltfAttributes, TakeTheNamesThatGltfAllowsForTheirData) {
  EXPECT_EQ(named(attribute(7, DracoSemantic::kNormal, DataType::kFloat32, 3)), "NORMAL 5126x3");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kNormal, DataType::kInt8, 3, true)), "NORMAL 5120x3 normalized");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kNormal, DataType::kInt16, 3)), "_GENERIC_0 5122x3");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kNormal, DataType::kUint8, 3, true)),
            "_GENERIC_0 5121x3 normalized");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kTexCoord, DataType::kInt16, 2)), "TEXCOORD_0 5122x2");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kTexCoord, DataType::kFloat32, 2)), "TEXCOORD_0 5126x2");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kTexCoord, DataType::kFloat32, 3)), "_GENERIC_0 5126x3");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kColor, DataType::kUint8, 4)), "COLOR_0 5121x4 normalized");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kColor, DataType::kUint16, 3)), "COLOR_0 5123x3 normalized");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kColor, DataType::kFloat32, 3)), "COLOR_0 5126x3");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kColor, DataType::kInt16, 3)), "_GENERIC_0 5122x3");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kColor, DataType::kUint8, 1)), "_GENERIC_0 5121x1");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kGeneric, DataType::kUint16, 1)), "_GENERIC_0 5123x1");
  EXPECT_EQ(named(attribute(7, DracoSemantic::kGeneric, DataType::kBool, 1)), "_GENERIC_0 5121x1");
}

TEST(GltfAttributes, BecomeFloatsWhereGltfHasNoSuchType) {
  for (const DataType type :
       {DataType::kInt32, DataType::kUint32, DataType::kInt64, DataType::kUint64, DataType::kFloat64})
    EXPECT_EQ(named(attribute(7, DracoSemantic::kGeneric, type, 16, true)), "_GENERIC_0 5126x16");
  const StreamAttribute doubles[] = {attribute(3, DracoSemantic::kPosition, DataType::kFloat64, 3)};
  const auto requests = must(gltf_attributes(doubles));
  EXPECT_EQ(requests.front().semantic, "POSITION");
}

TEST(GltfAttributes, HaveUniqueSemantics) {
  std::vector<StreamAttribute> attributes;
  const DracoSemantic semantics[] = {DracoSemantic::kGeneric, DracoSemantic::kPosition,
                                     DracoSemantic::kPosition, DracoSemantic::kNormal, DracoSemantic::kNormal};
  for (const DracoSemantic semantic : semantics)
    attributes.push_back(attribute(static_cast<uint32_t>(attributes.size()), semantic, DataType::kFloat32, 3));
  for (int i = 0; i < 2; ++i)
    attributes.push_back(
        attribute(static_cast<uint32_t>(attributes.size()), DracoSemantic::kTexCoord, DataType::kFloat32, 2));
  const auto requests = must(gltf_attributes(attributes));
  std::vector<std::string> names;
  for (const AttributeRequest& request : requests) names.push_back(request.semantic);
  EXPECT_EQ(names, (std::vector<std::string>{"_GENERIC_0", "POSITION", "_GENERIC_1", "NORMAL", "_GENERIC_2",
                                             "TEXCOORD_0", "TEXCOORD_1"}));
}

TEST(GltfAttributes, OfWhichThereAreManyTakeNoTimeToName) {
  std::vector<StreamAttribute> attributes = {kPositions};
  for (uint32_t i = 1; i < 50'000; ++i)
    attributes.push_back(attribute(i, DracoSemantic::kGeneric, DataType::kFloat32, 1));
  const auto requests = must(gltf_attributes(attributes));
  EXPECT_EQ(requests.back().semantic, "_GENERIC_49998");
}

TEST(GltfAttributes, RefuseWhatNoGltfAssetHolds) {
  for (const uint8_t components : std::initializer_list<uint8_t>{0, 5, 8, 10, 17, 255}) {
    const StreamAttribute both[] = {kPositions,
                                    attribute(1, DracoSemantic::kGeneric, DataType::kFloat32, components)};
    EXPECT_EQ(gltf_attributes(both).status().code(), StatusCode::kUnsupported) << int{components};
  }
  EXPECT_EQ(gltf_attributes({}).status().message(), "has no positions");
  const StreamAttribute pairs[] = {attribute(0, DracoSemantic::kPosition, DataType::kInt16, 2)};
  EXPECT_EQ(gltf_attributes(pairs).status().code(), StatusCode::kInvalidInput);
  EXPECT_EQ(named(attribute(0, DracoSemantic::kNormal, DataType::kFloat32, 3)),
            "two attributes have the unique id 0");
}

}  // namespace
}  // namespace psplit
