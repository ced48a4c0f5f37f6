// The patch container: directory, stitch map and Draco streams of one primitive in one run of bytes.
//
// Layout, all little-endian (gltf_ext/PSPLIT_mesh_draco_patches/README.md is the specification):
//
//   header      magic "PSPL", version, flags, stream count, five column descriptors
//   columns     per stream: stream bytes, faces, points, references, stitch bytes; each column is stored as
//               a base and 0, 1, 2 or 4 bytes a value
//   stitch map  per stream, concatenated
//   streams     per stream, concatenated: Draco 2.2 meshes
//
// Streams are the patches in order; with kResidue set the last is the residue: a sequential Draco mesh with
// the faces and points that Edgebreaker cannot carry.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/status.h"

namespace psplit {

// What write_container writes. Version 1 is read as well: its stitch maps have another format.
inline constexpr uint8_t kContainerVersion = 2;

// One row of the directory.
struct StreamEntry {
  uint32_t stream_bytes = 0;
  uint32_t face_count = 0;
  uint32_t point_count = 0;      // as decoded, references included
  uint32_t reference_count = 0;  // points that another stream, or an earlier point of this one, owns
  uint32_t stitch_bytes = 0;
  bool operator==(const StreamEntry&) const = default;
};

// A parsed container. Spans point into the bytes given to parse_container, which must outlive it.
struct Container {
  uint8_t version = kContainerVersion;
  std::vector<StreamEntry> entries;  // patches, then the residue if any
  bool has_residue = false;
  bool is_stock = false;  // one stream of either coding that no directory describes (container_of_stream)
  std::vector<std::span<const uint8_t>> stitch;   // one per entry
  std::vector<std::span<const uint8_t>> streams;  // one per entry
  // owned_base[i] is the number of the first point that entry i owns; the last is the total of points.
  std::vector<uint32_t> owned_base;
  // face_base[i] is the number of the first face of entry i; the last is the total of faces.
  std::vector<uint32_t> face_base;
  uint64_t header_bytes = 0;  // header and columns

  uint32_t patch_count() const { return static_cast<uint32_t>(entries.size()) - (has_residue ? 1 : 0); }
  uint32_t point_count() const { return owned_base.back(); }
  uint32_t face_count() const { return face_base.back(); }
  uint64_t stitch_bytes() const;
  uint64_t stream_bytes() const;
  uint64_t reference_count() const;
};

// Checks every length and sum; never reads past `bytes`; allocates in proportion to the stream count, which
// the bytes must justify. Errors are kInvalidInput with the patch in their place.
Expected<Container> parse_container(std::span<const uint8_t> bytes);

// stitch and streams have one item per entry, with the lengths that the entry names.
std::vector<uint8_t> write_container(std::span<const StreamEntry> entries, bool has_residue,
                                     std::span<const std::vector<uint8_t>> stitch,
                                     std::span<const std::vector<uint8_t>> streams);

}  // namespace psplit
