// What the encoder returns: the streams of a mesh, what stitches them, and the order of its points.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "src/container/decode_backend.h"
#include "src/container/stream_entry.h"
#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/mesh/value_bounds.h"

namespace psplit {

class StoredBytes;  // bytes that do not have to fit into memory

struct EncodeStatistics {
  uint32_t patch_count = 0;    // without the residue
  uint64_t merged_points = 0;  // duplicates that were merged
  uint64_t dropped_faces = 0;
  uint64_t dropped_points = 0;
  uint64_t residue_faces = 0;   // faces that repeat an index, which Edgebreaker cannot encode
  uint64_t residue_points = 0;  // points that no other stream has
  // The largest distance between a position of the input and its decoded position. Nothing if it was not
  // verified.
  std::optional<double> position_error;
  double partition_ms = 0;
  double encode_ms = 0;  // all of encoding except decoding and verifying the whole
  double verify_ms = 0;
};

// A container of patches, or a Draco stream without a container.
struct EncodedPiece {
  bool is_container = true;
  std::vector<uint8_t> bytes;
  std::shared_ptr<StoredBytes> stored;  // the bytes of a mesh that was encoded in parts, instead of `bytes`
  std::vector<StreamEntry> entries;     // the directory's rows; that of a lone stream has no stitch map
  uint32_t head_bytes = 0;              // of the container's head: what condensed streams share, and boxes
  uint32_t point_count = 0, face_count = 0;
  uint32_t used_point_count = 0;  // without those that no face uses, which come last
  // What it decodes to, and for each decoded point the input point that it was. Morph targets and other arrays
  // per point are reordered accordingly. Of a mesh in parts `bounds` instead: of the decoded values of each
  // attribute.
  Mesh decoded;
  std::vector<uint32_t> source_point;
  std::vector<ValueBounds> bounds;

  PSPLIT_EXPORT uint64_t size() const;  // in bytes
};

struct EncodedMesh {
  // One in most cases. A mesh in parts may exceed a container, and patches may be streams of their own. If
  // pieces share a point, each has it.
  std::vector<EncodedPiece> pieces;
  // In the order of the input's attributes: how to request each from a decoder, and how it is stored.
  std::vector<AttributeRequest> requests;
  std::vector<AttributeCoding> codings;
  std::vector<PrecisionNote> notes;  // what was done for its precision, and what it loses
  EncodeStatistics statistics;       // of all pieces together

  bool is_in_container() const { return !pieces.empty() && pieces.front().is_container; }
};

}  // namespace psplit
