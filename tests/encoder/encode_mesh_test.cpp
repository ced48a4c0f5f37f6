// The codec end to end, without glTF: every mesh of the catalogue comes back, whatever the options.
#include "encoder/encode_mesh.h"

#include <cfloat>
#include <cmath>
#include <cstring>
#include <random>
#include <stdexcept>

#include "encoder/coding/quantization.h"
#include "encoder/fields/expand_container.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "tests/support/choose_codings.h"
#include "tests/support/compare_meshes.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/default_codings.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// With keep_duplicates nothing at all may change but the order and the grid.
void expect_same_mesh_back(const NamedMesh& named, const StreamOptions& options, bool lossless) {
  const Mesh& mesh = named.mesh;
  const Coded coded = default_codings(mesh, lossless);
  const ThreadPool pool(2);
  const EncodedMesh encoded = must(encode_mesh(mesh, coded.codings, options, pool));
  const Mesh decoded = must(decode_container(draco_backend(), encoded.pieces[0].bytes, encoded.requests, pool));
  EXPECT_EQ(compare_meshes(mesh, decoded, coded.tolerances), "");
}

TEST(EncodeMesh, EveryMeshComesBackQuantized) {
  StreamOptions options{.keep_duplicates = true};
  for (const NamedMesh& named : all_meshes())
    for (uint32_t patch_count : {1u, 2u, 7u, 1000000u}) {
      SCOPED_TRACE(named.name + " in " + std::to_string(patch_count) + " patches");
      // A patch a face is a test of its own; thousands of streams say nothing more.
      if (patch_count > 7 && named.mesh.faces.size() > 400) continue;
      options.patch_count = patch_count;
      expect_same_mesh_back(named, options, false);
    }
  options.patch_count = 7;
  for (const NamedMesh& named : large_grids()) expect_same_mesh_back(named, options, false);
}

TEST(EncodeMesh, EveryMeshComesBackLosslessAtEverySpeed) {
  StreamOptions options{.patch_count = 3, .keep_duplicates = true};
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.size() > 20000) continue;
    for (int speed : {0, 2, 4, 6, 8, 10}) {
      SCOPED_TRACE(named.name + " at speed " + std::to_string(speed));
      options.encode_speed = speed;
      expect_same_mesh_back(named, options, true);
      expect_same_mesh_back(named, options, false);
    }
  }
}

// libdraco and the encoder of our own write the same container, with a residue or without.
TEST(EncodeMesh, BothEncodersWriteTheSameBytes) {
  StreamOptions options;
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.size() > 20000) continue;
    const std::vector<AttributeCoding> codings = default_codings(named.mesh, false).codings;
    for (const uint32_t patch_count : {1u, 5u, 40u})
      for (const int speed : {0, 5, 10}) {
        SCOPED_TRACE(named.name + " in " + std::to_string(patch_count) + " patches");
        options.patch_count = patch_count;
        options.encode_speed = speed;
        options.by_libdraco = false;
        const EncodedMesh ours = must(encode_mesh(named.mesh, codings, options, ThreadPool(2)));
        options.by_libdraco = true;
        const EncodedMesh reference = must(encode_mesh(named.mesh, codings, options, ThreadPool(2)));
        EXPECT_EQ(ours.pieces[0].bytes, reference.pieces[0].bytes);
        EXPECT_EQ(ours.pieces[0].source_point, reference.pieces[0].source_point);
      }
  }
}

// The squared distance from a point to the nearest one that the faces of a patch use, and twice their area.
std::pair<double, double> distance_and_area(const PatchContainer& container, const Mesh& decoded,
                                            uint32_t patch, const std::array<double, 3>& from) {
  const auto* const positions = reinterpret_cast<const float*>(decoded.find("POSITION")->values.data());
  double nearest = HUGE_VAL, area = 0;
  for (uint32_t face = container.face_base[patch]; face < container.face_base[patch + 1]; ++face) {
    double to[3][3] = {};
    for (size_t corner = 0; corner < 3; ++corner) {
      double squared = 0;
      for (size_t axis = 0; axis < 3; ++axis) {
        to[corner][axis] = positions[3 * decoded.faces[face][corner] + axis] - from[axis];
        squared += to[corner][axis] * to[corner][axis];
      }
      nearest = std::min(nearest, squared);
    }
    double squared_area = 0;
    for (size_t i = 0; i < 3; ++i) {
      const size_t j = (i + 1) % 3, k = (i + 2) % 3;
      const double normal =
          (to[1][j] - to[0][j]) * (to[2][k] - to[0][k]) - (to[1][k] - to[0][k]) * (to[2][j] - to[0][j]);
      squared_area += normal * normal;
    }
    area += std::sqrt(squared_area);
  }
  return {nearest, area};
}

// Each encoder writes the grid so that each decoder gives the numbers.
TEST(EncodeMesh, WholeNumbersComeBackFromEveryCodec) {
  Mesh mesh = make_grid(40, 30);
  std::mt19937 random(3);
  for (const int bits : {1, 11, 17, 23, 24}) {
    std::vector<float> ids = {0, std::ldexp(1.0f, bits) - 1};
    while (ids.size() < mesh.point_count) ids.push_back(static_cast<float>(random() >> (32 - bits)));
    mesh.attributes.resize(1);
    mesh.attributes.push_back(float_attribute("_ID", 1, ids));
    const auto codings = choose_codings(mesh, {});
    ASSERT_TRUE(codings[1].exact);
    std::vector<uint8_t> bytes;
    for (const bool by_libdraco : {false, true}) {
      StreamOptions options{.patch_count = 3, .by_libdraco = by_libdraco};
      const EncodedMesh encoded = must(encode_mesh(mesh, codings, options, ThreadPool(1)));
      for (const DecodeBackend& backend : {cpu_backend(), draco_backend()}) {
        const Mesh decoded =
            must(decode_container(backend, encoded.pieces[0].bytes, encoded.requests, ThreadPool(1)));
        const auto back = values_of<float>(*decoded.find("_ID"));
        for (size_t i = 0; i < back.size(); ++i) ASSERT_EQ(back[i], ids[encoded.pieces[0].source_point[i]]);
      }
      if (by_libdraco) {
        EXPECT_EQ(encoded.pieces[0].bytes, bytes);
      }
      bytes = encoded.pieces[0].bytes;
    }
  }
}

TEST(EncodeMesh, PatchesAreInTheOrderThatIsAskedFor) {
  const ThreadPool pool(2);
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.size() < 400 || named.mesh.faces.size() > 20000) continue;
    SCOPED_TRACE(named.name);
    const Coded coded = default_codings(named.mesh, true);  // so that the measured order is the one asked for
    StreamOptions options{.patch_count = 9, .keep_duplicates = true};
    const PatchOrder near{PatchOrder::By::kNear, {0.25, -0.5, 1}}, size{PatchOrder::By::kSize, {}};
    for (const PatchOrder& order : {PatchOrder(), near, size}) {
      options.order = order;
      const EncodedMesh encoded = must(encode_mesh(named.mesh, coded.codings, options, pool));
      const PatchContainer container = must(open_container(encoded.pieces[0].bytes));
      double last_distance = 0, last_area = HUGE_VAL;
      for (uint32_t i = 0; i < container.patch_count(); ++i) {
        const auto [distance, area] = distance_and_area(container, encoded.pieces[0].decoded, i, near.point);
        EXPECT_TRUE(order.by != PatchOrder::By::kNear || distance >= last_distance);
        EXPECT_TRUE(order.by != PatchOrder::By::kSize || area <= last_area * (1 + 1e-9));
        last_distance = distance;
        last_area = area;
      }
      expect_same_mesh_back(named, options, false);
    }
  }
}

TEST(EncodeMesh, BoxesHaveWhatPatchesHave) {
  const ThreadPool pool(2);
  size_t count = 0;
  for (const NamedMesh& named : all_meshes())
    for (const bool condense : {false, true}) {
      SCOPED_TRACE(named.name);
      const Coded coded = default_codings(named.mesh, false);
      StreamOptions options{.patch_count = 5, .condense = condense};
      const EncodedMesh without = must(encode_mesh(named.mesh, coded.codings, options, pool));
      options.boxes = true;
      const EncodedMesh encoded = must(encode_mesh(named.mesh, coded.codings, options, pool));
      const PatchContainer container = must(open_container(encoded.pieces[0].bytes));
      EXPECT_EQ(encoded.pieces[0].entries, without.pieces[0].entries);
      EXPECT_EQ(encoded.pieces[0].head_bytes, container.head_bytes);
      const std::vector<PatchBox> boxes = must(patch_boxes(container));
      if (boxes.empty()) {
        EXPECT_EQ(encoded.pieces[0].bytes, without.pieces[0].bytes);
        continue;
      }
      ++count;
      EXPECT_LE(encoded.pieces[0].bytes.size(), without.pieces[0].bytes.size() + 27 + 6 * boxes.size());
      const auto* const positions =
          reinterpret_cast<const float*>(encoded.pieces[0].decoded.find("POSITION")->values.data());
      for (uint32_t i = 0; i < boxes.size(); ++i)
        for (uint32_t face = container.face_base[i]; face < container.face_base[i + 1]; ++face)
          for (const uint32_t point : encoded.pieces[0].decoded.faces[face])
            for (size_t axis = 0; axis < 3; ++axis) {
              ASSERT_LE(boxes[i].low[axis], positions[3 * point + axis]);
              ASSERT_GE(boxes[i].high[axis], positions[3 * point + axis]);
            }
      const auto bytes_of = [](std::span<const uint8_t> section) {
        return std::vector<uint8_t>(section.begin(), section.end());
      };
      if (container.condensed_count() == 0) continue;
      const std::vector<uint8_t> expanded = must(expand_container(container, pool));
      EXPECT_EQ(bytes_of(boxes_section(must(open_container(expanded)))), bytes_of(boxes_section(container)));
    }
  EXPECT_GT(count, 10u);
}

TEST(EncodeMesh, BytesDoNotDependOnThreads) {
  for (const NamedMesh& named : all_meshes()) {
    SCOPED_TRACE(named.name);
    const Coded coded = default_codings(named.mesh, false);
    const StreamOptions options{
        .patch_count = 5, .condense = named.mesh.faces.size() % 2 == 0, .verify = false};
    const auto one = must(encode_mesh(named.mesh, coded.codings, options, ThreadPool(1)));
    for (int threads : {2, 7}) {
      const auto many = must(encode_mesh(named.mesh, coded.codings, options, ThreadPool(threads)));
      EXPECT_EQ(one.pieces[0].bytes, many.pieces[0].bytes) << threads << " threads";
    }
  }
}

Mesh two_triangles() { return make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {{0, 1, 2}, {2, 1, 3}}); }

TEST(EncodeMesh, MergesDuplicatesAndCountsThem) {
  Mesh mesh = two_triangles();
  // The second triangle gets points of its own at the same positions.
  append_points(mesh, 1, 3);
  mesh.faces[1] = {5, 4, 3};
  const Coded coded = default_codings(mesh, true);
  const auto merged = must(encode_mesh(mesh, coded.codings, {}, ThreadPool(1)));
  EXPECT_EQ(merged.statistics.merged_points, 2u);
  EXPECT_EQ(open_container(merged.pieces[0].bytes)->point_count(), 4u);
  const auto kept = must(encode_mesh(mesh, coded.codings, {.keep_duplicates = true}, ThreadPool(1)));
  EXPECT_EQ(kept.statistics.merged_points, 0u);
  EXPECT_EQ(open_container(kept.pieces[0].bytes)->point_count(), 6u);
}

TEST(EncodeMesh, LetsTheInputBeFreedOnceIfItIsNotTheMeshItself) {
  const ThreadPool pool(2);
  Mesh changed = make_grid(20, 20);
  changed.faces.push_back({7, 7, 8});
  for (const bool drops : {true, false})
    for (const bool by_bytes : {false, true}) {
      SCOPED_TRACE(std::string(drops ? "changed" : "as it was") + (by_bytes ? ", by bytes" : ""));
      Mesh mesh = drops ? changed : make_grid(20, 20);
      const std::vector<AttributeCoding> codings = default_codings(mesh, false).codings;
      StreamOptions options{.patch_count = 3, .drop_degenerate = true};
      options.choose_by_bytes = options.condense_smallest = by_bytes;
      const EncodedMesh expected = must(encode_mesh(mesh, codings, options, pool));
      size_t count = 0;
      options.free_input = [&] {
        ++count;
        mesh.faces = Array<std::array<uint32_t, 3>>();
        for (Attribute& attribute : mesh.attributes) attribute.values = Array<std::byte>();
      };
      EXPECT_EQ(must(encode_mesh(mesh, codings, options, pool)).pieces[0].bytes, expected.pieces[0].bytes);
      EXPECT_EQ(count, drops ? 1u : 0u);
    }
}

TEST(EncodeMesh, DropsDegeneratesOnlyWhenAsked) {
  Mesh mesh = two_triangles();
  mesh.faces.push_back({1, 1, 2});
  mesh.faces[1] = {0, 2, 1};  // leaves point 3 unused
  const Coded coded = default_codings(mesh, true);
  const auto kept = must(encode_mesh(mesh, coded.codings, {}, ThreadPool(1)));
  EXPECT_EQ(kept.statistics.residue_faces, 1u);
  EXPECT_EQ(kept.statistics.residue_points, 1u);
  EXPECT_EQ(open_container(kept.pieces[0].bytes)->face_count(), 3u);
  EXPECT_EQ(open_container(kept.pieces[0].bytes)->point_count(), 4u);
  const StreamOptions drop{.drop_degenerate = true, .drop_unused = true};
  const auto dropped = must(encode_mesh(mesh, coded.codings, drop, ThreadPool(1)));
  EXPECT_EQ(dropped.statistics.dropped_faces, 1u);
  EXPECT_EQ(dropped.statistics.dropped_points, 1u);
  EXPECT_EQ(open_container(dropped.pieces[0].bytes)->point_count(), 3u);
  EXPECT_FALSE(open_container(dropped.pieces[0].bytes)->has_residue);
}

// What the residue copies is stored where it is owned: a degenerate face costs its indices and little else.
TEST(EncodeMesh, DegenerateFacesCostTheirIndicesOnly) {
  Mesh mesh = make_grid(60, 60);
  // Values that no prediction shortens.
  std::vector<float> temperatures(mesh.point_count);
  std::mt19937 random(1);
  for (float& temperature : temperatures) temperature = static_cast<float>(random() % 10007);
  mesh.attributes.push_back(make_attribute("_TEMPERATURE", ComponentType::kFloat32, 1, false, temperatures));
  StreamOptions options{.patch_count = 4, .drop_degenerate = true};
  const Coded coded = default_codings(mesh, false);
  const auto without = encode_mesh(mesh, coded.codings, options, ThreadPool(2));
  constexpr uint32_t kFaces = 3000;
  for (uint32_t i = 0; i < kFaces; ++i) mesh.faces.push_back({i, i, i + 1});
  options.drop_degenerate = false;
  const auto with = encode_mesh(mesh, coded.codings, options, ThreadPool(2));
  ASSERT_TRUE(without.ok() && with.ok()) << with.status().to_string();
  EXPECT_EQ(with->statistics.residue_faces, kFaces);
  EXPECT_EQ(with->statistics.residue_points, 0u);
  const PatchContainer container = must(open_container(with->pieces[0].bytes));
  EXPECT_LT(container.streams.back().size(), kFaces * 6 + 300);
  // Every decoder takes the owner's values.
  const ThreadPool pool(2);
  for (const DecodeBackend& backend : {draco_backend(), cpu_backend()}) {
    const Mesh decoded = must(decode_container(backend, with->pieces[0].bytes, with->requests, pool));
    EXPECT_EQ(compare_meshes(mesh, decoded, coded.tolerances), "");
  }
  // A stream that is to mean something on its own has the values.
  options.alone = Alone::kAll;
  const auto alone = must(encode_mesh(mesh, coded.codings, options, ThreadPool(2)));
  EXPECT_GT(alone.pieces.back().bytes.size(), container.streams.back().size() + 2 * kFaces);
}

TEST(EncodeMesh, RefusesBadInput) {
  const ThreadPool pool(1);
  Mesh mesh = two_triangles();
  mesh.faces[1][2] = 4;
  const std::vector<AttributeCoding> codings(1);
  EXPECT_EQ(encode_mesh(mesh, codings, {}, pool).status().code(), StatusCode::kInvalidInput);
  mesh = two_triangles();
  mesh.attributes[0].semantic = "NORMAL";
  EXPECT_EQ(encode_mesh(mesh, codings, {}, pool).status().code(), StatusCode::kInvalidInput);
  mesh = two_triangles();
  mesh.attributes[0].values.pop_back();
  EXPECT_EQ(encode_mesh(mesh, codings, {}, pool).status().code(), StatusCode::kInvalidInput);
  mesh = two_triangles();
  mesh.faces.clear();
  EXPECT_EQ(encode_mesh(mesh, codings, {}, pool).status().code(), StatusCode::kInvalidInput);
  // Grids hold no value that is not finite; as it is, it can be stored.
  for (const float wrong : {NAN, INFINITY, -INFINITY}) {
    mesh = two_triangles();
    const std::vector<AttributeCoding> grid = default_codings(mesh, false).codings;
    std::memcpy(mesh.attributes[0].values.data(), &wrong, sizeof wrong);
    const Status refused = encode_mesh(mesh, grid, {}, pool).status();
    EXPECT_EQ(refused.code(), StatusCode::kInvalidInput);
    EXPECT_TRUE(contains(refused.to_string(), "POSITION")) << refused.to_string();
    EXPECT_TRUE(encode_mesh(mesh, codings, {}, pool).ok());
  }
  // The difference of these two is no float.
  mesh = two_triangles();
  const std::vector<AttributeCoding> grid = default_codings(mesh, false).codings;
  const float far_apart[] = {-FLT_MAX, 0, 0, FLT_MAX};
  std::memcpy(mesh.attributes[0].values.data(), far_apart, sizeof far_apart);
  EXPECT_EQ(encode_mesh(mesh, grid, {}, pool).status().code(), StatusCode::kInvalidInput);
}

// libdraco's encoder takes gigabytes for these.
TEST(EncodeMesh, TheWidestGridHoldsSymbolsOfEverySize) {
  Mesh mesh = make_grid(30, 30);
  std::mt19937 random(1);
  for (size_t i = 0; i < size_t{3} * mesh.point_count; ++i) {
    const float value = i < 3 ? 1.0f : std::uniform_real_distribution(-1.0f, 1.0f)(random);
    std::memcpy(mesh.attributes[0].values.data() + i * sizeof value, &value, sizeof value);
  }
  const std::vector<AttributeCoding> codings{must(fit_grid(mesh.attributes[0], 30))};
  for (int speed = 0; speed <= 10; ++speed)
    must(encode_mesh(mesh, codings, {.patch_count = 2, .encode_speed = speed}, ThreadPool(1)));
}

TEST(DecodeContainer, EveryMutantIsRefusedOrDecodes) {
  const Mesh mesh = two_triangles();
  const StreamOptions options{.patch_count = 2};
  const auto encoded = must(encode_mesh(mesh, default_codings(mesh, false).codings, options, ThreadPool(1)));
  const std::vector<AttributeRequest> requests = encoded.requests;
  const PatchContainer original = *open_container(encoded.pieces[0].bytes);
  // The streams themselves are libdraco's to defend; directory and stitch map are ours.
  const size_t ours = original.header_bytes + original.stitch_bytes();
  for (size_t at = 0; at < ours; ++at)
    for (int value = 0; value < 256; ++value) {
      std::vector<uint8_t> mutant = encoded.pieces[0].bytes;
      mutant[at] = static_cast<uint8_t>(value);
      const Expected<Mesh> decoded = decode_container(draco_backend(), mutant, requests, ThreadPool(1));
      if (!decoded.ok()) continue;
      EXPECT_EQ(decoded->faces.size(), 2u);
      for (const auto& face : decoded->faces)
        for (uint32_t point : face) EXPECT_LT(point, decoded->point_count);
    }
}

TEST(EncodeMesh, TakesAPartitionOfTheCallers) {
  const ThreadPool pool(2);
  const Mesh mesh = make_grid(8, 4);
  const std::vector<AttributeCoding> codings(1);
  std::vector<uint32_t> patch_of_face;
  for (size_t i = 0; i < mesh.faces.size(); ++i) patch_of_face.push_back(i < 24 ? 4 : 2);
  StreamOptions options{.patch_of_face = patch_of_face};
  const auto encoded = must(encode_mesh(mesh, codings, options, pool));
  const auto container = must(open_container(encoded.pieces[0].bytes));
  ASSERT_EQ(container.patch_count(), 2u);
  EXPECT_EQ(container.entries[0].face_count, 40u);
  EXPECT_EQ(container.entries[1].face_count, 24u);
  patch_of_face.pop_back();
  options.patch_of_face = patch_of_face;
  EXPECT_EQ(encode_mesh(mesh, codings, options, pool).status().code(), StatusCode::kUsage);
}

TEST(EncodeMesh, ReportsWhatTheCallersExecutorAndCallbackDo) {
  const Mesh& mesh = procedural_meshes().front().mesh;
  const ThreadPool dropping(4, [](size_t count, const std::function<void(size_t)>& body) {
    for (size_t i = 0; i + 1 < count; ++i) body(i);
  });
  EncodeOptions options;
  options.patches.count = 3;
  const Status dropped = encode(mesh, options, dropping).status();
  EXPECT_EQ(dropped.code(), StatusCode::kRuntimeFailure);
  EXPECT_NE(dropped.message().find("the executor ran"), std::string::npos) << dropped.message();
  const ThreadPool pool(2);
  const auto throws = [](size_t, size_t) { throw std::runtime_error("a callback"); };
  EXPECT_EQ(encode(mesh, options, pool, {.progress = throws}).status().message(), "a callback");
  EXPECT_TRUE(encode(mesh, options, pool).ok());
}

}  // namespace
}  // namespace psplit
