// A mesh that is encoded part by part comes back as one mesh, however it is cut.
#include "encoder/encode_parts.h"

#include <cmath>
#include <cstring>
#include <random>

#include "encoder/cut_faces.h"
#include "encoder/libdraco/draco_backend.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/condensed_head.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "tests/support/compare_meshes.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/default_codings.h"
#include "tests/support/mesh_in_parts.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/reproducible_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

Mesh reduced(const Mesh& mesh) {
  return reduce(mesh, {.drop_degenerate = true, .drop_unused = true}, ThreadPool(1)).mesh;
}

// Parts of consecutive faces.
std::vector<uint32_t> slabs(const Mesh& mesh, uint32_t count) {
  std::vector<uint32_t> part(mesh.faces.size());
  for (size_t face = 0; face < part.size(); ++face)
    part[face] = static_cast<uint32_t>(face * count / part.size());
  return part;
}

std::vector<uint32_t> random_parts(const Mesh& mesh, uint32_t count) {
  std::mt19937 random(count);
  std::vector<uint32_t> part(mesh.faces.size());
  for (uint32_t& number : part) number = static_cast<uint32_t>(random() % count);
  return part;
}

Expected<EncodedMesh> encode(MeshParts& parts, std::span<const AttributeCoding> codings,
                             const PartsOptions& options, int threads = 2) {
  return encode_parts(parts, codings, options, make_memory_spill, ThreadPool(threads));
}

// The bounds as JSON has them: least, then most.
std::vector<double> bounds_of(const Attribute& attribute, uint32_t point_count) {
  std::vector<double> least(attribute.component_count, 0), most = least;
  for (size_t c = 0; c < least.size(); ++c) {
    bool any = false;
    for (size_t point = 0; point < point_count; ++point) {
      const std::byte* at =
          &attribute.values[point * attribute.stride() + c * component_bytes(attribute.component_type)];
      double value = 0;
      const auto load = [&]<typename T>(T number) {
        std::memcpy(&number, at, sizeof(T));
        value = static_cast<double>(number);
      };
      switch (attribute.component_type) {
        case ComponentType::kInt8: load(int8_t{}); break;
        case ComponentType::kUint8: load(uint8_t{}); break;
        case ComponentType::kInt16: load(int16_t{}); break;
        case ComponentType::kUint16: load(uint16_t{}); break;
        case ComponentType::kUint32: load(uint32_t{}); break;
        case ComponentType::kFloat32: load(float{}); break;
      }
      if (!std::isfinite(value)) continue;
      least[c] = any ? std::min(least[c], value) : value;
      most[c] = any ? std::max(most[c], value) : value;
      any = true;
    }
  }
  least.insert(least.end(), most.begin(), most.end());
  return least;
}

void expect_same_mesh(const Mesh& mesh, const Coded& codings, EncodedMesh& encoded) {
  ASSERT_EQ(encoded.pieces.size(), 1u);
  EncodedPiece& container = encoded.pieces[0];
  const std::vector<uint8_t> bytes = read_all(*container.stored);
  const PatchContainer opened = must(open_container(bytes));
  EXPECT_EQ(opened.entries, container.entries);
  EXPECT_EQ(opened.point_count(), container.point_count);
  EXPECT_EQ(opened.face_count(), container.face_count);
  const ThreadPool pool(2);
  for (const DecodeBackend& backend : {cpu_backend(), draco_backend()}) {
    const auto decoded = must(backend.decode(opened, encoded.requests, pool));
    EXPECT_EQ(compare_meshes(mesh, decoded, codings.tolerances), "") << backend.name;
    for (size_t i = 0; i < decoded.attributes.size(); ++i) {
      std::vector<double> bounds = container.bounds[i].least;
      bounds.insert(bounds.end(), container.bounds[i].most.begin(), container.bounds[i].most.end());
      EXPECT_EQ(bounds, bounds_of(decoded.attributes[i], decoded.point_count));
    }
  }
}

std::vector<NamedMesh> catalogue() {
  std::vector<NamedMesh> kept;
  for (const NamedMesh& named : all_meshes())
    if (Mesh mesh = reduced(named.mesh); !mesh.faces.empty()) kept.push_back({named.name, std::move(mesh)});
  return kept;
}

void expect_all_come_back(uint64_t patch_faces, uint32_t part_count, bool at_random, size_t most_faces) {
  for (const NamedMesh& named : catalogue()) {
    const Mesh& mesh = named.mesh;
    if (mesh.faces.size() > most_faces) continue;
    for (const bool lossless : {false, true}) {
      SCOPED_TRACE(named.name + (lossless ? ", lossless" : ""));
      const Coded codings = default_codings(mesh, lossless);
      MeshInParts parts(mesh, at_random ? random_parts(mesh, part_count) : slabs(mesh, part_count));
      auto encoded = must(encode(parts, codings.codings, {.patch_faces = patch_faces}));
      expect_same_mesh(mesh, codings, encoded);
    }
  }
}

TEST(EncodeParts, EveryMeshComesBackFromSlabs) { expect_all_come_back(700, 5, false, 1000000); }
TEST(EncodeParts, EveryMeshComesBackFromManyParts) { expect_all_come_back(40, 40, false, 4000); }
TEST(EncodeParts, EveryMeshComesBackFromRandomParts) { expect_all_come_back(700, 3, true, 6000); }
TEST(EncodeParts, EveryMeshComesBackFromAPartForEachFace) { expect_all_come_back(1, 1000000, true, 400); }

TEST(EncodeParts, OnePartIsTheContainerOfEncodeMesh) {
  for (const NamedMesh& named : catalogue()) {
    SCOPED_TRACE(named.name);
    const Coded codings = default_codings(named.mesh, false);
    MeshInParts parts(named.mesh, slabs(named.mesh, 1));
    auto encoded = must(encode(parts, codings.codings, {.patch_faces = 900, .streams = {.boxes = true}}));
    const StreamOptions options{
        .patch_count = std::max(1u, static_cast<uint32_t>((named.mesh.faces.size() + 450) / 900)),
        .boxes = true,
        .keep_duplicates = true};
    const auto whole = must(encode_mesh(named.mesh, codings.codings, options, ThreadPool(2)));
    EXPECT_EQ(read_all(*encoded.pieces[0].stored), whole.pieces[0].bytes);
  }
}

// The patches that encode_parts makes of a part.
std::vector<std::vector<uint32_t>> patches_of(const Mesh& part, uint32_t patch_count) {
  WeldedMesh welded = weld(part, ThreadPool(1));
  separate_flat_faces(welded);
  return cut_faces(welded, {.patch_count = patch_count}, {}, ThreadPool(1)).patches;
}

// References to earlier parts are as short as those within a part.
TEST(EncodeParts, IsTheContainerOfEncodeMeshWithTheSamePatches) {
  const Mesh mesh = reduced(make_sheet(120, 100));
  const Coded codings = default_codings(mesh, false);
  for (const auto& part_of_face : {slabs(mesh, 4), random_parts(mesh, 3)}) {
    MeshInParts parts(mesh, part_of_face);
    auto encoded = must(encode(parts, codings.codings, {.patch_faces = 2000}));
    std::vector<uint32_t> patch_of_face(mesh.faces.size());
    uint32_t patch = 0;
    for (uint32_t part = 0; part < parts.part_count(); ++part) {
      const std::vector<uint32_t>& faces = parts.faces()[part];
      for (const auto& patch_faces :
           patches_of(parts.parts()[part].mesh, static_cast<uint32_t>((faces.size() + 1000) / 2000))) {
        for (const uint32_t face : patch_faces) patch_of_face[faces[face]] = patch;
        ++patch;
      }
    }
    const StreamOptions options{.patch_of_face = patch_of_face};
    const auto whole = must(encode_mesh(mesh, codings.codings, options, ThreadPool(2)));
    EXPECT_EQ(encoded.statistics.patch_count, patch);
    EXPECT_EQ(encoded.statistics.position_error, whole.statistics.position_error);
    EXPECT_EQ(read_all(*encoded.pieces[0].stored), whole.pieces[0].bytes);
  }
}

TEST(EncodeParts, BytesDoNotDependOnThreads) {
  const Mesh mesh = reduced(make_sheet(60, 50));
  const Coded codings = default_codings(mesh, false);
  std::vector<uint8_t> expected;
  for (const int threads : {1, 2, 5}) {
    MeshInParts parts(mesh, slabs(mesh, 3));
    std::atomic<size_t> faces = 0;
    auto encoded = must(encode(
        parts, codings.codings,
        {.patch_faces = 300, .streams = {.patch_encoded = [&](size_t count) { faces += count; }}}, threads));
    EXPECT_EQ(faces, mesh.faces.size());
    std::vector<uint8_t> bytes = read_all(*encoded.pieces[0].stored);
    if (threads == 1) expected = bytes;
    EXPECT_EQ(bytes, expected) << threads << " threads";
  }
}

// The faces of some parts as a mesh.
Mesh faces_of(const Mesh& mesh, const MeshInParts& parts, uint32_t first, uint32_t end) {
  Mesh some = mesh;
  some.faces.clear();
  for (uint32_t part = first; part < end; ++part)
    for (const uint32_t face : parts.faces()[part]) some.faces.push_back(mesh.faces[face]);
  return reduced(some);
}

TEST(EncodeParts, BeginsAnotherContainerAtTheLimit) {
  const Mesh mesh = reduced(make_sheet(60, 50));
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 7));
  const uint64_t most = 1200;
  auto encoded = must(encode(parts, codings.codings, {.patch_faces = 300, .most_points = most}));
  EXPECT_EQ(encoded.pieces.size(), 4u);
  uint32_t first = 0;
  for (EncodedPiece& container : encoded.pieces) {
    EXPECT_LE(container.point_count, most);
    uint32_t end = first;
    for (uint64_t faces = 0; faces < container.face_count;) faces += parts.faces()[end++].size();
    const std::vector<uint8_t> bytes = read_all(*container.stored);
    const auto decoded = must(decode_container(cpu_backend(), bytes, encoded.requests, ThreadPool(2)));
    EXPECT_EQ(compare_meshes(faces_of(mesh, parts, first, end), decoded, codings.tolerances), "");
    first = end;
  }
  EXPECT_EQ(first, parts.part_count());
}

TEST(EncodeParts, RefusesAPartThatNoContainerCanHold) {
  const Mesh mesh = reduced(make_sheet(20, 10));
  MeshInParts parts(mesh, slabs(mesh, 2));
  const auto encoded = encode(parts, default_codings(mesh, false).codings, {.most_points = 50});
  ASSERT_FALSE(encoded.ok());
  EXPECT_EQ(encoded.status().code(), StatusCode::kUnsupported);
  EXPECT_EQ(encoded.status().to_string(), "part 0: more points or faces than a container can hold");
}

// Flips a bit of the bytes that are appended, or of the bytes that are read.
class BrokenSpill : public MemorySpill {
 public:
  // Sets `bits` to the number of bits that were appended.
  BrokenSpill(uint64_t bit, bool when_read, uint64_t& bits) : bit_(bit), when_read_(when_read), bits_(bits) {}

  Status append(Span<const uint8_t> bytes) override {
    std::vector<uint8_t> copy(bytes.begin(), bytes.end());
    if (!when_read_) flip(size(), copy);
    Status status = MemorySpill::append(copy);
    bits_ = std::max(bits_, 8 * size());
    return status;
  }
  Status read(uint64_t offset, Span<uint8_t> to) override {
    Status status = MemorySpill::read(offset, to);
    if (when_read_) flip(offset, to);
    return status;
  }

 private:
  void flip(uint64_t begin, std::span<uint8_t> bytes) const {
    if (bit_ / 8 < begin || bit_ / 8 - begin >= bytes.size()) return;
    bytes[static_cast<size_t>(bit_ / 8 - begin)] ^= static_cast<uint8_t>(1u << bit_ % 8);
  }

  const uint64_t bit_;
  const bool when_read_;
  uint64_t& bits_;
};

// The spills in the order in which they are made.
enum SpillKind : size_t { kMaps, kStreams, kWalks };

// A mesh in three parts of two patches each. Verification may take a normal that is a step off for the right
// one, so the mesh has none.
Mesh small_sheet() {
  Mesh mesh = reduced(make_sheet(12, 10));
  std::erase_if(mesh.attributes, [](const Attribute& attribute) { return attribute.semantic == "NORMAL"; });
  return mesh;
}

struct Broken {
  size_t refused = 0, equal = 0;
};

// Encodes with one bit flipped, for every `step`-th bit of a spill. A result that is not refused must be the
// mesh.
Broken encode_broken(SpillKind kind, bool when_read, uint64_t step) {
  const Mesh mesh = small_sheet();
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 3));
  Broken result;
  uint64_t end = 0;
  const auto encode_with = [&](uint64_t bit) {
    size_t made = 0;
    const MakeSpill make = [&]() -> Expected<std::unique_ptr<Spill>> {
      std::unique_ptr<Spill> spill = std::make_unique<MemorySpill>();
      if (made++ == kind) spill = std::make_unique<BrokenSpill>(bit, when_read, end);
      return spill;
    };
    return encode_parts(parts, codings.codings, {.patch_faces = 40}, make, ThreadPool(1));
  };
  EXPECT_TRUE(encode_with(UINT64_MAX).ok());
  for (uint64_t bit = 0; bit < end; bit += step) {
    auto encoded = encode_with(bit);
    if (!encoded) {
      ++result.refused;
      EXPECT_EQ(encoded.status().code(), StatusCode::kRuntimeFailure) << encoded.status().to_string();
      EXPECT_TRUE(contains(encoded.status().message(), "verification"));
      continue;
    }
    ++result.equal;
    const std::vector<uint8_t> bytes = read_all(*encoded->pieces[0].stored);
    const auto decoded = decode_container(draco_backend(), bytes, encoded->requests, ThreadPool(1));
    EXPECT_EQ(decoded.status().to_string(), "") << "bit " << bit;
    if (decoded) {
      EXPECT_EQ(compare_meshes(mesh, *decoded, codings.tolerances), "") << "bit " << bit;
    }
  }
  return result;
}

TEST(EncodeParts, FindsABrokenBitOfAStitchMap) {
  const Broken broken = encode_broken(kMaps, false, 1);
  EXPECT_GT(broken.refused, 100u);
  EXPECT_EQ(broken.equal, 0u);
}

TEST(EncodeParts, FindsMutantsOfAStream) {
  const Broken broken = encode_broken(kStreams, false, 31);
  EXPECT_GT(broken.refused, 500u);
  // Bits without a meaning, the last bits of grids, and values of copies, which decoders take from the owner.
  EXPECT_LT(broken.equal, broken.refused / 3);
}

TEST(EncodeParts, FindsMutantsOfAWalk) {
  const Broken broken = encode_broken(kWalks, true, 5);
  EXPECT_GT(broken.refused, 40u);
  // Only some walks are read again, and only some places of these.
  EXPECT_GT(broken.equal, 0u);
}

TEST(EncodeParts, PassesOnTheErrorsOfSpills) {
  class FullSpill : public MemorySpill {
   public:
    Status append(Span<const uint8_t> bytes) override {
      return size() + bytes.size() > 2000 ? io_failure("no space left") : MemorySpill::append(bytes);
    }
  };
  const Mesh mesh = reduced(make_sheet(60, 50));
  MeshInParts parts(mesh, slabs(mesh, 3));
  const Coded codings = default_codings(mesh, false);
  const MakeSpill full = [] { return Expected(std::unique_ptr<Spill>(std::make_unique<FullSpill>())); };
  const auto encoded = encode_parts(parts, codings.codings, {}, full, ThreadPool(1));
  EXPECT_EQ(encoded.status().code(), StatusCode::kIo);
  EXPECT_EQ(encoded.status().to_string(), "part 0: no space left");
  const MakeSpill none = []() -> Expected<std::unique_ptr<Spill>> { return io_failure("no folder"); };
  EXPECT_EQ(encode_parts(parts, codings.codings, {}, none, ThreadPool(1)).status().to_string(),
            "part 0: no folder");
}

// A mesh with faces that repeat an index, whose points other faces use or not, and with points that no face
// uses.
Mesh with_leftovers(uint32_t columns = 40, uint32_t rows = 30) {
  Mesh mesh = make_sheet(columns, rows);
  const uint32_t used = mesh.point_count;
  append_points(mesh, used - used / 10, used);
  std::vector<std::array<uint32_t, 3>> faces;
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
    const uint32_t a = mesh.faces[i][0], b = mesh.faces[mesh.faces.size() - 1 - i][1];
    faces.push_back(mesh.faces[i]);
    if (i % 17 == 0) faces.push_back({a, b, b});
    if (i % 23 == 0) faces.push_back({used + i % (used / 20), a, a});
  }
  mesh.faces.assign(faces.begin(), faces.end());
  return mesh;
}

// The parts, and the points that no face uses in one of them. A point that another part uses is in it as well.
MeshInParts parts_with_unused(const Mesh& mesh, const std::vector<uint32_t>& part_of_face) {
  MeshInParts parts(mesh, part_of_face);
  std::vector<uint8_t> is_used(mesh.point_count, 0);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) is_used[point] = 1;
  MeshPart& part = parts.parts()[parts.part_count() / 2];
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    if (is_used[point] != 0) continue;
    ++part.mesh.point_count;
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Attribute& from = mesh.attributes[i];
      const auto value = from.values.begin() + static_cast<std::ptrdiff_t>(point * from.stride());
      Array<std::byte>& to = part.mesh.attributes[i].values;
      to.insert(to.end(), value, value + static_cast<std::ptrdiff_t>(from.stride()));
    }
  }
  return parts;
}

// The boxes fit the decoded mesh, also where parts share points, and in the residue.
TEST(EncodeParts, BoxesAreThoseOfTheDecodedMesh) {
  std::vector<NamedMesh> meshes = all_meshes();
  meshes.push_back({"leftovers", with_leftovers()});
  size_t count = 0;
  for (const NamedMesh& named : meshes) {
    const Mesh& mesh = named.mesh;
    if (mesh.faces.size() > fewer_with_sanitizers(20000) || reduced(mesh).faces.empty()) continue;
    for (const bool lossless : {false, true})
      for (const bool condense : {false, true})
        for (const bool verify : {false, true}) {
          SCOPED_TRACE(named.name + (lossless ? ", lossless" : "") + (condense ? ", condensed" : ""));
          const Coded codings = default_codings(mesh, lossless);
          MeshInParts parts = parts_with_unused(mesh, slabs(mesh, 5));
          PartsOptions options{.patch_faces = 300, .streams = {.condense = condense, .verify = verify}};
          auto without = must(encode(parts, codings.codings, options));
          options.streams.boxes = true;
          auto encoded = must(encode(parts, codings.codings, options));
          ASSERT_EQ(encoded.pieces.size(), 1u);
          const std::vector<uint8_t> bytes = read_all(*encoded.pieces[0].stored);
          const PatchContainer opened = must(open_container(bytes));
          EXPECT_EQ(opened.entries, encoded.pieces[0].entries);
          EXPECT_EQ(opened.head_bytes, encoded.pieces[0].head_bytes);
          const Mesh decoded = must(cpu_backend().decode(opened, encoded.requests, ThreadPool(2)));
          const std::vector<uint8_t> wanted = write_boxes(boxes_of(opened, decoded));
          const std::span<const uint8_t> section = boxes_section(opened);
          EXPECT_EQ(std::vector<uint8_t>(section.begin(), section.end()), wanted);
          std::vector<uint8_t> expected = read_all(*without.pieces[0].stored);
          if (!wanted.empty())
            expected = with_head_section(must(open_container(expected)), HeadSection::kBoxes, wanted);
          EXPECT_EQ(bytes, expected);
          count += wanted.empty() ? 0 : 1;
        }
  }
  EXPECT_GT(count, fewer_with_sanitizers(50));
}

TEST(EncodeParts, EachContainerHasItsOwnBoxes) {
  const Mesh mesh = with_leftovers();
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 5));
  auto encoded = must(encode(parts, codings.codings,
                             {.patch_faces = 300, .streams = {.boxes = true}, .most_residue_points = 50}));
  EXPECT_GT(encoded.pieces.size(), 1u);
  for (EncodedPiece& container : encoded.pieces) {
    const std::vector<uint8_t> bytes = read_all(*container.stored);
    EXPECT_EQ(must(patch_boxes(must(open_container(bytes)))).size(), container.entries.size());
  }
}

TEST(EncodeParts, KeepsFacesThatRepeatAPointAndPointsWithoutFaces) {
  const Mesh mesh = with_leftovers();
  for (const bool lossless : {false, true}) {
    const Coded codings = default_codings(mesh, lossless);
    for (const auto& part_of_face :
         {slabs(mesh, 1), slabs(mesh, 5), random_parts(mesh, 3), random_parts(mesh, 900)}) {
      MeshInParts parts = parts_with_unused(mesh, part_of_face);
      auto encoded = must(encode(parts, codings.codings, {.patch_faces = 300}));
      expect_same_mesh(mesh, codings, encoded);
      EXPECT_GT(encoded.statistics.residue_faces, 100u);
      const EncodedPiece& container = encoded.pieces[0];
      EXPECT_LT(container.used_point_count, container.point_count);
      EXPECT_EQ(container.entries.size(), encoded.statistics.patch_count + 1);
    }
  }
  // The faces of one part are all in the residue.
  MeshInParts parts(mesh, slabs(mesh, 3));
  for (auto& face : parts.parts()[1].mesh.faces) face[0] = face[1];
  auto encoded = must(encode(parts, default_codings(mesh, false).codings, {.patch_faces = 300}));
  EXPECT_EQ(encoded.pieces[0].face_count, mesh.faces.size());
}

TEST(EncodeParts, OnePartWithAResidueIsTheContainerOfEncodeMesh) {
  std::vector<NamedMesh> meshes = nasty_meshes();
  meshes.push_back({"leftovers", with_leftovers()});
  for (const NamedMesh& named : meshes) {
    if (reduced(named.mesh).faces.empty()) continue;
    SCOPED_TRACE(named.name);
    const Coded codings = default_codings(named.mesh, false);
    MeshInParts parts(named.mesh, slabs(named.mesh, 1));
    MeshPart& part = parts.parts()[0];
    part = {named.mesh, {}, {}};
    auto encoded = must(encode(parts, codings.codings, {.patch_faces = 1u << 30}));
    const auto whole = must(encode_mesh(named.mesh, codings.codings, {.keep_duplicates = true}, ThreadPool(2)));
    EXPECT_EQ(read_all(*encoded.pieces[0].stored), whole.pieces[0].bytes);
  }
}

// A large residue does not stay in memory.
TEST(EncodeParts, AResidueMayEndItsContainer) {
  const Mesh mesh = with_leftovers();
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 5));
  auto encoded = must(encode(parts, codings.codings, {.patch_faces = 300, .most_residue_points = 50}));
  EXPECT_GT(encoded.pieces.size(), 1u);
  uint64_t faces = 0;
  for (EncodedPiece& container : encoded.pieces) {
    const auto decoded =
        must(decode_container(draco_backend(), read_all(*container.stored), encoded.requests, ThreadPool(2)));
    faces += decoded.faces.size();
  }
  EXPECT_EQ(faces, mesh.faces.size());
}

TEST(EncodeParts, ContainersMayBeCondensed) {
  const Mesh mesh = with_leftovers(90, 80);
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts = parts_with_unused(mesh, slabs(mesh, 4));
  auto plain = encode(parts, codings.codings, {.patch_faces = 900});
  auto condensed = encode(parts, codings.codings, {.patch_faces = 900, .streams = {.condense = true}});
  ASSERT_TRUE(plain.ok() && condensed.ok()) << condensed.status().to_string();
  expect_same_mesh(mesh, codings, *condensed);
  EXPECT_LT(condensed->pieces[0].stored->size(), plain->pieces[0].stored->size());
  EXPECT_GT(condensed->pieces[0].head_bytes, 0u);
  // A container that is in memory while it is condensed ends early.
  condensed = encode(parts, codings.codings,
                     {.patch_faces = 900, .streams = {.condense = true}, .condensed_points = 3000});
  ASSERT_TRUE(condensed.ok()) << condensed.status().to_string();
  EXPECT_GT(condensed->pieces.size(), 1u);
  uint64_t faces = 0;
  for (EncodedPiece& container : condensed->pieces) faces += container.face_count;
  EXPECT_EQ(faces, mesh.faces.size());
}

TEST(EncodeParts, StreamsMayBeAlone) {
  const Mesh mesh = reduced(with_leftovers());
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 4));
  auto encoded = must(encode(parts, codings.codings, {.patch_faces = 300, .streams = {.alone = Alone::kAll}}));
  EXPECT_EQ(encoded.pieces.size(), encoded.statistics.patch_count);
  EXPECT_TRUE(encoded.statistics.position_error);
  Mesh all;
  uint32_t own_points = 0;
  for (EncodedPiece& alone : encoded.pieces) {
    const auto decoded = must(decode_draco_stream(read_all(*alone.stored), encoded.requests));
    EXPECT_EQ(decoded.point_count, alone.point_count);
    EXPECT_EQ(decoded.faces.size(), alone.face_count);
    ASSERT_EQ(alone.entries.size(), 1u);
    own_points += alone.entries[0].point_count - alone.entries[0].reference_count;
    append_mesh(all, decoded);
    for (size_t i = 0; i < all.attributes.size(); ++i) {
      std::vector<double> bounds = alone.bounds[i].least;
      bounds.insert(bounds.end(), alone.bounds[i].most.begin(), alone.bounds[i].most.end());
      EXPECT_EQ(bounds, bounds_of(decoded.attributes[i], decoded.point_count));
    }
  }
  EXPECT_EQ(own_points, mesh.point_count);
  // Points at borders are in several streams.
  EXPECT_EQ(compare_meshes(mesh, reduce(all, {}, ThreadPool(1)).mesh, codings.tolerances), "");
}

TEST(EncodeParts, RefusesPartsThatBreakTheRules) {
  const Mesh mesh = reduced(make_sheet(12, 10));
  const Coded codings = default_codings(mesh, false);
  const auto error = [&](const std::function<void(std::vector<MeshPart>&)>& change) {
    MeshInParts parts(mesh, slabs(mesh, 2));
    change(parts.parts());
    const auto encoded = encode(parts, codings.codings, {});
    EXPECT_EQ(encoded.status().code(), StatusCode::kInvalidInput);
    return encoded.status().to_string();
  };
  using Parts = std::vector<MeshPart>;
  EXPECT_EQ(error([](Parts& parts) { parts[1].mesh.attributes[1].semantic = "_OTHER"; }),
            "part 1: its attributes differ from those of part 0");
  EXPECT_EQ(error([](Parts& parts) { parts[1].shared_numbers.pop_back(); }),
            "part 1: shared points without numbers");
  EXPECT_EQ(error([](Parts& parts) { parts[0].shared_numbers[0] = 1000; }),
            "part 0: shared points that do not ascend, or that do not exist");
  EXPECT_EQ(error([](Parts& parts) { parts.clear(); }), "the mesh has no triangles");
}

TEST(EncodeParts, ReportsTheBytesOfEachPartAndMayBeEnded) {
  const Mesh mesh = reduced(make_sheet(60, 50));
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 3));
  std::vector<uint64_t> reported;
  PartsOptions options;
  options.part_written = [&](uint64_t bytes) {
    reported.push_back(bytes);
    return Status();
  };
  auto encoded = encode(parts, codings.codings, options);
  ASSERT_TRUE(encoded.ok()) << encoded.status().to_string();
  ASSERT_EQ(reported.size(), 3u);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  // The container has a header and a directory as well.
  EXPECT_LT(reported.back(), encoded->pieces[0].stored->size());
  EXPECT_GT(reported.back() + 1000, encoded->pieces[0].stored->size());
  options.part_written = [&](uint64_t bytes) {
    return bytes > reported[0] ? unsupported("too large") : Status();
  };
  encoded = encode(parts, codings.codings, options);
  EXPECT_EQ(encoded.status().message(), "too large");
}

TEST(EncodeParts, WithoutVerificationTheBytesAreTheSame) {
  const Mesh mesh = reduced(make_sheet(60, 50));
  const Coded codings = default_codings(mesh, false);
  MeshInParts parts(mesh, slabs(mesh, 3));
  auto verified = must(encode(parts, codings.codings, {}));
  auto unverified = must(encode(parts, codings.codings, {.streams = {.verify = false}}));
  EXPECT_EQ(read_all(*verified.pieces[0].stored), read_all(*unverified.pieces[0].stored));
}

}  // namespace
}  // namespace psplit
