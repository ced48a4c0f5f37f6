// Whole Draco streams, whose attributes are not known before: .drc files, and what libdraco's own users decode.
// A stream is a mesh of bitstream 2.2, or a point cloud of 2.2 or 2.3. All functions decode on the calling
// thread, take any bytes, and are thread-safe. They take at most 64 MiB and 4096 bytes for each byte of the
// stream, and as much again for results. If the attributes are known, or there are many streams,
// src/loader/loader.h is faster. Errors: kUnsupported for other bitstreams, kInvalidInput for everything else
// that cannot be decoded.
#pragma once

#include <functional>
#include <vector>

#include "src/container/stream_description.h"
#include "src/mesh/mesh.h"
#include "src/span.h"

namespace psplit {

// Describes a stream. It decodes the stream for that.
PSPLIT_EXPORT Expected<StreamDescription> describe_stream(Span<const uint8_t> stream);

// The same of a patch of an opened container, or of its residue: what describe_stream says of its Draco stream,
// also if it is condensed. Errors have the patch of a container as their place.
PSPLIT_EXPORT Expected<StreamDescription> describe_patch(const PatchContainer& container, uint32_t number);

// Decodes all attributes as glTF has them. A point cloud becomes a mesh without faces. gltf_attributes
// (src/container/stream_description.h) chooses names and types, and has errors of its own. `description`, if it
// is not null, becomes that of the stream.
PSPLIT_EXPORT Expected<Mesh> decode_draco(Span<const uint8_t> stream, StreamDescription* description = nullptr);

// One value for each point, tightly packed, in the type that the stream has: description.components of
// description.type, little-endian.
struct GeometryAttribute {
  StreamAttribute description;
  Array<std::byte> values;
  // Whether the values are the integers of the stream: then they are int32, description.components of them, or
  // two for a normal on its octahedron.
  bool are_integers = false;

  // Numbers of a value, and its bytes.
  core::DataType type() const { return are_integers ? core::DataType::kInt32 : description.type; }
  uint32_t component_count() const {
    return are_integers && description.is_octahedral() ? 2 : description.components;
  }
  PSPLIT_EXPORT size_t stride() const;
};

// A stream without the names and limits of glTF. Faces, points and attributes have the order of the stream.
struct DracoGeometry {
  StreamCoding coding = StreamCoding::kSequential;
  uint32_t point_count = 0;
  Array<std::array<uint32_t, 3>> faces;  // none: a point cloud
  std::vector<GeometryAttribute> attributes;
};

// Decodes all attributes to their own types. With `integers`, to the integers that the stream has: places on
// the grid of a quantized attribute, coordinates on the octahedron of a normal. Attributes that are stored
// exactly have integers too, if they are integers of at most 32 bits.
PSPLIT_EXPORT Expected<DracoGeometry> decode_geometry(Span<const uint8_t> stream, bool integers = false);

// What a stream stores of an attribute: each value once, in the order in which libdraco has them.
struct StoredValues {
  uint32_t value_count = 0;
  bool one_a_point = false;   // value i is that of point i
  bool has_integers = false;  // see decode_geometry
};

// What a stream contains. It is found in a part of the time that decoding takes, because values are not
// decoded. So they may still turn out to be broken.
struct StreamOutline {
  StreamDescription description;  // of a kD-tree without bits, ranges and origins, which come after its values
  std::vector<StoredValues> stored;  // an element for each attribute
};
PSPLIT_EXPORT Expected<StreamOutline> outline_stream(Span<const uint8_t> stream);

// Where an attribute is written.
struct AttributePlaces {
  // value_count values. If value_of_point is null, one for each point. Null: the attribute is not wanted.
  std::byte* values = nullptr;
  uint32_t* value_of_point = nullptr;  // the number of each point's value; may be null
  bool integers = false;               // only if the attribute has them
  size_t stride = 0;                   // bytes from one value to the next; 0: tightly packed
};
struct GeometryPlaces {
  void* faces = nullptr;                    // three points for each face, aligned to index_bytes
  std::vector<AttributePlaces> attributes;  // those of the stream, in its order
  // Called after each attribute is written, so that several can share an array value_of_point. May be empty.
  std::function<void(size_t attribute)> written{};
  uint32_t index_bytes = 4;  // or 2, if no point number is larger
};
// Called once the counts are known. `stored` has an element for each attribute.
using PlacesFor =
    std::function<Expected<GeometryPlaces>(const StreamDescription&, Span<const StoredValues> stored)>;

// Decodes a stream to the places that places_for returns, which may throw. Its error is returned.
PSPLIT_EXPORT Status decode_geometry(Span<const uint8_t> stream, const PlacesFor& places_for);

// Gives `geometry` what is known of a stream, and the memory for the rest, not zeroed, which is returned.
// Errors: kInvalidInput if `stored_bytes`, those of the stream, do not justify that much memory.
PSPLIT_EXPORT Expected<GeometryPlaces> allocate_geometry(const StreamDescription& description,
                                                         Span<const StoredValues> stored, bool integers,
                                                         uint64_t stored_bytes, DracoGeometry& geometry);

}  // namespace psplit
