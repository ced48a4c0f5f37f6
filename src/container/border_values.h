// The values of the first attribute at the borders of patches, which patches share. With CondensedHead::
// has_borders they are stored once, and patches are decoded when the values of their border walks are known.
// Specification: "border parts" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "psplit/parallel.h"
#include "src/container/patch_container.h"
#include "src/core/condensed/border_part.h"

namespace psplit {

// Has no values if the container has no borders. Safe to share between threads.
class BorderValues {
 public:
  BorderValues() = default;
  // Decodes the values of all patches. Errors: kInvalidInput, with the first patch whose part is invalid as its
  // place.
  static Expected<BorderValues> decode(const PatchContainer& container, const ThreadPool& pool);
  // Decodes values for some patches: only their border parts, and the parts of the patches that own their
  // shared values. Only the streams and the headers of these need to be there.
  static Expected<BorderValues> decode(const PatchContainer& container, std::span<const uint32_t> some);
  // Of one patch, or of the residue, which has none.
  static Expected<BorderValues> decode(const PatchContainer& container, uint32_t patch);
  // Decodes values for the patches [first, end) like the function above. If all headers are read, fails only if
  // all patches together fail, with their error. Otherwise the headers before `end` are read.
  static Expected<BorderValues> decode(const PatchContainer& container, uint32_t first, uint32_t end,
                                       const ThreadPool& pool);

  // Appends the owners of a patch's shared values, as its stitch map names them: patches before it, or itself.
  static void append_owners(const PatchContainer& container, uint32_t patch, std::vector<uint32_t>& owners);

  bool empty() const { return patches_.empty(); }
  // Sets what the header of a patch lacks to decode it: the values at its border, which this owns. Does nothing
  // for the residue.
  void complete(uint32_t patch, core::StreamHeader& header) const;

 private:
  explicit BorderValues(std::vector<uint32_t> patches) : patches_(std::move(patches)) {}

  Status allocate(const PatchContainer& container);
  void decode_parts(const PatchContainer& container, size_t begin, size_t end, std::span<Status> statuses);
  core::Fault share_values(const PatchContainer& container, size_t slot) const;
  size_t slot_of(uint32_t patch) const;

  std::vector<uint32_t> patches_;  // in ascending order; a patch's place among them is its slot
  // These have an element for each slot.
  std::vector<core::WalkValues> walks_;
  std::vector<core::SectionReader> behind_parts_;
  // The walks are views of these.
  std::unique_ptr<int32_t[]> values_;
  std::unique_ptr<uint8_t[]> is_own_;
};

}  // namespace psplit
