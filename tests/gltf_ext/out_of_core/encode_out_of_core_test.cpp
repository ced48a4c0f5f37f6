#include <zlib.h>

#include <algorithm>

#include "encoder/welding/reduce.h"
#include "gltf_ext/convert/encode_large_mesh.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/out_of_core/read_spool.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "psplit/gltf.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "system/files.h"
#include "system/io_error.h"
#include "tests/gltf_ext/asset.h"
#include "tests/mesh_files/far_mesh.h"
#include "tests/support/environment.h"
#include "tests/support/mesh_file_seeds.h"
#include "tests/support/test_folder.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

Mesh blob(uint64_t faces) {
  const ShapeOptions options{.shape = Shape::kBlob, .faces = faces, .normals = true, .texcoords = true};
  return std::move(generate_shape(options, test_pool())->front());
}

enum class Form { kText, kLittle, kBig };

// The mesh as PLY, with colours of bytes, and polygons of four corners among the faces.
std::string ply_of(const Mesh& mesh, Form form) {
  const auto stated = [&](const char* name) { return "property float " + std::string(name) + "\n"; };
  std::string text = std::string("ply\nformat ") +
                     (form == Form::kText     ? "ascii"
                      : form == Form::kLittle ? "binary_little_endian"
                                              : "binary_big_endian") +
                     " 1.0\nelement vertex " + std::to_string(mesh.point_count) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "s", "t"}) text += stated(name);
  for (const char* name : {"red", "green", "blue"}) text += "property uchar " + std::string(name) + "\n";
  text += "element face " + std::to_string(mesh.faces.size()) +
          "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    if (form == Form::kText) {
      char digits[32];
      if constexpr (std::is_same_v<decltype(value), float>)
        std::snprintf(digits, sizeof(digits), "%.9g ", static_cast<double>(value));
      else
        std::snprintf(digits, sizeof(digits), "%d ", static_cast<int>(value));
      text += digits;
      return;
    }
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    if (form == Form::kBig) std::reverse(raw, raw + sizeof(value));
    text.append(raw, sizeof(value));
  };
  for (size_t point = 0; point < mesh.point_count; ++point) {
    for (const Attribute& attribute : mesh.attributes) {
      std::vector<float> value(attribute.component_count);
      std::memcpy(value.data(), attribute.values.data() + point * attribute.stride(), attribute.stride());
      for (const float number : value) put(number);
    }
    for (const size_t factor : {1u, 3u, 7u}) put(static_cast<uint8_t>(point * factor / 16));
    if (form == Form::kText) text += "\n";
  }
  for (const auto& face : mesh.faces) {
    const bool quad = face[0] % 5 == 0;  // its fourth corner makes a second triangle
    put(static_cast<uint8_t>(quad ? 4 : 3));
    for (const uint32_t point : face) put(static_cast<int32_t>(point));
    if (quad) put(static_cast<int32_t>((face[2] + 1) % mesh.point_count));
    if (form == Form::kText) text += "\n";
  }
  return text;
}

std::string stl_of(const Mesh& mesh) {
  std::vector<StlFacet> facets;
  for (const auto& face : mesh.faces) {
    StlFacet& facet =
        facets.emplace_back(StlFacet{0, 0, face[0] % 3 == 0 ? 0.0f : 1.0f});  // some have no direction
    for (size_t c = 0; c < 3; ++c)
      std::memcpy(&facet[3 * (c + 1)], mesh.attributes[0].values.data() + face[c] * 12, 12);
  }
  return binary_stl(facets);
}

struct InMemory {
  Document document;
  std::vector<PrimitiveReport> reports;
  std::vector<std::string> warnings;
};

InMemory in_memory(const std::string& file, const EncodeDocumentOptions& options) {
  Asset asset = must(read_asset(memory_stream(bytes_of(file)), "test", describe_stream));
  InMemory result{std::move(asset.document), {}, asset.warnings};
  auto reports = must(encode(result.document, options));
  result.reports = std::move(reports);
  return result;
}

OutOfCoreOptions small_parts(const std::filesystem::path& folder, uint64_t faces = 6000) {
  const OutOfCoreOptions limits{.memory = uint64_t{1} << 30, .temporary = folder, .most_part_faces = faces};
  return limits;
}

struct OutOfCoreResult {
  Document document;
  PrimitiveReport report;
  std::vector<std::string> warnings;
};

Expected<OutOfCoreResult> encode_stream(std::unique_ptr<ByteStream> stream, const std::filesystem::path& source,
                                        const EncodeDocumentOptions& options, const OutOfCoreOptions& limits) {
  Expected<Scanner> scanner = open_scanner(std::move(stream));
  if (!scanner) return scanner.status();
  const std::optional<AssetFormat> format = format_of(*scanner, source);
  if (!format) return unsupported("no format");
  const auto check = [&](const ExpectedSizes& sizes, bool is_certain) {
    return check_temporary_space(sizes, limits.temporary, limits.note, is_certain);
  };
  Expected<Asset> asset = read_spool(*scanner, *format, source, spool_options(options, limits), check);
  if (!asset) return asset.status();
  auto reports = encode_document(asset->document, options, reference_backend(), test_pool(), {}, limits);
  if (!reports) return reports.status();
  return OutOfCoreResult{std::move(asset->document), std::move(reports->front()), std::move(asset->warnings)};
}

// No temporary file is left. On Windows the files of a result have names while it exists.
void expect_no_file(const TestFolder& folder) {
  if (!is_posix()) return;
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

// Encodes a file in small parts.
Expected<OutOfCoreResult> encode_file(const std::string& file, const EncodeDocumentOptions& options = {},
                                      uint64_t part_faces = 6000, const char* name = "test") {
  const TestFolder folder;
  auto result = encode_stream(memory_stream(bytes_of(file)), name, options, small_parts(folder, part_faces));
  expect_no_file(folder);
  return result;
}

Expected<std::vector<PrimitiveReport>> encode_in_parts(Document& document, const EncodeDocumentOptions& options,
                                                       uint64_t most_container_points = 0) {
  const TestFolder folder;
  OutOfCoreOptions limits = small_parts(folder);
  if (most_container_points > 0) limits.most_container_points = most_container_points;
  auto reports = encode_document(document, options, reference_backend(), test_pool(), {}, limits);
  expect_no_file(folder);
  return reports;
}

// The result is that of encoding in memory, except for the order of points and faces.
void expect_as_in_memory(const std::string& file, EncodeDocumentOptions options = {}) {
  InMemory expected = in_memory(file, options);
  OutOfCoreResult actual = must(encode_file(file, options));
  EXPECT_EQ(actual.warnings, expected.warnings);

  // The report.
  const PrimitiveReport& report = actual.report;
  const PrimitiveReport& report_in_memory = expected.reports[0];
  EXPECT_EQ(report.faces, report_in_memory.faces);
  // Corners of an STL that become equal when their normals are repaired are one point of the input.
  const bool repeats = actual.document.spooled->are_repeated;
  const uint64_t merged = report_in_memory.statistics.merged_points;
  EXPECT_EQ(report.points, report_in_memory.points - (repeats ? merged : 0));
  if (!repeats || merged == 0) {
    EXPECT_EQ(report.input_bytes, report_in_memory.input_bytes);
  }
  EXPECT_EQ(report.stored_as, StoredAs::kPatches);
  EXPECT_EQ(report.statistics.merged_points, repeats ? 0 : merged);
  EXPECT_EQ(report.statistics.dropped_faces, report_in_memory.statistics.dropped_faces);
  EXPECT_EQ(report.statistics.dropped_points, report_in_memory.statistics.dropped_points);
  EXPECT_EQ(report.dropped_attributes, report_in_memory.dropped_attributes);
  EXPECT_GT(report.streams.size(), 1u);
  uint64_t stream_bytes = 0;
  for (const StreamEntry& entry : report.streams) stream_bytes += entry.stream_bytes;
  EXPECT_GT(report.bytes, stream_bytes);

  // The accessors: counts, types and bounds.
  ASSERT_EQ(actual.document.json()["meshes"][0]["primitives"].size(), 1u);
  const Json& primitive = primitive_of(actual.document);
  const Json& primitive_in_memory = primitive_of(expected.document);
  for (const auto& [semantic, index] : primitive_in_memory["attributes"].items()) {
    ASSERT_TRUE(primitive["attributes"].contains(semantic)) << semantic;
    EXPECT_EQ(accessor_of(actual.document, semantic.c_str()), accessor_of(expected.document, semantic.c_str()));
  }
  // Members may be in another order.
  EXPECT_EQ(nlohmann::json(accessor_of(actual.document, "indices")),
            nlohmann::json(accessor_of(expected.document, "indices")));
  const auto ids = [](const Json& json) {
    return json["extensions"]["PSPLIT_mesh_draco_patches"]["attributes"];
  };
  EXPECT_EQ(ids(primitive), ids(primitive_in_memory));
  for (const char* list : {"extensionsUsed", "extensionsRequired", "scenes", "nodes"})
    EXPECT_EQ(actual.document.json()[list], expected.document.json()[list]) << list;

  // The mesh, exactly.
  EXPECT_EQ(compare_meshes(must(read(expected.document)), must(read(actual.document))), "");
}

TEST(EncodeOutOfCore, PlyInEveryEncoding) {
  const Mesh mesh = blob(30000);
  for (const Form form : {Form::kText, Form::kLittle, Form::kBig}) {
    SCOPED_TRACE(static_cast<int>(form));
    expect_as_in_memory(ply_of(mesh, form));
  }
}

TEST(EncodeOutOfCore, ExactValues) {
  const EncodeDocumentOptions options = DocumentOptions{.lossless = true};
  expect_as_in_memory(ply_of(blob(20000), Form::kLittle), options);
}

TEST(EncodeOutOfCore, LeavesAttributesOut) {
  EncodeDocumentOptions options = DocumentOptions{.skip = {"NORMAL", "COLOR_0"}};
  expect_as_in_memory(ply_of(blob(9000), Form::kLittle), options);
  // Facets become points with their normals in memory, and without them in files.
  options.skip = {"NORMAL"};
  const std::string stl = stl_of(blob(9000));
  const InMemory expected = in_memory(stl, options);
  OutOfCoreResult actual = must(encode_file(stl, options));
  EXPECT_EQ(actual.report.dropped_attributes, options.skip);
  EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual.document)), "");
}

TEST(EncodeOutOfCore, BitsByEdgesAndByAnError) {
  EncodeDocumentOptions options = DocumentOptions{.position_bits_by_edges = true};
  expect_as_in_memory(ply_of(blob(20000), Form::kLittle), options);
  expect_as_in_memory(stl_of(blob(8000)), options);
  options.position_bits_by_edges = false;
  options.max_position_error = 0.001;
  expect_as_in_memory(ply_of(blob(8000), Form::kLittle), options);
}

// Doubles are spooled before their origin is known, and normals of faces are made after it.
TEST(EncodeOutOfCore, DoublesFarFromTheirOrigin) {
  for (const bool is_binary : {true, false}) {
    expect_as_in_memory(far_ply(is_binary, 100));
    expect_as_in_memory(far_ply(is_binary, 100, true), DocumentOptions{.lossless = true});
  }
  expect_as_in_memory(far_stl(100));
  expect_as_in_memory(far_stl(100, true), DocumentOptions{.lossless = true});
  expect_as_in_memory(far_obj(100));
  EXPECT_TRUE(contains(must(encode_file(far_stl(100))).document.json()["nodes"].dump(), "translation"));
}

TEST(EncodeOutOfCore, Stl) { expect_as_in_memory(stl_of(blob(20000))); }

// The mesh as OBJ with indices of its own for each kind of value, a quad now and then, and faces before
// vertices.
std::string obj_of(const Mesh& mesh, bool with_texcoords) {
  std::string values, faces = "mtllib none.mtl\no thing\nusemtl red\n";
  const auto value = [&](const char* keyword, const char* semantic, size_t point) {
    const Attribute& attribute = *mesh.find(semantic);
    std::vector<float> numbers(attribute.component_count);
    std::memcpy(numbers.data(), attribute.values.data() + point * attribute.stride(), attribute.stride());
    values += keyword;
    for (const float number : numbers) {
      char digits[32];
      std::snprintf(digits, sizeof(digits), " %.9g", static_cast<double>(number));
      values += digits;
    }
    values += "\n";
  };
  const size_t count = mesh.point_count;
  for (size_t i = 0; i < count; ++i) {
    value("v", "POSITION", i);
    value("vn", "NORMAL", count - 1 - i);
    if (with_texcoords) value("vt", "TEXCOORD_0", i);
  }
  const auto corner = [&](uint32_t point) {
    const size_t normal = count - point;
    return " " + std::to_string(point + 1) + "/" + (with_texcoords ? std::to_string(point + 1) : "") + "/" +
           std::to_string(normal);
  };
  for (const auto& face : mesh.faces) {
    faces += "f" + corner(face[0]) + corner(face[1]) + corner(face[2]);
    if (face[0] % 5 == 0) faces += corner((face[2] + 1) % mesh.point_count);
    faces += "\n";
  }
  return with_texcoords ? faces + values + "f 1 2\nl 1 2\n" : values + faces;
}

void expect_obj_as_in_memory(const EncodeDocumentOptions& options) {
  for (const bool with_texcoords : {true, false}) {
    // Some statements are equal.
    Mesh mesh = blob(9000);
    for (Attribute& attribute : mesh.attributes)
      std::copy_n(attribute.values.begin(), 100 * attribute.stride(),
                  attribute.values.begin() + static_cast<std::ptrdiff_t>(100 * attribute.stride()));
    const std::string file = obj_of(mesh, with_texcoords);
    InMemory expected = in_memory(file, options);
    OutOfCoreResult actual = must(encode_file(file, options, 6000, "test.obj"));
    EXPECT_EQ(std::set<std::string>(actual.warnings.begin(), actual.warnings.end()),
              std::set<std::string>(expected.warnings.begin(), expected.warnings.end()));
    EXPECT_EQ(actual.report.faces, expected.reports[0].faces);
    EXPECT_EQ(actual.report.points, expected.reports[0].points - expected.reports[0].statistics.merged_points);
    for (const char* list : {"materials", "scenes", "nodes"})
      EXPECT_EQ(actual.document.json()[list], expected.document.json()[list]) << list;
    EXPECT_EQ(primitive_of(actual.document)["material"], 0);
    EXPECT_EQ(accessor_of(actual.document, "POSITION"), accessor_of(expected.document, "POSITION"));
    EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual.document)), "");
  }
}

// The output must not replace a file of materials, and the sizes of the input count it.
TEST(EncodeOutOfCore, ObjNamesItsFiles) {
  const TestFolder folder, temporary;
  std::string file = obj_of(blob(2000), false);
  file.replace(file.find("none.mtl"), 4, "red");
  must(write_file(folder / "red.mtl", {bytes_of("newmtl red\nKd 1 0 0\n")}));
  must(write_file(folder / "a.obj", {bytes_of(file)}));
  const Asset expected = must(read_asset(folder / "a.obj", describe_stream));
  const auto actual = must(
      encode_stream(must(open_byte_stream(folder / "a.obj")), folder / "a.obj", {}, small_parts(temporary)));
  EXPECT_EQ(actual.document.files, expected.document.files);
  EXPECT_EQ(actual.document.files.size(), 2u);
}

TEST(EncodeOutOfCore, Obj) { expect_obj_as_in_memory({}); }
TEST(EncodeOutOfCore, ObjKeepsWhatIsWanted) {
  expect_obj_as_in_memory(
      DocumentOptions{.keep_degenerate = true, .keep_unused = true, .keep_duplicates = true});
}

// They would be several primitives.
TEST(EncodeOutOfCore, ObjOfSeveralMaterialsIsUnsupported) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1 2 3\n";
  for (const char* more : {"usemtl a\nf 1 2 3\n", "o a\nf 1 2 3\n", "f 1/1 2/1 3/1\n"}) {
    const auto result = encode_file(points + more, {}, 6000, "test.obj");
    EXPECT_EQ(result.status().code(), StatusCode::kUnsupported);
    EXPECT_TRUE(contains(result.status().message(), "not read part by part"));
  }
  EXPECT_EQ(encode_file(points + "f 1 2 4\n", {}, 6000, "t.obj").status().message(),
            "line 6: a face names vertex 4, but there are 3");
}

std::string degenerate_ply(bool equal_points) {
  std::string text =
      "ply\nformat ascii 1.0\ncomment test\nelement vertex 6\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 6; ++i)
    text += equal_points ? "1 2 3 9 9 9\n" : std::to_string(i) + " 2 " + std::to_string(i * i) + " 1 2 3\n";
  return text + (equal_points ? "3 0 1 2\n3 3 4 5\n" : "3 0 0 1\n3 2 3 3\n");
}

// Nothing is encoded, as in memory.
TEST(EncodeOutOfCore, OnlyDegenerateTrianglesStayAsTheyAre) {
  for (const bool equal_points : {false, true}) {
    const std::string file = degenerate_ply(equal_points);
    InMemory expected = in_memory(file, {});
    OutOfCoreResult actual = must(encode_file(file));
    EXPECT_EQ(actual.report.skipped, expected.reports[0].skipped);
    EXPECT_EQ(actual.report.skipped, "no triangles but degenerate ones");
    EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual.document)), "");
    for (const char* semantic : {"POSITION", "COLOR_0"}) {
      Json accessor = accessor_of(actual.document, semantic),
           in_memory = accessor_of(expected.document, semantic);
      EXPECT_EQ(nlohmann::json::parse(accessor.dump()), nlohmann::json::parse(in_memory.dump()));
    }
  }
  Mesh flat = blob(500);
  for (auto& face : flat.faces) face[1] = face[0];
  const auto stl = must(encode_file(stl_of(flat)));
  EXPECT_EQ(stl.report.skipped, "no triangles but degenerate ones");
  EXPECT_EQ(read(stl.document)->faces.size(), flat.faces.size());
}

// The stream has no size, and comes in small pieces.
class Pipe : public ByteStream {
 public:
  explicit Pipe(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  size_t read(std::span<uint8_t> to) override {
    const size_t count = std::min<size_t>({to.size(), bytes_.size(), 1000});
    std::copy_n(bytes_.begin(), count, to.begin());
    bytes_ = bytes_.subspan(count);
    return count;
  }

 private:
  std::span<const uint8_t> bytes_;
};

TEST(EncodeOutOfCore, ReadsThePackedStreamOnce) {
  const TestFolder folder;
  const std::string file = ply_of(blob(20000), Form::kLittle);
  std::vector<uint8_t> packed(compressBound(static_cast<uLong>(file.size())) + 64);
  z_stream state{};
  ASSERT_EQ(deflateInit2(&state, 1, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(file.data()));
  state.avail_in = static_cast<uInt>(file.size());
  state.next_out = packed.data();
  state.avail_out = static_cast<uInt>(packed.size());
  ASSERT_EQ(deflate(&state, Z_FINISH), Z_STREAM_END);
  packed.resize(state.total_out);
  deflateEnd(&state);

  Expected<OutOfCoreResult> piped = encode_stream(std::make_unique<Pipe>(packed), "-", {}, small_parts(folder));
  Expected<OutOfCoreResult> plain = encode_stream(memory_stream(bytes_of(file)), "-", {}, small_parts(folder));
  ASSERT_TRUE(piped.ok()) << piped.status().to_string();
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(compare_meshes(*read(plain->document), *read(piped->document)), "");
  packed.resize(packed.size() / 2);
  piped = encode_stream(std::make_unique<Pipe>(packed), "-", {}, small_parts(folder));
  EXPECT_EQ(piped.status().code(), StatusCode::kInvalidInput) << piped.status().to_string();
  expect_no_file(folder);
}

// The header may state anything: it is invalid, and not a lack of space that may pass.
TEST(EncodeOutOfCore, AHeaderThatLiesIsInvalid) {
  const TestFolder folder;
  std::string ply = ply_of(blob(2000), Form::kLittle);
  const size_t count = ply.find("element vertex ") + 15;
  ply.replace(count, ply.find('\n', count) - count, "4000000000");
  std::string stl = stl_of(blob(2000));
  const uint32_t facets = 4000000000;
  std::memcpy(stl.data() + 80, &facets, sizeof facets);
  for (const std::string& file : {ply, stl}) {
    std::string note;
    OutOfCoreOptions limits = small_parts(folder);
    limits.note = [&](const std::string& text) { note = text; };
    const Status whole = encode_stream(memory_stream(bytes_of(file)), "a.stl", {}, limits).status();
    EXPECT_EQ(whole.code(), StatusCode::kInvalidInput) << whole.to_string();
    EXPECT_EQ(note, "");
    const Status piped = encode_stream(std::make_unique<Pipe>(bytes_of(file)), "a.stl", {}, limits).status();
    EXPECT_EQ(piped.code(), StatusCode::kInvalidInput) << piped.to_string();
    EXPECT_TRUE(note.ends_with(", according to the header")) << note;
  }
  expect_no_file(folder);
}

TEST(EncodeOutOfCore, OnePartIsTheContainerOfEncodingInMemory) {
  const std::string file = ply_of(blob(25000), Form::kLittle);
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.count = 4}};
  InMemory expected = in_memory(file, options);
  OutOfCoreResult actual = must(encode_file(file, options, 1000000));
  const auto container = [](Document& document) {
    const Json& extension = primitive_of(document)["extensions"]["PSPLIT_mesh_draco_patches"];
    const auto bytes = buffer_view_bytes(document, extension["bufferView"].get<int64_t>());
    return std::vector<uint8_t>(bytes->begin(), bytes->end());
  };
  EXPECT_EQ(container(actual.document), container(expected.document));
}

TEST(EncodeOutOfCore, PositionsCannotBeSkipped) {
  const auto result = encode_file(ply_of(blob(2000), Form::kLittle), DocumentOptions{.skip = {"POSITION"}});
  EXPECT_EQ(result.status().code(), StatusCode::kUsage);
}

// A mesh with points that are equal or that no face uses, and with faces that repeat a point or two equal ones.
Mesh untidy(uint64_t faces) {
  Mesh mesh = blob(faces);
  const uint32_t count = mesh.point_count;
  append_points(mesh, 0, count);  // point i equals point count + i
  std::vector<std::array<uint32_t, 3>> all;
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
    auto [a, b, c] = mesh.faces[i];
    if (i % 11 == 0) b += count;
    all.push_back({a, b, c});
    if (i % 101 == 0) all.push_back({a, a, c});
    if (i % 103 == 0) all.push_back({c, a, a + count});
    if (i % 107 == 0) all.push_back({a + count, a + count, a + count});
  }
  mesh.faces.assign(all.begin(), all.end());
  return mesh;
}

void expect_options_as_in_memory(const EncodeDocumentOptions& options) {
  expect_as_in_memory(ply_of(untidy(12000), Form::kLittle), options);
  Mesh facets = blob(8000);
  for (size_t i = 0; i < facets.faces.size(); i += 50) facets.faces[i][1] = facets.faces[i][0];
  expect_as_in_memory(stl_of(facets), options);
}

TEST(EncodeOutOfCore, KeepsDegenerateFaces) {
  expect_options_as_in_memory(DocumentOptions{.keep_degenerate = true});
}
TEST(EncodeOutOfCore, KeepsUnusedPoints) { expect_options_as_in_memory(DocumentOptions{.keep_unused = true}); }
TEST(EncodeOutOfCore, KeepsDuplicates) {
  expect_options_as_in_memory(DocumentOptions{.keep_duplicates = true});
}
TEST(EncodeOutOfCore, KeepsAll) {
  expect_options_as_in_memory(
      DocumentOptions{.lossless = true, .keep_degenerate = true, .keep_unused = true, .keep_duplicates = true});
  // Even if there is nothing else.
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.always = true}, .keep_degenerate = true};
  for (const bool equal_points : {false, true}) {
    const std::string file = degenerate_ply(equal_points);
    const InMemory expected = in_memory(file, options);
    const auto actual = must(encode_file(file, options));
    EXPECT_EQ(actual.report.skipped, "");
    EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual.document)), "");
  }
}

// Boxes come from the parts' streams.
TEST(EncodeOutOfCore, StoresBoxes) {
  for (const bool condense : {false, true}) {
    EncodeDocumentOptions options;
    options.condense = condense ? Condense::kFast : Condense::kNo;
    const std::string file = ply_of(untidy(20000), Form::kLittle);
    options.keep_degenerate = options.keep_unused = true;
    const auto plain = must(encode_file(file, options));
    options.boxes = true;
    expect_as_in_memory(file, options);
    auto actual = must(encode_file(file, options));
    EXPECT_EQ(actual.report.streams, plain.report.streams);
    const Json& extension = primitive_of(actual.document)["extensions"][kExtensionName];
    const auto bytes = must(buffer_view_bytes(actual.document, extension["bufferView"].get<int64_t>()));
    EXPECT_EQ(must(patch_boxes(must(open_container(bytes)))).size(), actual.report.streams.size());
    EXPECT_TRUE(validate_document(actual.document, cpu_backend(), test_pool()).empty());
  }
}

TEST(EncodeOutOfCore, Condenses) {
  EncodeDocumentOptions options;
  options.condense = Condense::kFast;
  expect_as_in_memory(ply_of(blob(30000), Form::kLittle), options);
  options.keep_degenerate = options.keep_unused = true;
  expect_as_in_memory(ply_of(untidy(12000), Form::kLittle), options);
  const std::string file = ply_of(blob(30000), Form::kLittle);
  const auto plain = must(encode_file(file)), condensed = must(encode_file(file, options));
  EXPECT_LT(condensed.report.bytes, plain.report.bytes);
  EXPECT_GT(condensed.report.head_bytes, 0u);
  EXPECT_TRUE(condensed.report.streams[0].is_condensed);
}

// All primitives of a mesh as one, with equal points merged: patches of their own have copies at their borders.
Mesh joined(const Document& document, size_t mesh = 0) {
  Mesh all;
  const size_t count = document.json()["meshes"][mesh]["primitives"].size();
  for (size_t i = 0; i < count; ++i) append_mesh(all, must(read(document, mesh, i)));
  return reduce(all, {}, ThreadPool(1)).mesh;
}

TEST(EncodeOutOfCore, PatchesMayBePrimitivesOfTheirOwn) {
  EncodeDocumentOptions options;
  options.compat = Compat::kKhr;
  for (const bool keeps_degenerate : {false, true}) {
    options.keep_degenerate = keeps_degenerate;
    const std::string file = ply_of(untidy(12000), Form::kLittle);
    InMemory expected = in_memory(file, options);
    auto actual = must(encode_file(file, options));
    const size_t count = actual.document.json()["meshes"][0]["primitives"].size();
    EXPECT_GT(count, 1u);
    EXPECT_EQ(actual.report.stored_as, StoredAs::kPatchPrimitives);
    EXPECT_EQ(actual.report.streams.size(), count);
    EXPECT_EQ(actual.report.has_residue, keeps_degenerate);
    for (size_t i = 0; i < count; ++i) {
      Document& document = actual.document;
      EXPECT_TRUE(primitive_of(document, 0, i)["extensions"].contains("KHR_draco_mesh_compression"));
      EXPECT_EQ(accessor_of(document, "POSITION", 0, i)["count"], must(read(document, 0, i)).point_count);
    }
    EXPECT_EQ(actual.document.json()["extensionsRequired"], expected.document.json()["extensionsRequired"]);
    EXPECT_EQ(compare_meshes(joined(expected.document), joined(actual.document)), "");
  }
}

TEST(EncodeOutOfCore, AFallbackIsTheDecodedMesh) {
  for (const Compat compat : {Compat::kNone, Compat::kKhr}) {
    EncodeDocumentOptions options;
    options.fallback = Fallback::kUncompressed;
    options.compat = compat;
    options.keep_unused = options.keep_degenerate = compat == Compat::kNone;
    auto actual = must(encode_file(ply_of(untidy(12000), Form::kLittle), options));
    Document& document = actual.document;
    EXPECT_FALSE(document.json().contains("extensionsRequired"));
    EXPECT_EQ(findings_of(document, cpu_backend()), "");
    const Mesh compressed = joined(document);
    Json& primitives = document.json()["meshes"][0]["primitives"];
    for (Json& primitive : primitives) primitive.erase("extensions");
    EXPECT_EQ(compare_meshes(compressed, joined(document)), "");
  }
}

TEST(EncodeOutOfCore, SaysWhatItCannotRead) {
  const auto status_of = [](const std::string& file) { return encode_file(file).status(); };
  EXPECT_EQ(status_of("").code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status_of("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").code(), StatusCode::kUnsupported);
  const std::string file = ply_of(blob(2000), Form::kLittle);
  EXPECT_EQ(status_of(file.substr(0, file.size() - 5)).code(), StatusCode::kInvalidInput);
  const Status points = status_of(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n0 0 0\n");
  EXPECT_EQ(points.code(), StatusCode::kUnsupported);
  EXPECT_TRUE(contains(points.message(), "has no triangles"));
}

// A document with a large primitive on two nodes and a small one.
Document large_and_small(uint64_t faces) {
  Document document = document_from_mesh(blob(faces));
  document.json()["meshes"].push_back(document.json()["meshes"][0]);
  add_mesh(document, blob(2000));
  return document;
}

TEST(EncodeLargePrimitives, EncodesThemInPartsAndTheOthersAsAlways) {
  Document expected = large_and_small(30000), actual = expected;
  auto expected_reports = must(encode(expected));
  auto reports = must(encode_in_parts(actual, DocumentOptions{.patches = {.always = true}}));
  ASSERT_EQ(reports.size(), 3u);
  EXPECT_GT(reports[0].streams.size(), expected_reports[0].streams.size());
  for (size_t mesh = 0; mesh < 3; ++mesh) {
    SCOPED_TRACE(mesh);
    const PrimitiveReport &a = reports[mesh], &b = expected_reports[mesh];
    EXPECT_EQ(a.skipped, "");
    EXPECT_EQ(a.faces, b.faces);
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.input_bytes, b.input_bytes);
    EXPECT_EQ(a.repeated, b.repeated);
    EXPECT_EQ(a.stored_as, StoredAs::kPatches);
    EXPECT_EQ(a.statistics.merged_points, b.statistics.merged_points);
    EXPECT_EQ(accessor_of(actual, "POSITION", mesh), accessor_of(expected, "POSITION", mesh));
    EXPECT_EQ(accessor_of(actual, "indices", mesh), accessor_of(expected, "indices", mesh));
    EXPECT_EQ(compare_meshes(must(read(expected, mesh)), must(read(actual, mesh))), "");
  }
  EXPECT_EQ(actual.json()["bufferViews"].size(), expected.json()["bufferViews"].size());
}

TEST(EncodeLargePrimitives, KeepsWhatIsWanted) {
  Document expected = document_from_mesh(untidy(12000)), actual = expected;
  EncodeDocumentOptions options;
  options.keep_degenerate = options.keep_unused = options.keep_duplicates = true;
  ASSERT_TRUE(encode(expected, options).ok());
  const auto reports = must(encode_in_parts(actual, options));
  EXPECT_GT(reports[0].streams.size(), 2u);
  EXPECT_EQ(compare_meshes(*read(expected), *read(actual)), "");
  EXPECT_EQ(findings_of(actual, cpu_backend()), "");
  // Two primitives would keep the same points.
  Document sharing = document_from_mesh(untidy(12000));
  Json& primitives = sharing.json()["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1].erase("indices");
  options.volume = QuantizationVolume::kPrimitive;
  const Status status = encode_in_parts(sharing, options).status();
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_TRUE(contains(status.message(), "--keep-unused"));
}

TEST(EncodeLargePrimitives, LeavesAttributesOut) {
  Document expected = large_and_small(9000), actual = expected;
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.always = true}, .skip = {"NORMAL"}};
  const auto expected_reports = must(encode(expected, options));
  const auto reports = must(encode_in_parts(actual, options));
  for (size_t mesh = 0; mesh < 3; ++mesh) {
    EXPECT_EQ(reports[mesh].dropped_attributes, options.skip);
    EXPECT_EQ(expected_reports[mesh].dropped_attributes, options.skip);
    EXPECT_EQ(compare_meshes(*read(expected, mesh), *read(actual, mesh)), "");
  }
  EXPECT_EQ(actual.json()["accessors"].size(), expected.json()["accessors"].size());
  EXPECT_EQ(actual.json()["bufferViews"].size(), expected.json()["bufferViews"].size());
}

size_t stream_count(std::span<const PrimitiveReport> reports) {
  size_t count = 0;
  for (const PrimitiveReport& report : reports) count += report.repeated ? 0 : report.streams.size();
  return count;
}

// PatchTarget::count is of all primitives together, whether they are in memory or in parts.
TEST(EncodeLargePrimitives, ShareThePatchesWithAllOthers) {
  const TestFolder folder;
  for (const auto& [count, part_faces] : {std::pair{16u, uint64_t{6000}}, std::pair{64u, uint64_t{1500}}}) {
    SCOPED_TRACE(count);
    const EncodeDocumentOptions options = DocumentOptions{.patches = {.count = count}};
    Document expected = large_and_small(30000), actual = expected;
    const auto expected_reports = must(encode(expected, options));
    const auto reports = must(encode_document(actual, options, reference_backend(), test_pool(), {},
                                              small_parts(folder, part_faces)));
    // Each part rounds its own number.
    EXPECT_NEAR(static_cast<double>(stream_count(reports)), count, count / 5);
    EXPECT_NEAR(static_cast<double>(reports[2].streams.size()),
                static_cast<double>(expected_reports[2].streams.size()), 1);
  }
}

// Where a container ends, another primitive begins, on the same grid.
TEST(EncodeLargePrimitives, SeveralContainersBecomePrimitives) {
  Document expected = large_and_small(30000), actual = expected;
  ASSERT_TRUE(encode(expected).ok());
  must(encode_in_parts(actual, {}, 8000).status());
  const size_t count = actual.json()["meshes"][0]["primitives"].size();
  ASSERT_GT(count, 1u);
  EXPECT_EQ(actual.json()["meshes"][1]["primitives"].size(), count);
  EXPECT_EQ(actual.json()["meshes"][2]["primitives"].size(), 1u);
  size_t faces = 0;
  for (size_t i = 0; i < count; ++i) {
    const Mesh part = must(read(actual, 0, i));
    EXPECT_LE(part.point_count, 8000u);
    faces += part.faces.size();
  }
  EXPECT_EQ(faces, read(expected)->faces.size());
}

// The document has patches already, and the large primitive before them becomes several.
TEST(EncodeLargePrimitives, CondensesThemAndThePatchesOfTheInput) {
  Document document = large_and_small(30000);
  std::swap(document.json()["meshes"][1], document.json()["meshes"][2]);
  document.json()["meshes"].erase(2);
  Document small = document;
  small.json()["meshes"].erase(0);
  ASSERT_TRUE(encode(small, DocumentOptions{.patches = {.count = 2}}).ok());
  // The large mesh comes before the patches in one mesh.
  const Json large = append_primitive(small, blob(30000));
  Json& primitives = small.json()["meshes"][0]["primitives"];
  primitives.insert(primitives.begin(), large);

  const Mesh patched = *read(small, 0, 1);
  EncodeDocumentOptions options;
  options.condense = Condense::kFast;
  options.volume = QuantizationVolume::kPrimitive;
  const auto reports = must(encode_in_parts(small, options, 8000));
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_TRUE(reports[0].streams[0].is_condensed);
  EXPECT_TRUE(reports[1].keeps_streams);
  const size_t count = small.json()["meshes"][0]["primitives"].size();
  ASSERT_GT(count, 2u);
  EXPECT_EQ(compare_meshes(patched, *read(small, 0, count - 1)), "");
  EXPECT_EQ(findings_of(small, cpu_backend()), "");
}

TEST(EncodeLargePrimitives, OnlyDegenerateTrianglesStayAsTheyAre) {
  Document expected = large_and_small(30000);
  // The last primitive of each mesh has degenerate triangles only, and the one before becomes several.
  Json indices = accessor_of(expected, "indices"), positions = accessor_of(expected, "POSITION");
  const uint32_t zeros[30000] = {};
  const int64_t view = append_buffer_view(expected, {reinterpret_cast<const uint8_t*>(zeros), sizeof zeros});
  indices["bufferView"] = view;
  indices["count"] = 30000;
  indices["componentType"] = 5125;
  for (const char* bound : {"min", "max"}) indices.erase(bound);
  const size_t accessor = expected.json()["accessors"].size();
  expected.json()["accessors"].push_back(indices);
  for (const size_t mesh : {0u, 1u}) {
    Json flat = primitive_of(expected, mesh);
    flat["indices"] = accessor;
    flat["attributes"] = {{"POSITION", flat["attributes"]["POSITION"]}};
    expected.json()["meshes"][mesh]["primitives"].push_back(std::move(flat));
  }
  Document actual = expected;
  const auto expected_reports = must(encode(expected));
  const auto reports =
      must(encode_in_parts(actual, DocumentOptions{.volume = QuantizationVolume::kPrimitive}, 8000));
  const size_t count = actual.json()["meshes"][0]["primitives"].size();
  ASSERT_GT(count, 2u);
  for (const size_t mesh : {0u, 1u}) {
    const Json& last = actual.json()["meshes"][mesh]["primitives"][count - 1];
    EXPECT_FALSE(last.contains("extensions")) << last;
    EXPECT_EQ(read(actual, mesh, count - 1)->faces.size(), 10000u);
    const auto report = std::ranges::find_if(
        reports, [&](const PrimitiveReport& r) { return r.id.mesh == mesh && r.id.primitive == 1; });
    ASSERT_NE(report, reports.end());
    EXPECT_EQ(report->skipped, expected_reports[1].skipped);
  }
}

TEST(EncodeLargePrimitives, WeightsKeepTheirSumAsInMemory) {
  Mesh mesh = blob(30000);
  Attribute weights{"WEIGHTS_0", ComponentType::kFloat32, 4, false, {}};
  Attribute joints{"JOINTS_0", ComponentType::kUint8, 4, false, {}};
  weights.values.resize(mesh.point_count * weights.stride());
  joints.values.assign(mesh.point_count * joints.stride(), std::byte{1});
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const float a = static_cast<float>(i % 97) / 97, b = (1 - a) / 3;
    const float values[4] = {a, b, b, 1 - a - 2 * b};
    std::memcpy(weights.values.data() + i * sizeof values, values, sizeof values);
  }
  mesh.attributes.push_back(weights);
  mesh.attributes.push_back(joints);
  Document expected = document_from_mesh(mesh), actual = expected;
  ASSERT_TRUE(encode(expected).ok());
  const auto reports = must(encode_in_parts(actual, {}));
  EXPECT_GT(reports[0].streams.size(), 1u);
  EXPECT_EQ(compare_meshes(*read(expected), *read(actual)), "");
}

TEST(EncodeLargePrimitives, SaysWhichPositionIsNotFinite) {
  Document document = large_and_small(20000);
  const int64_t view = accessor_of(document, "POSITION")["bufferView"].get<int64_t>();
  const auto offset = document.json()["bufferViews"][static_cast<size_t>(view)].value("byteOffset", size_t{0});
  const float value = NAN;
  std::memcpy(document.buffers[0].own().data() + offset + 12 * 70 + 4, &value, sizeof value);
  const Status status = encode_in_parts(document, {}).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << status.to_string();
  EXPECT_TRUE(status.message().starts_with("accessor ")) << status.message();
  EXPECT_TRUE(status.message().ends_with(": the position of point 70 is not finite")) << status.message();
}

TEST(EncodeLargePrimitives, SaysWhatDoesNotFit) {
  const auto status_of = [&](auto&& change, EncodeDocumentOptions options = {}) {
    Document document = large_and_small(20000);
    change(document);
    return encode_in_parts(document, options).status();
  };
  EXPECT_TRUE(status_of([](Document&) {}).ok());
  const auto expect_unsupported = [&](const Status& status, const char* what) {
    EXPECT_EQ(status.code(), StatusCode::kUnsupported) << status.to_string();
    EXPECT_TRUE(contains(status.message(), what));
  };
  expect_unsupported(status_of([](Document& document) { primitive_of(document)["mode"] = 5; }), "strip");
  expect_unsupported(status_of([](Document& document) {
                       Json& accessor = accessor_of(document, "NORMAL");
                       accessor["sparse"] = {{"count", 1},
                                             {"indices", {{"bufferView", 0}, {"componentType", 5125}}},
                                             {"values", {{"bufferView", 0}}}};
                     }),
                     "sparse");
  expect_unsupported(status_of([](Document& document) {
                       for (const size_t mesh : {size_t{0}, size_t{1}}) {
                         Json& primitive = primitive_of(document, mesh);
                         primitive["targets"] = Json::array({Json{{"POSITION", 0}}});
                       }
                     }),
                     "morph targets");
  const EncodeDocumentOptions scene = DocumentOptions{.volume = QuantizationVolume::kScene};
  expect_unsupported(status_of([](Document&) {}, scene), "--quantization-volume primitive");
  const Status bad = status_of([](Document& document) {
    for (const size_t mesh : {size_t{0}, size_t{1}})
      for (auto& [semantic, index] : primitive_of(document, mesh)["attributes"].items())
        document.json()["accessors"][index.get<size_t>()]["count"] = 100;
  });
  EXPECT_EQ(bad.code(), StatusCode::kInvalidInput) << bad.to_string();
}

TEST(TemporarySpace, IsSaidAndCompared) {
  const TestFolder folder;
  std::string note;
  const auto listen = [&](const std::string& text) { note = text; };
  EXPECT_TRUE(check_temporary_space({1000, 2000, 12, false}, folder, listen).ok());
  EXPECT_TRUE(note.starts_with("may take ")) << note;
  EXPECT_TRUE(contains(note, " MB of temporary space in "));
  note.clear();
  const Status status =
      check_temporary_space({uint64_t{1} << 50, uint64_t{1} << 51, 12, false}, folder, listen);
  EXPECT_EQ(status.code(), StatusCode::kMayPass);
  EXPECT_TRUE(contains(status.message(), "are free"));
  EXPECT_EQ(note, "");
}

}  // namespace
}  // namespace psplit
