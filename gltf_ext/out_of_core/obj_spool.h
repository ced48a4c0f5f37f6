// The statements of an OBJ of any size in temporary files, until all that faces name is known.
#pragma once

#include <array>
#include <filesystem>

#include "gltf_ext/out_of_core/file_blocks.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "mesh_files/obj.h"

namespace psplit {

class ObjSpool : public ObjSink {
 public:
  static Expected<ObjSpool> create(const std::filesystem::path& folder);

  Status add_position(const PrecisePosition& position) override;
  Status add_value(ObjValues kind, std::span<const float> value) override;
  Status add_face(std::span<const ObjCorner> corners) override;

  // About what write_to gives: the number of points is known only then.
  ExpectedSizes sizes() const;

  // Gives the points and triangles to `mesh`, once everything was added, and the space of the files back. A
  // corner that was seen recently is the same point again; others that are equal become one later, because the
  // parts of a mesh merge equal points. kUnsupported if only some faces have texture coordinates or normals:
  // they would be several primitives. `keeps_duplicates`: corners with other indices stay apart, so points get
  // the indices as their MeshSpool::kPointNumber.
  Status write_to(MeshSpool& mesh, Losses& losses, bool keeps_duplicates);

 private:
  struct Column {
    AppendFile file{};
    PagedFile pages{};
    uint64_t count = 0;
    size_t components = 3;
    size_t component_bytes = sizeof(float);
    size_t value_bytes() const { return components * component_bytes; }
  };
  Column& column(ObjValues kind) { return columns_[static_cast<size_t>(kind)]; }
  const Column& column(ObjValues kind) const { return columns_[static_cast<size_t>(kind)]; }
  bool has_colors() const;

  class Writer;
  std::array<Column, 4> columns_;
  AppendFile faces_;  // of each face the number of its corners, and these
  uint64_t face_count_ = 0, triangle_count_ = 0;
};

}  // namespace psplit
