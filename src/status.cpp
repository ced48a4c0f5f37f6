#include "psplit/base.h"

namespace psplit {

Status::Status() = default;
Status::Status(StatusCode code, std::string message, Place place)
    : code_(code), message_(std::move(message)), place_(std::move(place)) {}
Status::Status(StatusCode code, std::string message) : code_(code), message_(std::move(message)) {}
Status::Status(StatusCode code, const char* message) : code_(code), message_(message) {}
Status::Status(Status&&) noexcept = default;
Status::Status(const Status&) = default;
Status& Status::operator=(Status&&) noexcept = default;
Status& Status::operator=(const Status&) = default;
Status::~Status() = default;

Status Status::at(const Place& outer) && {
  if (place_.file.empty()) place_.file = outer.file;
  if (place_.mesh < 0) place_.mesh = outer.mesh;
  if (place_.primitive < 0) place_.primitive = outer.primitive;
  if (place_.patch < 0) place_.patch = outer.patch;
  return std::move(*this);
}

std::string Status::to_string() const {
  std::string where = place_.file;
  const auto add = [&](const char* what, int64_t number, const char* separator) {
    if (number < 0) return;
    if (!where.empty()) where += separator;
    where += what + std::to_string(number);
  };
  add("mesh ", place_.mesh, ": ");
  add("primitive ", place_.primitive, place_.mesh >= 0 ? ", " : ": ");
  add("patch ", place_.patch, place_.mesh >= 0 ? ", " : ": ");
  return where.empty() ? message_ : where + ": " + message_;
}

}  // namespace psplit
