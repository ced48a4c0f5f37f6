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

PatchBox no_box() {
  PatchBox box;
  box.low.fill(HUGE_VAL);
  box.high.fill(-HUGE_VAL);
  return box;
}

// Positions that are not finite are in no box.
void extend(PatchBox& box, const Attribute& positions, uint32_t point) {
  const std::byte* const at = positions.values.data() + point * positions.stride();
  std::array<double, kAxes> position{};
  for (size_t axis = 0; axis < kAxes; ++axis) {
    position[axis] = number_of(at + axis * component_bytes(positions.component_type), positions.component_type,
                               positions.normalized);
    if (!std::isfinite(position[axis])) return;
  }
  for (size_t axis = 0; axis < kAxes; ++axis) {
    box.low[axis] = std::min(box.low[axis], position[axis]);
    box.high[axis] = std::max(box.high[axis], position[axis]);
  }
}

std::vector<PatchBox> boxes_of(const PatchContainer& container, const Mesh& decoded,
                               const Attribute& positions) {
  std::vector<PatchBox> boxes(container.entries.size(), no_box());
  for (size_t i = 0; i < boxes.size(); ++i) {
    for (uint32_t face = container.face_base[i]; face < container.face_base[i + 1]; ++face)
      for (const uint32_t point : decoded.faces[face]) extend(boxes[i], positions, point);
    for (uint32_t point = container.owned_base[i]; point < container.owned_base[i + 1]; ++point)
      extend(boxes[i], positions, point);
  }
  return boxes;
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

std::vector<uint8_t> with_boxes(const PatchContainer& container, const Mesh& decoded) {
  std::vector<uint8_t> bytes(container.bytes.begin(), container.bytes.end());
  const Attribute* const attribute = decoded.find("POSITION");
  if (attribute == nullptr || attribute->component_count != kAxes) return bytes;
  const std::vector<PatchBox> boxes = boxes_of(container, decoded, *attribute);
  PatchBox all = no_box();
  for (const PatchBox& box : boxes)
    for (size_t axis = 0; axis < kAxes; ++axis) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      all.high[axis] = std::max(all.high[axis], box.high[axis]);
    }
  if (all.low[0] > all.high[0]) return bytes;
  Bounds bounds;
  std::vector<uint8_t> section;
  for (size_t axis = 0; axis < kAxes; ++axis)
    append_float(bounds.low[axis] = float_below(all.low[axis]), section);
  for (size_t axis = 0; axis < kAxes; ++axis)
    append_float(bounds.high[axis] = float_above(all.high[axis]), section);
  for (const PatchBox& box : boxes) append_box(bounds, box, section);
  return with_head_section(container, HeadSection::kBoxes, section);
}

}  // namespace psplit
