// No decoded value is farther from its input than half a step of the grid that the stored values call for:
// whatever is beside them in the mesh, unused, or merged. The extents are computed here.

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <tuple>

#include "encoder/coding/position_bits.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

using Row = std::vector<float>;  // all values of a point

struct FloatAttribute {
  std::string semantic;
  uint8_t width;
};

// A sheet with these values at its points, and further points and faces that encoding drops by default.
struct Sheet {
  std::vector<FloatAttribute> attributes;
  Mesh mesh;                // without attributes; the faces of the sheet come first
  std::vector<Row> points;  // points of the sheet come first
  uint32_t stored_points = 0;
  size_t stored_faces = 0;

  std::vector<float> values(size_t attribute, size_t count) const {
    size_t offset = 0;
    for (size_t i = 0; i < attribute; ++i) offset += attributes[i].width;
    std::vector<float> values;
    for (size_t i = 0; i < count; ++i)
      for (size_t c = 0; c < attributes[attribute].width; ++c) values.push_back(points[i][offset + c]);
    return values;
  }
};

class RandomSheets {
 public:
  explicit RandomSheets(uint32_t seed) : random_(seed) {}

  uint32_t below(uint32_t count) { return static_cast<uint32_t>(random_()) % count; }
  float between(float low, float high) {
    return low + (high - low) * static_cast<float>(random_() >> 8) * 0x1p-24f;
  }

  Sheet sheet() {
    Sheet sheet;
    sheet.attributes = {{"POSITION", 3}, {"TEXCOORD_0", 2}, {"_VALUE", 1}};
    sheet.attributes.push_back({"COLOR_0", static_cast<uint8_t>(3 + below(2))});
    const Mesh grid = make_grid(2 + below(5), 1 + below(5));
    sheet.mesh.faces = grid.faces;
    sheet.stored_points = grid.point_count;
    sheet.stored_faces = grid.faces.size();
    std::vector<std::array<float, 2>> ranges;
    for (const FloatAttribute& attribute : sheet.attributes)
      for (size_t c = 0; c < attribute.width; ++c)
        ranges.push_back(attribute.semantic == "COLOR_0" ? color_range() : range());
    ranges[0][1] = ranges[0][0] + between(1, 9);  // points at one place may merge on the grids of the others
    const bool has_bytes = below(4) == 0;         // colours that were bytes
    for (uint32_t i = 0; i < grid.point_count; ++i) {
      Row& row = sheet.points.emplace_back();
      for (size_t c = 0; c < ranges.size(); ++c) {
        row.push_back(between(ranges[c][0], ranges[c][1]));
        if (c >= 6 && has_bytes) row.back() = std::floor(row.back() * 255) / 255;
      }
    }
    add_what_is_dropped(sheet);
    return sheet;
  }

 private:
  std::array<float, 2> range() {
    constexpr std::array<float, 5> kScales = {1, 0.01f, 30, 5000, 0};
    const float at = between(-1, 1) * kScales[below(4)];
    return {at, at + between(0, 1) * kScales[below(5)]};
  }
  std::array<float, 2> color_range() {
    constexpr std::array<float, 4> kEnds = {0, 0.2f, 0.98f, 1};
    const float a = below(2) == 0 ? kEnds[below(4)] : between(0, 1), b = kEnds[below(4)];
    return {std::min(a, b), std::max(a, b)};
  }

  uint32_t add_far_point(Sheet& sheet) {
    Row row = sheet.points.front();
    for (float& value : row) value = between(-1e5f, 1e5f);
    sheet.points.push_back(row);
    return static_cast<uint32_t>(sheet.points.size() - 1);
  }

  void add_what_is_dropped(Sheet& sheet) {
    if (below(2) == 0) add_far_point(sheet);
    if (below(2) == 0) sheet.mesh.faces.push_back({0, add_far_point(sheet), 0});
    if (below(2) == 0) {  // a face of two equal points
      const uint32_t far = add_far_point(sheet);
      sheet.points.push_back(sheet.points[1]);
      sheet.mesh.faces.push_back({1, static_cast<uint32_t>(sheet.points.size() - 1), far});
    }
  }

  std::mt19937 random_;
};

Json primitive_of_sheet(Document& document, const Sheet& sheet) {
  Json primitive{{"mode", 4}, {"attributes", Json::object()}};
  for (size_t i = 0; i < sheet.attributes.size(); ++i)
    primitive["attributes"][sheet.attributes[i].semantic] = append_accessor(
        document,
        make_data(ComponentType::kFloat32, sheet.attributes[i].width, sheet.values(i, sheet.points.size())),
        34962, i == 0);
  std::vector<uint16_t> indices;
  for (const auto& face : sheet.mesh.faces)
    for (const uint32_t point : face) indices.push_back(static_cast<uint16_t>(point));
  primitive["indices"] =
      append_accessor(document, make_data<uint16_t>(ComponentType::kUint16, 1, indices), 34963, false);
  return primitive;
}

// A document with the sheets as primitives; the first `in_first_mesh` of them in mesh 0, the others in mesh 1.
Document document_of(const std::vector<Sheet>& sheets, size_t in_first_mesh) {
  Document document = document_from_mesh(make_grid(1, 1));
  document.json()["meshes"] = Json::array();
  for (size_t i = 0; i < sheets.size(); ++i) {
    if (i == 0 || i == in_first_mesh) document.json()["meshes"].push_back({{"primitives", Json::array()}});
    Json primitive = primitive_of_sheet(document, sheets[i]);
    document.json()["meshes"].back()["primitives"].push_back(std::move(primitive));
  }
  return document;
}

struct Range {
  std::vector<float> low, high;
};

class Ranges {
 public:
  void add(size_t group, const Sheet& sheet, size_t attribute) {
    Range& range = at(group, sheet, attribute);
    const size_t width = sheet.attributes[attribute].width;
    const std::vector<float> values = sheet.values(attribute, sheet.stored_points);
    if (range.low.empty()) {
      range.low.assign(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(width));
      range.high = range.low;
    }
    for (size_t i = 0; i < values.size(); ++i) {
      range.low[i % width] = std::min(range.low[i % width], values[i]);
      range.high[i % width] = std::max(range.high[i % width], values[i]);
    }
  }
  Range& at(size_t group, const Sheet& sheet, size_t attribute) {
    const FloatAttribute& of = sheet.attributes[attribute];
    // Only positions share a grid.
    return ranges_[{of.semantic == "POSITION" ? nullptr : &sheet, group, of.semantic, of.width}];
  }

 private:
  std::map<std::tuple<const Sheet*, size_t, std::string, size_t>, Range> ranges_;
};

// Half a step of the smallest cube around the range, a thousandth more, and the rounding of libdraco's floats:
// 8 of the range's magnitude, and one of the coordinate's.
double allowed_error(const Range& range, size_t component, int bits) {
  double extent = 0;
  for (size_t c = 0; c < range.low.size(); ++c)
    extent = std::max(extent, double{range.high[c]} - double{range.low[c]});
  const double magnitude =
      std::max(std::fabs(double{range.low[component]}), std::fabs(double{range.high[component]}));
  return 0.5 * 1.001 * extent / (std::ldexp(1.0, bits) - 1) + std::ldexp(8 * extent + magnitude, -24);
}

std::vector<float> sorted_column(const std::vector<float>& values, size_t component, size_t width) {
  std::vector<float> column;
  for (size_t i = component; i < values.size(); i += width) column.push_back(values[i]);
  std::ranges::sort(column);
  return column;
}

int bits_for(const EncodeDocumentOptions& options, const std::string& semantic) {
  return semantic == "POSITION"     ? options.position_bits
         : semantic == "TEXCOORD_0" ? options.texcoord_bits
         : semantic == "COLOR_0"    ? options.color_bits
                                    : options.generic_bits;
}

// Rounding to a grid keeps the order of values, so sorted values belong to each other.
void expect_precise(const Sheet& sheet, const Mesh& decoded, size_t group, Ranges& ranges,
                    const EncodeDocumentOptions& options) {
  ASSERT_EQ(decoded.point_count, sheet.stored_points);
  ASSERT_EQ(decoded.faces.size(), sheet.stored_faces);
  for (size_t i = 0; i < sheet.attributes.size(); ++i) {
    const auto& [semantic, width] = sheet.attributes[i];
    const std::vector<float> wanted = sheet.values(i, sheet.stored_points);
    const std::vector<float> values = values_of<float>(*decoded.find(semantic.c_str()));
    for (size_t c = 0; c < width; ++c) {
      const double allowed = allowed_error(ranges.at(group, sheet, i), c, bits_for(options, semantic));
      const std::vector<float> from = sorted_column(wanted, c, width), to = sorted_column(values, c, width);
      for (size_t k = 0; k < from.size(); ++k) {
        ASSERT_NEAR(double{from[k]}, double{to[k]}, allowed) << semantic << " " << c;
        if (semantic == "COLOR_0") {
          ASSERT_TRUE(to[k] >= 0 && to[k] <= 1) << to[k];
        }
      }
    }
  }
}

TEST(Precision, IsHalfAStepOfTheGridThatStoredValuesCallFor) {
  RandomSheets random(1);
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    std::vector<Sheet> sheets;
    for (uint32_t count = 1 + random.below(4); count > 0; --count) sheets.push_back(random.sheet());
    const size_t in_first_mesh = 1 + random.below(static_cast<uint32_t>(sheets.size()));
    EncodeDocumentOptions options = DocumentOptions{.position_bits = 5 + static_cast<int>(random.below(12)),
                                                    .texcoord_bits = 5 + static_cast<int>(random.below(12)),
                                                    .color_bits = 4 + static_cast<int>(random.below(8)),
                                                    .generic_bits = 1 + static_cast<int>(random.below(16))};
    options.volume = std::array{QuantizationVolume::kMesh, QuantizationVolume::kMesh,
                                QuantizationVolume::kPrimitive, QuantizationVolume::kScene}[random.below(4)];
    const auto group = [&](size_t i) {
      return options.volume == QuantizationVolume::kPrimitive ? i
             : options.volume == QuantizationVolume::kMesh    ? size_t{i >= in_first_mesh}
                                                              : 0;
    };
    Ranges ranges;
    for (size_t i = 0; i < sheets.size(); ++i)
      for (size_t k = 0; k < sheets[i].attributes.size(); ++k) ranges.add(group(i), sheets[i], k);
    Document document = document_of(sheets, in_first_mesh);
    const auto reports = must(encode(document, options));
    for (size_t i = 0; i < sheets.size(); ++i) {
      const size_t mesh = i >= in_first_mesh ? 1 : 0;
      const Mesh decoded = must(read(document, mesh, i - mesh * in_first_mesh));
      expect_precise(sheets[i], decoded, group(i), ranges, options);
    }
  }
}

float largest_range_of(const Expected<std::vector<PrimitiveReport>>& reports) {
  EXPECT_TRUE(reports.ok()) << reports.status().to_string();
  return reports.ok() ? reports->front().position_coding.range : 0;
}

TEST(Precision, OfPartsIsThatOfTheBoxOfAllValues) {
  // A long part, and a part beside it. The cube around the cubes of both would have an edge of 190.
  Mesh mesh = make_mesh({0, 0, 0, 100, 0, 0, 100, 1, 0}, {{0, 1, 2}});
  Document document = document_from_mesh(mesh);
  Json primitive = primitive_of(document);
  primitive["attributes"]["POSITION"] = append_accessor(
      document, make_data<float>(ComponentType::kFloat32, 3, {0, 90, 0, 1, 90, 0, 0, 91, 0}), 34962, true);
  document.json()["meshes"][0]["primitives"].push_back(primitive);
  EXPECT_EQ(largest_range_of(encode(document)), 100);
}

TEST(Precision, IsNotThatOfPointsThatAreDropped) {
  const auto encoded_range = [](const Mesh& mesh, const std::function<void(EncodeDocumentOptions&)>& change) {
    Document document = document_from_mesh(mesh);
    EncodeDocumentOptions options;
    change(options);
    return largest_range_of(encode(document, options));
  };
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1000, 0, 0, 0, 0, 0};
  const Mesh unused = make_mesh(positions, {{0, 1, 2}});
  const Mesh degenerate = make_mesh(positions, {{0, 1, 2}, {1, 1, 3}});
  const Mesh equal = make_mesh(positions, {{0, 1, 2}, {0, 4, 3}});
  for (const Mesh& mesh : {unused, degenerate, equal}) {
    EXPECT_EQ(encoded_range(mesh, [](EncodeDocumentOptions&) {}), 1);
    // A bound that floats near 1000 cannot keep.
    EXPECT_EQ(encoded_range(mesh, [](EncodeDocumentOptions& options) { options.max_position_error = 1e-6; }),
              1);
  }
  EXPECT_EQ(encoded_range(unused, [](EncodeDocumentOptions& options) { options.keep_unused = true; }), 1000);
  EXPECT_EQ(encoded_range(degenerate, [](EncodeDocumentOptions& options) { options.keep_degenerate = true; }),
            1000);
  EXPECT_EQ(encoded_range(equal, [](EncodeDocumentOptions& options) { options.keep_duplicates = true; }), 1000);
}

TEST(Precision, OfStockDracoIsNotThatOfUnusedPoints) {
  const Mesh mesh = make_mesh({0, 0, 0, 1, 0, 0, 0.3f, 1, 0, 1000, 0, 0}, {{0, 1, 2}, {1, 1, 3}});
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode_document_stock(document, {}, test_pool()));
  EXPECT_EQ(reports.front().statistics.dropped_faces, 1u);
  EXPECT_EQ(reports.front().statistics.dropped_points, 1u);
  const Mesh decoded = must(read(document));
  EXPECT_EQ(decoded.point_count, 3u);
  const std::vector<float> x = sorted_column(values_of<float>(*decoded.find("POSITION")), 0, 3);
  EXPECT_NEAR(x[1], 0.3, 0.5 / 16383 + 1e-6);
}

// A value that is not finite cannot be on a grid. But a point that is dropped does not matter.
TEST(Precision, HasGridsBesideUnusedPointsThatAreNotFinite) {
  Mesh mesh = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0}, {{0, 1, 2}});
  mesh.attributes.push_back(make_attribute("TEXCOORD_0", ComponentType::kFloat32, 2, false,
                                           std::vector<float>{0, 0.1f, 0, 1, 0.7f, 0.37f, INFINITY, NAN}));
  Document document = document_from_mesh(mesh);
  ASSERT_TRUE(encode(document).ok());
  const Mesh decoded = must(read(document));
  std::vector<float> values = values_of<float>(*decoded.find("TEXCOORD_0"));
  EXPECT_EQ(std::ranges::count(values, 0.37f), 0) << "it was kept exactly";
}

}  // namespace
}  // namespace psplit
