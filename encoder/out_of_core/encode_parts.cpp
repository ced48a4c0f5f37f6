#include "encoder/out_of_core/encode_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "encoder/draco/patch_stream.h"
#include "encoder/encode_streams.h"
#include "encoder/out_of_core/growing_container.h"
#include "encoder/verify.h"
#include "encoder/welding/weld.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

bool same_attributes(std::span<const AttributeRequest> requests, const Mesh& mesh) {
  return std::equal(requests.begin(), requests.end(), mesh.attributes.begin(), mesh.attributes.end(),
                    [](const AttributeRequest& request, const Attribute& attribute) {
                      return request.semantic == attribute.semantic &&
                             request.component_type == attribute.component_type &&
                             request.component_count == attribute.component_count &&
                             request.normalized == attribute.normalized;
                    });
}

Status check_shared_points(const MeshPart& part, uint32_t shared_count) {
  const std::vector<uint32_t>& points = part.shared_points;
  if (points.size() != part.shared_numbers.size()) return invalid_input("shared points without numbers");
  for (size_t i = 0; i < points.size(); ++i)
    if (points[i] >= part.mesh.point_count || (i > 0 && points[i] <= points[i - 1]) ||
        part.shared_numbers[i] >= shared_count)
      return invalid_input("shared points that do not ascend, or that do not exist");
  return {};
}

// Bounds that grow. The comparisons are those of accessors in memory (gltf_ext/primitive/accessors.cpp).
template <typename T>
void extend(const Attribute& attribute, uint32_t point_count, ValueBounds& bounds) {
  for (size_t component = 0; component < attribute.component_count; ++component) {
    double& least = bounds.least[component];
    double& most = bounds.most[component];
    for (size_t point = 0; point < point_count; ++point) {
      T value;
      std::memcpy(&value, &attribute.values[(point * attribute.component_count + component) * sizeof(T)],
                  sizeof(T));
      const auto number = static_cast<double>(value);
      if (!std::isfinite(number)) continue;
      least = std::min(least, number);
      most = std::max(most, number);
    }
  }
}

void extend(const Attribute& attribute, uint32_t point_count, ValueBounds& bounds) {
  if (bounds.least.empty()) {
    bounds.least.assign(attribute.component_count, std::numeric_limits<double>::infinity());
    bounds.most.assign(attribute.component_count, -std::numeric_limits<double>::infinity());
  }
  switch (attribute.component_type) {
    case ComponentType::kInt8: return extend<int8_t>(attribute, point_count, bounds);
    case ComponentType::kUint8: return extend<uint8_t>(attribute, point_count, bounds);
    case ComponentType::kInt16: return extend<int16_t>(attribute, point_count, bounds);
    case ComponentType::kUint16: return extend<uint16_t>(attribute, point_count, bounds);
    case ComponentType::kUint32: return extend<uint32_t>(attribute, point_count, bounds);
    case ComponentType::kFloat32: return extend<float>(attribute, point_count, bounds);
  }
}

// The part that is encoded, and the containers that have the parts before it.
class PartsEncoder {
 public:
  PartsEncoder(uint32_t shared_count, std::span<const AttributeCoding> codings, const PartsOptions& options,
               const MakeSpill& make_spill, const ThreadPool& pool)
      : codings_(codings),
        options_(options),
        make_spill_(make_spill),
        pool_(pool),
        shared_owners_(shared_count) {}

  Status encode(const MeshPart& part);
  Status finish_container();
  uint64_t bytes() const { return bytes_; }  // of all streams and stitch maps
  EncodedParts take() { return std::move(encoded_); }
  // Of the current container.
  uint32_t stream_count() const { return container_ ? container_->stream_count() : 0; }

 private:
  Expected<Streams> encode_streams(const Mesh& mesh);
  Status append(const MeshPart& part, const Streams& streams);
  Expected<bool> append_if_there_is_room(const MeshPart& part, const Streams& streams);
  Status begin_container();
  Status check_written(const MeshPart& part);
  Status verify(const MeshPart& part, Mesh& decoded) const;

  const std::span<const AttributeCoding> codings_;
  const PartsOptions& options_;
  const MakeSpill& make_spill_;
  const ThreadPool& pool_;
  std::vector<PointOwner> shared_owners_;  // in the current container, by shared number
  std::optional<GrowingContainer> container_;
  std::vector<ValueBounds> bounds_;     // of the current container
  std::vector<uint32_t> source_point_;  // the point of the part for each point that the part owns
  uint32_t first_stream_ = 0;           // of the part
  uint64_t bytes_ = 0;
  EncodedParts encoded_;
};

Expected<Streams> PartsEncoder::encode_streams(const Mesh& mesh) {
  WeldedMesh welded = weld(mesh, pool_);
  separate_flat_faces(welded);
  const Stopwatch partition_time;
  const uint64_t size = std::max<uint64_t>(1, options_.patch_faces);
  const auto patch_count = static_cast<uint32_t>(std::max<uint64_t>(1, (mesh.faces.size() + size / 2) / size));
  const Cut cut =
      cut_faces(welded, {patch_count, options_.refine, options_.method, options_.distance}, {}, pool_);
  encoded_.statistics.partition_ms += partition_time.ms();
  encoded_.statistics.patch_count += static_cast<uint32_t>(cut.patches.size());
  if (!cut.residue_faces.empty()) return invalid_input("a face repeats an index");
  EncodeOptions options;
  options.encode_speed = options_.encode_speed;
  options.patch_encoded = options_.patch_encoded;
  Streams streams;
  if (Status status = encode_patches(welded, cut, codings_, options, pool_, streams); !status.ok()) {
    const int64_t patch = status.place().patch;
    return Status(status.code(), status.message(), {.patch = patch < 0 ? patch : stream_count() + patch});
  }
  return streams;
}

Status PartsEncoder::begin_container() {
  Expected<GrowingContainer> container = GrowingContainer::begin(make_spill_);
  if (!container) return container.status();
  container_.emplace(std::move(*container));
  bounds_.assign(codings_.size(), {});
  std::fill(shared_owners_.begin(), shared_owners_.end(), PointOwner());
  return {};
}

Status PartsEncoder::finish_container() {
  if (Status status = container_->check_size(encoded_.requests); !status.ok())
    return runtime_failure("verification: " + status.to_string());
  for (ValueBounds& bounds : bounds_)
    for (size_t i = 0; i < bounds.least.size(); ++i)
      if (bounds.least[i] > bounds.most[i]) bounds.least[i] = bounds.most[i] = 0;
  PartsContainer& finished = encoded_.containers.emplace_back();
  finished.entries.assign(container_->entries().begin(), container_->entries().end());
  finished.point_count = container_->point_count();
  finished.face_count = container_->face_count();
  finished.bounds = std::move(bounds_);
  finished.bytes = container_->finish();
  container_.reset();
  return {};
}

// Stitches the streams to those of the parts before, and appends them.
Expected<bool> PartsEncoder::append_if_there_is_room(const MeshPart& part, const Streams& streams) {
  std::vector<PointOwner> owners(part.mesh.point_count);
  for (size_t i = 0; i < part.shared_points.size(); ++i)
    owners[part.shared_points[i]] = shared_owners_[part.shared_numbers[i]];
  first_stream_ = container_->stream_count();
  Stitching stitching = build_stitching(streams.owned, first_stream_, owners, pool_);
  for (const PointOwner& owner : owners)
    if (owner.stream == PointOwner::kNone) return invalid_input("a point is used by no face");
  const Expected<std::vector<StreamEntry>> entries = make_entries(streams, stitching);
  if (!entries) return entries.status();
  if (!container_->has_room_for(*entries, options_.most_points)) return false;
  for (size_t i = 0; i < part.shared_points.size(); ++i)
    shared_owners_[part.shared_numbers[i]] = owners[part.shared_points[i]];
  source_point_ = std::move(stitching.source_point);
  if (Status status = container_->append(*entries, stitching.maps, streams.bytes); !status.ok()) return status;
  for (size_t i = 0; i < streams.bytes.size(); ++i)
    bytes_ += stitching.maps[i].size() + streams.bytes[i].size();
  return true;
}

Status PartsEncoder::append(const MeshPart& part, const Streams& streams) {
  if (!container_)
    if (Status status = begin_container(); !status.ok()) return status;
  const Expected<bool> appended = append_if_there_is_room(part, streams);
  if (!appended || *appended) return appended.status();
  if (stream_count() > 0) {
    if (Status status = finish_container(); !status.ok()) return status;
    if (Status status = begin_container(); !status.ok()) return status;
    const Expected<bool> appended_to_next = append_if_there_is_room(part, streams);
    if (!appended_to_next || *appended_to_next) return appended_to_next.status();
  }
  return unsupported("more points or faces than a container can hold");
}

// `decoded` names points by their numbers in the container. Renames them first: the points that the part owns,
// then the points that earlier parts own.
Status PartsEncoder::verify(const MeshPart& part, Mesh& decoded) const {
  std::vector<std::pair<uint32_t, uint32_t>> foreign;  // the number in the container, the point of the part
  const uint32_t first_point = container_->first_point(first_stream_);
  for (size_t i = 0; i < part.shared_points.size(); ++i) {
    const PointOwner& owner = shared_owners_[part.shared_numbers[i]];
    if (owner.stream < first_stream_)
      foreign.push_back({container_->first_point(owner.stream) + owner.rank, part.shared_points[i]});
  }
  std::sort(foreign.begin(), foreign.end());
  std::vector<uint32_t> source_point = source_point_;
  for (const auto& [number, point] : foreign) source_point.push_back(point);
  for (auto& face : decoded.faces)
    for (uint32_t& number : face) {
      if (number >= first_point && number - first_point < decoded.point_count) {
        number -= first_point;
        continue;
      }
      const auto found = std::lower_bound(foreign.begin(), foreign.end(), std::pair(number, 0u));
      if (found == foreign.end() || found->first != number)
        return runtime_failure("verification: a face came back with point " + std::to_string(number) +
                               ", which the part does not use");
      number = decoded.point_count + static_cast<uint32_t>(found - foreign.begin());
    }
  return verify_decoded(part.mesh, codings_, decoded, source_point, static_cast<uint32_t>(foreign.size()));
}

// Decodes the part from the spills, for the bounds and to verify it.
Status PartsEncoder::check_written(const MeshPart& part) {
  Expected<Mesh> decoded = container_->decode_last(encoded_.requests, pool_);
  if (!decoded) {
    const Status status = decoded.status();
    if (status.code() == StatusCode::kIo) return status;
    return runtime_failure("verification: " + status.message(), status.place());
  }
  for (size_t i = 0; i < bounds_.size(); ++i) extend(decoded->attributes[i], decoded->point_count, bounds_[i]);
  if (!options_.verify) return {};
  if (Status status = verify(part, *decoded); !status.ok()) return status;
  std::optional<double>& error = encoded_.statistics.position_error;
  error = std::max(error.value_or(0), largest_distance(part.mesh, *decoded, source_point_));
  return {};
}

Status PartsEncoder::encode(const MeshPart& part) {
  if (Status status = check_mesh(part.mesh, codings_); !status.ok()) return status;
  const auto shared_count = static_cast<uint32_t>(shared_owners_.size());
  if (Status status = check_shared_points(part, shared_count); !status.ok()) return status;
  if (encoded_.requests.empty()) encoded_.requests = stream_requests(part.mesh);
  if (!same_attributes(encoded_.requests, part.mesh))
    return invalid_input("its attributes are not those of part 0");
  {
    const Stopwatch encode_time;
    const Expected<Streams> streams = encode_streams(part.mesh);
    if (!streams) return streams.status();
    if (Status status = append(part, *streams); !status.ok()) return status;
    encoded_.statistics.encode_ms += encode_time.ms();
  }
  const ScopedStopwatch verify_time(encoded_.statistics.verify_ms);
  return check_written(part);
}

Status in_part(uint32_t part, const Status& status) {
  return {status.code(), "part " + std::to_string(part) + ": " + status.message(), status.place()};
}

}  // namespace

Expected<EncodedParts> encode_parts(MeshParts& parts, std::span<const AttributeCoding> codings,
                                    const PartsOptions& options, const MakeSpill& make_spill,
                                    const ThreadPool& pool) {
  if (parts.part_count() == 0) return invalid_input("the mesh has no triangles");
  PartsEncoder encoder(parts.shared_count(), codings, options, make_spill, pool);
  for (uint32_t i = 0; i < parts.part_count(); ++i) {
    const Expected<MeshPart> part = parts.read(i);
    if (!part) return in_part(i, part.status());
    if (Status status = encoder.encode(*part); !status.ok()) return in_part(i, status);
    if (options.part_written)
      if (Status status = options.part_written(encoder.bytes()); !status.ok()) return status;
  }
  if (Status status = encoder.finish_container(); !status.ok()) return status;
  return encoder.take();
}

}  // namespace psplit
