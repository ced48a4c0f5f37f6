// The kernels for streams whose numbers take 32 bits.
#include "decoder_cuda/cuda_device.cuh"
#include "decoder_cuda/launches.h"

namespace psplit {

template Status launch_decoding<core::StreamKinds::kDraco>(CudaDevice&, const StreamSet<uint32_t>&,
                                                           const LaunchPlan&);
template Status launch_numbering<uint32_t>(CudaDevice&, const StreamSet<uint32_t>&);
template Status launch_writing<uint32_t>(CudaDevice&, const StreamSet<uint32_t>&);

}  // namespace psplit
