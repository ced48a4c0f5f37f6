// Primitives that are larger than memory, decoded window by window.
#pragma once

#include <span>
#include <vector>

#include "gltf_ext/primitive/mesh_view.h"
#include "psplit/document.h"
#include "psplit/parallel.h"
#include "src/container/patch_container.h"
#include "src/cpu/checked_decode.h"

namespace psplit {

// Decodes into `mesh`, whose memory is a FileMemory (system/mapped_file.h), by the CPU's decoder. After
// each window of patches its part of the file and of the container leaves the memory. This takes about
// limit.bytes / 2 of memory, or the memory of one patch if that is more; in addition 4 bytes for each point of
// a patch's border. Every request must satisfy is_written_as_stored. With `findings`, which has one entry for
// each stream, the streams are checked as decode_checked says. Errors: as cpu_backend.
Status decode_into_file(const PatchContainer& container, std::span<const AttributeRequest> requests,
                        const LaidOutMesh& mesh, const MemoryLimit& limit, const ThreadPool& pool,
                        const Progress& progress = {}, std::vector<StreamFindings>* findings = nullptr);

// Decodes into a new temporary file in limit.folder, if the container's size justifies its counts.
Expected<MeshInFile> decode_to_file(const PatchContainer& container, std::span<const AttributeRequest> requests,
                                    const MemoryLimit& limit, const ThreadPool& pool,
                                    std::vector<StreamFindings>* findings = nullptr);

}  // namespace psplit
