// Where the bytes of condensed streams are.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "src/core/condensed/section.h"

namespace psplit {

// In fractions of bytes: an entropy-coded symbol rarely takes whole bits.
struct SectionBytes {
  struct Attribute {
    double tokens = 0, bits = 0;  // entropy-coded tokens, and the plain bits behind them
    double flags = 0;             // creases, orientations and flips
  };
  double numbers = 0;  // plain numbers of patches: counts, split events, lengths of sections, ranges
  double borders = 0;  // values at borders that streams share
  double symbols = 0, seams = 0;
  std::vector<Attribute> attributes;  // by their places in the streams
  double ends = 0;                    // the coders' last states, and unused bits of last bytes

  double total() const {
    double sum = numbers + borders + symbols + seams + ends;
    for (const Attribute& attribute : attributes) sum += attribute.tokens + attribute.bits + attribute.flags;
    return sum;
  }
  SectionBytes& operator+=(const SectionBytes& other) {
    numbers += other.numbers;
    borders += other.borders;
    symbols += other.symbols;
    seams += other.seams;
    ends += other.ends;
    attributes.resize(std::max(attributes.size(), other.attributes.size()));
    for (size_t i = 0; i < other.attributes.size(); ++i) {
      attributes[i].tokens += other.attributes[i].tokens;
      attributes[i].bits += other.attributes[i].bits;
      attributes[i].flags += other.attributes[i].flags;
    }
    return *this;
  }
};

// Measures what is read of a section between two calls.
class SectionMeter {
 public:
  explicit SectionMeter(const core::SectionReader& section) : section_(&section) { restart(); }

  // Adds the bytes since the last call: words of the entropy coder, and plain bits.
  void add(double& coded, double& plain) {
    const double coded_before = coded_, plain_before = plain_;
    restart();
    coded += (coded_ - coded_before) / 8;
    plain += (plain_ - plain_before) / 8;
  }

 private:
  // The coder's state holds 16 to 32 bits that belong to the next symbols. Before the first state of 32 bits is
  // read, it counts as 24.
  void restart() {
    constexpr double kNotStarted = 32 - 24;
    coded_ = section_->state() == 0 ? kNotStarted
                                    : 8 * static_cast<double>(section_->word_bytes_taken()) -
                                          std::log2(static_cast<double>(section_->state()));
    plain_ = static_cast<double>(section_->bits_taken());
  }

  const core::SectionReader* section_;
  double coded_ = 0, plain_ = 0;
};

}  // namespace psplit
