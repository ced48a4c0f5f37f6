// Attributes of deltas, coded together: morph targets of one mesh, of which most are 0 at most vertices, and
// which resemble each other. Begin to read at DeltaCoding::code. Specification: "deltas"
// (gltf_ext/PSPLIT_mesh_draco_patches).
//
// Vertices are coded in the order of creation, backward, and at each vertex all deltas:
//
//   flags         whether the delta is 0. Where all sources (delta_sources.h) that are neighbours agree, the
//                 vertex nearly always agrees too: runs count such flags. Elsewhere a flag is a bit.
//   remainders    of a delta that is not 0. A delta minus the multiple of another one that it resembles, its
//                 reference, is a remainder. It is predicted from those of the sources, by weights.
//   corrections   what the prediction is off by: tokens, whose tables are chosen by how large the corrections
//                 of the sources were.
//
// The four sections of deltas have flags, and the corrections of the three components.
#pragma once

#include "src/core/condensed/condensed_numbers.h"
#include "src/core/condensed/delta_sources.h"
#include "src/core/condensed/token_steps.h"
#include "src/core/patch.h"

#if defined(PSPLIT_HAS_VECTORS) && defined(__SSE2__) && !defined(__CUDACC__)
#include <emmintrin.h>
#endif

namespace psplit::core {

// The numbers of three components. The fourth is 0.
struct alignas(16) DeltaValues {
  int32_t of[4];
};

// An attribute of deltas in a stream. Its rows, in order, except rows that are 0 everywhere in the stream.
struct DeltaRow {
  static constexpr uint16_t kNone = DeltaModel::kNoReference;

  int32_t* values = nullptr;  // the attribute's, by vertex
  DeltaValues zero = {};
  uint16_t reference = kNone;  // a row before it
  int16_t factor = 0;
  bool is_even = false;
  // The rows that have this one as their reference: the first one, and from each the next one.
  uint16_t first_referrer = kNone, next_referrer = kNone;
};

// What others depend on of a row at a vertex.
struct alignas(16) DeltaRecord {
  int16_t remainders[4];  // 16 bits hold nearly all; the others become the nearest ones that have 16
  uint16_t sizes[4];      // the magnitudes of corrections, at most 255
};
// What depends on the records of sources: the prediction of a remainder, and sums of sizes.
struct DeltaAround {
  DeltaValues predicted;
  alignas(8) uint16_t sizes[4];
};

// In registers.
using DeltaBlock = Components<4>;

#if defined(PSPLIT_HAS_VECTORS) && defined(__SSE2__) && !defined(__CUDACC__)
PSPLIT_INLINE __m128i vector_of(DeltaBlock block) {
  DeltaValues values;
  block.store(values.of);
  return _mm_load_si128(reinterpret_cast<const __m128i*>(&values));
}
// Even a number of records is read. Those beyond `count` are zeros.
PSPLIT_INLINE DeltaAround around(const DeltaRecord* const* sources, const DeltaWeights& weights, uint32_t count,
                                 uint32_t row) {
  __m128i sums = _mm_set1_epi32(kDeltaOne / 2), sizes = _mm_setzero_si128();
  for (uint32_t n = 0; n < count; n += 2) {
    const __m128i a = _mm_load_si128(reinterpret_cast<const __m128i*>(&sources[n][row])),
                  b = _mm_load_si128(reinterpret_cast<const __m128i*>(&sources[n + 1][row]));
    // Of two sources, the products of the same component are side by side, and are added.
    int both;
    copy_bytes(&both, &weights.of[n], sizeof both);
    sums = _mm_add_epi32(sums, _mm_madd_epi16(_mm_unpacklo_epi16(a, b), _mm_set1_epi32(both)));
    sizes = _mm_add_epi16(sizes, _mm_add_epi16(a, b));
  }
  DeltaAround out;
  _mm_store_si128(reinterpret_cast<__m128i*>(&out.predicted), _mm_srai_epi32(sums, kDeltaBits));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(&out.sizes), _mm_unpackhi_epi64(sizes, sizes));
  return out;
}
PSPLIT_INLINE DeltaRecord delta_record(DeltaBlock remainders, DeltaBlock corrections) {
  const __m128i zero = _mm_setzero_si128(),
                narrow = _mm_packs_epi32(vector_of(remainders), vector_of(corrections)),
                magnitudes = _mm_max_epi16(narrow, _mm_subs_epi16(zero, narrow)),
                sizes = _mm_min_epi16(magnitudes, _mm_set1_epi16(kMostDeltaSize));
  DeltaRecord out;
  _mm_store_si128(reinterpret_cast<__m128i*>(&out),
                  _mm_unpacklo_epi64(narrow, _mm_unpackhi_epi64(sizes, sizes)));
  return out;
}
#else
PSPLIT_HD PSPLIT_INLINE DeltaAround around(const DeltaRecord* const* sources, const DeltaWeights& weights,
                                           uint32_t count, uint32_t row) {
  DeltaAround out = {};
  for (uint32_t k = 0; k < kDeltaComponents; ++k) {
    int32_t sum = kDeltaOne / 2;
    uint32_t size = 0;
    for (uint32_t n = 0; n < count; ++n) {
      sum += weights.of[n] * sources[n][row].remainders[k];
      size += sources[n][row].sizes[k];
    }
    out.predicted.of[k] = sum >> kDeltaBits;
    out.sizes[k] = static_cast<uint16_t>(size);
  }
  return out;
}
PSPLIT_HD inline DeltaRecord delta_record(DeltaBlock remainders, DeltaBlock corrections) {
  DeltaValues of, corrected;
  remainders.store(of.of);
  corrections.store(corrected.of);
  DeltaRecord out = {};
  for (uint32_t k = 0; k < kDeltaComponents; ++k) {
    const int32_t value = of.of[k];
    const uint32_t size = magnitude(corrected.of[k]);
    out.remainders[k] = static_cast<int16_t>(value < -0x8000 ? -0x8000 : value > 0x7fff ? 0x7fff : value);
    out.sizes[k] = static_cast<uint16_t>(size < kMostDeltaSize ? size : kMostDeltaSize);
  }
  return out;
}
#endif

// The level of corrections where those around have this mean size, in quarters.
PSPLIT_HD constexpr uint32_t level_of_mean(uint32_t mean) {
  if (mean < 2) return mean;
  uint32_t top = 1;
  while (mean >> (top + 1) != 0) ++top;
  return 2 * top + (mean >> (top - 1) & 1);
}
inline constexpr uint32_t kMeanSizes = 4 * kMostDeltaSize + 1;
struct DeltaLevels {
  constexpr DeltaLevels() {
    for (uint32_t mean = 0; mean < kMeanSizes; ++mean)
      of_mean[mean] = static_cast<uint8_t>(level_of_mean(mean));
  }
  uint8_t of_mean[kMeanSizes] = {};
};
inline constexpr DeltaLevels kDeltaLevels;

PSPLIT_HD PSPLIT_INLINE uint8_t delta_level(uint32_t mean) {
#if PSPLIT_MOVES_ROWS
  return static_cast<uint8_t>(level_of_mean(mean));
#else
  return kDeltaLevels.of_mean[mean];
#endif
}

// A row whose delta at a vertex is not 0, and the levels of its corrections.
struct DeltaItem {
  uint16_t row;
  uint8_t levels[kDeltaComponents];
};

// Codes the deltas of vertex after vertex. A coder reads them, or writes them:
//
//   flags(sure, expected, mixed)     returns the flags of 32 rows. Those in `sure` equal those in `expected`,
//                                    unless a run ends there; those in `mixed` are bits
//   begin(items, count)              announces the deltas of a vertex that are not 0
//   corrections(n, item, expected)   returns what `expected` of item n is off by
//
// The memory has no meaning before. Arrays are by place in the order of creation, then by row.
template <typename Index>
class DeltaCoding {
 public:
  PSPLIT_HD static size_t bytes(uint64_t vertices, uint64_t rows) {
    return Arena::bytes<DeltaSources<Index>>(vertices) + Arena::bytes<uint32_t>(vertices * words(rows)) +
           Arena::bytes<DeltaRecord>((vertices + 1) * rows) + 2 * Arena::bytes<DeltaValues>(rows) +
           Arena::bytes<DeltaItem>(rows);
  }
  PSPLIT_HD bool allocate(uint32_t vertex_count, View<DeltaRow> rows, Arena& arena) {
    rows_ = rows;
    for (size_t r = rows.size(); r-- > 0;) {
      if (rows[r].reference == DeltaRow::kNone) continue;
      uint16_t& first = rows[rows[r].reference].first_referrer;
      rows[r].next_referrer = first;
      first = static_cast<uint16_t>(r);
    }
    for (uint32_t count = 0; count <= kMostDeltaSources; ++count) even_[count] = even_delta_weights(count);
    const uint64_t vertices = vertex_count, row_count = rows.size();
    if (!arena.take(sources_, vertices) || !arena.take(flags_, vertices * words(row_count)) ||
        !arena.take(records_, (vertices + 1) * row_count) || !arena.take(deltas_, row_count) ||
        !arena.take(predicted_, row_count) || !arena.take(items_, row_count))
      return false;
    set_bytes(&records_[vertices * row_count], 0, row_count * sizeof(DeltaRecord));
    return true;
  }
  PSPLIT_HD View<DeltaSources<Index>> sources() const { return sources_; }

  // Codes the vertex at place `i`. Its sources are set, and all vertices before it are coded. Calls
  // put(row, delta) for each delta that is not 0.
  template <typename Coder, typename Put>
  PSPLIT_HD void code(uint32_t i, Coder& coder, Put put) const {
    const auto row_count = static_cast<uint32_t>(rows_.size());
    const DeltaSources<Index>& sources = sources_[i];
    const View<const uint32_t> flags = code_flags(i, sources, coder);
    DeltaRecord* const records = records_.data() + size_t{i} * row_count;
    set_bytes(records, 0, row_count * sizeof *records);
    const uint32_t count = list_items(sources, flags);
    coder.begin(items_.data(), count);
    for (uint32_t n = 0; n < count; ++n) {
      const DeltaItem item = items_[n];
      const DeltaRow& row = rows_[item.row];
      const DeltaBlock predicted(predicted_[n].of);
      DeltaBlock expected = predicted;
      if (row.reference != DeltaRow::kNone && is_flagged(flags, row.reference))
        expected = expected + part_of(row, DeltaBlock(deltas_[row.reference].of));
      const DeltaBlock corrections = coder.corrections(n, item, expected), delta = expected + corrections;
      records[item.row] = delta_record(predicted + corrections, corrections);
      delta.store(deltas_[item.row].of);
      put(item.row, delta);
      // A delta of 0 has a remainder too, if that of its reference is not 0.
      for (uint32_t r = row.first_referrer; r != DeltaRow::kNone; r = rows_[r].next_referrer)
        if (!is_flagged(flags, r))
          records[r] = delta_record(DeltaBlock(0) - part_of(rows_[r], delta), DeltaBlock(0));
    }
  }

 private:
  PSPLIT_HD static constexpr uint64_t words(uint64_t rows) { return (rows + 31) / 32; }
  PSPLIT_HD static bool is_flagged(View<const uint32_t> flags, uint32_t row) {
    return (flags[row / 32] >> row % 32 & 1) != 0;
  }
  // The multiple of the reference's delta that a row resembles.
  PSPLIT_HD static DeltaBlock part_of(const DeltaRow& row, DeltaBlock delta) {
    return (delta.times(row.factor) + DeltaBlock(kDeltaOne / 2)).shifted(kDeltaBits);
  }

  template <typename Coder>
  PSPLIT_HD View<const uint32_t> code_flags(uint32_t i, const DeltaSources<Index>& sources,
                                            Coder& coder) const {
    const auto count = static_cast<uint32_t>(words(rows_.size()));
    uint32_t* const flags = flags_.data() + size_t{i} * count;
    for (uint32_t word = 0; word < count; ++word) {
      uint32_t all = sources.neighbours != 0 ? ~0u : 0, some = 0;
      for (uint32_t left = sources.neighbours; left != 0; left &= left - 1) {
        const uint32_t of_source = flags_[size_t{sources.place[trailing_zeros(left)]} * count + word];
        all &= of_source, some |= of_source;
      }
      const uint32_t rows = static_cast<uint32_t>(rows_.size()) - 32 * word;
      const uint32_t valid = rows >= 32 ? ~0u : (1u << rows) - 1, mixed = some & ~all & valid;
      flags[word] = coder.flags(valid & ~mixed, all & valid & ~mixed, mixed);
    }
    return {flags, count};
  }

  // Lists the rows that are not 0, with the levels of their corrections. Returns their number.
  PSPLIT_HD uint32_t list_items(const DeltaSources<Index>& sources, View<const uint32_t> flags) const {
    const size_t row_count = rows_.size();
    const uint32_t source_count = sources.count;
    const DeltaRecord* records_of[kMostDeltaSources];
    for (uint32_t n = 0; n < kMostDeltaSources; ++n)
      records_of[n] =
          n < source_count ? &records_[sources.place[n] * row_count] : &records_[records_.size() - row_count];
    const DeltaWeights& even = even_[source_count];
    // Of a sum of sizes, the mean in quarters. The quotient is exact, because sums are below 8 * 256.
    constexpr uint32_t kUnit = 1u << 16;
    const uint32_t per_source = source_count > 0 ? (kUnit + source_count - 1) / source_count : 0;
    uint32_t count = 0;
    for (uint32_t word = 0; word < flags.size(); ++word)
      for (uint32_t left = flags[word]; left != 0; left &= left - 1, ++count) {
        const uint32_t row = 32 * word + trailing_zeros(left);
        const DeltaAround of =
            around(records_of, rows_[row].is_even ? even : sources.weights, source_count, row);
        predicted_[count] = of.predicted;
        DeltaItem& item = items_[count];
        item.row = static_cast<uint16_t>(row);
        for (uint32_t k = 0; k < kDeltaComponents; ++k)
          item.levels[k] = delta_level(4 * of.sizes[k] * per_source >> 16);
        if (source_count == 0)
          for (uint8_t& level : item.levels) level = DeltaTables::kLevels - 1;
      }
    return count;
  }

  View<DeltaRow> rows_;
  View<DeltaSources<Index>> sources_;
  View<uint32_t> flags_;       // bits, by word
  View<DeltaRecord> records_;  // the vertices' records, then zeros
  // Of the vertex being coded: its nonzero deltas by row, the list of these, and their predictions.
  View<DeltaValues> deltas_, predicted_;
  View<DeltaItem> items_;
  DeltaWeights even_[kMostDeltaSources + 1];  // by number of sources
};

// Reads flags and corrections from the sections of a stream.
class DeltaReader {
 public:
  // `sections` are started, and all tables exist. `corrections` has room for one vertex's corrections.
  PSPLIT_HD DeltaReader(const SectionReader (&sections)[kDeltaSections], const CondensedModels& models,
                        View<DeltaValues> corrections)
      : flags_(sections[0]), some_(models.delta_tables.some), corrections_(corrections.data()) {
    for (uint32_t k = 0; k < kDeltaComponents; ++k) sections_[k] = sections[1 + k];
    runs_ = &models.token_tables[models.delta_tables.runs];
    for (uint32_t level = 0; level < DeltaTables::kLevels; ++level)
      tables_[level] = &models.token_tables[models.delta_tables.of_level[level]];
    run_ = symbol(flags_, *runs_);
  }

  PSPLIT_HD uint32_t flags(uint32_t sure, uint32_t expected, uint32_t mixed) {
    uint32_t flags = expected;
    uint32_t count = bit_count(sure);
    while (PSPLIT_UNLIKELY(run_ < count)) {
      for (; run_ > 0; --run_, --count) sure &= sure - 1;
      flags ^= sure & (0u - sure);
      sure &= sure - 1;
      --count;
      run_ = symbol(flags_, *runs_);
    }
    run_ -= count;
    for (; mixed != 0; mixed &= mixed - 1)
      if (flags_.next_bit(some_) != 0) flags |= mixed & (0u - mixed);
    return flags;
  }
  // Decodes the corrections of a vertex at once: no more of it depends on them than sums.
  PSPLIT_HD void begin(const DeltaItem* items, uint32_t count) {
    SectionReader x = sections_[0], y = sections_[1], z = sections_[2];
    for (uint32_t n = 0; n < count; ++n) {
      const DeltaItem item = items[n];
      int32_t* const out = corrections_[n].of;
      out[0] = correction(x, *tables_[item.levels[0]]);
      out[1] = correction(y, *tables_[item.levels[1]]);
      out[2] = correction(z, *tables_[item.levels[2]]);
      out[3] = 0;
    }
    sections_[0] = x, sections_[1] = y, sections_[2] = z;
  }
  PSPLIT_HD DeltaBlock corrections(uint32_t n, const DeltaItem&, DeltaBlock) const {
    return DeltaBlock(corrections_[n].of);
  }
  // Whether all sections are read to their ends, when all vertices are coded.
  PSPLIT_HD bool is_at_end() const {
    bool is_at_end = flags_.is_at_end();
    for (const SectionReader& section : sections_) is_at_end &= section.is_at_end();
    return is_at_end;
  }

 private:
  PSPLIT_HD PSPLIT_INLINE static uint32_t symbol(SectionReader& section, const TokenTable& table) {
    const uint32_t token = section.next_token(table);
    if (PSPLIT_LIKELY(token < kDirectTokens)) return token;
    const TokenBits bits = bits_of_token(token);
    return bits.base + section.read(static_cast<int>(bits.bit_count));
  }
  PSPLIT_HD PSPLIT_INLINE static int32_t correction(SectionReader& section, const TokenTable& table) {
    return static_cast<int32_t>(signed_of_symbol(symbol(section, table)));
  }

  SectionReader flags_, sections_[kDeltaComponents];
  uint32_t some_, run_ = 0;  // run: the sure flags before the next one that is not as expected
  DeltaValues* corrections_;
  const TokenTable* runs_;
  const TokenTable* tables_[DeltaTables::kLevels];
};

// The attributes of deltas of a stream.
template <typename Index>
class DeltaDecoder {
 public:
  // Reads which of them are not 0 everywhere, and the lengths of the sections, whose sum is added to `at`:
  // there they begin in the stream.
  PSPLIT_HD Fault read(const CondensedStream& stream, CondensedNumbers& numbers, NumberKind& bytes,
                       const Patch<Index>& patch, Arena& arena) {
    count_ = stream.models.delta_count(stream.attribute_count);
    if (count_ == 0) return Fault::kNone;
    View<uint16_t> row_of;
    if (!arena.take(row_of, count_) || !arena.take(rows_, count_)) return Fault::kWorkspace;
    uint16_t row_count = 0;
    for (uint32_t n = 0; n < count_; ++n) {
      const DeltaModel& model = stream.models.deltas[n];
      const Attribute<Index>& attribute = patch.attributes[model.attribute];
      // All of them are in the table of the first attribute, which has their places.
      if (attribute.coding == Coding::kRaw || attribute.value_components() != kDeltaComponents ||
          attribute.group != patch.attributes[0].group)
        return Fault::kAttribute;
      row_of[n] = DeltaRow::kNone;
      if (numbers.bit() == 0) continue;
      DeltaRow& row = rows_[row_count];
      row = {};
      row.factor = model.factor;
      row.is_even = model.is_even;
      for (uint32_t k = 0; k < kDeltaComponents; ++k) row.zero.of[k] = model.zero[k];
      if (model.reference != DeltaModel::kNoReference) row.reference = row_of[model.reference];
      row_of[n] = row_count++;
    }
    rows_ = rows_.first(row_count);
    row_of_ = row_of;
    for (uint32_t s = 0; s < kDeltaSections; ++s) section_bytes_[s] = row_count > 0 ? numbers.number(bytes) : 0;
    return Fault::kNone;
  }
  PSPLIT_HD uint32_t count() const { return count_; }
  // What the sections take, divided among the attributes that are not 0 everywhere.
  PSPLIT_HD uint32_t share_of_sections(uint32_t n) const {
    if (row_of_[n] == DeltaRow::kNone) return 0;
    uint64_t all = 0;
    for (const uint32_t bytes : section_bytes_) all += bytes;
    return static_cast<uint32_t>(all * (row_of_[n] + 1u) / rows_.size() - all * row_of_[n] / rows_.size());
  }

  // Takes memory. The sections begin at byte `at` of the stream.
  PSPLIT_HD Fault start(const CondensedStream& stream, size_t at, Patch<Index>& patch, Arena& arena) {
    if (count_ == 0) return Fault::kNone;
    const uint32_t vertex_count = patch.groups[patch.attributes[0].group].table.vertex_count;
    for (uint32_t n = 0; n < count_; ++n) {
      Attribute<Index>& attribute = patch.attributes[stream.models.deltas[n].attribute];
      if (!arena.take(attribute.values, uint64_t{vertex_count} * value_stride(kDeltaComponents)))
        return Fault::kWorkspace;
      if (row_of_[n] != DeltaRow::kNone) rows_[row_of_[n]].values = attribute.values.data();
    }
    if (rows_.empty()) return Fault::kNone;
    const DeltaTables& tables = stream.models.delta_tables;
    if (tables.runs == kNoTable) return Fault::kEntropy;
    for (const uint16_t table : tables.of_level)
      if (table == kNoTable) return Fault::kEntropy;
    for (uint32_t s = 0; s < kDeltaSections; ++s) {
      sections_[s] = SectionReader(stream.bytes.data() + at, section_bytes_[s]);
      if (const Fault fault = sections_[s].start_words(0); fault != Fault::kNone) return fault;
      at += section_bytes_[s];
    }
    return arena.take(corrections_, rows_.size()) && coding_.allocate(vertex_count, rows_, arena)
               ? Fault::kNone
               : Fault::kWorkspace;
  }

  // Decodes all values, once the first attribute's are decoded. `order` is the order of creation, backward, and
  // `places` has the place of each vertex. Collective.
  template <Lanes L>
  PSPLIT_HD Fault decode(L lanes, const CondensedStream& stream, const Sequence<Index>& order,
                         DeltaPlaces places, Patch<Index>& patch) {
    if (count_ == 0) return Fault::kNone;
    const AttributeTable<Index>& table = patch.groups[patch.attributes[0].group].table;
    const uint32_t vertex_count = table.vertex_count;
    static_assert(value_stride(kDeltaComponents) * sizeof(int32_t) == sizeof(DeltaValues));
    for (uint32_t n = 0; n < count_; ++n) {
      const DeltaModel& model = stream.models.deltas[n];
      const DeltaValues zero = {{model.zero[0], model.zero[1], model.zero[2], 0}};
      int32_t* const values = patch.attributes[model.attribute].values.data();
      for_each_lane_item(lanes, vertex_count,
                         [&](uint32_t v) { copy_bytes(values + size_t{4} * v, &zero, sizeof zero); });
    }
    if (rows_.empty()) {
      lanes.sync();
      return Fault::kNone;
    }
    const DeltaSourceSearch<Index> search(table.table, order, places);
    for_each_lane_item(lanes, vertex_count, [&](uint32_t i) { coding_.sources()[i] = search.find(i); });
    lanes.sync();
    return alone(lanes, [&] {
      DeltaReader reader(sections_, stream.models, corrections_);
      for (uint32_t i = 0; i < vertex_count; ++i) {
        const size_t at = size_t{4} * table.table.vertex[order.corner[i]];
        coding_.code(i, reader, [&](uint32_t r, DeltaBlock delta) {
          (delta + DeltaBlock(rows_[r].zero.of)).store(rows_[r].values + at);
        });
      }
      return reader.is_at_end() ? Fault::kNone : Fault::kSection;
    });
  }

  // The memory that read and start take for at most `vertices` vertices, without values.
  PSPLIT_HD static size_t bytes(const CondensedStream& stream, uint32_t vertices) {
    const uint32_t count = stream.models.delta_count(stream.attribute_count);
    if (count == 0) return 0;
    return Arena::bytes<uint16_t>(count) + Arena::bytes<DeltaRow>(count) +
           Arena::bytes<DeltaValues>(stream.delta_row_count) +
           DeltaCoding<Index>::bytes(vertices, stream.delta_row_count) +
           count * Arena::bytes<int32_t>(uint64_t{vertices} * value_stride(kDeltaComponents));
  }

 private:
  uint32_t count_ = 0;     // of attributes
  View<uint16_t> row_of_;  // by attribute of deltas; kNoReference if all of its deltas are 0
  View<DeltaRow> rows_;
  uint32_t section_bytes_[kDeltaSections] = {};
  SectionReader sections_[kDeltaSections];
  View<DeltaValues> corrections_;  // of a vertex, by row
  DeltaCoding<Index> coding_;
};

}  // namespace psplit::core
