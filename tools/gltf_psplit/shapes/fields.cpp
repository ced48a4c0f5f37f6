#include "tools/gltf_psplit/shapes/fields.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace psplit {
namespace {

struct Octave {
  double amplitude, frequency;
};

// `base` plus a sum of noises, the coarsest first. Stops early if the rest cannot bring the sum back into the
// band.
double add_octaves(double base, Vec3 p, std::span<const Octave> octaves, uint64_t seed, double band) {
  double rest = 0;
  for (const Octave& octave : octaves) rest += octave.amplitude;
  double sum = base;
  for (const Octave& octave : octaves) {
    if (std::fabs(sum) - rest > band) return sum > 0 ? sum - rest : sum + rest;
    sum += octave.amplitude * value_noise(p * octave.frequency, seed++);
    rest -= octave.amplitude;
  }
  return sum;
}

double octave_slope(std::span<const Octave> octaves) {
  double slope = 0;
  for (const Octave& octave : octaves) slope += octave.amplitude * octave.frequency * kNoiseSlope;
  return slope;
}

class Terrain : public Field {
 public:
  explicit Terrain(uint64_t seed) : seed_(seed) {
    low = {-1, -0.5, -1};
    high = {1, 0.5, 1};
    closed = false;
  }
  double at(Vec3 p, double band) const override { return add_octaves(p.y, p, kOctaves, seed_, band); }
  double slope() const override { return 1 + octave_slope(kOctaves); }

 private:
  static constexpr Octave kOctaves[] = {{0.24, 1.7}, {0.11, 3.9}, {0.045, 8.3},
                                        {0.018, 19}, {0.006, 41}, {0.002, 97}};
  uint64_t seed_;
};

class Blob : public Field {
 public:
  explicit Blob(uint64_t seed) : seed_(seed) {}
  double at(Vec3 p, double band) const override {
    return add_octaves(length(p) - 0.62, p, kOctaves, seed_, band);
  }
  double slope() const override { return 1 + octave_slope(kOctaves); }

 private:
  static constexpr Octave kOctaves[] = {{0.21, 1.9}, {0.08, 4.3}, {0.03, 9.7}, {0.012, 21}, {0.004, 47}};
  uint64_t seed_;
};

class Gyroid : public Field {
 public:
  explicit Gyroid(uint64_t seed) : seed_(seed) {}
  double at(Vec3 p, double band) const override {
    const double ball = length(p) - 0.92;
    if (ball > band) return ball;
    // Bending the lattice makes all tunnels differ in size and direction.
    const double bend = 0.06 * value_noise(p * 2.1, seed_);
    const Vec3 q = {kTunnels * (p.x + bend), kTunnels * (p.y - bend), kTunnels * (p.z + bend)};
    const double wave = parabola_wave(q.x) * parabola_wave(q.y + 0.25) +
                        parabola_wave(q.y) * parabola_wave(q.z + 0.25) +
                        parabola_wave(q.z) * parabola_wave(q.x + 0.25);
    const double solid = add_octaves(0.07 * wave, p, kOctaves, seed_ + 1, band);
    return std::max(ball, solid);
  }
  double slope() const override { return 3 + octave_slope(kOctaves); }

 private:
  static constexpr double kTunnels = 2.3;
  static constexpr Octave kOctaves[] = {{0.01, 7.7}, {0.004, 23}, {0.002, 53}};
  uint64_t seed_;
};

class Ring : public Field {
 public:
  explicit Ring(uint64_t seed) : seed_(seed) {
    low.y = -0.5;
    high.y = 0.5;
  }
  double at(Vec3 p, double band) const override {
    const double from_circle = std::sqrt(p.x * p.x + p.z * p.z) - 0.65;
    const double tube = std::sqrt(from_circle * from_circle + p.y * p.y) - 0.22;
    return add_octaves(tube, p, kOctaves, seed_, band);
  }
  double slope() const override { return 1 + octave_slope(kOctaves); }

 private:
  static constexpr Octave kOctaves[] = {{0.05, 3.1}, {0.02, 8.9}, {0.008, 23}};
  uint64_t seed_;
};

// Separate stones of many sizes, which make a mesh of several components.
class Pebbles : public Field {
 public:
  explicit Pebbles(uint64_t seed) : seed_(seed) {
    for (int i = 0; i < 8; ++i) {
      const uint64_t bits = hash_lattice(i, 0, 0, seed);
      const Vec3 corner = {i & 1 ? 0.45 : -0.45, i & 2 ? 0.45 : -0.45, i & 4 ? 0.45 : -0.45};
      const Vec3 shift = {0.08 * signed_unit(bits), 0.08 * signed_unit(bits >> 21),
                          0.08 * signed_unit(bits >> 42)};
      stones_.push_back({corner + shift, 0.12 + 0.025 * i});
    }
  }
  double at(Vec3 p, double band) const override {
    double nearest = 4;
    for (const Stone& stone : stones_) nearest = std::min(nearest, length(p - stone.centre) - stone.radius);
    return add_octaves(nearest, p, kOctaves, seed_, band);
  }
  double slope() const override { return 1 + octave_slope(kOctaves); }

 private:
  struct Stone {
    Vec3 centre;
    double radius;
  };
  static constexpr Octave kOctaves[] = {{0.03, 6.1}, {0.008, 17}};
  std::vector<Stone> stones_;
  uint64_t seed_;
};

}  // namespace

std::unique_ptr<Field> make_field(FieldKind kind, uint64_t seed) {
  // Octaves use seed, seed + 1, ...; scrambling keeps the octaves of adjacent seeds apart.
  seed = scramble(seed + 0x9e3779b97f4a7c15u);
  switch (kind) {
    case FieldKind::kTerrain: return std::make_unique<Terrain>(seed);
    case FieldKind::kBlob: return std::make_unique<Blob>(seed);
    case FieldKind::kGyroid: return std::make_unique<Gyroid>(seed);
    case FieldKind::kRing: return std::make_unique<Ring>(seed);
    case FieldKind::kPebbles: return std::make_unique<Pebbles>(seed);
  }
  return nullptr;
}

}  // namespace psplit
