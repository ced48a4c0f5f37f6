// The bodies of the kernels that find the values at the borders of condensed streams, which patches share. They
// come before the bodies of stream_bodies.h.
//
//   TakeBorderParts     a thread a stream    decodes the values that the stream owns
//   ShareBorderValues   a warp a stream      copies values that other streams own
#pragma once

#include "decoder_cuda/stream_bodies.h"

namespace psplit {

struct TakeBorderParts {
  Batch batch;
  const BorderTask* tasks = nullptr;

  PSPLIT_HD void operator()(uint32_t i) const {
    const StreamTask& stream = batch.streams[tasks[i].stream];
    BorderState& border = *new (batch.borders + stream.border_at) BorderState;
    const core::Fault fault = take(stream, tasks[i], border);
    if (fault != core::Fault::kNone) border.walk = {};
    batch.faults[tasks[i].stream] = fault;
  }

 private:
  PSPLIT_HD core::Fault take(const StreamTask& of, const BorderTask& task, BorderState& border) const {
    using core::Fault;
    core::StreamHeader header;
    // They are where the values will be.
    const core::View<core::SkeletonAttribute> attributes(
        reinterpret_cast<core::SkeletonAttribute*>(&border + 1), task.attributes);
    if (const Fault fault = batch.read_condensed_header(of, attributes, header); fault != Fault::kNone)
      return fault;
    const core::CondensedStream& stream = header.condensed;
    const size_t components = task.components, places = task.places;
    if (stream.border_components != components || core::most_places(stream, of.reference_count) != places)
      return Fault::kRow;
    auto* const values = reinterpret_cast<int32_t*>(&border + 1);
    border.walk.values = {values, places * components};
    border.walk.is_own = {reinterpret_cast<uint8_t*>(values + places * components), places};
    // The part's symbols are at the end of the values.
    const size_t part = stream.border_count * components;
    auto* const symbols = reinterpret_cast<uint32_t*>(values + places * components - part);
    core::TokenSequence tokens;
    const Fault fault = core::start_border_part(header.condensed, border.walk.is_own, {symbols, part}, tokens);
    if (fault != Fault::kNone) return fault;
    core::TokenSequence* const one = &tokens;
    core::step_tokens<1>(&one, 1);
    border.behind = tokens.section();
    if (!task.is_known) return core::place_own_values(batch.row(of), stream, border.walk);
    border.walk.values = {const_cast<int32_t*>(batch.known + task.known_at), task.known_count};
    border.walk.length = components > 0 ? static_cast<uint32_t>(task.known_count / components) : 0;
    return Fault::kNone;
  }
};

struct ShareBorderValues {
  Batch batch;
  const BorderTask* tasks = nullptr;

  template <core::Lanes L>
  PSPLIT_HD void operator()(L lanes, uint32_t i) const {
    core::Fault& fault = batch.faults[tasks[i].stream];
    const StreamTask& task = batch.streams[tasks[i].stream];
    if (task.use == StreamUse::kBorder || tasks[i].is_known || fault != core::Fault::kNone) return;
    lanes.sync();  // before a lane sets the fault
    const uint32_t first = batch.primitives[task.primitive].first_stream;
    const auto walk_of = [&](uint32_t stream) {
      const StreamTask& owner = batch.streams[first + stream];
      return owner.border_at != StreamTask::kNoBorder ? batch.border(owner).walk : core::WalkValues();
    };
    core::CondensedStream stream;
    stream.border_components = tasks[i].components;
    const core::Fault missing =
        core::copy_shared_values(lanes, batch.row(task), stream, walk_of, batch.border(task).walk);
    if (lanes.rank() == 0) fault = missing;
  }
};

}  // namespace psplit
