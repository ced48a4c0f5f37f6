// The seams of a condensed stream.
#pragma once

#include "src/core/condensed/condensed_stream.h"

namespace psplit::core {

// Decodes a bit for each inner edge and each attribute data that has seams, one attribute data after the other.
// The probability of a bit depends on the bit before it.
class CondensedSeamSteps {
 public:
  CondensedSeamSteps() = default;
  // `seams` has zeros for all edges of the first attribute data, then of the second and so on.
  PSPLIT_HD CondensedSeamSteps(const CondensedStream& stream, const SectionReader& section, uint32_t data_count,
                               View<uint8_t> seams, size_t edge_count)
      : section_(section),
        has_seams_(stream.numbers(stream.seams_at)),
        models_(stream.models.seams.data()),
        left_(data_count),
        edge_count_(edge_count),
        at_(seams.data()),
        end_(seams.data()) {}

  // Steps of the current attribute data.
  PSPLIT_HD uint32_t steps_left() const { return static_cast<uint32_t>(end_ - at_); }
  // Goes on to the next attribute data that has seams.
  PSPLIT_HD void renew() {
    for (; left_ > 0 && steps_left() == 0; --left_) {
      const SeamModel& model = *models_++;
      if (has_seams_.read(1) != 0)
        end_ = at_ + edge_count_;
      else
        end_ = at_ += edge_count_;
      none_ = model.after[0], seam_ = model.after[1], last_ = 0;
    }
  }
  PSPLIT_HD void step() {
    last_ = section_.next_bit(select(0 - last_, seam_, none_));
    *at_++ = static_cast<uint8_t>(last_);
  }
  PSPLIT_HD const SectionReader& section() const { return section_; }

 private:
  SectionReader section_, has_seams_;
  const SeamModel* models_ = nullptr;
  uint32_t left_ = 0, none_ = 0, seam_ = 0, last_ = 0;
  size_t edge_count_ = 0;
  uint8_t* at_ = nullptr;
  uint8_t* end_ = nullptr;
};

}  // namespace psplit::core
