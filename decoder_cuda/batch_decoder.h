// Plans a batch and launches it on a device: what a CUDA device (cuda_device.cuh) and its emulation in the
// tests have in common. A Device has
//
//   Array<T>                     memory of its own that grows and is kept: reserve(count), data()
//   upload(array, span)          to an array, that is large enough afterwards
//   download(out, data, count)
//   launch_threads(count, body)  body(i) for each i below count
//   launch_warps(count, body)    body(lanes, i), with the lanes of a warp
//   mark(stage)                  what follows belongs to a stage, for those who measure
//   wait()                       until all that was asked for is done
//
// which are in order, and may return before they are done, but for wait. Those that can fail return a Status.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "decoder_cuda/batch.h"
#include "src/container/claims.h"
#include "src/container/stream_description.h"

namespace psplit {

// One primitive of a batch, or some of its patches. Targets and indices are memory of the device, for as many
// faces and points as the directory counts.
//
// Stitched, points are those of the mesh, and there are all patches. Otherwise every patch has the points that
// it decodes to, references included: faces and points of patch after patch, from `first` to `end`, indices
// counting from the first point of all; a residue is one more patch.
struct BatchPrimitive {
  std::span<const uint8_t> bytes;        // of the container
  const Container* container = nullptr;  // parsed from them
  std::vector<AttributeTarget> targets;
  void* indices = nullptr;
  uint32_t index_bytes = 4;  // 2 or 4
  bool is_stitched = true;
  uint32_t first = 0, end = 0xffffffff;  // patches, if they are not stitched
  // On the device, or null: least and most of the first target's three floats, six for each patch.
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

  // How much memory of the device streams may take that are decoded at once; beside that there are the
  // compressed bytes, four bytes a point, four kilobytes a stream and what results take. Streams wait for their
  // turn, results are the same. A stream that takes more on its own is decoded all the same.
  void set_workspace_limit(uint64_t bytes) { workspace_limit_ = bytes; }

  // Plans and launches; the containers' bytes are no longer needed afterwards. Their claims are checked
  // (check_claims). Errors: kUsage for what cannot be asked for, kInvalidInput and kUnsupported for containers
  // and streams, with the primitive of the batch and the patch as the place, kRuntimeFailure where the device
  // fails.
  Status start(std::span<const BatchPrimitive> primitives) {
    Status status = plan_and_launch(primitives);
    if (!status.ok()) streams_.clear();
    return status;
  }

  // Waits until all is written. The first fault, with its place like start. What other streams decoded to is
  // right all the same, but for faces that share a point with the broken one; indices are below the number of
  // points in any case.
  Status finish() {
    for (;;) {
      faults_.resize(2 * streams_.size());
      device_.mark("faults");
      if (Status status = device_.download(faults_.data(), device_faults_.data(), faults_.size()); !status.ok())
        return status;
      device_.mark("");
      if (Status status = device_.wait(); !status.ok()) return status;
      if (!enlarge()) break;
      if (Status status = send(); !status.ok()) return status;
      if (Status status = launch(); !status.ok()) return status;
    }
    for (size_t i = 0; i < streams_.size(); ++i) {
      const core::Fault fault = faults_[i] != core::Fault::kNone ? faults_[i] : faults_[streams_.size() + i];
      if (fault != core::Fault::kNone)
        return status_of(fault).at({.primitive = streams_[i].primitive, .patch = streams_[i].number});
    }
    return {};
  }

 private:
  template <typename Index>
  struct Width {
    std::vector<uint32_t> streams;
    LaunchPlan launches;
    typename Device::template Array<uint32_t> device_streams;
    typename Device::template Array<StreamState<Index>> states;

    StreamSet<Index> part(const Batch& batch, size_t first, size_t end) const {
      return {batch, device_streams.data() + first, states.data(), static_cast<uint32_t>(end - first)};
    }
  };
  // Streams that are decoded at once: up to these of each width, from where the part before ended.
  struct Part {
    size_t first_narrow = 0, narrow_end = 0, first_wide = 0, wide_end = 0;
  };

  Status plan_and_launch(std::span<const BatchPrimitive> primitives) {
    if (Status status = plan(primitives); !status.ok()) return status;
    if (Status status = send(); !status.ok()) return status;
    return launch();
  }

  Status launch() {
    for (const Part& part : parts_)
      if (Status status = launch(part); !status.ok()) return status;
    return {};
  }
  Status launch(const Part& part) {
    const auto narrow = narrow_.part(batch_, part.first_narrow, part.narrow_end);
    const auto wide = wide_.part(batch_, part.first_wide, part.wide_end);
    if (Status status = launch_decoding(device_, narrow, narrow_.launches); !status.ok()) return status;
    if (Status status = launch_decoding(device_, wide, wide_.launches); !status.ok()) return status;
    if (Status status = launch_writing(device_, narrow); !status.ok()) return status;
    return launch_writing(device_, wide);
  }

  Status plan(std::span<const BatchPrimitive> primitives) {
    primitives_.clear();
    targets_.clear();
    streams_.clear();
    is_wide_.clear();
    compressed_.clear();
    narrow_.launches = wide_.launches = {};
    walk_points_ = 0;
    for (const BatchPrimitive& primitive : primitives) {
      Status status = plan(primitive);
      if (!status.ok()) return std::move(status).at({.primitive = static_cast<int64_t>(primitives_.size())});
    }
    return {};
  }

  // Gives streams their memory, part after part: of the order of the streams, since references go back only.
  void arrange() {
    constexpr size_t kMostStreams = size_t{1} << 20;  // threads have 32-bit numbers
    // Whatever streams claim, their bytes must justify it.
    const uint64_t limit = std::min(workspace_limit_, core::justified_bytes(compressed_.size()));
    narrow_.streams.clear();
    wide_.streams.clear();
    parts_ = {Part()};
    uint64_t used = 0;
    workspace_bytes_ = 0;
    for (uint32_t i = 0; i < streams_.size(); ++i) {
      StreamTask& task = streams_[i];
      const uint64_t bytes = (task.workspace_bytes + 255) / 256 * 256;
      const Part last = parts_.back();
      const size_t count = last.narrow_end - last.first_narrow + last.wide_end - last.first_wide;
      if (count > 0 && (used + bytes > limit || count == kMostStreams)) {
        parts_.push_back({last.narrow_end, last.narrow_end, last.wide_end, last.wide_end});
        used = 0;
      }
      task.workspace_at = used;
      used += bytes;
      workspace_bytes_ = std::max(workspace_bytes_, used);
      (is_wide_[i] ? wide_.streams : narrow_.streams).push_back(i);
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

  // More memory for streams that had too little: they have attributes that nobody asked for. Whether there are
  // any that may have more.
  bool enlarge() {
    bool any = false;
    for (size_t i = 0; i < streams_.size(); ++i) {
      StreamTask& task = streams_[i];
      const uint64_t most = core::justified_bytes(task.stream_bytes);
      if (faults_[i] != core::Fault::kWorkspace || task.workspace_bytes == most) continue;
      task.workspace_bytes = std::min(4 * task.workspace_bytes, most);
      any = true;
    }
    return any;
  }

  Status plan(const BatchPrimitive& primitive) {
    const Container& container = *primitive.container;
    const Expected<std::vector<core::StreamHeader>> headers = check_claims(container);
    if (!headers) return headers.status();
    const auto count = static_cast<uint32_t>(container.entries.size());
    const uint32_t first = primitive.first, end = std::min(primitive.end, count);
    if (primitive.is_stitched ? first != 0 || end != count : first > end)
      return Status(StatusCode::kUsage, "patches that are stitched are all patches");
    uint64_t points = container.point_count();
    if (!primitive.is_stitched) {
      points = 0;
      for (uint32_t i = first; i < end; ++i) points += container.entries[i].point_count;
    }
    if (primitive.index_bytes != 2 && primitive.index_bytes != 4)
      return Status(StatusCode::kUsage, "indices take 2 or 4 bytes");
    if (points > (primitive.index_bytes == 2 ? 0xffffu : 0xfffffffeu))
      return Status(StatusCode::kUsage, "the indices do not tell so many points apart");
    for (const AttributeTarget& target : primitive.targets)
      if (target.stride < core::data_type_bytes(target.type) * target.components)
        return Status(StatusCode::kUsage, "values of an attribute that overlap");
    if (primitive.bounds != nullptr && primitive.is_stitched)
      return Status(StatusCode::kUsage, "patches that are stitched do not have all their points");
    if (primitive.bounds != nullptr &&
        (primitive.targets.empty() || primitive.targets[0].type != core::DataType::kFloat32 ||
         primitive.targets[0].components != 3))
      return Status(StatusCode::kUsage, "bounds are those of a first attribute of three floats");
    const auto number = static_cast<uint32_t>(primitives_.size());
    primitives_.push_back({.first_stream = static_cast<uint32_t>(streams_.size()),
                           .first_target = static_cast<uint32_t>(targets_.size()),
                           .target_count = static_cast<uint32_t>(primitive.targets.size()),
                           .point_count = static_cast<uint32_t>(points),
                           .is_stitched = primitive.is_stitched,
                           .indices = primitive.indices,
                           .index_bytes = primitive.index_bytes,
                           .bounds = primitive.bounds});
    targets_.insert(targets_.end(), primitive.targets.begin(), primitive.targets.end());
    core::ValueCounts values{0, static_cast<uint32_t>(primitive.targets.size()), 0};
    for (const AttributeTarget& target : primitive.targets) values.components += target.components;

    const uint64_t base = compressed_.size();
    compressed_.insert(compressed_.end(), primitive.bytes.begin(), primitive.bytes.end());
    const auto place_of = [&](std::span<const uint8_t> part) {
      return base + static_cast<uint64_t>(part.data() - primitive.bytes.data());
    };
    uint32_t next_face = 0, next_point = 0;
    for (uint32_t i = first; i < end; ++i) {
      const StreamEntry& entry = container.entries[i];
      StreamTask task;
      task.stream_at = place_of(container.streams[i]);
      task.stitch_at = container.stitch[i].empty() ? base : place_of(container.stitch[i]);
      task.stream_bytes = entry.stream_bytes;
      task.stitch_bytes = entry.stitch_bytes;
      task.primitive = number;
      task.number = i;
      task.face_count = entry.face_count;
      task.point_count = entry.point_count;
      task.reference_count = entry.reference_count;
      task.face_base = next_face;
      next_face += entry.face_count;
      task.owned_base = next_point;
      next_point += entry.point_count - (primitive.is_stitched ? entry.reference_count : 0);
      task.owned_end = next_point;
      task.is_residue = i == container.patch_count();
      task.has_walk = primitive.is_stitched && container.reference_count() > 0;
      task.walk_at = walk_points_;
      if (task.has_walk) walk_points_ += entry.point_count;
      const core::StreamHeader& header = (*headers)[i];
      values.points = entry.point_count;
      is_wide_.push_back(!header.fits_16_bits());
      if (is_wide_.back())
        foresee<uint32_t>(wide_.launches, header, values, task);
      else
        foresee<uint16_t>(narrow_.launches, header, values, task);
      streams_.push_back(task);
    }
    return {};
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

  Status send() {
    arrange();
    device_.mark("upload");
    const size_t count = streams_.size();
    for (Status status : {device_.upload(device_compressed_, std::span<const uint8_t>(compressed_)),
                          device_.upload(device_primitives_, std::span<const PrimitiveTask>(primitives_)),
                          device_.upload(device_targets_, std::span<const AttributeTarget>(targets_)),
                          device_.upload(device_streams_, std::span<const StreamTask>(streams_)),
                          device_workspace_.reserve(workspace_bytes_), device_walks_.reserve(count),
                          device_walk_numbers_.reserve(walk_points_), device_faults_.reserve(2 * count)})
      if (!status.ok()) return status;
    batch_ = {device_compressed_.data(), device_primitives_.data(), device_targets_.data(),
              device_streams_.data(),    device_workspace_.data(),  device_walk_numbers_.data(),
              device_walks_.data(),      device_faults_.data(),     device_faults_.data() + count};
    size_t narrow = 0, wide = 0;  // most in one part
    for (const Part& part : parts_) {
      narrow = std::max(narrow, part.narrow_end - part.first_narrow);
      wide = std::max(wide, part.wide_end - part.first_wide);
    }
    if (Status status = send(narrow_, narrow); !status.ok()) return status;
    return send(wide_, wide);
  }
  template <typename Index>
  Status send(Width<Index>& width, size_t most_states) {
    Status status = device_.upload(width.device_streams, std::span<const uint32_t>(width.streams));
    return status.ok() ? width.states.reserve(most_states) : status;
  }

  Device device_;
  std::vector<PrimitiveTask> primitives_;
  std::vector<AttributeTarget> targets_;
  std::vector<StreamTask> streams_;
  std::vector<bool> is_wide_;  // by stream
  std::vector<uint8_t> compressed_;
  std::vector<core::Fault> faults_;  // of decoding, then of stitching
  std::vector<Part> parts_;
  uint64_t workspace_limit_ = ~uint64_t{0};
  uint64_t workspace_bytes_ = 0, walk_points_ = 0;
  Batch batch_;
  Width<uint16_t> narrow_;
  Width<uint32_t> wide_;
  typename Device::template Array<uint8_t> device_compressed_, device_workspace_;
  typename Device::template Array<PrimitiveTask> device_primitives_;
  typename Device::template Array<AttributeTarget> device_targets_;
  typename Device::template Array<StreamTask> device_streams_;
  typename Device::template Array<core::View<uint32_t>> device_walks_;
  typename Device::template Array<uint32_t> device_walk_numbers_;
  typename Device::template Array<core::Fault> device_faults_;
};

// A container to a mesh in the host's memory.
template <typename Device>
Expected<Mesh> decode_to_host(BatchDecoder<Device>& decoder, std::span<const uint8_t> bytes,
                              std::span<const AttributeRequest> requests) {
  const Expected<Container> container = parse_container(bytes);
  if (!container) return container.status();
  // Before memory is taken for results.
  if (const auto headers = check_claims(*container); !headers) return headers.status();
  Mesh mesh;
  mesh.point_count = container->point_count();
  BatchPrimitive primitive{bytes, &*container, {}, nullptr, 4};
  std::vector<size_t> offsets;
  size_t size = size_t{12} * container->face_count();
  for (const AttributeRequest& request : requests) {
    mesh.attributes.push_back(
        {request.semantic, request.component_type, request.component_count, request.normalized, {}});
    const size_t stride = mesh.attributes.back().stride();
    offsets.push_back(size);
    size += (size_t{mesh.point_count} * stride + 255) / 256 * 256;
    primitive.targets.push_back({request.unique_id, stored_type(request.component_type),
                                 request.component_count, nullptr, static_cast<uint32_t>(stride), nullptr});
  }
  typename Device::template Array<uint8_t> out;
  if (Status status = out.reserve(size); !status.ok()) return status;
  auto* const indices = reinterpret_cast<uint32_t*>(out.data());
  primitive.indices = indices;
  for (size_t i = 0; i < requests.size(); ++i) primitive.targets[i].values = out.data() + offsets[i];
  if (Status status = decoder.start({&primitive, 1}); !status.ok()) return status;
  if (const Status status = decoder.finish(); !status.ok())
    return Status(status.code(), status.message(), {.patch = status.place().patch});

  mesh.faces.resize(container->face_count());
  Device& device = decoder.device();
  if (Status status =
          device.download(reinterpret_cast<uint32_t*>(mesh.faces.data()), indices, 3 * mesh.faces.size());
      !status.ok())
    return status;
  for (size_t i = 0; i < requests.size(); ++i) {
    Array<std::byte>& values = mesh.attributes[i].values;
    values.resize(size_t{mesh.point_count} * mesh.attributes[i].stride());
    auto* const to = reinterpret_cast<uint8_t*>(values.data());
    if (Status status = device.download(to, out.data() + offsets[i], values.size()); !status.ok())
      return status;
  }
  if (Status status = device.wait(); !status.ok()) return status;
  return mesh;
}

}  // namespace psplit
