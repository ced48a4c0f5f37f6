#include "tools/gltf_psplit/diff/filtered_grids.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_codec.h"

namespace psplit {

std::optional<DeclaredGrid> FilteredGrids::of(int64_t accessor) {
  const AccessorRecord& record = document_.records().accessor(accessor);
  if (record.layout.component_type != ComponentType::kFloat32) return std::nullopt;
  const size_t width = record.layout.stored_bytes();
  std::optional<int> least, most;
  uint32_t multiples = 0;  // all of them, to find the bits that are zero in each
  bool is_all = true;
  const auto add = [&](const ElementsRecord& elements, uint64_t count, uint64_t stride) {
    const std::vector<uint8_t>& rows = rows_of(elements.view);
    is_all &= !rows.empty();
    if (rows.empty()) return;
    for (uint64_t i = 0; i < count; ++i)
      for (size_t at = 0; at < width; at += sizeof(uint32_t)) {
        // A row is a number of 24 bits below its exponent, little-endian.
        const uint8_t* const row = &rows[elements.offset + i * stride + at];
        const auto exponent = static_cast<int8_t>(row[3]);
        multiples |= static_cast<uint32_t>(row[0] | row[1] << 8 | row[2] << 16);
        least = std::min<int>(least.value_or(exponent), exponent);
        most = std::max<int>(most.value_or(exponent), exponent);
      }
  };
  if (record.has_view()) {
    const uint32_t stride = document_.records().view(record.elements.view).stride;
    add(record.elements, record.count, stride > 0 ? stride : width);
  }
  if (record.sparse) add(record.sparse->values, record.sparse->count, width);
  if (!most) return std::nullopt;
  // Small multiples may stand in the upper bytes, below a smaller exponent (lift_multiples).
  if (least == most && multiples != 0) most = *most + std::countr_zero(multiples) / 8 * 8, least = most;
  DeclaredGrid grid;
  grid.within = std::ldexp(0.5, *most);
  if (is_all && least == most) grid.identity = "multiples of 2^" + std::to_string(*most);
  return grid;
}

const std::vector<uint8_t>& FilteredGrids::rows_of(int64_t view) {
  const auto [found, is_new] = rows_.try_emplace(view);
  std::vector<uint8_t>& rows = found->second;
  const ViewRecord& record = document_.records().view(view);
  if (!is_new || !record.meshopt || record.meshopt->filter != "EXPONENTIAL") return rows;
  const auto& [buffer, offset, length] = record.meshopt->range;
  const std::span<const uint8_t> all = document_.buffers[static_cast<size_t>(buffer)];
  if (offset > all.size() || length > all.size() - offset) return rows;
  const std::span<const uint8_t> bytes = all.subspan(static_cast<size_t>(offset), static_cast<size_t>(length));
  if (!is_readable_meshopt(*record.meshopt, bytes) || !is_legal_meshopt(*record.meshopt)) return rows;
  rows.resize(record.meshopt->decoded_bytes());
  if (rows.size() < record.range.bytes || !decode_meshopt_rows(*record.meshopt, bytes, rows.data()))
    rows.clear();
  return rows;
}

}  // namespace psplit
