// Meshes laid out for the buffers of a document, in memory or in a file.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "gltf_ext/primitive/accessors.h"
#include "psplit/decode.h"
#include "system/mapped_file.h"

namespace psplit {

MeshView view_of(const Mesh& mesh);
// The indices with the component type of a new accessor. They are the mesh's own, which must outlive this, or
// narrower copies.
class IndexData {
 public:
  explicit IndexData(const Mesh& mesh);
  IndexData(const IndexData&) = delete;
  IndexData& operator=(const IndexData&) = delete;
  operator const ValuesView&() const { return values_; }
  bool are_narrow() const { return !narrow_.empty(); }  // copies, not the mesh's own

 private:
  ValuesView values_;
  std::vector<std::byte> narrow_;
};
// Appends a mesh to the document's buffers. Returns a primitive with its attributes and indices. Large arrays
// of the mesh become buffers; the others are copied and freed. With `are_points` it is one of points, and the
// mesh has no faces.
Json append_primitive(Document& document, Mesh mesh, bool are_points = false);

// A mesh laid out as PrimitiveEditor stores it: the attributes, then the indices, each on a 4-byte boundary.
struct LaidOutMesh {
  MeshView view;
  PrimitiveBuffers buffers;       // the memory of `view`, to be written
  std::vector<uint64_t> offsets;  // in the memory, of each attribute, then of the indices
  uint64_t end = 0;
};
// Lays a mesh out in `memory` from the offset `begin` on. Without memory, only offsets and end are known.
LaidOutMesh lay_out(std::span<const AttributeRequest> requests, uint32_t point_count, uint32_t face_count,
                    uint64_t begin, std::span<uint8_t> memory);

// A mesh in a temporary file, which may be larger than the memory.
struct MeshInFile {
  FileMemory memory;
  LaidOutMesh laid_out;
};
// Room for a mesh; its bytes are zeros. Errors: as for the file.
Expected<MeshInFile> lay_out_in_file(std::span<const AttributeRequest> requests, uint32_t point_count,
                                     uint32_t face_count, const std::filesystem::path& folder);

// Whether values that a decoder writes tightly packed, apart from the stride, are what a buffer view holds:
// the columns of some matrices are padded there.
bool is_written_as_stored(const AttributeRequest& request);

}  // namespace psplit
