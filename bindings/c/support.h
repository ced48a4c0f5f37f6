// What all functions of the C interface share: structs of the caller's, errors and handles.
#pragma once

#include <atomic>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"
#include "psplit/psplit.h"
#include "src/catch_exceptions.h"

struct psplit_pool {
  psplit::ThreadPool threads;
};

struct psplit_stop {
  std::atomic<bool> flag{false};
};

namespace psplit::c {

// Bytes of a struct in the first version of the interface: the least that callers may state. A struct that has
// grown keeps its first size here.
template <typename Struct>
inline constexpr uint32_t kFirstSize = sizeof(Struct);

// Whether a caller's struct may have that size. Elements of an array are aligned.
template <typename Struct>
bool is_size_of(uint32_t size) {
  return size >= kFirstSize<Struct> && size % alignof(Struct) == 0;
}

// A copy of a caller's struct; members that its version does not have are 0. `name` is for errors.
template <typename Struct>
Expected<Struct> read_struct(const Struct* from, const char* name) {
  static_assert(std::is_trivially_copyable_v<Struct>);
  if (from == nullptr) return wrong_usage(std::string(name) + " is null");
  const uint32_t size = from->struct_size;
  if (!is_size_of<Struct>(size))
    return wrong_usage(std::string(name) + " has the struct_size " + std::to_string(size));
  const auto* bytes = reinterpret_cast<const unsigned char*>(from);
  for (size_t i = sizeof(Struct); i < size; ++i)
    if (bytes[i] != 0) return unsupported(std::string(name) + " has members of a newer version of psplit");
  Struct read{};
  std::memcpy(&read, from, std::min<size_t>(size, sizeof(Struct)));
  return read;
}

// Sets what the caller's version has of the struct, and the rest of a larger one to 0.
template <typename Struct>
Status write_struct(Struct* to, Struct value, const char* name) {
  if (to == nullptr) return wrong_usage(std::string(name) + " is null");
  const uint32_t size = to->struct_size;
  if (!is_size_of<Struct>(size))
    return wrong_usage(std::string(name) + " has the struct_size " + std::to_string(size));
  value.struct_size = size;
  std::memcpy(to, &value, std::min<size_t>(size, sizeof(Struct)));
  if (size > sizeof(Struct))
    std::memset(reinterpret_cast<unsigned char*>(to) + sizeof(Struct), 0, size - sizeof(Struct));
  return {};
}

// The element of a caller's array, whose elements have the size that the first one states.
template <typename Struct>
Struct* element_of(Struct* array, size_t index) {
  using Byte = std::conditional_t<std::is_const_v<Struct>, const unsigned char, unsigned char>;
  return reinterpret_cast<Struct*>(reinterpret_cast<Byte*>(array) + index * array->struct_size);
}

// Copies of all elements.
template <typename Struct>
Expected<std::vector<Struct>> read_array(const Struct* array, size_t count, const char* name) {
  std::vector<Struct> elements;
  for (size_t i = 0; i < count; ++i) {
    // The first element is checked before its size is used.
    Expected<Struct> read = read_struct(i == 0 ? array : element_of(array, i), name);
    if (!read) return read.status();
    if (read->struct_size != array->struct_size)
      return wrong_usage(std::string(name) + ": elements of an array have different struct_sizes");
    elements.push_back(*read);
  }
  return elements;
}

// Gives the caller the error, or success, and returns its code.
psplit_code report(const Status& status, psplit_error* error);
psplit_code report_no_memory(psplit_error* error) noexcept;

// Runs the body of a function, which returns a Status. No exception leaves it.
template <typename Body>
psplit_code guarded(psplit_error* error, Body body) noexcept {
  try {
    return report(catch_exceptions(body), error);
  } catch (...) {  // no memory for a text
    return report_no_memory(error);
  }
}

// Sets the handle that a function returns, null until it has one.
template <typename Handle, typename Make>
psplit_code make_handle(Handle** out, psplit_error* error, Make make) noexcept {
  if (out != nullptr) *out = nullptr;
  return guarded(error, [&]() -> Status {
    if (out == nullptr) return wrong_usage("there is no place for the new handle");
    Expected<std::unique_ptr<Handle>> made = make();
    if (!made) return made.status();
    *out = made->release();
    return {};
  });
}

inline Status null_handle() { return wrong_usage("a handle is null"); }

// Threads for a call: the caller's pool, or some of its own.
class Threads {
 public:
  static Expected<Threads> of(const psplit_pool* pool, int32_t count);
  const ThreadPool& pool() const { return kept_ != nullptr ? *kept_ : *own_; }

 private:
  const ThreadPool* kept_ = nullptr;
  std::unique_ptr<const ThreadPool> own_;
};
// kUsage if `count` is negative or above the largest number of threads.
Status check_thread_count(int32_t count);

// glTF's type for one of ours; nothing if it has none.
std::optional<ComponentType> component_type_of(psplit_type type);

// A copy of the caller's bytes if it wants one.
struct SourceBytes {
  const uint8_t* data = nullptr;
  size_t size = 0;
  std::shared_ptr<const std::vector<uint8_t>> copy{};
};
Expected<SourceBytes> source_bytes(const void* data, size_t size, bool copies);

}  // namespace psplit::c
