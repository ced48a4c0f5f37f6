// Values of the decoder as numpy arrays, and Python's memory as the decoder takes it.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "psplit/base.h"
#include "psplit/draco_types.h"
#include "psplit/mesh.h"

namespace psplit::python {

namespace py = pybind11;

// What a failed call raises. throw_if_failed throws it; the module's translator makes gltf_psplit.Error of it.
struct StatusError {
  Status status;
};
inline void throw_if_failed(const Status& status) {
  if (!status.ok()) throw StatusError{status};
}
template <typename T>
T value_or_throw(Expected<T>&& expected) {
  throw_if_failed(expected.status());
  return std::move(*expected);
}
// The exception of a status, which is not raised.
py::object exception_of(const Status& status);

// The bytes of an object with a contiguous buffer (bytes, mmap, an array). They stay where they are as long as
// this object lives, so it needs the interpreter's lock when it goes. TypeError for other objects.
class HeldBytes {
 public:
  explicit HeldBytes(const py::handle& object);
  HeldBytes(HeldBytes&& other) noexcept : view_(std::exchange(other.view_, {})) {}
  HeldBytes& operator=(HeldBytes&&) = delete;
  ~HeldBytes() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }
  std::span<const uint8_t> bytes() const {
    return {static_cast<const uint8_t*>(view_.buf), static_cast<size_t>(view_.len)};
  }

 private:
  Py_buffer view_{};
};

// numpy's type of values: "f4", "u1". Draco's bools are bytes, because nothing limits them to 0 and 1.
const char* type_code(DataType type);
const char* type_code(ComponentType type);

// Writable arrays that own the values: nothing is copied.
py::array array_of(Array<std::byte>&& values, const char* type, size_t rows, size_t columns);
py::array array_of(Array<std::array<uint32_t, 3>>&& faces);

// Where values of the caller's array are: `stride` bytes from one row to the next. Null: there is no array.
struct OutPlace {
  std::byte* data = nullptr;
  size_t stride = 0;
};

// The caller's arrays for a result, by their names in the dict `out`, or by an attribute's number. Reading the
// dict needs the interpreter's lock; asking for memory does not.
class OutArrays {
 public:
  static constexpr const char* kFaces = "faces";

  OutArrays() = default;
  // `dict` may be None. kUsage for arrays that cannot be filled row by row in any order: arrays that are not
  // writable, not in the machine's byte order, that have negative strides, or rows with gaps in them, and rows
  // or arrays that share memory.
  explicit OutArrays(const py::object& dict);

  // The memory for rows x columns values. Errors: kUsage if the array has another type or shape.
  Expected<OutPlace> take(const std::string& name, std::optional<uint32_t> unique_id, const char* type,
                          size_t rows, size_t columns);
  // The memory for faces, which have no gaps.
  Expected<std::byte*> take_faces(size_t face_count);
  // The array that was taken, or nothing.
  py::object taken(const std::string& name, std::optional<uint32_t> unique_id) const;
  py::object taken_faces() const { return taken(kFaces, {}); }
  // kUsage if an array was not taken.
  Status all_taken() const;

 private:
  struct Given {
    py::array array;
    std::string type, shape;
    OutPlace place{};
    bool is_taken = false;
  };
  using Key = std::variant<std::string, uint32_t>;
  static Key key_of(const py::handle& key);
  const Given* find(const std::string& name, std::optional<uint32_t> unique_id) const;

  std::map<Key, Given> given_;
};

}  // namespace psplit::python
