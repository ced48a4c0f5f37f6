// Decoding a container, with the checks of a validator on the way: each stream is decoded once.
#pragma once

#include <span>
#include <vector>

#include "psplit/decode.h"
#include "src/container/patch_container.h"

namespace psplit {

// Violations of the specification in a stream that can be decoded all the same. The statuses have the patch as
// their place.
struct StreamFindings {
  Status types;   // an attribute is stored in another type than its request's
  Status copies;  // the copy of a point has other values than the point; always ok for the residue
};

struct CheckedMesh {
  Mesh mesh;
  std::vector<StreamFindings> streams;  // one for each stream
};

// Decodes like cpu_backend, and checks each stream. Keeps the values of all copies until the end. `container`
// comes from open_container. Errors: as for cpu_backend.
Expected<CheckedMesh> decode_checked(const PatchContainer& container,
                                     std::span<const AttributeRequest> requests, const ThreadPool& pool);

// A container and the caller's memory for its mesh. `findings` has an element for each stream.
struct CheckedTask {
  DecodeTask task;
  PrimitiveBuffers buffers;
  std::vector<StreamFindings>* findings;
};
// Decodes and checks several containers, into the caller's memory, like decode_into of cpu_backend. Returns a
// status for each task.
std::vector<Status> decode_checked_into(std::span<const CheckedTask> tasks, const ThreadPool& pool,
                                        const Watch& watch);

}  // namespace psplit
