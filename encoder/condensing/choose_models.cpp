#include "encoder/condensing/choose_models.h"

#include <algorithm>

namespace psplit {
namespace {

// What a coding may take more than the smallest one, if it decodes faster.
constexpr double kWorthValence = 0.02;    // of all bits
constexpr double kWorthContexts = 0.001;  // of all bits, for each symbol more in the context
constexpr double kWorthDracoOrder = 0.01, kWorthTwo = 0.002;  // of the attribute's bits

// The counts with a shorter context: it is the last symbols of the longer one.
SymbolCounts shortened(const SymbolCounts& counts, uint32_t contexts) {
  SymbolCounts result(contexts);
  for (size_t i = 0; i < counts.size(); ++i)
    for (size_t s = 0; s < counts[i].size(); ++s) result[i % contexts][s] += counts[i][s];
  return result;
}

double all_bits(const SymbolCounts& counts, double scale) {
  const auto tables = symbol_tables(counts);
  BitStringWriter table_bits;
  write_symbol_tables(tables, table_bits);
  return scale * symbol_bits(counts, tables) + static_cast<double>(table_bits.bit_count());
}

}  // namespace

ValueCoding CodingCounts::value_coding(uint32_t number) {
  const uint32_t flags = number - 1;
  return number == 0 ? ValueCoding{} : ValueCoding{true, (flags & 1) != 0, (flags & 4) != 0, (flags & 2) != 0};
}

void CodingCounts::add(const DracoFields& fields, const Skeleton& skeleton, const DecodedSource* source) {
  add_symbols(fields, contexts_of_symbols(fields, kMostLastSymbols), last_symbols_);
  add_symbols(fields, contexts_of_symbols(fields, kValenceContexts), valences_);
  for (uint32_t i = 0; i < fields.attributes.size(); ++i) {
    const SkeletonAttribute& attribute = skeleton.attributes[i];
    const CodedValues in_draco_order = code_in_draco_order(fields.attributes[i], attribute);
    const bool has_values = source != nullptr && attribute.allows_creation_order();
    attributes_[i].has_values |= has_values;
    for (uint32_t n = 0; n < kValueCodings; ++n)
      attributes_[i].counts[n].add(n > 0 && has_values
                                       ? code_by_creation(*source, i, attribute.components, value_coding(n))
                                       : in_draco_order,
                                   attribute.components);
  }
}

CodingCounts& CodingCounts::operator+=(const CodingCounts& other) {
  last_symbols_ += other.last_symbols_;
  valences_ += other.valences_;
  for (size_t i = 0; i < attributes_.size(); ++i) {
    attributes_[i].has_values |= other.attributes_[i].has_values;
    for (uint32_t n = 0; n < kValueCodings; ++n) attributes_[i].counts[n] += other.attributes_[i].counts[n];
  }
  return *this;
}

ValueCoding CodingCounts::choose_values(uint32_t attribute, double scale, bool smallest, double& bits) const {
  ValueCoding chosen;
  double best = -1;
  // The slowest come last: two parallelograms, and Draco's order, which is number 0.
  for (uint32_t i = 1; i <= kValueCodings; ++i) {
    const uint32_t n = i % kValueCodings;
    const ValueCoding coding = value_coding(n);
    if (coding.by_creation && !attributes_[attribute].has_values) continue;
    const AttributeCounts& counts = attributes_[attribute].counts[n];
    const auto tables = token_tables(counts, coding);
    BitStringWriter table_bits;
    write_token_tables(tables, table_bits);
    const double took = scale * value_bits(counts, tables) + static_cast<double>(table_bits.bit_count());
    const double worth = smallest                    ? 0
                         : !coding.by_creation       ? kWorthDracoOrder
                         : coding.two && !chosen.two ? kWorthTwo
                                                     : 0;
    if (best >= 0 && took >= best * (1 - worth)) continue;
    best = took;
    chosen = coding;
  }
  bits = best;
  return chosen;
}

uint32_t CodingCounts::choose_symbols(double scale, bool smallest, double bits_of_values) const {
  uint32_t chosen = 0;
  double best = 0;
  for (uint32_t k = 0; k <= kMostLastSymbols; ++k) {
    const double took = all_bits(shortened(last_symbols_, context_count(k)), scale);
    const double worth = smallest || k == 0 ? 0 : kWorthContexts * (k - chosen) * (best + bits_of_values);
    if (k > 0 && took >= best - worth) continue;
    best = took;
    chosen = k;
  }
  const double took = all_bits(valences_, scale);
  const double worth = smallest ? 0 : kWorthValence * (best + bits_of_values);
  return took < best - worth ? kValenceContexts : chosen;
}

Codings CodingCounts::choose(double scale, bool smallest) const {
  Codings codings;
  double bits_of_values = 0;
  for (uint32_t i = 0; i < attributes_.size(); ++i) {
    double bits = 0;
    codings.values.push_back(choose_values(i, scale, smallest, bits));
    bits_of_values += bits;
  }
  codings.symbol_contexts = choose_symbols(scale, smallest, bits_of_values);
  return codings;
}

}  // namespace psplit
