#include "tools/gltf_psplit/shapes/character.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "tools/gltf_psplit/shapes/attributes.h"
#include "tools/gltf_psplit/shapes/charts.h"
#include "tools/gltf_psplit/shapes/fields.h"
#include "tools/gltf_psplit/shapes/noise.h"
#include "tools/gltf_psplit/shapes/sized_surface.h"

namespace psplit {
namespace {

// What the character wears. Where two garments meet, normals have a seam.
enum class Garment : uint8_t { kHead, kJacket, kHand, kTrousers, kBoot };

// A bone is also the capsule that the body has around it, whose radius changes evenly from one end to the
// other.
struct Bone {
  const char* name;
  int parent;
  Vec3 begin, end;  // the joint is at `begin`
  double begin_radius, end_radius;
  Garment garment;
  uint8_t island;  // of the texture: the two sides of an island are a chart each
};

constexpr Bone kBones[] = {
    {"hips", -1, {0, 0, 0}, {0, 0.12, 0}, 0.15, 0.14, Garment::kTrousers, 0},
    {"spine", 0, {0, 0.14, 0}, {0, 0.28, 0}, 0.13, 0.14, Garment::kJacket, 1},
    {"chest", 1, {0, 0.32, 0}, {0, 0.44, 0}, 0.15, 0.13, Garment::kJacket, 1},
    {"neck", 2, {0, 0.5, 0}, {0, 0.6, 0.01}, 0.06, 0.055, Garment::kHead, 2},
    {"head", 3, {0, 0.62, 0.01}, {0, 0.78, 0.015}, 0.09, 0.12, Garment::kHead, 2},
    {"upper arm, left", 2, {0.16, 0.45, 0}, {0.42, 0.45, 0}, 0.075, 0.06, Garment::kJacket, 3},
    {"forearm, left", 5, {0.44, 0.45, 0}, {0.68, 0.45, 0}, 0.058, 0.042, Garment::kJacket, 3},
    {"hand, left", 6, {0.7, 0.45, 0}, {0.84, 0.45, 0}, 0.045, 0.03, Garment::kHand, 4},
    {"upper arm, right", 2, {-0.16, 0.45, 0}, {-0.42, 0.45, 0}, 0.075, 0.06, Garment::kJacket, 5},
    {"forearm, right", 8, {-0.44, 0.45, 0}, {-0.68, 0.45, 0}, 0.058, 0.042, Garment::kJacket, 5},
    {"hand, right", 9, {-0.7, 0.45, 0}, {-0.84, 0.45, 0}, 0.045, 0.03, Garment::kHand, 6},
    {"thigh, left", 0, {0.1, -0.06, 0}, {0.11, -0.42, 0}, 0.1, 0.075, Garment::kTrousers, 7},
    {"shin, left", 11, {0.11, -0.45, 0}, {0.11, -0.72, 0}, 0.072, 0.055, Garment::kTrousers, 7},
    {"foot, left", 12, {0.11, -0.82, 0}, {0.11, -0.88, 0.17}, 0.065, 0.045, Garment::kBoot, 8},
    {"thigh, right", 0, {-0.1, -0.06, 0}, {-0.11, -0.42, 0}, 0.1, 0.075, Garment::kTrousers, 9},
    {"shin, right", 14, {-0.11, -0.45, 0}, {-0.11, -0.72, 0}, 0.072, 0.055, Garment::kTrousers, 9},
    {"foot, right", 15, {-0.11, -0.82, 0}, {-0.11, -0.88, 0.17}, 0.065, 0.045, Garment::kBoot, 10},
};
constexpr size_t kJoints = std::size(kBones);
constexpr uint8_t kIslands = 11, kCharts = 2 * kIslands;

double from_capsule(const Bone& bone, Vec3 p) {
  const Vec3 axis = bone.end - bone.begin, d = p - bone.begin;
  const double t = std::clamp(dot(d, axis) / dot(axis, axis), 0.0, 1.0);
  return length(d - axis * t) - (bone.begin_radius + (bone.end_radius - bone.begin_radius) * t);
}

// The smaller of both, rounded where they are closer to each other than kBlend.
double blend(double a, double b) {
  constexpr double kBlend = 0.06;
  const double near = std::max(kBlend - std::fabs(a - b), 0.0);
  return std::min(a, b) - near * near / (4 * kBlend);
}

// The body, or one garment of it, with folds and unevenness.
class Body : public Field {
 public:
  explicit Body(uint64_t seed) : seed_(seed) { set_box(); }
  Body(uint64_t seed, Garment garment) : seed_(seed), is_garment_(true), garment_(garment) { set_box(); }

  double at(Vec3 p, double /*band*/) const override {
    double body = 4;
    for (const Bone& bone : kBones)
      if (!is_garment_ || bone.garment == garment_) body = blend(body, from_capsule(bone, p));
    uint64_t seed = seed_;
    for (const auto& [amplitude, frequency] : kFolds) body += amplitude * value_noise(p * frequency, seed++);
    return body;
  }
  double slope() const override {
    double slope = 1.2;  // of a capsule that gets wider
    for (const auto& [amplitude, frequency] : kFolds) slope += amplitude * frequency * kNoiseSlope;
    return slope;
  }

 private:
  struct Fold {
    double amplitude, frequency;
  };
  static constexpr Fold kFolds[] = {{0.012, 9.1}, {0.005, 23}, {0.0015, 57}};

  void set_box() {
    low = {-1, -1, -0.3};
    high = {1, 1, 0.4};
  }

  uint64_t seed_;
  bool is_garment_ = false;
  Garment garment_ = Garment::kHead;
};

const Bone& nearest_bone(Vec3 p) {
  return *std::ranges::min_element(kBones, {}, [&](const Bone& bone) { return from_capsule(bone, p); });
}

// Front and back of each island, and left and right of boots, projected onto a plane. A chart has a cell of the
// texture.
class TailoredAtlas : public Atlas {
 public:
  explicit TailoredAtlas(const Surface& surface) {
    boxes_.fill({{9, 9, 9}, {-9, -9, -9}});
    for (const auto& face : surface.faces) {
      Box& box = boxes_[chart(centre_of(surface, face))];
      for (const uint32_t vertex : face)
        for (size_t k = 0; k < 3; ++k) {
          box.low[k] = std::min<double>(box.low[k], surface.positions[vertex][k]);
          box.high[k] = std::max<double>(box.high[k], surface.positions[vertex][k]);
        }
    }
  }

  uint8_t chart(Vec3 centre) const override {
    const Bone& bone = nearest_bone(centre);
    const bool is_second = bone.garment == Garment::kBoot ? centre.x < bone.begin.x : centre.z < bone.begin.z;
    return static_cast<uint8_t>(2 * bone.island + (is_second ? 1 : 0));
  }
  std::array<float, 2> texcoord(uint8_t chart_index, const std::array<float, 3>& position) const override {
    constexpr int kColumns = 6, kRows = (kCharts + kColumns - 1) / kColumns;
    const Box& box = boxes_[chart_index];
    const auto part = [&](size_t k) {
      return 0.02 + 0.96 * (position[k] - box.low[k]) / std::max(box.high[k] - box.low[k], 1e-9);
    };
    const double u = part(is_boot(chart_index) ? 2 : 0), v = part(1);
    return {static_cast<float>((chart_index % kColumns + u) / kColumns),
            static_cast<float>((chart_index / kColumns + v) / kRows)};
  }

 private:
  struct Box {
    std::array<double, 3> low, high;
  };
  static bool is_boot(uint8_t chart_index) {
    return std::ranges::any_of(kBones, [&](const Bone& bone) {
      return bone.island == chart_index / 2 && bone.garment == Garment::kBoot;
    });
  }
  std::array<Box, kCharts> boxes_;
};

Garment garment_of(uint8_t chart) {
  return std::ranges::find(kBones, static_cast<uint8_t>(chart / 2), &Bone::island)->garment;
}

// The four bones that move a point, and their shares, which decrease and add up to 1.
struct Influences {
  std::array<uint8_t, 4> joints{};
  std::array<float, 4> weights{};
};

Influences influences_at(Vec3 p) {
  constexpr double kReach = 0.02, kLeast = 0.005;
  std::array<std::pair<double, uint8_t>, kJoints> shares;
  double sum = 0;
  for (size_t j = 0; j < kJoints; ++j) {
    const double distance = kReach + std::max(0.0, from_capsule(kBones[j], p)), square = distance * distance;
    shares[j] = {1 / (square * square), static_cast<uint8_t>(j)};
    sum += shares[j].first;
  }
  std::ranges::partial_sort(shares, shares.begin() + 4, std::ranges::greater());
  double kept = 0;
  for (size_t i = 0; i < 4; ++i) {
    if (shares[i].first < kLeast * sum) shares[i] = {0, 0};
    kept += shares[i].first;
  }
  Influences influences;
  for (size_t i = 0; i < 4; ++i) {
    influences.joints[i] = shares[i].second;
    influences.weights[i] = static_cast<float>(shares[i].first / kept);
  }
  return influences;
}

// Points that are nearer than `radius` to the centre move, those at the centre by `shift`.
struct Bump {
  Vec3 centre;
  double radius;
  Vec3 shift;
};
struct Expression {
  const char* name;
  std::array<Bump, 2> bumps;
};
constexpr Expression kExpressions[] = {
    {"jaw open", {{{{0, 0.6, 0.12}, 0.09, {0, -0.04, 0.005}}, {{0, 0.56, 0.08}, 0.07, {0, -0.015, 0}}}}},
    {"smile", {{{{0.05, 0.64, 0.12}, 0.06, {0.02, 0.015, 0}}, {{-0.05, 0.64, 0.12}, 0.06, {-0.02, 0.015, 0}}}}},
    {"blink, left",
     {{{{0.045, 0.75, 0.12}, 0.04, {0, -0.015, 0.004}}, {{0.045, 0.73, 0.12}, 0.03, {0, 0.006, 0}}}}},
    {"blink, right",
     {{{{-0.045, 0.75, 0.12}, 0.04, {0, -0.015, 0.004}}, {{-0.045, 0.73, 0.12}, 0.03, {0, 0.006, 0}}}}},
    {"brows up", {{{{0.05, 0.79, 0.12}, 0.06, {0, 0.018, 0}}, {{-0.05, 0.79, 0.12}, 0.06, {0, 0.018, 0}}}}},
    {"cheeks", {{{{0.07, 0.67, 0.1}, 0.06, {0.02, 0, 0.015}}, {{-0.07, 0.67, 0.1}, 0.06, {-0.02, 0, 0.015}}}}},
    {"broad chest", {{{{0.09, 0.38, 0.1}, 0.3, {0.03, 0, 0.04}}, {{-0.09, 0.38, 0.1}, 0.3, {-0.03, 0, 0.04}}}}},
    {"belly", {{{{0, 0.14, 0.12}, 0.28, {0, 0, 0.08}}, {{0, 0.08, -0.1}, 0.2, {0, 0, -0.02}}}}},
};

// The difference of a position, and that of the normal n of the surface there.
std::pair<Vec3, Vec3> moved(const Expression& expression, Vec3 p, Vec3 n) {
  Vec3 shift, turned = n;
  for (const Bump& bump : expression.bumps) {
    const Vec3 d = p - bump.centre;
    const double rest = 1 - dot(d, d) / (bump.radius * bump.radius);
    if (rest <= 0) continue;
    shift = shift + bump.shift * (rest * rest * rest);
    // The part that the gradient of the factor above has in the transposed derivative of the movement.
    turned = turned + d * (6 * rest * rest / (bump.radius * bump.radius) * dot(bump.shift, n));
  }
  const double size = length(turned);
  return {shift, size > 0 ? turned * (1 / size) - n : Vec3{}};
}

std::array<float, 3> floats_of(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
Vec3 vector_of(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

CharacterTarget make_target(const Expression& expression, std::span<const std::array<float, 3>> positions,
                            std::span<const std::array<float, 3>> normals) {
  CharacterTarget target{expression.name, {}, {}};
  for (size_t i = 0; i < positions.size(); ++i) {
    const auto [shift, turn] = moved(expression, vector_of(positions[i]), vector_of(normals[i]));
    target.positions.push_back(floats_of(shift));
    target.normals.push_back(floats_of(turn));
  }
  return target;
}

// How a joint swings while the character walks: half of the tangent of its angle, around each axis.
struct Swing {
  Vec3 rest, reach;
  double phase;  // of a step
};
Swing swing_of(size_t joint) {
  const std::string name = kBones[joint].name;
  const bool is_right = name.ends_with("right");
  const double side = is_right ? -1 : 1, phase = is_right ? 0.5 : 0;
  if (name.starts_with("thigh")) return {{}, {0.22, 0, 0.01}, phase};
  if (name.starts_with("shin")) return {{0.12, 0, 0}, {0.12, 0, 0}, phase + 0.2};
  if (name.starts_with("foot")) return {{}, {0.08, 0, 0}, phase + 0.35};
  if (name.starts_with("upper arm")) return {{0, 0, -0.55 * side}, {0.03, 0.18 * side, 0}, phase};
  if (name.starts_with("forearm")) return {{0, -0.12 * side, 0}, {0, 0.08, 0}, phase + 0.1};
  if (name.starts_with("hand")) return {{}, {0.02, 0.03, 0.02}, phase + 0.2};
  return {{0.01, 0, 0}, {0.01, 0.03, 0.012}, 0.1 * static_cast<double>(joint)};
}

// A walk of two seconds, with the unevenness of a recording.
void add_clip(Character& character, uint64_t seed) {
  constexpr size_t kKeys = 61;
  constexpr double kKeysASecond = 30, kStepsASecond = 1, kShake = 0.006;
  const auto shake = [&](double time, size_t track) {
    return kShake * value_noise({7 * time, static_cast<double>(track) + 0.5, 0.5}, seed);
  };
  for (size_t key = 0; key < kKeys; ++key) {
    const double time = static_cast<double>(key) / kKeysASecond, step = time * kStepsASecond;
    character.times.push_back(static_cast<float>(time));
    const Vec3 root = {0.01 * parabola_wave(step), 0.012 * parabola_wave(2 * step), shake(time, 1000)};
    character.translations.push_back(floats_of(root));
    for (size_t j = 0; j < kJoints; ++j) {
      const Swing swing = swing_of(j);
      const double wave = parabola_wave(step + swing.phase);
      const Vec3 v = swing.rest + swing.reach * wave +
                     Vec3{shake(time, 3 * j), shake(time, 3 * j + 1), shake(time, 3 * j + 2)};
      const double scale = 1 / std::sqrt(1 + dot(v, v));
      const std::array<float, 3> xyz = floats_of(v * scale);
      character.joints[j].rotations.push_back({xyz[0], xyz[1], xyz[2], static_cast<float>(scale)});
    }
    for (size_t t = 0; t < character.targets.size(); ++t) {
      const double wave = parabola_wave(0.5 * step + 0.13 * static_cast<double>(t));
      character.weights.push_back(static_cast<float>(std::max(0.0, wave)));
    }
  }
}

}  // namespace

Expected<Character> generate_character(uint64_t faces, uint64_t seed, const ThreadPool& pool) {
  if (Status status = check_face_count(faces); !status.ok()) return status;
  const uint64_t noise = scramble(seed + 0x9e3779b97f4a7c15u);
  Expected<SizedSurface> extracted = extract_about(Body(noise), faces, seed, pool);
  if (!extracted) return extracted.status();
  Surface& surface = extracted->surface;
  const ChartedPoints points = unfold(surface, TailoredAtlas(surface));
  const size_t point_count = points.vertex.size();

  std::vector<std::array<float, 3>> positions(point_count), normals(point_count);
  std::vector<Influences> influences(point_count);
  constexpr size_t kGrain = 1 << 10;
  pool.for_ranges(point_count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      positions[i] = surface.positions[points.vertex[i]];
      normals[i] = normal_at(Body(noise, garment_of(points.chart[i])), positions[i], 0.5 * extracted->cell);
      influences[i] = influences_at(vector_of(positions[i]));
    }
  });

  Character character;
  for (const Bone& bone : kBones)
    character.joints.push_back({bone.name, bone.parent, floats_of(bone.begin), {}});
  for (const Expression& expression : kExpressions)
    character.targets.push_back(make_target(expression, positions, normals));
  add_clip(character, noise);
  Mesh& mesh = character.mesh;
  mesh.point_count = static_cast<uint32_t>(point_count);
  mesh.faces = std::move(surface.faces);
  Attribute joints = make_attribute("JOINTS_0", 4, point_count, ComponentType::kUint8);
  Attribute weights = make_attribute("WEIGHTS_0", 4, point_count);
  for (size_t i = 0; i < point_count; ++i) {
    store(joints, i, influences[i].joints);
    store(weights, i, influences[i].weights);
  }
  mesh.attributes = {attribute_of<3>("POSITION", positions), attribute_of<3>("NORMAL", normals),
                     attribute_of<2>("TEXCOORD_0", points.texcoords), std::move(joints), std::move(weights)};
  return character;
}

}  // namespace psplit
