#include "encoder/stream/attribute_values.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "encoder/coding/octahedral_place.h"
#include "encoder/coding/quantization.h"

namespace psplit {
namespace {

template <typename T>
T component_at(const Attribute& source, uint32_t row, size_t component) {
  T value;
  std::memcpy(&value, source.values.data() + row * source.stride() + component * sizeof(T), sizeof(T));
  return value;
}

template <typename T>
bool copy_integers(const Attribute& source, std::span<const uint32_t> rows, int32_t* out,
                   bool are_signed = false) {
  const uint32_t most = are_signed ? 0xffffffff : 0x7fffffff;
  const size_t components = source.component_count, stride = core::value_stride(source.component_count);
  bool fits = true;
  for (const uint32_t row : rows) {
    for (size_t k = 0; k < components; ++k) {
      const T value = component_at<T>(source, row, k);
      if constexpr (sizeof(T) == sizeof(uint32_t)) fits = fits && value <= most;
      out[k] = static_cast<int32_t>(value);
    }
    out += stride;
  }
  return fits;
}

}  // namespace

void set_stream_grid(const Attribute& source, const AttributeCoding& coding, std::span<const uint32_t> rows,
                     AttributePlan& plan) {
  GridExtremes extremes = grid_extremes(coding).value_or(GridExtremes{coding.origin, coding.origin});
  // libdraco replaces the least value only by a smaller one, and compares the values of rows in their order,
  // then the extremes. So the least is the one of the lowest row, also if zeros have different signs.
  std::vector<uint32_t> low_row(source.component_count, ~uint32_t{0});
  for (const uint32_t row : rows)
    for (size_t k = 0; k < source.component_count; ++k) {
      const auto value = component_at<float>(source, row, k);
      float& low = extremes.low[k];
      if (value < low || (value == low && row < low_row[k])) low = value, low_row[k] = row;
      extremes.high[k] = std::max(extremes.high[k], value);
    }
  float range = 0;
  for (size_t k = 0; k < source.component_count; ++k)
    range = std::max(range, extremes.high[k] - extremes.low[k]);
  plan.origin = std::move(extremes.low);
  plan.description.range = range == 0 ? 1.0f : range;
}

Status write_integers(const Attribute& source, const AttributePlan& plan, std::span<const uint32_t> rows,
                      std::span<int32_t> out) {
  const core::Attribute<uint32_t>& description = plan.description;
  int32_t* to = out.data();
  const auto no_grid = [&] {
    return invalid_input(
        source.semantic +
        " fits no grid: a value is not finite, or the extent of its values is too large or too small");
  };
  if (description.coding == core::Coding::kNormal) {
    const core::OctahedralGrid grid(description.bits);
    for (const uint32_t row : rows) {
      float direction[3];
      std::memcpy(direction, source.values.data() + row * sizeof direction, sizeof direction);
      if (!std::ranges::all_of(direction, [](float of) { return std::isfinite(of); })) return no_grid();
      const core::Vec2 place = octahedral_place(grid, direction);
      to[0] = place.s, to[1] = place.t;
      to += core::value_stride(2);
    }
    return {};
  }
  if (description.coding == core::Coding::kQuantized) {
    // An infinite value anywhere makes the range infinite.
    const float range = description.range;
    if (!std::isfinite(grid_place(range, 0, range, description.bits))) return no_grid();
    const size_t stride = core::value_stride(source.component_count);
    for (const uint32_t row : rows) {
      for (size_t k = 0; k < source.component_count; ++k) {
        const auto value = component_at<float>(source, row, k);
        const float place = grid_place(value, plan.origin[k], range, description.bits);
        if (!(std::fabs(place) < 0x1p31f)) return no_grid();  // also if the value or the origin is not a number
        to[k] = static_cast<int32_t>(place);
      }
      to += stride;
    }
    return {};
  }
  bool fits = true;
  switch (source.component_type) {
    case ComponentType::kInt8: fits = copy_integers<int8_t>(source, rows, to); break;
    case ComponentType::kUint8: fits = copy_integers<uint8_t>(source, rows, to); break;
    case ComponentType::kInt16: fits = copy_integers<int16_t>(source, rows, to); break;
    case ComponentType::kUint16: fits = copy_integers<uint16_t>(source, rows, to); break;
    case ComponentType::kUint32:
      fits = copy_integers<uint32_t>(source, rows, to, description.type == DataType::kInt32);
      break;
    case ComponentType::kFloat32: fits = false; break;
  }
  return fits ? Status() : unsupported(source.semantic + ": an integer above 2^31 - 1");
}

std::vector<uint8_t> raw_values(const Attribute& source, std::span<const uint32_t> rows) {
  const size_t stride = source.stride();
  std::vector<uint8_t> bytes(rows.size() * stride);
  uint8_t* to = bytes.data();
  for (const uint32_t row : rows) {
    std::memcpy(to, source.values.data() + row * stride, stride);
    to += stride;
  }
  return bytes;
}

}  // namespace psplit
