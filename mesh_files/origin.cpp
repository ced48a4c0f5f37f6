#include "mesh_files/origin.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <limits>
#include <string>

#include "mesh_files/mesh_file.h"

namespace psplit {
namespace {

constexpr int kDefaultBits = 14;

double loss_of(const PrecisePosition& position) {
  double loss = 0;
  for (const double value : position) loss = std::max(loss, std::fabs(value - rounded_to_float(value)));
  return loss;
}

// The most that floats lose of positions within the bounds, relative to the origin.
double loss_bound(const PositionSpread& spread, const PrecisePosition& origin) {
  double farthest = 0;
  for (size_t axis = 0; axis < 3; ++axis)
    farthest = std::max(
        {farthest, std::fabs(spread.low[axis] - origin[axis]), std::fabs(spread.high[axis] - origin[axis])});
  constexpr int kBitsOfFloat = 24;
  return farthest == 0 ? 0 : std::ldexp(1.0, std::ilogb(farthest) - kBitsOfFloat);
}

// Near the centre, in multiples of `unit`.
PrecisePosition centre_of(const PositionSpread& spread, double unit) {
  PrecisePosition centre;
  for (size_t axis = 0; axis < 3; ++axis)
    centre[axis] =
        std::round((spread.low[axis] + (spread.high[axis] - spread.low[axis]) / 2) / unit) * unit + 0.0;
  return centre;
}

// Whole numbers, unless these are too far from so small an object.
PrecisePosition centre_of(const PositionSpread& spread) {
  constexpr int kEnoughBits = 20;
  const double extent = spread.extent();
  const PrecisePosition whole = centre_of(spread, 1);
  const bool is_near =
      !(extent > 0) || extent >= 1 || loss_bound(spread, whole) <= std::ldexp(extent, -kEnoughBits);
  if (is_near) return whole;
  constexpr int kBitsOfQuotient = 50;  // doubles count multiples up to these
  double farthest = 0;
  for (size_t axis = 0; axis < 3; ++axis)
    farthest = std::max({farthest, std::fabs(spread.low[axis]), std::fabs(spread.high[axis])});
  const int digit = std::max(std::ilogb(extent), std::ilogb(farthest) - kBitsOfQuotient);
  return centre_of(spread, std::ldexp(1.0, digit));
}

double half_step(const PositionSpread& spread, int bits) {
  return bits > 0 ? spread.extent() / (std::ldexp(1.0, bits) - 1) / 2 : 0;
}

// Whether so large a loss is more than the object may have, and much more than with an origin of its own.
bool is_too_much(double loss, const PositionSpread& object, int bits, double spare) {
  const double gain = bits > 0 ? 2 : 16;
  return loss > std::max(half_step(object, bits), spare) && loss > gain * loss_bound(object, centre_of(object));
}

// Whether floats relative to these origins may lose too much. They lose `most` at most.
bool are_coarse(std::span<const PositionSpread> objects, std::span<const PrecisePosition> origins, double most,
                const OriginChoice& choice) {
  for (size_t i = 0; i < objects.size(); ++i)
    if (!objects[i].is_empty() &&
        is_too_much(std::min(most, loss_bound(objects[i], origins[i])), objects[i], choice.bits, choice.spare))
      return true;
  return false;
}

std::string short_text(double value) {
  std::array<char, 32> text;
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 2);
  return {text.data(), end};
}

bool is_one(const std::vector<PrecisePosition>& given) {
  return !given.empty() && std::ranges::all_of(given, [&](const auto& origin) { return origin == given[0]; });
}

bool is_zero(const PrecisePosition& origin) { return origin == PrecisePosition{}; }

PositionSpread spread_of(const MeshFilePart& part) {
  PositionSpread spread;
  for (const PrecisePosition& position : part.positions) spread.add(position);
  if (!part.positions.empty()) return spread;
  const Attribute& floats = part.mesh.attributes[0];
  for (uint32_t i = 0; i < part.mesh.point_count; ++i) spread.add(precise(position_at(floats, i)));
  return spread;
}

// Returns what the floats lose.
double make_floats(MeshFilePart& part, const PrecisePosition& origin) {
  Attribute& floats = part.mesh.attributes[0];
  if (part.positions.empty() && is_zero(origin)) return 0;
  const bool from_floats = part.positions.empty();
  floats.values.resize(part.mesh.point_count * sizeof(Position));
  double left = 0;
  for (uint32_t i = 0; i < part.mesh.point_count; ++i) {
    const PrecisePosition from = from_floats ? precise(position_at(floats, i)) : part.positions[i];
    const Position to = relative_to(origin, from);
    left = std::max(left, lost_by(origin, from));
    std::memcpy(floats.values.data() + i * sizeof(to), to.data(), sizeof(to));
  }
  part.positions = {};
  return left;
}

}  // namespace

void PositionSpread::add(const PrecisePosition& position) {
  for (size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], position[axis]);
    high[axis] = std::max(high[axis], position[axis]);
  }
  loss = std::max(loss, loss_of(position));
}

void PositionSpread::add(const PositionSpread& other) {
  for (size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], other.low[axis]);
    high[axis] = std::max(high[axis], other.high[axis]);
  }
  loss = std::max(loss, other.loss);
}

double PositionSpread::extent() const {
  double most = 0;
  for (size_t axis = 0; axis < 3; ++axis) most = std::max(most, high[axis] - low[axis]);
  return most;
}

std::vector<PrecisePosition> choose_origins(std::span<const PositionSpread> objects,
                                            const OriginChoice& choice) {
  std::vector<PrecisePosition> origins(objects.size());
  if (choice.by == OriginChoice::By::kNone) return origins;
  if (choice.by == OriginChoice::By::kGiven) {
    const bool is_for_all = choice.given.size() != objects.size() && is_one(choice.given);
    if (is_for_all) std::ranges::fill(origins, choice.given[0]);
    if (choice.given.size() == objects.size()) origins = choice.given;
    const bool fits = is_for_all || choice.given.size() == objects.size();
    if (fits && !(choice.refuses_coarse && are_coarse(objects, origins, INFINITY, choice))) return origins;
    std::ranges::fill(origins, PrecisePosition{});
  }
  PositionSpread whole;
  bool is_needed = false;
  for (const PositionSpread& object : objects) {
    if (object.is_empty()) continue;
    whole.add(object);
    is_needed = is_needed || is_too_much(object.loss, object, choice.bits, choice.spare);
  }
  if (!is_needed) return origins;
  // Small objects beside the origin of a large scene lose more than their own grid allows, too, but not more
  // than their neighbours do. They stay as they are.
  constexpr double kFar = 4, kFarIfExact = 16, kVeryFar = 1 << 17;
  const PrecisePosition common = centre_of(whole);
  const bool is_far = whole.loss > (choice.bits > 0 ? kFar : kFarIfExact) * loss_bound(whole, common);
  const int bits = choice.bits > 0 ? choice.bits : kDefaultBits;
  const bool is_enough = std::ranges::none_of(objects, [&](const PositionSpread& object) {
    return !object.is_empty() && is_too_much(loss_bound(object, common), object, bits, choice.spare);
  });
  if (is_far && is_enough) return std::vector<PrecisePosition>(objects.size(), common);
  for (size_t i = 0; i < objects.size(); ++i) {
    const PositionSpread& object = objects[i];
    if (object.is_empty() || !is_too_much(object.loss, object, choice.bits, choice.spare)) continue;
    const PrecisePosition own = centre_of(object);
    if (is_far || object.loss > kVeryFar * loss_bound(object, own)) origins[i] = own;
  }
  return origins;
}

bool need_doubles(std::span<const PositionSpread> objects) {
  OriginChoice exact;
  exact.bits = 0;
  const std::vector<PrecisePosition> origins = choose_origins(objects, exact);
  return !std::ranges::all_of(origins, is_zero);
}

bool is_far(const PositionSpread& object) {
  return object.extent() > 0 && is_too_much(loss_bound(object, {}), object, kDefaultBits, 0);
}

void say_origins(std::span<const PositionSpread> objects, std::span<const PrecisePosition> origins, double left,
                 const OriginChoice& choice, Losses& losses) {
  double loss = 0;
  bool too_much = false;
  size_t moved = 0, first = 0, own = 0;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].is_empty()) continue;
    loss = std::max(loss, objects[i].loss);
    too_much = too_much || is_too_much(objects[i].loss, objects[i], choice.bits, choice.spare);
    if (is_zero(origins[i])) continue;
    if (moved++ == 0) first = i;
    own += origins[i] != origins[first] ? 1 : 0;
  }
  const std::string would = loss > 0 ? ": floats alone would be off by up to " + short_text(loss) : "";
  if (moved > 0 && own == 0)
    losses.say("positions are relative to the origin " + origin_text(origins[first]) +
               ", which is the translation of their node" + would);
  else if (moved > 0)
    losses.say("positions of " + std::to_string(moved) + " objects are relative to origins such as " +
               origin_text(origins[first]) + ", which are the translations of their nodes" + would);
  if (moved == 0 && choice.by == OriginChoice::By::kNone && too_much)
    losses.say("positions are off by up to " + short_text(loss) +
               ", because they become floats and no origin is subtracted");
  else if (choice.by == OriginChoice::By::kGiven && are_coarse(objects, origins, left, choice))
    losses.say("positions are off by up to " + short_text(left) + ", because floats are coarse so far from " +
               "the origin that is subtracted");
  else if (left > 0 && choice.is_lossless)
    losses.say("positions are not floats exactly: they are off by up to " + short_text(left));
}

bool is_finite(const PrecisePosition& position) {
  return std::ranges::all_of(
      position, [](double value) { return std::fabs(value) <= double{std::numeric_limits<float>::max()}; });
}

Position relative_to(const PrecisePosition& origin, const PrecisePosition& position) {
  Position relative;
  // A difference would change the sign of a zero.
  for (size_t axis = 0; axis < 3; ++axis)
    relative[axis] = static_cast<float>(origin[axis] == 0 ? position[axis] : position[axis] - origin[axis]);
  return relative;
}

double lost_by(const PrecisePosition& origin, const PrecisePosition& position) {
  return loss_of({position[0] - origin[0], position[1] - origin[1], position[2] - origin[2]});
}

std::string origin_text(const PrecisePosition& origin) {
  std::string text;
  for (const double value : origin) {
    std::array<char, 400> digits;
    const auto [end, error] =
        std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed);
    text += (text.empty() ? "" : ",") + std::string(digits.data(), end);
  }
  return text;
}

void settle_positions(MeshFile& file, const OriginChoice& choice) {
  bool has_doubles = false;
  std::vector<PositionSpread> spreads;
  std::vector<MeshFileObject*> objects;
  const bool are_points = has_only_points(file);
  for (MeshFileObject& object : file.objects) {
    // Objects without faces become no mesh, unless there are no others.
    if (!are_points &&
        std::ranges::all_of(object.parts, [](const MeshFilePart& p) { return p.mesh.faces.empty(); })) {
      for (MeshFilePart& part : object.parts) make_floats(part, {});
      continue;
    }
    objects.push_back(&object);
    for (const MeshFilePart& part : object.parts) has_doubles = has_doubles || !part.positions.empty();
  }
  if (!has_doubles && choice.by != OriginChoice::By::kGiven) return;
  for (const MeshFileObject* object : objects) {
    PositionSpread& spread = spreads.emplace_back();
    for (const MeshFilePart& part : object->parts) spread.add(spread_of(part));
  }
  const std::vector<PrecisePosition> origins = choose_origins(spreads, choice);
  double left = 0;
  for (size_t i = 0; i < objects.size(); ++i) {
    objects[i]->origin = origins[i];
    for (MeshFilePart& part : objects[i]->parts) left = std::max(left, make_floats(part, origins[i]));
  }
  say_origins(spreads, origins, left, choice, file.losses);
}

}  // namespace psplit
