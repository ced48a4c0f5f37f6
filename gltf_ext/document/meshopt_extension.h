// The extension objects of buffers and buffer views that meshoptimizer compressed.
#pragma once

#include <string>

#include "gltf_ext/json/json_fields.h"

namespace psplit {

inline constexpr const char* kMeshoptExtensions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

// The extension of a buffer or a buffer view, or null.
template <AnyJson J>
J* meshopt_extension(J& object) {
  for (const char* name : kMeshoptExtensions)
    if (J* found = extension_field(object, name)) return found;
  return nullptr;
}

// The name under which an object has the extension; empty if it has none.
inline std::string name_of_meshopt(const Json& object) {
  for (const char* name : kMeshoptExtensions)
    if (extension_field(object, name) != nullptr) return name;
  return "";
}

// Removes the extension from an object that has it.
inline void erase_meshopt_extension(Json& object) {
  for (const char* name : kMeshoptExtensions) object["extensions"].erase(name);
  if (object["extensions"].empty()) object.erase("extensions");
}

// Whether a buffer is only a placeholder for the data that meshoptimizer decodes: it may have no bytes.
inline bool is_meshopt_fallback(const Json& buffer) {
  const Json* extension = meshopt_extension(buffer);
  return extension != nullptr && bool_field_or(*extension, "fallback", false);
}

}  // namespace psplit
