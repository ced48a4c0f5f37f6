#include "gltf_ext/out_of_core/encode_out_of_core.h"

#include <zlib.h>

#include <algorithm>
#include <bit>

#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/files/io_error.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "gltf_ext/out_of_core/encode_large_primitives.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "src/cpu/cpu_backend.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

Mesh blob(uint64_t faces) {
  ShapeOptions options;
  options.shape = Shape::kBlob;
  options.faces = faces;
  options.normals = options.texcoords = true;
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
  std::string text(84, ' ');
  const auto count = static_cast<uint32_t>(mesh.faces.size());
  std::memcpy(text.data() + 80, &count, sizeof(count));
  for (const auto& face : mesh.faces) {
    std::string facet(50, '\0');
    const float up = face[0] % 3 == 0 ? 0.0f : 1.0f;  // some normals have no direction
    std::memcpy(facet.data() + 8, &up, sizeof(up));
    for (size_t c = 0; c < 3; ++c)
      std::memcpy(facet.data() + 12 * (c + 1), mesh.attributes[0].values.data() + face[c] * 12, 12);
    text += facet;
  }
  return text;
}

struct InMemory {
  Document document;
  std::vector<PrimitiveReport> reports;
  std::vector<std::string> warnings;
};

InMemory in_memory(const std::string& file, const EncodeDocumentOptions& options) {
  Expected<Asset> asset = read_asset(memory_stream(bytes_of(file)), "test", describe_stream);
  EXPECT_TRUE(asset.ok()) << asset.status().to_string();
  InMemory result{std::move(asset->document), {}, asset->warnings};
  auto reports = encode(result.document, options);
  EXPECT_TRUE(reports.ok()) << reports.status().to_string();
  result.reports = std::move(*reports);
  return result;
}

Expected<OutOfCoreResult> encode_stream(std::unique_ptr<ByteStream> stream, const std::filesystem::path& source,
                                        const EncodeDocumentOptions& options, const OutOfCoreOptions& limits) {
  Expected<Scanner> scanner = open_scanner(std::move(stream));
  if (!scanner) return scanner.status();
  const std::optional<AssetFormat> format = format_of(*scanner, source);
  if (!format) return unsupported("no format");
  return encode_out_of_core(*scanner, *format, source, options, limits, test_pool());
}

OutOfCoreOptions small_parts(const std::filesystem::path& folder, uint64_t faces = 6000) {
  OutOfCoreOptions limits;
  limits.memory = uint64_t{1} << 30;
  limits.temporary = folder;
  limits.most_part_faces = faces;
  return limits;
}

// The result is that of encoding in memory, except for the order of points and faces.
void expect_as_in_memory(const std::string& file, EncodeDocumentOptions options = {}) {
  const TestFolder folder;
  InMemory expected = in_memory(file, options);
  Expected<OutOfCoreResult> actual =
      encode_stream(memory_stream(bytes_of(file)), "test", options, small_parts(folder));
  ASSERT_TRUE(actual.ok()) << actual.status().to_string();
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  EXPECT_EQ(actual->warnings, expected.warnings);

  // The report.
  ASSERT_EQ(actual->reports.size(), 1u);
  const PrimitiveReport& report = actual->reports[0];
  const PrimitiveReport& report_in_memory = expected.reports[0];
  EXPECT_EQ(report.faces, report_in_memory.faces);
  EXPECT_EQ(report.points, report_in_memory.points);
  EXPECT_EQ(report.input_bytes, report_in_memory.input_bytes);
  EXPECT_EQ(report.stored_as, StoredAs::kPatches);
  EXPECT_EQ(report.statistics.merged_points, report_in_memory.statistics.merged_points);
  EXPECT_EQ(report.statistics.dropped_faces, report_in_memory.statistics.dropped_faces);
  EXPECT_EQ(report.statistics.dropped_points, report_in_memory.statistics.dropped_points);
  EXPECT_EQ(report.dropped_attributes, report_in_memory.dropped_attributes);
  EXPECT_GT(report.streams.size(), 1u);
  uint64_t stream_bytes = 0;
  for (const StreamEntry& entry : report.streams) stream_bytes += entry.stream_bytes;
  EXPECT_GT(report.bytes, stream_bytes);

  // The accessors: counts, types and bounds.
  ASSERT_EQ(actual->document.json["meshes"][0]["primitives"].size(), 1u);
  const Json& primitive = primitive_of(actual->document);
  const Json& primitive_in_memory = primitive_of(expected.document);
  for (const auto& [semantic, index] : primitive_in_memory["attributes"].items()) {
    ASSERT_TRUE(primitive["attributes"].contains(semantic)) << semantic;
    EXPECT_EQ(accessor_of(actual->document, semantic.c_str()),
              accessor_of(expected.document, semantic.c_str()));
  }
  EXPECT_EQ(accessor_of(actual->document, "indices"), accessor_of(expected.document, "indices"));
  const auto ids = [](const Json& json) {
    return json["extensions"]["PSPLIT_mesh_draco_patches"]["attributes"];
  };
  EXPECT_EQ(ids(primitive), ids(primitive_in_memory));
  for (const char* list : {"extensionsUsed", "extensionsRequired", "scenes", "nodes"})
    EXPECT_EQ(actual->document.json[list], expected.document.json[list]) << list;

  // The mesh, exactly.
  const Expected<Mesh> decoded = read(actual->document), decoded_in_memory = read(expected.document);
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  ASSERT_TRUE(decoded_in_memory.ok());
  EXPECT_EQ(compare_meshes(*decoded_in_memory, *decoded), "");
}

TEST(EncodeOutOfCore, PlyInEveryEncoding) {
  const Mesh mesh = blob(30000);
  for (const Form form : {Form::kText, Form::kLittle, Form::kBig}) {
    SCOPED_TRACE(static_cast<int>(form));
    expect_as_in_memory(ply_of(mesh, form));
  }
}

TEST(EncodeOutOfCore, ExactValues) {
  EncodeDocumentOptions options;
  options.lossless = true;
  expect_as_in_memory(ply_of(blob(20000), Form::kLittle), options);
}

TEST(EncodeOutOfCore, LeavesAttributesOut) {
  EncodeDocumentOptions options;
  options.skip = {"NORMAL", "COLOR_0"};
  expect_as_in_memory(ply_of(blob(9000), Form::kLittle), options);
  // Facets become points with their normals in memory, and without them in files.
  const TestFolder folder;
  options.skip = {"NORMAL"};
  const std::string stl = stl_of(blob(9000));
  const InMemory expected = in_memory(stl, options);
  Expected<OutOfCoreResult> actual =
      encode_stream(memory_stream(bytes_of(stl)), "test", options, small_parts(folder));
  ASSERT_TRUE(actual.ok()) << actual.status().to_string();
  EXPECT_EQ(actual->reports[0].dropped_attributes, options.skip);
  EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual->document)), "");
}

TEST(EncodeOutOfCore, BitsByEdgesAndByAnError) {
  EncodeDocumentOptions options;
  options.position_bits_by_edges = true;
  expect_as_in_memory(ply_of(blob(20000), Form::kLittle), options);
  expect_as_in_memory(stl_of(blob(8000)), options);
  options.position_bits_by_edges = false;
  options.max_position_error = 0.001;
  expect_as_in_memory(ply_of(blob(8000), Form::kLittle), options);
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

TEST(EncodeOutOfCore, Obj) {
  for (const bool with_texcoords : {true, false}) {
    const std::string file = obj_of(blob(9000), with_texcoords);
    const TestFolder folder;
    InMemory expected = in_memory(file, {});
    Expected<OutOfCoreResult> actual =
        encode_stream(memory_stream(bytes_of(file)), "test.obj", {}, small_parts(folder));
    ASSERT_TRUE(actual.ok()) << actual.status().to_string();
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    EXPECT_EQ(std::set<std::string>(actual->warnings.begin(), actual->warnings.end()),
              std::set<std::string>(expected.warnings.begin(), expected.warnings.end()));
    EXPECT_EQ(actual->reports[0].faces, expected.reports[0].faces);
    EXPECT_EQ(actual->reports[0].points,
              expected.reports[0].points - expected.reports[0].statistics.merged_points);
    for (const char* list : {"materials", "scenes", "nodes"})
      EXPECT_EQ(actual->document.json[list], expected.document.json[list]) << list;
    EXPECT_EQ(primitive_of(actual->document)["material"], 0);
    EXPECT_EQ(accessor_of(actual->document, "POSITION"), accessor_of(expected.document, "POSITION"));
    EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual->document)), "");
  }
}

// They would be several primitives.
TEST(EncodeOutOfCore, ObjOfSeveralMaterialsIsUnsupported) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1 2 3\n";
  for (const char* more : {"usemtl a\nf 1 2 3\n", "o a\nf 1 2 3\n", "f 1/1 2/1 3/1\n"}) {
    const std::string file = points + more;
    const TestFolder folder;
    const auto result = encode_stream(memory_stream(bytes_of(file)), "test.obj", {}, small_parts(folder));
    EXPECT_EQ(result.status().code(), StatusCode::kUnsupported);
    EXPECT_NE(result.status().message().find("not read part by part"), std::string::npos)
        << result.status().message();
  }
  const TestFolder folder;
  const std::string missing = points + "f 1 2 4\n";
  EXPECT_EQ(
      encode_stream(memory_stream(bytes_of(missing)), "t.obj", {}, small_parts(folder)).status().message(),
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
  const TestFolder folder;
  for (const bool equal_points : {false, true}) {
    const std::string file = degenerate_ply(equal_points);
    InMemory expected = in_memory(file, {});
    Expected<OutOfCoreResult> actual =
        encode_stream(memory_stream(bytes_of(file)), "test", {}, small_parts(folder));
    ASSERT_TRUE(actual.ok()) << actual.status().to_string();
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    ASSERT_EQ(actual->reports.size(), 1u);
    EXPECT_EQ(actual->reports[0].skipped, expected.reports[0].skipped);
    EXPECT_EQ(actual->reports[0].skipped, "no triangles but degenerate ones");
    EXPECT_EQ(compare_meshes(*read(expected.document), *read(actual->document)), "");
    // Members may be in another order.
    EXPECT_EQ(nlohmann::json::parse(actual->document.json.dump()),
              nlohmann::json::parse(expected.document.json.dump()));
    EXPECT_TRUE(std::ranges::equal(actual->document.buffers[0].bytes(), expected.document.buffers[0].bytes()));
  }
  Mesh flat = blob(500);
  for (auto& face : flat.faces) face[1] = face[0];
  const auto stl = encode_stream(memory_stream(bytes_of(stl_of(flat))), "test", {}, small_parts(folder));
  ASSERT_TRUE(stl.ok()) << stl.status().to_string();
  EXPECT_EQ(stl->reports[0].skipped, "no triangles but degenerate ones");
  EXPECT_EQ(read(stl->document)->faces.size(), flat.faces.size());
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
  std::vector<uint8_t> packed(compressBound(file.size()) + 64);
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
  EXPECT_TRUE(std::filesystem::is_empty(folder));
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
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(EncodeOutOfCore, OnePartIsTheContainerOfEncodingInMemory) {
  const TestFolder folder;
  const std::string file = ply_of(blob(25000), Form::kLittle);
  EncodeDocumentOptions options;
  options.patches = 4;
  InMemory expected = in_memory(file, options);
  Expected<OutOfCoreResult> actual =
      encode_stream(memory_stream(bytes_of(file)), "test", options, small_parts(folder, 1000000));
  ASSERT_TRUE(actual.ok()) << actual.status().to_string();
  const auto container = [](Document& document) {
    const Json& extension = primitive_of(document)["extensions"]["PSPLIT_mesh_draco_patches"];
    const auto bytes = buffer_view_bytes(document, extension["bufferView"].get<int64_t>());
    return std::vector<uint8_t>(bytes->begin(), bytes->end());
  };
  EXPECT_EQ(container(actual->document), container(expected.document));
}

TEST(EncodeOutOfCore, SaysWhichOptionsCannotWork) {
  const auto refusal = [](auto&& set) {
    EncodeDocumentOptions options;
    set(options);
    const Status status = check_out_of_core(options);
    EXPECT_EQ(status.code(), StatusCode::kUsage);
    return status.message();
  };
  EXPECT_TRUE(refusal([](auto& o) { o.keep_degenerate = true; }).starts_with("--keep-degenerate"));
  EXPECT_TRUE(refusal([](auto& o) { o.keep_unused = true; }).starts_with("--keep-unused"));
  EXPECT_TRUE(refusal([](auto& o) { o.keep_duplicates = true; }).starts_with("--keep-duplicates"));
  EXPECT_TRUE(refusal([](auto& o) { o.compat = Compat::kKhr; }).starts_with("--compat"));
  EXPECT_TRUE(refusal([](auto& o) { o.fallback = Fallback::kUncompressed; }).starts_with("--fallback"));
  EXPECT_TRUE(refusal([](auto& o) { o.condense = true; }).starts_with("--condense"));
  EXPECT_TRUE(check_out_of_core({}).ok());
}

TEST(EncodeOutOfCore, SaysWhatItCannotRead) {
  const TestFolder folder;
  const auto status_of = [&](const std::string& file) {
    return encode_stream(memory_stream(bytes_of(file)), "test", {}, small_parts(folder)).status();
  };
  EXPECT_EQ(status_of("").code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status_of("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").code(), StatusCode::kUnsupported);
  const std::string file = ply_of(blob(2000), Form::kLittle);
  EXPECT_EQ(status_of(file.substr(0, file.size() - 5)).code(), StatusCode::kInvalidInput);
  const Status points = status_of(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n0 0 0\n");
  EXPECT_EQ(points.code(), StatusCode::kUnsupported);
  EXPECT_NE(points.message().find("point cloud"), std::string::npos) << points.message();
}

// A document with a large primitive on two nodes and a small one.
Document large_and_small(uint64_t faces) {
  Document document = document_from_mesh(blob(faces));
  const Document small = document_from_mesh(blob(2000));
  // The small mesh's accessors, views and bytes follow those of the large one.
  Json& json = document.json;
  const size_t views = json["bufferViews"].size(), accessors = json["accessors"].size();
  json["buffers"].push_back(small.json["buffers"][0]);
  document.buffers.push_back(small.buffers[0]);
  for (Json view : small.json["bufferViews"]) {
    view["buffer"] = 1;
    json["bufferViews"].push_back(std::move(view));
  }
  for (Json accessor : small.json["accessors"]) {
    accessor["bufferView"] = accessor["bufferView"].get<size_t>() + views;
    json["accessors"].push_back(std::move(accessor));
  }
  Json mesh = small.json["meshes"][0];
  Json& primitive = mesh["primitives"][0];
  for (auto& [semantic, index] : primitive["attributes"].items()) index = index.get<size_t>() + accessors;
  primitive["indices"] = primitive["indices"].get<size_t>() + accessors;
  json["meshes"].push_back(json["meshes"][0]);
  json["meshes"].push_back(std::move(mesh));
  return document;
}

TEST(EncodeLargePrimitives, EncodesThemInPartsAndTheOthersAsAlways) {
  const TestFolder folder;
  Document expected = large_and_small(30000), actual = expected;
  auto expected_reports = encode(expected);
  ASSERT_TRUE(expected_reports.ok()) << expected_reports.status().to_string();
  EncodeDocumentOptions options;
  options.always_patches = true;
  auto reports = encode_large_primitives(actual, options, small_parts(folder), draco_backend(), test_pool());
  ASSERT_TRUE(reports.ok()) << reports.status().to_string();
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  ASSERT_EQ(reports->size(), 3u);
  EXPECT_GT((*reports)[0].streams.size(), (*expected_reports)[0].streams.size());
  for (size_t mesh = 0; mesh < 3; ++mesh) {
    SCOPED_TRACE(mesh);
    const PrimitiveReport &a = (*reports)[mesh], &b = (*expected_reports)[mesh];
    EXPECT_EQ(a.skipped, "");
    EXPECT_EQ(a.faces, b.faces);
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.input_bytes, b.input_bytes);
    EXPECT_EQ(a.repeated, b.repeated);
    EXPECT_EQ(a.stored_as, StoredAs::kPatches);
    EXPECT_EQ(a.statistics.merged_points, b.statistics.merged_points);
    EXPECT_EQ(accessor_of(actual, "POSITION", mesh), accessor_of(expected, "POSITION", mesh));
    EXPECT_EQ(accessor_of(actual, "indices", mesh), accessor_of(expected, "indices", mesh));
    const Expected<Mesh> decoded = read(actual, mesh), decoded_in_memory = read(expected, mesh);
    ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
    EXPECT_EQ(compare_meshes(*decoded_in_memory, *decoded), "");
  }
  EXPECT_EQ(actual.json["bufferViews"].size(), expected.json["bufferViews"].size());
}

TEST(EncodeLargePrimitives, LeavesAttributesOut) {
  const TestFolder folder;
  Document expected = large_and_small(9000), actual = expected;
  EncodeDocumentOptions options;
  options.always_patches = true;
  options.skip = {"NORMAL"};
  const auto expected_reports = encode(expected, options);
  ASSERT_TRUE(expected_reports.ok()) << expected_reports.status().to_string();
  const auto reports =
      encode_large_primitives(actual, options, small_parts(folder), draco_backend(), test_pool());
  ASSERT_TRUE(reports.ok()) << reports.status().to_string();
  for (size_t mesh = 0; mesh < 3; ++mesh) {
    EXPECT_EQ((*reports)[mesh].dropped_attributes, options.skip);
    EXPECT_EQ((*expected_reports)[mesh].dropped_attributes, options.skip);
    EXPECT_EQ(compare_meshes(*read(expected, mesh), *read(actual, mesh)), "");
  }
  EXPECT_EQ(actual.json["accessors"].size(), expected.json["accessors"].size());
  EXPECT_EQ(actual.json["bufferViews"].size(), expected.json["bufferViews"].size());
}

// Where a container ends, another primitive begins, on the same grid.
TEST(EncodeLargePrimitives, SeveralContainersBecomePrimitives) {
  const TestFolder folder;
  Document expected = large_and_small(30000), actual = expected;
  ASSERT_TRUE(encode(expected).ok());
  OutOfCoreOptions limits = small_parts(folder);
  limits.most_container_points = 8000;
  auto reports = encode_large_primitives(actual, {}, limits, draco_backend(), test_pool());
  ASSERT_TRUE(reports.ok()) << reports.status().to_string();
  const size_t count = actual.json["meshes"][0]["primitives"].size();
  ASSERT_GT(count, 1u);
  EXPECT_EQ(actual.json["meshes"][1]["primitives"].size(), count);
  EXPECT_EQ(actual.json["meshes"][2]["primitives"].size(), 1u);
  size_t faces = 0;
  for (size_t i = 0; i < count; ++i) {
    const Expected<Mesh> part = read(actual, 0, i);
    ASSERT_TRUE(part.ok()) << part.status().to_string();
    EXPECT_LE(part->point_count, 8000u);
    faces += part->faces.size();
  }
  EXPECT_EQ(faces, read(expected)->faces.size());
}

TEST(EncodeLargePrimitives, OnlyDegenerateTrianglesStayAsTheyAre) {
  const TestFolder folder;
  Document expected = large_and_small(30000);
  // The last primitive of each mesh has degenerate triangles only, and the one before becomes several.
  Json indices = accessor_of(expected, "indices"), positions = accessor_of(expected, "POSITION");
  const uint32_t zeros[30000] = {};
  const int64_t view = append_buffer_view(expected, {reinterpret_cast<const uint8_t*>(zeros), sizeof zeros});
  indices["bufferView"] = view;
  indices["count"] = 30000;
  indices["componentType"] = 5125;
  for (const char* bound : {"min", "max"}) indices.erase(bound);
  const size_t accessor = expected.json["accessors"].size();
  expected.json["accessors"].push_back(indices);
  for (const size_t mesh : {0u, 1u}) {
    Json flat = primitive_of(expected, mesh);
    flat["indices"] = accessor;
    flat["attributes"] = {{"POSITION", flat["attributes"]["POSITION"]}};
    expected.json["meshes"][mesh]["primitives"].push_back(std::move(flat));
  }
  Document actual = expected;
  const auto expected_reports = encode(expected);
  ASSERT_TRUE(expected_reports.ok()) << expected_reports.status().to_string();
  OutOfCoreOptions limits = small_parts(folder);
  limits.most_container_points = 8000;
  EncodeDocumentOptions options;
  options.volume = QuantizationVolume::kPrimitive;
  const auto reports = encode_large_primitives(actual, options, limits, draco_backend(), test_pool());
  ASSERT_TRUE(reports.ok()) << reports.status().to_string();
  const size_t count = actual.json["meshes"][0]["primitives"].size();
  ASSERT_GT(count, 2u);
  for (const size_t mesh : {0u, 1u}) {
    const Json& last = actual.json["meshes"][mesh]["primitives"][count - 1];
    EXPECT_FALSE(last.contains("extensions")) << last;
    EXPECT_EQ(read(actual, mesh, count - 1)->faces.size(), 10000u);
    const auto report = std::ranges::find_if(
        *reports, [&](const PrimitiveReport& r) { return r.id.mesh == mesh && r.id.primitive == count - 1; });
    ASSERT_NE(report, reports->end());
    EXPECT_EQ(report->skipped, (*expected_reports)[1].skipped);
  }
}

TEST(EncodeLargePrimitives, WeightsKeepTheirSumAsInMemory) {
  const TestFolder folder;
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
  const auto reports = encode_large_primitives(actual, {}, small_parts(folder), draco_backend(), test_pool());
  ASSERT_TRUE(reports.ok()) << reports.status().to_string();
  EXPECT_GT((*reports)[0].streams.size(), 1u);
  EXPECT_EQ(compare_meshes(*read(expected), *read(actual)), "");
}

TEST(EncodeLargePrimitives, SaysWhichPositionIsNotFinite) {
  const TestFolder folder;
  Document document = large_and_small(20000);
  const int64_t view = accessor_of(document, "POSITION")["bufferView"].get<int64_t>();
  const auto offset = document.json["bufferViews"][static_cast<size_t>(view)].value("byteOffset", size_t{0});
  const float value = NAN;
  std::memcpy(document.buffers[0].own().data() + offset + 12 * 70 + 4, &value, sizeof value);
  const Status status =
      encode_large_primitives(document, {}, small_parts(folder), draco_backend(), test_pool()).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << status.to_string();
  EXPECT_TRUE(status.message().starts_with("accessor ")) << status.message();
  EXPECT_TRUE(status.message().ends_with(": the position of point 70 is not finite")) << status.message();
}

TEST(EncodeLargePrimitives, SaysWhatDoesNotFit) {
  const TestFolder folder;
  const auto status_of = [&](auto&& change, EncodeDocumentOptions options = {}) {
    Document document = large_and_small(20000);
    change(document);
    return encode_large_primitives(document, options, small_parts(folder), draco_backend(), test_pool())
        .status();
  };
  EXPECT_TRUE(status_of([](Document&) {}).ok());
  const auto expect_unsupported = [&](const Status& status, const char* what) {
    EXPECT_EQ(status.code(), StatusCode::kUnsupported) << status.to_string();
    EXPECT_NE(status.message().find(what), std::string::npos) << status.message();
  };
  expect_unsupported(status_of([](Document& document) { primitive_of(document)["mode"] = 5; }), "strip");
  expect_unsupported(status_of([](Document& document) {
                       Json& accessor = accessor_of(document, "NORMAL");
                       accessor["sparse"] = Json{{"count", 1}};
                     }),
                     "sparse");
  expect_unsupported(status_of([](Document& document) {
                       for (const size_t mesh : {size_t{0}, size_t{1}}) {
                         Json& primitive = primitive_of(document, mesh);
                         primitive["targets"] = Json::array({Json{{"POSITION", 0}}});
                       }
                     }),
                     "morph targets");
  EncodeDocumentOptions scene;
  scene.volume = QuantizationVolume::kScene;
  expect_unsupported(status_of([](Document&) {}, scene), "--quantization-volume primitive");
  const Status bad = status_of([](Document& document) {
    for (const size_t mesh : {size_t{0}, size_t{1}})
      for (auto& [semantic, index] : primitive_of(document, mesh)["attributes"].items())
        document.json["accessors"][index.get<size_t>()]["count"] = 100;
  });
  EXPECT_EQ(bad.code(), StatusCode::kInvalidInput) << bad.to_string();
}

TEST(TemporarySpace, IsSaidAndCompared) {
  const TestFolder folder;
  std::string note;
  const auto listen = [&](const std::string& text) { note = text; };
  EXPECT_TRUE(check_temporary_space({1000, 2000, 12, false}, folder, listen).ok());
  EXPECT_TRUE(note.starts_with("may take ")) << note;
  EXPECT_NE(note.find(" MB of temporary space in "), std::string::npos) << note;
  note.clear();
  const Status status =
      check_temporary_space({uint64_t{1} << 50, uint64_t{1} << 51, 12, false}, folder, listen);
  EXPECT_EQ(status.code(), kMayPass);
  EXPECT_NE(status.message().find("are free"), std::string::npos);
  EXPECT_EQ(note, "");
}

}  // namespace
}  // namespace psplit
