// Reads any bytes as a mesh and as options for libdraco's encoder. The core must decode what libdraco makes of
// them to the same bits as libdraco's decoder: in one lane, by a warp, and from the condensed form.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "encoder/condensing/condense.h"
#include "encoder/fields/expand.h"
#include "src/container/condensed_head.h"
#include "src/core/condensed/condensed_header.h"
#include "tests/src/core/decode_mesh.h"
#include "tests/support/container_of_streams.h"
#include "tests/support/draco_subject.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

// Choices from the input; all are 0 after its end.
class Choices {
 public:
  Choices(const uint8_t* data, size_t size) : data_(data), left_(size) {}

  uint8_t byte() { return left_ > 0 ? --left_, *data_++ : uint8_t{0}; }
  uint32_t below(uint32_t end) {
    const uint32_t low = byte();
    return (end > 256 ? low | uint32_t{byte()} << 8 : low) % end;
  }
  bool one_in(uint32_t count) { return below(count) == count - 1; }
  uint64_t word() {
    uint64_t word = 0;
    for (int i = 0; i < 8; ++i) word = word << 8 | byte();
    return word;
  }

 private:
  const uint8_t* data_;
  size_t left_;
};

// A sequence of numbers that look random, from one choice: values need more bytes than an input has.
class Noise {
 public:
  explicit Noise(uint64_t seed) : state_(seed) {}
  uint64_t word() {
    state_ += 0x9e3779b97f4a7c15u;
    uint64_t x = (state_ ^ state_ >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
  }
  double unit() { return static_cast<double>(word() >> 11) * 0x1p-53; }

 private:
  uint64_t state_;
};

// A sheet, which may be closed to a cylinder, a torus or a Moebius strip; without some faces, and with some
// corners moved to other points: holes, handles, edges of three faces, faces that repeat a point.
void add_sheet(Choices& choices, Subject& subject) {
  const uint32_t columns = 1 + choices.below(9), rows = 1 + choices.below(9), closed = choices.below(6);
  const uint32_t first = subject.point_count, width = columns + 1, height = rows + 1;
  const auto point = [&](uint32_t x, uint32_t y) {
    if (closed % 3 != 0 && x == columns) y = closed < 3 ? y : rows - y, x = 0;
    if (closed % 3 == 2 && y == rows) y = 0;
    return first + y * width + x;
  };
  const uint32_t holes = choices.below(8), moves = choices.one_in(3) ? choices.below(8) : 0;
  const size_t first_face = subject.faces.size();
  Noise noise(choices.word());
  for (uint32_t y = 0; y < rows; ++y)
    for (uint32_t x = 0; x < columns; ++x) {
      const uint32_t a = point(x, y), b = point(x + 1, y), c = point(x, y + 1), d = point(x + 1, y + 1);
      if (holes == 0 || noise.word() % 32 >= holes) subject.faces.push_back({a, b, d});
      if (holes == 0 || noise.word() % 32 >= holes) subject.faces.push_back({a, d, c});
    }
  subject.point_count += width * height;
  for (uint32_t i = 0; i < moves && subject.faces.size() > first_face; ++i) {
    auto& face = subject.faces[first_face + noise.word() % (subject.faces.size() - first_face)];
    face[noise.word() % 3] = static_cast<uint32_t>(noise.word() % subject.point_count);
  }
}

// Any faces over a few points.
void add_soup(Choices& choices, Subject& subject) {
  const uint32_t points = 1 + choices.below(12), faces = 1 + choices.below(16), first = subject.point_count;
  subject.point_count += points;
  for (uint32_t i = 0; i < faces; ++i)
    subject.faces.push_back(
        {first + choices.below(points), first + choices.below(points), first + choices.below(points)});
}

// Faces around one edge, or around one point.
void add_book(Choices& choices, Subject& subject) {
  const uint32_t pages = 1 + choices.below(8), first = subject.point_count;
  const bool is_fan = choices.one_in(2);
  subject.point_count += 3 + pages;
  for (uint32_t i = 0; i < pages; ++i)
    subject.faces.push_back({first, is_fan ? first + 2 + i : first + 1, first + 3 + i});
}

enum class Pattern { kRandom, kEnds, kFew, kConstant, kSmooth };

template <typename T>
T component(Pattern pattern, Noise& noise, uint32_t point, double low, double high) {
  double unit = noise.unit();
  switch (pattern) {
    case Pattern::kRandom: break;
    case Pattern::kEnds: unit = std::clamp(unit * 3 - 1, 0.0, 1.0); break;
    case Pattern::kFew: unit = std::floor(unit * 4) / 4; break;
    case Pattern::kConstant: unit = 0.625; break;
    case Pattern::kSmooth: unit = std::abs(std::sin(point * 0.1 + unit * 0.05)); break;
  }
  return static_cast<T>(low + unit * (high - low));
}

void add_attribute(Choices& choices, Subject& subject, Role role, draco::DataType type, int component_count) {
  Values values{role, type, component_count, choices.one_in(2), {}};
  const auto pattern = static_cast<Pattern>(choices.below(5));
  Noise noise(choices.word());
  const auto fill = [&]<typename T>(T, double low, double high) {
    for (uint32_t point = 0; point < subject.point_count; ++point)
      for (int c = 0; c < component_count; ++c) {
        const T value = component<T>(pattern, noise, point, low, high);
        const auto* bytes = reinterpret_cast<const uint8_t*>(&value);
        values.bytes.insert(values.bytes.end(), bytes, bytes + sizeof value);
      }
  };
  // libdraco counts the symbols of integers in tables as large as the largest of them.
  const double wide = choices.one_in(2) ? 100 : 1 << 20;
  switch (type) {
    case draco::DT_INT8: fill(int8_t{}, -128, 127); break;
    case draco::DT_UINT8: fill(uint8_t{}, 0, 255); break;
    case draco::DT_INT16: fill(int16_t{}, -32768, 32767); break;
    case draco::DT_UINT16: fill(uint16_t{}, 0, 65535); break;
    case draco::DT_INT32: fill(int32_t{}, -wide, wide); break;
    case draco::DT_UINT32: fill(uint32_t{}, 0, wide); break;
    case draco::DT_INT64: fill(int64_t{}, -9e18, 9e18); break;
    case draco::DT_UINT64: fill(uint64_t{}, 0, 1.8e19); break;
    case draco::DT_FLOAT64: fill(double{}, -1e100, 1e100); break;
    case draco::DT_BOOL: fill(uint8_t{}, 0, 1.99); break;
    default: fill(float{}, choices.one_in(4) ? 1000 : -1, choices.one_in(4) ? 1001 : 1); break;
  }
  subject.attributes.push_back(std::move(values));
}

Subject read_subject(Choices& choices) {
  Subject subject{.name = "fuzzed"};
  for (uint32_t parts = 1 + choices.below(3); parts > 0; --parts) {
    const uint32_t kind = choices.below(5);
    kind == 0   ? add_soup(choices, subject)
    : kind == 1 ? add_book(choices, subject)
                : add_sheet(choices, subject);
  }
  subject.point_count += choices.one_in(4) ? choices.below(4) : 0;  // points without faces
  subject.welded = choices.one_in(2);
  subject.metadata = choices.one_in(8);
  subject.first_id = choices.one_in(8) ? 300 : 0;
  subject.element = static_cast<draco::MeshAttributeElementType>(choices.below(3));

  // Normals and texture coordinates can be predicted only from triples of at most 32 bits. From others libdraco
  // writes streams that it cannot read.
  const bool is_float = !choices.one_in(4);
  const auto integers = static_cast<draco::DataType>(draco::DT_INT8 + choices.below(6));
  add_attribute(choices, subject, Role::POSITION, is_float ? draco::DT_FLOAT32 : integers, 3);
  for (uint32_t others = choices.below(5); others > 0; --others) {
    const auto any = static_cast<draco::DataType>(draco::DT_INT8 + choices.below(draco::DT_BOOL));
    const auto floats = choices.one_in(3) ? any : draco::DT_FLOAT32;
    const int count = 1 + static_cast<int>(choices.one_in(8) ? choices.below(16) : choices.below(4));
    switch (choices.below(4)) {
      // Integers of this role are taken for octahedral coordinates, whose number is another.
      case 0: add_attribute(choices, subject, Role::NORMAL, draco::DT_FLOAT32, 3); break;
      case 1: add_attribute(choices, subject, Role::TEX_COORD, floats, choices.one_in(8) ? count : 2); break;
      case 2: add_attribute(choices, subject, Role::COLOR, floats, count); break;
      default: add_attribute(choices, subject, Role::GENERIC, floats, count); break;
    }
  }
  return subject;
}

Recipe read_recipe(Choices& choices) {
  Recipe recipe{.speed = static_cast<int>(choices.below(11))};
  recipe.sequential = choices.one_in(8);
  recipe.compress_indices = choices.one_in(2);
  constexpr int kConnectivities[] = {kAuto, kStandard, kValence};
  recipe.connectivity = kConnectivities[choices.below(3)];
  recipe.split_on_seams = static_cast<int>(choices.below(3)) - 1;
  recipe.given_grid = choices.one_in(16);
  for (int& bits : recipe.bits)
    bits = static_cast<int>(choices.one_in(3) ? choices.below(31) : 8 + choices.below(11));
  // Tables of symbols would take gigabytes. The largest values are 700 times as far as a given grid.
  constexpr int kMostGivenBits = 11;
  if (recipe.given_grid)
    for (int& bits : recipe.bits) bits = std::clamp(bits, 1, kMostGivenBits);
  recipe.bits[Role::NORMAL] = std::max(recipe.bits[Role::NORMAL], 2);
  constexpr int kMostSymbolBits = 21;
  const bool counts_symbols = *std::ranges::max_element(recipe.bits) <= kMostSymbolBits;
  recipe.entropy_coding = counts_symbols && !choices.one_in(8);
  if (!counts_symbols) recipe.speed = std::max(recipe.speed, 2);
  if (!choices.one_in(4)) return recipe;
  constexpr int kSchemes[] = {kAuto, draco::PREDICTION_NONE, draco::PREDICTION_DIFFERENCE,
                              draco::MESH_PREDICTION_PARALLELOGRAM,
                              draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM};
  for (size_t role = 0; role < kRoleCount; ++role)
    recipe.scheme[role] = kSchemes[choices.below(role == Role::NORMAL ? 3 : counts_symbols ? 5 : 4)];
  return recipe;
}

[[noreturn]] void fail(const char* what, const Subject& subject, const Recipe& recipe) {
  std::fprintf(stderr, "%s: %u points, %zu faces, %zu attributes, %s, %s\n", what, subject.point_count,
               subject.faces.size(), subject.attributes.size(), subject.welded ? "welded" : "not welded",
               describe(recipe).c_str());
  std::abort();
}

// Counts what the inputs were, to show that they mean something; printed at the end.
struct Counts {
  size_t inputs = 0, encoded = 0, decoded = 0, condensed = 0;
  ~Counts() {
    std::fprintf(stderr, "mesh_fuzzer: %zu inputs, %zu encoded by libdraco, %zu decoded by it, %zu condensed\n",
                 inputs, encoded, decoded, condensed);
  }
} counts;

template <typename Index>
bool decodes(const core::StreamHeader& header, size_t stream_bytes, const RawMesh& expected) {
  RawMesh decoded;
  if (core::decode_in_workspace<Index>(header, stream_bytes, expected, decoded) != core::Fault::kNone ||
      decoded != expected)
    return false;
  const LaneOrder order = kLaneOrders[counts.inputs % kLaneOrders.size()];
  return core::decode_by_warp<Index>(header, order, decoded) == core::Fault::kNone && decoded == expected;
}
bool decodes(const core::StreamHeader& header, size_t stream_bytes, const RawMesh& expected) {
  return decodes<uint32_t>(header, stream_bytes, expected) &&
         (!header.fits_16_bits() || decodes<uint16_t>(header, stream_bytes, expected));
}

// Copies of a stream together save more than their head takes.
const char* check_condensed(const Bytes& stream, const RawMesh& expected) {
  static const ThreadPool pool(1);
  const auto face_count = static_cast<uint32_t>(expected.faces.size());
  const std::vector<Bytes> copies(20, stream);
  const std::vector<StreamEntry> rows(copies.size(),
                                      {.face_count = face_count, .point_count = expected.point_count});
  const CondensedStreams condensed = condense(container_of_streams(copies, rows), counts.inputs % 2 == 0, pool);
  const StreamEntry& row = condensed.entries[0];
  if (!row.is_condensed) return nullptr;
  ++counts.condensed;
  const Expected<CondensedHead> head = read_condensed_head(condensed.head);
  if (!head) return "the condensed head";
  const Bytes& bytes = condensed.bytes[0];
  const auto expanded = expand_stream(*head, {bytes, row.skeleton, face_count, expected.point_count});
  if (!expanded || *expanded != stream) return "the expanded stream";
  const Bytes& skeleton = head->skeletons[row.skeleton];
  core::StreamHeader header;
  if (core::read_condensed_header({skeleton.data(), skeleton.size()}, {bytes.data(), bytes.size()},
                                  head->models(), face_count, expected.point_count, header,
                                  header.condensed) != core::Fault::kNone)
    return "the condensed stream's header";
  return decodes(header, bytes.size(), expected) ? nullptr : "the mesh from the condensed stream";
}

}  // namespace
}  // namespace psplit

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace psplit;
  Choices choices(data, size);
  const Recipe recipe = read_recipe(choices);
  const Subject subject = read_subject(choices);
  ++counts.inputs;
  const std::optional<Bytes> stream = encode(*build(subject), recipe);
  if (!stream) return 0;
  ++counts.encoded;
  const std::optional<RawMesh> expected = decode_with_libdraco(*stream);
  if (!expected) return 0;
  ++counts.decoded;
  core::StreamHeader header;
  if (core::read_stream_header(stream->data(), stream->size(), header) != core::Fault::kNone)
    fail("the header", subject, recipe);
  if (!decodes(header, stream->size(), *expected)) fail("the mesh", subject, recipe);
  if (const char* what = check_condensed(*stream, *expected)) fail(what, subject, recipe);
  return 0;
}
