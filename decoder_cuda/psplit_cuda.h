// The CUDA side of psplit, callable from builds that have none.
#pragma once

#include <string>

#include "src/container/decode_backend.h"

namespace psplit {

// True when this build holds the CUDA decoder and the machine has a device and a driver that run it. Else
// *why, where given, is a phrase to show a user: "built without CUDA", "no CUDA-capable device is detected".
bool cuda_available(std::string* why);

// All patches at once on the current device. Safe to call from several threads, which wait for each other;
// memory of the device is kept for the next mesh. Attributes must be asked for in the types that they were
// encoded in. Errors: kUnsupported without a device, and for whole Draco streams; kRuntimeFailure where the
// device fails.
DecodeBackend cuda_backend();

}  // namespace psplit
