#include "gltf_ext/convert/stated_grids.h"

#include <algorithm>
#include <optional>

#include "encoder/coding/quantization.h"
#include "encoder/coding/step_grid.h"
#include "gltf_ext/primitive/describe_primitive.h"
#include "psplit/decode.h"

namespace psplit {
namespace {

AttributeCoding coding_of(const StreamDescription& stream, uint32_t unique_id) {
  const auto found = std::ranges::find(stream.attributes, unique_id, &StreamAttribute::unique_id);
  if (found == stream.attributes.end()) return {};
  return {found->bits, found->is_octahedral(), found->origin, found->range};
}

bool is_wide_integer(DataType type) {
  return type == DataType::kInt32 || type == DataType::kUint32 || type == DataType::kInt64 ||
         type == DataType::kUint64;
}

// The grid of step 1 of an attribute that has wide integers in the stream and floats in glTF. No grid if it has
// not, or if the numbers need more than 24 bits.
AttributeCoding grid_of_integers(const StreamDescription& stream, uint32_t unique_id,
                                 const Attribute& attribute) {
  const auto found = std::ranges::find(stream.attributes, unique_id, &StreamAttribute::unique_id);
  if (found == stream.attributes.end() || !is_wide_integer(found->type) || found->normalized) return {};
  constexpr int kAllBits = 24;
  return fit_whole_numbers(bounds_of(attribute, kAllBits)).value_or(AttributeCoding());
}

// Nothing if the primitive is plain, or cannot be described.
std::optional<DescribedPrimitive> description_of(const Document& document, PrimitiveId id,
                                                 const ThreadPool& pool) {
  if (document.records().primitive(id).storage() == PrimitiveStorage::kPlain) return std::nullopt;
  Expected<DescribedPrimitive> described = describe_primitive(document, id, describe_stream, pool);
  if (!described || described->streams.empty()) return std::nullopt;
  return std::move(*described);
}

// 0 bits if the streams do not agree.
AttributeCoding coding_of_all(const DescribedPrimitive& described, uint32_t unique_id) {
  const AttributeCoding grid = coding_of(described.streams.front(), unique_id);
  const bool is_one = std::ranges::all_of(described.streams, [&](const StreamDescription& stream) {
    return is_same_grid(grid, coding_of(stream, unique_id));
  });
  return is_one ? grid : AttributeCoding();
}

}  // namespace

bool is_same_grid(const AttributeCoding& a, const AttributeCoding& b) {
  return a.bits == b.bits && a.octahedral == b.octahedral && a.origin == b.origin && a.range == b.range;
}

std::vector<AttributeCoding> stated_grids(const Document& document, PrimitiveId id,
                                          const std::vector<Attribute>& attributes, const ThreadPool& pool) {
  std::vector<AttributeCoding> grids(attributes.size());
  const std::optional<DescribedPrimitive> described = description_of(document, id, pool);
  if (!described) return grids;
  for (const AttributeRequest& request : described->requests) {
    const auto found = std::ranges::find(attributes, request.semantic, &Attribute::semantic);
    if (found == attributes.end() || found->component_type != ComponentType::kFloat32) continue;
    AttributeCoding grid = coding_of_all(*described, request.unique_id);
    if (grid.bits == 0) grid = grid_of_integers(described->streams.front(), request.unique_id, *found);
    grids[static_cast<size_t>(found - attributes.begin())] = std::move(grid);
  }
  return grids;
}

StatedGrids all_stated_grids(const Document& document, const ThreadPool& pool) {
  StatedGrids grids;
  for (const PrimitiveId id : all_primitives(document)) {
    const std::optional<DescribedPrimitive> described = description_of(document, id, pool);
    if (!described) continue;
    for (const AttributeRequest& request : described->requests)
      grids[id][request.semantic] = coding_of_all(*described, request.unique_id);
  }
  return grids;
}

}  // namespace psplit
