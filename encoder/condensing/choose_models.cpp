#include "encoder/condensing/choose_models.h"

#include <algorithm>
#include <limits>

namespace psplit {
namespace {

// A coding that decodes slower must save this share of the bytes. The thresholds were measured on scans and on
// a regular mesh (Dragon, skull, nefertiti, ICBM; patches of 440 to 4,800 faces, one thread), so that condensed
// patches decode as fast as ordinary ones: with half of these thresholds, nefertiti decodes at 0.81 to 0.91 of
// that speed, ICBM at 0.70 to 0.85. Valence contexts take 20 to 27 % more time than symbol contexts, because
// each waits for the mesh.
constexpr double kWorthValence = 0.09;  // of all bits
// Up to 3 symbols cost nothing. 5 cost 4 %, as their 3,125 contexts do not stay in the cache.
constexpr double kWorthContexts = 0.001;  // of all bits, for each symbol more in the context
// One parallelogram in the order of creation is fast, forward and backward. Draco's order, two parallelograms,
// means of two values and a shorter reach take 12 to 20 % more, each of them and all together.
constexpr double kWorthSlowValues = 0.08;  // of the attribute's bits
constexpr double kWorthBorders = 0.005;    // of the first attribute's bits

bool is_fast(const core::ValueCoding& coding) {
  return coding.by_creation && !coding.two && !coding.mean && coding.reach == 0;
}

// The counts with a shorter context, which consists of the last symbols of the longer one.
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

double all_bits(const TokenCounts& counts, double scale) {
  const std::vector<uint16_t> table = fitting_frequencies(counts);
  BitStringWriter table_bits;
  core::NumberKind used = used_kind();
  write_token_table(table, used, table_bits);
  return scale * token_bits(counts, table) + static_cast<double>(table_bits.bit_count());
}

}  // namespace

void CodingCounts::add_by_creation(const DecodedSource& source, uint32_t attribute,
                                   std::span<const uint32_t> known, Attribute& to) {
  const uint32_t components = source.attribute(attribute).value_components();
  for (const bool backward : {false, true})
    for (const bool two : {false, true}) {
      if (!to.is_counted(backward, two)) continue;
      CreationCounts& counts = to.by_creation[backward][two];
      const CreationSymbols values(source, attribute, backward, two, known);
      for (uint32_t i = 0; i < values.count(); ++i) {
        const uint32_t parallelograms = values.parallelograms(i);
        const auto count = [&](TokenCounts& tokens, bool mean, uint32_t reach) {
          for (uint32_t k = 0; k < components; ++k) ++tokens[token_of(values.symbol(i, k, mean, reach)).token];
        };
        if (parallelograms == 0)
          for (const bool mean : {false, true}) count(counts.none[mean], mean, 0);
        else
          for (uint8_t reach = 0; reach < kReaches; ++reach)
            count((parallelograms == 1 ? counts.one : counts.two)[reach], false, reach);
      }
    }
}

void CodingCounts::add(const DracoFields& fields, const DecodedSource* source, const BorderPart* border) {
  add_symbols(fields, contexts_of_symbols(fields, kMostHistory), last_symbols_);
  add_symbols(fields, contexts_of_symbols(fields, kValenceContexts), valences_);
  if (border != nullptr) {
    const uint32_t components = fields.attributes[0].components;
    inner_.may_be_by_creation = true;
    add_by_creation(*source, 0, border->known, inner_);
    // Without border parts, corrections in Draco's order are the alternative.
    inner_.in_draco_order.add(code_in_draco_order(fields.attributes[0]), components);
    for (size_t n = 0; n < border->symbols.size(); ++n)
      ++border_[n < components ? 0 : 1][token_of(border->symbols[n]).token];
  }
  for (uint32_t i = 0; i < fields.attributes.size(); ++i) {
    const AttributeFields& attribute = fields.attributes[i];
    AttributeCounts in_draco_order;
    in_draco_order.add(code_in_draco_order(attribute), attribute.components);
    attributes_[i].in_draco_order += in_draco_order;
    if (source != nullptr && attribute.skeleton.allows_creation_order()) {
      attributes_[i].may_be_by_creation = true;
      add_by_creation(*source, i, {}, attributes_[i]);
      continue;
    }
    // It has these corrections anyway, and they share the tables.
    for (auto& by_order : attributes_[i].by_creation)
      for (CreationCounts& counts : by_order) {
        for (TokenCounts& tokens : counts.none) tokens += in_draco_order.tokens[0];
        for (TokenCounts& tokens : counts.one) tokens += in_draco_order.tokens[1];
      }
  }
}

void CodingCounts::Attribute::add(const Attribute& other) {
  may_be_by_creation |= other.may_be_by_creation;
  in_draco_order += other.in_draco_order;
  for (size_t backward = 0; backward < 2; ++backward)
    for (size_t two = 0; two < 2; ++two) {
      if (!is_counted(backward != 0, two != 0)) continue;
      CreationCounts& sums = by_creation[backward][two];
      const CreationCounts& counts = other.by_creation[backward][two];
      for (size_t mean = 0; mean < 2; ++mean) sums.none[mean] += counts.none[mean];
      for (size_t reach = 0; reach < kReaches; ++reach) {
        sums.one[reach] += counts.one[reach];
        sums.two[reach] += counts.two[reach];
      }
    }
}

CodingCounts& CodingCounts::operator+=(const CodingCounts& other) {
  last_symbols_ += other.last_symbols_;
  valences_ += other.valences_;
  for (size_t i = 0; i < attributes_.size(); ++i) attributes_[i].add(other.attributes_[i]);
  inner_.add(other.inner_);
  for (size_t t = 0; t < border_.size(); ++t) border_[t] += other.border_[t];
  return *this;
}

core::ValueCoding CodingCounts::choose_values(const Attribute& attribute, double scale, bool smallest,
                                              bool in_creation_order, double& bits) {
  const auto bits_of = [&](const TokenCounts& counts) { return all_bits(counts, scale); };
  core::ValueCoding chosen;
  bits = bits_of(attribute.in_draco_order.tokens[0]) + bits_of(attribute.in_draco_order.tokens[1]);
  if (!attribute.may_be_by_creation) return chosen;
  if (in_creation_order) bits = std::numeric_limits<double>::infinity();
  const auto cost = [&](const core::ValueCoding& coding, double takes) {
    return smallest || is_fast(coding) ? takes : takes / (1 - kWorthSlowValues);
  };
  const auto consider = [&](const core::ValueCoding& coding, double takes) {
    if (cost(coding, takes) >= cost(chosen, bits)) return;
    chosen = coding;
    bits = takes;
  };
  for (const bool backward : {false, true})
    for (const bool two : {false, true}) {
      if (!attribute.is_counted(backward, two)) continue;
      const CreationCounts& counts = attribute.by_creation[backward][two];
      const double none[2] = {bits_of(counts.none[0]), bits_of(counts.none[1])};
      for (uint8_t reach = 0; reach < kReaches; ++reach) {
        const double others = bits_of(counts.one[reach]) + bits_of(counts.two[reach]);
        for (const bool mean : {false, true}) consider({true, backward, two, mean, reach}, none[mean] + others);
      }
    }
  return chosen;
}

uint32_t CodingCounts::choose_symbols(double scale, bool smallest, double bits_of_values) const {
  uint32_t chosen = 0;
  double best = 0;
  for (uint32_t k = 0; k <= kMostHistory; ++k) {
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

Codings CodingCounts::choose(double scale, bool smallest, bool with_borders, bool with_deltas) const {
  Codings codings;
  double bits_of_values = 0;
  for (uint32_t i = 0; i < attributes_.size(); ++i) {
    double bits = 0;
    core::ValueCoding coding = choose_values(attributes_[i], scale, smallest, with_deltas && i == 0, bits);
    if (i == 0 && with_borders && inner_.may_be_by_creation) {
      double inner_bits = 0;
      const core::ValueCoding inner = choose_values(inner_, scale, smallest, with_deltas, inner_bits);
      inner_bits += all_bits(border_[0], scale) + all_bits(border_[1], scale);
      codings.has_borders = inner.by_creation && inner_bits < bits * (smallest ? 1 : 1 - kWorthBorders);
      if (codings.has_borders) coding = inner, bits = inner_bits;
    }
    codings.values.push_back(coding);
    codings.bits.push_back(bits);
    bits_of_values += bits;
  }
  codings.symbol_contexts = choose_symbols(scale, smallest, bits_of_values);
  return codings;
}

}  // namespace psplit
