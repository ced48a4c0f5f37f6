// The places where accessors name buffer views.
#pragma once

#include <cstdint>
#include <utility>

#include "gltf_ext/json/json_fields.h"

namespace psplit {

// What an accessor has in the view: its elements, its sparse indices, or its sparse values.
enum class ElementsRole { kElements, kSparseIndices, kSparseValues };
inline constexpr ElementsRole kElementsRoles[] = {ElementsRole::kElements, ElementsRole::kSparseIndices,
                                                  ElementsRole::kSparseValues};
using ElementsPlace = std::pair<int64_t, ElementsRole>;  // the index of the accessor

// The object with the members "bufferView" and "byteOffset", or null.
template <AnyJson J>
J* elements_json(J& accessors, ElementsPlace place) {
  J& accessor = accessors[static_cast<size_t>(place.first)];
  if (place.second == ElementsRole::kElements)
    return field(accessor, "bufferView") == nullptr ? nullptr : &accessor;
  J* sparse = object_field(accessor, "sparse");
  return sparse == nullptr
             ? nullptr
             : object_field(*sparse, place.second == ElementsRole::kSparseIndices ? "indices" : "values");
}

}  // namespace psplit
