// Used by all public headers: views of arrays, and errors with their place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "psplit/version.h"

#if __cplusplus > 201703L && __has_include(<ranges>)
#include <ranges>
#endif

// PSPLIT_EXPORT marks the functions and classes that shared libraries export; they hide all others.
// PSPLIT_HIDDEN is for members of an exported class.
#if defined(_WIN32) && defined(PSPLIT_BUILDS_SHARED)
#define PSPLIT_EXPORT __declspec(dllexport)
#elif defined(_WIN32) && defined(PSPLIT_SHARED)
#define PSPLIT_EXPORT __declspec(dllimport)
#elif defined(_WIN32)
#define PSPLIT_EXPORT
#else
#define PSPLIT_EXPORT [[gnu::visibility("default")]]
#endif

#if defined(_WIN32)
#define PSPLIT_HIDDEN
#else
#define PSPLIT_HIDDEN [[gnu::visibility("hidden")]]
#endif

namespace psplit {

// A view of consecutive elements, like std::span. Public headers use it because they are C++17, and because
// std::span would become part of the symbol names that a library exports. It converts from and to std::span. It
// owns nothing: the elements must outlive it. Cheap to copy.
template <typename T>
class Span {
 public:
  using element_type = T;
  using value_type = std::remove_cv_t<T>;
  using iterator = T*;

  constexpr Span() = default;
  constexpr Span(T* data, size_t size) : data_(data), size_(size) {}
  // Views an array, or any container with data() and size().
  template <
      typename Values, typename Element = std::remove_pointer_t<decltype(std::data(std::declval<Values&>()))>,
      typename = std::enable_if_t<std::is_convertible_v<Element (*)[], T (*)[]> &&
                                  !std::is_same_v<std::remove_cv_t<std::remove_reference_t<Values>>, Span>>>
  constexpr Span(Values&& values)  // NOLINT: implicit
      : data_(std::data(values)), size_(std::size(values)) {}

  constexpr T* data() const { return data_; }
  constexpr size_t size() const { return size_; }
  constexpr size_t size_bytes() const { return size_ * sizeof(T); }
  constexpr bool empty() const { return size_ == 0; }
  constexpr T* begin() const { return data_; }
  constexpr T* end() const { return data_ + size_; }
  constexpr T& operator[](size_t i) const { return data_[i]; }
  constexpr T& front() const { return data_[0]; }
  constexpr T& back() const { return data_[size_ - 1]; }
  // `count` and `offset` are at most size().
  constexpr Span first(size_t count) const { return {data_, count}; }
  constexpr Span last(size_t count) const { return {data_ + (size_ - count), count}; }
  constexpr Span subspan(size_t offset) const { return {data_ + offset, size_ - offset}; }
  constexpr Span subspan(size_t offset, size_t count) const { return {data_ + offset, count}; }

 private:
  T* data_ = nullptr;
  size_t size_ = 0;
};
template <typename Values>
Span(Values&&) -> Span<std::remove_pointer_t<decltype(std::data(std::declval<Values&>()))>>;
template <typename T>
Span(T*, size_t) -> Span<T>;

// ---- Errors ----

// All host code of psplit returns them. Loading and encoding also turn exceptions of the caller's callbacks and
// executors into errors: kRuntimeFailure with the exception's text, kOutOfMemory for std::bad_alloc.
enum class StatusCode : uint8_t {
  kOk,
  kUsage,           // the caller's arguments are wrong
  kIo,              // a file cannot be read or written
  kInvalidInput,    // the input is malformed
  kRuntimeFailure,  // an internal error, or a failure of the device or system
  kUnsupported,     // the input is valid, but uses a feature that psplit does not support
  kCancelled,       // the caller stopped the work
  kDiffers,         // meshes that should be equal differ
  kOutOfMemory,     // the same call may succeed later, alone or with more memory
  kMayPass,         // the same call may succeed later: a full disk, a lock, an interruption
};

// The place of an error. -1 and "" mean that a part is unknown or does not apply.
struct Place {
  std::string file{};
  int64_t mesh = -1;
  int64_t primitive = -1;
  int64_t patch = -1;
};

class [[nodiscard]] PSPLIT_EXPORT Status {
 public:
  // Defined in status.cpp to keep callers small: errors are rare, but each function that may fail constructs
  // many statuses.
  Status();
  Status(StatusCode code, std::string message, Place place);
  Status(StatusCode code, std::string message);
  Status(StatusCode code, const char* message);
  Status(Status&&) noexcept;
  Status(const Status&);
  Status& operator=(Status&&) noexcept;
  Status& operator=(const Status&);
  ~Status();

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& message() const { return message_; }
  const Place& place() const { return place_; }

  // Fills in the parts of the place that are still unknown. Callers add what callees cannot know.
  Status at(const Place& outer) &&;

  // "bunny.glb: mesh 0, primitive 1, patch 7: connectivity ends early"
  std::string to_string() const;

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
  Place place_;
};

// A message with a place is a std::string; without a place it may also be a literal.
template <StatusCode kCode>
struct StatusOf {
  Status operator()(std::string message, Place place) const {
    return {kCode, std::move(message), std::move(place)};
  }
  Status operator()(std::string message) const { return {kCode, std::move(message)}; }
  Status operator()(const char* message) const { return {kCode, message}; }
};
inline constexpr StatusOf<StatusCode::kInvalidInput> invalid_input;
inline constexpr StatusOf<StatusCode::kUsage> wrong_usage;
inline constexpr StatusOf<StatusCode::kUnsupported> unsupported;
inline constexpr StatusOf<StatusCode::kRuntimeFailure> runtime_failure;
inline constexpr StatusOf<StatusCode::kIo> io_failure;
inline constexpr StatusOf<StatusCode::kOutOfMemory> out_of_memory;
inline Status cancelled() { return {StatusCode::kCancelled, "cancelled"}; }

// A value, or the status that says why it could not be made.
template <typename T>
class [[nodiscard]] Expected {
 public:
  Expected(T value) : content_(std::move(value)) {}         // NOLINT: implicit on purpose
  Expected(Status status) : content_(std::move(status)) {}  // NOLINT: implicit on purpose

  bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }
  // The value, or null after an error. Nothing here throws; value(), * and -> throw std::bad_variant_access
  // after an error, which callers check first.
  T* value_if() noexcept { return std::get_if<T>(&content_); }
  const T* value_if() const noexcept { return std::get_if<T>(&content_); }
  T& value() { return std::get<T>(content_); }
  const T& value() const { return std::get<T>(content_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  // Ok if there is a value.
  Status status() const { return ok() ? Status() : std::get<Status>(content_); }

 private:
  std::variant<T, Status> content_;
};

}  // namespace psplit

#if defined(__cpp_lib_ranges)
template <typename T>
inline constexpr bool std::ranges::enable_borrowed_range<psplit::Span<T>> = true;
template <typename T>
inline constexpr bool std::ranges::enable_view<psplit::Span<T>> = true;
#endif
