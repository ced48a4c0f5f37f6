// Some patches of a container whose other streams need not be there.
//
// A patch has all its points, so it needs no other stream, with one exception: if patches share values at their
// borders (border_values.h), a patch needs the streams that own its own. Points are not stitched: the chosen
// patches are a container without references, and points at borders come once for each patch.
#pragma once

#include <memory>
#include <vector>

#include "src/container/border_values.h"

namespace psplit::web {

class ChosenStreams {
 public:
  // The whole container, with rows and head but without streams: open_front filled it, and check_claims
  // accepted it.
  PatchContainer whole;

  // Chooses distinct patches of `whole`, in any order. `stitch_map` has the bytes that the rows name, if
  // patches share values; otherwise it is null. `container`, which is empty, becomes the container of the
  // patches in their order, without streams and headers. To be called once.
  void choose(std::vector<uint32_t> patches, std::unique_ptr<uint8_t[]> stitch_map, PatchContainer& container);
  // The streams that they need: the patches in their order, each after the owners of its values that do not
  // come before.
  const std::vector<uint32_t>& needed() const { return needed_; }
  uint64_t needed_bytes() const;

  // The needed streams come to `memory`, one after the other. It must outlive this.
  void place(std::span<const uint8_t> memory);
  // The first `arrived` bytes of the memory have arrived. Gives the container of the patches the streams and
  // the headers that can be decoded since the last call. They may refer to memory that the next call
  // replaces. Errors: as for open_container and BorderValues::decode, with the number of the patch in the
  // whole container. Not to be called after one.
  Status arrive(size_t arrived, PatchContainer& container);

  // The status with the number that its patch has in the whole container.
  Status in_whole(const Status& status) const;

 private:
  std::vector<uint32_t> patches_, needed_;
  std::vector<uint32_t> waits_for_;  // for each patch, how many needed streams
  uint32_t arrived_count_ = 0;       // of the needed streams
  std::unique_ptr<uint8_t[]> stitch_map_;
  BorderValues borders_;
};

}  // namespace psplit::web
