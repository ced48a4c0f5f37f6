// Access to members of hostile JSON: each may be missing or of any type. No function here throws.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "gltf_ext/json/json.h"

namespace psplit {

// `J` is Json or const Json: a result is as mutable as its argument.
template <typename J>
concept AnyJson = std::is_same_v<std::remove_const_t<J>, Json>;

// The member, or null if `object` is not an object or has no such member.
template <AnyJson J>
J* field(J& object, const char* name) {
  using Members = std::conditional_t<std::is_const_v<J>, const Json::object_t, Json::object_t>;
  auto* const members = object.template get_ptr<Members*>();
  if (members == nullptr) return nullptr;
  // Json::find would compare texts before their lengths.
  const std::string_view wanted(name);
  for (auto& [key, value] : *members)
    if (key == wanted) return &value;
  return nullptr;
}

// The member if it is an object (an array), otherwise null.
template <AnyJson J>
J* object_field(J& object, const char* name) {
  J* found = field(object, name);
  return found != nullptr && found->is_object() ? found : nullptr;
}
template <AnyJson J>
J* array_field(J& object, const char* name) {
  J* found = field(object, name);
  return found != nullptr && found->is_array() ? found : nullptr;
}

// object["extensions"][name] if it is an object, otherwise null.
template <AnyJson J>
J* extension_field(J& object, const char* name) {
  J* extensions = object_field(object, "extensions");
  return extensions == nullptr ? nullptr : object_field(*extensions, name);
}

// The element of an array, or null if `array` is not an array or the index is out of range.
template <AnyJson J>
J* element(J& array, int64_t index) {
  if (!array.is_array() || index < 0 || static_cast<uint64_t>(index) >= array.size()) return nullptr;
  return &array[static_cast<size_t>(index)];
}

// json[name][index] if it is an object, otherwise null; for accessors, meshes, images ...
template <AnyJson J>
J* top_level_object(J& json, const char* name, int64_t index) {
  J* array = array_field(json, name);
  J* found = array == nullptr ? nullptr : element(*array, index);
  return found != nullptr && found->is_object() ? found : nullptr;
}

// The number of elements of an array member, or 0 if there is no such array.
inline size_t array_size(const Json& object, const char* name) {
  const Json* array = array_field(object, name);
  return array == nullptr ? 0 : array->size();
}

// The value as an integer. 3.0 counts as 3, because some writers know only floats.
inline std::optional<int64_t> integer_value(const Json& value) {
  if (value.is_number_unsigned()) {
    const uint64_t number = *value.get_ptr<const Json::number_unsigned_t*>();
    if (number > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) return std::nullopt;
    return static_cast<int64_t>(number);
  }
  if (value.is_number_integer()) return *value.get_ptr<const Json::number_integer_t*>();
  if (value.is_number_float()) {
    constexpr double kExact = 9007199254740992.0;  // 2^53: above it a double skips integers
    const double number = *value.get_ptr<const Json::number_float_t*>();
    if (!(std::abs(number) <= kExact) || std::floor(number) != number) return std::nullopt;
    return static_cast<int64_t>(number);
  }
  return std::nullopt;
}

inline std::optional<double> number_value(const Json& value) {
  if (value.is_number_float()) return *value.get_ptr<const Json::number_float_t*>();
  if (value.is_number_unsigned()) return static_cast<double>(*value.get_ptr<const Json::number_unsigned_t*>());
  if (value.is_number_integer()) return static_cast<double>(*value.get_ptr<const Json::number_integer_t*>());
  return std::nullopt;
}

// Nothing if the member is missing or is not an integer.
inline std::optional<int64_t> integer_field(const Json& object, const char* name) {
  const Json* found = field(object, name);
  return found == nullptr ? std::nullopt : integer_value(*found);
}

// `fallback` if the member is missing, nothing if it is not an integer.
inline std::optional<int64_t> integer_field_or(const Json& object, const char* name, int64_t fallback) {
  const Json* found = field(object, name);
  return found == nullptr ? std::optional<int64_t>(fallback) : integer_value(*found);
}

inline std::optional<double> number_field(const Json& object, const char* name) {
  const Json* found = field(object, name);
  return found == nullptr ? std::nullopt : number_value(*found);
}

// Null if the member is missing or is not a string.
inline const std::string* string_field(const Json& object, const char* name) {
  const Json* found = field(object, name);
  return found == nullptr ? nullptr : found->get_ptr<const Json::string_t*>();
}

inline bool bool_field_or(const Json& object, const char* name, bool fallback) {
  const Json* found = field(object, name);
  if (found == nullptr || !found->is_boolean()) return fallback;
  return *found->get_ptr<const Json::boolean_t*>();
}

}  // namespace psplit
