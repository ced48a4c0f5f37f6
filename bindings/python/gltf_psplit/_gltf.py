"""Names and numbers of glTF."""

PATCHES = "PSPLIT_mesh_draco_patches"
STOCK = "KHR_draco_mesh_compression"
COMPONENT_TYPES = (5120, 5121, 5122, 5123, 5125, 5126)
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
TYPES = {count: name for name, count in COMPONENTS.items() if name != "MAT2"}
