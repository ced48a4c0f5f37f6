#include "encoder/stream/stream_steps.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <string>
#include <utility>

#include "encoder/stream/encode_stream.h"
#include "src/container/claims.h"
#include "src/core/border_walk.h"

namespace psplit {
namespace {

// Numbers below their count, equal where `numbers` are equal. There are fewer than 2^30.
std::vector<uint32_t> small_numbers(std::vector<uint32_t> numbers) {
  if (std::ranges::all_of(numbers, [&](uint32_t number) { return number < numbers.size(); })) return numbers;
  // For each number the first place that has it.
  constexpr uint32_t kEmpty = ~uint32_t{0}, kFactor = 2654435769u;  // Fibonacci hashing
  const size_t slot_count = std::bit_ceil(2 * numbers.size() + 2);
  const int shift = 32 - std::countr_zero(slot_count);
  std::vector<uint32_t> slots(slot_count, kEmpty), first(numbers.size());
  for (uint32_t i = 0; i < numbers.size(); ++i) {
    size_t at = numbers[i] * kFactor >> shift;
    while (slots[at] != kEmpty && numbers[slots[at]] != numbers[i]) at = (at + 1) & (slot_count - 1);
    if (slots[at] == kEmpty) slots[at] = i;
    first[i] = slots[at];
  }
  return first;
}

// Faces and points in the order of the stream.
void list_points(const EncodedConnectivity& connectivity, EncodedPatch& out) {
  const core::Patch<uint32_t>& patch = connectivity.patch;
  out.decoded.point_count = patch.point_count;
  out.decoded.faces.resize(patch.face_count);
  out.patch_point.resize(patch.point_count);
  for (uint32_t i = 0; i < patch.face_count; ++i)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t corner = 4 * i + k, point = patch.point_at[corner];
      out.decoded.faces[i][k] = point;
      out.patch_point[point] = connectivity.point_of_corner[corner];
    }
}

// The border, as a decoder walks it.
Status list_border(const EncodedConnectivity& connectivity, EncodedPatch& out) {
  const size_t size = core::border_walk_bytes<uint32_t>(connectivity.patch.point_count);
  const std::unique_ptr<uint8_t[]> memory(new uint8_t[size]);
  core::Arena arena(memory.get(), size);
  core::View<uint32_t> walk;
  if (const core::Fault fault = core::walk_border(connectivity.patch, arena, walk); fault != core::Fault::kNone)
    return status_of(fault);
  out.walk.assign(walk.data(), walk.data() + walk.size());
  return {};
}

// Decodes a stream whose mesh is known except for its values.
Status decode_values(const Mesh& mesh, EncodedPatch& out) {
  Expected<Mesh> decoded = decode_stream(mesh, out.bytes);
  if (!decoded) return decoded.status();
  if (decoded->point_count != out.decoded.point_count || decoded->faces != out.decoded.faces)
    return runtime_failure("an encoded stream decodes to another mesh");
  out.decoded = std::move(*decoded);
  return {};
}

}  // namespace

Expected<EncodedConnectivity> connect_patch(const WeldedMesh& welded, const PatchMesh& patch,
                                            const ConnectivityChoices& choices) {
  constexpr size_t kMostPoints = size_t{1} << 30;
  if (patch.points.size() > kMostPoints)
    return unsupported(std::to_string(patch.points.size()) + " points are too many for one stream");
  std::vector<std::vector<uint32_t>> values;
  for (const size_t i : attribute_order(*welded.mesh)) {
    if (!welded.has_own_seams(i)) continue;
    std::vector<uint32_t>& rows = values.emplace_back(patch.points.size());
    for (size_t p = 0; p < rows.size(); ++p) rows[p] = welded.value_of_point[i][patch.points[p]];
  }
  values[0] = small_numbers(std::move(values[0]));
  const std::vector<std::span<const uint32_t>> spans(values.begin(), values.end());
  return encode_connectivity({static_cast<uint32_t>(patch.points.size()), patch.faces, spans, patch.neighbours},
                             choices);
}

Expected<std::vector<uint8_t>> write_stream(EncodedConnectivity& connectivity, EncodedAttributes attributes,
                                            bool is_valence, int symbol_level) {
  const core::View<core::Group<uint32_t>> groups = connectivity.patch.groups;
  std::vector<uint8_t> has_seams;
  for (uint32_t group = 1; group < groups.size(); ++group) has_seams.push_back(groups[group].per_corner);
  DracoFields& fields = connectivity.fields;
  fields.skeleton = edgebreaker_skeleton(attributes.plans, is_valence, has_seams);
  fields.attributes = std::move(attributes.fields);
  fields.symbol_level = symbol_level;
  return write_fields(fields, &connectivity.table_bytes);
}

size_t table_bytes_of(std::span<const uint8_t> stream) {
  size_t bytes = 0;
  if (const Expected<DracoFields> fields = read_fields(stream))
    static_cast<void>(write_fields(*fields, &bytes));
  return bytes;
}

Expected<EncodedPatch> describe_stream(const WeldedMesh& welded, const EncodedConnectivity& connectivity,
                                       std::vector<uint8_t> bytes, bool with_values) {
  EncodedPatch out;
  out.bytes = std::move(bytes);
  out.table_bytes = connectivity.table_bytes;
  list_points(connectivity, out);
  // Streams with values are alone, and are not stitched.
  Status status = with_values ? decode_values(*welded.mesh, out) : list_border(connectivity, out);
  if (!status.ok()) return status;
  return out;
}

}  // namespace psplit
