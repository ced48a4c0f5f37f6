#include <algorithm>
#include <memory>

#include "encoder/fields/draco_fields.h"
#include "encoder/fields/entropy_encoder.h"
#include "encoder/fields/stream_layout.h"
#include "encoder/fields/symbol_lists.h"
#include "src/core/edgebreaker_decoder.h"
#include "src/core/seams.h"
#include "src/core/symbols.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

using core::Fault;

// Reads fields, for StreamLayout.
class FieldsReader {
 public:
  FieldsReader(std::span<const uint8_t> stream, const core::StreamHeader& header)
      : header_(header),
        literals_(stream),
        bytes_left_(core::justified_bytes(stream.size())),
        size_(stream.size()) {
    fields_.possible_levels = (2u << kLevelBeforeLevels) - 1;
  }

  Expected<DracoFields> read() {
    // The arena is needed for the connectivity first, then for its seams, and for one table of symbols at a
    // time.
    const size_t symbols =
        core::SymbolSequence::bytes(1, ~uint64_t{0}) + core::RansTable::slot_bytes(~uint64_t{0}, size_);
    const size_t arena_bytes = symbols + connectivity_bytes();
    if (!claim(arena_bytes)) return status_of(Fault::kWorkspace);
    memory_.reset(new uint8_t[arena_bytes]);
    arena_ = core::Arena(memory_.get(), arena_bytes);
    if (Status status = StreamLayout(*this).walk(); !status.ok()) return status;
    literals_.skip(literals_.remaining());
    literals_.copy_to(fields_.skeleton);
    for (int level = kLevelBeforeLevels; level >= 0; --level)
      if ((fields_.possible_levels >> level & 1) != 0) fields_.symbol_level = level;
    return std::move(fields_);
  }

  Literals& literals() { return literals_; }

  Status counts() {
    literals_.copy_to(fields_.skeleton);
    fields_.vertex_count = literals_.varint();
    fields_.face_count = literals_.varint();
    literals_.leave_out();
    return {};
  }

  Status connectivity(bool is_valence, uint32_t data_count) {
    literals_.copy_to(fields_.skeleton);
    fields_.symbol_count = literals_.varint();
    literals_.varint();  // the number of S
    literals_.varint();  // the number of split events
    const Status status = status_of(read_connectivity(is_valence, data_count));
    literals_.leave_out();
    return status.ok() && is_valence ? list_symbols(fields_) : status;
  }

  uint32_t value_count(const core::Group<uint32_t>& group) const {
    return group.per_corner ? seam_vertex_counts_[static_cast<size_t>(group.attribute_data)]
                            : mesh_.vertex_count;
  }

  Status raw(uint32_t count, const core::Attribute<uint32_t>& description) {
    literals_.copy_to(fields_.skeleton);
    AttributeFields& attribute = fields_.attributes.emplace_back();
    attribute.count = count;
    attribute.components = description.components;
    attribute.component_bytes = core::data_type_bytes(description.type);
    const uint64_t bytes = uint64_t{count} * description.stride();
    const uint8_t* const head = literals_.head();
    if (!literals_.skip(bytes)) return status_of(Fault::kTruncated);
    attribute.raw.assign(head, head + bytes);
    literals_.leave_out();
    return {};
  }

  Status symbols(uint32_t count, const PredictedAttribute& predicted) {
    const uint32_t components = predicted.attribute.value_components();
    literals_.copy_to(fields_.skeleton);
    AttributeFields& attribute = fields_.attributes.emplace_back();
    attribute.count = count;
    attribute.components = components;
    attribute.skeleton = {predicted.attribute.coding, predicted.scheme, predicted.transform,
                          static_cast<uint8_t>(components), 0};
    const uint64_t total = uint64_t{count} * components;
    if (total > 0xffffffffu || !claim(total * sizeof(uint32_t))) return status_of(Fault::kWorkspace);
    attribute.symbols.resize(static_cast<size_t>(total));
    constexpr uint8_t kRaw = 1;
    const bool is_raw = total > 0 && literals_.remaining() >= 2 && literals_.head()[0] == kRaw;
    const uint32_t symbol_bits = is_raw ? literals_.head()[1] : 0;
    Fault fault = read_symbols(count, components, attribute.symbols);
    if (fault == Fault::kNone && is_raw)
      fields_.possible_levels &= possible_symbol_levels(attribute.symbols, symbol_bits);
    // The numbers of the grid follow directly: normals on a grid have none of the fields that could precede
    // them.
    if (fault == Fault::kNone && attribute.skeleton.has_grid()) {
      core::PredictionData data;
      data.transform = predicted.transform;
      core::ByteReader ahead = literals_;
      fault = data.read_grid(ahead);
      attribute.grid_size = data.grid.max_quantized();
    }
    literals_.leave_out();
    return status_of(fault);
  }

  Status creases() {
    Fault fault = Fault::kNone;
    for (std::vector<uint8_t>& flags : fields_.attributes.back().creases) {
      const uint32_t count = literals_.varint();
      if (count > 0 && fault == Fault::kNone) fault = read_flags(count, flags);
    }
    literals_.leave_out();
    return status_of(fault);
  }
  Status orientations() {
    const uint32_t count = literals_.u32();
    const Fault fault = read_flags(count, fields_.attributes.back().same_orientations);
    literals_.leave_out();
    return status_of(fault);
  }
  Status wrap() {
    core::WrapRange range;
    const Fault fault = range.read(literals_);
    fields_.attributes.back().wrap_min = range.low;
    fields_.attributes.back().wrap_max = range.high;
    literals_.leave_out();
    return status_of(fault);
  }
  Status flips() {
    literals_.copy_to(fields_.skeleton);
    const uint32_t count = fields_.attributes.back().count;
    Fault fault = Fault::kWorkspace;
    if (claim(count)) {
      core::RansBits bits;
      fault = bits.start(literals_);
      if (fault == Fault::kNone) append_flags(bits, count, fields_.attributes.back().flips);
    }
    literals_.leave_out();
    return status_of(fault);
  }

 private:
  using ListedSymbols = core::ValenceSymbols<uint32_t>;

  // Takes `bytes` of the memory that the stream's size justifies. Returns false if less is left.
  bool claim(uint64_t bytes) {
    if (bytes > bytes_left_) return false;
    bytes_left_ -= bytes;
    return true;
  }

  size_t connectivity_bytes() const {
    const core::ConnectivityCounts& counts = header_.counts;
    const uint64_t corners = uint64_t{3} * counts.face_count, vertices = counts.vertex_limit;
    using core::Arena, core::EdgebreakerDecoder;
    const size_t seams = 2 * Arena::bytes<uint32_t>(corners) + Arena::bytes<uint8_t>(corners) +
                         Arena::bytes<bool>(vertices) + Arena::bytes<uint32_t>(vertices) +
                         core::AttributeTable<uint32_t>::bytes(counts.face_count);
    return EdgebreakerDecoder<uint32_t>::bytes(header_) + EdgebreakerDecoder<uint32_t>::scratch_bytes(header_) +
           (header_.attribute_data_count > 0 ? seams : 0);
  }

  static void append_flags(core::RansBits& bits, uint32_t count, std::vector<uint8_t>& flags) {
    flags.resize(count);
    for (uint8_t& flag : flags) flag = static_cast<uint8_t>(bits.next_fast());
  }
  // No scheme has more flags than there are corners.
  Fault read_flags(uint32_t count, std::vector<uint8_t>& flags) {
    if (count > 3 * header_.counts.face_count) return Fault::kPrediction;
    if (!claim(count)) return Fault::kWorkspace;
    core::RansBits bits;
    const Fault fault = bits.start(literals_);
    if (fault == Fault::kNone) append_flags(bits, count, flags);
    return fault;
  }

  Fault read_symbols(uint32_t count, uint32_t components, std::vector<uint32_t>& out) {
    const size_t mark = arena_.mark();
    core::SymbolSequence sequence;
    Fault fault = sequence.start(literals_, count, components, arena_, {out.data(), out.size()});
    if (fault == Fault::kNone) {
      core::SymbolSequence* const one = &sequence;
      core::step_symbols<1>(&one, 1);
      fault = sequence.finish(core::SerialLanes(), literals_);
    }
    arena_.release(mark);
    return fault;
  }

  Fault read_connectivity(bool is_valence, uint32_t data_count) {
    const core::ConnectivityCounts& counts = header_.counts;
    if (!claim(uint64_t{3} * counts.symbol_count)) return Fault::kWorkspace;
    if (counts.split_count > literals_.remaining() / 2) return Fault::kTruncated;
    fields_.split_events.resize(counts.split_count);
    const core::View<core::SplitEvent> events(fields_.split_events.data(), counts.split_count);
    Fault fault = core::read_split_events(literals_, counts.symbol_count, events);
    if (fault != Fault::kNone) return fault;
    core::BitReader symbols;
    if (!is_valence) {
      const uint64_t size = literals_.varint64();
      symbols = core::BitReader(literals_.head(), literals_.remaining());
      if (!literals_.skip(size)) return Fault::kTruncated;
    }
    core::RansBits start_faces;
    fault = start_faces.start(literals_);
    std::vector<core::RansBits> seams(data_count);
    for (core::RansBits& bits : seams)
      if (fault == Fault::kNone) fault = bits.start(literals_);
    if (fault == Fault::kNone) fault = decode_mesh(is_valence, symbols, events, start_faces);
    return fault == Fault::kNone ? read_seams(seams) : fault;
  }

  Fault decode_mesh(bool is_valence, core::BitReader bits, core::View<const core::SplitEvent> events,
                    core::RansBits start_faces) {
    mesh_.counts = header_.counts;
    fields_.symbols.resize(mesh_.counts.symbol_count);
    if (!mesh_.allocate(arena_)) return Fault::kWorkspace;
    const size_t mark = arena_.mark();
    core::RansBits again = start_faces;
    const auto decode = [&](const auto& symbols) {
      return core::decode_connectivity(StoredSymbols(symbols, fields_.symbols.data()), events, again, arena_,
                                       mesh_);
    };
    ListedSymbols lists;
    Fault fault = Fault::kNone;
    if (is_valence) fault = read_lists(lists);
    if (fault == Fault::kNone) fault = is_valence ? decode(lists) : decode(core::StandardSymbols(bits));
    if (fault != Fault::kNone) return fault;
    arena_.release(mark);
    mesh_.move_up(core::SerialLanes());
    mesh_.find_closed_vertices(core::SerialLanes());
    append_flags(start_faces, component_count(fields_), fields_.start_faces);
    return Fault::kNone;
  }

  Fault read_lists(ListedSymbols& lists) {
    core::View<core::SymbolSequence> sequences;
    if (!arena_.take(sequences, ListedSymbols::kLists)) return Fault::kWorkspace;
    const Fault fault = lists.start(literals_, header_.counts, arena_, sequences);
    if (fault != Fault::kNone) return fault;
    for (size_t i = 0; i < sequences.size(); ++i) {
      core::SymbolSequence* const one = &sequences[i];
      core::step_symbols<1>(&one, 1);
    }
    return lists.finish(literals_, sequences);
  }

  Fault read_seams(std::vector<core::RansBits>& seams) {
    fields_.seams.resize(seams.size());
    seam_vertex_counts_.assign(seams.size(), mesh_.vertex_count);
    if (seams.empty()) return Fault::kNone;
    core::View<uint32_t> edges, around, scratch;
    core::View<uint8_t> changes;
    core::View<bool> on_seam;
    const uint64_t corner_count = uint64_t{3} * header_.counts.face_count;
    if (!arena_.take(edges, corner_count) || !arena_.take(around, corner_count) ||
        !arena_.take(changes, corner_count) || !arena_.take(scratch, mesh_.vertex_count) ||
        !arena_.take(on_seam, mesh_.vertex_count))
      return Fault::kWorkspace;
    const uint32_t edge_count = core::list_inner_edges(mesh_.table, edges);
    edges = edges.first(edge_count);
    for (size_t i = 0; i < seams.size(); ++i) {
      std::vector<uint8_t>& flags = fields_.seams[i];
      if (!claim(edge_count)) return Fault::kWorkspace;
      append_flags(seams[i], edge_count, flags);
      core::AttributeTable<uint32_t> table;
      const size_t mark = arena_.mark();
      core::fill(on_seam, false);
      const Fault fault = core::cut_seams(mesh_, edges, {flags.data(), flags.size()}, arena_, table, on_seam);
      if (fault != Fault::kNone) return fault;
      core::AttributeTable<uint32_t>* const one = &table;
      if (table.has_seams)
        core::VertexSplit<uint32_t>(mesh_, around, changes, scratch).split(&one, 1, on_seam, {});
      seam_vertex_counts_[i] = table.vertex_count;
      arena_.release(mark);
    }
    return Fault::kNone;
  }

  const core::StreamHeader& header_;
  Literals literals_;
  uint64_t bytes_left_;
  size_t size_;
  std::unique_ptr<uint8_t[]> memory_;
  core::Arena arena_;
  core::Connectivity<uint32_t> mesh_;
  std::vector<uint32_t> seam_vertex_counts_;  // by attribute data
  DracoFields fields_;
};

}  // namespace

Expected<DracoFields> read_fields(std::span<const uint8_t> stream) {
  core::StreamHeader header;
  if (const Fault fault = core::read_stream_header(stream.data(), stream.size(), header); fault != Fault::kNone)
    return status_of(fault);
  if (!header.edgebreaker) return unsupported("a sequential mesh");
  return FieldsReader(stream, header).read();
}

}  // namespace psplit
