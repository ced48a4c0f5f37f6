#include "gltf_ext/primitive/accessors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// A document with the bytes 0, 1, 2 ... in view 0, and with the given accessor.
Document counting(size_t byte_count, const char* accessor) {
  Document document = new_document();
  std::vector<uint8_t> bytes(byte_count);
  for (size_t i = 0; i < byte_count; ++i) bytes[i] = static_cast<uint8_t>(i);
  append_buffer_view(document, bytes);
  document.json()["accessors"] = Json::array({Json::parse(accessor)});
  return document;
}

std::vector<int> values(const Expected<AccessorData>& data) {
  std::vector<int> numbers;
  if (data)
    for (const std::byte value : data->values) numbers.push_back(static_cast<int>(value));
  return numbers;
}

AccessorData floats(uint8_t components, const std::vector<float>& numbers) {
  AccessorData data{ComponentType::kFloat32, components, false, 0, {}};
  data.count = static_cast<uint32_t>(numbers.size() / components);
  data.values.resize(numbers.size() * sizeof(float));
  std::memcpy(data.values.data(), numbers.data(), data.values.size());
  return data;
}

TEST(ReadAccessor, TakesStridesAndOffsets) {
  Document document = counting(
      12, R"({"bufferView":0,"byteOffset":1,"componentType":5121,"type":"VEC2","count":3,"normalized":true})");
  document.json()["bufferViews"][0]["byteStride"] = 4;
  const auto data = read_accessor(document, 0);
  EXPECT_EQ(values(data), (std::vector<int>{1, 2, 5, 6, 9, 10}));
  EXPECT_TRUE(data->normalized);
}

TEST(ReadAccessor, TakesPaddingOutOfMatrices) {
  EXPECT_EQ(
      values(read_accessor(counting(8, R"({"bufferView":0,"componentType":5121,"type":"MAT2","count":1})"), 0)),
      (std::vector<int>{0, 1, 4, 5}));
  EXPECT_EQ(values(read_accessor(
                counting(12, R"({"bufferView":0,"componentType":5121,"type":"MAT3","count":1})"), 0)),
            (std::vector<int>{0, 1, 2, 4, 5, 6, 8, 9, 10}));
  EXPECT_EQ(values(read_accessor(
                counting(24, R"({"bufferView":0,"componentType":5123,"type":"MAT3","count":1})"), 0)),
            (std::vector<int>{0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, 16, 17, 18, 19, 20, 21}));
}

TEST(ReadAccessor, MissingBufferViewIsZeros) {
  EXPECT_EQ(values(read_accessor(counting(1, R"({"componentType":5123,"type":"VEC2","count":2})"), 0)),
            std::vector<int>(8, 0));
  const auto absurd =
      read_accessor(counting(1, R"({"componentType":5126,"type":"MAT4","count":4294967295})"), 0);
  EXPECT_EQ(absurd.status().code(), StatusCode::kInvalidInput);
}

TEST(ReadAccessor, SparseReplacesValues) {
  const char* sparse = R"({"componentType":5121,"type":"VEC2","count":4,"sparse":{"count":2,
    "indices":{"bufferView":0,"byteOffset":1,"componentType":5121},"values":{"bufferView":0,"byteOffset":8}}})";
  EXPECT_EQ(values(read_accessor(counting(12, sparse), 0)), (std::vector<int>{0, 0, 8, 9, 10, 11, 0, 0}));
  Document over = counting(12, sparse);
  over.json()["accessors"][0]["bufferView"] = 0;
  EXPECT_EQ(values(read_accessor(over, 0)), (std::vector<int>{0, 1, 8, 9, 10, 11, 6, 7}));
}

TEST(ReadAccessor, RefusesWrongSparse) {
  const char* sparse = R"({"componentType":5121,"type":"SCALAR","count":2,"sparse":{"count":2,
    "indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}})";
  const auto with = [&](const char* pointer, const Json& value) {
    Document document = counting(4, sparse);
    document.json()["accessors"][0]["sparse"][Json::json_pointer(pointer)] = value;
    return document.check().ok() ? read_accessor(document, 0).status().code() : document.check().code();
  };
  EXPECT_EQ(with("/count", 2), StatusCode::kOk);
  EXPECT_EQ(with("/count", 3), StatusCode::kInvalidInput);
  EXPECT_EQ(with("/count", -1), StatusCode::kInvalidInput);
  EXPECT_EQ(with("/indices/componentType", 5126), StatusCode::kInvalidInput);
  EXPECT_EQ(with("/indices/byteOffset", 2), StatusCode::kInvalidInput);  // index 2 of 2
  EXPECT_EQ(with("/indices/bufferView", 9), StatusCode::kInvalidInput);
  EXPECT_EQ(with("/values/byteOffset", 3), StatusCode::kInvalidInput);
  EXPECT_EQ(with("/values", "text"), StatusCode::kInvalidInput);
}

TEST(ReadAccessor, RefusesWhatDoesNotFit) {
  const auto with = [](const char* name, const Json& value) {
    Document document = counting(12, R"({"bufferView":0,"componentType":5121,"type":"VEC3","count":4})");
    document.json()["accessors"][0][name] = value;
    return document.check().code();
  };
  EXPECT_EQ(with("count", 4), StatusCode::kOk);
  EXPECT_EQ(with("count", 5), StatusCode::kInvalidInput);
  EXPECT_EQ(with("count", 4294967295), StatusCode::kInvalidInput);
  EXPECT_EQ(with("count", "4"), StatusCode::kInvalidInput);
  EXPECT_EQ(with("byteOffset", 1), StatusCode::kInvalidInput);
  EXPECT_EQ(with("byteOffset", std::numeric_limits<int64_t>::max()), StatusCode::kInvalidInput);
  EXPECT_EQ(with("bufferView", 1), StatusCode::kInvalidInput);
  EXPECT_EQ(with("bufferView", nullptr), StatusCode::kInvalidInput);
  EXPECT_EQ(with("type", 3), StatusCode::kInvalidInput);
  for (const int64_t index : {-1, 1}) {
    Document document = new_document();
    document.json()["meshes"][0]["primitives"][0]["indices"] = index;
    EXPECT_EQ(document.check().code(), StatusCode::kInvalidInput);
  }
}

TEST(AppendAccessor, ReadsBackWithBounds) {
  Document document = new_document();
  const AccessorData data = floats(3, {1, 0.1f, -3, 4, NAN, 6});
  const int64_t index = append_accessor(document, data, 34962, true);
  const Json& accessor = document.json()["accessors"][static_cast<size_t>(index)];
  EXPECT_EQ(accessor["min"], Json({1.0f, 0.1f, -3.0f}));
  EXPECT_EQ(accessor["max"], Json({4.0f, 0.1f, 6.0f}));
  EXPECT_EQ(document.json()["bufferViews"][0]["target"], 34962);
  EXPECT_EQ(read_accessor(document, index)->values, data.values);
  // JSON text keeps every float exactly.
  EXPECT_EQ(Json::parse(accessor.dump())["min"][1].get<float>(), 0.1f);
}

TEST(AppendAccessor, PadsVertexAttributesAndMatrices) {
  Document document = new_document();
  const AccessorData colors{
      ComponentType::kUint8,
      3,
      true,
      2,
      {std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}, std::byte{6}}};
  EXPECT_EQ(append_accessor(document, colors, 34962, true), 0);
  EXPECT_EQ(document.json()["bufferViews"][0]["byteStride"], 4);
  EXPECT_EQ(document.json()["accessors"][0]["max"], Json({4, 5, 6}));
  EXPECT_EQ(read_accessor(document, 0)->values, colors.values);

  const AccessorData matrix{ComponentType::kInt8, 9, false, 1, Array<std::byte>(9, std::byte{0xff})};
  EXPECT_EQ(append_accessor(document, matrix, 0, true), 1);
  EXPECT_EQ(document.json()["bufferViews"][1]["byteLength"], 12);
  EXPECT_EQ(document.json()["accessors"][1]["min"], Json(std::vector<int>(9, -1)));
  EXPECT_EQ(read_accessor(document, 1)->values, matrix.values);
}

TEST(DescribeDecoded, KeepsOtherMembers) {
  Json accessor = Json::parse(
      R"({"name":"n","bufferView":3,"byteOffset":4,"sparse":{},"count":9,"min":[0],"max":[9],"extras":1})");
  describe_decoded(accessor, floats(1, {2, -5}), true);
  EXPECT_EQ(accessor, Json::parse(R"({"name":"n","count":2,"min":[-5.0],"max":[2.0],"extras":1})"));
  describe_decoded(accessor, floats(1, {2}), false);
  EXPECT_EQ(accessor, Json::parse(R"({"name":"n","count":1,"extras":1})"));
}

}  // namespace
}  // namespace psplit
