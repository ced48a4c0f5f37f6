#include "encoder/condensing/condense.h"

#include <algorithm>
#include <numeric>

#include "encoder/condensing/choose_models.h"
#include "encoder/condensing/table_sets.h"
#include "encoder/condensing/write_patch.h"
#include "src/condensed/expand.h"

namespace psplit {
namespace {

// One pass over the streams of a primitive after the other. Sums are made of parts that do not depend on the
// number of threads.
class Condenser {
 public:
  Condenser(std::span<const std::vector<uint8_t>> streams, std::span<const DecodedCounts> counts, bool smallest,
            const ThreadPool& pool)
      : streams_(streams), counts_(counts), smallest_(smallest), pool_(pool), patches_(streams.size()) {
    result_.bytes.assign(streams.begin(), streams.end());
    result_.is_condensed.resize(streams.size());
    result_.skeleton.resize(streams.size());
  }

  // Nothing if values at borders were to be stored once, and that was not possible for all patches.
  std::optional<CondensedStreams> condense(bool with_borders) {
    read_streams();
    share_skeletons();
    if (models_.skeletons.empty()) return std::move(result_);
    const Codings codings = choose_codings(with_borders && may_have_borders());
    code_patches(codings);
    if (codings.has_borders && !borders_agree()) return std::nullopt;
    write_patches();
    if (codings.has_borders && !result_.head.empty() && condensed_count() < patch_count()) return std::nullopt;
    return std::move(result_);
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
  };

  // All streams are patches, except that the last one may be a sequential residue.
  size_t patch_count() const {
    core::StreamHeader header;
    const bool has_residue = core::read_stream_header(streams_.back().data(), streams_.back().size(), header) ==
                                 core::Fault::kNone &&
                             !header.edgebreaker;
    return streams_.size() - (has_residue ? 1 : 0);
  }
  size_t condensed_count() const { return static_cast<size_t>(std::ranges::count(result_.is_condensed, 1)); }
  bool may_have_borders() const {
    const auto has_stitch = [](const DecodedCounts& counts) { return !counts.stitch.empty(); };
    const auto is_condensable = [](const Patch& patch) { return patch.is_condensable; };
    return std::ranges::any_of(counts_, has_stitch) &&
           static_cast<size_t>(std::ranges::count_if(patches_, is_condensable)) == patch_count() &&
           std::ranges::all_of(std::span(patches_).first(patch_count()), [&](const Patch& patch) {
             const AttributeFields& first = patch.coded.fields.attributes[0];
             return first.skeleton.allows_creation_order() &&
                    first.components == patches_[0].coded.fields.attributes[0].components;
           });
  }
  BorderPart border_part(size_t i, const DecodedSource& source) const {
    const uint32_t components = patches_[i].coded.fields.attributes[0].components;
    return make_border_part(source, counts_[i], static_cast<uint32_t>(i), components);
  }
  bool borders_agree() const {
    std::vector<BorderPart> parts;
    for (const Patch& patch : patches_) parts.push_back(patch.coded.border);
    std::vector<uint8_t> agree(patches_.size(), 1);
    pool_.for_each(patches_.size(), [&](size_t i) {
      if (!patches_[i].is_condensable) return;
      const uint32_t components = patches_[i].coded.fields.attributes[0].components;
      agree[i] = parts[i].agrees(counts_[i], static_cast<uint32_t>(i), components, parts);
    });
    return std::ranges::find(agree, 0) == agree.end();
  }

  void read_streams() {
    pool_.for_each(streams_.size(), [&](size_t i) {
      std::optional<DracoFields> fields = condensable_fields(streams_[i], counts_[i]);
      if (!fields) return;
      patches_[i].is_condensable = true;
      patches_[i].coded.fields = std::move(*fields);
      patches_[i].coded.point_count = counts_[i].point_count;
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
    return is_needed ? DecodedSource::decode(streams_[i], counts_[i].point_count, fields) : nullptr;
  }

  Codings choose_codings(bool with_borders) const {
    std::vector<size_t> condensable;
    uint64_t faces = 0;
    for (size_t i = 0; i < patches_.size(); ++i)
      if (patches_[i].is_condensable) condensable.push_back(i), faces += counts_[i].face_count;
    const size_t every = std::min<size_t>(1 + faces / kSampleFaces, condensable.size());
    std::vector<CodingCounts> parts(kParts, CodingCounts(attribute_count_));
    uint64_t sample_faces = 0;
    for (size_t n = 0; n < condensable.size(); n += every) sample_faces += counts_[condensable[n]].face_count;
    for_parts((condensable.size() + every - 1) / every, [&](size_t part, size_t n) {
      const size_t i = condensable[n * every];
      const std::unique_ptr<DecodedSource> source = decode(i);
      const bool has_border = with_borders && source != nullptr;
      const BorderPart border = has_border ? border_part(i, *source) : BorderPart();
      parts[part].add(patches_[i].coded.fields, source.get(), has_border ? &border : nullptr);
    });
    for (size_t part = 1; part < kParts; ++part) parts[0] += parts[part];
    const double scale = static_cast<double>(faces) / static_cast<double>(std::max<uint64_t>(sample_faces, 1));
    return parts[0].choose(scale, smallest_);
  }

  void code_patches(const Codings& codings) {
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
    set_tables(codings, parts[0]);
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
    const auto is_by_creation = [&](uint32_t a) {
      return codings.values[a].by_creation && fields.attributes[a].skeleton.allows_creation_order();
    };
    std::unique_ptr<DecodedSource> source;
    for (uint32_t a = 0; a < fields.attributes.size(); ++a)
      if (is_by_creation(a) && source == nullptr && (source = decode(i)) == nullptr) {
        patch.is_condensable = false;
        return;
      }
    if (codings.has_borders) patch.coded.border = border_part(i, *source);
    patch.coded.contexts = contexts_of_symbols(fields, codings.symbol_contexts);
    for (uint32_t a = 0; a < fields.attributes.size(); ++a) {
      patch.coded.attributes.push_back(
          is_by_creation(a) ? code_by_creation(*source, a, codings.values[a],
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
    for (size_t t = 0; t < to.borders.size(); ++t) to.borders[t] += from.borders[t];
    const auto add_bits = [](const auto& bits, auto& sums) {
      for (size_t i = 0; i < bits.size(); ++i)
        for (size_t bit = 0; bit < 2; ++bit) sums[i][bit] += bits[i][bit];
    };
    for (size_t a = 0; a < to.flags.size(); ++a) add_bits(from.flags[a], to.flags[a]);
    for (size_t data = 0; data < to.seams.size(); ++data) add_bits(from.seams[data], to.seams[data]);
  }

  void set_tables(const Codings& codings, const Counts& counts) {
    models_.symbol_tables = symbol_tables(counts.symbols);
    for (size_t t = 0; t < counts.borders.size(); ++t)
      models_.border_tables[t] = fitting_frequencies(counts.borders[t]);
    for (size_t a = 0; a < attribute_count_; ++a) {
      AttributeTables& model = models_.attributes.emplace_back();
      model.coding = codings.values[a];
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

  // Condenses each stream that gets smaller and comes back, if that saves more than the head takes.
  void write_patches() {
    std::vector<uint8_t> head_bytes = write_head(models_);
    const Expected<CondensedHead> head = read_condensed_head(head_bytes);
    if (!head) return;
    const CodingTables tables(models_);
    std::vector<int64_t> saved(streams_.size());
    std::vector<std::vector<uint8_t>> condensed(streams_.size());
    std::vector<uint8_t> is_condensed(streams_.size());
    pool_.for_each(streams_.size(), [&](size_t i) {
      Patch& patch = patches_[i];
      if (!patch.is_condensable) return;
      condensed[i] = write_patch(patch.coded, models_, tables);
      const std::vector<int32_t> known = std::move(patch.coded.border.values);
      patch.coded = {};
      const int64_t saves = std::ssize(streams_[i]) - std::ssize(condensed[i]);
      // With borders either all patches are condensed, or none.
      if (saves <= 0 && !models_.has_borders) return;
      const Expected<std::vector<uint8_t>> expanded = expand_stream(
          *head, {condensed[i], patch.skeleton, counts_[i].face_count, counts_[i].point_count, known});
      if (!expanded.ok() || *expanded != streams_[i]) return;
      saved[i] = saves;
      is_condensed[i] = 1;
    });
    if (std::accumulate(saved.begin(), saved.end(), int64_t{0}) <= std::ssize(head_bytes)) return;
    result_.head = std::move(head_bytes);
    result_.is_condensed = std::move(is_condensed);
    for (size_t i = 0; i < streams_.size(); ++i) {
      if (result_.is_condensed[i] == 0) continue;
      result_.bytes[i] = std::move(condensed[i]);
      result_.skeleton[i] = static_cast<uint8_t>(patches_[i].skeleton);
    }
  }

  static constexpr size_t kParts = 32;
  static constexpr uint64_t kSampleFaces = 1 << 16;

  std::span<const std::vector<uint8_t>> streams_;
  std::span<const DecodedCounts> counts_;
  bool smallest_;
  const ThreadPool& pool_;
  std::vector<Patch> patches_;
  size_t attribute_count_ = 0, data_count_ = 0;  // of the skeletons that have most
  Models models_;
  CondensedStreams result_;
};

}  // namespace

CondensedStreams condense(std::span<const std::vector<uint8_t>> draco_streams,
                          std::span<const DecodedCounts> counts, bool smallest, const ThreadPool& pool) {
  if (auto condensed = Condenser(draco_streams, counts, smallest, pool).condense(/*with_borders=*/true))
    return std::move(*condensed);
  return *Condenser(draco_streams, counts, smallest, pool).condense(/*with_borders=*/false);
}

}  // namespace psplit
