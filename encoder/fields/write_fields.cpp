#include <algorithm>

#include "encoder/fields/draco_fields.h"
#include "encoder/fields/entropy_encoder.h"
#include "encoder/fields/stream_layout.h"
#include "encoder/fields/symbol_lists.h"
#include "src/container/bit_string.h"

namespace psplit {
namespace {

Status contradiction() { return invalid_input("fields of a stream that contradict each other"); }

// Writes fields, for StreamLayout.
class FieldsWriter {
 public:
  explicit FieldsWriter(const DracoFields& fields) : fields_(fields), literals_(fields.skeleton) {
    out_.reserve(fields.skeleton.size() + fields.symbols.size());
  }

  Expected<std::vector<uint8_t>> write() {
    if (Status status = StreamLayout(*this).walk(); !status.ok()) return status;
    if (attribute_count_ != fields_.attributes.size()) return contradiction();
    literals_.skip(literals_.remaining());
    literals_.copy_to(out_);
    return std::move(out_);
  }

  size_t table_bytes() const { return table_bytes_; }

  Literals& literals() { return literals_; }

  Status counts() {
    literals_.copy_to(out_);
    append_varint(fields_.vertex_count, out_);
    append_varint(fields_.face_count, out_);
    return {};
  }

  Status connectivity(bool is_valence, uint32_t data_count) {
    literals_.copy_to(out_);
    if (fields_.seams.size() != data_count) return contradiction();
    append_varint(fields_.symbol_count, out_);
    append_varint(count_s(is_valence), out_);
    if (Status status = split_events(); !status.ok()) return status;
    if (!is_valence)
      if (Status status = standard_symbols(); !status.ok()) return status;
    encode_flags(fields_.start_faces, out_);
    for (const std::vector<uint8_t>& seams : fields_.seams) encode_flags(seams, out_);
    if (is_valence) symbol_lists();
    return {};
  }

  uint32_t value_count(const core::Group<uint32_t>&) const {
    return attribute_count_ < fields_.attributes.size() ? fields_.attributes[attribute_count_].count : 0;
  }

  Status raw(uint32_t count, const core::Attribute<uint32_t>& description) {
    literals_.copy_to(out_);
    const uint64_t bytes = uint64_t{count} * description.stride();
    if (!next_attribute() || attribute().count != count || attribute().raw.size() != bytes)
      return contradiction();
    out_.insert(out_.end(), attribute().raw.begin(), attribute().raw.end());
    return {};
  }

  Status symbols(uint32_t count, const PredictedAttribute& predicted) {
    const uint32_t components = predicted.attribute.value_components();
    literals_.copy_to(out_);
    if (!next_attribute() || attribute().count != count || attribute().components != components ||
        attribute().symbols.size() != uint64_t{count} * components)
      return contradiction();
    table_bytes_ += encode_symbols(attribute().symbols, components, fields_.symbol_level, out_);
    return {};
  }

  Status creases() {
    for (const std::vector<uint8_t>& flags : attribute().creases) {
      append_varint(flags.size(), out_);
      if (!flags.empty()) encode_flags(flags, out_);
    }
    return {};
  }
  Status orientations() {
    append_u32(static_cast<uint32_t>(attribute().same_orientations.size()), out_);
    encode_flags(attribute().same_orientations, out_);
    return {};
  }
  Status wrap() {
    append_u32(static_cast<uint32_t>(attribute().wrap_min), out_);
    append_u32(static_cast<uint32_t>(attribute().wrap_max), out_);
    return {};
  }
  Status flips() {
    literals_.copy_to(out_);
    encode_flags(attribute().flips, out_);
    return {};
  }

 private:
  uint64_t count_s(bool is_valence) const {
    if (!is_valence)
      return static_cast<uint64_t>(std::count(fields_.symbols.begin(), fields_.symbols.end(), core::kS));
    uint64_t count = 0;
    for (const std::vector<uint8_t>& list : fields_.symbol_lists)
      count += static_cast<uint64_t>(std::count(list.begin(), list.end(), core::number_of_clers(core::kS)));
    return count;
  }

  // Encoders number symbols from the other end.
  Status split_events() {
    append_varint(fields_.split_events.size(), out_);
    if (fields_.split_events.empty()) return {};
    uint32_t last = 0;
    for (const core::SplitEvent& event : fields_.split_events) {
      if (event.source > event.split || event.split >= fields_.symbol_count) return contradiction();
      const uint32_t source = fields_.symbol_count - 1 - event.source;
      if (source < last) return contradiction();
      append_varint(source - last, out_);
      append_varint(event.split - event.source, out_);
      last = source;
    }
    BitStringWriter edges;
    for (const core::SplitEvent& event : fields_.split_events) edges.bits(event.right_edge != 0 ? 1 : 0, 1);
    const std::vector<uint8_t> bytes = edges.take();
    out_.insert(out_.end(), bytes.begin(), bytes.end());
    return {};
  }

  Status standard_symbols() {
    if (fields_.symbols.size() != fields_.symbol_count) return contradiction();
    BitStringWriter bits;
    for (const uint8_t symbol : fields_.symbols) bits.bits(symbol & 7u, symbol == core::kC ? 1 : 3);
    append_block(bits.take(), out_);
    return {};
  }

  void symbol_lists() {
    const bool has_levels = fields_.symbol_level != kLevelBeforeLevels;
    for (const std::vector<uint8_t>& list : fields_.symbol_lists) {
      append_varint(list.size(), out_);
      const std::vector<uint32_t> symbols(list.begin(), list.end());
      table_bytes_ += encode_symbols(symbols, 1, has_levels ? kDefaultSymbolLevel : kLevelBeforeLevels, out_);
    }
  }

  bool next_attribute() { return attribute_count_++ < fields_.attributes.size(); }
  const AttributeFields& attribute() const { return fields_.attributes[attribute_count_ - 1]; }

  const DracoFields& fields_;
  Literals literals_;
  std::vector<uint8_t> out_;
  size_t attribute_count_ = 0;  // attributes that are written or being written
  size_t table_bytes_ = 0;
};

}  // namespace

Expected<std::vector<uint8_t>> write_fields(const DracoFields& fields, size_t* table_bytes) {
  FieldsWriter writer(fields);
  Expected<std::vector<uint8_t>> bytes = writer.write();
  if (table_bytes != nullptr) *table_bytes = writer.table_bytes();
  return bytes;
}

}  // namespace psplit
