// The host's plan of a batch: which streams are decoded, in which memory, in how many launches, and from which
// bytes of containers.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <span>
#include <vector>

#include "decoder_cuda/launch_plan.h"
#include "decoder_cuda/stream_bodies.h"
#include "psplit/cuda.h"
#include "psplit/decode.h"
#include "src/container/claims.h"
#include "src/container/stored_type.h"

namespace psplit {

// Must succeed before memory of the device is taken according to a container's counts.
inline Status check_container(const PatchContainer& container) {
  if (!container.refusal.ok()) return container.refusal;
  return container.is_stock ? check_claims(container) : Status();
}

class BatchPlan {
 public:
  enum class Size : uint8_t { kNarrow, kWide };
  struct Width {
    std::vector<uint32_t> streams;  // part after part
    LaunchPlan draco, condensed;
  };
  // A range of the streams of a width: first Draco streams, then condensed ones.
  struct Range {
    size_t first = 0, first_condensed = 0, end = 0;
  };
  // Streams that are decoded at once.
  struct Part {
    Range narrow, wide;
  };
  // The head of consecutive primitives.
  struct Head {
    const CondensedHead* head = nullptr;
    uint64_t at = 0;  // in head_bytes()
    size_t first_primitive = 0, primitive_end = 0;
  };
  // Bytes of containers that go to the device in one run, from where they are or gathered with other pieces.
  struct Piece {
    std::span<const uint8_t> bytes;
    uint64_t at = 0;  // in piece_bytes()
    bool is_gathered = false;
  };

  // Which pieces are gathered in pinned memory, so that copying them does not wait.
  enum class Gather : uint8_t { kSmallPieces, kAllPieces };

  // Returns a status for each primitive: an error for an impossible request. Meshes with many patches are
  // planned on the threads of `pool`, unless it is null.
  std::vector<Status> make(std::span<const CudaPrimitive> primitives, Gather which,
                           const ThreadPool* pool = nullptr) {
    *this = {};
    std::vector<Status> statuses;
    size_t stream_count = 0;
    for (size_t i = 0; i < primitives.size(); ++i) {
      statuses.push_back(check(primitives[i]).at({.primitive = static_cast<int64_t>(i)}));
      is_due_.push_back(statuses.back().ok());
      if (is_due_.back()) stream_count += end_of(primitives[i]);
    }
    streams_.reserve(stream_count);
    sizes_.reserve(stream_count);
    for (size_t i = 0; i < primitives.size(); ++i) {
      if (is_due_[i])
        add(primitives[i], pool);
      else
        primitives_.push_back({});
    }
    gather(which);
    return statuses;
  }

  // Gives memory to the streams that are due, part after part. A part takes at most `limit` bytes, unless it is
  // a single stream that needs more. Parts follow the order of the streams, since references only go back.
  void arrange(uint64_t limit) {
    constexpr size_t kMostStreams = size_t{1} << 20;
    static_assert(kMostStreams * LaunchPlan::kMostRuns < 0xffffffff, "threads have 32-bit numbers");
    narrow_.streams.clear();
    wide_.streams.clear();
    parts_ = {Part()};
    uint64_t used = 0;
    workspace_bytes_ = 0;
    for (uint32_t i = 0; i < streams_.size(); ++i) {
      StreamTask& task = streams_[i];
      if (!is_decoded(task.use) || !is_due_[task.primitive]) continue;
      const bool is_wide = sizes_[i] == Size::kWide;
      const uint64_t bytes = (is_wide ? StreamState<uint32_t>::bytes() : StreamState<uint16_t>::bytes()) +
                             in_block(task.workspace_bytes);
      const Part last = parts_.back();
      const size_t count = last.narrow.end - last.narrow.first + last.wide.end - last.wide.first;
      if (count > 0 && (used + bytes > limit || count == kMostStreams)) {
        parts_.push_back({{last.narrow.end, 0, last.narrow.end}, {last.wide.end, 0, last.wide.end}});
        used = 0;
      }
      task.workspace_at = used;
      used += bytes;
      workspace_bytes_ = std::max(workspace_bytes_, used);
      (is_wide ? wide_ : narrow_).streams.push_back(i);
      parts_.back().narrow.end = narrow_.streams.size();
      parts_.back().wide.end = wide_.streams.size();
    }
    // The threads of a warp wait for the longest, so neighbours should have similar sizes: the largest come
    // first, in classes of sizes. All Draco streams come before condensed ones.
    std::vector<uint32_t> unsorted;
    const auto sort = [&](std::vector<uint32_t>& all, Range& range) {
      constexpr uint32_t kClasses = 512;
      const std::span streams(all.data() + range.first, range.end - range.first);
      unsorted.assign(streams.begin(), streams.end());
      uint32_t most = 0;
      for (const uint32_t i : unsorted) most = std::max(most, streams_[i].face_count);
      const int shift = std::max(0, std::countl_zero(kClasses - 1) - std::countl_zero(most));
      const auto class_of = [&](uint32_t i) {
        return (is_condensed(i) ? kClasses : 0) + kClasses - 1 - (streams_[i].face_count >> shift);
      };
      std::array<uint32_t, 2 * kClasses + 1> first{};
      for (const uint32_t i : unsorted) ++first[class_of(i) + 1];
      std::partial_sum(first.begin(), first.end(), first.begin());
      range.first_condensed = range.first + first[kClasses];
      for (const uint32_t i : unsorted) streams[first[class_of(i)]++] = i;
    };
    for (Part& part : parts_) {
      sort(narrow_.streams, part.narrow);
      sort(wide_.streams, part.wide);
    }
  }

  // Gives more memory to streams that had too little: they have attributes that were not requested. Only their
  // primitives are due again, each as a whole, since streams refer to each other. Returns whether there are
  // any.
  bool enlarge(std::span<const core::Fault> faults) {
    is_due_.assign(primitives_.size(), false);
    bool any = false;
    for (size_t i = 0; i < streams_.size(); ++i) {
      StreamTask& task = streams_[i];
      const uint64_t most = core::justified_bytes(task.stream_bytes);
      if (faults[i] != core::Fault::kWorkspace || task.workspace_bytes == most) continue;
      task.workspace_bytes = std::min(4 * task.workspace_bytes, most);
      any = is_due_[task.primitive] = true;
    }
    return any;
  }

  // Adds the faults of streams to the statuses of their primitives: first the faults of decoding all streams,
  // then of stitching them. `shortage` is the status of a stream that needs more memory than it had.
  void add_faults(std::span<const core::Fault> faults, const Status& shortage,
                  std::span<Status> statuses) const {
    for (size_t i = 0; i < streams_.size(); ++i) {
      const StreamTask& task = streams_[i];
      const core::Fault fault = faults[i] != core::Fault::kNone ? faults[i] : faults[streams_.size() + i];
      Status& status = statuses[task.primitive];
      if (fault == core::Fault::kNone || !status.ok()) continue;
      const bool is_short = fault == core::Fault::kWorkspace && is_due_[task.primitive] && !shortage.ok();
      status = is_short ? shortage : status_of(fault);
      status = std::move(status).at({.primitive = task.primitive, .patch = task.number});
    }
  }

  // The number of points of a stock stream, which is the first of its primitive.
  uint32_t point_count(size_t primitive, std::span<const uint32_t> point_counts) const {
    const size_t stream = primitives_[primitive].first_stream;
    return stream < point_counts.size() ? point_counts[stream] : 0;
  }

  const std::vector<PrimitiveTask>& primitives() const { return primitives_; }
  const std::vector<AttributeTarget>& targets() const { return targets_; }
  const std::vector<StreamTask>& streams() const { return streams_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<BorderTask>& borders() const { return borders_; }
  const std::vector<int32_t>& known() const { return known_; }
  const std::vector<Head>& heads() const { return heads_; }
  const std::vector<Part>& parts() const { return parts_; }
  const Width& narrow() const { return narrow_; }
  const Width& wide() const { return wide_; }
  bool has_point_limits() const { return has_point_limits_; }
  uint64_t workspace_bytes() const { return workspace_bytes_; }
  uint64_t walk_points() const { return walk_points_; }
  uint64_t stream_bytes() const { return stream_bytes_; }
  uint64_t border_bytes() const { return border_bytes_; }
  uint64_t head_bytes() const { return head_bytes_; }
  uint64_t piece_bytes() const { return pieces_.empty() ? 0 : pieces_.back().at + pieces_.back().bytes.size(); }
  uint64_t gathered_bytes() const { return gathered_bytes_; }

  static uint64_t in_block(uint64_t bytes) { return (bytes + 255) / 256 * 256; }

 private:
  static uint32_t end_of(const CudaPrimitive& primitive) {
    return std::min(primitive.end, static_cast<uint32_t>(primitive.container->entries.size()));
  }

  bool is_condensed(uint32_t stream) const { return streams_[stream].skeleton_bytes > 0; }

  // Whole, and not only its border part.
  static bool is_decoded(StreamUse use) { return use >= StreamUse::kReferredTo; }
  static uint64_t border_bytes(const core::StreamHeader& header, const StreamEntry& entry) {
    const core::CondensedStream& stream = header.condensed;
    return BorderState::bytes(core::most_places(stream, entry.reference_count), stream.border_components,
                              stream.attribute_count);
  }

  static AttributeTarget target_of(const CudaAttribute& attribute) {
    return {.unique_id = attribute.unique_id,
            .type = stored_type(attribute.component_type),
            .components = attribute.component_count,
            .values = static_cast<uint8_t*>(attribute.values),
            .stride = attribute.stride,
            .grid = attribute.grid};
  }

  static Status check(const CudaPrimitive& primitive) {
    if (primitive.container == nullptr) return {StatusCode::kUsage, "no container"};
    const PatchContainer& container = *primitive.container;
    if (Status status = check_container(container); !status.ok()) return status;
    if (Status status = check_borders(container); !status.ok()) return status;
    const uint32_t first = primitive.first, end = end_of(primitive);
    const auto refused = [](const char* message) { return Status(StatusCode::kUsage, message); };
    const auto is_aligned = [](const void* at, size_t bytes) {
      return reinterpret_cast<uintptr_t>(at) % bytes == 0;
    };
    if (first > end) return refused("no such patches");
    uint64_t points = container.point_count(),
             written = container.owned_base[end] - container.owned_base[first];
    if (!primitive.is_stitched) {
      points = 0;
      for (uint32_t i = first; i < end; ++i) points += container.entries[i].point_count;
      written = points;
    }
    if (primitive.index_bytes != 2 && primitive.index_bytes != 4) return refused("indices take 2 or 4 bytes");
    if (points > (primitive.index_bytes == 2 ? 0xffffu : 0xfffffffeu))
      return refused("too many points for the size of the indices");
    if (primitive.indices == nullptr && container.face_base[end] > container.face_base[first])
      return refused("nowhere to write indices to");
    if (!is_aligned(primitive.indices, primitive.index_bytes)) return refused("indices that are not aligned");
    for (const CudaAttribute& attribute : primitive.attributes) {
      const AttributeTarget target = target_of(attribute);
      if (target.stride < core::data_type_bytes(target.type) * target.components)
        return refused("values of an attribute that overlap");
      if (target.values == nullptr && written > 0) return refused("nowhere to write an attribute's values to");
      if (!is_aligned(target.grid, sizeof(float))) return refused("a grid that is not aligned");
    }
    if (primitive.bounds == nullptr) return {};
    if (primitive.is_stitched) return refused("patches that are stitched do not have all their points");
    if (primitive.attributes.empty() || primitive.attributes[0].component_type != ComponentType::kFloat32 ||
        primitive.attributes[0].component_count != 3)
      return refused("bounds are those of a first attribute of three floats");
    if (!is_aligned(primitive.bounds, sizeof(float)) || !target_of(primitive.attributes[0]).is_aligned())
      return refused("bounds, or the floats that they are of, are not aligned");
    return {};
  }

  // Whether the bytes justify the memory for the values at borders.
  static Status check_borders(const PatchContainer& container) {
    uint64_t bytes = 0;
    for (size_t i = 0; container.has_borders() && i < container.entries.size(); ++i)
      bytes += border_bytes(container.headers[i], container.entries[i]);
    return status_of(bytes > core::justified_bytes(container.stream_bytes()) ? core::Fault::kWorkspace
                                                                             : core::Fault::kNone);
  }

  // The use of each stream below `end`, if [first, end) is written.
  static std::vector<StreamUse> uses_of(const CudaPrimitive& primitive) {
    const PatchContainer& container = *primitive.container;
    const uint32_t end = end_of(primitive);
    std::vector<StreamUse> uses(end, StreamUse::kNone);
    std::fill(uses.begin() + std::min(primitive.first, end), uses.end(), StreamUse::kWritten);
    if (primitive.first == 0) return uses;  // references only go back
    const auto refer_to = [&](uint32_t owner, StreamUse use) { uses[owner] = std::max(uses[owner], use); };
    for (uint32_t i = primitive.first; primitive.is_stitched && i < end; ++i) {
      core::StitchReader reader(container.stitch_row(i));
      for (core::StitchReader::Run run; reader.next_run(run);) refer_to(run.owner, StreamUse::kReferredTo);
      for (core::StitchReader::Pair pair; reader.next_pair(pair);) refer_to(pair.owner, StreamUse::kReferredTo);
    }
    for (uint32_t i = 0; container.has_borders() && i < end; ++i) {
      if (!is_decoded(uses[i])) continue;
      core::StitchReader reader(container.stitch_row(i));
      for (core::StitchReader::Run run; reader.next_run(run);) refer_to(run.owner, StreamUse::kBorder);
    }
    return uses;
  }

  // The launches for the streams of both widths.
  struct Launches {
    LaunchPlan narrow_draco, narrow_condensed, wide_draco, wide_condensed;

    LaunchPlan& of(Size size, bool is_condensed) {
      if (size == Size::kNarrow) return is_condensed ? narrow_condensed : narrow_draco;
      return is_condensed ? wide_condensed : wide_draco;
    }
  };

  void add(const CudaPrimitive& primitive, const ThreadPool* pool) {
    const PatchContainer& container = *primitive.container;
    const uint32_t first = primitive.first;
    const auto first_stream = static_cast<uint32_t>(streams_.size());
    const bool is_stitched = primitive.is_stitched;
    has_point_limits_ |= container.is_stock;
    if (container.condensed_count() > 0) add_head(*container.head);
    describe_streams(primitive, uses_of(primitive), pool);
    const std::span tasks = std::span(streams_).subspan(first_stream);
    uint32_t next_point = 0;  // of patches that are not stitched
    for (StreamTask& task : tasks) {
      const StreamEntry& entry = container.entries[task.number];
      task.owned_base = is_stitched ? container.owned_base[task.number] : next_point;
      task.owned_end = is_stitched ? container.owned_base[task.number + 1] : next_point + entry.point_count;
      task.walk_at = walk_points_;
      if (task.use != StreamUse::kNone && container.headers[task.number].is_condensed() &&
          container.has_borders())
        add_border(container, first_stream + task.number, task);
      if (!is_decoded(task.use)) continue;
      next_point += entry.point_count;
      stream_bytes_ += entry.stream_bytes;
      if (task.has_walk) walk_points_ += entry.point_count;
    }
    place_bytes(primitive, tasks);
    primitives_.push_back({.bytes = primitive.device_bytes,
                           .first_stream = first_stream,
                           .first_written = first_stream + first,
                           .first_target = static_cast<uint32_t>(targets_.size()),
                           .target_count = static_cast<uint32_t>(primitive.attributes.size()),
                           .point_count = is_stitched ? container.point_count() : next_point,
                           .first_point = is_stitched ? container.owned_base[first] : 0,
                           .is_stitched = is_stitched,
                           .indices = primitive.indices,
                           .index_bytes = primitive.index_bytes,
                           .bounds = primitive.bounds});
    for (const CudaAttribute& attribute : primitive.attributes) targets_.push_back(target_of(attribute));
  }

  // Adds a task for each stream of the primitive that is added, without what depends on the streams before it.
  void describe_streams(const CudaPrimitive& primitive, const std::vector<StreamUse>& uses,
                        const ThreadPool* pool) {
    constexpr size_t kStreamsOfTask = 2048;  // about a tenth of a millisecond
    const PatchContainer& container = *primitive.container;
    const size_t first_stream = streams_.size();
    core::ValueCounts values{0, static_cast<uint32_t>(primitive.attributes.size()), 0};
    for (const CudaAttribute& attribute : primitive.attributes) values.components += attribute.component_count;
    const StreamTask of_all{.primitive = static_cast<uint32_t>(primitives_.size()),
                            .has_walk = primitive.is_stitched && container.reference_count() > 0,
                            .has_point_limit = container.is_stock};
    streams_.resize(first_stream + uses.size(), of_all);
    sizes_.resize(streams_.size());
    std::vector<Launches> launches(uses.size() / kStreamsOfTask + 1);
    const auto describe = [&](size_t begin, size_t end) {
      Launches joined;
      for (size_t i = begin; i < end; ++i) {
        StreamTask& task = streams_[first_stream + i];
        task.use = uses[i];
        task.number = static_cast<uint32_t>(i);
        task.face_base = container.face_base[i] - container.face_base[primitive.first];
        describe_stream(container, task);
        const bool is_narrow = container.headers[i].fits_16_bits();
        const Size size = sizes_[first_stream + i] = is_narrow ? Size::kNarrow : Size::kWide;
        if (!is_decoded(task.use)) continue;
        LaunchPlan& plan = joined.of(size, container.headers[i].is_condensed());
        if (is_narrow)
          foresee<uint16_t>(container, values, task, plan);
        else
          foresee<uint32_t>(container, values, task, plan);
      }
      launches[begin / kStreamsOfTask] = joined;
    };
    if (pool != nullptr)
      pool->for_ranges(uses.size(), kStreamsOfTask, describe);
    else
      describe(0, uses.size());
    for (const Launches& each : launches) {
      narrow_.draco.join(each.narrow_draco);
      narrow_.condensed.join(each.narrow_condensed);
      wide_.draco.join(each.wide_draco);
      wide_.condensed.join(each.wide_condensed);
    }
  }
  static void describe_stream(const PatchContainer& container, StreamTask& task) {
    const StreamEntry& entry = container.entries[task.number];
    task.stream_bytes = entry.stream_bytes;
    task.stitch_bytes = entry.stitch_bytes;
    if (entry.is_condensed) {
      task.skeleton_at = skeleton_place(*container.head, entry.skeleton);
      task.skeleton_bytes = static_cast<uint32_t>(container.head->skeletons[entry.skeleton].size());
    }
    task.face_count = entry.face_count;
    task.point_count = entry.point_count;
    task.reference_count = entry.reference_count;
    task.is_residue = !container.headers[task.number].edgebreaker;
  }

  // The border of a stream. The header of a patch alone has the values at its border.
  void add_border(const PatchContainer& container, uint32_t stream, StreamTask& task) {
    const core::StreamHeader& header = container.headers[task.number];
    const StreamEntry& entry = container.entries[task.number];
    task.border_at = border_bytes_;
    border_bytes_ += border_bytes(header, entry);
    BorderTask& border = borders_.emplace_back();
    border.stream = stream;
    border.places = core::most_places(header.condensed, entry.reference_count);
    border.components = header.condensed.border_components;
    border.attributes = header.condensed.attribute_count;
    border.is_known = container.is_stock;
    if (!container.is_stock) return;
    const core::View<const int32_t> known = header.condensed.known;
    border.known_at = known_.size();
    border.known_count = static_cast<uint32_t>(known.size());
    known_.insert(known_.end(), known.data(), known.data() + known.size());
  }

  // The head of the primitive that is added. Windows of a mesh share it.
  void add_head(const CondensedHead& head) {
    const size_t primitive = primitives_.size();
    if (heads_.empty() || heads_.back().head != &head || heads_.back().primitive_end != primitive) {
      heads_.push_back({&head, head_bytes_, primitive});
      head_bytes_ += in_block(device_head_bytes(head));
    }
    heads_.back().primitive_end = primitive + 1;
  }

  // Places the bytes that streams in use are decoded from, and no others. So a mesh that is decoded window
  // after window is uploaded once.
  void place_bytes(const CudaPrimitive& primitive, std::span<StreamTask> tasks) {
    const auto place = [&](std::span<const uint8_t> bytes) -> uint64_t {
      if (bytes.empty()) return 0;
      if (primitive.device_bytes != nullptr)
        return static_cast<uint64_t>(bytes.data() - primitive.container->bytes.data());
      const uint64_t at = piece_bytes();
      if (!pieces_.empty() && pieces_.back().bytes.data() + pieces_.back().bytes.size() == bytes.data())
        pieces_.back().bytes = {pieces_.back().bytes.data(), pieces_.back().bytes.size() + bytes.size()};
      else
        pieces_.push_back({bytes, at});
      return at;
    };
    // In a container all stitch maps come first.
    for (StreamTask& task : tasks)
      if (task.use != StreamUse::kNone && (primitive.is_stitched || task.border_at != StreamTask::kNoBorder))
        task.stitch_at = place(primitive.container->stitch[task.number]);
    for (StreamTask& task : tasks)
      if (task.use != StreamUse::kNone) task.stream_at = place(primitive.container->streams[task.number]);
  }

  // Small pieces go in one copy, whose size the host can pin.
  void gather(Gather which) {
    constexpr size_t kLargePiece = size_t{1} << 20, kMostGathered = size_t{64} << 20;
    for (Piece& piece : pieces_) {
      const size_t bytes = piece.bytes.size();
      piece.is_gathered =
          which == Gather::kAllPieces || (bytes < kLargePiece && gathered_bytes_ + bytes <= kMostGathered);
      if (piece.is_gathered) gathered_bytes_ += bytes;
    }
  }

  // Estimates the memory that a stream needs, and the number of its stops.
  template <typename Index>
  static void foresee(const PatchContainer& container, core::ValueCounts values, StreamTask& task,
                      LaunchPlan& launches) {
    const core::StreamHeader& header = container.headers[task.number];
    values.points = container.likely_point_count(task.number);
    // Streams may have attributes that were not requested. Most of these have a table of their own.
    const uint32_t others = header.attribute_data_count >= values.attributes
                                ? header.attribute_data_count + 1 - values.attributes
                                : 0;
    values.attributes += others;
    values.components += 4 * others;
    const uint64_t needed =
        core::workspace_bytes<Index>(header, task.stream_bytes, values, numbering_bytes(task));
    task.workspace_bytes = std::min(needed, core::justified_bytes(task.stream_bytes));
    const uint32_t lists = header.valence ? core::ValenceSymbols<Index>::kLists : 0;
    const uint32_t runs = std::max({2 * values.attributes, header.attribute_data_count, lists});
    // A condensed stream has one stop for its symbols, and each attribute with tagged symbols of a Draco stream
    // stops once more.
    const bool is_condensed = header.is_condensed();
    const uint32_t chain_round =
        1 + (header.attribute_data_count > 0 ? 1 : 0) + (is_condensed || header.valence ? 1 : 0);
    const uint32_t rounds = chain_round + (is_condensed ? 1 : values.attributes);
    // A traversal for each attribute, and the symbols of the first one: those after tagged symbols come later.
    launches.join({.runs = std::min(runs, LaunchPlan::kMostRuns),
                   .rounds = std::min(rounds, LaunchPlan::kMostRounds),
                   .chain_round = chain_round,
                   .chains = is_condensed ? values.attributes : values.attributes + 1,
                   .has_steps = values.attributes > 1});
  }

  std::vector<PrimitiveTask> primitives_;  // `bytes` is null if they are uploaded as pieces
  std::vector<AttributeTarget> targets_;
  std::vector<StreamTask> streams_;
  std::vector<Size> sizes_;   // by stream
  std::vector<bool> is_due_;  // by primitive: whether its streams are to be decoded
  std::vector<Head> heads_;
  std::vector<BorderTask> borders_;
  std::vector<int32_t> known_;  // the values at the borders of patches alone
  std::vector<Piece> pieces_;
  std::vector<Part> parts_;
  Width narrow_, wide_;
  bool has_point_limits_ = false;
  uint64_t workspace_bytes_ = 0, walk_points_ = 0, stream_bytes_ = 0, head_bytes_ = 0, border_bytes_ = 0,
           gathered_bytes_ = 0;
};

}  // namespace psplit
