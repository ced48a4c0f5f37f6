#include "gltf_ext/files/io_error.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace psplit {
namespace {

constexpr std::array kPassing = {ENOSPC, EDQUOT, ENOMEM, EMFILE, ENFILE,    EAGAIN,
                                 EINTR,  ESTALE, EBUSY,  EIO,    ETIMEDOUT, ENOLCK};

}  // namespace

Status io_error(const std::string& what, int error, Place place) {
  const bool passes = std::ranges::find(kPassing, error) != kPassing.end();
  return {passes ? StatusCode::kMayPass : StatusCode::kIo, what + ": " + std::strerror(error),
          std::move(place)};
}

}  // namespace psplit
