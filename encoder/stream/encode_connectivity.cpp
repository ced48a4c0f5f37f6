#include "encoder/stream/encode_connectivity.h"

#include <algorithm>

#include "encoder/fields/symbol_lists.h"
#include "encoder/stream/attribute_plan.h"
#include "encoder/stream/traverse_faces.h"
#include "src/container/claims.h"
#include "src/core/seam_decoder.h"

namespace psplit {
namespace {

using core::Fault, core::kNone;

// Symbols for core::add_faces.
class KnownSymbols {
 public:
  explicit KnownSymbols(const uint8_t* symbols) : symbols_(symbols) {}
  uint32_t next(uint32_t) { return *symbols_++; }
  void added(uint32_t, uint32_t, uint32_t, uint32_t) {}
  void merged(uint32_t, uint32_t) {}

 private:
  const uint8_t* symbols_;
};

class KnownStartFaces {
 public:
  explicit KnownStartFaces(const std::vector<uint8_t>& flags) : flags_(flags.data()) {}
  bool next() { return *flags_++ != 0; }

 private:
  const uint8_t* flags_;
};

class ConnectivityEncoder {
 public:
  ConnectivityEncoder(const SourceMesh& mesh, const ConnectivityChoices& choices)
      : mesh_(mesh), choices_(choices) {
    if (!choices_.one_table) header_.attribute_data_count = static_cast<uint32_t>(mesh.values.size()) - 1;
  }

  Expected<EncodedConnectivity> encode() {
    if (Status status = traverse(); !status.ok()) return status;
    Fault fault = take_memory();
    if (fault == Fault::kNone) fault = decode_mesh();
    if (fault == Fault::kNone) fault = find_seams();
    if (fault == Fault::kNone) fault = find_groups();
    if (fault != Fault::kNone) return status_of(fault);
    return std::move(out_);
  }

 private:
  using Group = core::Group<uint32_t>;
  using Seams = core::SeamDecoder<uint32_t>;

  // Fills all fields except lists and seams.
  Status traverse() {
    std::vector<uint32_t> points;
    std::span<const uint32_t> vertex_of_point = mesh_.values[0];
    if (choices_.one_table) {
      points.resize(mesh_.point_count);
      for (uint32_t point = 0; point < mesh_.point_count; ++point) points[point] = point;
      vertex_of_point = points;
    }
    SourceTable table(mesh_.faces, vertex_of_point, mesh_.point_count, mesh_.neighbours);
    if (table.flat_count() == table.face_count()) return invalid_input("all faces use a vertex twice");
    Traversal traversal = traverse_faces(table);
    DracoFields& fields = out_.fields;
    fields.vertex_count = table.vertex_count();
    fields.face_count = table.face_count() - table.flat_count();
    fields.symbol_count = static_cast<uint32_t>(traversal.symbols.size());
    fields.symbols = std::move(traversal.symbols);
    fields.split_events = std::move(traversal.split_events);
    fields.start_faces = std::move(traversal.start_faces);
    take_points(traversal.corners);
    core::ConnectivityCounts& counts = header_.counts;
    counts.face_count = fields.face_count;
    counts.symbol_count = fields.symbol_count;
    counts.split_count = static_cast<uint32_t>(fields.split_events.size());
    const auto splits = static_cast<uint32_t>(std::ranges::count(fields.symbols, core::kS));
    return status_of(core::finish_edgebreaker_counts(fields.vertex_count, splits, counts));
  }

  // `corners` are the source's, of corner 0 of each face.
  void take_points(const std::vector<uint32_t>& corners) {
    out_.point_of_corner.resize(4 * corners.size());
    for (size_t i = 0; i < corners.size(); ++i) {
      const std::array<uint32_t, 3>& face = mesh_.faces[corners[i] >> 2];
      const uint32_t k = corners[i] & 3;
      uint32_t* const points = &out_.point_of_corner[4 * i];
      points[0] = face[k];
      points[1] = face[core::next(k)];
      points[2] = face[core::previous(k)];
    }
  }

  Fault take_memory() {
    using core::Arena;
    const core::ConnectivityCounts& counts = header_.counts;
    const uint64_t corners = uint64_t{3} * counts.face_count, groups = header_.attribute_data_count + 1;
    const size_t connectivity = Valences::bytes(counts) + core::WaitingEdges<uint32_t>::bytes(counts);
    const size_t seams = Seams::bytes(header_, {.points = static_cast<uint32_t>(corners)});
    const size_t sequences = Arena::bytes<core::Group<uint32_t>>(groups) +
                             groups * core::Sequence<uint32_t>::bytes(corners) +
                             core::traverse_bytes<uint32_t>(false, counts.face_count, corners) +
                             core::traverse_bytes<uint32_t>(true, counts.face_count, corners);
    const size_t size = core::Connectivity<uint32_t>::bytes(counts) + connectivity + seams + sequences;
    out_.memory.reset(new uint8_t[size]);
    arena_ = core::Arena(out_.memory.get(), size);
    out_.patch.face_count = counts.face_count;
    out_.patch.mesh.counts = counts;
    return out_.patch.mesh.allocate(arena_) ? Fault::kNone : Fault::kWorkspace;
  }

  // The decoder's corner table and, on the way, the lists of symbols.
  Fault decode_mesh() {
    DracoFields& fields = out_.fields;
    core::Connectivity<uint32_t>& mesh = out_.patch.mesh;
    const size_t mark = arena_.mark();
    KnownStartFaces start_faces(fields.start_faces);
    const auto decode = [&](const auto& symbols) {
      return core::decode_connectivity(symbols, {fields.split_events.data(), fields.split_events.size()},
                                       start_faces, arena_, mesh);
    };
    Fault fault = Fault::kNone;
    if (choices_.valence) {
      Valences valences;
      std::vector<uint8_t> lists(fields.symbols.size());
      fault = valences.start(mesh.counts, arena_);
      if (fault == Fault::kNone) fault = decode(NotedLists(valences, fields.symbols.data(), lists.data()));
      if (fault == Fault::kNone) fill_lists(lists, fields);
    } else {
      fault = decode(KnownSymbols(fields.symbols.data()));
    }
    if (fault != Fault::kNone) return fault;
    arena_.release(mark);
    // As the decoder does it.
    if (header_.attribute_data_count > 0)
      mesh.move_up(core::SerialLanes());
    else
      mesh.fill_holes();
    mesh.find_closed_vertices(core::SerialLanes());
    out_.patch.point_at = mesh.table.vertex;
    out_.patch.point_count = mesh.vertex_count;
    return mesh.vertex_count == fields.vertex_count ? Fault::kNone : Fault::kConnectivity;
  }

  // An edge is a seam of an attribute if the points of its two faces have different values at one of its ends.
  Fault find_seams() {
    if (header_.attribute_data_count == 0) return Fault::kNone;
    core::Patch<uint32_t>& patch = out_.patch;
    if (const Fault fault = seams_.start(header_.attribute_data_count, patch.mesh, arena_);
        fault != Fault::kNone)
      return fault;
    const std::vector<uint32_t>& points = out_.point_of_corner;
    const core::View<const uint32_t> edges = seams_.edges(), opposite = patch.mesh.table.opposite;
    std::vector<std::vector<uint8_t>>& flags = out_.fields.seams;
    flags.assign(header_.attribute_data_count, std::vector<uint8_t>(edges.size()));
    for (size_t i = 0; i < edges.size(); ++i) {
      using core::next, core::previous;
      const uint32_t corner = edges[i], across = opposite[corner];
      const uint32_t a = points[next(corner)], b = points[previous(across)], c = points[previous(corner)],
                     d = points[next(across)];
      if (a == b && c == d) continue;
      for (size_t data = 0; data < flags.size(); ++data) {
        const std::span<const uint32_t> value = mesh_.values[data + 1];
        flags[data][i] = value[a] != value[b] || value[c] != value[d];
      }
    }
    for (uint32_t data = 0; data < flags.size(); ++data)
      std::ranges::copy(flags[data], seams_.seams_of(data).data());
    return seams_.finish(arena_, patch);
  }

  // One group has all attributes that share one table; otherwise each attribute has a group of its own.
  Fault find_groups() {
    core::Patch<uint32_t>& patch = out_.patch;
    const auto count = static_cast<uint32_t>(mesh_.values.size());
    if (!arena_.take(patch.groups, choices_.one_table ? 1 : count)) return Fault::kWorkspace;
    for (uint32_t g = 0; g < patch.groups.size(); ++g) {
      Group& group = patch.groups[g];
      group = {};
      group.first = g;
      group.count = choices_.one_table ? count : 1;
      group.attribute_data = static_cast<int8_t>(static_cast<int>(g) - 1);
      group.table = {patch.mesh.table, patch.mesh.closed, patch.mesh.vertex_count, false};
      if (g == 0)
        group.by_prediction_degree = choices_.by_degree;
      else
        group.table = seams_.tables()[g - 1];
      group.per_corner = group.table.has_seams;
      if (const Fault fault = find_sequence(group); fault != Fault::kNone) return fault;
    }
    return Fault::kNone;
  }
  Fault find_sequence(Group& group) {
    for (const Group* other = out_.patch.groups.data(); other != &group; ++other) {
      if (other->by_prediction_degree != group.by_prediction_degree ||
          other->table.table.opposite.data() != group.table.table.opposite.data())
        continue;
      group.sequence = other->sequence;
      return Fault::kNone;
    }
    if (!group.sequence.allocate(group.table.vertex_count, arena_)) return Fault::kWorkspace;
    return core::traverse(group.table, group.by_prediction_degree, arena_, group.sequence);
  }

  const SourceMesh& mesh_;
  const ConnectivityChoices choices_;
  core::StreamHeader header_;
  core::Arena arena_;
  Seams seams_;
  EncodedConnectivity out_;
};

}  // namespace

ConnectivityChoices choose_connectivity(int speed, uint64_t face_count) {
  constexpr uint64_t kFewFaces = 1000;
  return {.valence = speed < 5 && face_count >= kFewFaces,
          .one_table = speed >= kSpeedOfOneTable,
          .by_degree = speed == kSpeedByDegree};
}

Expected<EncodedConnectivity> encode_connectivity(const SourceMesh& mesh, const ConnectivityChoices& choices) {
  // Each fan of faces may need a vertex of its own.
  const uint64_t faces = mesh.faces.size(), most_vertices = mesh.point_count + 3 * faces;
  if (faces >= core::kMaxFaces<uint32_t> || most_vertices > 0xfffffff0u)
    return unsupported(std::to_string(faces) + " faces are too many for one stream");
  if (!choices.one_table && mesh.values.size() > core::kMaxAttributeData + 1)
    return unsupported(std::to_string(mesh.values.size()) + " attributes; a stream has at most " +
                       std::to_string(core::kMaxAttributeData + 1));
  return ConnectivityEncoder(mesh, choices).encode();
}

}  // namespace psplit
