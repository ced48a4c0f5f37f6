#include "encoder/condensing/condense.h"

#include <algorithm>

#include "encoder/condensing/choose_models.h"
#include "encoder/condensing/code_deltas.h"
#include "encoder/condensing/coded_patch.h"
#include "encoder/condensing/table_sets.h"
#include "encoder/fields/expand.h"
#include "src/container/condensed_head.h"
#include "src/container/patch_boxes.h"

namespace psplit {
namespace {

// One pass over the streams of a primitive after the other. Sums are made of parts that do not depend on the
// number of threads.
class Condenser {
 public:
  Condenser(const PatchContainer& draco, bool smallest, const ThreadPool& pool)
      : draco_(draco), smallest_(smallest), pool_(pool), patches_(draco.entries.size()) {
    result_.entries = draco.entries;
    result_.bytes.resize(draco.entries.size());
  }

  CondensedStreams condense() {
    read_streams();
    share_skeletons();
    if (models_.skeletons.empty()) return std::move(result_);
    find_deltas();
    CodingCounts counts = count_codings();
    bool with_borders = true;
    for (;;) {
      const Codings codings = counts.choose(scale_, smallest_, with_borders, !models_.deltas.empty());
      const Outcome outcome = code(codings);
      if (outcome == Outcome::kDone) return std::move(result_);
      // Something cannot be stored as chosen, or not so well. The fields of the streams are used up.
      read_streams();
      if (outcome == Outcome::kWithoutBorders) with_borders = false;
      if (outcome == Outcome::kWithoutDeltas) {
        models_.deltas.clear();
        counts = count_codings();
      }
    }
  }

 private:
  struct Patch {
    bool is_condensable = false;
    uint32_t skeleton = 0;
    CodedPatch coded;
  };
  // What the coded patches of one part count.
  struct Counts {
    explicit Counts(size_t context_count, size_t attribute_count, size_t data_count)
        : symbols(context_count), flags(attribute_count), seams(data_count) {}
    SymbolCounts symbols;
    std::vector<FlagCounts> flags;
    std::vector<SeamCounts> seams;
    std::array<TokenCounts, 2> borders{};
    DeltaCounts deltas;
  };
  // How coding ended: the next try is without what did not help.
  enum class Outcome { kDone, kWithoutBorders, kWithoutDeltas };

  bool may_have_borders() const {
    const auto may_have = [&](const Patch& patch) {
      if (!patch.is_condensable) return false;
      const AttributeFields& first = patch.coded.fields.attributes[0];
      return first.skeleton.allows_creation_order() &&
             first.components == patches_[0].coded.fields.attributes[0].components;
    };
    return std::ranges::any_of(draco_.stitch, [](std::span<const uint8_t> map) { return !map.empty(); }) &&
           std::ranges::all_of(std::span(patches_).first(draco_.patch_count()), may_have);
  }
  BorderPart border_part(size_t i, const DecodedSource& source) const {
    const uint32_t components = patches_[i].coded.fields.attributes[0].components;
    return make_border_part(source, draco_, static_cast<uint32_t>(i), components);
  }
  bool borders_agree() const {
    std::vector<BorderPart> parts;
    for (const Patch& patch : patches_) parts.push_back(patch.coded.border);
    std::vector<uint8_t> agree(patches_.size(), 1);
    pool_.for_each(patches_.size(), [&](size_t i) {
      if (!patches_[i].is_condensable) return;
      const uint32_t components = patches_[i].coded.fields.attributes[0].components;
      agree[i] = parts[i].agrees(draco_, static_cast<uint32_t>(i), components, parts);
    });
    return std::ranges::find(agree, 0) == agree.end();
  }

  // Codes all streams, and stores each condensed one in the result. Values at borders are stored once for all
  // patches, or not at all.
  Outcome code(const Codings& codings) {
    if (!code_patches(codings)) return Outcome::kWithoutDeltas;
    return (!codings.has_borders || borders_agree()) && write_patches() ? Outcome::kDone
                                                                        : Outcome::kWithoutBorders;
  }

  void read_streams() {
    pool_.for_each(patches_.size(), [&](size_t i) {
      std::optional<DracoFields> fields = condensable_fields(draco_.streams[i], draco_.entries[i].face_count);
      if (!fields) return;
      patches_[i].is_condensable = true;
      patches_[i].coded = {};
      patches_[i].coded.fields = std::move(*fields);
      patches_[i].coded.point_count = draco_.entries[i].point_count;
    });
  }

  // Streams with the same literal bytes share a skeleton, if they have a level in common.
  void share_skeletons() {
    std::vector<uint32_t> levels;  // possible ones, by skeleton
    for (Patch& patch : patches_) {
      if (!patch.is_condensable) continue;
      DracoFields& fields = patch.coded.fields;
      uint32_t s = 0;
      while (s < levels.size() &&
             (models_.skeletons[s].literals != fields.skeleton || (levels[s] & fields.possible_levels) == 0))
        ++s;
      if (s == kMostSkeletons) {
        patch.is_condensable = false;
        continue;
      }
      if (s == levels.size()) {
        models_.skeletons.push_back({fields.skeleton, 0});
        levels.push_back(fields.possible_levels);
      }
      patch.skeleton = s;
      levels[s] &= fields.possible_levels;
      attribute_count_ = std::max(attribute_count_, fields.attributes.size());
      data_count_ = std::max(data_count_, fields.seams.size());
    }
    for (size_t s = 0; s < levels.size(); ++s) models_.skeletons[s].symbol_level = std::countr_zero(levels[s]);
  }

  // Finds the attributes that may be coded as deltas: in all streams that have them, and these are alike in all
  // streams with one skeleton.
  void find_deltas() {
    std::vector<uint8_t> is_seen(models_.skeletons.size());
    std::vector<std::vector<core::DeltaModel>> of_skeletons;
    std::vector<size_t> attribute_counts;
    for (size_t i = 0; i < patches_.size(); ++i) {
      const Patch& patch = patches_[i];
      if (!patch.is_condensable || std::exchange(is_seen[patch.skeleton], 1) != 0) continue;
      const std::unique_ptr<DecodedSource> source = decode(i);
      of_skeletons.push_back(source != nullptr ? possible_deltas(*source, patch.coded.fields)
                                               : std::vector<core::DeltaModel>());
      attribute_counts.push_back(patch.coded.fields.attributes.size());
    }
    for (uint32_t a = 1; a < attribute_count_; ++a) {
      const core::DeltaModel* found = nullptr;
      bool is_everywhere = true;
      for (size_t s = 0; s < of_skeletons.size(); ++s) {
        if (a >= attribute_counts[s]) continue;
        const auto at = std::ranges::find(of_skeletons[s], a, &core::DeltaModel::attribute);
        is_everywhere &= at != of_skeletons[s].end();
        if (is_everywhere) found = &*at;
      }
      if (is_everywhere && found != nullptr) models_.deltas.push_back(*found);
    }
  }
  bool is_delta(size_t attribute) const {
    return std::ranges::find(models_.deltas, attribute, &core::DeltaModel::attribute) != models_.deltas.end();
  }
  // The models of a stream's deltas.
  std::span<const core::DeltaModel> deltas_of(const Patch& patch) const {
    const size_t attributes = patch.coded.fields.attributes.size();
    const auto is_in = [&](const core::DeltaModel& model) { return model.attribute < attributes; };
    return std::span(models_.deltas).first(static_cast<size_t>(std::ranges::count_if(models_.deltas, is_in)));
  }

  // Calls body(part, i) for each stream i in some order, where streams of the same part follow each other.
  template <typename Body>
  void for_parts(size_t count, Body body) const {
    pool_.for_each(kParts, [&](size_t part) {
      for (size_t i = part * count / kParts; i < (part + 1) * count / kParts; ++i) body(part, i);
    });
  }

  std::unique_ptr<DecodedSource> decode(size_t i) const {
    const DracoFields& fields = patches_[i].coded.fields;
    const bool is_needed = std::ranges::any_of(fields.attributes, [](const AttributeFields& attribute) {
      return attribute.skeleton.allows_creation_order();
    });
    return is_needed ? DecodedSource::decode(draco_.streams[i], draco_.entries[i].point_count, fields)
                     : nullptr;
  }

  // The counts of a sample of the streams. Sets scale_, and how deltas are coded.
  CodingCounts count_codings() {
    const bool with_borders = may_have_borders();
    std::vector<size_t> condensable;
    uint64_t faces = 0;
    for (size_t i = 0; i < patches_.size(); ++i)
      if (patches_[i].is_condensable) condensable.push_back(i), faces += draco_.entries[i].face_count;
    const size_t every = std::min<size_t>(1 + faces / kSampleFaces, condensable.size());
    std::vector<CodingCounts> parts(kParts, CodingCounts(attribute_count_, models_.deltas));
    uint64_t sample_faces = 0;
    for (size_t n = 0; n < condensable.size(); n += every)
      sample_faces += draco_.entries[condensable[n]].face_count;
    std::vector<DeltaSample> delta_parts(kParts);
    const auto delta_every = static_cast<uint32_t>(1 + sample_faces / kSampleDeltaFaces);
    for_parts((condensable.size() + every - 1) / every, [&](size_t part, size_t n) {
      const size_t i = condensable[n * every];
      const std::unique_ptr<DecodedSource> source = decode(i);
      // A stream with fewer of them says nothing about the others.
      if (source != nullptr && !models_.deltas.empty() &&
          deltas_of(patches_[i]).size() == models_.deltas.size())
        delta_parts[part].add(*source, models_.deltas,
                              patches_[i].coded.fields.attributes[0].skeleton.allows_creation_order(),
                              delta_every);
      const bool has_border = with_borders && source != nullptr;
      const BorderPart border = has_border ? border_part(i, *source) : BorderPart();
      parts[part].add(patches_[i].coded.fields, source.get(), has_border ? &border : nullptr);
    });
    for (size_t part = 1; part < kParts; ++part) parts[0] += parts[part];
    for (size_t part = 1; part < kParts; ++part) delta_parts[0].append(std::move(delta_parts[part]));
    delta_parts[0].choose(models_.deltas, pool_);
    scale_ = static_cast<double>(faces) / static_cast<double>(std::max<uint64_t>(sample_faces, 1));
    return std::move(parts[0]);
  }

  // False if deltas take more bytes than other values would.
  bool code_patches(const Codings& codings) {
    models_.has_borders = codings.has_borders;
    models_.symbol_contexts = codings.symbol_contexts;
    std::vector<Counts> parts(kParts,
                              Counts(context_count(codings.symbol_contexts), attribute_count_, data_count_));
    for_parts(patches_.size(), [&](size_t part, size_t i) {
      if (!patches_[i].is_condensable) return;
      code_patch(codings, i);
      if (patches_[i].is_condensable) count_patch(patches_[i], parts[part]);
    });
    for (size_t part = 1; part < kParts; ++part) add_counts(parts[part], parts[0]);
    models_.delta_tables = delta_tables(parts[0].deltas);
    if (!models_.deltas.empty()) {
      BitStringWriter head;
      write_deltas(models_, head);
      double others = 0;
      for (const core::DeltaModel& delta : models_.deltas) others += codings.bits[delta.attribute];
      const double sections = 8.0 * 4 * core::kDeltaSections * static_cast<double>(patches_.size());
      if (delta_bits(parts[0].deltas, models_.delta_tables) + static_cast<double>(head.bit_count()) + sections >
          others)
        return false;
    }
    set_tables(codings, parts[0]);
    return true;
  }

  void set_token_tables(size_t a, AttributeTables& model) {
    std::vector<size_t> streams;
    for (size_t i = 0; i < patches_.size(); ++i)
      if (patches_[i].is_condensable && a < patches_[i].coded.attributes.size()) streams.push_back(i);
    std::vector<PatchTokens> tokens(streams.size());
    pool_.for_each(streams.size(), [&](size_t n) {
      const Patch& patch = patches_[streams[n]];
      AttributeCounts counts;
      counts.add(patch.coded.attributes[a], patch.coded.fields.attributes[a].components);
      tokens[n] = patch_tokens(counts);
    });
    const auto most =
        static_cast<uint32_t>(std::min<size_t>(kMostTableSets, kMostTableSetsOfAll / attribute_count_));
    const TableSets sets = choose_table_sets(tokens, most, smallest_, pool_);
    for (const AttributeCounts& set : sets.counts) model.sets.push_back(token_tables(set, model.coding));
    for (size_t n = 0; n < streams.size(); ++n) patches_[streams[n]].coded.attributes[a].set = sets.set[n];
  }

  void code_patch(const Codings& codings, size_t i) {
    Patch& patch = patches_[i];
    DracoFields& fields = patch.coded.fields;
    const std::span<const core::DeltaModel> deltas = deltas_of(patch);
    const auto is_by_creation = [&](uint32_t a) {
      return is_delta(a) ||
             (codings.values[a].by_creation && fields.attributes[a].skeleton.allows_creation_order());
    };
    std::unique_ptr<DecodedSource> source;
    for (uint32_t a = 0; a < fields.attributes.size(); ++a)
      if (is_by_creation(a) && source == nullptr && (source = decode(i)) == nullptr) {
        patch.is_condensable = false;
        return;
      }
    if (codings.has_borders) patch.coded.border = border_part(i, *source);
    patch.coded.contexts = contexts_of_symbols(fields, codings.symbol_contexts);
    if (!deltas.empty()) patch.coded.deltas = code_deltas(*source, deltas, is_by_creation(0));
    for (uint32_t a = 0; a < fields.attributes.size(); ++a) {
      patch.coded.attributes.push_back(
          is_delta(a)         ? CodedValues()
          : is_by_creation(a) ? code_by_creation(*source, a, codings.values[a],
                                                 a == 0 ? std::span<const uint32_t>(patch.coded.border.known)
                                                        : std::span<const uint32_t>())
                              : code_in_draco_order(fields.attributes[a]));
      fields.attributes[a].symbols = {};
      fields.attributes[a].raw = {};
    }
  }

  void count_patch(const Patch& patch, Counts& counts) const {
    const DracoFields& fields = patch.coded.fields;
    add_symbols(fields, patch.coded.contexts, counts.symbols);
    counts.deltas.add(patch.coded.deltas);
    const BorderPart& border = patch.coded.border;
    for (size_t n = 0; n < border.symbols.size(); ++n)
      ++counts.borders[n < fields.attributes[0].components ? 0 : 1][token_of(border.symbols[n]).token];
    for (size_t a = 0; a < fields.attributes.size(); ++a)
      for (uint32_t kind = 0; kind < kFlagKinds; ++kind)
        for (const uint8_t flag : flags_of_kind(fields.attributes[a], kind)) ++counts.flags[a][kind][flag];
    for (size_t data = 0; data < fields.seams.size(); ++data) {
      const std::vector<uint8_t>& seams = fields.seams[data];
      if (!has_seams(seams)) continue;
      uint8_t before = 0;
      for (const uint8_t seam : seams) {
        ++counts.seams[data][before][seam];
        before = seam;
      }
    }
  }

  static void add_counts(const Counts& from, Counts& to) {
    to.symbols += from.symbols;
    to.deltas += from.deltas;
    for (size_t t = 0; t < to.borders.size(); ++t) to.borders[t] += from.borders[t];
    const auto add_bits = [](const auto& bits, auto& sums) {
      for (size_t i = 0; i < bits.size(); ++i)
        for (size_t bit = 0; bit < 2; ++bit) sums[i][bit] += bits[i][bit];
    };
    for (size_t a = 0; a < to.flags.size(); ++a) add_bits(from.flags[a], to.flags[a]);
    for (size_t data = 0; data < to.seams.size(); ++data) add_bits(from.seams[data], to.seams[data]);
  }

  void set_tables(const Codings& codings, const Counts& counts) {
    models_.attributes.clear();
    models_.seam_probability.clear();
    models_.symbol_tables = symbol_tables(counts.symbols);
    for (size_t t = 0; t < counts.borders.size(); ++t)
      models_.border_tables[t] = fitting_frequencies(counts.borders[t]);
    for (size_t a = 0; a < attribute_count_; ++a) {
      AttributeTables& model = models_.attributes.emplace_back();
      model.coding = codings.values[a];
      if (is_delta(a)) {
        model.coding = {.by_creation = true};
        model.sets.emplace_back(TokenTables(core::TableSet::kTables));
        continue;
      }
      set_token_tables(a, model);
      for (uint32_t kind = 0; kind < kFlagKinds; ++kind) {
        const auto [zeros, ones] = counts.flags[a][kind];
        model.has_flags |= zeros + ones > 0;
        model.flag_probability[kind] = fitting_probability(zeros, ones);
      }
    }
    for (const SeamCounts& seams : counts.seams)
      models_.seam_probability.push_back(
          {fitting_probability(seams[0][0], seams[0][1]), fitting_probability(seams[1][0], seams[1][1])});
  }

  // Condenses each stream that gets smaller and comes back, if that saves more than the head takes. Returns
  // what code() returns.
  bool write_patches() {
    std::vector<uint8_t> head_bytes = write_head(models_);
    const Expected<CondensedHead> head = read_condensed_head(head_bytes);
    if (!head) return true;
    const size_t count = patches_.size();
    std::vector<int64_t> saved(count);
    std::vector<std::vector<uint8_t>> condensed(count);
    pool_.for_each(count, [&](size_t i) {
      Patch& patch = patches_[i];
      if (!patch.is_condensable) return;
      const StreamEntry& entry = draco_.entries[i];
      std::vector<uint8_t> bytes = write_patch(patch.coded, *head);
      const std::vector<int32_t> known = std::move(patch.coded.border.values);
      patch.coded = {};
      saved[i] = std::ssize(draco_.streams[i]) - std::ssize(bytes);
      // With borders either all patches are condensed, or none.
      if (saved[i] <= 0 && !models_.has_borders) return;
      const Expected<std::vector<uint8_t>> expanded =
          expand_stream(*head, {bytes, patch.skeleton, entry.face_count, entry.point_count, known});
      if (expanded && std::ranges::equal(*expanded, draco_.streams[i])) condensed[i] = std::move(bytes);
    });
    int64_t all_saved = 0;
    size_t condensed_count = 0;
    for (size_t i = 0; i < count; ++i)
      if (!condensed[i].empty()) all_saved += saved[i], ++condensed_count;
    if (all_saved <= std::ssize(head_bytes)) return true;
    if (models_.has_borders && condensed_count < draco_.patch_count()) return false;
    result_.head = std::move(head_bytes);
    result_.bytes = std::move(condensed);
    for (size_t i = 0; i < count; ++i) {
      if (result_.bytes[i].empty()) continue;
      StreamEntry& entry = result_.entries[i];
      entry.stream_bytes = static_cast<uint32_t>(result_.bytes[i].size());
      entry.is_condensed = true;
      entry.skeleton = static_cast<uint8_t>(patches_[i].skeleton);
    }
    return true;
  }

  static constexpr size_t kParts = 32;
  static constexpr uint64_t kSampleFaces = 1 << 16, kSampleDeltaFaces = 1 << 12;

  const PatchContainer& draco_;
  const bool smallest_;
  const ThreadPool& pool_;
  std::vector<Patch> patches_;
  size_t attribute_count_ = 0, data_count_ = 0;  // of the skeletons that have most
  double scale_ = 1;                             // of the counts of the sample
  Models models_;
  CondensedStreams result_;
};

}  // namespace

CondensedStreams condense(const PatchContainer& draco, bool smallest, const ThreadPool& pool) {
  return Condenser(draco, smallest, pool).condense();
}

std::optional<CondensedContainer> condense_container(const PatchContainer& draco, uint64_t bytes_without,
                                                     bool smallest, const ThreadPool& pool) {
  CondensedStreams condensed = condense(draco, smallest, pool);
  if (condensed.head.empty()) return std::nullopt;
  if (const std::span<const uint8_t> boxes = boxes_section(draco); !boxes.empty())
    append_head_section(HeadSection::kBoxes, boxes, condensed.head);
  std::vector<uint8_t> bytes = write_container(condensed.entries, draco.has_residue, {}, {}, condensed.head);
  uint64_t size = bytes.size() + draco.stitch_bytes();
  for (const StreamEntry& entry : condensed.entries) size += entry.stream_bytes;
  if (size >= bytes_without) return std::nullopt;
  bytes.reserve(static_cast<size_t>(size));
  const auto append = [&](std::span<const uint8_t> piece) {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  };
  for (const std::span<const uint8_t> map : draco.stitch) append(map);
  for (size_t i = 0; i < draco.streams.size(); ++i)
    append(condensed.entries[i].is_condensed ? condensed.bytes[i] : draco.streams[i]);
  return CondensedContainer{std::move(bytes), std::move(condensed.entries),
                            static_cast<uint32_t>(condensed.head.size())};
}

}  // namespace psplit
