// Errors with their place. All host code of psplit returns them; no exceptions cross its API.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "src/export.h"

namespace psplit {

enum class StatusCode : uint8_t {
  kOk,
  kUsage,           // the caller's arguments are wrong
  kIo,              // a file cannot be read or written
  kInvalidInput,    // the input is malformed
  kRuntimeFailure,  // what should not fail failed
  kUnsupported,     // the input is valid, but uses what psplit does not support
  kCancelled,       // the caller stopped the work
  kDiffers,         // meshes that should be the same are not
  kOutOfMemory,     // the same call may succeed later, alone or with more memory
  kMayPass,         // the same call may succeed later: a full disk, a lock, an interruption
};

// The place of an error. -1 and "" mean that a part is not known or does not apply.
struct Place {
  std::string file{};
  int64_t mesh = -1;
  int64_t primitive = -1;
  int64_t patch = -1;
};

class [[nodiscard]] PSPLIT_EXPORT Status {
 public:
  // All in status.cpp: an error is rare, but the code of each function that may return one has many of these.
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

  // Fills in the parts of the place that are not known yet. Callers know more than callees.
  Status at(const Place& outer) &&;

  // "bunny.glb: mesh 0, primitive 1, patch 7: connectivity ends early"
  std::string to_string() const;

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
  Place place_;
};

// The messages of statuses with a place are strings, all others may be literals as well.
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
