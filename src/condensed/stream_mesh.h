// The mesh of an Edgebreaker stream, for those who need its corner tables and the order of its values, but not
// its values.
#pragma once

#include <memory>
#include <vector>

#include "src/condensed/entropy_encoder.h"
#include "src/condensed/symbol_lists.h"
#include "src/core/border_walk.h"
#include "src/core/edgebreaker.h"
#include "src/core/traversal.h"

namespace psplit {

class StreamMesh {
 public:
  StreamMesh(const core::ConnectivityCounts& counts, uint32_t data_count) : data_count_(data_count) {
    mesh_.counts = counts;
  }
  // The memory that this takes at most.
  uint64_t bytes() const {
    using core::Arena;
    const uint64_t vertices = mesh_.counts.vertex_limit, corners = uint64_t{3} * mesh_.counts.face_count;
    const uint64_t table = core::AttributeTable<uint32_t>::bytes(mesh_.counts.face_count);
    // A group without attribute data, and one for each of these.
    const uint64_t sequences =
        core::Sequence<uint32_t>::bytes(vertices) + data_count_ * core::Sequence<uint32_t>::bytes(corners);
    const uint64_t walk = std::max(
        core::DepthFirstTraversal<uint32_t>::bytes(mesh_.counts.face_count),
        core::PredictionDegreeTraversal<uint32_t>::bytes(mesh_.counts.face_count, std::max(corners, vertices)));
    // Points, and their walk.
    const uint64_t points = Arena::bytes<uint32_t>(4 * uint64_t{mesh_.counts.face_count}) +
                            Arena::bytes<uint32_t>(corners) +
                            core::border_walk_bytes<uint32_t>(std::max(corners, vertices));
    return core::Connectivity<uint32_t>::bytes(mesh_.counts) + Valences::bytes(mesh_.counts) +
           core::connectivity_scratch_bytes<uint32_t>(mesh_.counts) + Arena::bytes<uint32_t>(corners) +
           2 * Arena::bytes<bool>(vertices) + Arena::bytes<uint32_t>(vertices) + data_count_ * table +
           sequences + walk + points;
  }
  // To be called first. Takes all memory.
  void allocate() {
    const auto size = static_cast<size_t>(bytes());
    memory_.reset(new uint8_t[size]);
    arena_ = core::Arena(memory_.get(), size);
  }

  // Decodes the connectivity. make_symbols(valences) returns the symbols for core::add_faces; `valences` are
  // started. `start_faces` has a flag for each component.
  template <typename MakeSymbols>
  core::Fault decode(MakeSymbols make_symbols, core::View<const core::SplitEvent> events,
                     const std::vector<uint8_t>& start_faces) {
    std::vector<uint8_t> flags;
    encode_flags(start_faces, flags);
    core::ByteReader reader(flags.data(), flags.size());
    core::RansBits start_face_bits;
    Valences valences;
    core::Fault fault = start_face_bits.start(reader);
    if (fault != core::Fault::kNone) return fault;
    if (!mesh_.allocate(arena_)) return core::Fault::kWorkspace;
    fault = valences.start(mesh_.counts, arena_);
    if (fault != core::Fault::kNone) return fault;
    fault = core::decode_connectivity(make_symbols(valences), events, start_face_bits, arena_, mesh_);
    if (fault != core::Fault::kNone) return fault;
    // As the decoder does: the numbers of points depend on it.
    mesh_.drop_merged_vertices(/*keep_order=*/data_count_ > 0);
    return list_edges();
  }

  // Edges between two faces: the number of flags for seams of each attribute data.
  uint32_t edge_count() const { return static_cast<uint32_t>(edges_.size()); }

  // To be called for each attribute data in order.
  core::Fault cut(std::vector<uint8_t>& seams) {
    core::AttributeTable<uint32_t>& table = tables_.emplace_back();
    const core::Fault fault =
        core::cut_seams(mesh_, edges_, {seams.data(), seams.size()}, arena_, table, on_seam_);
    if (fault != core::Fault::kNone || !table.has_seams) return fault;
    core::number_attribute_vertices(mesh_, on_seam_, scratch_, table);
    for (size_t v = 0; v < on_seam_.size(); ++v) on_any_seam_[v] |= on_seam_[v];
    has_seams_ = true;
    return fault;
  }

  // The vertices of a group's table at the places of the border walk. To be called at most once, after all
  // seams.
  core::Fault find_walk(const core::Group<uint32_t>& group, std::vector<uint32_t>& vertices) {
    core::Patch<uint32_t> patch;
    patch.face_count = mesh_.counts.face_count;
    patch.mesh = mesh_;
    patch.point_at = mesh_.table.vertex;
    patch.point_count = mesh_.vertex_count;
    if (has_seams_) {
      patch.on_seam = on_any_seam_;
      if (!arena_.take(patch.point_at, mesh_.table.vertex.size())) return core::Fault::kWorkspace;
      patch.point_count = core::split_into_points(mesh_, {tables_.data(), tables_.size()}, on_any_seam_,
                                                  scratch_, patch.point_at);
      if (!arena_.take(patch.corner_of_point, patch.point_count)) return core::Fault::kWorkspace;
      for (uint32_t c = 0; c < patch.point_at.size(); ++c)
        if ((c & 3) != 3) patch.corner_of_point[patch.point_at[c]] = c;
    }
    core::View<uint32_t> walk;
    if (const core::Fault fault = core::walk_border(patch, arena_, walk); fault != core::Fault::kNone)
      return fault;
    for (size_t place = 0; place < walk.size(); ++place)
      vertices.push_back(has_seams_ ? table(group).table.vertex[patch.corner_of_point[walk[place]]]
                                    : walk[place]);
    return core::Fault::kNone;
  }

  core::AttributeTable<uint32_t> table(const core::Group<uint32_t>& group) const {
    if (group.per_corner) return tables_[static_cast<size_t>(group.attribute_data)];
    return {mesh_.table, mesh_.closed, mesh_.vertex_count, false};
  }

  // The order of the values of a group. To be called once for each group.
  core::Fault find_sequence(const core::Group<uint32_t>& group, core::Sequence<uint32_t>& out) {
    const core::AttributeTable<uint32_t> walked = table(group);
    if (!out.allocate(walked.vertex_count, arena_)) return core::Fault::kWorkspace;
    if (group.by_prediction_degree) return core::traverse_by_prediction_degree(walked, arena_, out);
    const size_t mark = arena_.mark();
    core::DepthFirstTraversal<uint32_t> walk;
    if (const core::Fault fault = walk.start(walked, arena_, out); fault != core::Fault::kNone) return fault;
    while (walk.running()) walk.step();
    arena_.release(mark);
    return walk.finish();
  }

 private:
  core::Fault list_edges() {
    if (!arena_.take(edges_, size_t{3} * mesh_.counts.face_count) ||
        !arena_.take(on_seam_, mesh_.vertex_count) || !arena_.take(on_any_seam_, mesh_.vertex_count) ||
        !arena_.take(scratch_, mesh_.vertex_count))
      return core::Fault::kWorkspace;
    core::fill(on_any_seam_, false);
    edges_ = edges_.first(core::list_inner_edges(mesh_.table, edges_));
    return core::Fault::kNone;
  }

  uint32_t data_count_;
  std::unique_ptr<uint8_t[]> memory_;
  core::Arena arena_;
  core::Connectivity<uint32_t> mesh_;
  core::View<uint32_t> edges_, scratch_;
  core::View<bool> on_seam_, on_any_seam_;
  bool has_seams_ = false;
  std::vector<core::AttributeTable<uint32_t>> tables_;  // by attribute data
};

}  // namespace psplit
