// Decoding many streams at once on a device: the tasks, the state of each stream, and the bodies of the
// kernels.
//
// Nothing here is CUDA. A launcher calls a body once for each item, with one thread or with the lanes of a
// warp. cuda_device.cuh launches on a device, and an emulation launches in the tests.
//
//   BeginStreams    a warp a stream      the header, to the first stop
//   TakeRuns        a thread a run       the long chains of steps
//   ResumeStreams   a warp a stream      from one stop to the next
//   PredictStreams  a warp a stream      most values
//   PredictRuns     a thread a run       values that are a chain
//   CompleteStreams a warp a stream      the stops that remain, if there are more than launches
//   FinishStreams   a warp a stream      the points that it owns; the first stream's grid
//   WriteStreams    a warp a stream      values and faces, to their targets
//
// The first six exist twice: for Draco streams, and for condensed streams. Before them come the bodies of
// border_bodies.h, if a container stores the values at borders once.
#pragma once

#include <new>

#include "decoder_cuda/device_head.h"
#include "src/core/condensed/border_part.h"
#include "src/core/condensed/condensed_header.h"
#include "src/core/stitch.h"
#include "src/core/workspace.h"

namespace psplit {

// A requested attribute: CudaAttribute in the core's terms.
struct AttributeTarget {
  uint32_t unique_id = 0;
  DataType type = DataType::kFloat32;
  uint8_t components = 0;
  uint8_t* values = nullptr;  // of the primitive's first point
  uint32_t stride = 0;        // bytes from one point to the next
  float* grid = nullptr;      // or null: place 0 of each component, and then the step between places

  // Whether every value is aligned as its component type.
  PSPLIT_HD bool is_aligned() const {
    return (reinterpret_cast<uintptr_t>(values) | stride) % core::data_type_bytes(type) == 0;
  }
  PSPLIT_HD bool fits(DataType stored, core::Coding coding, uint8_t bits) const {
    if (type == stored) return grid == nullptr;
    const uint32_t bytes = type == DataType::kUint8    ? 1
                           : type == DataType::kUint16 ? 2
                           : type == DataType::kUint32 ? 4
                                                       : 0;
    return coding == core::Coding::kQuantized && bits <= 8 * bytes;
  }
};

// A primitive has consecutive streams and consecutive targets.
struct PrimitiveTask {
  const uint8_t* bytes = nullptr;                // the places of its streams count from here
  uint32_t first_stream = 0, first_written = 0;  // places in the batch
  uint32_t first_target = 0, target_count = 0;
  uint32_t point_count = 0;          // of all streams
  uint32_t first_point = 0;          // the point of a target's first value
  const DeviceHead* head = nullptr;  // of condensed streams
  bool is_stitched = true;           // if not, results have all points of each stream, one after the other
  void* indices = nullptr;           // three for each face
  uint32_t index_bytes = 4;          // 2 or 4
  // May be null. For each stream, the three smallest and the three largest values of the first target.
  float* bounds = nullptr;
};

enum class StreamUse : uint8_t {
  kNone,
  kBorder,      // only its border part is decoded
  kReferredTo,  // decoded only for the numbers of its points
  kWritten,
};

// A row of a container's directory, and the places of its data.
struct StreamTask {
  uint64_t stream_at = 0, stitch_at = 0;  // in the primitive's bytes
  uint32_t stream_bytes = 0, stitch_bytes = 0;
  uint32_t skeleton_at = 0, skeleton_bytes = 0;  // of a condensed stream
  uint32_t primitive = 0, number = 0;            // the stream's place in its container
  uint32_t face_count = 0, point_count = 0, reference_count = 0;
  uint32_t face_base = 0, owned_base = 0, owned_end = 0;
  bool is_residue = false, has_walk = false;
  StreamUse use = StreamUse::kNone;
  bool has_point_limit = false;  // the row has the largest number of points, not the exact one
  uint64_t workspace_at = 0, workspace_bytes = 0;  // of the StreamState, and the bytes after it
  uint64_t walk_at = 0;                            // of point_count numbers, which all streams may refer to
  static constexpr uint64_t kNoBorder = ~uint64_t{0};
  uint64_t border_at = kNoBorder;  // of the BorderState of a condensed stream with a border part
};

// A stream with a border part.
struct BorderTask {
  uint32_t stream = 0;  // its place in the batch
  uint32_t places = 0, components = 0;
  uint32_t attributes = 0;  // of its skeleton
  // For a patch that is decoded alone: where the values at its border are, and their number. They are uploaded.
  bool is_known = false;
  uint32_t known_count = 0;
  uint64_t known_at = 0;
};

// The values of the first attribute at a stream's border, which are known before the stream is decoded. The
// memory after this struct has the values and marks of all places.
struct BorderState {
  core::WalkValues walk;
  core::SectionReader behind;  // the stream's coder after its border part

  // The bytes of this struct and the memory after it. Each value takes four bytes, and each place has a mark.
  // Before they are written, the attributes of the skeleton use this memory.
  static size_t bytes(uint64_t places, uint64_t components, uint64_t attributes) {
    const uint64_t values = places * (4 * components + 1),
                   before = attributes * sizeof(core::SkeletonAttribute);
    return static_cast<size_t>((sizeof(BorderState) + (values < before ? before : values) + 15) / 16 * 16);
  }
};

// The memory for a stream's numbers, beside the memory that it decodes in.
inline size_t numbering_bytes(const StreamTask& task) {
  return sizeof(uint32_t) * (size_t{task.point_count} + task.reference_count) + 2 * 16;
}

template <typename Index>
struct StreamState {
  PSPLIT_HD static constexpr size_t bytes() { return (sizeof(StreamState) + 255) / 256 * 256; }

  core::StreamHeader header;
  core::Arena arena;
  core::Patch<Index> patch;
  alignas(core::PatchDecoder<Index>) uint8_t decoder_bytes[sizeof(core::PatchDecoder<Index>)];
  core::View<Index> border;
  core::View<uint32_t> numbers, references;

  // The decoder that BeginStreams made for streams of these kinds.
  template <core::StreamKinds kKinds>
  PSPLIT_HD core::PatchDecoder<Index, kKinds>& decoder() {
    using Decoder = core::PatchDecoder<Index, kKinds>;
    static_assert(sizeof(Decoder) == sizeof decoder_bytes);
    return *__builtin_launder(reinterpret_cast<Decoder*>(decoder_bytes));
  }
};

// Arrays of the device. An array with an element for each stream has the order of `streams`.
struct Batch {
  const PrimitiveTask* primitives = nullptr;
  const AttributeTarget* targets = nullptr;
  const StreamTask* streams = nullptr;
  uint8_t* workspace = nullptr;
  uint32_t* walk_numbers = nullptr;
  core::View<uint32_t>* walks = nullptr;  // the primitive's points along the stream's border
  core::Fault* faults = nullptr;          // of decoding
  core::Fault* stitch_faults = nullptr;
  uint32_t* point_counts = nullptr;  // as decoded
  uint8_t* borders = nullptr;        // the places of borders count from here
  const int32_t* known = nullptr;    // the values at the borders of patches alone

  PSPLIT_HD BorderState& border(const StreamTask& task) const {
    return *__builtin_launder(reinterpret_cast<BorderState*>(borders + task.border_at));
  }
  PSPLIT_HD core::Fault read_condensed_header(const StreamTask& task,
                                              core::View<core::SkeletonAttribute> attributes,
                                              core::StreamHeader& header) const {
    const PrimitiveTask& primitive = primitives[task.primitive];
    return core::read_condensed_header(primitive.head->skeleton(task.skeleton_at, task.skeleton_bytes),
                                       {primitive.bytes + task.stream_at, task.stream_bytes},
                                       primitive.head->models, task.face_count, task.point_count, attributes,
                                       header, header.condensed);
  }
  PSPLIT_HD core::StitchRow row(const StreamTask& task) const {
    const PrimitiveTask& primitive = primitives[task.primitive];
    return {core::View<const uint8_t>(primitive.bytes + task.stitch_at, task.stitch_bytes),
            task.number,
            task.point_count,
            task.reference_count,
            task.owned_base,
            primitive.point_count};
  }
};

// Streams whose numbers take 16 bits, or streams whose numbers take 32.
template <typename Index>
struct StreamSet {
  Batch batch;
  const uint32_t* streams = nullptr;  // their places in the batch
  uint32_t count = 0;

  StreamSet range(size_t first, size_t end) const {
    return {batch, streams + first, static_cast<uint32_t>(end - first)};
  }

  PSPLIT_HD const StreamTask& task(uint32_t i) const { return batch.streams[streams[i]]; }
  PSPLIT_HD StreamState<Index>& state(uint32_t i) const {
    return *__builtin_launder(reinterpret_cast<StreamState<Index>*>(memory(i)));
  }
  PSPLIT_HD uint8_t* memory(uint32_t i) const { return batch.workspace + task(i).workspace_at; }
  PSPLIT_HD core::Fault& fault(uint32_t i) const { return batch.faults[streams[i]]; }
};

// The attribute of a target, or null if the stream has none of its type.
template <typename Index>
PSPLIT_HD const core::Attribute<Index>* find_attribute(const core::Patch<Index>& patch,
                                                       const AttributeTarget& target) {
  for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
    const core::Attribute<Index>& attribute = patch.attributes[i];
    if (attribute.unique_id == target.unique_id)
      return attribute.components == target.components &&
                     target.fits(attribute.type, attribute.coding, attribute.bits)
                 ? &attribute
                 : nullptr;
  }
  return nullptr;
}

// Element k of an attribute's grid: place 0 of each component, and then the step between places.
template <typename Index>
PSPLIT_HD float grid_value(const core::Attribute<Index>& attribute, uint32_t k) {
  if (k == attribute.components) return attribute.step();
  float origin;
  core::copy_bytes(&origin, attribute.origin + sizeof origin * k, sizeof origin);
  return origin;
}

template <typename Index, core::StreamKinds kKinds>
struct BeginStreams {
  StreamSet<Index> set;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    using core::Fault;
    const StreamTask& task = set.task(i);
    const Fault of_border = task.border_at != StreamTask::kNoBorder ? set.fault(i) : Fault::kNone;
    if (lanes.rank() == 0) new (set.memory(i)) StreamState<Index>;
    lanes.sync();
    StreamState<Index>& state = set.state(i);
    Fault fault = of_border;
    if (fault == Fault::kNone) fault = core::alone(lanes, [&] { return begin(task, state, set.memory(i)); });
    if (fault == Fault::kNone) fault = state.template decoder<kKinds>().start(lanes);
    if (lanes.rank() == 0) set.fault(i) = fault;
  }

 private:
  PSPLIT_HD core::Fault begin(const StreamTask& task, StreamState<Index>& state, uint8_t* memory) const {
    using core::Fault;
    const Fault fault = read_header(task, memory + state.bytes(), state.header);
    if (fault != Fault::kNone) return fault;
    // A residue may have more faces than its row counts; they follow the counted ones.
    const uint32_t faces = state.header.counts.face_count;
    if (task.is_residue ? faces < task.face_count : faces != task.face_count) return Fault::kRow;
    if (sizeof(Index) == 2 && !state.header.fits_16_bits()) return Fault::kRow;
    state.arena = core::Arena(memory + state.bytes(), task.workspace_bytes);
    using Decoder = core::PatchDecoder<Index, kKinds>;
    new (state.decoder_bytes) Decoder(state.header, state.arena, state.patch);
    return Fault::kNone;
  }
  // `memory` is the stream's, which is not used yet.
  PSPLIT_HD core::Fault read_header(const StreamTask& task, uint8_t* memory, core::StreamHeader& header) const {
    if constexpr (kKinds == core::StreamKinds::kDraco) {
      const uint8_t* const stream = set.batch.primitives[task.primitive].bytes + task.stream_at;
      return core::read_stream_header(stream, task.stream_bytes, header);
    } else {
      const uint64_t room = task.workspace_bytes / sizeof(core::SkeletonAttribute);
      const core::View<core::SkeletonAttribute> attributes(
          reinterpret_cast<core::SkeletonAttribute*>(memory),
          static_cast<size_t>(room < core::kMaxAttributes ? room : core::kMaxAttributes));
      const core::Fault fault = set.batch.read_condensed_header(task, attributes, header);
      if (fault != core::Fault::kNone || task.border_at == StreamTask::kNoBorder) return fault;
      const BorderState& border = set.batch.border(task);
      header.condensed.known =
          border.walk.values.first(size_t{border.walk.length} * header.condensed.border_components);
      header.condensed.behind_border = border.behind;
      return fault;
    }
  }
};

// Runs [0, run_count) of all streams. Neighbouring threads take runs of the same kind.
template <typename Index, core::StreamKinds kKinds>
struct TakeRuns {
  StreamSet<Index> set;

  PSPLIT_HD void operator()(uint32_t item) const {
    const uint32_t run = item / set.count, i = item % set.count;
    if (set.fault(i) != core::Fault::kNone) return;
    core::PatchDecoder<Index, kKinds>& decoder = set.state(i).template decoder<kKinds>();
    if (run < core::pending_runs(decoder)) core::take_run(decoder, run);
  }
};

template <typename Index, core::StreamKinds kKinds>
struct ResumeStreams {
  StreamSet<Index> set;
  uint32_t runs_taken = 0;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    using core::Fault;
    if (set.fault(i) != Fault::kNone) return;
    core::PatchDecoder<Index, kKinds>& decoder = set.state(i).template decoder<kKinds>();
    if (decoder.stop() >= core::Stop::kCorrections) return;
    const uint32_t pending = core::pending_runs(decoder);
    if (pending > runs_taken)
      core::for_each_lane_item(lanes, pending - runs_taken,
                               [&](uint32_t run) { core::take_run(decoder, runs_taken + run); });
    lanes.sync();
    const Fault fault = decoder.resume_to_corrections(lanes);
    if (lanes.rank() == 0) set.fault(i) = fault;
  }
};

// The values of most streams, which lanes compute together.
template <typename Index, core::StreamKinds kKinds>
struct PredictStreams {
  static constexpr bool kIsSmall = true;  // it takes few registers
  StreamSet<Index> set;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    core::Fault& fault = set.fault(i);
    if (fault != core::Fault::kNone) return;
    core::PatchDecoder<Index, kKinds>& decoder = set.state(i).template decoder<kKinds>();
    if (decoder.stop() != core::Stop::kCorrections) return;
    lanes.sync();  // before a lane sets the fault
    const core::Fault found = decoder.predict(lanes);
    if (lanes.rank() == 0) fault = found;
  }
};

// Values that one thread computes, each from those before it. Items are as for TakeRuns.
template <typename Index, core::StreamKinds kKinds>
struct PredictRuns {
  StreamSet<Index> set;

  PSPLIT_HD void operator()(uint32_t item) const {
    const uint32_t run = item / set.count, i = item % set.count;
    if (set.fault(i) != core::Fault::kNone) return;
    core::PatchDecoder<Index, kKinds>& decoder = set.state(i).template decoder<kKinds>();
    if (decoder.stop() == core::Stop::kPrediction && run < core::pending_runs(decoder))
      core::take_prediction(decoder, run);
  }
};

// Decodes to their end the streams that no launch before it has finished. In most batches there are none.
template <typename Index, core::StreamKinds kKinds>
struct CompleteStreams {
  StreamSet<Index> set;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    core::Fault& fault = set.fault(i);
    if (fault != core::Fault::kNone) return;
    core::PatchDecoder<Index, kKinds>& decoder = set.state(i).template decoder<kKinds>();
    if (decoder.stop() == core::Stop::kDone) return;
    lanes.sync();  // before a lane sets the fault
    const core::Fault found = core::finish_together(lanes, decoder);
    if (lanes.rank() == 0) fault = found;
  }
};

template <typename Index>
struct FinishStreams {
  StreamSet<Index> set;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    using core::Fault;
    const StreamTask& task = set.task(i);
    StreamState<Index>& state = set.state(i);
    core::View<uint32_t>& walk = set.batch.walks[set.streams[i]];
    Fault fault = set.fault(i);
    if (fault == Fault::kNone)
      fault = core::alone(lanes, [&] { return check(task, state, set.batch.point_counts[set.streams[i]]); });
    if (fault == Fault::kNone && task.has_walk)
      fault = core::walk_border(lanes, state.patch, state.arena, state.border);
    if (fault == Fault::kNone) fault = core::alone(lanes, [&] { return take_numbers(task, state, walk); });
    if (fault == Fault::kNone) fault = number(lanes, task, state, walk);
    lanes.sync();
    if (lanes.rank() != 0) return;
    set.fault(i) = fault;
    const PrimitiveTask& primitive = set.batch.primitives[task.primitive];
    if (fault == Fault::kNone && set.streams[i] == primitive.first_written) write_grids(primitive, state);
    if (fault != Fault::kNone) walk = {};
  }

 private:
  PSPLIT_HD core::Fault check(const StreamTask& task, const StreamState<Index>& state,
                              uint32_t& point_count) const {
    using core::Fault;
    const uint32_t points = state.patch.point_count;
    if (task.has_point_limit ? points > task.point_count : points != task.point_count) return Fault::kRow;
    point_count = points;
    const PrimitiveTask& primitive = set.batch.primitives[task.primitive];
    for (uint32_t t = 0; t < primitive.target_count; ++t)
      if (find_attribute(state.patch, set.batch.targets[primitive.first_target + t]) == nullptr)
        return Fault::kRequest;
    return Fault::kNone;
  }
  PSPLIT_HD core::Fault take_numbers(const StreamTask& task, StreamState<Index>& state,
                                     core::View<uint32_t>& walk) const {
    // A walk visits no point twice, so it has room.
    walk = core::View<uint32_t>(set.batch.walk_numbers + task.walk_at, state.border.size());
    const bool taken = state.arena.take(state.numbers, state.patch.point_count) &&
                       state.arena.take(state.references, task.reference_count);
    return taken ? core::Fault::kNone : core::Fault::kWorkspace;
  }

  PSPLIT_HD void write_grids(const PrimitiveTask& primitive, const StreamState<Index>& state) const {
    for (uint32_t t = 0; t < primitive.target_count; ++t) {
      const AttributeTarget& target = set.batch.targets[primitive.first_target + t];
      for (uint32_t k = 0; target.grid != nullptr && k <= target.components; ++k)
        target.grid[k] = grid_value(*find_attribute(state.patch, target), k);
    }
  }

  template <core::Lanes L>
  PSPLIT_HD core::Fault number(L lanes, const StreamTask& task, StreamState<Index>& state,
                               core::View<uint32_t> walk) const {
    const PrimitiveTask& primitive = set.batch.primitives[task.primitive];
    if (!primitive.is_stitched) {
      core::for_each_lane_item(lanes, state.patch.point_count,
                               [&](uint32_t point) { state.numbers[point] = task.owned_base + point; });
      return core::Fault::kNone;
    }
    const uint32_t total = primitive.point_count;
    const core::Fault fault = core::number_mesh_points(
        lanes, set.batch.row(task), core::View<const Index>(state.border), state.numbers, state.references);
    if (fault != core::Fault::kNone) return fault;
    core::for_each_lane_item(lanes, static_cast<uint32_t>(walk.size()), [&](uint32_t at) {
      const uint32_t number = state.numbers[state.border[at]];
      walk[at] = number < total ? number : core::kNoPoint;
    });
    return fault;
  }
};

template <typename Index>
struct WriteStreams {
  StreamSet<Index> set;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    const StreamTask& task = set.task(i);
    StreamState<Index>& state = set.state(i);
    const PrimitiveTask& primitive = set.batch.primitives[task.primitive];
    // A caller may draw the faces of broken streams by mistake, so their indices must be valid.
    const auto write_nothing = [&] {
      if (primitive.point_count > 0) write_indices(lanes, task, primitive, [](uint32_t) { return Triangle(); });
    };
    core::Fault fault = set.fault(i);
    if (fault == core::Fault::kNone && task.use == StreamUse::kWritten &&
        set.streams[i] != primitive.first_written)
      fault = compare_grids(primitive, state);
    if (fault == core::Fault::kNone && task.use == StreamUse::kWritten && primitive.is_stitched)
      fault = resolve(lanes, task, state);
    if (lanes.rank() == 0) set.batch.stitch_faults[set.streams[i]] = fault;
    if (task.use != StreamUse::kWritten) return;
    if (fault != core::Fault::kNone) return write_nothing();
    const uint32_t total = primitive.point_count;
    const core::View<Index> point_at = state.patch.point_at;
    const core::View<const uint32_t> numbers = state.numbers, references = state.references;
    write_indices(lanes, task, primitive, [&](uint32_t face) {
      const auto points = core::row_of(point_at, 4 * face);
      Triangle triangle;
      for (uint32_t k = 0; k < 3; ++k) triangle.at[k] = numbers[points.at[k]];
      for (uint32_t& number : triangle.at)
        if (number >= total) number = references[number - total];
      return triangle;
    });
    for (uint32_t t = 0; t < primitive.target_count; ++t) {
      const AttributeTarget& target = set.batch.targets[primitive.first_target + t];
      const core::Attribute<Index>& attribute = *find_attribute(state.patch, target);
      uint8_t* const values = target.values;
      const uint32_t first_point = primitive.first_point, stride = target.stride;
      // The owner writes. Every copy holds the same bits.
      const auto place_of = [&](uint32_t point) -> uint8_t* {
        const uint32_t number = numbers[point];
        return number < total ? values + size_t{number - first_point} * stride : nullptr;
      };
      if (target.is_aligned())
        state.patch.template write_values<true>(lanes, attribute, target.type, place_of);
      else
        state.patch.write_values(lanes, attribute, target.type, place_of);
    }
    if (primitive.bounds == nullptr) return;
    lanes.sync();
    write_bounds(lanes, task.owned_base, state.patch.point_count, set.batch.targets[primitive.first_target],
                 primitive.bounds + 6 * (set.streams[i] - primitive.first_written));
  }

 private:
  // The places of all streams are in one array, so they must be on one grid.
  PSPLIT_HD core::Fault compare_grids(const PrimitiveTask& primitive, const StreamState<Index>& state) const {
    if (set.batch.faults[primitive.first_written] != core::Fault::kNone) return core::Fault::kNone;
    for (uint32_t t = 0; t < primitive.target_count; ++t) {
      const AttributeTarget& target = set.batch.targets[primitive.first_target + t];
      for (uint32_t k = 0; target.grid != nullptr && k <= target.components; ++k)
        if (target.grid[k] != grid_value(*find_attribute(state.patch, target), k))
          return core::Fault::kAttribute;
    }
    return core::Fault::kNone;
  }

  struct Triangle {
    uint32_t at[3] = {};
  };
  // triangle_of(face) has the mesh's points of a face of the stream. They are all loaded before one is stored,
  // as a compiler does not know that these places differ.
  template <core::Lanes L, typename TriangleOf>
  PSPLIT_HD static void write_indices(L lanes, const StreamTask& task, const PrimitiveTask& primitive,
                                      TriangleOf triangle_of) {
    const auto write = [&]<typename Out>(Out* indices) {
      Out* const out = indices + size_t{3} * task.face_base;
      core::for_each_lane_item(lanes, task.face_count, [&](uint32_t face) {
        const Triangle triangle = triangle_of(face);
        for (uint32_t k = 0; k < 3; ++k) out[3 * face + k] = static_cast<Out>(triangle.at[k]);
      });
    };
    if (primitive.index_bytes == 2)
      write(static_cast<uint16_t*>(primitive.indices));
    else
      write(static_cast<uint32_t*>(primitive.indices));
  }

  // The bounds of the values that were just written, which may be fewer than there is room for.
  template <core::Lanes L>
  PSPLIT_HD static void write_bounds(L lanes, uint32_t first_point, uint32_t point_count,
                                     const AttributeTarget& target, float* bounds) {
    const uint8_t* const values = target.values + size_t{first_point} * target.stride;
    for (uint32_t k = 0; k < 3; ++k) {
      float low = 0, high = 0;
      bool any = false;
      core::for_each_lane_item(lanes, point_count, [&](uint32_t point) {
        const float value = reinterpret_cast<const float*>(values + size_t{point} * target.stride)[k];
        if (!(value == value)) return;  // NaN
        low = !any || value < low ? value : low;
        high = !any || value > high ? value : high;
        any = true;
      });
      for (uint32_t step = 1; step < L::size(); step *= 2) {
        const float other_low = shuffle_float(lanes, low, lanes.rank() ^ step);
        const float other_high = shuffle_float(lanes, high, lanes.rank() ^ step);
        const bool other_any = lanes.shuffle(uint32_t{any}, lanes.rank() ^ step) != 0;
        low = other_any && (!any || other_low < low) ? other_low : low;
        high = other_any && (!any || other_high > high) ? other_high : high;
        any |= other_any;
      }
      if (lanes.rank() == 0) bounds[k] = low, bounds[3 + k] = high;
    }
  }
  template <core::Lanes L>
  PSPLIT_HD static float shuffle_float(L lanes, float value, uint32_t source) {
    uint32_t bits;
    core::copy_bytes(&bits, &value, sizeof bits);
    bits = lanes.shuffle(bits, source);
    core::copy_bytes(&value, &bits, sizeof bits);
    return value;
  }

  // A reference to a stream that did not decode becomes any point of it: the fault is not this stream's.
  template <core::Lanes L>
  PSPLIT_HD core::Fault resolve(L lanes, const StreamTask& task, StreamState<Index>& state) const {
    const Batch& batch = set.batch;
    const uint32_t first = batch.primitives[task.primitive].first_stream;
    const auto walk_of = [&](uint32_t stream, uint32_t place) -> uint32_t {
      const StreamTask& owner = batch.streams[first + stream];
      if (owner.use == StreamUse::kNone) return core::kNoPoint;
      if (batch.faults[first + stream] != core::Fault::kNone && owner.owned_base < owner.owned_end)
        return owner.owned_base;
      const core::View<uint32_t> walk = batch.walks[first + stream];
      return place < walk.size() ? walk[place] : core::kNoPoint;
    };
    const auto owned_of = [&](uint32_t stream, uint32_t rank) -> uint32_t {
      const StreamTask& owner = batch.streams[first + stream];
      return rank < owner.owned_end - owner.owned_base ? owner.owned_base + rank : core::kNoPoint;
    };
    return core::resolve_references(lanes, set.batch.row(task), walk_of, owned_of, state.references);
  }
};

}  // namespace psplit
