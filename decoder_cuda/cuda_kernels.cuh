// All kernels of the decoder. The files launch_*.cu compile them.
#pragma once

#include "decoder_cuda/cuda_device.cuh"
#include "decoder_cuda/launches.h"

namespace psplit {

extern template Status launch_decoding<core::StreamKinds::kDraco>(CudaDevice&, const StreamSet<uint16_t>&,
                                                                  const LaunchPlan&);
extern template Status launch_decoding<core::StreamKinds::kDraco>(CudaDevice&, const StreamSet<uint32_t>&,
                                                                  const LaunchPlan&);
extern template Status launch_decoding<core::StreamKinds::kCondensed>(CudaDevice&, const StreamSet<uint16_t>&,
                                                                      const LaunchPlan&);
extern template Status launch_decoding<core::StreamKinds::kCondensed>(CudaDevice&, const StreamSet<uint32_t>&,
                                                                      const LaunchPlan&);
extern template Status launch_borders(CudaDevice&, const Batch&, const BorderTask*, uint32_t);
extern template Status launch_numbering<uint16_t>(CudaDevice&, const StreamSet<uint16_t>&);
extern template Status launch_writing<uint16_t>(CudaDevice&, const StreamSet<uint16_t>&);
extern template Status launch_numbering<uint32_t>(CudaDevice&, const StreamSet<uint32_t>&);
extern template Status launch_writing<uint32_t>(CudaDevice&, const StreamSet<uint32_t>&);

// Launches each kernel at least once, with nothing to do. `device` is set to measure or to load them.
inline Status visit_kernels(CudaDevice& device) {
  const LaunchPlan plan{.runs = 1, .rounds = 1, .has_steps = true};
  const auto visit = [&]<typename Index>(const StreamSet<Index>& set) {
    Status status = launch_decoding<core::StreamKinds::kDraco>(device, set, plan);
    if (status.ok()) status = launch_decoding<core::StreamKinds::kCondensed>(device, set, plan);
    if (status.ok()) status = launch_numbering(device, set);
    return status.ok() ? launch_writing(device, set) : status;
  };
  Status status = visit(StreamSet<uint16_t>{{}, nullptr, 1});
  if (status.ok()) status = visit(StreamSet<uint32_t>{{}, nullptr, 1});
  return status.ok() ? launch_borders(device, {}, nullptr, 1) : status;
}

// A device on which the decoder runs. Errors: kUnsupported without a device.
Expected<CudaDevice> create_device(cudaStream_t stream);

}  // namespace psplit
