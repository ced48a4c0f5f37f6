#include <algorithm>

#include "encoder/condensing/coded_patch.h"
#include "encoder/condensing/section_writer.h"
#include "encoder/condensing/shared_models.h"

namespace psplit {
namespace {

class PatchWriter {
 public:
  PatchWriter(const CodedPatch& patch, const CondensedHead& head)
      : patch_(patch), fields_(patch.fields), head_(head) {}

  std::vector<uint8_t> write() {
    // The main section comes last, and its plain bits begin at its end: they say where all sections are.
    std::vector<uint8_t> bytes;
    std::vector<uint32_t> lengths;
    for (uint32_t i = 1; i < patch_.attributes.size(); ++i) {
      if (head_.attributes[i].is_delta) continue;
      SectionWriter section;
      code_attribute(i, section);
      lengths.push_back(section.append_to(bytes));
    }
    std::vector<uint32_t> delta_lengths;
    if (patch_.deltas.has_rows()) delta_lengths = append_deltas(bytes);
    SectionWriter main;
    write_connectivity_numbers(main.plain());
    write_attribute_numbers(lengths, delta_lengths, main.plain());
    if (head_.has_borders) code_border(main);
    code_symbols(main);
    code_seams(main);
    code_attribute(0, main);
    main.append_to(bytes);
    return bytes;
  }

 private:
  void write_connectivity_numbers(BitStringWriter& out) {
    core::NumberKind vertices(0), splits(2), event_kind(8);
    const uint32_t interior = fields_.face_count - fields_.symbol_count;
    const auto components = static_cast<uint32_t>(fields_.start_faces.size());
    out.number(count_, interior);
    out.signed_number(vertices, int64_t{patch_.point_count} - fields_.vertex_count);
    out.number(splits, static_cast<uint32_t>(std::ranges::count(fields_.symbols, core::kS)));
    out.number(count_, components - 1);
    if (interior > 0 && interior < components)
      for (const uint8_t flag : fields_.start_faces) out.bits(flag, 1);
    out.number(count_, static_cast<uint32_t>(fields_.split_events.size()));
    uint32_t last = 0;  // counted from the other end, as encoders do
    for (const core::SplitEvent& event : fields_.split_events) {
      const uint32_t source = fields_.symbol_count - 1 - event.source;
      out.number(event_kind, source - last);
      out.number(event_kind, event.split - event.source);
      out.bits(event.right_edge, 1);
      last = source;
    }
    for (const std::vector<uint8_t>& seams : fields_.seams) out.bits(has_seams(seams), 1);
  }

  void write_attribute_numbers(std::span<const uint32_t> section_bytes,
                               std::span<const uint32_t> delta_section_bytes, BitStringWriter& out) {
    core::NumberKind bytes(8), low(12), extent(12), flags(8);
    for (const uint32_t count : section_bytes) out.number(bytes, count);
    for (const uint8_t is_row : patch_.deltas.is_row) out.bits(is_row, 1);
    for (const uint32_t count : delta_section_bytes) out.number(bytes, count);
    for (uint32_t i = 0; i < patch_.attributes.size(); ++i) {
      const AttributeFields& attribute = fields_.attributes[i];
      if (!attribute.skeleton.has_wrap_range() || is_by_creation(i)) continue;
      out.signed_number(low, attribute.wrap_min);
      out.number(extent, static_cast<uint32_t>(attribute.wrap_max) - static_cast<uint32_t>(attribute.wrap_min));
    }
    for (uint32_t i = 0; i < patch_.attributes.size(); ++i) {
      const AttributeFields& attribute = fields_.attributes[i];
      const core::Scheme scheme = attribute.skeleton.scheme;
      if (scheme == core::Scheme::kConstrainedMultiParallelogram)
        for (const std::vector<uint8_t>& list : attribute.creases)
          out.number(flags, static_cast<uint32_t>(list.size()));
      if (scheme == core::Scheme::kTexCoords)
        out.number(flags, static_cast<uint32_t>(attribute.same_orientations.size()));
    }
    for (uint32_t i = 0; i < patch_.attributes.size(); ++i)
      out.bits(patch_.attributes[i].set, set_bits(head_.attributes[i].set_count));
    core::NumberKind border(5);
    if (head_.has_borders)
      out.number(border,
                 static_cast<uint32_t>(patch_.border.symbols.size() / fields_.attributes[0].components));
  }

  bool is_by_creation(uint32_t i) const {
    return head_.attributes[i].by_creation && fields_.attributes[i].skeleton.allows_creation_order();
  }

  void code_border(SectionWriter& out) {
    for (size_t i = 0; i < patch_.border.symbols.size(); ++i) {
      const bool is_first = i < fields_.attributes[0].components;
      code_token(patch_.border.symbols[i], head_.token_tables[head_.border_tables[is_first ? 0 : 1]], out);
    }
  }

  static void code_token(uint32_t symbol, const core::TokenTable& table, SectionWriter& out) {
    const Token token = token_of(symbol);
    out.code(table.shares[token.token]);
    out.plain().bits(token.extra, token.extra_bits);
  }

  std::vector<uint32_t> append_deltas(std::vector<uint8_t>& bytes) {
    const core::DeltaTables& tables = head_.delta_tables;
    SectionWriter out;
    for (const uint32_t flag : patch_.deltas.flags) {
      if (flag < CodedDeltas::kRun)
        out.code_bit(flag != 0, tables.some);
      else
        code_token(flag - CodedDeltas::kRun, head_.token_tables[tables.runs], out);
    }
    std::vector<uint32_t> lengths{out.append_to(bytes)};
    for (const std::vector<CodedDeltas::Correction>& component : patch_.deltas.corrections) {
      for (const CodedDeltas::Correction& correction : component)
        code_token(correction.symbol, head_.token_tables[tables.of_level[correction.level]], out);
      lengths.push_back(out.append_to(bytes));
    }
    return lengths;
  }

  void code_symbols(SectionWriter& out) {
    for (size_t i = 0; i < patch_.contexts.size(); ++i)
      out.code(head_.contexts[patch_.contexts[i]].shares[core::number_of_clers(fields_.symbols[i + 1])]);
  }

  void code_seams(SectionWriter& out) {
    for (size_t data = 0; data < fields_.seams.size(); ++data) {
      if (!has_seams(fields_.seams[data])) continue;
      uint8_t before = 0;
      for (const uint8_t seam : fields_.seams[data]) {
        out.code_bit(seam != 0, head_.seams[data].after[before]);
        before = seam;
      }
    }
  }

  void code_attribute(uint32_t i, SectionWriter& out) {
    const core::AttributeModel& model = head_.attributes[i];
    const CodedValues& values = patch_.attributes[i];
    const uint32_t components = fields_.attributes[i].components;
    const core::TableSet& set = head_.table_sets[model.first_set + values.set];
    for (size_t value = 0; value < values.table.size(); ++value) {
      const core::TokenTable& table = head_.token_tables[set.tables[values.table[value]]];
      for (uint32_t k = 0; k < components; ++k) code_token(values.symbols[value * components + k], table, out);
    }
    for (uint32_t kind = 0; kind < kFlagKinds; ++kind)
      for (const uint8_t flag : flags_of_kind(fields_.attributes[i], kind))
        out.code_bit(flag != 0, flag_probability(model, kind));
  }

  core::NumberKind count_{0};
  const CodedPatch& patch_;
  const DracoFields& fields_;
  const CondensedHead& head_;
};

}  // namespace

std::vector<uint8_t> write_patch(const CodedPatch& patch, const CondensedHead& head) {
  return PatchWriter(patch, head).write();
}

}  // namespace psplit
