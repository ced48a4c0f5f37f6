// The patches of a container to one stitched mesh, on a pool of threads.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "psplit/decode.h"
#include "src/container/border_values.h"
#include "src/container/patch_container.h"
#include "src/cpu/checked_decode.h"
#include "src/cpu/scratch.h"

namespace psplit {

// Reports finished patches to the caller, and asks it whether to go on. Thread-safe.
class Steps {
 public:
  Steps(const Watch& watch, size_t total) : watch_(watch), total_(total) {}

  bool stopped() const { return watch_.stopped(); }
  void finish(size_t count) {
    if (watch_.progress) watch_.progress(done_ += count, total_);
  }

 private:
  const Watch& watch_;
  const size_t total_;
  std::atomic<size_t> done_ = 0;
};

// Streams of a container: from `first` on, without `end`. They own consecutive points of the mesh, and their
// faces are consecutive.
struct StreamRange {
  uint32_t first = 0, end = 0;
};

// Values that patches share at their borders are decoded first. Then there are two rounds over the patches. In
// the first, each patch writes the values that it owns, and its faces with placeholders for references. In the
// second, references take the numbers that their owners gave.
//
// Several decoders may share a container: each decodes a range of its streams. Their callers take the steps of
// decode() themselves.
class ContainerDecoder {
 public:
  struct Placeholder {
    uint32_t corner;     // of the mesh, three for each face
    uint32_t reference;  // of the patch, in the order of its stitch map
  };
  // What stitching knows of one stream of the container, from the time when its own points are written.
  struct StitchedPatch {
    std::vector<uint32_t> walk;  // the mesh's numbers along the border; kNoPoint for references
    std::vector<Placeholder> placeholders;
    std::vector<uint32_t> references;  // the mesh's numbers, after the second round
    // Only set if findings are wanted: the decoded point of each reference, and the values of its copy for each
    // request.
    std::vector<uint32_t> copied_points;
    std::vector<std::vector<std::byte>> copies;
    Status status;
  };

  // `out` has room for the container's counts. If `findings` is not null, it has an element for each stream,
  // and the streams are checked as decode_checked says. All arguments must outlive the decoder.
  ContainerDecoder(const DecodeTask& task, const PrimitiveBuffers& out, const ThreadPool& pool, Steps& steps,
                   std::vector<StreamFindings>* findings = nullptr);
  // Decodes a range of the streams: `out` has room for their faces, and for the points that they own.
  ContainerDecoder(const DecodeTask& task, StreamRange range, const PrimitiveBuffers& out,
                   const ThreadPool& pool, Steps& steps, std::vector<StreamFindings>* findings = nullptr);

  // Decodes all streams.
  Status decode();
  // Decodes in windows of consecutive streams, each with at most `most_faces` faces, or one stream. After a
  // window, only the numbers along its borders stay in the decoder's memory, and later windows do not write to
  // its part of `out` any more. finish(window) is then called. Errors: as for decode().
  Status decode_in_windows(uint64_t most_faces, const std::function<void(StreamRange)>& finish);

  // The steps of it. The values come first that streams of the range share with others; then they may be
  // decoded.
  Status decode_borders(StreamRange streams);
  // The first round for streams of the range: `count` is 1, or kInStep for as many in step. stitched(i) has
  // their statuses.
  void decode_streams(uint32_t first, uint32_t count);
  // The second round, in two steps. All streams to which stream `i` refers are decoded, or stitched(i) has what
  // another decoder made of them. They never come after `i`.
  Status resolve_references(uint32_t i);
  // `i` is of the range.
  void write_references(uint32_t i);
  StitchedPatch& stitched(uint32_t i) { return patches_[i]; }

 private:
  StreamRange window_from(uint32_t first, uint64_t most_faces) const;
  void decode_first_round(StreamRange window);
  void decode_second_round(StreamRange window);
  Status first_failure(StreamRange window) const;
  void decode_patch(uint32_t i, Scratch& scratch);
  void decode_patches(uint32_t first, Scratch& scratch);
  // std::nullopt if it needs more memory than the arena has left.
  template <typename Index>
  std::optional<Status> write_patch(uint32_t i, const core::Patch<Index>& patch, core::Arena& arena,
                                    std::vector<uint32_t>& numbers);
  template <typename Index>
  void check_types(uint32_t i, std::span<const core::Attribute<Index>* const> attributes);
  template <typename Index>
  Status keep_copies(uint32_t i, const core::Patch<Index>& patch,
                     std::span<const core::Attribute<Index>* const> attributes,
                     const std::vector<uint32_t>& numbers);
  void check_copies(uint32_t i);
  core::View<uint32_t> references_of(uint32_t i);

  const PatchContainer& container_;
  const std::span<const AttributeRequest> requests_;
  const bool has_references_;
  const StreamRange range_;
  const PrimitiveBuffers& out_;
  const ThreadPool& pool_;
  Steps& steps_;
  BorderValues borders_;
  std::vector<StreamFindings>* const findings_;
  std::vector<StitchedPatch> patches_;
};

// core::decode_patch with 32-bit numbers. The core takes ten seconds to compile, so the encoder has no copy of
// its own.
core::Fault decode_wide(const core::StreamHeader& header, core::Arena& arena, core::Patch<uint32_t>& out);

}  // namespace psplit
