// A stream that libdraco's encoder wrote comes back from its fields bit for bit.
#include "encoder/fields/draco_fields.h"

#include <algorithm>
#include <random>

#include "encoder/coding/quantization.h"
#include "encoder/encode_mesh.h"
#include "src/container/patch_container.h"
#include "tests/support/corpus_streams.h"
#include "tests/support/draco_streams.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/reproducible_meshes.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

// Writes the fields, and returns the place of the first difference from the stream, or an empty string.
std::string difference(std::span<const uint8_t> stream, const DracoFields& fields) {
  const Expected<Bytes> again = write_fields(fields);
  if (!again) return again.status().message();
  const auto [at, in_stream] = std::mismatch(again->begin(), again->end(), stream.begin(), stream.end());
  if (at == again->end() && in_stream == stream.end()) return {};
  return "byte " + std::to_string(at - again->begin()) + " of " + std::to_string(stream.size());
}

// Counts streams by feature. It shows that the tests meet all features.
struct Features {
  size_t streams = 0, events = 0, handles = 0, valence = 0, components = 0, closed = 0, seams = 0, raw = 0,
         creases = 0, orientations = 0, flips = 0, wraps = 0, levels = 0;

  void count(const DracoFields& fields) {
    const auto any = [](const Bytes& flags) { return std::ranges::count(flags, 1) > 0; };
    ++streams;
    handles += !fields.split_events.empty();
    valence += std::ranges::any_of(fields.symbol_lists, [](const Bytes& list) { return !list.empty(); });
    components += fields.start_faces.size() > 1;
    closed += any(fields.start_faces);
    seams += std::ranges::any_of(fields.seams, any);
    levels |= fields.possible_levels;
    for (const AttributeFields& attribute : fields.attributes) {
      raw += !attribute.raw.empty();
      creases += std::ranges::any_of(attribute.creases, any);
      orientations += any(attribute.same_orientations);
      flips += any(attribute.flips);
      wraps += attribute.wrap_max != 0;
    }
  }
};

void expect_every_stream_back(StreamSet set) {
  Features seen;
  size_t others = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        const Expected<DracoFields> fields = read_fields(stream.bytes);
        if (!fields) {
          ++others;
          const std::string message = fields.status().message();
          EXPECT_TRUE(message == "a sequential mesh" || message == "integers that are not entropy-coded")
              << stream.name << ": " << message;
          return;
        }
        seen.count(*fields);
        EXPECT_EQ(difference(stream.bytes, *fields), "") << stream.name;
        EXPECT_NE(fields->possible_levels >> fields->symbol_level & 1, 0u) << stream.name;
        EXPECT_EQ(fields->symbols.size(), fields->symbol_count);
        if (std::ranges::all_of(fields->symbol_lists, &Bytes::empty)) return;
        DracoFields listed = *fields;
        for (Bytes& list : listed.symbol_lists) list.assign(3, 0);
        ASSERT_TRUE(list_symbols(listed).ok()) << stream.name;
        EXPECT_EQ(listed.symbol_lists, fields->symbol_lists) << stream.name;
      },
      set);
  EXPECT_GT(seen.streams, set == StreamSet::kThird ? 1500u : 300u);
  EXPECT_GT(others, 0u);
  for (const size_t feature : {seen.handles, seen.valence, seen.components, seen.closed, seen.seams, seen.raw,
                               seen.creases, seen.orientations, seen.flips, seen.wraps})
    EXPECT_GT(feature, 0u);
}

TEST(DracoFields, EveryKindOfStreamComesBack) { expect_every_stream_back(StreamSet::kSmall); }

TEST(DracoFields, EveryThirdOfAllStreamsComesBackTakesLong) { expect_every_stream_back(StreamSet::kThird); }

EncodedMesh encode_sheet(const Mesh& mesh, uint32_t patch_count, int speed) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes)
    codings.push_back(attribute.semantic == "NORMAL"                        ? AttributeCoding{10, true, {}, 0}
                      : attribute.component_type == ComponentType::kFloat32 ? *fit_grid(attribute, 12)
                                                                            : AttributeCoding{});
  const StreamOptions options{.patch_count = patch_count, .encode_speed = speed, .verify = false};
  EncodedMesh encoded = must(encode_mesh(mesh, codings, options, ThreadPool(1)));
  return encoded;
}

// Patches of all sizes down to a face. All patches of a mesh have the level of its speed.
TEST(DracoFields, EveryPatchAtEverySpeedComesBack) {
  const Mesh sheet = make_sheet(24, 20);
  for (int speed = 0; speed <= 10; ++speed)
    for (const uint32_t patch_count : {1u, 2u, 7u, 60u, 960u}) {
      const EncodedMesh encoded = encode_sheet(sheet, patch_count, speed);
      const PatchContainer container = *open_container(encoded.pieces[0].bytes);
      for (const std::span<const uint8_t> stream : container.streams) {
        const DracoFields fields = must(read_fields(stream));
        EXPECT_EQ(difference(stream, fields), "") << patch_count << " patches, speed " << speed;
        EXPECT_NE(fields.possible_levels >> (10 - speed) & 1, 0u) << "speed " << speed;
        DracoFields same = fields;
        same.symbol_level = 10 - speed;
        EXPECT_EQ(difference(stream, same), "") << patch_count << " patches, speed " << speed;
      }
    }
}

// The memory that a stream may claim is little for each face: this one has half a byte for each.
TEST(DracoFields, ASeamOfALargeFlatSheetComesBack) {
  constexpr uint32_t kQuads = 115, kSeam = kQuads / 2,
                     kColumns = kQuads + 2;  // points; column kSeam is there twice
  Mesh sheet;
  sheet.point_count = kColumns * (kQuads + 1);
  std::vector<float> positions, texcoords;
  for (uint32_t row = 0; row <= kQuads; ++row)
    for (uint32_t column = 0; column < kColumns; ++column) {
      const uint32_t x = column > kSeam ? column - 1 : column;
      positions.insert(positions.end(), {static_cast<float>(x), static_cast<float>(row), 0.0f});
      texcoords.insert(texcoords.end(), {static_cast<float>(column), static_cast<float>(row)});
    }
  for (uint32_t row = 0; row < kQuads; ++row)
    for (uint32_t column = 0; column + 1 < kColumns; ++column) {
      if (column == kSeam) continue;
      const uint32_t a = row * kColumns + column, b = a + kColumns;
      sheet.faces.push_back({a, a + 1, b});
      sheet.faces.push_back({a + 1, b + 1, b});
    }
  const auto bytes_of = [](const std::vector<float>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    return Array<std::byte>(bytes.begin(), bytes.end());
  };
  sheet.attributes = {{"POSITION", ComponentType::kFloat32, 3, false, bytes_of(positions)},
                      {"TEXCOORD_0", ComponentType::kFloat32, 2, false, bytes_of(texcoords)}};
  const EncodedMesh encoded = encode_sheet(sheet, 1, 5);
  const Expected<PatchContainer> opened = open_piece(encoded.pieces[0]);
  ASSERT_TRUE(opened.ok());
  EXPECT_LT(opened->streams[0].size(), sheet.faces.size() * 3 / 5);
  EXPECT_EQ(difference(opened->streams[0], must(read_fields(opened->streams[0]))), "");
}

// Bytes after a stream come back too. Two streams of an older encoder do not: before libdraco 1.5.1 the order
// of equal probabilities depended on the encoder's standard library.
TEST(DracoFields, StreamsOfTheCorpusComeBack) {
  std::vector<std::string> different;
  for_each_corpus_stream([&](const std::string& file, const Bytes& stream) {
    const bool is_edgebreaker = stream.size() > 8 && stream[8] == 1;
    if (is_edgebreaker && !difference(stream, must(read_fields(stream))).empty()) different.push_back(file);
  });
  if (IsSkipped()) return;
  EXPECT_EQ(different, std::vector<std::string>(2, "2CylinderEngine.bin"));
}

std::vector<Bytes> streams_to_damage() {
  std::vector<Bytes> streams;
  size_t count = 0;
  for (const DracoStream& stream : small_draco_streams())
    if (stream.bytes.size() < 2000 && count++ % 7 == 0) streams.push_back(stream.bytes);
  return streams;
}

// Bytes of an exact size, so that sanitizers see a read past their end.
void read_and_write(std::span<const uint8_t> bytes) {
  const std::unique_ptr<uint8_t[]> exact(new uint8_t[bytes.size()]);
  std::ranges::copy(bytes, exact.get());
  const Expected<DracoFields> fields = read_fields({exact.get(), bytes.size()});
  if (!fields) return;
  EXPECT_TRUE(write_fields(*fields).ok());
  DracoFields listed = *fields;
  EXPECT_TRUE(list_symbols(listed).ok());
  EXPECT_EQ(listed.symbols, fields->symbols);
}

TEST(DracoFields, EveryTruncationIsRefused) {
  for (const Bytes& stream : streams_to_damage()) {
    if (!read_fields(stream)) continue;
    for (size_t size = 0; size < stream.size(); size += 1 + stream.size() / 300) {
      const std::unique_ptr<uint8_t[]> exact(new uint8_t[size]);
      std::copy_n(stream.begin(), size, exact.get());
      EXPECT_FALSE(read_fields({exact.get(), size}).ok()) << size << " of " << stream.size();
    }
  }
}

TEST(DracoFields, MutantsDoNotCrash) {
  std::mt19937 random(7);
  const auto below = [&](size_t n) { return static_cast<size_t>(random() % n); };
  for (const Bytes& stream : streams_to_damage())
    for (int i = 0; i < 40; ++i) {
      Bytes mutant = stream;
      for (size_t n = 1 + below(3); n > 0; --n) edit(mutant, below(mutant.size()), random);
      read_and_write(mutant);
    }
}

// Fields that were changed are written or refused.
TEST(DracoFields, ContradictionsAreRefused) {
  const EncodedMesh encoded = encode_sheet(make_sheet(6, 5), 1, 0);
  const DracoFields good = *read_fields(open_container(encoded.pieces[0].bytes)->streams[0]);
  const auto refused = [&](auto change) {
    DracoFields fields = good;
    change(fields);
    return !write_fields(fields).ok();
  };
  EXPECT_FALSE(refused([](DracoFields&) {}));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.attributes.pop_back(); }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.attributes.emplace_back(); }));
  EXPECT_TRUE(refused([](DracoFields& fields) { ++fields.attributes[0].count; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.attributes[0].symbols.pop_back(); }));
  // A symbol of 32 bits is written in the tagged coding.
  EXPECT_FALSE(refused([](DracoFields& fields) { fields.attributes[0].symbols[0] = ~0u; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.seams.emplace_back(); }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.skeleton.resize(20); }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.skeleton.clear(); }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.split_events = {{5, 3, 0}}; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.split_events = {{1, 1u << 30, 0}}; }));
  for (size_t at = 0; at < good.skeleton.size(); ++at)
    for (const int byte : {0, 1, 2, 4, 0x7f, 0x80, 0xff}) {
      DracoFields fields = good;
      fields.skeleton[at] = static_cast<uint8_t>(byte);
      write_fields(fields).ok();
    }
}

TEST(DracoFields, SymbolsThatFormNoMeshHaveNoLists) {
  const EncodedMesh encoded = encode_sheet(make_sheet(6, 5), 1, 0);
  const DracoFields good = *read_fields(open_container(encoded.pieces[0].bytes)->streams[0]);
  const auto refused = [&](auto change) {
    DracoFields fields = good;
    change(fields);
    return !list_symbols(fields).ok();
  };
  EXPECT_FALSE(refused([](DracoFields&) {}));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.symbols[0] = core::kC; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.symbols[1] = 2; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.symbols[1] = 77; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.symbols.pop_back(); }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.face_count = 1u << 29; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.vertex_count = 0xffffffffu; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.vertex_count = 4; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.split_events = {{0, 1u << 30, 0}}; }));
  EXPECT_TRUE(refused([](DracoFields& fields) { fields.split_events = {{0, 3, 0}, {1, 3, 0}}; }));
}

}  // namespace
}  // namespace psplit
