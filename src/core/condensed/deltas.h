// Attributes of deltas, coded together: morph targets of one mesh, of which most are 0 at most vertices, and
// which resemble each other. Begin to read at DeltaCoding::code. Specification: "deltas"
// (gltf_ext/PSPLIT_mesh_draco_patches).
//
// Vertices are coded in the order of creation, backward, and at each vertex all deltas:
//
//   flags         whether the delta is 0. Where all sources (delta_sources.h) that are neighbours agree, the
//                 vertex nearly always agrees too: runs count such flags. Elsewhere a flag is a bit.
//   remainders    of a delta that is not 0. A delta minus the multiple of another one that it resembles, its
//                 reference, is a remainder. It is predicted from the sources' remainders, by weights.
//   corrections   remainders less their predictions: tokens, whose tables are chosen by how large the
//                 corrections of the sources were.
//
// The four sections of deltas have flags, and the corrections of the three components.
#pragma once

#include "src/core/condensed/condensed_numbers.h"
#include "src/core/condensed/delta_sources.h"
#include "src/core/condensed/token_steps.h"
#include "src/core/patch.h"

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
  const DeltaValues* referred = nullptr;  // what `reference` has at the vertex being coded, or a 0
  uint16_t reference = kNone;             // a row before it
  bool is_even = false;
  int32_t factor = 0;
};

// What others depend on of a row at a vertex.
struct alignas(16) DeltaRecord {
  int16_t remainders[4];  // 16 bits hold nearly all; the others become the nearest ones that have 16
  uint16_t sizes[4];      // the magnitudes of corrections, at most 255
};

// A row whose delta at a vertex is not 0. `means` are of the sizes of the sources, in quarters, by component.
struct alignas(8) DeltaItem {
  uint16_t means[kDeltaComponents];
  uint16_t row;
};
inline constexpr uint16_t kMostMeanSize = 4 * kMostDeltaSize,
                          kNoMeanSize = kMostMeanSize + 4;  // without sources

// Three numbers and a 0 in registers.
using DeltaBlock = Components<4>;

#if defined(PSPLIT_HAS_SSE2_DELTAS)
PSPLIT_INLINE __m128i vector_of(DeltaBlock block) {
  DeltaValues values;
  block.store(values.of);
  return _mm_load_si128(reinterpret_cast<const __m128i*>(&values));
}
PSPLIT_INLINE DeltaBlock block_of(__m128i vector) {
  DeltaValues values;
  _mm_store_si128(reinterpret_cast<__m128i*>(&values), vector);
  return DeltaBlock(values.of);
}
// Each component times `factor`: fewer instructions than for any two vectors.
PSPLIT_INLINE DeltaBlock scaled(DeltaBlock block, int32_t factor) {
  const __m128i of = vector_of(block), factors = _mm_set1_epi32(factor);
  const __m128 even = _mm_castsi128_ps(_mm_mul_epu32(of, factors)),
               odd = _mm_castsi128_ps(_mm_mul_epu32(_mm_srli_epi64(of, 32), factors));
  return block_of(_mm_shuffle_epi32(_mm_castps_si128(_mm_shuffle_ps(even, odd, 0x88)), 0xd8));
}
// The records of a vertex's sources, and their weights. Those beyond the last source are zeros.
class DeltaNeighbourhood {
 public:
  static constexpr uint32_t kMostPairs = kMostDeltaSources / 2;

  // records[n] are the records of source n. There are `count` sources.
  DeltaNeighbourhood(const DeltaRecord* const (&records)[kMostDeltaSources], const DeltaWeights& affine,
                     const DeltaWeights& even, uint32_t count)
      : shift_(_mm_cvtsi32_si128(count == 1 ? 3 : 2)),
        per_source_(_mm_set1_epi16(static_cast<int16_t>(mean_factor(count)))) {
    for (uint32_t n = 0; n < kMostDeltaSources; ++n) records_[n] = records[n];
    spread(affine, weights_[0]);
    spread(even, weights_[1]);
  }
  // Stores the prediction of a row's remainder, and its item. There are at most kPairs * 2 sources.
  template <uint32_t kPairs>
  PSPLIT_INLINE void describe(uint32_t row, bool is_even, DeltaValues& predicted, DeltaItem& item) const {
    const __m128i* const weights = weights_[is_even];
    __m128i sums = _mm_set1_epi32(kDeltaOne / 2), sizes = _mm_setzero_si128();
    PSPLIT_UNROLL
    for (uint32_t n = 0; n < kPairs; ++n) {
      const __m128i a = _mm_load_si128(reinterpret_cast<const __m128i*>(records_[2 * n] + row)),
                    b = _mm_load_si128(reinterpret_cast<const __m128i*>(records_[2 * n + 1] + row));
      // Of two sources, the products of the same component are side by side, and are added.
      sums = _mm_add_epi32(sums, _mm_madd_epi16(_mm_unpacklo_epi16(a, b), weights[n]));
      sizes = _mm_add_epi16(sizes, _mm_add_epi16(a, b));
    }
    _mm_store_si128(reinterpret_cast<__m128i*>(&predicted), _mm_srai_epi32(sums, kDeltaBits));
    const __m128i means = _mm_mulhi_epu16(_mm_sll_epi16(_mm_unpackhi_epi64(sizes, sizes), shift_), per_source_);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(&item), means);
    item.row = static_cast<uint16_t>(row);
  }

 private:
  // A sum of sizes times 4, or 8 for one source, times this is the mean in quarters in the upper 16 bits. That
  // is exact, because sums are below 8 * 256.
  static uint32_t mean_factor(uint32_t count) {
    constexpr uint32_t kUnit = 1u << 16;
    return count == 1 ? kUnit / 2 : count > 1 ? (kUnit + count - 1) / count : 0;
  }
  static void spread(const DeltaWeights& weights, __m128i (&pairs)[kMostPairs]) {
    const __m128i all = _mm_load_si128(reinterpret_cast<const __m128i*>(&weights));
    pairs[0] = _mm_shuffle_epi32(all, 0x00), pairs[1] = _mm_shuffle_epi32(all, 0x55);
    pairs[2] = _mm_shuffle_epi32(all, 0xaa), pairs[3] = _mm_shuffle_epi32(all, 0xff);
  }

  const DeltaRecord* records_[kMostDeltaSources];
  __m128i weights_[2][kMostPairs];  // by is_even
  const __m128i shift_, per_source_;
};
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
PSPLIT_HD inline DeltaBlock scaled(DeltaBlock block, int32_t factor) { return block.times(factor); }
class DeltaNeighbourhood {
 public:
  static constexpr uint32_t kMostPairs = 1;  // it is not unrolled

  PSPLIT_HD DeltaNeighbourhood(const DeltaRecord* const (&records)[kMostDeltaSources],
                               const DeltaWeights& affine, const DeltaWeights& even, uint32_t count)
      : records_(records), affine_(affine), even_(even), count_(count) {}
  template <uint32_t>
  PSPLIT_HD PSPLIT_INLINE void describe(uint32_t row, bool is_even, DeltaValues& predicted,
                                        DeltaItem& item) const {
    const DeltaWeights& weights = is_even ? even_ : affine_;
    for (uint32_t k = 0; k < kDeltaComponents; ++k) {
      int32_t sum = kDeltaOne / 2;
      uint32_t size = 0;
      for (uint32_t n = 0; n < count_; ++n) {
        sum += weights.of[n] * records_[n][row].remainders[k];
        size += records_[n][row].sizes[k];
      }
      predicted.of[k] = sum >> kDeltaBits;
      item.means[k] = static_cast<uint16_t>(count_ > 0 ? 4 * size / count_ : 0);
    }
    predicted.of[3] = 0;
    item.row = static_cast<uint16_t>(row);
  }

 private:
  const DeltaRecord* const (&records_)[kMostDeltaSources];
  const DeltaWeights &affine_, &even_;
  const uint32_t count_;
};
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
static_assert(level_of_mean(kNoMeanSize) == DeltaTables::kLevels - 1);
struct DeltaLevels {
  constexpr DeltaLevels() {
    for (uint32_t mean = 0; mean <= kNoMeanSize; ++mean)
      of_mean[mean] = static_cast<uint8_t>(level_of_mean(mean));
  }
  uint8_t of_mean[kNoMeanSize + 1] = {};
};
inline constexpr DeltaLevels kDeltaLevels;

PSPLIT_HD PSPLIT_INLINE uint8_t delta_level(uint32_t mean) {
#if PSPLIT_MOVES_ROWS
  return static_cast<uint8_t>(level_of_mean(mean));
#else
  return kDeltaLevels.of_mean[mean];
#endif
}

// Codes the deltas of vertex after vertex. A coder reads them, or writes them:
//
//   flags(sure, expected, mixed)   returns the flags of 32 rows. Flags in `sure` equal the bits of `expected`,
//                                  unless a run ends there; flags in `mixed` are coded as bits
//   begin_corrections(items, out)  is told the deltas of a vertex that are not 0, and may store corrections
//   correction(item, stored, expected)  returns the error of `expected` for each of these deltas
//
// The memory has no meaning before. Arrays are by place in the order of creation, then by row.
template <typename Index>
class DeltaCoding {
 public:
  PSPLIT_HD static size_t bytes(uint64_t vertices, uint64_t rows) {
    return Arena::bytes<DeltaSources<Index>>(vertices) + Arena::bytes<uint32_t>(vertices * words(rows)) +
           Arena::bytes<Words>((1 + rows) * quads(rows)) + Arena::bytes<DeltaRecord>((vertices + 1) * rows) +
           Arena::bytes<DeltaValues>(rows + 1) + Arena::bytes<DeltaValues>(rows) +
           Arena::bytes<DeltaItem>(rows) + 2 * Arena::bytes<Words>(0);
  }
  PSPLIT_HD bool allocate(uint32_t vertex_count, View<DeltaRow> rows, Arena& arena) {
    rows_ = rows;
    for (uint32_t count = 0; count <= kMostDeltaSources; ++count) even_[count] = even_delta_weights(count);
    const uint64_t vertices = vertex_count, row_count = rows.size(), word_count = words(row_count),
                   quad_count = quads(row_count);
    if (!arena.take(sources_, vertices) || !arena.take(flags_, vertices * word_count) ||
        !arena.take(records_, (vertices + 1) * row_count) || !arena.take(deltas_, row_count + 1) ||
        !arena.take(corrections_, row_count) || !arena.take(items_, row_count) ||
        !arena.take(referrers_, row_count * quad_count) || !arena.take(pending_, quad_count))
      return false;
    if (!flags_.empty()) set_bytes(flags_.data(), 0, word_count * sizeof(uint32_t));  // read without a meaning
    set_bytes(&records_[vertices * row_count], 0, row_count * sizeof(DeltaRecord));
    set_bytes(referrers_.data(), 0, referrers_.size() * sizeof(Words));
    for (uint32_t r = 0; r < row_count; ++r) {
      const bool refers = rows[r].reference != DeltaRow::kNone;
      if (refers) referrers_[rows[r].reference * quad_count + r / 128].of[r / 32 % 4] |= 1u << r % 32;
      rows[r].referred = &deltas_[refers ? rows[r].reference : row_count];
    }
    return true;
  }
  PSPLIT_HD View<DeltaSources<Index>> sources() const { return sources_; }

  // Codes the vertex at place `i`. Its sources are set, and all vertices before it are coded. Calls
  // put(row, delta) for each delta that is not 0.
  template <typename Coder, typename Put>
  PSPLIT_HD void code(uint32_t i, Coder& coder, Put put) const {
    const auto row_count = static_cast<uint32_t>(rows_.size());
    const View<const uint32_t> flags = code_flags(i, sources_[i], coder);
    DeltaRecord* const records = records_.data() + size_t{i} * row_count;
    set_bytes(records, 0, row_count * sizeof *records);
    set_bytes(deltas_.data(), 0, deltas_.size() * sizeof(DeltaValues));
    const uint32_t count = list_items(sources_[i], flags);
    const View<const DeltaItem> items{items_.data(), count};
    coder.begin_corrections(items, corrections_);
    const DeltaRow* const rows = rows_.data();
    DeltaValues* const deltas = deltas_.data();
    const DeltaValues* given = corrections_.data();
    for (const DeltaItem *at = items.data(), *end = at + count; at != end; ++at, ++given) {
      const DeltaItem& item = *at;
      const DeltaRow& row = rows[item.row];
      const DeltaBlock predicted(deltas[item.row].of),
          part = part_of(row), correction = coder.correction(item, *given, predicted + part),
          remainder = predicted + correction, delta = remainder + part;
      records[item.row] = delta_record(remainder, correction);
      delta.store(deltas[item.row].of);
      put(row, delta);
    }
    code_zeros(flags, count, records);
  }

 private:
  // Bits of rows: four words at a time, where all of them are needed.
  struct alignas(16) Words {
    uint32_t of[4];
  };
  PSPLIT_HD static constexpr uint64_t words(uint64_t rows) { return (rows + 31) / 32; }
  PSPLIT_HD static constexpr uint64_t quads(uint64_t rows) { return (rows + 127) / 128; }
  // The multiple of the reference's delta that a row resembles.
  PSPLIT_HD PSPLIT_INLINE static DeltaBlock part_of(const DeltaRow& row) {
    return (scaled(DeltaBlock(row.referred->of), row.factor) + DeltaBlock(kDeltaOne / 2)).shifted(kDeltaBits);
  }

  template <typename Coder>
  PSPLIT_HD View<const uint32_t> code_flags(uint32_t i, const DeltaSources<Index>& sources,
                                            Coder& coder) const {
    const auto count = static_cast<uint32_t>(words(rows_.size()));
    uint32_t* const flags = flags_.data() + size_t{i} * count;
    // The number of neighbours is unpredictable: each other source is replaced by one of them.
    const bool has_neighbours = sources.neighbours != 0;
    const uint32_t one = sources.place[has_neighbours ? trailing_zeros(sources.neighbours) : 0];
    const uint32_t* neighbours[kMostDeltaSources];
    for (uint32_t n = 0; n < kMostDeltaSources; ++n)
      neighbours[n] =
          flags_.data() + size_t{select(0u - (sources.neighbours >> n & 1u), sources.place[n], one)} * count;
    for (uint32_t word = 0; word < count; ++word) {
      uint32_t all = mask(has_neighbours), some = 0;
      for (uint32_t n = 0; n < kMostDeltaSources; ++n) all &= neighbours[n][word], some |= neighbours[n][word];
      some &= mask(has_neighbours);
      const uint32_t rows = static_cast<uint32_t>(rows_.size()) - 32 * word;
      const uint32_t valid = rows >= 32 ? ~0u : (1u << rows) - 1, mixed = some & ~all & valid;
      flags[word] = coder.flags(valid & ~mixed, all & valid & ~mixed, mixed);
    }
    return {flags, count};
  }

  // Lists the rows that are not 0, with the predictions of their remainders. Returns their number.
  PSPLIT_HD uint32_t list_items(const DeltaSources<Index>& sources, View<const uint32_t> flags) const {
    const size_t row_count = rows_.size();
    const DeltaRecord* records_of[kMostDeltaSources];
    for (uint32_t n = 0; n < kMostDeltaSources; ++n)
      records_of[n] =
          n < sources.count ? &records_[sources.place[n] * row_count] : &records_[records_.size() - row_count];
    const DeltaNeighbourhood around(records_of, sources.weights, even_[sources.count], sources.count);
    if constexpr (DeltaNeighbourhood::kMostPairs == 4) {
      if (sources.count > 6) return list_items<4>(around, flags);
      if (sources.count > 4) return list_items<3>(around, flags);
      if (sources.count > 2) return list_items<2>(around, flags);
    }
    const uint32_t count = list_items<1>(around, flags);
    if (PSPLIT_UNLIKELY(sources.count == 0))
      for (uint32_t n = 0; n < count; ++n)
        for (uint16_t& mean : items_[n].means) mean = kNoMeanSize;
    return count;
  }
  template <uint32_t kPairs>
  PSPLIT_HD uint32_t list_items(const DeltaNeighbourhood& around, View<const uint32_t> flags) const {
    const DeltaRow* const rows = rows_.data();
    DeltaItem* item = items_.data();
    DeltaValues* const predicted = deltas_.data();
    for (uint32_t word = 0; word < flags.size(); ++word)
      for (uint32_t left = flags[word]; left != 0; left &= left - 1) {
        const uint32_t row = 32 * word + trailing_zeros(left);
        around.describe<kPairs>(row, rows[row].is_even, predicted[row], *item++);
      }
    return static_cast<uint32_t>(item - items_.data());
  }

  // A delta of 0 has a remainder too, if that of its reference is not 0.
  PSPLIT_HD void code_zeros(View<const uint32_t> flags, uint32_t item_count, DeltaRecord* records) const {
    const size_t quad_count = pending_.size();
    for (size_t quad = 0; quad < quad_count; ++quad) {
      const DeltaItem* const items = items_.data();
      const Words* const referrers = referrers_.data() + quad;
      Words all = {};
      for (uint32_t n = 0; n < item_count; ++n)
        for (uint32_t k = 0; k < 4; ++k) all.of[k] |= referrers[items[n].row * quad_count].of[k];
      pending_[quad] = all;
    }
    for (uint32_t word = 0; word < flags.size(); ++word)
      for (uint32_t left = pending_[word / 4].of[word % 4] & ~flags[word]; left != 0; left &= left - 1) {
        const uint32_t r = 32 * word + trailing_zeros(left);
        const DeltaRow& row = rows_[r];
        records[r] = delta_record(DeltaBlock(0) - part_of(row), DeltaBlock(0));
      }
  }

  View<DeltaRow> rows_;
  View<DeltaSources<Index>> sources_;
  View<uint32_t> flags_;       // bits, by word
  View<DeltaRecord> records_;  // the vertices' records, then zeros
  // The deltas of the vertex that is being coded by row, then a 0; their corrections; and the list of the
  // deltas that are not 0. A delta is at first the prediction of its remainder.
  View<DeltaValues> deltas_, corrections_;
  View<DeltaItem> items_;
  View<Words> referrers_;                     // by row: bits of the rows that have the row as their reference
  View<Words> pending_;                       // of the vertex being coded: the referrers of rows that are not 0
  DeltaWeights even_[kMostDeltaSources + 1];  // by number of sources
};

// Reads flags and corrections from the sections of a stream.
class DeltaReader {
 public:
  // `sections` are started, and all tables exist.
  PSPLIT_HD DeltaReader(const SectionReader (&sections)[kDeltaSections], const CondensedModels& models)
      : flags_(sections[0]), some_(models.delta_tables.some) {
    for (uint32_t k = 0; k < kDeltaComponents; ++k) sections_[k] = sections[1 + k];
    runs_ = &models.token_tables[models.delta_tables.runs];
    for (uint32_t level = 0; level < DeltaTables::kLevels; ++level)
      tables_[level] = &models.token_tables[models.delta_tables.of_level[level]];
    run_ = next_run();
  }

  PSPLIT_HD uint32_t flags(uint32_t sure, uint32_t expected, uint32_t mixed) {
    uint32_t flags = expected;
    uint32_t count = bit_count(sure);
    while (PSPLIT_UNLIKELY(run_ < count)) {
      for (; run_ > 0; --run_, --count) sure &= sure - 1;
      flags ^= sure & (0u - sure);
      sure &= sure - 1;
      --count;
      run_ = next_run();
    }
    run_ -= count;
    // Whether a flag is 1 is unpredictable.
    SectionReader section = flags_;  // stays in registers
    for (; mixed != 0; mixed &= mixed - 1) flags |= mixed & (0u - mixed) & (0u - section.next_bit(some_));
    flags_ = section;
    return flags;
  }
  // Corrections are read before they are used: their states then stay in registers.
  PSPLIT_HD void begin_corrections(View<const DeltaItem> items, View<DeltaValues> out) {
    const auto count = static_cast<uint32_t>(items.size());
    bool is_far = !PSPLIT_IS_SMALL_CODE;
    for (const SectionReader& section : sections_) is_far &= section.has_words(count);
    if (is_far)
      read_corrections<!PSPLIT_IS_SMALL_CODE>(items, out.data());
    else
      read_corrections<false>(items, out.data());
  }
  PSPLIT_HD PSPLIT_INLINE static DeltaBlock correction(const DeltaItem&, const DeltaValues& read, DeltaBlock) {
    return DeltaBlock(read.of);
  }
  // Whether all sections are read to their ends, when all vertices are coded.
  PSPLIT_HD bool is_at_end() const {
    bool is_at_end = flags_.is_at_end();
    for (const SectionReader& section : sections_) is_at_end &= section.is_at_end();
    return is_at_end;
  }

 private:
  // kIsFar: the sections have at least a word for each of the corrections.
  template <bool kIsFar>
  PSPLIT_HD void read_corrections(View<const DeltaItem> items, DeltaValues* out) {
    SectionReader words[kDeltaComponents] = {sections_[0], sections_[1], sections_[2]};
    const auto next_token = [&](uint32_t k, const DeltaItem& item) {
      return words[k].template next_token<kIsFar>(*tables_[delta_level(item.means[k])]);
    };
    for (const DeltaItem *at = items.data(), *end = at + items.size(); at != end; ++at, ++out) {
      uint32_t x = next_token(0, *at), y = next_token(1, *at), z = next_token(2, *at);
      if (PSPLIT_UNLIKELY((x | y | z) >= kDirectTokens)) {
        x = symbol_of_token(sections_[0], x);
        y = symbol_of_token(sections_[1], y);
        z = symbol_of_token(sections_[2], z);
      }
      DeltaBlock(x, y, z, 0).signed_of_symbols().store(out->of);
    }
    for (uint32_t k = 0; k < kDeltaComponents; ++k) sections_[k].go_to_words_of(words[k]);
  }
  PSPLIT_HD uint32_t next_run() { return symbol_of_token(flags_, flags_.next_token(*runs_)); }

  SectionReader flags_, sections_[kDeltaComponents];
  uint32_t some_, run_ = 0;  // run: the sure flags before the next one that is not as expected
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
    return coding_.allocate(vertex_count, rows_, arena) ? Fault::kNone : Fault::kWorkspace;
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
                         [=](uint32_t v) { DeltaBlock(zero.of).store(values + size_t{4} * v); });
    }
    if (rows_.empty()) {
      lanes.sync();
      return Fault::kNone;
    }
    const DeltaSourceSearch<Index> search(table.table, order, places);
    constexpr uint32_t kAtOnce = DeltaSourceSearch<Index>::kAtOnce;
    for_each_lane_item(lanes, (vertex_count + kAtOnce - 1) / kAtOnce, [&](uint32_t block) {
      const uint32_t first = kAtOnce * block, left = vertex_count - first;
      search.find(first, left < kAtOnce ? left : kAtOnce, coding_.sources().data() + first);
    });
    lanes.sync();
    return alone(lanes, [&] {
      DeltaReader reader(sections_, stream.models);
      for (uint32_t i = 0; i < vertex_count; ++i) {
        const size_t at = size_t{4} * table.table.vertex[order.corner[i]];
        coding_.code(i, reader, [at](const DeltaRow& row, DeltaBlock delta) {
          (delta + DeltaBlock(row.zero.of)).store(row.values + at);
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
           DeltaCoding<Index>::bytes(vertices, stream.delta_row_count) +
           count * Arena::bytes<int32_t>(uint64_t{vertices} * value_stride(kDeltaComponents));
  }

 private:
  uint32_t count_ = 0;     // of attributes
  View<uint16_t> row_of_;  // by attribute of deltas; kNoReference if all of its deltas are 0
  View<DeltaRow> rows_;
  uint32_t section_bytes_[kDeltaSections] = {};
  SectionReader sections_[kDeltaSections];
  DeltaCoding<Index> coding_;
};

}  // namespace psplit::core
