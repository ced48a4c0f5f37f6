#include "bindings/c/support.h"

#include "psplit/decode.h"

namespace psplit::c {
namespace {

constexpr int32_t kMostThreads = 4096;

psplit_code code_of(StatusCode code) {
  switch (code) {
    case StatusCode::kOk: return PSPLIT_OK;
    case StatusCode::kUsage: return PSPLIT_ERROR_USAGE;
    case StatusCode::kInvalidInput: return PSPLIT_ERROR_INVALID_INPUT;
    case StatusCode::kUnsupported: return PSPLIT_ERROR_UNSUPPORTED;
    case StatusCode::kCancelled: return PSPLIT_ERROR_CANCELLED;
    case StatusCode::kOutOfMemory: return PSPLIT_ERROR_NO_MEMORY;
    // Nothing here uses files or compares meshes.
    case StatusCode::kIo:
    case StatusCode::kDiffers:
    case StatusCode::kMayPass:
    case StatusCode::kRuntimeFailure: break;
  }
  return PSPLIT_ERROR_FAILURE;
}

// The longest beginning that fits, and does not end within a character.
size_t fitting_bytes(const char* text, size_t size, size_t room) {
  if (size <= room) return size;
  while (room > 0 && (static_cast<unsigned char>(text[room]) & 0xc0) == 0x80) --room;
  return room;
}

void set_error(psplit_error* error, psplit_code code, const Place& place, const char* text, size_t size) {
  if (error == nullptr || !is_size_of<psplit_error>(error->struct_size)) return;
  psplit_error value{};
  value.code = code;
  value.mesh = place.mesh;
  value.primitive = place.primitive;
  value.patch = place.patch;
  std::memcpy(value.text, text, fitting_bytes(text, size, sizeof(value.text) - 1));
  (void)write_struct(error, value, "");
}

}  // namespace

psplit_code report(const Status& status, psplit_error* error) {
  const psplit_code code = code_of(status.code());
  const std::string text = status.ok() ? std::string() : status.to_string();
  set_error(error, code, status.place(), text.data(), text.size());
  return code;
}

psplit_code report_no_memory(psplit_error* error) noexcept {
  static constexpr char kText[] = "there is not enough memory";
  if (error != nullptr && is_size_of<psplit_error>(error->struct_size)) {
    error->code = PSPLIT_ERROR_NO_MEMORY;
    error->mesh = error->primitive = error->patch = -1;
    std::memcpy(error->text, kText, sizeof(kText));
  }
  return PSPLIT_ERROR_NO_MEMORY;
}

Status check_thread_count(int32_t count) {
  if (count < 0 || count > kMostThreads)
    return wrong_usage(std::to_string(count) + " threads: 0 to " + std::to_string(kMostThreads) +
                       " are possible");
  return {};
}

Expected<Threads> Threads::of(const psplit_pool* pool, int32_t count) {
  Threads threads;
  if (pool != nullptr) {
    threads.kept_ = &pool->threads;
    return threads;
  }
  if (Status status = check_thread_count(count); !status.ok()) return status;
  threads.own_ = std::make_unique<const ThreadPool>(count);
  return threads;
}

std::optional<ComponentType> component_type_of(psplit_type type) {
  switch (type) {
    case PSPLIT_INT8: return ComponentType::kInt8;
    case PSPLIT_UINT8: return ComponentType::kUint8;
    case PSPLIT_INT16: return ComponentType::kInt16;
    case PSPLIT_UINT16: return ComponentType::kUint16;
    case PSPLIT_UINT32: return ComponentType::kUint32;
    case PSPLIT_FLOAT32: return ComponentType::kFloat32;
    default: return std::nullopt;
  }
}

Expected<SourceBytes> source_bytes(const void* data, size_t size, bool copies) {
  if (data == nullptr && size > 0) return wrong_usage("the bytes are null");
  const auto* bytes = static_cast<const uint8_t*>(data);
  if (!copies) return SourceBytes{bytes, size};
  auto copy = std::make_shared<const std::vector<uint8_t>>(bytes, bytes + size);
  return SourceBytes{copy->data(), copy->size(), copy};
}

}  // namespace psplit::c

using namespace psplit;
using namespace psplit::c;

uint32_t psplit_version() { return PSPLIT_VERSION; }

const char* psplit_code_name(psplit_code code) {
  switch (code) {
    case PSPLIT_OK: return "ok";
    case PSPLIT_ERROR_USAGE: return "wrong usage";
    case PSPLIT_ERROR_INVALID_INPUT: return "invalid input";
    case PSPLIT_ERROR_FAILURE: return "failure";
    case PSPLIT_ERROR_UNSUPPORTED: return "unsupported";
    case PSPLIT_ERROR_CANCELLED: return "cancelled";
    case PSPLIT_ERROR_NO_MEMORY: return "no memory";
    default: return "unknown";
  }
}

psplit_code psplit_pool_create(int32_t threads, psplit_pool** pool, psplit_error* error) {
  return make_handle(pool, error, [&]() -> Expected<std::unique_ptr<psplit_pool>> {
    if (Status status = check_thread_count(threads); !status.ok()) return status;
    return std::unique_ptr<psplit_pool>(new psplit_pool{ThreadPool(threads)});
  });
}
int32_t psplit_pool_threads(const psplit_pool* pool) {
  return pool == nullptr ? 0 : pool->threads.thread_count();
}
void psplit_pool_free(psplit_pool* pool) { delete pool; }

psplit_code psplit_stop_create(psplit_stop** stop, psplit_error* error) {
  return make_handle(
      stop, error, []() -> Expected<std::unique_ptr<psplit_stop>> { return std::make_unique<psplit_stop>(); });
}
void psplit_stop_set(psplit_stop* stop, int32_t value) {
  if (stop != nullptr) stop->flag = value != 0;
}
void psplit_stop_free(psplit_stop* stop) { delete stop; }

void psplit_release_scratch() {
  try {
    release_scratch();
  } catch (...) {  // locks alone could throw
  }
}
