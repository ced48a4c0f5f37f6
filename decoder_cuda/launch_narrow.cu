// The kernels for streams whose numbers take 16 bits: most patches.
#include "decoder_cuda/cuda_device.cuh"
#include "decoder_cuda/launches.h"

namespace psplit {

template Status launch_decoding<core::StreamKinds::kDraco>(CudaDevice&, const StreamSet<uint16_t>&,
                                                           const LaunchPlan&);
template Status launch_numbering<uint16_t>(CudaDevice&, const StreamSet<uint16_t>&);
template Status launch_writing<uint16_t>(CudaDevice&, const StreamSet<uint16_t>&);

}  // namespace psplit
