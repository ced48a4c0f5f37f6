// A decoded Draco stream, whose values are written when a page asks for them.
#pragma once

#include <memory>

#include "src/container/patch_container.h"
#include "src/core/decode_patch.h"

namespace psplit::web {

// Where the values of an attribute go: one after the other.
class ValuePlaces {
 public:
  ValuePlaces(uint8_t* out, size_t stride) : out_(out), stride_(stride) {}

  uint8_t* operator()(uint32_t point) const { return out_ + point * stride_; }

 private:
  uint8_t* out_;
  size_t stride_;
};

class DecodedStream {
 public:
  using Patch = core::Patch<uint32_t>;
  using Attribute = core::Attribute<uint32_t>;

  // Decodes a Draco 2.2 mesh stream; a module for Draco streams alone also a point cloud of 2.2 or 2.3, which
  // becomes a patch without faces. Any bytes may be given. Errors: kUnsupported for other bitstreams,
  // kInvalidInput for everything else that does not decode.
  static Expected<std::unique_ptr<DecodedStream>> decode(std::unique_ptr<uint8_t[]> bytes, size_t size);

  const uint8_t* bytes() const { return bytes_.get(); }

  // Its point_at is not as the core left it: see faces().
  const Patch& patch() const { return patch_; }

  // Three numbers of points for each face.
  const uint32_t* faces() const { return patch_.point_at.data(); }
  // As above, in numbers of 2 or 4 bytes; `out` is aligned for them. Numbers of 2 bytes are cut off above
  // 65,535.
  void write_faces(uint32_t index_bytes, void* out) const;

  // One value for each point, tightly packed. The components get the type `type`; values of other types are
  // converted as libdraco does it. Returns false if a value does not fit.
  bool write_attribute(const Attribute& attribute, DataType type, uint8_t* out) const;

  // The integers from which the values are computed: places on the grid of a quantized attribute, the two
  // coordinates of a normal on its octahedron, or the values themselves. Returns false for attributes that have
  // none.
  bool write_integers(const Attribute& attribute, int32_t* out) const;

  // For each point the number of the attribute's stored value that it has, in the order of the stream. For
  // Edgebreaker meshes: in all other streams, value i is that of point i.
  void write_value_numbers(const Attribute& attribute, uint32_t* out) const;

 private:
  DecodedStream() = default;
  void close_up_faces();
  uint32_t vertex_of(const Attribute& attribute, uint32_t point) const;

  std::unique_ptr<uint8_t[]> bytes_, memory_;
  Patch patch_;
};

}  // namespace psplit::web
