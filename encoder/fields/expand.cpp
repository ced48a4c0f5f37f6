#include "encoder/fields/expand.h"

#include <algorithm>
#include <memory>

#include "encoder/fields/draco_corrections.h"
#include "encoder/fields/draco_fields.h"
#include "encoder/fields/stream_layout.h"
#include "encoder/fields/symbol_lists.h"
#include "src/core/condensed/border_part.h"
#include "src/core/condensed/condensed_header.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

using core::Fault;

// Decodes a condensed stream with the core, and takes the fields of its Draco stream where the decoder stops.
class StreamExpander {
 public:
  StreamExpander(const CondensedHead& head, const CondensedPatch& patch)
      : patch_(patch), models_(head.models()) {
    fields_.skeleton = head.skeletons[patch.skeleton];
    fields_.symbol_level = head.levels[patch.skeleton];
  }

  Expected<DracoFields> take_fields() {
    Fault fault = read_header();
    if (fault == Fault::kNone) fault = read_symbols();
    if (fault == Fault::kNone) fault = decode();
    if (fault != Fault::kNone) return status_of(fault);
    if (header_.valence)
      if (Status status = list_symbols(fields_); !status.ok()) return status;
    measured_.ends = static_cast<double>(patch_.bytes.size()) - measured_.total();
    // From the last one on, so that the places of those before stay.
    for (size_t i = unpredicted_.size(); i-- > 0;) store_as_values(attributes_[unpredicted_[i]]);
    return std::move(fields_);
  }
  // The bytes that take_fields has read, by section.
  const SectionBytes& measured() const { return measured_; }

 private:
  using Decoder = core::PatchDecoder<uint32_t, core::StreamKinds::kCondensed>;

  // Makes the scheme that of an attribute that is not predicted, which has no transform.
  void store_as_values(const core::SkeletonAttribute& attribute) {
    const auto scheme = fields_.skeleton.begin() + static_cast<std::ptrdiff_t>(attribute.scheme_at);
    *scheme = static_cast<uint8_t>(core::Scheme::kNone);
    fields_.skeleton.erase(scheme + 1);
  }

  // Reads the plain numbers of the connectivity, and takes the memory for everything.
  Fault read_header() {
    core::CondensedStream& stream = header_.condensed;
    const core::View<const uint8_t> skeleton(fields_.skeleton.data(), fields_.skeleton.size());
    Fault fault = core::read_condensed_header(skeleton, {patch_.bytes.data(), patch_.bytes.size()}, models_,
                                              patch_.face_count, patch_.point_count,
                                              {attributes_, core::kMaxAttributes}, header_, stream);
    if (fault != Fault::kNone) return fault;
    const core::ConnectivityCounts& counts = header_.counts;
    core::ValueCounts values{patch_.point_count, stream.attribute_count, 0};
    for (uint32_t i = 0; i < stream.attribute_count; ++i) values.components += attributes_[i].components;
    if (patch_.point_count > core::most_points(header_)) return Fault::kCounts;
    const size_t size = core::workspace_bytes<uint32_t>(header_, patch_.bytes.size(), values);
    if (size > core::justified_bytes(patch_.bytes.size())) return Fault::kWorkspace;
    memory_.reset(new uint8_t[size]);
    arena_ = core::Arena(memory_.get(), size);
    fields_.face_count = counts.face_count;
    fields_.symbol_count = counts.symbol_count;
    fields_.vertex_count = counts.vertex_limit - stream.split_symbol_count;
    fields_.split_events.resize(counts.split_count);
    fault = core::read_split_events(stream, counts.symbol_count,
                                    {fields_.split_events.data(), fields_.split_events.size()});
    core::CondensedStartFaces start_faces(stream);
    for (uint32_t i = 0; i < stream.component_count; ++i) fields_.start_faces.push_back(start_faces.next());
    measured_.numbers = static_cast<double>(stream.numbers_end) / 8;
    return fault == Fault::kNone && models_.has_borders ? skip_border_part() : fault;
  }
  // The values that it has are known.
  Fault skip_border_part() {
    core::CondensedStream& stream = header_.condensed;
    const uint64_t total = uint64_t{stream.border_count} * stream.border_components;
    if (sizeof(uint32_t) * total > core::justified_bytes(patch_.bytes.size())) return Fault::kWorkspace;
    std::vector<uint32_t> symbols(static_cast<size_t>(total));
    std::vector<uint8_t> table_of(stream.border_count);
    core::TokenSequence tokens;
    const Fault fault = core::start_border_part(stream, {table_of.data(), table_of.size()},
                                                {symbols.data(), symbols.size()}, tokens);
    if (fault != Fault::kNone) return fault;
    const core::SectionReader begin = tokens.section();
    core::TokenSequence* const one = &tokens;
    core::step_tokens<1>(&one, 1);
    add_section_bytes(begin, tokens.section(), measured_.borders, measured_.borders);
    stream.known = {patch_.known.data(), patch_.known.size()};
    stream.behind_border = tokens.section();
    return Fault::kNone;
  }

  // The decoder does not keep Edgebreaker's symbols, so they are decoded once more, for themselves.
  Fault read_symbols() {
    core::SectionReader section;
    Fault fault = core::start_symbols(header_.condensed, section);
    if (fault != Fault::kNone) return fault;
    const core::SectionReader begin = section;
    fields_.symbols.resize(fields_.symbol_count);
    if (models_.has_valence_contexts) {
      std::vector<uint32_t> corners(size_t{header_.counts.vertex_limit} + 3);
      fault = add_faces_alone(header_.counts, fields_.split_events, [&](const Valences& valences) {
        using Symbols = core::ValenceContextSymbols<uint32_t, /*kLast=*/false>;
        return StoredSymbols(Symbols(valences, models_, section, {corners.data(), corners.size()}),
                             fields_.symbols.data());
      });
    } else {
      core::ContextSymbolSteps steps(section, models_, {fields_.symbols.data(), fields_.symbols.size()});
      while (steps.steps_left() > 0) steps.step();
      section = steps.section();
    }
    add_section_bytes(begin, section, measured_.symbols, measured_.numbers);
    return fault;
  }

  Fault decode() {
    Decoder decoder(header_, arena_, decoded_);
    Decoder* const one[] = {&decoder};
    Fault fault = decoder.start();
    while (fault == Fault::kNone && decoder.stop() != core::Stop::kDone) {
      const core::Stop stop = decoder.stop();
      const core::View<core::CondensedSeamSteps> seams = decoder.condensed_seams();
      const core::SectionReader before_seams = seams.empty() ? core::SectionReader() : seams[0].section();
      if (stop == core::Stop::kChains) note_sections(decoder, begins_);
      core::take_steps(one, 1);
      if (stop == core::Stop::kSeams) {
        take_seams(decoder);
        add_section_bytes(before_seams, seams[0].section(), measured_.seams, measured_.numbers);
      }
      if (stop == core::Stop::kChains) note_sections(decoder, behind_tokens_);
      fault = decoder.resume(core::SerialLanes());
      if (stop == core::Stop::kChains && fault == Fault::kNone) take_attributes(decoder);
    }
    if (fault == Fault::kNone && decoded_.point_count != patch_.point_count) return Fault::kCounts;
    return fault == Fault::kNone ? take_created(decoder) : fault;
  }

  // A flag for each edge between two faces, also if there are no seams.
  void take_seams(const Decoder& decoder) {
    const core::View<const uint32_t> opposite = decoded_.mesh.table.opposite;
    size_t sides = 0;
    for (size_t corner = 0; corner < opposite.size(); ++corner)
      sides += corner % 4 != 3 && opposite[corner] != core::kNone<uint32_t> ? 1 : 0;
    for (uint32_t data = 0; data < header_.attribute_data_count; ++data) {
      const core::View<const uint8_t> flags = decoder.seam_flags(data);
      fields_.seams.emplace_back(flags.data(), flags.data() + flags.size()).resize(sides / 2);
    }
  }

  static void note_sections(const Decoder& decoder, std::vector<core::SectionReader>& sections) {
    const auto attributes = decoder.condensed_attributes();
    for (size_t i = 0; i < attributes.size(); ++i) sections.push_back(attributes[i].tokens.section());
  }

  // The symbols and flags of the values that are not in order of creation.
  void take_attributes(const Decoder& decoder) {
    fields_.attributes.resize(decoded_.attributes.size());
    for (uint32_t i = 0; i < fields_.attributes.size(); ++i) {
      core::CondensedAttribute<uint32_t>& attribute = decoder.condensed_attributes()[i];
      const core::Attribute<uint32_t>& description = decoded_.attributes[i];
      AttributeFields& out = fields_.attributes[i];
      out.count = decoded_.groups[description.group].table.vertex_count;
      out.components = description.value_components();
      if (description.coding == core::Coding::kRaw)
        out.raw.assign(description.raw, description.raw + size_t{out.count} * description.stride());
      else if (!attribute.by_creation)
        take_corrections(decoder.integers()[i], out);
      SectionBytes::Attribute& measured = measured_.attributes.emplace_back();
      if (attribute.is_delta) {
        measured.tokens += attribute.section_bytes;
        continue;
      }
      add_section_bytes(begins_[i], behind_tokens_[i], measured.tokens, measured.bits);
      add_section_bytes(behind_tokens_[i], attribute.tokens.section(), measured.flags, measured.bits);
    }
  }
  static void take_corrections(core::IntegerDecoder<uint32_t>& integers, AttributeFields& out) {
    const core::PredictionData& data = integers.data();
    const auto bytes = [](core::View<const uint8_t> flags) {
      return std::vector<uint8_t>(flags.data(), flags.data() + flags.size());
    };
    const core::View<uint32_t> symbols = integers.symbols();
    out.symbols.assign(symbols.data(), symbols.data() + symbols.size());
    if (data.scheme == core::Scheme::kNone) return;
    if (data.transform == core::Transform::kWrap) {
      out.wrap_min = data.wrap.low;
      out.wrap_max = data.wrap.high;
    } else {
      // Corrections on an octahedron are modulo the number of places of a component.
      for (uint32_t& symbol : out.symbols) {
        const int64_t correction = core::unfold(symbol);
        symbol = static_cast<uint32_t>(correction < 0 ? correction + data.grid.max_quantized() : correction);
      }
    }
    for (uint32_t list = 0; list < core::kMaxParallelograms; ++list)
      out.creases[list] = bytes(data.creases[list]);
    out.same_orientations = bytes(data.orientations);
    for (size_t k = out.same_orientations.size(); k-- > 0;)
      out.same_orientations[k] = data.orientations[k] == (k > 0 ? data.orientations[k - 1] : 1);
    out.flips = bytes(data.flips_by_value);
  }

  // The corrections that Draco's encoder makes of created values.
  Fault take_created(const Decoder& decoder) {
    for (uint32_t i = 0; i < fields_.attributes.size(); ++i) {
      if (!decoder.condensed_attributes()[i].by_creation) continue;
      const core::Attribute<uint32_t>& attribute = decoded_.attributes[i];
      core::Group<uint32_t>& group = decoded_.groups[attribute.group];
      if (group.sequence.corner.empty())
        if (const Fault fault = find_sequence(group); fault != Fault::kNone) return fault;
      const core::PredictionData& data = decoder.integers()[i].data();
      const bool is_predicted = data.scheme != core::Scheme::kNone;
      if (!DracoCorrections(group, attribute, data).write(fields_.attributes[i]) && is_predicted)
        unpredicted_.push_back(i);
    }
    return Fault::kNone;
  }
  // Groups with the same table and the same walk have the same order, but each has memory of its own here.
  Fault find_sequence(core::Group<uint32_t>& group) {
    const uint32_t count = group.table.vertex_count;
    const size_t size = core::Sequence<uint32_t>::bytes(count) +
                        core::traverse_bytes<uint32_t>(group.by_prediction_degree, decoded_.face_count, count);
    sequences_.emplace_back(new uint8_t[size]);
    core::Arena arena(sequences_.back().get(), size);
    if (!group.sequence.allocate(count, arena)) return Fault::kWorkspace;
    return core::traverse(group.table, group.by_prediction_degree, arena, group.sequence);
  }

  const CondensedPatch& patch_;
  const core::CondensedModels models_;
  core::StreamHeader header_;
  core::SkeletonAttribute attributes_[core::kMaxAttributes];
  std::unique_ptr<uint8_t[]> memory_;
  core::Arena arena_;
  core::Patch<uint32_t> decoded_;
  std::vector<std::unique_ptr<uint8_t[]>> sequences_;
  std::vector<core::SectionReader> begins_, behind_tokens_;  // by attribute
  std::vector<uint32_t> unpredicted_;                        // attributes whose range no transform has
  DracoFields fields_;
  SectionBytes measured_;
};

Status check_skeleton(const CondensedHead& head, const CondensedPatch& patch) {
  return patch.skeleton < head.skeletons.size() ? Status() : invalid_input("a skeleton that does not exist");
}

}  // namespace

Expected<std::vector<uint8_t>> expand_stream(const CondensedHead& head, const CondensedPatch& patch) {
  if (Status status = check_skeleton(head, patch); !status.ok()) return status;
  const Expected<DracoFields> fields = StreamExpander(head, patch).take_fields();
  if (!fields) return fields.status();
  return write_fields(*fields);
}

Expected<SectionBytes> measure_stream(const CondensedHead& head, const CondensedPatch& patch) {
  if (Status status = check_skeleton(head, patch); !status.ok()) return status;
  StreamExpander expander(head, patch);
  const Expected<DracoFields> fields = expander.take_fields();
  if (!fields) return fields.status();
  return expander.measured();
}

}  // namespace psplit
