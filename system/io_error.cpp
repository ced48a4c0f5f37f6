#include "system/io_error.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace psplit {
namespace {

constexpr std::array kPassing = {
    ENOSPC, EMFILE, ENFILE, EAGAIN, EINTR, EBUSY, EIO, ETIMEDOUT, ENOLCK,
#ifdef EDQUOT
    EDQUOT,
#endif
#ifdef ESTALE
    ESTALE,
#endif
};

StatusCode code_of(int error) {
  if (error == ENOMEM) return StatusCode::kOutOfMemory;
  return std::ranges::find(kPassing, error) != kPassing.end() ? StatusCode::kMayPass : StatusCode::kIo;
}

}  // namespace

Status io_error(const std::string& what, int error, Place place) {
  return {code_of(error), what + ": " + std::strerror(error), std::move(place)};
}

Status io_error(const std::string& what, const std::error_code& error, Place place) {
  const std::error_condition condition = error.default_error_condition();
  if (condition.category() == std::generic_category())
    return io_error(what, condition.value(), std::move(place));
  return io_failure(what + ": " + error.message(), std::move(place));
}

}  // namespace psplit
