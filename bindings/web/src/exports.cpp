// The exports of all modules: memory and errors.
#include "bindings/web/src/exports.h"

#include "bindings/web/src/heap.h"

namespace psplit::web {
namespace {

struct LastError {
  uint32_t code = 0;  // a StatusCode
  int32_t patch = -1;
  const char* message = nullptr;
  uint32_t message_bytes = 0;
};

Status error;
LastError last;

}  // namespace

bool keep_error(Status status) {
  error = std::move(status);
  last = {static_cast<uint32_t>(error.code()), static_cast<int32_t>(error.place().patch),
          error.message().data(), static_cast<uint32_t>(error.message().size())};
  return error.ok();
}

PSPLIT_WEB_EXPORT(allocate) void* allocate_bytes(size_t bytes) { return allocate(bytes); }
PSPLIT_WEB_EXPORT(release) void release_bytes(void* memory) { release(memory); }

// code, patch or -1, address and length of the message in UTF-8
PSPLIT_WEB_EXPORT(last_error) const LastError* last_error() { return &last; }

}  // namespace psplit::web
