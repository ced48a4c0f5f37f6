// Each prediction scheme on a mesh made by hand, where the predicted values can be checked by hand.
#include "src/core/prediction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <tuple>

#include "src/core/seams.h"
#include "tests/src/core/clers_mesh.h"
#include "tests/src/core/rans_encoder.h"
#include "tests/src/core/small_mesh.h"

namespace psplit::core {
namespace {

using Values = std::vector<int32_t>;

constexpr WrapRange kWide{-1000, 1000, 2001};

// Two triangles that share the edge from 1 to 2.
//
//     2---3
//     | \ |
//     0---1
const std::vector<std::array<uint16_t, 3>> kSquare{{0, 1, 2}, {3, 2, 1}};

// Corrections of `components` components: component k of a value is greater by k than component 0.
Values repeated(const Values& values, uint32_t components) {
  Values out;
  for (const int32_t value : values)
    for (uint32_t k = 0; k < components; ++k) out.push_back(value + static_cast<int32_t>(k));
  return out;
}

template <uint32_t kComponents>
void expect_parallelogram(uint32_t components = kComponents) {
  SmallMesh mesh(kSquare);
  // Values 0 to 2 are predicted from the one before, and value 3 from the parallelogram.
  const auto on = mesh.values<kComponents>(repeated({10, 5, 100, -7}, components), components);
  for (ParallelogramSteps<uint16_t, kComponents> steps({on, kWide}); steps.steps_left() > 0;) steps.step();
  for (uint32_t v = 0; v < 4; ++v) {
    Values expected;
    for (int32_t k = 0; k < static_cast<int32_t>(components); ++k) {
      const int32_t zero = 10 + k, one = zero + 5 + k, two = one + 100 + k, three = one + two - zero - 7 + k;
      expected.push_back(std::array{zero, one, two, three}[v]);
    }
    EXPECT_EQ(mesh.value(v, components), expected) << "vertex " << v << " of " << components << " components";
  }
}

TEST(Prediction, AValueCompletesTheParallelogramAcrossItsEdge) {
  expect_parallelogram<1>();
  expect_parallelogram<2>();
  expect_parallelogram<3>();
  expect_parallelogram<4>();
  expect_parallelogram<0>(5);
}

// Four components in a register, against one component at a time in memory.
TEST(Prediction, DifferencesAreTheSameWhateverTheirCorrections) {
  std::mt19937 random(7);
  constexpr int32_t kMost = 0x7fffffff;
  const auto expect_same = [&](const WrapRange& range, int32_t low, int32_t high) {
    SmallMesh in_register(kSquare), in_memory(kSquare);
    Values corrections;
    std::uniform_int_distribution<int32_t> any(low, high);
    while (corrections.size() < 16) corrections.push_back(any(random));
    predict_by_difference(in_register.values<4>(corrections, 4), range);
    predict_by_difference(in_memory.values<0>(corrections, 4), range);
    for (uint32_t v = 0; v < 4; ++v) EXPECT_EQ(in_register.value(v, 4), in_memory.value(v, 4));
  };
  for (int round = 0; round < 100; ++round) {
    expect_same({10, 30, 21}, -20, 20);  // as an encoder writes them; zero is not in the range
    expect_same({10, 30, 21}, -22, 22);  // some are beyond it
    expect_same(kWide, -kMost, kMost);
    expect_same({-kMost / 2, kMost / 2, kMost}, -kMost + 1, kMost - 1);  // sums wrap around
  }
}

TEST(Prediction, AParallelogramIsKnownOnceItsThreeValuesAre) {
  SmallMesh mesh(kSquare);
  const auto on = mesh.values<1>({0, 0, 0, 0});
  Parallelogram found{};
  for (uint32_t i = 0; i < 3; ++i) EXPECT_FALSE(find_parallelogram(on, i, mesh.met[3], found));
  EXPECT_TRUE(find_parallelogram(on, 3, mesh.met[3], found));
  EXPECT_EQ(found.far, on.of_vertex(0));
  EXPECT_FALSE(find_parallelogram(on, 3, uint16_t{1}, found));  // no face is across the edge from 0 to 2
}

// Vertex 5 has two faces, and a parallelogram across each.
//
//     0---3---1
//      \ /|\ /
//       2 | 4
//        \|/
//         5
const std::vector<std::array<uint16_t, 3>> kFan{{0, 3, 2}, {1, 4, 3}, {5, 2, 3}, {5, 3, 4}};
constexpr uint16_t kLeftFace = 8, kRightFace = 12;  // the corners at vertex 5
// The values of vertices 0 to 4, none of which has a parallelogram that is complete before it.
constexpr int32_t kFanValues[] = {1000, 2000, 32, 64, 3};
constexpr int32_t kLeft = 32 + 64 - 1000, kRight = 64 + 3 - 2000;

// The predicted value of vertex 5, if the traversal met it at a corner.
template <uint32_t kComponents, typename Predict>
int32_t predicted_in_fan(uint16_t met, Predict predict) {
  SmallMesh mesh(kFan);
  mesh.met[5] = met;
  Values corrections;
  for (uint32_t v = 0; v < 6; ++v)
    for (uint32_t k = 0; k < kComponents; ++k)
      corrections.push_back(v == 5 ? 0 : kFanValues[v] - (v > 0 ? kFanValues[v - 1] : 0));
  predict(WrappedValues<uint16_t, kComponents>(mesh.values<kComponents>(corrections), {-5000, 5000, 10001}));
  for (uint32_t v = 0; v < 5; ++v)
    EXPECT_EQ(mesh.value(v, kComponents), Values(kComponents, kFanValues[v])) << v;
  const Values value = mesh.value(5, kComponents);
  EXPECT_EQ(value, Values(kComponents, value[0]));
  return value[0];
}

TEST(Prediction, SeveralParallelogramsPredictTheirMean) {
  const auto predict = [](const auto& on) { predict_by_multi_parallelogram(on); };
  EXPECT_EQ(predicted_in_fan<1>(kRightFace, predict), (kLeft + kRight) / 2);
  EXPECT_EQ(predicted_in_fan<3>(kRightFace, predict), (kLeft + kRight) / 2);
  // Clockwise from the left face there are no more.
  EXPECT_EQ(predicted_in_fan<1>(kLeftFace, predict), kLeft);
  EXPECT_EQ(predicted_in_fan<3>(kLeftFace, predict), kLeft);
}

// As above, with flags for vertex 5's two parallelograms: a set flag excludes one. Nothing if there is a fault.
template <uint32_t kComponents>
std::optional<int32_t> predicted_with_creases(uint16_t met, std::vector<uint8_t> flags) {
  std::vector<uint8_t> memory(1 << 20);
  Fault fault = Fault::kNone;
  const int32_t predicted = predicted_in_fan<kComponents>(met, [&](const auto& on) {
    Arena arena(memory.data(), memory.size());
    View<uint8_t> creases[kMaxParallelograms];
    creases[1] = {flags.data(), flags.size()};
    ParallelogramFinder<uint16_t> parallelograms;
    ASSERT_EQ(parallelograms.find(on.table, on.sequence, arena), Fault::kNone);
    fault = predict_by_constrained_multi_parallelogram(on, parallelograms, creases);
  });
  return fault == Fault::kNone ? std::optional(predicted) : std::nullopt;
}

template <uint32_t kComponents>
void expect_creases_exclude() {
  const auto predicted = predicted_with_creases<kComponents>;
  EXPECT_EQ(predicted(kLeftFace, {0, 0}), (kLeft + kRight) / 2);
  // The first flag is that of the face at which the traversal met the vertex, and the second that of the other
  // face.
  EXPECT_EQ(predicted(kLeftFace, {1, 0}), kRight);
  EXPECT_EQ(predicted(kLeftFace, {0, 1}), kLeft);
  EXPECT_EQ(predicted(kRightFace, {1, 0}), kLeft);
  EXPECT_EQ(predicted(kRightFace, {0, 1}), kRight);
  EXPECT_EQ(predicted(kRightFace, {1, 1}), kFanValues[4]);  // the value before
}

TEST(Prediction, CreasesExcludeParallelograms) {
  expect_creases_exclude<1>();
  expect_creases_exclude<2>();
  expect_creases_exclude<3>();
  expect_creases_exclude<4>();
}

TEST(Prediction, EveryParallelogramNeedsACreaseFlag) {
  SmallMesh mesh(kFan);
  const WrappedValues<uint16_t, 1> on(mesh.values<1>({0, 0, 0, 0, 0, 0}), kWide);
  std::vector<uint8_t> memory(1 << 20);
  Arena arena(memory.data(), memory.size());
  uint8_t flag = 0;
  View<uint8_t> creases[kMaxParallelograms];
  creases[1] = {&flag, 1};
  ParallelogramFinder<uint16_t> parallelograms;
  ASSERT_EQ(parallelograms.find(on.table, on.sequence, arena), Fault::kNone);
  EXPECT_EQ(predict_by_constrained_multi_parallelogram(on, parallelograms, creases), Fault::kPrediction);
}

// A random mesh of some hundred faces, or null: most strings of letters are none.
std::unique_ptr<ClersMesh> random_mesh(std::mt19937& random) {
  static constexpr char kLetters[] = "CCCCCCCCRRRRRRRLLLES";
  std::string letters = "E";
  const size_t length = 20 + random() % 150;
  while (letters.size() < length) letters += kLetters[random() % (sizeof kLetters - 1)];
  auto mesh = std::make_unique<ClersMesh>(letters, std::vector<SplitEvent>(), 0, /*vertex_limit=*/300);
  if (mesh->fault != Fault::kNone) return nullptr;
  mesh->fill_holes();
  return mesh;
}

// The values' order of a traversal, or any order in which each value is met at any corner of its vertex.
Sequence<uint16_t> random_sequence(const AttributeTable<uint16_t>& mesh, bool is_traversal,
                                   std::mt19937& random, Arena& arena) {
  Sequence<uint16_t> out;
  if (!out.allocate(mesh.vertex_count, arena)) __builtin_trap();
  if (is_traversal) {
    EXPECT_EQ(traverse(mesh, random() % 2 == 0, arena, out), Fault::kNone);
    return out;
  }
  std::vector<uint16_t> order(mesh.vertex_count);
  for (uint16_t v = 0; v < order.size(); ++v) order[v] = v;
  std::shuffle(order.begin(), order.end(), random);
  for (uint16_t i = 0; i < order.size(); ++i) out.rank[order[i]] = i;
  for (uint16_t corner = 0; corner < mesh.table.vertex.size(); ++corner) {
    uint16_t& met = out.corner[out.rank[mesh.table.vertex[corner]]];
    if (corner % 4 != 3 && (met >= mesh.table.vertex.size() || random() % 3 == 0 ||
                            mesh.table.vertex[met] != mesh.table.vertex[corner]))
      met = corner;
  }
  return out;
}

// The mesh's own table, or the table of an attribute with a seam at one of `one_of` inner edges, or so.
AttributeTable<uint16_t> random_table(const Connectivity<uint16_t>& mesh, uint32_t one_of, std::mt19937& random,
                                      Arena& arena) {
  AttributeTable<uint16_t> out{mesh.table, mesh.closed, mesh.vertex_count, false};
  if (one_of == 0) return out;
  View<uint16_t> edges, around, value_counts;
  View<uint8_t> bits, changes;
  View<bool> on_seam;
  if (!arena.take(edges, mesh.table.vertex.size()) || !arena.take(bits, mesh.table.vertex.size()) ||
      !arena.take(around, mesh.table.vertex.size()) || !arena.take(changes, mesh.table.vertex.size()) ||
      !arena.take(value_counts, mesh.vertex_count) || !arena.take(on_seam, mesh.vertex_count))
    __builtin_trap();
  edges = edges.first(list_inner_edges(mesh.table, edges));
  bits = bits.first(edges.size());
  for (size_t i = 0; i < bits.size(); ++i) bits[i] = random() % one_of == 0 ? 1 : 0;
  fill(on_seam, false);
  EXPECT_EQ(cut_seams(mesh, edges, View<const uint8_t>(bits), arena, out, on_seam), Fault::kNone);
  AttributeTable<uint16_t>* const one = &out;
  if (out.has_seams)
    VertexSplit<uint16_t>(mesh, around, changes, value_counts).split(&one, 1, View<const bool>(on_seam), {});
  return out;
}

TEST(Prediction, ParallelogramsFromFacesAreThoseAroundTheVertex) {
  std::mt19937 random(51);
  std::array<uint32_t, kMaxParallelograms + 1> seen{};
  uint32_t seamed = 0;
  for (uint32_t meshes = 0; meshes < 300;) {
    const std::unique_ptr<ClersMesh> decoded = random_mesh(random);
    if (decoded == nullptr) continue;
    ++meshes;
    const Connectivity<uint16_t>& mesh = decoded->mesh;
    std::vector<uint8_t> memory(1 << 20);
    Arena arena(memory.data(), memory.size());
    constexpr uint32_t kSeams[] = {0, 2, 10};
    const AttributeTable<uint16_t> table = random_table(mesh, kSeams[meshes % 3], random, arena);
    seamed += table.has_seams ? 1 : 0;
    PredictedValues<uint16_t, 1> on;
    on.table = table.table;
    on.sequence = random_sequence(table, meshes % 2 == 0, random, arena);
    ParallelogramFinder<uint16_t> finder;
    ASSERT_EQ(finder.find(on.table, on.sequence, arena), Fault::kNone);
    for (uint32_t i = 0; i < on.sequence.count; ++i) {
      const FoundParallelograms expected = find_parallelograms(on.table, on.sequence, i);
      ASSERT_EQ(finder.count(i), expected.count);
      for (uint32_t j = 0; j < expected.count; ++j) ASSERT_EQ(finder.across(i, j), expected.across[j]);
      ++seen[expected.count];
    }
  }
  for (const uint32_t count : seen) EXPECT_GT(count, 100u);
  EXPECT_GT(seamed, 100u);
}

// The square in space, in four places a vertex.
constexpr int32_t kPositions[16] = {0, 0, 0, 0, 10, 0, 0, 0, 0, 10, 0, 0, 10, 10, 0, 0};

Positions<uint16_t> positions_of(SmallMesh& mesh, View<const int32_t> values = {kPositions, 16}) {
  return {mesh.table(), mesh.table(), mesh.sequence(), values, false};
}

TEST(Prediction, TextureCoordinatesHaveTheShapeOfTheTriangleInSpace) {
  SmallMesh mesh(kSquare);
  const auto positions = positions_of(mesh);
  // The first edge makes the texture twice as large as the square, and turns it by a quarter.
  const Values corrections{3, 3, 0, 20, 0, 0, 0, 0};
  const auto decode = [&](std::vector<uint8_t> orientations) {
    const WrappedValues<uint16_t, 2> on(mesh.values<2>(corrections), kWide);
    return TexCoordsPredictor<uint16_t>(on, positions, {orientations.data(), orientations.size()}).predict();
  };
  ASSERT_EQ(decode({0, 0}), Fault::kNone);
  EXPECT_EQ(mesh.value(1, 2), (Values{3, 23}));
  EXPECT_EQ(mesh.value(2, 2), (Values{-17, 3}));
  EXPECT_EQ(mesh.value(3, 2), (Values{-17, 23}));
  // The last orientation is that of the first triangle; each mirrors its tip.
  ASSERT_EQ(decode({0, 1}), Fault::kNone);
  EXPECT_EQ(mesh.value(2, 2), (Values{23, 3}));
  ASSERT_EQ(decode({1, 0}), Fault::kNone);
  EXPECT_EQ(mesh.value(3, 2), (Values{3, 3}));
  EXPECT_EQ(decode({0}), Fault::kPrediction);
}

TEST(Prediction, NormalsFollowFromTheFacesAroundAVertex) {
  SmallMesh mesh(kSquare);
  PredictionData data;
  data.transform = Transform::kOctahedronCanonicalized;
  data.grid = OctahedralGrid(4);
  const Bytes flips = encode_bits({false, true, false, false}, 128);
  ByteReader reader(flips.data(), flips.size());
  ASSERT_EQ(data.flips.start(reader), Fault::kNone);
  predict_from_geometry(SerialLanes(), mesh.values<2>(Values(8, 0)), positions_of(mesh), {}, data);
  const Vec2 up = data.grid.project({0, 0, 1}, false), down = data.grid.project({0, 0, 1}, true);
  for (uint32_t v = 0; v < 4; ++v) {
    const Vec2 expected = v == 1 ? down : up;
    EXPECT_EQ(mesh.value(v, 2), (Values{expected.s, expected.t})) << v;
  }
}

TEST(Prediction, ANormalIsCorrectedFromTheOneBefore) {
  SmallMesh mesh(kSquare);
  const OctahedralGrid grid(4);
  const Values corrections{1, 2, -3, 4, 0, 0, 7, -7};
  for (NormalSteps<uint16_t> steps(mesh.values<2>(corrections), grid, true); steps.steps_left() > 0;)
    steps.step();
  Vec2 last;
  for (uint32_t v = 0; v < 4; ++v) {
    last = grid.correct(last, {corrections[2 * v], corrections[2 * v + 1]}, true);
    EXPECT_EQ(mesh.value(v, 2), (Values{last.s, last.t})) << v;
  }
}

// Values in their own order, one for each pair of corrections.
struct NormalRun {
  explicit NormalRun(const Values& of) : corrections(of), values(of.size()) {
    for (size_t v = 0; v < values.size() / 2; ++v) identity.push_back(static_cast<uint16_t>(v));
    on.table.vertex = {identity.data(), identity.size()};
    on.sequence = {on.table.vertex, on.table.vertex, static_cast<uint32_t>(identity.size())};
    on.corrections = View<const int32_t>(corrections.data(), corrections.size());
    on.values = {values.data(), values.size()};
  }
  std::vector<uint16_t> identity;
  Values corrections, values;
  PredictedValues<uint16_t, 2> on;
};

// Each has a grid of its own, and they end one after the other.
TEST(Prediction, NormalsOfSeveralRunsAtOnceAreThoseOfEach) {
  std::mt19937 random(1);
  for (size_t count = 0; count < 8; ++count) {
    std::vector<std::unique_ptr<NormalRun>> runs;
    std::vector<NormalSteps<uint16_t>> steps(count);
    std::vector<NormalSteps<uint16_t>*> pointers;
    for (size_t n = 0; n < count; ++n) {
      const OctahedralGrid grid(static_cast<int>(4 + n));
      Values corrections(2 * (random() % 50));
      for (int32_t& value : corrections) value = static_cast<int32_t>(random() % grid.max_quantized());
      runs.push_back(std::make_unique<NormalRun>(corrections));
      steps[n] = {runs[n]->on, grid, n % 2 == 0};
      pointers.push_back(&steps[n]);
    }
    step_normals(pointers.data(), static_cast<uint32_t>(count));
    for (size_t n = 0; n < count; ++n) {
      NormalRun alone(runs[n]->corrections);
      correct_normals_by_difference(alone.on, OctahedralGrid(static_cast<int>(4 + n)), n % 2 == 0);
      EXPECT_EQ(runs[n]->values, alone.values) << n << " of " << count;
    }
  }
}

#if defined(PSPLIT_HAS_VECTORS)
// Short and long normals, those on axes, and none at all.
TEST(Prediction, NormalsFromSumsAreThoseOfEachSum) {
  std::mt19937_64 random(1);
  for (const int bits : {2, 8, 10, kMostExactBits})
    for (uint32_t count = 0; count < 200; count += 33) {
      PredictionData data;
      data.transform = bits % 4 == 0 ? Transform::kOctahedron : Transform::kOctahedronCanonicalized;
      data.grid = OctahedralGrid(bits);
      ASSERT_TRUE(is_exact(data.grid));
      const auto any = [&] {
        return static_cast<int64_t>(random()) >> (random() % 4 == 0 ? 63 : random() % 64);
      };
      std::vector<Vec3> sums(count);
      std::vector<uint8_t> flips(count);
      Values corrections(2 * size_t{count}), expected;
      for (int32_t& value : corrections) value = static_cast<int32_t>(random() % data.grid.max_quantized());
      for (uint32_t v = 0; v < count; ++v) {
        sums[v] = {any(), any(), any()};
        flips[v] = random() % 2;
        Vec3 normal = sums[v];
        shorten(normal);
        const Vec2 at = data.grid.correct(data.grid.project(normal, flips[v] != 0),
                                          {corrections[2 * v], corrections[2 * v + 1]},
                                          data.transform == Transform::kOctahedronCanonicalized);
        expected.insert(expected.end(), {at.s, at.t});
      }
      NormalRun run(corrections);
      EXPECT_TRUE(are_in_range(run.on, data.grid));
      data.flips_by_value = View<const uint8_t>(flips.data(), flips.size());
      predict_from_sums(run.on, View<const Vec3>(sums.data(), sums.size()), data);
      EXPECT_EQ(run.values, expected) << bits << " bits, " << count << " values";
    }
  EXPECT_FALSE(is_exact(OctahedralGrid(kMostExactBits + 1)));
}
#endif

// A range of positions of 2^32 is more than any encoder has. Sums then wrap around: builds with a sanitizer for
// overflows decode them, too.
TEST(Prediction, PositionsOfAnySizeGiveNormalsOnTheGrid) {
  constexpr int32_t kLeast = INT32_MIN;
  SmallMesh mesh({{0, 1, 2}, {0, 2, 3}});
  const int32_t positions[16] = {kLeast, kLeast, kLeast, 0, 1, 0, kLeast, 0, -1, 0, 0, 0, kLeast, kLeast, 0, 0};
  PredictionData data;
  data.transform = Transform::kOctahedron;
  data.grid = OctahedralGrid(10);
  const auto values = mesh.values<2>(Values(8, 0));
  const Positions<uint16_t> from = positions_of(mesh, {positions, 16});
  predict_from_geometry(SerialLanes(), values, from, {}, data);
  for (uint32_t v = 0; v < 4; ++v)
    for (const int32_t place : mesh.value(v, 2)) {
      EXPECT_GE(place, 0) << v;
      EXPECT_LE(place, 1022) << v;
    }
}

// The sums of all vertices at once are those around each vertex, also if they wrap around. A device has none.
TEST(Prediction, NormalsOfAllVerticesAreThoseOfEach) {
  std::mt19937 random(1);
  for (const uint32_t bits : {10u, 31u}) {
    SmallMesh mesh(kSquare);
    int32_t positions[16];
    for (int32_t& position : positions) position = static_cast<int32_t>(random() >> (32 - bits));
    const auto values = mesh.values<2>(Values(8, 0));
    const Positions<uint16_t> from = positions_of(mesh, {positions, 16});
    std::vector<uint8_t> memory(normal_sum_bytes(4));
    Arena arena(memory.data(), memory.size()), none;
    EXPECT_TRUE(sum_normals(values.table, from, 4, none).empty());
    const View<Vec3> sums = sum_normals(values.table, from, 4, arena);
    ASSERT_EQ(sums.size(), PSPLIT_MOVES_ROWS ? 0u : 4u);
    for (uint32_t v = 0; v < sums.size(); ++v) {
      const Vec3 expected = normal_at(values.table, from, values.sequence.corner[v]);
      EXPECT_EQ(std::tie(sums[v].x, sums[v].y, sums[v].z), std::tie(expected.x, expected.y, expected.z));
    }
  }
}

TEST(Prediction, PositionsOfAnySizeGiveTextureCoordinatesInTheRange) {
  constexpr int32_t kLeast = INT32_MIN, kMost = INT32_MAX;
  // Vertex 0 and 1 have the edge, vertex 2 is the tip.
  SmallMesh mesh({{2, 0, 1}});
  const int32_t positions[12] = {kMost,       kLeast, kLeast,    0,          -907160925, 787471729,
                                 -1439015196, 0,      147483647, 1636976142, -411013501, 0};
  std::vector<uint8_t> orientations{1};
  const WrappedValues<uint16_t, 2> on(mesh.values<2>(Values{0, 0, 1, 1, 0, 0}), WrapRange{0, 100, 101});
  const Fault fault =
      TexCoordsPredictor<uint16_t>(on, positions_of(mesh, {positions, 12}), {orientations.data(), 1}).predict();
  ASSERT_EQ(fault, Fault::kNone);
  for (const int32_t coordinate : mesh.value(2, 2)) {
    EXPECT_GE(coordinate, 0);
    EXPECT_LE(coordinate, 100);
  }
}

}  // namespace
}  // namespace psplit::core
