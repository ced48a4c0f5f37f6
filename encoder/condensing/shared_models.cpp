#include "encoder/condensing/shared_models.h"

#include <algorithm>

#include "src/container/condensed_head.h"
#include "src/core/edgebreaker_symbols.h"

namespace psplit {

void AttributeCounts::add(const CodedValues& values, uint32_t components) {
  for (size_t i = 0; i < values.table.size(); ++i)
    for (uint32_t k = 0; k < components; ++k)
      ++tokens[values.table[i]][token_of(values.symbols[i * components + k]).token];
}

AttributeCounts& AttributeCounts::operator+=(const AttributeCounts& other) {
  for (size_t t = 0; t < tokens.size(); ++t) tokens[t] += other.tokens[t];
  return *this;
}

void DeltaCounts::add(const CodedDeltas& deltas) {
  for (const uint32_t flag : deltas.flags) {
    if (flag < CodedDeltas::kRun)
      ++some[flag];
    else
      ++runs[token_of(flag - CodedDeltas::kRun).token];
  }
  for (const std::vector<CodedDeltas::Correction>& component : deltas.corrections)
    for (const CodedDeltas::Correction& correction : component)
      ++corrections[correction.level][token_of(correction.symbol).token];
}

DeltaCounts& DeltaCounts::operator+=(const DeltaCounts& other) {
  for (size_t bit = 0; bit < some.size(); ++bit) some[bit] += other.some[bit];
  runs += other.runs;
  for (size_t level = 0; level < corrections.size(); ++level) corrections[level] += other.corrections[level];
  return *this;
}

SymbolCounts& operator+=(SymbolCounts& to, const SymbolCounts& from) {
  for (size_t i = 0; i < to.size(); ++i)
    for (size_t s = 0; s < core::SymbolContext::kCount; ++s) to[i][s] += from[i][s];
  return to;
}

void add_symbols(const DracoFields& fields, std::span<const uint16_t> contexts, SymbolCounts& counts) {
  for (size_t i = 0; i < contexts.size(); ++i)
    ++counts[contexts[i]][core::number_of_clers(fields.symbols[i + 1])];
}

std::vector<std::array<uint16_t, core::SymbolContext::kCount>> symbol_tables(const SymbolCounts& counts) {
  std::vector<std::array<uint16_t, core::SymbolContext::kCount>> tables(counts.size());
  for (size_t i = 0; i < counts.size(); ++i)
    std::ranges::copy(fitting_frequencies(counts[i]), tables[i].begin());
  return tables;
}

TokenTables token_tables(const AttributeCounts& counts, core::ValueCoding coding) {
  TokenTables tables;
  for (uint32_t t = 0; t < (coding.by_creation ? 3 : 2); ++t)
    tables.push_back(fitting_frequencies(counts.tokens[t]));
  return tables;
}

double symbol_bits(const SymbolCounts& counts,
                   std::span<const std::array<uint16_t, core::SymbolContext::kCount>> tables) {
  double bits = 0;
  for (size_t i = 0; i < counts.size(); ++i) bits += coded_bits(counts[i], tables[i]);
  return bits;
}

double token_bits(const TokenCounts& counts, std::span<const uint16_t> table) {
  double bits = coded_bits(counts, table);
  for (uint32_t token = core::kDirectTokens; token < core::kTokenCount; ++token)
    bits += static_cast<double>(counts[token]) * core::token_bits(token).bit_count;
  return bits;
}

namespace {

void write_frequencies(std::span<const uint16_t> frequencies, core::NumberKind& kind, BitStringWriter& out) {
  for (const uint16_t frequency : frequencies) out.number(kind, frequency);
}

core::NumberKind frequency_kind() { return core::NumberKind(4); }

}  // namespace

void write_symbol_tables(std::span<const std::array<uint16_t, core::SymbolContext::kCount>> tables,
                         BitStringWriter& out) {
  core::NumberKind kind = frequency_kind();
  for (const auto& table : tables) write_frequencies(table, kind, out);
}

void write_token_table(std::span<const uint16_t> table, core::NumberKind& used_kind, BitStringWriter& out) {
  while (!table.empty() && table.back() == 0) table = table.first(table.size() - 1);
  out.number(used_kind, static_cast<uint32_t>(table.size()));
  core::NumberKind kind = frequency_kind();
  write_frequencies(table, kind, out);
}

void write_deltas(const Models& models, BitStringWriter& out) {
  core::NumberKind count(0), used = used_kind(), skip(0), zero(10), back(1), factor(5);
  out.number(count, static_cast<uint32_t>(models.deltas.size()) - 1);
  uint32_t last = 0;
  for (size_t n = 0; n < models.deltas.size(); ++n) {
    const core::DeltaModel& delta = models.deltas[n];
    out.number(skip, delta.attribute - last - 1u);
    last = delta.attribute;
    out.bits(delta.is_even, 1);
    for (const int32_t of : delta.zero) out.signed_number(zero, of);
    const bool has_reference = delta.reference != core::DeltaModel::kNoReference;
    out.bits(has_reference, 1);
    if (!has_reference) continue;
    out.number(back, n - delta.reference - 1);
    out.signed_number(factor, delta.factor);
  }
  const DeltaTables& tables = models.delta_tables;
  out.bits(tables.some, core::kSlotBits);
  out.bits(tables.begins >> 1, core::DeltaTables::kLevels - 1);
  write_token_table(tables.runs, used, out);
  for (const std::vector<uint16_t>& table : tables.corrections) write_token_table(table, used, out);
}

std::vector<uint8_t> write_head(const Models& models) {
  BitStringWriter out;
  core::NumberKind count(0), length(5), used = used_kind();
  out.number(count, static_cast<uint32_t>(models.skeletons.size()) - 1);
  for (const SkeletonModel& skeleton : models.skeletons) {
    out.bits(static_cast<uint64_t>(skeleton.symbol_level), 4);
    const auto literals = std::span(skeleton.literals).subspan(kSkeletonFront.size());
    out.number(length, literals.size());
    for (const uint8_t byte : literals) out.bits(byte, 8);
  }
  out.bits(models.symbol_contexts, 4);
  write_symbol_tables(models.symbol_tables, out);
  out.number(count, static_cast<uint32_t>(models.attributes.size()) - 1);
  for (const AttributeTables& attribute : models.attributes) {
    out.bits(attribute.coding.by_creation, 1);
    if (attribute.coding.by_creation) {
      out.bits(attribute.coding.backward, 1);
      out.bits(attribute.coding.two, 1);
      out.bits(attribute.coding.mean, 1);
      out.bits(attribute.coding.reach, 2);
    }
    out.number(count, static_cast<uint32_t>(attribute.sets.size()) - 1);
    for (const TokenTables& tables : attribute.sets)
      for (const std::vector<uint16_t>& table : tables) write_token_table(table, used, out);
    out.bits(attribute.has_flags, 1);
    if (attribute.has_flags)
      for (const uint32_t probability : attribute.flag_probability) out.bits(probability, core::kSlotBits);
  }
  out.number(count, static_cast<uint32_t>(models.seam_probability.size()));
  for (const std::array<uint32_t, 2>& seam : models.seam_probability)
    for (const uint32_t probability : seam) out.bits(probability, core::kSlotBits);
  std::vector<uint8_t> head;
  append_head_section(HeadSection::kTables, out.take(), head);
  if (models.has_borders) {
    used = used_kind();
    for (const std::vector<uint16_t>& table : models.border_tables) write_token_table(table, used, out);
    append_head_section(HeadSection::kBorders, out.take(), head);
  }
  if (!models.deltas.empty()) {
    write_deltas(models, out);
    append_head_section(HeadSection::kDeltas, out.take(), head);
  }
  return head;
}

}  // namespace psplit
