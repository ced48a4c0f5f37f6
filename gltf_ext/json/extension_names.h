// The names of the two glTF extensions whose primitives are Draco streams.
#pragma once

namespace psplit {

inline constexpr const char* kExtensionName = "PSPLIT_mesh_draco_patches";
inline constexpr const char* kStockExtensionName = "KHR_draco_mesh_compression";

}  // namespace psplit
