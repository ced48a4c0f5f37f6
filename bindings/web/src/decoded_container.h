// An opened container, and the part of its mesh that a range of its streams becomes.
//
// One instance of the module decodes all streams, or several share them: the lead takes the first range.
// Streams refer only to streams before them. So the lead resolves its own references, and another instance
// the references within its range. It sends the lead the data for all others (stitching).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "bindings/web/src/chosen_streams.h"
#include "src/cpu/container_decoder.h"

namespace psplit::web {

class DecodedContainer {
 public:
  // An attribute as a stream stores it: Draco's numbers of its semantic and its type.
  struct StoredAttribute {
    uint32_t semantic, type, components, normalized, unique_id;
  };
  // Where decoding failed. A failure of an earlier stage comes first, and within a stage that of the lowest
  // stream.
  enum class Stage : uint32_t { kNone, kStreams, kReferences };

  // How much of the container is present: all of its bytes, or at least those to the end of the head.
  enum class Arrival : uint32_t {
    kFront,  // of the whole container, which arrives
    kWhole,
    kOutline,  // of a container without memory for its streams: for choose()
  };
  // Opens a container. Any bytes may be given. Errors: as for open_container.
  static Expected<std::unique_ptr<DecodedContainer>> open(std::unique_ptr<uint8_t[]> bytes, size_t size,
                                                          Arrival arrival);

  // The whole container, until patches of it are chosen.
  const PatchContainer& container() const { return is_outline_ ? chosen_->whole : container_; }
  // Of a container that arrives, whose memory the caller fills: the first `arrived` bytes are there. Returns
  // the number of streams that have arrived, or for chosen patches the number that can be decoded. Not to be
  // called after a stream failed.
  uint32_t arrive(size_t arrived);

  // Makes an outline the container of some patches of it, as ChosenStreams says. Returns the streams that they
  // need.
  const std::vector<uint32_t>& choose(std::vector<uint32_t> patches, std::unique_ptr<uint8_t[]> stitch_map);
  // Takes memory for these streams. They then arrive, one after the other.
  Status place_chosen();

  // Decodes the first stream for its attributes.
  Status describe();
  const std::vector<StoredAttribute>& stored() const { return stored_; }

  // Requests an attribute. To be called before begin().
  void request(AttributeRequest request) { requests_.push_back(std::move(request)); }

  // Takes the memory for a range, and decodes the values at borders of its streams that have arrived. The range
  // has at least one stream, and ends where the container ends at the latest. Errors: as for the CPU's
  // backend for all streams.
  Status begin(StreamRange range);
  // Decodes the next streams of the range that have arrived, and resolves their references if it can. Returns
  // how many; 0 if there are none, and after a stream that failed.
  uint32_t decode_streams();
  // The first failure. Its status has the stream as its place.
  Stage failed_stage() const;
  const Status& failure() const;

  // The part of the mesh: the faces of the range, and the points that it owns. The indices count in the
  // mesh.
  const Mesh& part() const { return part_; }
  // Whether the faces of a stream are final, for each stream.
  const std::vector<uint8_t>& is_resolved() const { return is_resolved_; }

  // What the lead needs of the range. Valid until the next call.
  const std::vector<uint32_t>& stitching();
  // Takes the stitching of the range that begins at stream `first`.
  void add_stitching(uint32_t first, std::span<const uint32_t> words);
  // Resolves all other references, when all streams have their stitching. Errors: that of the lowest stream.
  Status resolve_rest();
  // The corners of the mesh whose indices that changed, each with its new index.
  const std::vector<uint32_t>& corrections() const { return corrections_; }

 private:
  DecodedContainer() = default;

  Status in_whole(Status status) const;
  bool refers_only_to_range(uint32_t stream) const;
  uint32_t arrived_count() const { return static_cast<uint32_t>(container_.headers.size()); }

  std::unique_ptr<uint8_t[]> bytes_;
  PatchContainer container_;
  std::optional<ChosenStreams> chosen_;  // if it was opened as an outline
  bool is_outline_ = false;              // no patches are chosen yet
  std::vector<StoredAttribute> stored_;
  std::vector<AttributeRequest> requests_;

  StreamRange range_;
  Mesh part_;
  PrimitiveBuffers buffers_;
  const ThreadPool pool_;
  const Watch watch_{};
  Steps steps_{watch_, 0};
  std::optional<ContainerDecoder> decoder_;
  uint32_t next_ = 0;  // the stream to decode next
  Status stream_failure_, reference_failure_;
  std::vector<uint8_t> is_resolved_;
  std::vector<uint32_t> stitching_, corrections_;
};

}  // namespace psplit::web
