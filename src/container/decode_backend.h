// A decode backend turns containers into meshes in the caller's memory. The loader takes its backend as a
// value: the CPU's by default. CUDA and libdraco have backends of their own.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/span.h"
#include "src/status.h"

namespace psplit {

// Opened bytes, as all decoders take them: checked once, and shared between threads. Opaque: callers only hand
// on a reference. CompressedPrimitive::container (src/loader/loader.h) gives it, and says how long it lives.
struct PatchContainer;

// Requests a Draco attribute, by its unique id, as a glTF attribute.
struct AttributeRequest {
  std::string semantic;
  uint32_t unique_id = 0;
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;
  bool normalized = false;

  size_t value_bytes() const { return component_bytes(component_type) * component_count; }
};

// Has the positions of all points that the faces of a patch use, and that it owns, as decoders return them. If
// `low` is above `high`, it has none that is finite.
struct PatchBox {
  std::array<double, 3> low{}, high{};
};

// The caller's memory, as bytes. Spans, vectors and arrays of plain values convert to it.
class WritableBytes : public Span<std::byte> {
 public:
  WritableBytes() = default;
  template <typename Values,
            typename T = std::remove_reference_t<decltype(*std::data(std::declval<Values&>()))>,
            typename = std::enable_if_t<std::is_trivially_copyable_v<T> && !std::is_const_v<T> &&
                                        std::is_convertible_v<Values, Span<T>>>>
  WritableBytes(Values&& values)  // NOLINT: implicit
      : Span(reinterpret_cast<std::byte*>(std::data(values)), std::size(values) * sizeof(T)) {}
};

// Where an attribute goes: one value for each point, `stride` bytes from one value to the next. A stride of 0
// means tightly packed. Any alignment is allowed. The bytes between two values are not touched.
struct AttributeBuffer {
  WritableBytes bytes;
  size_t stride = 0;
};

// The caller's memory for one mesh. No two parts of it overlap.
struct PrimitiveBuffers {
  WritableBytes indices;                      // three for each face, tightly packed, aligned to their size
  uint32_t index_bytes = 4;                   // 4, or 2 if there are no more than 65,535 points
  std::vector<AttributeBuffer> attributes{};  // one for each requested attribute
};

// A container, and the attributes that become one mesh. Both must outlive decoding.
struct DecodeTask {
  const PatchContainer* container = nullptr;
  Span<const AttributeRequest> requests;
};

// Gives a backend the memory for a task's mesh, or the error that ends the task. A backend calls it when it
// knows the counts, which for some stock streams is after decoding. The memory must have room for them, and its
// strides must not be 0. Called from any thread, for one task possibly again with the same counts.
using BuffersFor =
    std::function<Expected<PrimitiveBuffers>(size_t task, uint32_t point_count, uint32_t face_count)>;

// Called with the number of finished steps and their total, from any thread.
using Progress = std::function<void(size_t done, size_t total)>;

// How a caller follows work, and ends it.
struct Watch {
  Progress progress{};                      // in the steps that a backend takes: patches, or tasks
  const std::atomic<bool>* stop = nullptr;  // decoding ends when it becomes true; may be null

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

struct PSPLIT_EXPORT DecodeBackend {
  std::string name;
  // Decodes all tasks, and stitches their patches. Returns a status for each task, in their order. The error of
  // one task does not affect another. After an error the task's memory may hold anything. Thread-safe.
  std::function<std::vector<Status>(Span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                    const ThreadPool& pool, const Watch& watch)>
      decode_into;

  // Decodes to new meshes: a mesh or an error for each task. Errors: those of decode_into and of allocate_mesh.
  std::vector<Expected<Mesh>> decode(Span<const DecodeTask> tasks, const ThreadPool& pool,
                                     const Progress& progress = {}) const;
  Expected<Mesh> decode(const PatchContainer& container, Span<const AttributeRequest> requests,
                        const ThreadPool& pool) const;
};

// Gives `mesh` the counts, the attributes and the memory for them, not zeroed. Errors: kInvalidInput if
// `stored_bytes`, which the mesh is decoded from, do not justify that much memory.
PSPLIT_EXPORT Expected<PrimitiveBuffers> allocate_mesh(uint32_t point_count, uint32_t face_count,
                                                       Span<const AttributeRequest> requests,
                                                       uint64_t stored_bytes, Mesh& mesh);

}  // namespace psplit
