// A container that grows by the streams of one part of a mesh after the other. Its streams, stitch maps and
// border walks are in spills.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "encoder/spill.h"
#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"
#include "src/container/patch_container.h"
#include "src/cpu/container_decoder.h"

namespace psplit {

class GrowingContainer {
 public:
  // Begins a container without streams. Errors: as for `make_spill`.
  static Expected<GrowingContainer> begin(const MakeSpill& make_spill);

  std::span<const StreamEntry> entries() const { return directory_.entries; }
  uint32_t stream_count() const { return static_cast<uint32_t>(directory_.entries.size()); }
  uint32_t point_count() const { return directory_.point_count(); }
  uint32_t face_count() const { return directory_.face_count(); }
  // The mesh's number of the first point that a stream owns. stream_count() is allowed.
  uint32_t first_point(uint32_t stream) const { return directory_.owned_base[stream]; }

  // Whether the container stays within `most_points` and within the limits of the format with these streams.
  bool has_room_for(std::span<const StreamEntry> entries, uint64_t most_points) const;

  // Appends the streams of a part, with one stitch map for each. There is room for them. After a residue, which
  // is the last of these streams, nothing is appended. Errors: kIo.
  Status append(std::span<const StreamEntry> entries, std::span<const std::vector<uint8_t>> maps,
                std::span<const std::vector<uint8_t>> streams, bool has_residue);

  // Decodes the streams that were appended last from the bytes in the spills. The result has the points that
  // these streams own. Its faces name points by their numbers in the whole mesh. To be called once after each
  // append: keeps the walks, to which later streams refer. Errors: kIo, kInvalidInput.
  Expected<Mesh> decode_last(std::span<const AttributeRequest> requests, const ThreadPool& pool);

  // The streams, their parts of the stitch map and their headers, in memory.
  struct Opened {
    std::vector<uint8_t> bytes;
    PatchContainer container;
  };
  // All streams so far. Errors: kIo, kInvalidInput.
  Expected<Opened> open() const { return open_from(0); }

  // The bytes of the whole container as it is now, without a head.
  uint64_t size() const { return write_front({}).size() + maps_->size() + streams_->size(); }

  // Whether decoders will take the memory that the whole mesh needs. Errors: kInvalidInput, kUnsupported.
  Status check_size(std::span<const AttributeRequest> requests) const;

  // The whole container: header, directory, head, stitch map and streams. Ends the use of this object.
  std::unique_ptr<StoredBytes> finish(std::span<const uint8_t> head);

 private:
  GrowingContainer() = default;
  std::vector<uint8_t> write_front(std::span<const uint8_t> head) const {
    return write_container(entries(), directory_.has_residue, {}, {}, head);
  }
  Expected<Opened> open_from(uint32_t first) const;
  Status load_walks(const PatchContainer& window, ContainerDecoder& decoder);
  Status keep_walks(ContainerDecoder& decoder);

  PatchContainer directory_;  // rows and sums only
  std::unique_ptr<Spill> maps_, streams_, walks_;
  std::vector<uint64_t> walk_ends_;  // for each stream, the end of its walk in its spill
  StreamRange last_;                 // the streams that were appended last
};

}  // namespace psplit
