// The launches of a batch's kernels on a Device, in their order. A CUDA device (cuda_device.cuh) and its
// emulation in the tests share this code. A Device has
//
//   Array<T>                     memory of the device: reserve(count), size(), data(). It loses its
//                                contents when it grows, and never shrinks
//   HostArray<T>                 the same for pinned memory of the host
//   upload(to, from, count)      from the host
//   download(to, from, count)    to the host
//   launch_threads(count, busy, body)  calls body(i) for each i below count. About `busy` calls have much to do
//   launch_warps(count, body)    calls body(lanes, i), with the lanes of a warp
//   mark(stage)                  the name of the stage that follows, for measurements
//   wait()                       returns when everything before it is done
//   free_memory()                bytes
//
// The device does them in order. All except wait may return before they are done. Functions that can fail
// return a Status.
#pragma once

#include "decoder_cuda/border_bodies.h"
#include "decoder_cuda/launch_plan.h"

namespace psplit {

template <core::StreamKinds kKinds, typename Index, typename Device>
Status launch_decoding(Device& device, const StreamSet<Index>& set, const LaunchPlan& plan) {
  if (set.count == 0) return {};
  device.mark("connectivity");
  if (Status status = device.launch_warps(set.count, BeginStreams<Index, kKinds>{set}); !status.ok())
    return status;
  for (uint32_t round = 0; round < plan.rounds; ++round) {
    device.mark("steps");
    const uint32_t busy = (round == plan.chain_round ? plan.chains : 1) * set.count;
    if (Status status = device.launch_threads(plan.runs * set.count, busy, TakeRuns<Index, kKinds>{set});
        !status.ok())
      return status;
    device.mark("between steps");
    if (Status status = device.launch_warps(set.count, ResumeStreams<Index, kKinds>{set, plan.runs});
        !status.ok())
      return status;
  }
  device.mark("prediction");
  if (Status status = device.launch_warps(set.count, PredictStreams<Index, kKinds>{set}); !status.ok())
    return status;
  if (plan.has_steps)
    if (Status status =
            device.launch_threads(plan.runs * set.count, set.count, PredictRuns<Index, kKinds>{set});
        !status.ok())
      return status;
  return device.launch_warps(set.count, CompleteStreams<Index, kKinds>{set});
}

// Numbers streams of both kinds. All streams of a batch are numbered before one is written.
template <typename Index, typename Device>
Status launch_numbering(Device& device, const StreamSet<Index>& set) {
  if (set.count == 0) return {};
  device.mark("numbering");
  return device.launch_warps(set.count, FinishStreams<Index>{set});
}

template <typename Index, typename Device>
Status launch_writing(Device& device, const StreamSet<Index>& set) {
  if (set.count == 0) return {};
  device.mark("output");
  return device.launch_warps(set.count, WriteStreams<Index>{set});
}

// The values at the borders of `count` streams.
template <typename Device>
Status launch_borders(Device& device, const Batch& batch, const BorderTask* tasks, uint32_t count) {
  if (count == 0) return {};
  device.mark("borders");
  if (Status status = device.launch_threads(count, count, TakeBorderParts{batch, tasks}); !status.ok())
    return status;
  return device.launch_warps(count, ShareBorderValues{batch, tasks});
}

}  // namespace psplit
