// Plans a batch and launches it on a device: what a CUDA device (cuda_device.cuh) and its emulation in the
// tests have in common. A Device has
//
//   Array<T>                     memory of its own that grows and is kept: reserve(count), data()
//   HostArray<T>                 the same of the host, which copies to the device do not wait for
//   upload(to, from, count)      from the host
//   download(to, from, count)
//   launch_threads(count, body)  body(i) for each i below count
//   launch_warps(count, body)    body(lanes, i), with the lanes of a warp
//   mark(stage)                  what follows belongs to a stage, for those who measure
//   wait()                       until all that was asked for is done
//   free_memory()                bytes that it has left
//
// which are in order, and may return before they are done, but for wait. Those that can fail return a Status.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "decoder_cuda/batch.h"
#include "src/container/claims.h"
#include "src/container/stream_description.h"

namespace psplit {

// One primitive of a batch, or some of its patches. Targets and indices are memory of the device.
//
// Stitched, patches [first, end) have the faces and the points of the mesh that the directory gives them, a
// window of it: targets start at the first point that patch `first` owns, indices are the mesh's. Patches that
// these refer to are decoded as well, but not written. Otherwise every patch has the points that it decodes to,
// references included: points of patch after patch, indices counting from the first point of all. A residue is
// one more patch.
struct BatchPrimitive {
  std::span<const uint8_t> bytes;         // of the container
  const uint8_t* device_bytes = nullptr;  // the same on the device, or null
  const Container* container = nullptr;   // parsed from them; a stock stream is container_of_stream
  const std::vector<core::StreamHeader>* headers = nullptr;  // of check_claims
  bool is_stream = false;
  std::vector<AttributeTarget> targets{};
  void* indices = nullptr;
  uint32_t index_bytes = 4;  // 2 or 4
  bool is_stitched = true;
  uint32_t first = 0, end = 0xffffffff;
  // On the device, or null, where patches are not stitched: least and most of the first target's three floats,
  // six for each patch.
  float* bounds = nullptr;
};

// How streams of one width are launched. What is more than was foreseen is done at the end, slowly.
struct LaunchPlan {
  uint32_t runs = 0;    // of one stream between two stops
  uint32_t rounds = 0;  // from stop to stop
};

template <typename Index, typename Device>
Status launch_decoding(Device& device, const StreamSet<Index>& set, const LaunchPlan& plan) {
  if (set.count == 0) return {};
  device.mark("connectivity");
  if (Status status = device.launch_threads(set.count, BeginStreams<Index>{set}); !status.ok()) return status;
  for (uint32_t round = 0; round < plan.rounds; ++round) {
    device.mark("steps");
    if (Status status = device.launch_threads(plan.runs * set.count, TakeRuns<Index>{set}); !status.ok())
      return status;
    device.mark("between steps");
    if (Status status = device.launch_warps(set.count, ResumeStreams<Index>{set, plan.runs}); !status.ok())
      return status;
  }
  device.mark("numbering");
  return device.launch_warps(set.count, FinishStreams<Index>{set});
}

template <typename Index, typename Device>
Status launch_writing(Device& device, const StreamSet<Index>& set) {
  if (set.count == 0) return {};
  device.mark("output");
  return device.launch_warps(set.count, WriteStreams<Index>{set});
}

// Not safe to share between threads. Its memory is kept from batch to batch.
template <typename Device>
class BatchDecoder {
 public:
  explicit BatchDecoder(Device device) : device_(std::move(device)) {}

  Device& device() { return device_; }

  // How much memory of the device it may take. Streams wait for their turn, results are the same. What all
  // streams need, compressed bytes and some bytes a point and a stream, is taken in any case, and so is what a
  // stream takes on its own.
  void set_memory_limit(uint64_t bytes) { memory_limit_ = bytes; }

  // Plans and launches; the containers' bytes must stay until finish. Errors: kRuntimeFailure where the device
  // fails, all others come from finish.
  Status start(std::span<const BatchPrimitive> primitives) {
    plan(primitives);
    Status status = send();
    if (status.ok()) status = launch();
    if (status.ok()) return status;
    streams_.clear();
    std::fill(statuses_.begin(), statuses_.end(), status);
    return status;
  }

  // Waits until all is written. The first error, with the primitive of the batch and the patch as its place:
  // kUsage for what cannot be asked for, kInvalidInput and kUnsupported for streams, kRuntimeFailure where the
  // device fails. What other streams decoded to is right all the same, but for faces that share a point with
  // the broken one; indices are below the number of points in any case.
  Status finish() {
    Status status = finish_streams();
    if (!status.ok()) std::fill(statuses_.begin(), statuses_.end(), status);
    for (const Status& each : statuses_)
      if (!each.ok()) return each;
    return {};
  }

  // Of a primitive of the batch, after finish.
  const Status& status(size_t primitive) const { return statuses_[primitive]; }
  // How many points a stock stream has, after finish.
  uint32_t point_count(size_t primitive) const { return point_counts_[primitives_[primitive].first_stream]; }

 private:
  enum class Size : uint8_t { kNarrow, kWide };
  struct Width {
    std::vector<uint32_t> streams;
    LaunchPlan launches;
    const uint32_t* device_streams = nullptr;

    template <typename Index>
    StreamSet<Index> part(const Batch& batch, size_t first, size_t end) const {
      return {batch, device_streams + first, static_cast<uint32_t>(end - first)};
    }
  };
  // Streams that are decoded at once: up to these of each width, from where the part before ended.
  struct Part {
    size_t first_narrow = 0, narrow_end = 0, first_wide = 0, wide_end = 0;
  };
  // Where the device has a container's bytes: the caller's, or a place in the block.
  struct Source {
    std::span<const uint8_t> bytes;
    const uint8_t* on_device = nullptr;
    size_t block_at = 0;
  };

  // ---- planning

  void plan(std::span<const BatchPrimitive> primitives) {
    primitives_.clear();
    targets_.clear();
    streams_.clear();
    sizes_.clear();
    sources_.clear();
    statuses_.assign(primitives.size(), Status());
    has_point_limits_ = false;
    narrow_.launches = wide_.launches = {};
    walk_points_ = stream_bytes_ = 0;
    for (size_t i = 0; i < primitives.size(); ++i) {
      statuses_[i] = check(primitives[i]).at({.primitive = static_cast<int64_t>(i)});
      if (statuses_[i].ok()) {
        plan(primitives[i]);
      } else {
        primitives_.push_back({});
        sources_.push_back({});
      }
    }
  }

  static uint32_t end_of(const BatchPrimitive& primitive) {
    return std::min(primitive.end, static_cast<uint32_t>(primitive.container->entries.size()));
  }

  static Status check(const BatchPrimitive& primitive) {
    const Container& container = *primitive.container;
    const uint32_t end = end_of(primitive);
    const auto refused = [](const char* message) { return Status(StatusCode::kUsage, message); };
    if (primitive.first > end) return refused("no such patches");
    uint64_t points = container.point_count();
    if (!primitive.is_stitched) {
      points = 0;
      for (uint32_t i = primitive.first; i < end; ++i) points += container.entries[i].point_count;
    }
    if (primitive.index_bytes != 2 && primitive.index_bytes != 4) return refused("indices take 2 or 4 bytes");
    if (points > (primitive.index_bytes == 2 ? 0xffffu : 0xfffffffeu))
      return refused("the indices do not tell so many points apart");
    for (const AttributeTarget& target : primitive.targets)
      if (target.stride < core::data_type_bytes(target.type) * target.components)
        return refused("values of an attribute that overlap");
    if (primitive.bounds != nullptr && primitive.is_stitched)
      return refused("patches that are stitched do not have all their points");
    if (primitive.bounds != nullptr &&
        (primitive.targets.empty() || primitive.targets[0].type != core::DataType::kFloat32 ||
         primitive.targets[0].components != 3))
      return refused("bounds are those of a first attribute of three floats");
    return {};
  }

  // Which streams must be decoded so that [first, end) can be written.
  static std::vector<StreamUse> uses_of(const BatchPrimitive& primitive) {
    const Container& container = *primitive.container;
    const uint32_t end = end_of(primitive);
    std::vector<StreamUse> uses(container.entries.size(), StreamUse::kNone);
    const auto refer_to = [&](uint32_t owner) {
      if (owner < primitive.first) uses[owner] = StreamUse::kReferredTo;
    };
    for (uint32_t i = primitive.first; i < end; ++i) {
      uses[i] = StreamUse::kWritten;
      if (!primitive.is_stitched || primitive.first == 0) continue;
      core::StitchReader reader({{container.stitch[i].data(), container.stitch[i].size()}, i});
      for (core::StitchReader::Run run; reader.next_run(run);) refer_to(run.owner);
      for (core::StitchReader::Pair pair; reader.next_pair(pair);) refer_to(pair.owner);
    }
    return uses;
  }

  void plan(const BatchPrimitive& primitive) {
    const Container& container = *primitive.container;
    const uint32_t first = primitive.first;
    const auto number = static_cast<uint32_t>(primitives_.size());
    const auto first_stream = static_cast<uint32_t>(streams_.size());
    const bool is_stitched = primitive.is_stitched;
    const bool has_walks = is_stitched && container.reference_count() > 0;
    has_point_limits_ |= primitive.is_stream;
    core::ValueCounts values{0, static_cast<uint32_t>(primitive.targets.size()), 0};
    for (const AttributeTarget& target : primitive.targets) values.components += target.components;
    sources_.push_back({primitive.bytes, primitive.device_bytes, 0});
    const std::vector<StreamUse> uses = uses_of(primitive);
    uint32_t next_point = 0;  // where they are not stitched
    for (uint32_t i = 0; i < uses.size(); ++i) {
      const StreamEntry& entry = container.entries[i];
      const core::StreamHeader& header = (*primitive.headers)[i];
      StreamTask task;
      task.use = uses[i];
      task.stream_at = static_cast<uint64_t>(container.streams[i].data() - primitive.bytes.data());
      if (!container.stitch[i].empty())
        task.stitch_at = static_cast<uint64_t>(container.stitch[i].data() - primitive.bytes.data());
      task.stream_bytes = entry.stream_bytes;
      task.stitch_bytes = entry.stitch_bytes;
      task.primitive = number;
      task.number = i;
      task.face_count = entry.face_count;
      task.point_count = entry.point_count;
      task.reference_count = entry.reference_count;
      task.face_base = container.face_base[i] - container.face_base[first];
      task.owned_base = is_stitched ? container.owned_base[i] : next_point;
      task.owned_end = is_stitched ? container.owned_base[i + 1] : next_point + entry.point_count;
      task.is_residue = i == container.patch_count();
      task.has_point_limit = primitive.is_stream;
      task.has_walk = has_walks;
      task.walk_at = walk_points_;
      if (task.use != StreamUse::kNone) {
        next_point += entry.point_count;
        stream_bytes_ += entry.stream_bytes;
        if (task.has_walk) walk_points_ += entry.point_count;
        values.points =
            primitive.is_stream ? std::min(core::likely_points(header), entry.point_count) : entry.point_count;
        if (header.fits_16_bits())
          foresee<uint16_t>(narrow_.launches, header, values, task);
        else
          foresee<uint32_t>(wide_.launches, header, values, task);
      }
      sizes_.push_back(header.fits_16_bits() ? Size::kNarrow : Size::kWide);
      streams_.push_back(task);
    }
    primitives_.push_back({.first_stream = first_stream,
                           .first_written = first_stream + first,
                           .first_target = static_cast<uint32_t>(targets_.size()),
                           .target_count = static_cast<uint32_t>(primitive.targets.size()),
                           .point_count = is_stitched ? container.point_count() : next_point,
                           .first_point = is_stitched ? container.owned_base[first] : 0,
                           .is_stitched = is_stitched,
                           .indices = primitive.indices,
                           .index_bytes = primitive.index_bytes,
                           .bounds = primitive.bounds});
    targets_.insert(targets_.end(), primitive.targets.begin(), primitive.targets.end());
  }

  // The memory that a stream needs, and how often it stops.
  template <typename Index>
  static void foresee(LaunchPlan& launches, const core::StreamHeader& header, core::ValueCounts values,
                      StreamTask& task) {
    // Streams may have attributes that nobody asked for: most have a table of their own.
    const uint32_t others = header.attribute_data_count >= values.attributes
                                ? header.attribute_data_count + 1 - values.attributes
                                : 0;
    values.attributes += others;
    values.components += 4 * others;
    const uint64_t needed =
        core::workspace_bytes<Index>(header, task.stream_bytes, values) + numbering_bytes(task);
    task.workspace_bytes = std::min(needed, core::justified_bytes(task.stream_bytes));
    const uint32_t lists = header.valence ? core::ValenceSymbols<Index>::kLists : 0;
    launches.runs = std::max({launches.runs, 2 * values.attributes, header.attribute_data_count, lists});
    // Tagged symbols stop once more each.
    launches.rounds =
        std::max(launches.rounds,
                 2 + values.attributes + (header.attribute_data_count > 0 ? 1 : 0) + (header.valence ? 1 : 0));
  }

  // Gives streams their memory, part after part: of the order of the streams, since references go back only.
  void arrange(uint64_t limit) {
    constexpr size_t kMostStreams = size_t{1} << 20;  // threads have 32-bit numbers
    narrow_.streams.clear();
    wide_.streams.clear();
    parts_ = {Part()};
    uint64_t used = 0;
    workspace_bytes_ = 0;
    for (uint32_t i = 0; i < streams_.size(); ++i) {
      StreamTask& task = streams_[i];
      if (task.use == StreamUse::kNone) continue;
      const bool is_wide = sizes_[i] == Size::kWide;
      const uint64_t bytes = (is_wide ? StreamState<uint32_t>::bytes() : StreamState<uint16_t>::bytes()) +
                             in_block(task.workspace_bytes);
      const Part last = parts_.back();
      const size_t count = last.narrow_end - last.first_narrow + last.wide_end - last.first_wide;
      if (count > 0 && (used + bytes > limit || count == kMostStreams)) {
        parts_.push_back({last.narrow_end, last.narrow_end, last.wide_end, last.wide_end});
        used = 0;
      }
      task.workspace_at = used;
      used += bytes;
      workspace_bytes_ = std::max(workspace_bytes_, used);
      (is_wide ? wide_ : narrow_).streams.push_back(i);
      parts_.back().narrow_end = narrow_.streams.size();
      parts_.back().wide_end = wide_.streams.size();
    }
    // Threads of a warp wait for the longest.
    const auto sort = [&](std::vector<uint32_t>& streams, size_t first, size_t end) {
      std::stable_sort(streams.begin() + static_cast<ptrdiff_t>(first),
                       streams.begin() + static_cast<ptrdiff_t>(end),
                       [&](uint32_t a, uint32_t b) { return streams_[a].face_count > streams_[b].face_count; });
    };
    for (const Part& part : parts_) {
      sort(narrow_.streams, part.first_narrow, part.narrow_end);
      sort(wide_.streams, part.first_wide, part.wide_end);
    }
  }

  // ---- the device

  // Tables, and containers that are not there yet, are one block, in one copy but for large containers, which
  // are copied from where they are.
  Status send() {
    constexpr size_t kLargeContainer = size_t{1} << 20;
    const size_t count = streams_.size();
    size_t size = 0;
    const auto place = [&](size_t bytes) {
      const size_t at = size;
      size += in_block(bytes);
      return at;
    };
    const size_t primitives_at = place(primitives_.size() * sizeof(PrimitiveTask));
    const size_t targets_at = place(targets_.size() * sizeof(AttributeTarget));
    const size_t streams_at = place(count * sizeof(StreamTask));
    const size_t lists_at = place(count * sizeof(uint32_t));  // narrow, then wide
    for (Source& source : sources_)
      if (source.on_device == nullptr && source.bytes.size() < kLargeContainer)
        source.block_at = place(source.bytes.size());
    const size_t copied = size;
    for (Source& source : sources_)
      if (source.on_device == nullptr && source.bytes.size() >= kLargeContainer)
        source.block_at = place(source.bytes.size());

    const uint64_t beside = size + count * (sizeof(core::View<uint32_t>) + 2 * sizeof(core::Fault) + 4) +
                            walk_points_ * sizeof(uint32_t);
    // Whatever streams claim, their bytes must justify it.
    arrange(std::min(memory_limit_ - std::min(memory_limit_, beside), core::justified_bytes(stream_bytes_)));

    device_.mark("upload");
    for (Status status :
         {device_block_.reserve(size), host_block_.reserve(copied), device_workspace_.reserve(workspace_bytes_),
          device_walks_.reserve(count), device_walk_numbers_.reserve(walk_points_),
          device_faults_.reserve(2 * count), device_point_counts_.reserve(count)})
      if (!status.ok()) return status;
    uint8_t* const block = device_block_.data();
    for (size_t i = 0; i < sources_.size(); ++i)
      primitives_[i].bytes =
          sources_[i].on_device != nullptr ? sources_[i].on_device : block + sources_[i].block_at;
    uint8_t* const host = host_block_.data();
    const auto copy = [&](size_t at, const auto& values) {
      if (values.size() > 0) std::memcpy(host + at, values.data(), values.size() * sizeof(values[0]));
    };
    copy(primitives_at, primitives_);
    copy(targets_at, targets_);
    copy(streams_at, streams_);
    copy(lists_at, narrow_.streams);
    copy(lists_at + narrow_.streams.size() * sizeof(uint32_t), wide_.streams);
    for (const Source& source : sources_)
      if (source.on_device == nullptr && source.bytes.size() < kLargeContainer)
        copy(source.block_at, source.bytes);
    if (Status status = device_.upload(block, host, copied); !status.ok()) return status;
    for (const Source& source : sources_)
      if (source.on_device == nullptr && source.bytes.size() >= kLargeContainer)
        if (Status status = device_.upload(block + source.block_at, source.bytes.data(), source.bytes.size());
            !status.ok())
          return status;

    narrow_.device_streams = reinterpret_cast<const uint32_t*>(block + lists_at);
    wide_.device_streams = narrow_.device_streams + narrow_.streams.size();
    batch_ = {.primitives = reinterpret_cast<const PrimitiveTask*>(block + primitives_at),
              .targets = reinterpret_cast<const AttributeTarget*>(block + targets_at),
              .streams = reinterpret_cast<const StreamTask*>(block + streams_at),
              .workspace = device_workspace_.data(),
              .walk_numbers = device_walk_numbers_.data(),
              .walks = device_walks_.data(),
              .faults = device_faults_.data(),
              .stitch_faults = device_faults_.data() + count,
              .point_counts = device_point_counts_.data()};
    return {};
  }

  Status launch() {
    for (const Part& part : parts_)
      if (Status status = launch(part); !status.ok()) return status;
    return {};
  }
  Status launch(const Part& part) {
    const auto narrow = narrow_.template part<uint16_t>(batch_, part.first_narrow, part.narrow_end);
    const auto wide = wide_.template part<uint32_t>(batch_, part.first_wide, part.wide_end);
    if (Status status = launch_decoding(device_, narrow, narrow_.launches); !status.ok()) return status;
    if (Status status = launch_decoding(device_, wide, wide_.launches); !status.ok()) return status;
    if (Status status = launch_writing(device_, narrow); !status.ok()) return status;
    return launch_writing(device_, wide);
  }

  Status finish_streams() {
    const size_t count = streams_.size();
    if (count == 0) return {};
    for (;;) {
      faults_.resize(2 * count);
      point_counts_.resize(count);
      device_.mark("faults");
      Status status = device_.download(faults_.data(), device_faults_.data(), faults_.size());
      if (status.ok() && has_point_limits_)
        status = device_.download(point_counts_.data(), device_point_counts_.data(), count);
      device_.mark("");
      if (status.ok()) status = device_.wait();
      if (!status.ok()) return status;
      if (!enlarge()) break;
      if (status = send(); status.ok()) status = launch();
      if (!status.ok()) return status;
    }
    for (size_t i = 0; i < count; ++i) {
      const StreamTask& task = streams_[i];
      if (task.use == StreamUse::kNone) continue;
      const core::Fault fault = faults_[i] != core::Fault::kNone ? faults_[i] : faults_[count + i];
      Status& status = statuses_[task.primitive];
      if (fault != core::Fault::kNone && status.ok())
        status = status_of(fault).at({.primitive = task.primitive, .patch = task.number});
    }
    return {};
  }

  // More memory for streams that had too little: they have attributes that nobody asked for. Whether there are
  // any that may have more.
  bool enlarge() {
    bool any = false;
    for (size_t i = 0; i < streams_.size(); ++i) {
      StreamTask& task = streams_[i];
      const uint64_t most = core::justified_bytes(task.stream_bytes);
      if (task.use == StreamUse::kNone || faults_[i] != core::Fault::kWorkspace || task.workspace_bytes == most)
        continue;
      task.workspace_bytes = std::min(4 * task.workspace_bytes, most);
      any = true;
    }
    return any;
  }

  static size_t in_block(size_t bytes) { return (bytes + 255) / 256 * 256; }

  Device device_;
  uint64_t memory_limit_ = ~uint64_t{0};
  std::vector<PrimitiveTask> primitives_;
  std::vector<AttributeTarget> targets_;
  std::vector<StreamTask> streams_;
  std::vector<Size> sizes_;  // by stream
  std::vector<Source> sources_;
  std::vector<Status> statuses_;     // by primitive
  std::vector<core::Fault> faults_;  // of decoding, then of stitching
  std::vector<uint32_t> point_counts_;
  std::vector<Part> parts_;
  bool has_point_limits_ = false;
  uint64_t workspace_bytes_ = 0, walk_points_ = 0, stream_bytes_ = 0;
  Batch batch_;
  Width narrow_, wide_;
  typename Device::template HostArray<uint8_t> host_block_;
  typename Device::template Array<uint8_t> device_block_, device_workspace_;
  typename Device::template Array<core::View<uint32_t>> device_walks_;
  typename Device::template Array<uint32_t> device_walk_numbers_, device_point_counts_;
  typename Device::template Array<core::Fault> device_faults_;
};

}  // namespace psplit
