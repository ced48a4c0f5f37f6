#include "encoder/condensing/source_stream.h"

#include <algorithm>

#include "src/container/condensed_head.h"
#include "src/core/workspace.h"
#include "src/cpu/container_decoder.h"

namespace psplit {

std::optional<DracoFields> condensable_fields(std::span<const uint8_t> draco_stream, uint32_t face_count) {
  Expected<DracoFields> fields = read_fields(draco_stream);
  if (!fields || fields->possible_levels == 0 || fields->symbols.empty() || fields->symbols[0] != core::kE ||
      fields->face_count != face_count || fields->skeleton.size() > kMostSkeletonBytes)
    return std::nullopt;
  // The number of faces without a symbol says how many start faces there are.
  const auto interior = static_cast<uint64_t>(std::ranges::count(fields->start_faces, 1));
  if (fields->start_faces.empty() || interior != fields->face_count - fields->symbol_count) return std::nullopt;
  if (fields->attributes.empty()) return std::nullopt;
  for (const AttributeFields& attribute : fields->attributes) {
    constexpr uint32_t kMostComponentBytes = 4;
    const bool is_outside =
        attribute.grid_size > 0 &&
        std::ranges::any_of(attribute.symbols, [&](uint32_t symbol) { return symbol >= attribute.grid_size; });
    if (attribute.component_bytes > kMostComponentBytes || is_outside) return std::nullopt;
  }
  return std::move(*fields);
}

std::unique_ptr<DecodedSource> DecodedSource::decode(std::span<const uint8_t> draco_stream,
                                                     uint32_t point_count, const DracoFields& fields) {
  core::StreamHeader header;
  if (core::read_stream_header(draco_stream.data(), draco_stream.size(), header) != core::Fault::kNone)
    return nullptr;
  core::ValueCounts values{point_count, static_cast<uint32_t>(fields.attributes.size()), 0};
  for (const AttributeFields& attribute : fields.attributes) values.components += attribute.components;
  const size_t size = core::workspace_bytes<uint32_t>(header, draco_stream.size(), values);
  if (size > core::justified_bytes(draco_stream.size())) return nullptr;
  auto source = std::make_unique<DecodedSource>();
  source->memory_.reset(new uint8_t[size]);
  core::Arena arena(source->memory_.get(), size);
  core::Patch<uint32_t>& patch = source->patch_;
  core::View<uint32_t> walk;
  if (decode_wide(header, arena, patch) != core::Fault::kNone ||
      core::walk_border(patch, arena, walk) != core::Fault::kNone)
    return nullptr;
  const core::CornerTable<uint32_t>& table = source->table(0).table;
  for (size_t place = 0; place < walk.size(); ++place)
    source->walk_.push_back(patch.corner_of_point.empty() ? walk[place]
                                                          : table.vertex[patch.corner_of_point[walk[place]]]);
  return source;
}

}  // namespace psplit
