// The values of a Draco stream in the tables of psplit's decoder.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "encoder/stream/attribute_corrections.h"
#include "src/core/workspace.h"

namespace psplit {

class DecodedValues {
 public:
  // The bytes must outlive it.
  core::Fault decode(std::span<const uint8_t> stream) {
    core::Fault fault = core::read_stream_header(stream.data(), stream.size(), header_);
    for (size_t size = size_t{1} << 16; fault == core::Fault::kNone; size *= 2) {
      memory_.reset(new uint8_t[size]);
      core::Arena arena(memory_.get(), size);
      patch_ = std::make_unique<core::Patch<uint32_t>>();
      fault = core::decode_patch<uint32_t>(header_, arena, *patch_);
      if (fault == core::Fault::kNone) break;
      if (fault == core::Fault::kWorkspace && size < size_t{1} << 32) fault = core::Fault::kNone;
    }
    return fault;
  }

  const core::Patch<uint32_t>& patch() const { return *patch_; }
  // An attribute, to be predicted as the stream's fields say.
  ValuesToCorrect values(uint32_t i, const AttributeFields& fields) const {
    const core::Attribute<uint32_t>& attribute = patch_->attributes[i];
    const core::Attribute<uint32_t>* const positions = patch_->position_before(i);
    return {patch_->groups[attribute.group],
            attribute,
            fields.skeleton.scheme,
            fields.skeleton.transform,
            positions != nullptr ? &patch_->groups[positions->group] : nullptr,
            positions};
  }

 private:
  core::StreamHeader header_;
  std::unique_ptr<uint8_t[]> memory_;
  std::unique_ptr<core::Patch<uint32_t>> patch_;
};

}  // namespace psplit
