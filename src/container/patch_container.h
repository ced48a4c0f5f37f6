// The patch container: the directory, the stitch map and the streams of one primitive in one run of bytes.
//
// Layout, all little-endian (gltf_ext/PSPLIT_mesh_draco_patches/README.md is the specification):
//
//   header      20 bytes: magic "PSPL", version, flags, codec, stream count, directory bytes, head bytes
//   directory   per stream: faces, points, references, stitch bytes, stream bytes (directory.h)
//   head        what streams have in common, in sections (condensed_head.h); often empty
//   stitch map  per stream, concatenated (src/core/stitch_reader.h)
//   streams     per stream, concatenated: Draco 2.2 meshes
//
// If the head has tables, streams may be condensed: they hold the fields of a Draco stream, coded with these.
//
// Streams are the patches in order. If kResidue is set, the last stream is the residue: a sequential Draco mesh
// with the faces and points that Edgebreaker cannot carry.
//
// Bytes are opened once. Everything that decodes or reports takes the opened value.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "src/core/stitch_reader.h"
#include "src/core/stream_header.h"

namespace psplit {

inline constexpr uint8_t kContainerVersion = 1;

class BorderValues;
enum class HeadSection : uint8_t;
struct CondensedHead;

// An opened container, or one stock Draco stream as a container of one patch. The directory, the headers of all
// streams and the number of bytes agree. Its spans point into the bytes that were opened, which must outlive
// it. Safe to share between threads.
struct PatchContainer {
  std::span<const uint8_t> bytes;
  bool has_residue = false;
  // A Draco stream without a directory: it has no references, and it may be sequential or Edgebreaker.
  bool is_stock = false;
  // False for an Edgebreaker stream that no directory describes. Its row has the largest number of points that
  // it can decode to. The true number is known only after decoding.
  bool is_point_count_known = true;
  // Not ok for a stock stream that the core refuses: the error. `headers` is then empty, and the row counts no
  // faces and no points. libdraco may still decode the stream, for example if its bitstream is older than 2.2.
  // Not ok for a patch alone if the values at its border cannot be decoded.
  Status refusal;

  std::vector<StreamEntry> entries;               // the patches, then the residue if there is one
  std::vector<core::StreamHeader> headers;        // one for each entry
  std::vector<std::span<const uint8_t>> stitch;   // one for each entry
  std::vector<std::span<const uint8_t>> streams;  // one for each entry
  // owned_base[i] is the number of the first point that entry i owns; the last element is the total of points.
  std::vector<uint32_t> owned_base;
  // face_base[i] is the number of the first face of entry i; the last element is the total of faces.
  std::vector<uint32_t> face_base;
  // The values at the border of a patch that is alone, if its header refers to them.
  std::shared_ptr<const BorderValues> borders;
  // What the condensed streams have in common; null if no stream is condensed. Their headers refer to it.
  std::shared_ptr<const CondensedHead> head;
  uint64_t header_bytes = 0;  // of header, directory and head
  uint32_t head_bytes = 0;

  // The number of patches without the residue. Functions that take a patch take the residue as well: it comes
  // after the patches.
  uint32_t patch_count() const { return static_cast<uint32_t>(entries.size()) - (has_residue ? 1 : 0); }
  uint32_t point_count() const { return owned_base.back(); }
  uint32_t face_count() const { return face_base.back(); }
  uint64_t stitch_bytes() const;
  uint64_t stream_bytes() const;
  // The bytes of the whole container.
  uint64_t total_bytes() const { return header_bytes + stitch_bytes() + stream_bytes(); }
  uint64_t reference_count() const;
  uint32_t condensed_count() const;  // of the streams
  // Whether patches share the values of the first attribute at their borders (border_values.h).
  bool has_borders() const;

  // The number of points to plan memory for: the row's, or an estimate if the row has only a limit.
  uint32_t likely_point_count(uint32_t patch) const;

  // Places the container in memory of total_bytes(): sets `bytes`, `stitch` and `streams`.
  void place(std::span<const uint8_t> memory);
  // Reads the headers of the streams that end within the first `arrived` bytes of the container, after the
  // headers that were read already. Errors: the first invalid header's, with the patch as their place.
  Status read_headers(uint64_t arrived);

  // The core's readers of the stitch map take this.
  core::StitchRow stitch_row(uint32_t patch) const;

  // One patch as a container of its own, with all its points. A residue has the faces that its row counts. A
  // condensed patch stays condensed. Decodes the values at its border that patches share: if that fails,
  // `refusal` is the error.
  PatchContainer alone(uint32_t patch) const;

  // Sets the number of points of a stock stream, for a caller that knows it: glTF's accessors say it. The
  // number must not be larger than that of the row.
  void expect_points(uint32_t count);
};

// Checks every length, sum and header, and that the bytes justify the memory that the counts ask for. Never
// reads past `bytes`. Allocates in proportion to the stream count, which the bytes must justify. Errors are
// kInvalidInput, and kUnsupported for unknown versions, flags, codecs and sections that must be understood,
// with the patch in their place.
Expected<PatchContainer> open_container(std::span<const uint8_t> bytes);

// The first step of it, also for a container that arrives, into an empty `container`. `bytes` are the whole
// container if `is_whole`, and otherwise those to the end of the head, or more. `bytes`, `stitch`, `streams`
// and `headers` of the container stay empty: the caller has memory of total_bytes(), which only the rows
// justify if not `is_whole`, and calls place(), read_headers() and check_claims() (claims.h).
Status open_front(std::span<const uint8_t> bytes, bool is_whole, PatchContainer& container);

// A stock Draco mesh stream as a container of one patch. Its row counts no more than `most_points` points; a
// backend may decode more, and the caller's BuffersFor compares. Never fails: see `refusal`.
PatchContainer open_stream(std::span<const uint8_t> bytes, uint32_t most_points = 0xfffffffeu);

// The errors of open_container in the header and the directory, but not in the streams.
Status check_directory(std::span<const uint8_t> bytes);

// `stitch` and `streams` have one item for each entry, of the lengths that the entry names. The entries say
// which streams are condensed; `head` is then that of condense().
std::vector<uint8_t> write_container(std::span<const StreamEntry> entries, bool has_residue,
                                     std::span<const std::vector<uint8_t>> stitch,
                                     std::span<const std::vector<uint8_t>> streams,
                                     std::span<const uint8_t> head = {});

// The container with one more section in its head, which has none of this type and ends with it.
std::vector<uint8_t> with_head_section(const PatchContainer& container, HeadSection type,
                                       std::span<const uint8_t> section);

}  // namespace psplit
