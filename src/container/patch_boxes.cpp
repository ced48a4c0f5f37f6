#include "src/container/patch_boxes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "src/container/condensed_head.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

constexpr size_t kAxes = 3, kBoundBytes = 2 * kAxes * sizeof(float), kBoxBytes = 2 * kAxes;
constexpr int kSteps = 255;

// The bounds of the whole mesh, on whose steps the boxes lie.
struct Bounds {
  std::array<float, kAxes> low{}, high{};

  double at(size_t axis, int step) const {
    return step == kSteps ? double{high[axis]} : low[axis] + (double{high[axis]} - low[axis]) * step / kSteps;
  }
};

float read_float(std::span<const uint8_t> bytes) {
  uint32_t word = 0;
  for (size_t i = 0; i < sizeof(word); ++i) word |= uint32_t{bytes[i]} << (8 * i);
  return std::bit_cast<float>(word);
}
void append_float(float value, std::vector<uint8_t>& bytes) {
  const auto word = std::bit_cast<uint32_t>(value);
  for (size_t i = 0; i < sizeof(word); ++i) bytes.push_back(static_cast<uint8_t>(word >> (8 * i)));
}

// The floats next to a number, at most and at least it.
float float_below(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -HUGE_VALF) : rounded;
}
float float_above(double value) { return -float_below(-value); }

void append_box(const Bounds& bounds, const PatchBox& box, std::vector<uint8_t>& bytes) {
  const bool is_empty = box.low[0] > box.high[0];
  std::array<int, kAxes> low{}, high{};
  for (size_t axis = 0; axis < kAxes; ++axis) {
    low[axis] = is_empty ? kSteps : 0;
    high[axis] = is_empty ? 0 : kSteps;
    if (is_empty) continue;
    while (low[axis] < kSteps && bounds.at(axis, low[axis] + 1) <= box.low[axis]) ++low[axis];
    // In a flat mesh, all steps are the same.
    while (high[axis] > low[axis] && bounds.at(axis, high[axis] - 1) >= box.high[axis]) --high[axis];
  }
  for (const auto& steps : {low, high})
    for (const int step : steps) bytes.push_back(static_cast<uint8_t>(step));
}

}  // namespace

std::span<const uint8_t> boxes_section(const PatchContainer& container) {
  if (container.is_stock || container.head_bytes == 0) return {};
  const auto front = container.bytes.first(static_cast<size_t>(container.header_bytes));
  return find_head_section(HeadSection::kBoxes, front.last(container.head_bytes));
}

Expected<std::vector<PatchBox>> patch_boxes(const PatchContainer& container) {
  const std::span<const uint8_t> bytes = boxes_section(container);
  std::vector<PatchBox> boxes;
  if (bytes.empty()) return boxes;
  if (bytes.size() != kBoundBytes + kBoxBytes * container.entries.size())
    return invalid_input("head: boxes of another number of streams");
  Bounds bounds;
  for (size_t axis = 0; axis < kAxes; ++axis) {
    bounds.low[axis] = read_float(bytes.subspan(axis * sizeof(float)));
    bounds.high[axis] = read_float(bytes.subspan((kAxes + axis) * sizeof(float)));
    if (!std::isfinite(bounds.low[axis]) || !std::isfinite(bounds.high[axis]) ||
        bounds.low[axis] > bounds.high[axis])
      return invalid_input("head: boxes without bounds");
  }
  for (size_t at = kBoundBytes; at < bytes.size(); at += kBoxBytes) {
    PatchBox& box = boxes.emplace_back();
    bool is_empty = false;
    for (size_t axis = 0; axis < kAxes; ++axis) {
      const int low = bytes[at + axis], high = bytes[at + kAxes + axis];
      is_empty |= low > high;
      box.low[axis] = bounds.at(axis, low);
      box.high[axis] = bounds.at(axis, high);
    }
    if (is_empty) box = no_box();
  }
  return boxes;
}

PatchBox no_box() {
  PatchBox box;
  box.low.fill(HUGE_VAL);
  box.high.fill(-HUGE_VAL);
  return box;
}

void extend(PatchBox& box, const std::byte* position, ComponentType type, bool normalized) {
  std::array<double, kAxes> numbers{};
  for (size_t axis = 0; axis < kAxes; ++axis) {
    numbers[axis] = number_of(position + axis * component_bytes(type), type, normalized);
    if (!std::isfinite(numbers[axis])) return;
  }
  for (size_t axis = 0; axis < kAxes; ++axis) {
    box.low[axis] = std::min(box.low[axis], numbers[axis]);
    box.high[axis] = std::max(box.high[axis], numbers[axis]);
  }
}

std::optional<size_t> axis_outside(const PatchBox& box, const PatchBox& positions) {
  if (positions.low[0] > positions.high[0]) return std::nullopt;
  for (size_t axis = 0; axis < kAxes; ++axis) {
    // Other encoders may compute the bounds of a box in another order.
    const double slack = 0x1p-50 * std::max(std::fabs(box.low[axis]), std::fabs(box.high[axis]));
    if (!(box.low[axis] - slack <= positions.low[axis] && positions.high[axis] <= box.high[axis] + slack))
      return axis;
  }
  return std::nullopt;
}

StreamPlace place_of_stream(const PatchContainer& container, uint32_t stream) {
  return {container.face_base[stream], container.face_base[stream + 1], container.owned_base[stream],
          container.owned_base[stream + 1]};
}

std::vector<PatchBox> boxes_of(const PatchContainer& container, const Mesh& decoded) {
  const Attribute* const positions = decoded.find("POSITION");
  std::vector<PatchBox> boxes;
  if (positions == nullptr || positions->component_count != kAxes) return boxes;
  for (uint32_t i = 0; i < container.entries.size(); ++i)
    boxes.push_back(box_of(
        place_of_stream(container, i), positions->component_type, positions->normalized,
        [&](size_t corner) { return decoded.faces[corner / 3][corner % 3]; },
        [&](uint32_t point) { return positions->values.data() + point * positions->stride(); }));
  return boxes;
}

std::vector<uint8_t> write_boxes(std::span<const PatchBox> boxes) {
  PatchBox all = no_box();
  for (const PatchBox& box : boxes)
    for (size_t axis = 0; axis < kAxes; ++axis) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      all.high[axis] = std::max(all.high[axis], box.high[axis]);
    }
  std::vector<uint8_t> section;
  if (all.low[0] > all.high[0]) return section;
  Bounds bounds;
  for (size_t axis = 0; axis < kAxes; ++axis)
    append_float(bounds.low[axis] = float_below(all.low[axis]), section);
  for (size_t axis = 0; axis < kAxes; ++axis)
    append_float(bounds.high[axis] = float_above(all.high[axis]), section);
  for (const PatchBox& box : boxes) append_box(bounds, box, section);
  return section;
}

}  // namespace psplit
