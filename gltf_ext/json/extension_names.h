// The names of glTF extensions: of the two whose primitives are Draco streams, and of the one that allows
// integers in attributes.
#pragma once

namespace psplit {

inline constexpr const char* kExtensionName = "PSPLIT_mesh_draco_patches";
inline constexpr const char* kStockExtensionName = "KHR_draco_mesh_compression";
inline constexpr const char* kQuantizationExtensionName = "KHR_mesh_quantization";

}  // namespace psplit
