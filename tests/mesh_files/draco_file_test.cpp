// .drc files whose values are not floats, and what they say beside their geometry.
#include "mesh_files/draco_file.h"

#include "gltf_ext/primitive/accessors.h"
#include "psplit/encode.h"
#include "tests/mesh_files/mesh_text.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

// A strip of triangles whose point i has the values f(3 i), f(3 i + 1), f(3 i + 2).
template <typename T>
Attribute vectors(const std::string& semantic, ComponentType type, bool normalized,
                  const std::vector<T>& values, uint8_t components = 3) {
  Attribute attribute{semantic, type, components, normalized, {}};
  attribute.values.resize(values.size() * sizeof(T));
  std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  return attribute;
}

Mesh strip(Attribute positions) {
  Mesh mesh;
  mesh.point_count = static_cast<uint32_t>(positions.values.size() / positions.stride());
  for (uint32_t i = 0; i + 2 < mesh.point_count; ++i) mesh.faces.push_back({i, i + 1, i + 2});
  mesh.attributes.push_back(std::move(positions));
  return mesh;
}

std::vector<uint8_t> drc_of(const Mesh& mesh) {
  const std::vector<AttributeCoding> codings(mesh.attributes.size());
  return must(encode_stock_sequential(mesh, codings, 5)).bytes;
}

Expected<Asset> read_drc(const std::vector<uint8_t>& bytes) {
  return read_asset(memory_stream(bytes), "a.drc", describe_stream);
}

template <typename T>
void expect_exact(ComponentType type, bool normalized, const std::vector<T>& values) {
  const Expected<Asset> asset = read_drc(drc_of(strip(vectors("POSITION", type, normalized, values))));
  ASSERT_TRUE(asset.ok()) << asset.status().to_string();
  EXPECT_EQ(warnings_of(asset), "");
  EXPECT_EQ(asset->document.json()["extensionsRequired"],
            Json::array({"KHR_draco_mesh_compression", "KHR_mesh_quantization"}));
  const Mesh mesh = mesh_of(asset);
  ASSERT_NE(mesh.find("POSITION"), nullptr);
  EXPECT_EQ(mesh.find("POSITION")->component_type, type);
  EXPECT_EQ(mesh.find("POSITION")->normalized, normalized);
  EXPECT_EQ(values_of<T>(*mesh.find("POSITION")), values);
}

TEST(DracoFile, PositionsOfSmallIntegersAreExact) {
  for (const bool normalized : {false, true}) {
    expect_exact<int8_t>(ComponentType::kInt8, normalized, {-128, 0, 1, 127, 2, 3, 4, -5, 6, 7, 8, 99});
    expect_exact<uint8_t>(ComponentType::kUint8, normalized, {255, 0, 1, 127, 2, 3, 4, 5, 6, 7, 8, 99});
    expect_exact<int16_t>(ComponentType::kInt16, normalized, {-32768, 0, 1, 32767, 2, 3, 4, 5, 6, 7, 8, 9});
    expect_exact<uint16_t>(ComponentType::kUint16, normalized, {65535, 0, 1, 32767, 2, 3, 4, 5, 6, 7, 8, 9});
  }
}

// Values in the types of a stream.
struct RawAttribute {
  DracoSemantic semantic;
  DataType type;
  uint8_t components;
  bool normalized;
  std::string values;  // of kTrianglePoints points
};

template <typename T>
std::string raw(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

constexpr uint8_t kTrianglePoints = 3;
const RawAttribute kTriangle{DracoSemantic::kPosition, DataType::kFloat32, 3, false,
                             raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0})};

// A sequential stream without compression, of a triangle or of its points. Attribute i has the unique id i.
std::vector<uint8_t> raw_stream(const std::vector<RawAttribute>& attributes,
                                const std::vector<uint8_t>& metadata = {}, bool is_cloud = false) {
  const auto put = [](std::vector<uint8_t>& bytes, const auto& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
  };
  std::vector<uint8_t> bytes{'D', 'R', 'A', 'C', 'O', 2, 2, !is_cloud, 0, 0, 0};
  if (!metadata.empty()) bytes.back() = 0x80;
  put(bytes, metadata);
  if (is_cloud)
    put(bytes, std::vector<uint8_t>{kTrianglePoints, 0, 0, 0});
  else
    put(bytes, std::vector<uint8_t>{1, kTrianglePoints, 1, 0, 1, 2});  // one face, its indices uncompressed
  bytes.push_back(1);                                                  // a group of all attributes
  bytes.push_back(static_cast<uint8_t>(attributes.size()));
  for (uint8_t i = 0; i < attributes.size(); ++i) {
    const RawAttribute& attribute = attributes[i];
    put(bytes,
        std::vector<uint8_t>{static_cast<uint8_t>(attribute.semantic), static_cast<uint8_t>(attribute.type),
                             attribute.components, attribute.normalized, i});
  }
  bytes.resize(bytes.size() + attributes.size());  // each is raw
  for (const RawAttribute& attribute : attributes) put(bytes, attribute.values);
  return bytes;
}

template <typename T>
RawAttribute generic(DataType type, std::initializer_list<T> values, bool normalized = false) {
  return {DracoSemantic::kGeneric, type, 1, normalized, raw(values)};
}

TEST(DracoFile, NumbersThatNoFloatHoldsAreCounted) {
  const auto warnings = [](const RawAttribute& attribute) {
    return warnings_of(read_drc(raw_stream({kTriangle, attribute})));
  };
  EXPECT_EQ(warnings(generic<int32_t>(DataType::kInt32, {-16777216, INT32_MIN, 2147483520})), "");
  EXPECT_EQ(warnings(generic<int32_t>(DataType::kInt32, {-16777217, INT32_MAX, 5})),
            "2 whole numbers of _GENERIC_0 are rounded: no floats are equal to them\n");
  EXPECT_EQ(warnings(generic<uint32_t>(DataType::kUint32, {1, 16777218, UINT32_MAX})),
            "1 whole number of _GENERIC_0 is rounded: no float is equal to it\n");
  EXPECT_EQ(warnings(generic<int64_t>(DataType::kInt64, {INT64_MIN, 1LL << 40, -3})), "");
  EXPECT_EQ(warnings(generic<int64_t>(DataType::kInt64, {INT64_MAX, (1LL << 40) + 1, INT64_MIN + 1})),
            "3 whole numbers of _GENERIC_0 are rounded: no floats are equal to them\n");
  EXPECT_EQ(warnings(generic<uint64_t>(DataType::kUint64, {UINT64_MAX, 1ULL << 63, 0})),
            "1 whole number of _GENERIC_0 is rounded: no float is equal to it\n");
  EXPECT_EQ(warnings(generic<double>(DataType::kFloat64, {NAN, HUGE_VAL, 0.5})), "");
  EXPECT_EQ(warnings(generic<double>(DataType::kFloat64, {0.1, 1e300, 1e-320})),
            "3 doubles of _GENERIC_0 are rounded: no floats are equal to them\n");
  // Fractions of the largest number.
  EXPECT_EQ(warnings(generic<int32_t>(DataType::kInt32, {1, INT32_MAX, 0}, true)),
            "1 fraction of _GENERIC_0 is rounded: no float is equal to it\n");
  EXPECT_EQ(warnings(generic<uint8_t>(DataType::kBool, {0, 1, 1})), "");
}

void put(std::vector<uint8_t>& bytes, const std::string& text) {
  size_t size = text.size();
  for (; size >= 0x80; size >>= 7) bytes.push_back(static_cast<uint8_t>(size | 0x80));
  bytes.push_back(static_cast<uint8_t>(size));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

using Entries = std::vector<std::pair<std::string, std::string>>;

// The entries of a part, and of a part in it if `part` names one.
void put_tree(std::vector<uint8_t>& bytes, const Entries& entries, const std::string& part = {},
              const Entries& entries_of_part = {}) {
  bytes.push_back(static_cast<uint8_t>(entries.size()));
  for (const auto& [name, value] : entries) put(bytes, name), put(bytes, value);
  bytes.push_back(!part.empty());
  if (part.empty()) return;
  put(bytes, part);
  put_tree(bytes, entries_of_part);
}

std::vector<uint8_t> metadata_of(const std::vector<std::pair<uint8_t, Entries>>& attributes,
                                 const Entries& geometry, const std::string& part = {},
                                 const Entries& entries_of_part = {}) {
  std::vector<uint8_t> bytes{static_cast<uint8_t>(attributes.size())};
  for (const auto& [id, entries] : attributes) {
    bytes.push_back(id);
    put_tree(bytes, entries);
  }
  put_tree(bytes, geometry, part, entries_of_part);
  return bytes;
}

Json extras_of(const Document& document, const char* semantic) {
  const Json& json = document.json();
  return json["accessors"][json["meshes"][0]["primitives"][0]["attributes"][semantic].get<size_t>()]["extras"];
}

// Of a cloud the accessors have the values.
template <typename T>
std::vector<T> values_in(const Document& document, const char* semantic) {
  const Json& attributes = document.json()["meshes"][0]["primitives"][0]["attributes"];
  if (document.cloud) {
    const AccessorData data = must(read_accessor(document, attributes[semantic].get<int64_t>()));
    return values_of<T>(Attribute{semantic, data.component_type, data.component_count, false, data.values});
  }
  const Mesh mesh = must(read_primitive(document, {0, 0}, cpu_backend(), ThreadPool(1)));
  return mesh.find(semantic) == nullptr ? std::vector<T>() : values_of<T>(*mesh.find(semantic));
}

std::vector<RawAttribute> triangle_with_bytes(uint8_t count) {
  std::vector<RawAttribute> attributes{kTriangle};
  for (uint8_t i = 0; i < count; ++i)
    attributes.push_back(generic<uint8_t>(DataType::kUint8, {1, 2, static_cast<uint8_t>(3 + i)}));
  return attributes;
}

const std::vector<uint8_t> kNamesAndMore = metadata_of(
    {{1, {{"name", "attr_x"}, {"unit", "m/s"}, {"scale", raw<double>({0.5})}}},
     {2, {{"name", "_ATTR_X"}}},
     {0, {{"name", "points"}}},
     {1, {{"name", "again"}}},
     {99, {{"name", "lost"}}}},
    {{"id", raw<int32_t>({7})}, {"range", raw<int32_t>({1, -2, 3})}, {"bits", raw<uint8_t>({0, 9, 255})}},
    "author", {{"who", "J\xC3\xB8rn"}});

TEST(DracoFile, NamesAndMetadataReachGltf) {
  const std::vector<uint8_t> mesh = raw_stream(triangle_with_bytes(3), kNamesAndMore),
                             cloud = raw_stream(triangle_with_bytes(3), kNamesAndMore, true);
  for (const std::vector<uint8_t>& drc : {mesh, cloud}) {
    Losses losses;
    const Document document = must(document_from_draco(
        drc, describe_stream,
        [](std::span<const uint8_t> stream, StreamDescription& description) {
          return decode_draco(stream, &description);
        },
        &losses));
    EXPECT_EQ(losses.sentences(),
              (std::vector<std::string>{"metadata are left out: their attribute has others",
                                        "metadata of an attribute that does not exist are left out"}));
    const Json& of_mesh = document.json()["meshes"][0];
    const Json& attributes = of_mesh["primitives"][0]["attributes"];
    ASSERT_EQ(attributes.size(), 4u);
    ASSERT_TRUE(attributes.contains("_ATTR_X") && attributes.contains("_ATTR_X_2") &&
                attributes.contains("_GENERIC_2"))
        << attributes;
    EXPECT_EQ(extras_of(document, "_ATTR_X"), (Json{{"name", "attr_x"}, {"scale", 0.5}, {"unit", "m/s"}}));
    EXPECT_EQ(extras_of(document, "POSITION"), (Json{{"name", "points"}}));
    EXPECT_EQ(
        of_mesh["extras"],
        (Json{{"bits", {0, 9, 255}}, {"id", 7}, {"range", {1, -2, 3}}, {"author", {{"who", "J\xC3\xB8rn"}}}}));
    EXPECT_EQ(values_in<uint8_t>(document, "_ATTR_X_2"), (std::vector<uint8_t>{1, 2, 4}));
  }
}

TEST(DracoFile, MetadataThatJsonDoesNotHoldAreCounted) {
  std::string picture(5000, '\0');
  const std::string text(500, 'x');
  const Expected<Asset> asset = read_drc(raw_stream(
      {kTriangle}, metadata_of({}, {{"a", picture}, {"b", picture}, {"text", text}, {"\xE9", "1"}}, "text")));
  EXPECT_EQ(warnings_of(asset),
            "2 values in metadata of the geometry are left out: they are not text, and too long for numbers\n");
  ASSERT_TRUE(asset.ok());
  EXPECT_EQ(asset->document.json()["meshes"][0]["extras"],
            (Json{{"text", text}, {"\xC3\xA9", "1"}, {"text_", Json::object()}}));
  // Parts in each other.
  std::vector<uint8_t> deep{0};
  for (int i = 0; i < 100; ++i) deep.insert(deep.end(), {0, 1, 1, 'p'});
  deep.insert(deep.end(), {0, 0});
  EXPECT_EQ(warnings_of(read_drc(raw_stream({kTriangle}, deep))),
            "metadata of the geometry are left out: they have too many entries, or parts in each other\n");
  // An empty name is one that the decoder reads, but libdraco's rules do not allow an empty value.
  EXPECT_EQ(warnings_of(read_drc(raw_stream({kTriangle}, metadata_of({}, {{"a", ""}})))),
            "metadata are left out: Draco stream: metadata with an empty value, or that repeat a name or nest "
            "too deeply\n");
}

// Sanitizers see what reads too far.
TEST(DracoFile, MetadataThatEndEarlyAreRefused) {
  const std::vector<uint8_t> drc = raw_stream(triangle_with_bytes(3), kNamesAndMore);
  for (size_t size = 5; size < drc.size(); ++size)
    EXPECT_FALSE(read_drc({drc.begin(), drc.begin() + static_cast<std::ptrdiff_t>(size)}).ok()) << size;
  for (size_t at = 0; at < kNamesAndMore.size(); ++at)
    for (const int value : {0, 1, 0x7f, 0x80, 0xff}) {
      std::vector<uint8_t> names = kNamesAndMore;
      names[at] = static_cast<uint8_t>(value);
      const Expected<Asset> asset = read_drc(raw_stream(triangle_with_bytes(3), names));
      if (asset.ok()) {
        EXPECT_EQ(mesh_of(asset).attributes.size(), 4u) << at;
      }
    }
}

TEST(DracoFile, PointsMayHavePositionsOfIntegers) {
  const RawAttribute positions{DracoSemantic::kPosition, DataType::kInt16, 3, false,
                               raw<int16_t>({-32768, 0, 1, 2, 3, 4, 5, 6, 32767})};
  const Document document =
      must(document_from_draco(raw_stream({positions}, {}, true), describe_stream,
                               [](std::span<const uint8_t> stream, StreamDescription& description) {
                                 return decode_draco(stream, &description);
                               }));
  EXPECT_EQ(document.json()["extensionsRequired"], Json::array({"KHR_mesh_quantization"}));
  EXPECT_EQ(values_in<int16_t>(document, "POSITION"),
            (std::vector<int16_t>{-32768, 0, 1, 2, 3, 4, 5, 6, 32767}));
}

}  // namespace
}  // namespace psplit
