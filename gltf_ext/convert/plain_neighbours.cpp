#include "gltf_ext/convert/plain_neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/position_bits.h"
#include "gltf_ext/convert/replace_streams.h"
#include "gltf_ext/convert/stated_grids.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// Whether the values can be replaced: they are floats. What meshoptimizer compressed would grow.
bool may_move(const AssetRecords& records, const AccessorRecord& accessor) {
  if (accessor.has_view() && records.view(accessor.elements.view).meshopt) return false;
  return accessor.layout.component_type == ComponentType::kFloat32 && accessor.layout.component_count() == 3;
}

// Whether the box that the accessor states reaches into that of the grid; true if it states none.
bool meets(const Json& accessor, const AttributeCoding& grid) {
  const Json *least = array_field(accessor, "min"), *most = array_field(accessor, "max");
  if (least == nullptr || most == nullptr || least->size() != 3 || most->size() != 3) return true;
  for (size_t c = 0; c < 3; ++c) {
    if (!(*least)[c].is_number() || !(*most)[c].is_number()) return true;
    const double low = double{grid.origin[c]} - grid_step(grid),
                 high = low + double{grid.range} + 2 * grid_step(grid);
    if ((*most)[c].get<double>() < low || (*least)[c].get<double>() > high) return false;
  }
  return true;
}

// Rounds the values; returns whether one changes.
bool round_values(AccessorData& data, const AttributeCoding& grid) {
  bool changes = false;
  for (size_t i = 0; i < data.count; ++i) {
    std::array<float, 3> value, rounded;
    std::byte* const at = data.values.data() + i * sizeof value;
    std::memcpy(value.data(), at, sizeof value);
    if (!std::ranges::all_of(value, [](float v) { return std::isfinite(v); })) continue;
    rounded = value;
    round_to_grid(rounded, grid);
    changes = changes || rounded != value;
    std::memcpy(at, rounded.data(), sizeof rounded);
  }
  return changes;
}

// The positions that some primitives read from one accessor.
struct PlainPositions {
  std::vector<PrimitiveId> ids;
  const AttributeCoding* grid = nullptr;
};

// Collects changes while the document stays as it is, so that its records are read once.
class PlainRounder {
 public:
  explicit PlainRounder(const Document& document)
      : document_(document), replaceable_(replaceable_views(document)) {
    for_each_accessor_reference(document.json(), [&](const Json& index) {
      if (const auto number = integer_value(index)) ++users_[*number];
    });
    const std::vector<AccessorRecord>& accessors = document.records().accessors;
    for (size_t i = 0; i < accessors.size(); ++i)
      if (accessors[i].count > 0) accessors_of_[accessors[i].elements.view].push_back(static_cast<int64_t>(i));
  }

  Status round(int64_t index, const PlainPositions& positions) {
    Expected<AccessorData> data = read_accessor(document_, index);
    if (!data) return data.status();
    if (!round_values(*data, *positions.grid)) return {};
    if (positions.ids.size() == users_[index] && has_own_bytes(index))
      write(index, *data);
    else
      added_.emplace_back(positions.ids, std::move(*data));
    return {};
  }

  void apply(Document& document) const {
    for (const auto& [index, bounds] : bounds_) {
      Json& accessor = document.json()["accessors"][static_cast<size_t>(index)];
      for (const char* name : {"min", "max"}) accessor[name] = bounds[name];
    }
    for (const auto& [ids, data] : added_) {
      const int64_t added = append_accessor(document, data, kArrayBuffer, true);
      for (const PrimitiveId id : ids) primitive_json(document, id)["attributes"]["POSITION"] = added;
    }
    StreamReplacements replacements;
    for (const auto& [view, bytes] : views_) replacements[view] = bytes;
    if (!replacements.empty()) replace_streams(document, replacements);
  }

 private:
  uint64_t stride_of(const AccessorRecord& accessor) const {
    const uint32_t stated = document_.records().view(accessor.elements.view).stride;
    return stated > 0 ? stated : accessor.layout.stored_bytes();
  }
  uint64_t end_of(const AccessorRecord& accessor) const {
    return accessor.elements.offset + (accessor.count - uint64_t{1}) * stride_of(accessor) +
           accessor.layout.stored_bytes();
  }

  bool share_bytes(const AccessorRecord& a, const AccessorRecord& b) const {
    if (end_of(a) <= b.elements.offset || end_of(b) <= a.elements.offset) return false;
    const uint64_t stride = stride_of(a);
    if (stride_of(b) != stride) return true;
    const uint64_t at_a = a.elements.offset % stride, at_b = b.elements.offset % stride;
    const uint64_t end_a = at_a + a.layout.stored_bytes(), end_b = at_b + b.layout.stored_bytes();
    return (at_a < end_b && at_b < end_a) || end_a > stride + at_b || end_b > stride + at_a;
  }

  // Whether the elements are in a buffer view, and share no bytes with another accessor's elements.
  bool has_own_bytes(int64_t index) {
    const AssetRecords& records = document_.records();
    const AccessorRecord& own = records.accessor(index);
    if (!own.has_view() || own.sparse) return false;
    if (!replaceable_.contains(own.elements.view) || !buffer_view_bytes(document_, own.elements.view))
      return false;
    return std::ranges::none_of(accessors_of_[own.elements.view], [&](int64_t other) {
      return other != index && share_bytes(own, records.accessor(other));
    });
  }

  void write(int64_t index, const AccessorData& data) {
    const AccessorRecord& accessor = document_.records().accessor(index);
    const auto [found, is_new] = views_.try_emplace(accessor.elements.view);
    std::vector<uint8_t>& bytes = found->second;
    if (is_new) {
      const auto stored = buffer_view_bytes(document_, accessor.elements.view);
      bytes.assign(stored->begin(), stored->end());
    }
    const size_t width = accessor.layout.packed_bytes();
    for (size_t i = 0; i < data.count; ++i)
      std::memcpy(bytes.data() + accessor.elements.offset + i * stride_of(accessor),
                  data.values.data() + i * width, width);
    describe_decoded(bounds_[index] = Json::object(), data, true);
  }

  const Document& document_;
  const std::set<int64_t> replaceable_;
  std::map<int64_t, size_t> users_;
  std::map<int64_t, std::vector<int64_t>> accessors_of_;  // of each view
  std::map<int64_t, std::vector<uint8_t>> views_;         // their bytes with rounded values
  std::map<int64_t, Json> bounds_;                        // of accessors
  std::vector<std::pair<std::vector<PrimitiveId>, AccessorData>> added_;
};

}  // namespace

std::map<size_t, AttributeCoding> position_grids(std::span<EncodeJob> jobs, const GridGroups& groups) {
  std::map<size_t, AttributeCoding> grids;
  for (EncodeJob& job : jobs) {
    const AttributeCoding* coding = job.position_coding();
    if (coding == nullptr || coding->exact) continue;
    for (const PrimitiveId id : job.group.ids)
      if (const auto group = groups.of_mesh(id.mesh)) grids.emplace(*group, *coding);
  }
  return grids;
}

Status round_plain_neighbours(Document& output, std::span<const PrimitiveId> origins,
                              std::span<const EncodeJob> jobs, const GridGroups& groups,
                              const std::map<size_t, AttributeCoding>& grids, const ThreadPool& pool,
                              EncodeReports& reports) {
  if (grids.empty()) return {};
  std::set<PrimitiveId> encoded;
  for (const EncodeJob& job : jobs) encoded.insert(job.group.ids.begin(), job.group.ids.end());
  const Document& before = output;
  std::map<std::pair<int64_t, size_t>, PlainPositions> plain;  // by accessor and group
  const std::vector<PrimitiveId> all = all_primitives(before);
  for (size_t i = 0; i < all.size(); ++i) {
    const auto group = groups.of_mesh(origins[i].mesh);
    const auto found = group ? grids.find(*group) : grids.end();
    if (found == grids.end() || encoded.contains(origins[i])) continue;
    const PrimitiveRecord& primitive = before.records().primitive(all[i]);
    const int64_t index = primitive.accessor_of("POSITION");
    if (!primitive.status.ok() || index < 0 || before.records().accessor(index).count == 0) continue;
    const AttributeCoding& grid = found->second;
    if (!meets(before.json()["accessors"][static_cast<size_t>(index)], grid)) continue;
    const bool is_plain = primitive.storage() == PrimitiveStorage::kPlain;
    if (is_plain && may_move(before.records(), before.records().accessor(index))) {
      PlainPositions& positions = plain[{index, *group}];
      positions.grid = &grid;
      positions.ids.push_back(all[i]);
      continue;
    }
    const std::vector<Attribute> position{{"POSITION", ComponentType::kFloat32, 3, false, {}}};
    if (!is_plain && is_same_grid(stated_grids(before, all[i], position, pool)[0], grid)) continue;
    reports[origins[i]].warnings.push_back(
        "its positions stay, and those of the primitives beside it move by up to " +
        rounded_text(distance_bound(grid)) + ": surfaces that touch may come apart");
  }
  PlainRounder rounder(before);
  for (const auto& [at, positions] : plain) {
    // Values that are not there cannot be rounded, and nothing else reads them.
    Status status = rounder.round(at.first, positions);
    if (!status.ok() && status.code() != StatusCode::kUnsupported) return status;
  }
  rounder.apply(output);
  return {};
}

}  // namespace psplit
