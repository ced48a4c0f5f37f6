#include "src/container/condensed_head.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "src/container/bit_string.h"
#include "src/core/edgebreaker_symbols.h"
#include "src/core/stream_header.h"

namespace psplit {
namespace {

using core::kSlotBits;
using core::kSlots;
using core::NumberKind;
using core::SymbolContext;

constexpr uint32_t kMostAttributes = 256, kMostAttributeData = 128;

Status invalid(const std::string& cause) { return invalid_input("head: " + cause); }

// Reads the bits of one section into a head.
class HeadSectionReader {
 public:
  HeadSectionReader(std::span<const uint8_t> bytes, CondensedHead& head) : bits_(bytes), head_(head) {}

  Status read_tables() {
    Status status = read_skeletons();
    if (status.ok()) status = read_contexts();
    if (status.ok()) status = read_attributes();
    if (status.ok()) status = read_seams();
    return status.ok() ? check_end() : status;
  }
  Status read_borders() {
    if (head_.skeletons.empty()) return invalid("values at borders without tables");
    head_.has_borders = true;
    for (uint16_t& table : head_.border_tables)
      if (Status status = read_token_table(table); !status.ok()) return status;
    return check_end();
  }

  Status read_deltas() {
    if (head_.skeletons.empty()) return invalid("deltas without tables");
    const uint64_t count = uint64_t{bits_.number(count_)} + 1;
    if (bits_.broken()) return check_truncation();
    NumberKind skip{0}, zero{10}, back{1}, factor{5};
    uint64_t attribute = 0;
    for (uint64_t n = 0; n < count; ++n) {
      // The first attribute has the places, so it is none of them.
      attribute += uint64_t{bits_.number(skip)} + 1;
      if (bits_.broken()) return check_truncation();
      if (attribute >= head_.attributes.size()) return invalid("deltas of an attribute without a model");
      core::AttributeModel& model = head_.attributes[static_cast<size_t>(attribute)];
      if (!model.by_creation || model.set_count > 1) return invalid("deltas with a model of other values");
      model.is_delta = true;
      core::DeltaModel& delta = head_.deltas.emplace_back();
      delta.attribute = static_cast<uint16_t>(attribute);
      delta.is_even = bits_.bits(1) != 0;
      for (int32_t& of : delta.zero) of = static_cast<int32_t>(bits_.signed_number(zero));
      if (bits_.bits(1) == 0) continue;
      const uint64_t distance = uint64_t{bits_.number(back)} + 1;
      const int64_t times = bits_.signed_number(factor);
      if (bits_.broken()) return check_truncation();
      constexpr int64_t kMostFactor = 0x7fff;
      if (distance > n || times < -kMostFactor || times > kMostFactor) return invalid("an invalid reference");
      delta.reference = static_cast<uint16_t>(n - distance);
      delta.factor = static_cast<int16_t>(times);
    }
    return read_delta_tables();
  }

 private:
  Status read_delta_tables() {
    core::DeltaTables& tables = head_.delta_tables;
    if (!read_probability(tables.some))
      return bits_.broken() ? check_truncation() : invalid("a probability of 0");
    uint32_t begins = bits_.bits(core::DeltaTables::kLevels - 1) << 1 | 1;
    if (bits_.broken()) return check_truncation();
    if (core::bit_count(begins) > kMostDeltaTables) return invalid("more than 8 tables of deltas");
    if (Status status = read_token_table(tables.runs); !status.ok()) return status;
    for (uint16_t& table : tables.of_level) {
      if ((begins & 1) != 0) {
        table = core::kNoTable;
        if (Status status = read_token_table(table); !status.ok()) return status;
      } else {
        table = *(&table - 1);
      }
      begins >>= 1;
    }
    return check_end();
  }

  Status check_truncation() const { return bits_.broken() ? invalid("a section ends early") : Status(); }
  // The unused bits of the last byte are 0.
  Status check_end() {
    if (bits_.broken()) return check_truncation();
    return bits_.ends_here() ? Status() : invalid("a section does not end with its last bit");
  }

  Status read_skeletons() {
    const uint64_t count = uint64_t{bits_.number(count_)} + 1;
    if (bits_.broken()) return check_truncation();
    if (count > kMostSkeletons) return invalid("more than 255 skeletons");
    NumberKind length_kind{5};
    for (uint64_t i = 0; i < count; ++i) {
      constexpr uint32_t kMostLevel = 11;
      const uint32_t level = bits_.bits(4), length = bits_.number(length_kind);
      if (bits_.broken()) return check_truncation();
      if (length > kMostSkeletonBytes) return invalid("a skeleton of more than 4096 bytes");
      if (level > kMostLevel) return invalid("an unknown level of entropy coding");
      head_.levels.push_back(static_cast<uint8_t>(level));
      std::vector<uint8_t>& skeleton =
          head_.skeletons.emplace_back(kSkeletonFront.begin(), kSkeletonFront.end());
      for (uint32_t k = 0; k < length; ++k) skeleton.push_back(static_cast<uint8_t>(bits_.bits(8)));
      if (bits_.broken()) return check_truncation();
    }
    return {};
  }

  Status read_contexts() {
    constexpr uint32_t kContextsOfValences = core::Valences<uint32_t>::kClasses * SymbolContext::kCount;
    const uint32_t coding = bits_.bits(4);
    if (coding > kMostHistory && coding != kValenceContexts) return invalid("unknown contexts of symbols");
    head_.has_valence_contexts = coding == kValenceContexts;
    uint32_t count = head_.has_valence_contexts ? kContextsOfValences : 1;
    for (uint32_t k = 0; k < coding && !head_.has_valence_contexts; ++k) count *= SymbolContext::kCount;
    NumberKind frequency_kind{4};
    for (uint32_t i = 0; i < count; ++i) {
      std::array<uint32_t, SymbolContext::kCount> frequencies;
      uint64_t sum = 0;
      for (uint32_t& frequency : frequencies) sum += frequency = bits_.number(frequency_kind);
      if (bits_.broken()) return check_truncation();
      if (sum != 0 && sum != kSlots) return invalid("frequencies of symbols that do not sum to 4096");
      SymbolContext& context =
          head_.contexts.emplace_back(sum == 0 ? unused_context() : context_of(frequencies));
      if (!head_.has_valence_contexts) context.next = i * SymbolContext::kCount % count;
    }
    // The step after a symbol leads to another context for each symbol, even if all steps are equal.
    if (count == 1) head_.contexts.resize(SymbolContext::kCount, head_.contexts.front());
    return {};
  }
  static SymbolContext context_of(const std::array<uint32_t, SymbolContext::kCount>& frequencies) {
    SymbolContext context;
    uint32_t first = 0;
    for (uint32_t s = 0; s < SymbolContext::kCount; ++s) {
      context.shares[s] = {frequencies[s], first};
      context.codes[s] = static_cast<uint8_t>(core::clers_of_number(s));
      first += frequencies[s];
    }
    return context;
  }
  static SymbolContext unused_context() {
    SymbolContext context = context_of({kSlots, 0, 0, 0, 0});
    for (uint8_t& code : context.codes) code = SymbolContext::kInvalid;
    return context;
  }

  Status read_attributes() {
    const uint64_t count = uint64_t{bits_.number(count_)} + 1;
    if (bits_.broken()) return check_truncation();
    if (count > kMostAttributes) return invalid("models of more than 256 attributes");
    for (uint64_t i = 0; i < count; ++i) {
      core::AttributeModel& model = head_.attributes.emplace_back();
      model.by_creation = bits_.bits(1) != 0;
      if (model.by_creation) {
        model.backward = bits_.bits(1) != 0;
        model.two = bits_.bits(1) != 0;
        model.mean = bits_.bits(1) != 0;
        constexpr uint32_t kMostReach = 2;
        model.reach = static_cast<uint8_t>(bits_.bits(2));
        if (model.reach > kMostReach) return bits_.broken() ? check_truncation() : invalid("an unknown reach");
      }
      if (Status status = read_table_sets(model); !status.ok()) return status;
      model.has_flags = bits_.bits(1) != 0;
      if (!model.has_flags) continue;
      bool is_valid = true;
      for (uint16_t& crease : model.creases) is_valid &= read_probability(crease);
      is_valid &= read_probability(model.orientations);
      is_valid &= read_probability(model.flips);
      if (!is_valid) return bits_.broken() ? check_truncation() : invalid("a probability of 0");
    }
    return check_truncation();
  }
  Status read_table_sets(core::AttributeModel& model) {
    const uint64_t count = uint64_t{bits_.number(count_)} + 1;
    if (bits_.broken()) return check_truncation();
    if (count > kMostTableSets) return invalid("more than 8 sets of token tables for an attribute");
    if (head_.table_sets.size() + count > kMostTableSetsOfAll)
      return invalid("more than 256 sets of token tables");
    model.first_set = static_cast<uint16_t>(head_.table_sets.size());
    model.set_count = static_cast<uint16_t>(count);
    for (uint64_t s = 0; s < count; ++s) {
      core::TableSet& set = head_.table_sets.emplace_back();
      for (uint32_t t = 0; t < (model.by_creation ? 3u : 2u); ++t)
        if (Status status = read_token_table(set.tables[t]); !status.ok()) return status;
    }
    return {};
  }
  bool read_probability(uint16_t& probability) {
    probability = static_cast<uint16_t>(bits_.bits(kSlotBits));
    return probability > 0;
  }

  Status read_token_table(uint16_t& number_of_table) {
    const uint32_t used = bits_.number(used_);
    if (bits_.broken()) return check_truncation();
    if (used > core::kTokenCount) return invalid("a table of more than 116 tokens");
    if (used == 0) return {};
    NumberKind frequency_kind{4};
    std::array<uint32_t, core::kTokenCount> frequencies{};
    uint64_t sum = 0;
    for (uint32_t token = 0; token < used; ++token) sum += frequencies[token] = bits_.number(frequency_kind);
    if (bits_.broken()) return check_truncation();
    if (sum != kSlots) return invalid("frequencies of tokens that do not sum to 4096");
    // Three tables for each of 256 sets, two for borders, and nine for deltas.
    number_of_table = static_cast<uint16_t>(head_.token_tables.size());
    core::TokenTable& table = head_.token_tables.emplace_back();
    uint32_t first = 0;
    for (uint32_t token = 0; token < used; ++token) {
      table.shares[token] = {frequencies[token], first};
      std::fill_n(table.token_of + first, frequencies[token], static_cast<uint8_t>(token));
      first += frequencies[token];
    }
    return {};
  }

  Status read_seams() {
    const uint32_t count = bits_.number(count_);
    if (bits_.broken()) return check_truncation();
    if (count > kMostAttributeData) return invalid("models of more than 128 attribute data");
    for (uint32_t i = 0; i < count; ++i) {
      core::SeamModel& seam = head_.seams.emplace_back();
      const bool is_valid = read_probability(seam.after[0]) && read_probability(seam.after[1]);
      if (!is_valid) return bits_.broken() ? check_truncation() : invalid("a probability of 0");
    }
    return {};
  }

  BitStringReader bits_;
  NumberKind count_{0}, used_{5};
  CondensedHead& head_;
};

Status read_section(uint32_t type, std::span<const uint8_t> bytes, CondensedHead& head) {
  if (type >= static_cast<uint32_t>(HeadSection::kMayBeSkipped)) return {};
  // Without tables, no stream is condensed.
  if (!core::kReadsCondensed)
    return unsupported("head: tables of condensed streams, which this build leaves out");
  switch (static_cast<HeadSection>(type)) {
    case HeadSection::kTables: return HeadSectionReader(bytes, head).read_tables();
    case HeadSection::kBorders: return HeadSectionReader(bytes, head).read_borders();
    case HeadSection::kDeltas: return HeadSectionReader(bytes, head).read_deltas();
    default:
      return unsupported("head: section " + std::to_string(type) + " is not known, and may not be skipped");
  }
}

}  // namespace

core::CondensedModels CondensedHead::models() const {
  core::CondensedModels models;
  models.has_valence_contexts = has_valence_contexts;
  // The history before the first symbol is of E alone, the last of the symbols.
  models.first_context = has_valence_contexts ? 0 : static_cast<uint32_t>(contexts.size()) - 1;
  models.has_borders = has_borders;
  for (size_t i = 0; i < border_tables.size(); ++i) models.border_tables[i] = border_tables[i];
  models.contexts = {contexts.data(), contexts.size()};
  models.token_tables = {token_tables.data(), token_tables.size()};
  models.table_sets = {table_sets.data(), table_sets.size()};
  models.attributes = {attributes.data(), attributes.size()};
  models.seams = {seams.data(), seams.size()};
  models.deltas = {deltas.data(), deltas.size()};
  models.delta_tables = delta_tables;
  return models;
}

void append_head_section(HeadSection type, std::span<const uint8_t> bytes, std::vector<uint8_t>& head) {
  head.push_back(static_cast<uint8_t>(type));
  size_t length = bytes.size();
  for (; length >= 0x80; length >>= 7) head.push_back(static_cast<uint8_t>(length | 0x80));
  head.push_back(static_cast<uint8_t>(length));
  head.insert(head.end(), bytes.begin(), bytes.end());
}

std::span<const uint8_t> find_head_section(HeadSection wanted, std::span<const uint8_t> head) {
  core::ByteReader reader(head.data(), head.size());
  while (reader.remaining() > 0) {
    const uint32_t type = reader.u8();
    const uint64_t length = reader.varint64();
    if (reader.truncated() || length > reader.remaining()) return {};
    if (type == static_cast<uint32_t>(wanted)) return {reader.head(), static_cast<size_t>(length)};
    reader.skip(length);
  }
  return {};
}

Expected<CondensedHead> read_condensed_head(std::span<const uint8_t> bytes) {
  constexpr size_t kMostLengthBytes = 5;
  CondensedHead head;
  core::ByteReader reader(bytes.data(), bytes.size());
  for (int last_type = -1; reader.remaining() > 0;) {
    const int type = reader.u8();
    if (type <= last_type) return invalid("its sections do not ascend by type");
    last_type = type;
    const size_t length_at = reader.position();
    const uint64_t length = reader.varint64();
    if (reader.truncated() || reader.position() - length_at > kMostLengthBytes || length > reader.remaining())
      return invalid("a section of more bytes than there are");
    const std::span section(reader.head(), static_cast<size_t>(length));
    reader.skip(length);
    if (Status status = read_section(static_cast<uint32_t>(type), section, head); !status.ok()) return status;
  }
  return head;
}

}  // namespace psplit
