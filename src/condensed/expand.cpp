#include "src/condensed/expand.h"

#include <algorithm>
#include <optional>

#include "src/condensed/creation_order.h"
#include "src/condensed/draco_corrections.h"
#include "src/condensed/draco_fields.h"
#include "src/condensed/skeleton.h"
#include "src/condensed/stream_layout.h"
#include "src/condensed/stream_mesh.h"
#include "src/core/condensed/border_part.h"
#include "src/core/condensed/condensed_header.h"
#include "src/core/condensed/context_symbols.h"
#include "src/core/condensed/token_steps.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

using core::Fault;

// The symbols of a section, for core::add_faces. Each is also stored, and so is its list in a valence
// traversal.
class SectionSymbols : public Valences {
 public:
  SectionSymbols(const Valences& valences, core::SectionReader& section, const core::CondensedModels& models,
                 uint8_t* symbols, uint8_t* lists)
      : Valences(valences),
        section_(&section),
        models_(&models),
        history_(models.first_context),
        symbols_(symbols),
        lists_(lists) {}

  uint32_t next(uint32_t to) {
    constexpr uint32_t kE = 4;
    uint32_t number = kE;
    *lists_ = 0;
    if (to != core::kNone<uint32_t>) {
      *lists_ = static_cast<uint8_t>(class_of(to));
      number = decode(models_->contexts[models_->has_valence_contexts ? 5 * class_of(to) + last_ : history_]);
    }
    ++lists_;
    last_ = number;
    if (!models_->has_valence_contexts) history_ = models_->contexts[history_].next + number;
    return *symbols_++ = is_unused_ ? uint8_t{core::SymbolContext::kInvalid} : kClersOfNumber[number];
  }

 private:
  uint32_t decode(const core::SymbolContext& context) {
    uint32_t clers;
    const uint32_t number = core::next_symbol(*section_, context, clers);
    is_unused_ = clers == core::SymbolContext::kInvalid;
    return number;
  }

  core::SectionReader* section_;
  const core::CondensedModels* models_;
  uint32_t history_, last_ = 4;
  uint8_t *symbols_, *lists_;
  bool is_unused_ = false;
};

// Reads the fields of a condensed stream.
class FieldsExpander {
 public:
  FieldsExpander(const CondensedHead& head, const CondensedStream& stream, const Skeleton& skeleton)
      : stream_(stream),
        literals_(head.skeletons[stream.skeleton]),
        models_(head.models()),
        skeleton_(skeleton),
        bytes_left_(core::justified_bytes(stream.bytes.size())) {
    fields_.symbol_level = head.levels[stream.skeleton];
    sequences_.resize(skeleton.groups.size());
  }

  // What read() has read.
  const SectionBytes& bytes_read() const { return read_; }

  Expected<DracoFields> read() {
    Fault fault = read_header();
    if (fault == Fault::kNone) fault = read_connectivity();
    for (uint32_t i = 0; i < skeleton_.attributes.size() && fault == Fault::kNone; ++i)
      fault = read_attribute(i);
    if (fault == Fault::kNone && !main_.is_at_end()) fault = Fault::kSection;
    if (fault != Fault::kNone) return fault_status(fault);
    read_.ends = static_cast<double>(stream_.bytes.size()) - read_.total();
    fields_.skeleton = literals_;
    // From the last one on, so that the places of those before stay.
    for (size_t i = unpredicted_.size(); i-- > 0;) store_as_values(skeleton_.attributes[unpredicted_[i]]);
    return std::move(fields_);
  }

 private:
  // Memory that the bytes of the stream must justify.
  bool claim(uint64_t bytes) {
    if (bytes > bytes_left_) return false;
    bytes_left_ -= bytes;
    return true;
  }

  // Makes the scheme that of an attribute that is not predicted, which has no transform.
  void store_as_values(const SkeletonAttribute& attribute) {
    const auto scheme = fields_.skeleton.begin() + static_cast<std::ptrdiff_t>(attribute.scheme_at);
    *scheme = static_cast<uint8_t>(core::Scheme::kNone);
    fields_.skeleton.erase(scheme + 1);
  }

  // Reads the plain numbers, all of which are in the main section, and finds all sections.
  Fault read_header() {
    const core::View<const uint8_t> bytes(stream_.bytes.data(), stream_.bytes.size());
    const Fault fault = core::read_condensed_header({literals_.data(), literals_.size()}, bytes, models_,
                                                    stream_.face_count, stream_.point_count, header_);
    if (fault != Fault::kNone) return fault;
    const core::CondensedStream& condensed = header_.condensed;
    const core::ConnectivityCounts& counts = header_.counts;
    if (!claim(8 * (uint64_t{counts.symbol_count} + counts.split_count + condensed.component_count)))
      return Fault::kWorkspace;
    fields_.face_count = counts.face_count;
    fields_.symbol_count = counts.symbol_count;
    fields_.vertex_count = counts.vertex_limit - condensed.split_symbol_count;
    read_start_faces(condensed);
    if (const Fault events = read_events(condensed); events != Fault::kNone) return events;
    core::CondensedNumbers seams(condensed.numbers(condensed.seams_at));
    for (uint32_t i = 0; i < skeleton_.data_count; ++i) has_seams_.push_back(seams.bit() != 0);
    return read_attribute_numbers(condensed);
  }
  void read_start_faces(const core::CondensedStream& condensed) {
    core::CondensedNumbers numbers(condensed.numbers(condensed.start_faces_at));
    fields_.start_faces.assign(condensed.component_count, condensed.interior_count > 0);
    if (!condensed.has_start_face_bits()) return;
    for (uint8_t& flag : fields_.start_faces) flag = static_cast<uint8_t>(numbers.bit());
  }
  Fault read_events(const core::CondensedStream& condensed) {
    core::CondensedNumbers numbers(condensed.numbers(condensed.events_at));
    core::CondensedKinds kinds;
    uint64_t source = 0;
    for (uint32_t i = 0; i < header_.counts.split_count; ++i) {
      const auto event = numbers.split_event(kinds.event);
      source += event.source_delta;
      core::SplitEvent& out = fields_.split_events.emplace_back();
      if (!core::set_split_event(fields_.symbol_count, source, event.back, out)) return Fault::kSplitEvent;
      out.right_edge = event.right_edge;
    }
    return Fault::kNone;
  }
  Fault read_attribute_numbers(const core::CondensedStream& condensed) {
    core::CondensedNumbers numbers(condensed.numbers(condensed.lengths_at));
    core::CondensedKinds kinds;
    const size_t attribute_count = skeleton_.attributes.size();
    for (size_t i = 1; i < attribute_count; ++i) section_bytes_.push_back(numbers.number(kinds.bytes));
    fields_.attributes.resize(attribute_count);
    for (uint32_t i = 0; i < attribute_count; ++i) {
      if (!skeleton_.attributes[i].has_wrap_range() || is_by_creation(i)) continue;
      const int64_t low = numbers.signed_number(kinds.low), high = low + numbers.number(kinds.extent);
      if (high > 0x7fffffff) return Fault::kPrediction;
      fields_.attributes[i].wrap_min = static_cast<int32_t>(low);
      fields_.attributes[i].wrap_max = static_cast<int32_t>(high);
    }
    for (uint32_t i = 0; i < attribute_count; ++i) {
      const core::Scheme scheme = skeleton_.attributes[i].scheme;
      AttributeFields& attribute = fields_.attributes[i];
      if (scheme == core::Scheme::kConstrainedMultiParallelogram)
        for (std::vector<uint8_t>& list : attribute.creases)
          if (!make_flags(list, numbers.number(kinds.flags))) return Fault::kPrediction;
      if (scheme == core::Scheme::kTexCoords &&
          !make_flags(attribute.same_orientations, numbers.number(kinds.flags)))
        return Fault::kPrediction;
    }
    for (uint32_t i = 0; i < attribute_count; ++i) {
      const core::AttributeModel& model = models_.attributes[i];
      const uint32_t set = numbers.bits(static_cast<int>(core::set_bits(model)));
      if (set >= model.set_count) return Fault::kAttribute;
      tables_.push_back(models_.table_sets[model.first_set + set]);
    }
    if (numbers.broken()) return Fault::kTruncated;
    main_ = condensed.numbers(condensed.numbers_end);
    read_.numbers = static_cast<double>(main_.bits_taken()) / 8;
    return models_.has_borders ? skip_border_part() : main_.start_words(condensed.first_section);
  }
  // The values that it has are known.
  Fault skip_border_part() {
    const uint32_t count = header_.condensed.border_count;
    const uint64_t total = uint64_t{count} * header_.condensed.border_components;
    if (!claim(sizeof(uint32_t) * total + count)) return Fault::kWorkspace;
    std::vector<uint32_t> symbols(static_cast<size_t>(total));
    std::vector<uint8_t> table_of(count);
    core::TokenSequence tokens;
    const Fault fault =
        core::start_border_part(header_, {table_of.data(), count}, {symbols.data(), symbols.size()}, tokens);
    if (fault != Fault::kNone) return fault;
    SectionMeter meter(tokens.section());
    core::TokenSequence* const one = &tokens;
    core::step_tokens<1>(&one, 1);
    meter.add(read_.borders, read_.borders);
    main_ = tokens.section();
    return Fault::kNone;
  }
  // No scheme has more flags than there are corners.
  bool make_flags(std::vector<uint8_t>& flags, uint32_t count) {
    if (count > 3 * uint64_t{fields_.face_count} || !claim(count)) return false;
    flags.resize(count);
    return true;
  }

  bool is_by_creation(uint32_t attribute) const {
    return models_.attributes[attribute].by_creation && skeleton_.attributes[attribute].allows_creation_order();
  }

  Fault read_connectivity() {
    mesh_.emplace(header_.counts, skeleton_.data_count);
    if (!claim(mesh_->bytes())) return Fault::kWorkspace;
    mesh_->allocate();
    fields_.symbols.resize(fields_.symbol_count);
    SectionMeter meter(main_);
    std::vector<uint8_t> lists(fields_.symbol_count);
    const auto symbols = [&](const Valences& valences) {
      return SectionSymbols(valences, main_, models_, fields_.symbols.data(), lists.data());
    };
    const core::View<const core::SplitEvent> events(fields_.split_events.data(), fields_.split_events.size());
    const Fault fault = mesh_->decode(symbols, events, fields_.start_faces);
    if (fault != Fault::kNone) return fault;
    meter.add(read_.symbols, read_.numbers);
    const auto s_count =
        static_cast<uint32_t>(std::count(fields_.symbols.begin(), fields_.symbols.end(), core::kS));
    if (s_count != header_.condensed.split_symbol_count ||
        component_count(fields_) != header_.condensed.component_count)
      return Fault::kCounts;
    if (skeleton_.is_valence)
      for (size_t i = lists.size(); i-- > 1;)
        fields_.symbol_lists[lists[i]].push_back(kNumberOfClers[fields_.symbols[i]]);
    return read_seams();
  }

  Fault read_seams() {
    SectionMeter meter(main_);
    for (uint32_t data = 0; data < skeleton_.data_count; ++data) {
      if (!claim(mesh_->edge_count())) return Fault::kWorkspace;
      std::vector<uint8_t>& seams = fields_.seams.emplace_back(mesh_->edge_count());
      uint8_t before = 0;
      if (has_seams_[data])
        for (uint8_t& seam : seams)
          before = seam = static_cast<uint8_t>(main_.next_bit(models_.seams[data].after[before]));
      if (const Fault fault = mesh_->cut(seams); fault != Fault::kNone) return fault;
    }
    meter.add(read_.seams, read_.numbers);
    return Fault::kNone;
  }

  Fault read_attribute(uint32_t i) {
    if (i == 0) return read_values(i, main_);
    core::SectionReader section(stream_.bytes.data() + section_at_, section_bytes_[i - 1]);
    section_at_ += section_bytes_[i - 1];
    Fault fault = section.start_words(0);
    if (fault == Fault::kNone) fault = read_values(i, section);
    return fault == Fault::kNone && !section.is_at_end() ? Fault::kSection : fault;
  }

  Fault read_values(uint32_t i, core::SectionReader& section) {
    const SkeletonAttribute& attribute = skeleton_.attributes[i];
    const core::Group<uint32_t>& group = skeleton_.groups[attribute.group];
    AttributeFields& out = fields_.attributes[i];
    out.count = mesh_->table(group).vertex_count;
    out.components = attribute.components;
    const uint64_t total = uint64_t{out.count} * out.components;
    // Symbols and values.
    if (total > 0xffffffffu || !claim(3 * sizeof(uint32_t) * total)) return Fault::kWorkspace;
    out.symbols.resize(static_cast<size_t>(total));
    SectionBytes::Attribute& read = read_.attributes.emplace_back();
    SectionMeter meter(section);
    Fault fault = is_by_creation(i) ? read_by_creation(i, group, section) : read_in_draco_order(i, section);
    meter.add(read.tokens, read.bits);
    if (fault == Fault::kNone) fault = read_flags(i, section);
    meter.add(read.flags, read.bits);
    return fault;
  }

  // False if the table does not exist.
  bool read_value(const core::TableSet& set, uint32_t table, core::SectionReader& section, uint32_t* out,
                  uint32_t components) const {
    const uint32_t number = set.tables[table];
    if (number == core::kNoTable) return false;
    const core::TokenTable& tokens = models_.token_tables[number];
    for (uint32_t k = 0; k < components; ++k) {
      const core::TokenBits bits = core::token_bits(section.next_token(tokens));
      out[k] = bits.base + section.read(static_cast<int>(bits.bit_count));
    }
    return true;
  }

  Fault read_in_draco_order(uint32_t i, core::SectionReader& section) {
    AttributeFields& out = fields_.attributes[i];
    const SkeletonAttribute& attribute = skeleton_.attributes[i];
    constexpr uint32_t kFirst = 3, kMostComponentBytes = 4;
    if (attribute.is_raw && attribute.component_bytes > kMostComponentBytes) return Fault::kAttribute;
    for (uint32_t value = 0; value < out.count; ++value)
      if (!read_value(tables_[i], value < kFirst ? 0 : 1, section, &out.symbols[size_t{value} * out.components],
                      out.components))
        return Fault::kEntropy;
    if (attribute.grid_max > 0) return make_octahedral(attribute.grid_max, out.symbols);
    if (attribute.is_raw) make_raw(attribute, out);
    return Fault::kNone;
  }
  // Corrections on an octahedron are modulo the number of places of a component.
  static Fault make_octahedral(uint32_t modulus, std::vector<uint32_t>& symbols) {
    for (uint32_t& symbol : symbols) {
      const int64_t correction = core::unfold(symbol);
      if (correction > modulus / 2 || -correction > (modulus - 1) / 2) return Fault::kPrediction;
      symbol = static_cast<uint32_t>(correction < 0 ? correction + modulus : correction);
    }
    return Fault::kNone;
  }
  static void make_raw(const SkeletonAttribute& attribute, AttributeFields& out) {
    std::vector<uint32_t> before(attribute.components);
    out.raw.reserve(out.symbols.size() * attribute.component_bytes);
    for (size_t at = 0; at < out.symbols.size(); ++at) {
      uint32_t& number = before[at % before.size()];
      number += static_cast<uint32_t>(core::unfold(out.symbols[at]));
      for (uint32_t byte = 0; byte < attribute.component_bytes; ++byte)
        out.raw.push_back(static_cast<uint8_t>(number >> 8 * byte));
    }
    out.symbols = {};
  }

  // The vertices of the border walk, and their values. Of several places of a vertex the lowest counts.
  Fault take_known_values(const core::Group<uint32_t>& group, uint32_t components, std::vector<uint32_t>& known,
                          std::vector<int32_t>& values) {
    std::vector<uint32_t> walk;
    if (const Fault fault = mesh_->find_walk(group, walk); fault != Fault::kNone) return fault;
    if (stream_.known.size() != uint64_t{walk.size()} * components) return Fault::kCounts;
    const uint32_t stride = core::value_stride(components);
    std::vector<bool> is_known(values.size() / stride);
    for (size_t place = 0; place < walk.size(); ++place) {
      const uint32_t vertex = walk[place];
      if (is_known[vertex]) continue;
      is_known[vertex] = true;
      known.push_back(vertex);
      for (uint32_t k = 0; k < components; ++k)
        values[size_t{vertex} * stride + k] = stream_.known[place * components + k];
    }
    return Fault::kNone;
  }

  Fault read_by_creation(uint32_t i, const core::Group<uint32_t>& group, core::SectionReader& section) {
    const core::AttributeModel& model = models_.attributes[i];
    AttributeFields& out = fields_.attributes[i];
    const core::CornerTable<uint32_t> table = mesh_->table(group).table;
    std::vector<uint32_t> known;
    std::vector<int32_t> values(size_t{out.count} * core::value_stride(out.components));  // by vertex
    if (i == 0 && models_.has_borders)
      if (const Fault fault = take_known_values(group, out.components, known, values); fault != Fault::kNone)
        return fault;
    const CreationOrder order(table, out.count, model.backward, known);
    const CreationPredictor predictor(table, order, model.two);
    const uint32_t stride = core::value_stride(out.components);
    const auto place = [&](uint32_t rank) { return size_t{order.vertex[rank]} * stride; };
    std::vector<uint32_t> symbols(out.components);
    for (uint32_t rank = order.known_count; rank < out.count; ++rank) {
      const CreationPredictor::Prediction by = predictor.of(rank);
      if (!read_value(tables_[i], by.parallelogram_count, section, symbols.data(), out.components))
        return Fault::kEntropy;
      for (uint32_t k = 0; k < out.components; ++k) {
        const int32_t predicted = predicted_number(by, model.mean, model.reach,
                                                   [&](uint32_t other) { return values[place(other) + k]; });
        values[place(rank) + k] = core::wrapping_add(predicted, static_cast<int32_t>(core::unfold(symbols[k])));
      }
    }
    core::Sequence<uint32_t>& sequence = sequences_[skeleton_.attributes[i].group];
    if (sequence.corner.empty())
      if (const Fault fault = mesh_->find_sequence(group, sequence); fault != Fault::kNone) return fault;
    const DracoCorrections corrections(table, sequence, {values.data(), values.size()},
                                       skeleton_.attributes[i]);
    const DracoCorrections::Symbols written = corrections.write(out);
    if (written == DracoCorrections::Symbols::kNone) return Fault::kPrediction;
    const bool is_predicted = skeleton_.attributes[i].scheme != core::Scheme::kNone;
    if (written == DracoCorrections::Symbols::kValues && is_predicted) unpredicted_.push_back(i);
    return Fault::kNone;
  }

  Fault read_flags(uint32_t i, core::SectionReader& section) {
    AttributeFields& out = fields_.attributes[i];
    const core::AttributeModel& model = models_.attributes[i];
    if (skeleton_.attributes[i].scheme == core::Scheme::kGeometricNormal) out.flips.resize(out.count);
    const auto read = [&](std::vector<uint8_t>& flags, uint32_t probability) {
      if (!model.has_flags && !flags.empty()) return Fault::kEntropy;
      for (uint8_t& flag : flags) flag = static_cast<uint8_t>(section.next_bit(probability));
      return Fault::kNone;
    };
    Fault fault = Fault::kNone;
    for (uint32_t list = 0; list < out.creases.size() && fault == Fault::kNone; ++list)
      fault = read(out.creases[list], model.creases[list]);
    if (fault == Fault::kNone) fault = read(out.same_orientations, model.orientations);
    return fault == Fault::kNone ? read(out.flips, model.flips) : fault;
  }

  const CondensedStream& stream_;
  const std::vector<uint8_t>& literals_;
  const core::CondensedModels models_;
  const Skeleton& skeleton_;
  uint64_t bytes_left_;
  core::StreamHeader header_;
  std::vector<bool> has_seams_;          // by attribute data
  std::vector<uint32_t> section_bytes_;  // of all sections except the main one, which comes last
  size_t section_at_ = 0;
  std::vector<core::TableSet> tables_;  // by attribute
  core::SectionReader main_;
  std::optional<StreamMesh> mesh_;
  std::vector<core::Sequence<uint32_t>> sequences_;  // by group; empty until it is needed
  std::vector<uint32_t> unpredicted_;                // attributes whose range no transform has
  DracoFields fields_;
  SectionBytes read_;
};

Expected<Skeleton> skeleton_of(const CondensedHead& head, const CondensedStream& stream) {
  if (stream.skeleton >= head.skeletons.size()) return invalid_input("a skeleton that does not exist");
  Expected<Skeleton> skeleton = read_skeleton(head.skeletons[stream.skeleton]);
  // No encoder condenses a stream whose fields it cannot read.
  if (!skeleton) return invalid_input(skeleton.status().message());
  return skeleton;
}

}  // namespace

Expected<std::vector<uint8_t>> expand_stream(const CondensedHead& head, const CondensedStream& stream) {
  const Expected<Skeleton> skeleton = skeleton_of(head, stream);
  if (!skeleton) return skeleton.status();
  const Expected<DracoFields> fields = FieldsExpander(head, stream, *skeleton).read();
  if (!fields) return fields.status();
  return write_fields(*fields);
}

Expected<SectionBytes> measure_stream(const CondensedHead& head, const CondensedStream& stream) {
  const Expected<Skeleton> skeleton = skeleton_of(head, stream);
  if (!skeleton) return skeleton.status();
  FieldsExpander expander(head, stream, *skeleton);
  const Expected<DracoFields> fields = expander.read();
  if (!fields) return fields.status();
  return expander.bytes_read();
}

}  // namespace psplit
