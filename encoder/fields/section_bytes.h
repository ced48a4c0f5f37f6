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
    double tokens = 0, bits = 0;  // entropy-coded tokens, and the plain bits after them
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

// Adds the bytes of a section between two of its places: words of the entropy coder, and plain bits.
inline void add_section_bytes(const core::SectionReader& from, const core::SectionReader& to, double& coded,
                              double& plain) {
  // The coder's state holds 16 to 32 bits that belong to the next symbols.
  const auto coded_bits = [](const core::SectionReader& at) {
    return 8 * static_cast<double>(at.word_bytes_taken()) - std::log2(static_cast<double>(at.state()));
  };
  coded += (coded_bits(to) - coded_bits(from)) / 8;
  plain += static_cast<double>(to.bits_taken() - from.bits_taken()) / 8;
}

}  // namespace psplit
