#include "encoder/encode_parts.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "encoder/coding/grid_places.h"
#include "encoder/condensing/condense.h"
#include "encoder/encode_streams.h"
#include "encoder/growing_container.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/verify.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "psplit/decode.h"
#include "src/container/condensed_head.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "src/mesh/select_points.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

// A MeshPart whose data belong to someone else.
struct PartView {
  const Mesh& mesh;
  std::span<const uint32_t> shared_points, shared_numbers;

  explicit PartView(const Mesh& whole) : mesh(whole) {}
  PartView(const MeshPart& part)
      : mesh(part.mesh), shared_points(part.shared_points), shared_numbers(part.shared_numbers) {}
};

bool same_attributes(std::span<const AttributeRequest> requests, const Mesh& mesh) {
  return std::equal(requests.begin(), requests.end(), mesh.attributes.begin(), mesh.attributes.end(),
                    [](const AttributeRequest& request, const Attribute& attribute) {
                      return request.semantic == attribute.semantic &&
                             request.component_type == attribute.component_type &&
                             request.component_count == attribute.component_count &&
                             request.normalized == attribute.normalized;
                    });
}

Status check_shared_points(const PartView& part, uint32_t shared_count) {
  const std::span<const uint32_t> points = part.shared_points;
  if (points.size() != part.shared_numbers.size()) return invalid_input("shared points without numbers");
  for (size_t i = 0; i < points.size(); ++i)
    if (points[i] >= part.mesh.point_count || (i > 0 && points[i] <= points[i - 1]) ||
        part.shared_numbers[i] >= shared_count)
      return invalid_input("shared points that do not ascend, or that do not exist");
  return {};
}

void extend(const Attribute& attribute, uint32_t point_count, ValueBounds& bounds) {
  bounds.add(attribute.component_type, attribute.component_count, attribute.values.data(), point_count,
             attribute.stride());
}

// Some of the bytes of a spill.
class PieceOfSpill : public StoredBytes {
 public:
  PieceOfSpill(std::shared_ptr<Spill> spill, uint64_t begin, uint64_t size)
      : spill_(std::move(spill)), begin_(begin), size_(size) {}
  uint64_t size() const override { return size_; }
  Status read(uint64_t offset, Span<uint8_t> to) override { return spill_->read(begin_ + offset, to); }

 private:
  const std::shared_ptr<Spill> spill_;
  const uint64_t begin_, size_;
};

// Brings the bytes of a piece into memory.
Status load(EncodedPiece& piece) {
  if (piece.stored == nullptr) return {};
  piece.bytes.resize(static_cast<size_t>(piece.stored->size()));
  Status status = piece.stored->read(0, piece.bytes);
  piece.stored.reset();
  return status;
}

constexpr uint32_t kNoNumber = 0xffffffffu;

// For each point of the part its number among shared points, or kNoNumber.
std::vector<uint32_t> shared_numbers_of(const PartView& part) {
  std::vector<uint32_t> numbers(part.mesh.point_count, kNoNumber);
  for (size_t i = 0; i < part.shared_points.size(); ++i)
    numbers[part.shared_points[i]] = part.shared_numbers[i];
  return numbers;
}

// Whether patches can hold all of the part.
bool is_regular(const Mesh& mesh) {
  if (std::ranges::any_of(mesh.faces, repeats_a_point)) return false;
  const std::vector<uint8_t> is_used = used_points(mesh);
  return std::ranges::find(is_used, 0) == is_used.end();
}

// What patches cannot hold, of all parts of a container: faces that repeat an index, and points that no face
// uses. It becomes the last stream of the container, because a later patch may own its points.
struct Leftovers {
  MeshPart part;                   // shared points are in the order in which they came
  std::vector<PointOwner> owners;  // of each point, as far as they are known
  std::unordered_map<uint32_t, uint32_t> point_of_shared;

  // Adds the faces and points of `from`, whose point i is the point number_in_patches[i] of its patches.
  void add(const PartView& from, std::span<const uint32_t> number_in_patches,
           std::span<const PointOwner> owners_in_patches);

 private:
  uint32_t add_point(const Mesh& from, uint32_t point);
};

uint32_t Leftovers::add_point(const Mesh& from, uint32_t point) {
  for (size_t k = 0; k < from.attributes.size(); ++k) {
    const Attribute& a = from.attributes[k];
    if (k == part.mesh.attributes.size())
      part.mesh.attributes.push_back({a.semantic, a.component_type, a.component_count, a.normalized, {}});
    const auto value = a.values.begin() + static_cast<std::ptrdiff_t>(point * a.stride());
    Array<std::byte>& values = part.mesh.attributes[k].values;
    values.insert(values.end(), value, value + static_cast<std::ptrdiff_t>(a.stride()));
  }
  return part.mesh.point_count++;
}

void Leftovers::add(const PartView& from, std::span<const uint32_t> number_in_patches,
                    std::span<const PointOwner> owners_in_patches) {
  enum Use : uint8_t { kUnused, kInPatches, kInLeftovers };
  std::vector<uint8_t> use(from.mesh.point_count, kUnused);
  for (const auto& face : from.mesh.faces)
    for (const uint32_t point : face)
      use[point] = std::max<uint8_t>(use[point], repeats_a_point(face) ? kInLeftovers : kInPatches);
  const std::vector<uint32_t> shared = shared_numbers_of(from);
  std::vector<uint32_t> place(from.mesh.point_count, kNoNumber);
  for (uint32_t point = 0; point < from.mesh.point_count; ++point) {
    const bool is_shared = shared[point] != kNoNumber;
    if (use[point] == kInPatches || (use[point] == kUnused && is_shared)) continue;
    const auto known = is_shared ? point_of_shared.find(shared[point]) : point_of_shared.end();
    if (known != point_of_shared.end()) {
      place[point] = known->second;
      continue;
    }
    place[point] = add_point(from.mesh, point);
    const uint32_t number = number_in_patches[point];
    owners.push_back(number == kNoNumber ? PointOwner() : owners_in_patches[number]);
    if (!is_shared) continue;
    point_of_shared[shared[point]] = place[point];
    part.shared_points.push_back(place[point]);
    part.shared_numbers.push_back(shared[point]);
  }
  for (const auto& face : from.mesh.faces)
    if (repeats_a_point(face)) part.mesh.faces.push_back({place[face[0]], place[face[1]], place[face[2]]});
}

// The part that is encoded, and the containers that have the parts before it.
class PartsEncoder {
 public:
  // Points and faces that a container must have room for, beside the appended ones.
  using Room = StreamEntry;

  // `keeps_meshes`: pieces are in memory, with what they decode to, and not in spills, with bounds.
  PartsEncoder(uint32_t shared_count, std::span<const AttributeCoding> codings, const PartsOptions& options,
               bool keeps_meshes, const MakeSpill& make_spill, const ThreadPool& pool)
      : codings_(codings),
        options_(options),
        keeps_meshes_(keeps_meshes),
        make_spill_(make_spill),
        pool_(pool),
        shared_owners_(shared_count) {}

  // Encodes one of several parts, and stores its streams.
  Status encode(const PartView& part);
  // Stores the streams of a part without leftovers, or of a whole mesh, and verifies them.
  Status store(const PartView& part, Streams streams, const Room& room);
  Status finish_container();
  uint64_t bytes() const { return bytes_; }  // of all streams and stitch maps
  EncodedMesh take() { return std::move(encoded_); }

 private:
  uint32_t stream_count() const {
    return container_ ? container_->stream_count() : static_cast<uint32_t>(encoded_.pieces.size());
  }
  Expected<Streams> encode_streams_of(const Mesh& mesh);
  Status append_alone(const PartView& part, Streams& streams);
  Status encode_with_leftovers(const PartView& part);
  Status encode_leftovers();
  bool is_full() const;
  Status condense();
  Expected<Mesh> decode_written();
  std::vector<PointOwner> known_owners(const PartView& part, std::vector<PointOwner> owners) const;
  Status append(const PartView& part, const Streams& streams, const Room& room);
  Expected<bool> append_if_there_is_room(const PartView& part, const Streams& streams,
                                         std::vector<PointOwner> owners, const Room& room);
  Status begin_container();
  Status spill(EncodedPiece& piece) const;
  Status check_written(const PartView& part);
  Status rename_points(Mesh& decoded);
  Status verify(const PartView& part, const Mesh& decoded);
  void add_boxes(const PartView& part, const Mesh& decoded);
  void count(const Streams& streams);

  const std::span<const AttributeCoding> codings_;
  const PartsOptions& options_;
  const bool keeps_meshes_;
  const MakeSpill& make_spill_;
  const ThreadPool& pool_;
  std::vector<PointOwner> shared_owners_;  // in the current container, by shared number
  std::optional<GrowingContainer> container_;
  std::optional<CondensedContainer> condensed_;  // instead of the current container, when all of it is there
  Leftovers leftovers_;                          // of the current container
  uint32_t unused_count_ = 0;                    // points of the current container that no face uses
  std::vector<ValueBounds> bounds_;              // of the current container
  std::vector<PatchBox> boxes_;                  // of its streams, if they are wanted
  std::shared_ptr<Spill> lone_;                  // the streams that are alone
  bool keeps_owners_ = false;                    // the part has leftovers
  std::vector<PointOwner> owners_;               // of the part's points
  // Points of the part that earlier parts own: the number in the container, the point of the part.
  std::vector<std::pair<uint32_t, uint32_t>> foreign_;
  std::vector<uint32_t> source_point_;  // the point of the part for each point that the part owns
  uint32_t first_stream_ = 0;           // of the part
  Mesh decoded_;                        // the whole mesh
  uint64_t bytes_ = 0;
  EncodedMesh encoded_;
};

Expected<Streams> PartsEncoder::encode_streams_of(const Mesh& mesh) {
  const ScopedStopwatch encode_time(encoded_.statistics.encode_ms);
  const uint64_t size = std::max<uint64_t>(1, options_.patch_faces);
  const auto patch_count = static_cast<uint32_t>(std::max<uint64_t>(1, (mesh.faces.size() + size / 2) / size));
  Expected<Streams> streams = encode_streams(mesh, codings_, options_.streams, patch_count, pool_);
  const Status status = streams.status();
  const int64_t patch = status.place().patch;
  if (patch >= 0) return Status(status.code(), status.message(), {.patch = stream_count() + patch});
  return streams;
}

Status PartsEncoder::begin_container() {
  Expected<GrowingContainer> container = GrowingContainer::begin(make_spill_);
  if (!container) return container.status();
  container_.emplace(std::move(*container));
  bounds_.assign(codings_.size(), {});
  boxes_.clear();
  unused_count_ = 0;
  std::fill(shared_owners_.begin(), shared_owners_.end(), PointOwner());
  return {};
}

Status PartsEncoder::finish_container() {
  if (leftovers_.part.mesh.point_count > 0)
    if (Status status = encode_leftovers(); !status.ok()) return status;
  if (!container_) return {};
  if (Status status = container_->check_size(encoded_.requests); !status.ok())
    return runtime_failure("verification: " + status.to_string());
  EncodedPiece finished;
  finished.entries.assign(container_->entries().begin(), container_->entries().end());
  finished.point_count = container_->point_count();
  finished.used_point_count = finished.point_count - unused_count_;
  finished.face_count = container_->face_count();
  if (options_.streams.condense && !keeps_meshes_)
    if (Status status = condense(); !status.ok()) return status;
  const std::vector<uint8_t> boxes = write_boxes(boxes_);
  std::vector<uint8_t> boxes_in_head;
  if (!boxes.empty()) append_head_section(HeadSection::kBoxes, boxes, boxes_in_head);
  finished.head_bytes = static_cast<uint32_t>(boxes_in_head.size());
  if (condensed_) {
    if (!boxes.empty()) {
      const Expected<PatchContainer> opened = open_container(condensed_->bytes);
      if (!opened) return opened.status();
      condensed_->bytes = with_head_section(*opened, HeadSection::kBoxes, boxes);
    }
    finished.bytes = std::move(condensed_->bytes);
    finished.entries = std::move(condensed_->entries);
    finished.head_bytes += condensed_->head_bytes;
  } else {
    finished.stored = container_->finish(boxes_in_head);
  }
  if (Status status = keeps_meshes_ ? load(finished) : spill(finished); !status.ok()) return status;
  container_.reset();
  condensed_.reset();
  if (keeps_meshes_) {
    finished.decoded = std::move(decoded_);
    finished.source_point = std::move(source_point_);
  } else {
    for (ValueBounds& bounds : bounds_) bounds.finish();
    finished.bounds = std::move(bounds_);
  }
  encoded_.pieces.push_back(std::move(finished));
  return {};
}

// Brings the bytes of a piece out of memory.
Status PartsEncoder::spill(EncodedPiece& piece) const {
  if (piece.stored != nullptr) return {};
  Expected<std::unique_ptr<Spill>> spill = make_spill_();
  if (!spill) return spill.status();
  Status status = (*spill)->append(piece.bytes);
  piece.stored = std::move(*spill);
  piece.bytes = std::vector<uint8_t>();
  return status;
}

// Condenses the current container if that makes it smaller.
Status PartsEncoder::condense() {
  const Stopwatch encode_time;
  const Expected<GrowingContainer::Opened> opened = container_->open();
  if (!opened) return opened.status();
  const PatchContainer& plain = opened->container;
  condensed_ = condense_container(plain, container_->size(), options_.streams.condense_smallest, pool_);
  encoded_.statistics.encode_ms += encode_time.ms();
  // check_written verifies a mesh that is kept. Parts are verified, and not in memory any more.
  if (!condensed_ || keeps_meshes_ || !options_.streams.verify) return {};
  const ScopedStopwatch verify_time(encoded_.statistics.verify_ms);
  const Expected<Mesh> decoded = cpu_backend().decode(plain, encoded_.requests, pool_);
  if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
  return verify_condensed(condensed_->bytes, encoded_.requests, *decoded, pool_);
}

// `owners`, and the owners of shared points among earlier streams.
std::vector<PointOwner> PartsEncoder::known_owners(const PartView& part, std::vector<PointOwner> owners) const {
  owners.resize(part.mesh.point_count);
  for (size_t i = 0; i < part.shared_points.size(); ++i) {
    PointOwner& owner = owners[part.shared_points[i]];
    if (owner.stream == PointOwner::kNone) owner = shared_owners_[part.shared_numbers[i]];
  }
  return owners;
}

// Stitches the streams to earlier parts, and appends them.
Expected<bool> PartsEncoder::append_if_there_is_room(const PartView& part, const Streams& streams,
                                                     std::vector<PointOwner> owners, const Room& room) {
  owners = known_owners(part, std::move(owners));
  first_stream_ = container_->stream_count();
  Stitching stitching = build_stitching(streams.owned, first_stream_, owners, pool_);
  Expected<std::vector<StreamEntry>> entries = make_entries(streams, stitching);
  if (!entries) return entries.status();
  entries->push_back(room);
  if (!container_->has_room_for(*entries, options_.most_points)) return false;
  entries->pop_back();
  for (size_t i = 0; i < part.shared_points.size(); ++i)
    shared_owners_[part.shared_numbers[i]] = owners[part.shared_points[i]];
  foreign_.clear();
  for (uint32_t point = 0; point < owners.size(); ++point)
    if (owners[point].stream < first_stream_)
      foreign_.push_back({container_->first_point(owners[point].stream) + owners[point].rank, point});
  if (keeps_owners_) owners_ = std::move(owners);
  source_point_ = std::move(stitching.source_point);
  Status status = container_->append(*entries, stitching.maps, streams.bytes, streams.has_residue);
  if (!status.ok()) return status;
  for (size_t i = 0; i < streams.bytes.size(); ++i)
    bytes_ += stitching.maps[i].size() + streams.bytes[i].size();
  return true;
}

Status PartsEncoder::append(const PartView& part, const Streams& streams, const Room& room) {
  const ScopedStopwatch encode_time(encoded_.statistics.encode_ms);
  if (!container_)
    if (Status status = begin_container(); !status.ok()) return status;
  const Mesh& left = leftovers_.part.mesh;
  const Room all{.face_count = room.face_count + static_cast<uint32_t>(left.faces.size()),
                 .point_count = room.point_count + left.point_count};
  const Expected<bool> appended = append_if_there_is_room(part, streams, {}, all);
  if (!appended || *appended) return appended.status();
  if (container_->stream_count() > 0) {
    if (Status status = finish_container(); !status.ok()) return status;
    if (Status status = begin_container(); !status.ok()) return status;
    const Expected<bool> appended_to_next = append_if_there_is_room(part, streams, {}, room);
    if (!appended_to_next || *appended_to_next) return appended_to_next.status();
  }
  return unsupported("more points or faces than a container can hold");
}

// `decoded` names points by their numbers in the container. Renames them: the points that the part owns come
// first, then points that earlier parts own, in the order of foreign_. In a whole mesh, all numbers stay.
Status PartsEncoder::rename_points(Mesh& decoded) {
  std::sort(foreign_.begin(), foreign_.end());
  const uint32_t first_point = container_->first_point(first_stream_);
  for (auto& face : decoded.faces)
    for (uint32_t& number : face) {
      if (number >= first_point && number - first_point < decoded.point_count) {
        number -= first_point;
        continue;
      }
      const auto found = std::lower_bound(foreign_.begin(), foreign_.end(), std::pair(number, 0u));
      if (found == foreign_.end() || found->first != number)
        return runtime_failure("verification: a face came back with point " + std::to_string(number) +
                               ", which the part does not use");
      number = decoded.point_count + static_cast<uint32_t>(found - foreign_.begin());
    }
  return {};
}

Status PartsEncoder::verify(const PartView& part, const Mesh& decoded) {
  std::vector<uint32_t> source_point = source_point_;
  for (const auto& [number, point] : foreign_) source_point.push_back(point);
  return verify_mesh(part.mesh, codings_, decoded, source_point, static_cast<uint32_t>(foreign_.size()), false,
                     pool_, encoded_.statistics.position_error);
}

// Adds the boxes of the part's streams. The decoded positions of points that earlier parts own are not in
// memory, but they equal the input's positions on its grid.
void PartsEncoder::add_boxes(const PartView& part, const Mesh& decoded) {
  const Attribute* const positions = decoded.find("POSITION");
  constexpr uint8_t kAxes = 3;
  if (positions == nullptr || positions->component_count != kAxes) return;
  const size_t stride = positions->stride();
  const Attribute& input = *part.mesh.find("POSITION");
  const AttributeCoding& coding = codings_[static_cast<size_t>(&input - part.mesh.attributes.data())];
  Array<std::byte> foreign(foreign_.size() * stride);
  for (size_t i = 0; i < foreign_.size(); ++i) {
    std::byte* const to = foreign.data() + i * stride;
    std::memcpy(to, input.values.data() + foreign_[i].second * stride, stride);
    if (coding.bits == 0) continue;
    std::array<float, kAxes> value{};
    std::memcpy(value.data(), to, stride);
    round_to_grid(value, coding);
    std::memcpy(to, value.data(), stride);
  }
  const std::span<const StreamEntry> entries = container_->entries();
  StreamPlace place;
  for (uint32_t i = first_stream_; i < container_->stream_count(); ++i) {
    place.first_face = place.end_face;
    place.first_point = place.end_point;
    place.end_face += entries[i].face_count;
    place.end_point += entries[i].point_count - entries[i].reference_count;
    boxes_.push_back(box_of(
        place, positions->component_type, positions->normalized,
        [&](size_t corner) { return decoded.faces[corner / 3][corner % 3]; },
        [&](uint32_t point) {
          return point < decoded.point_count ? positions->values.data() + point * stride
                                             : foreign.data() + (point - decoded.point_count) * stride;
        }));
  }
}

// Decodes the part from what was written.
Expected<Mesh> PartsEncoder::decode_written() {
  if (!condensed_) return container_->decode_last(encoded_.requests, pool_);
  const Expected<PatchContainer> opened = open_container(condensed_->bytes);
  if (!opened) return opened.status();
  return cpu_backend().decode(*opened, encoded_.requests, pool_);
}

// Decodes the part, for the bounds and to verify it.
Status PartsEncoder::check_written(const PartView& part) {
  const ScopedStopwatch verify_time(encoded_.statistics.verify_ms);
  Expected<Mesh> decoded = decode_written();
  if (!decoded) {
    const Status status = decoded.status();
    if (status.code() == StatusCode::kIo) return status;
    return runtime_failure("verification: " + status.message(), status.place());
  }
  for (size_t i = 0; i < bounds_.size() && !keeps_meshes_; ++i)
    extend(decoded->attributes[i], decoded->point_count, bounds_[i]);
  if (options_.streams.verify || options_.streams.boxes)
    if (Status status = rename_points(*decoded); !status.ok()) return status;
  if (options_.streams.boxes) add_boxes(part, *decoded);
  Status status = options_.streams.verify ? verify(part, *decoded) : Status();
  if (keeps_meshes_) decoded_ = std::move(*decoded);
  return status;
}

Status PartsEncoder::store(const PartView& part, Streams streams, const Room& room) {
  const StreamOptions& options = options_.streams;
  if (encoded_.requests.empty()) encoded_.requests = stream_requests(part.mesh);
  count(streams);
  if (streams.are_alone(options.alone)) return append_alone(part, streams);
  if (Status status = append(part, streams, room); !status.ok()) return status;
  streams = Streams();
  if (keeps_meshes_ && options.condense)
    if (Status status = condense(); !status.ok()) return status;
  return check_written(part);
}

Status PartsEncoder::encode_with_leftovers(const PartView& part) {
  ReducedMesh reduced =
      reduce(part.mesh, {.keep_duplicates = true, .drop_degenerate = true, .drop_unused = true}, pool_);
  std::vector<uint32_t> number(part.mesh.point_count, kNoNumber);
  for (uint32_t i = 0; i < reduced.source_point.size(); ++i) number[reduced.source_point[i]] = i;
  MeshPart patches{std::move(reduced.mesh), {}, {}};
  for (size_t i = 0; i < part.shared_points.size(); ++i) {
    if (number[part.shared_points[i]] == kNoNumber) continue;
    patches.shared_points.push_back(number[part.shared_points[i]]);
    patches.shared_numbers.push_back(part.shared_numbers[i]);
  }
  keeps_owners_ = true;
  const Room room{.face_count = static_cast<uint32_t>(part.mesh.faces.size() - patches.mesh.faces.size()),
                  .point_count = part.mesh.point_count};
  if (!patches.mesh.faces.empty()) {
    Expected<Streams> streams = encode_streams_of(patches.mesh);
    if (!streams) return streams.status();
    if (Status status = store(patches, std::move(*streams), room); !status.ok()) return status;
  }
  leftovers_.add(part, number, owners_);
  keeps_owners_ = false;
  owners_ = std::vector<PointOwner>();
  return {};
}

// Whether the container should end, because its remaining work would not fit into memory.
bool PartsEncoder::is_full() const {
  const Mesh& left = leftovers_.part.mesh;
  if (left.point_count > options_.most_residue_points) return container_ || !left.faces.empty();
  return options_.streams.condense && container_ && container_->point_count() >= options_.condensed_points;
}

Status PartsEncoder::encode_leftovers() {
  if (!container_)
    if (Status status = begin_container(); !status.ok()) return status;
  Leftovers left = std::exchange(leftovers_, Leftovers());
  const Mesh& mesh = left.part.mesh;
  {
    const ScopedStopwatch encode_time(encoded_.statistics.encode_ms);
    left.owners = known_owners(left.part, std::move(left.owners));
    std::vector<uint8_t> is_in_patch;
    for (const PointOwner& owner : left.owners)
      is_in_patch.push_back(owner.stream == PointOwner::kNone ? 0 : 1);
    const std::vector<uint8_t> is_used = used_points(mesh);
    unused_count_ = static_cast<uint32_t>(std::count(is_used.begin(), is_used.end(), 0));
    std::vector<uint32_t> faces(mesh.faces.size());
    std::iota(faces.begin(), faces.end(), 0u);
    WeldedMesh welded = weld(mesh, pool_);
    separate_flat_faces(welded);
    Streams streams;
    Status status = append_residue(welded, faces, is_in_patch, codings_, options_.streams, false, streams);
    if (!status.ok()) return status;
    count(streams);
    const Expected<bool> appended = append_if_there_is_room(left.part, streams, std::move(left.owners), {});
    if (!appended) return appended.status();
    if (!*appended) return unsupported("more points or faces than a container can hold");
  }
  return check_written(left.part);
}

// Each stream of the part alone.
Status PartsEncoder::append_alone(const PartView& part, Streams& streams) {
  if (options_.streams.verify) {
    const ScopedStopwatch verify_time(encoded_.statistics.verify_ms);
    Status status = verify_alone(part.mesh, codings_, streams, pool_, encoded_.statistics.position_error);
    if (!status.ok()) return status;
  }
  const ScopedStopwatch encode_time(encoded_.statistics.encode_ms);
  std::vector<uint8_t> is_known(part.mesh.point_count, 0);
  for (size_t i = 0; i < part.shared_points.size(); ++i)
    is_known[part.shared_points[i]] =
        std::exchange(shared_owners_[part.shared_numbers[i]].stream, 0u) == PointOwner::kNone ? 0 : 1;
  const Expected<std::vector<StreamEntry>> entries = make_lone_entries(streams, std::move(is_known));
  if (!entries) return entries.status();
  if (!lone_ && !keeps_meshes_) {
    Expected<std::unique_ptr<Spill>> made = make_spill_();
    if (!made) return made.status();
    lone_ = std::move(*made);
  }
  for (size_t i = 0; i < entries->size(); ++i) {
    Mesh& decoded = streams.decoded[i];
    std::vector<uint8_t>& bytes = streams.bytes[i];
    EncodedPiece& alone = encoded_.pieces.emplace_back();
    alone.is_container = false;
    alone.entries = {(*entries)[i]};
    alone.point_count = alone.used_point_count = decoded.point_count;
    alone.face_count = static_cast<uint32_t>(decoded.faces.size());
    bytes_ += bytes.size();
    if (keeps_meshes_) {
      alone.bytes = std::move(bytes);
      alone.decoded = std::move(decoded);
      alone.source_point = std::move(streams.owned[i].points);
      continue;
    }
    alone.stored = std::make_shared<PieceOfSpill>(lone_, lone_->size(), bytes.size());
    if (Status status = lone_->append(bytes); !status.ok()) return status;
    alone.bounds.resize(codings_.size());
    for (size_t k = 0; k < codings_.size(); ++k) {
      extend(decoded.attributes[k], decoded.point_count, alone.bounds[k]);
      alone.bounds[k].finish();
    }
  }
  return {};
}

void PartsEncoder::count(const Streams& streams) {
  EncodeStatistics& statistics = encoded_.statistics;
  statistics.patch_count += streams.patch_count();
  statistics.residue_faces += streams.residue_face_count;
  statistics.residue_points += streams.residue_point_count;
  statistics.partition_ms += streams.partition_ms;
}

Status PartsEncoder::encode(const PartView& part) {
  if (Status status = check_mesh(part.mesh, codings_); !status.ok()) return status;
  const auto shared_count = static_cast<uint32_t>(shared_owners_.size());
  if (Status status = check_shared_points(part, shared_count); !status.ok()) return status;
  if (encoded_.requests.empty()) encoded_.requests = stream_requests(part.mesh);
  if (!same_attributes(encoded_.requests, part.mesh))
    return invalid_input("its attributes differ from those of part 0");
  // A residue is the last stream. So other parts may follow only if patches hold all of this one.
  Status status;
  if (options_.streams.alone == Alone::kAll || is_regular(part.mesh)) {
    Expected<Streams> streams = encode_streams_of(part.mesh);
    status = streams ? store(part, std::move(*streams), {}) : streams.status();
  } else {
    status = encode_with_leftovers(part);
  }
  return status.ok() && is_full() ? finish_container() : std::move(status);
}

Status in_part(uint32_t part, const Status& status) {
  return {status.code(), "part " + std::to_string(part) + ": " + status.message(), status.place()};
}

}  // namespace

Expected<EncodedMesh> encode_parts(MeshParts& parts, Span<const AttributeCoding> codings,
                                   const PartsOptions& options, const MakeSpill& make_spill,
                                   const ThreadPool& pool) {
  if (parts.part_count() == 0) return invalid_input("the mesh has no triangles");
  PartsOptions of_parts = options;
  if (of_parts.streams.alone == Alone::kWhole) of_parts.streams.alone = Alone::kNone;
  of_parts.streams.patch_of_face = {};
  PartsEncoder encoder(parts.shared_count(), codings, of_parts, false, make_spill, pool);
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

Expected<EncodedMesh> store_whole(const Mesh& mesh, Span<const AttributeCoding> codings,
                                  const StreamOptions& options, Streams streams, const ThreadPool& pool) {
  const PartsOptions as_parts{.streams = options};
  const MakeSpill make_spill = make_memory_spill;
  PartsEncoder encoder(0, codings, as_parts, true, make_spill, pool);
  Status status = encoder.store(PartView(mesh), std::move(streams), {});
  if (status.ok()) status = encoder.finish_container();
  if (!status.ok()) return status;
  return encoder.take();
}

}  // namespace psplit
