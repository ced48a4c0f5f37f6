// The JSON tree of a glTF document. Objects keep their members in the order of the file.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "gltf_ext/json/json_fwd.h"

namespace psplit {

// An empty object with room for members. One without room grows by copying its members with their trees.
inline Json object_with_room(size_t members) {
  Json object = Json::object();
  object.get_ref<Json::object_t&>().reserve(members);
  return object;
}

}  // namespace psplit
