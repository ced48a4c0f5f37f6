// The kernels for condensed streams whose numbers take 16 bits: most patches; and those for
// the values at borders.
#include "decoder_cuda/cuda_device.cuh"
#include "decoder_cuda/launches.h"

namespace psplit {

template Status launch_decoding<core::StreamKinds::kCondensed>(CudaDevice&, const StreamSet<uint16_t>&,
                                                               const LaunchPlan&);
template Status launch_borders(CudaDevice&, const Batch&, const BorderTask*, uint32_t);

}  // namespace psplit
