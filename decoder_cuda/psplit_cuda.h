// The CUDA side of psplit, callable from builds that have none.
#pragma once

#include <string>

namespace psplit {

// True when this build holds the CUDA decoder and the machine has a device and a driver that run it. Else
// *why, where given, is a phrase to show a user: "built without CUDA", "no CUDA-capable device is detected".
bool cuda_available(std::string* why);

}  // namespace psplit
