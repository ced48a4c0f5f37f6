// The kernels for condensed streams whose numbers take 32 bits.
#include "decoder_cuda/cuda_device.cuh"
#include "decoder_cuda/launches.h"

namespace psplit {

template Status launch_decoding<core::StreamKinds::kCondensed>(CudaDevice&, const StreamSet<uint32_t>&,
                                                               const LaunchPlan&);

}  // namespace psplit
