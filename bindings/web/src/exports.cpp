// The exports of all modules: memory and errors.
#include "bindings/web/src/exports.h"

#include <optional>
#include <string>

#include "bindings/web/src/heap.h"

namespace psplit::web {
namespace {

struct LastError {
  uint32_t code = 0;  // a StatusCode
  int32_t patch = -1;
  const char* message = nullptr;
  uint32_t message_bytes = 0;
};

// It keeps its memory: a message that moved with each error would separate the free memory before it from the
// free memory after it. No static object has a constructor: the linker would have it called with each call of
// an export.
[[clang::no_destroy]] constinit std::optional<std::string> message;
constinit LastError last;

}  // namespace

bool keep_error(Status status) {
  if (status.ok()) return true;
  if (!message) message.emplace();
  message->assign(status.message());
  last = {static_cast<uint32_t>(status.code()), static_cast<int32_t>(status.place().patch), message->data(),
          static_cast<uint32_t>(message->size())};
  return false;
}

PSPLIT_WEB_EXPORT(allocate) void* allocate_bytes(size_t bytes) { return allocate(bytes); }
PSPLIT_WEB_EXPORT(release) void release_bytes(void* memory) { release(memory); }

// code, patch or -1, address and length of the message in UTF-8
PSPLIT_WEB_EXPORT(last_error) const LastError* last_error() { return &last; }

}  // namespace psplit::web
