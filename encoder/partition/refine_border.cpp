#include "encoder/partition/refine_border.h"

#include <algorithm>
#include <utility>

namespace psplit {
namespace {

constexpr int kPasses = 2;
// Moves in a row that lead to nothing better before a search gives up.
constexpr size_t kPatience = 15;
// Edges that a face above a patch's limit is worth.
constexpr double kExcessPrice = 0.6;
// Cells that are looked at around one that leaves its patch. Around a vertex there are six faces.
constexpr size_t kWalk = 24;

class Refinement {
 public:
  Refinement(const CellGraph& graph, std::span<const uint32_t> face_limits, std::vector<uint32_t>& patch_of)
      : graph_(graph),
        patch_of_(patch_of),
        excess_(face_limits.size()),
        cell_counts_(face_limits.size()),
        marks_(graph.cell_count()) {
    for (size_t p = 0; p < face_limits.size(); ++p) excess_[p] = -int64_t{face_limits[p]};
    for (uint32_t c = 0; c < graph.cell_count(); ++c) {
      excess_[patch_of[c]] += graph.face_counts[c];
      ++cell_counts_[patch_of[c]];
    }
  }

  void run() {
    std::vector<uint32_t> seeds;
    for (uint32_t c = 0; c < graph_.cell_count(); ++c)
      if (is_on_border(c)) seeds.push_back(c);
    for (pass_ = 1; pass_ <= kPasses; ++pass_) {
      for (const uint32_t seed : seeds) search(seed);
      // Where nothing has changed a second search would find nothing.
      seeds = std::exchange(changed_, {});
      std::sort(seeds.begin(), seeds.end());
      seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
    }
  }

 private:
  struct Move {
    uint32_t cell = 0;
    uint32_t to = 0;
    int64_t gain = 0;  // edges no longer cut
  };
  static bool is_worse(const Move& a, const Move& b) {
    return a.gain != b.gain ? a.gain < b.gain : a.cell < b.cell;
  }
  // Pass and walks that a cell was last part of.
  struct Marks {
    int moved = 0;
    uint32_t to_reach = 0;
    uint32_t reached = 0;
  };

  bool is_on_border(uint32_t cell) const {
    for (const CellGraph::Link& link : graph_.around(cell))
      if (patch_of_[link.cell] != patch_of_[cell]) return true;
    return false;
  }

  // The best move that balance allows, or one to where the cell already is.
  Move best_move(uint32_t cell) {
    const uint32_t own = patch_of_[cell];
    Move best{cell, own, 0};
    if (cell_counts_[own] == 1) return best;
    int64_t inside = 0;
    sides_.clear();
    for (const CellGraph::Link& link : graph_.around(cell)) {
      const uint32_t patch = patch_of_[link.cell];
      if (patch == own) {
        inside += link.edges;
        continue;
      }
      auto side = std::find_if(sides_.begin(), sides_.end(), [&](const Move& m) { return m.to == patch; });
      if (side == sides_.end()) side = sides_.insert(side, Move{cell, patch, 0});
      side->gain += link.edges;
    }
    for (const Move& side : sides_) {
      const int64_t excess = excess_[side.to] + graph_.face_counts[cell];
      if (excess > 0 && excess >= excess_[own]) continue;
      if (best.to == own || side.gain > best.gain ||
          (side.gain == best.gain && excess_[side.to] < excess_[best.to]))
        best = side;
    }
    best.gain -= inside;
    return best;
  }

  // Whether the patch of a cell stays connected without it, as far as a short walk around the cell tells.
  bool can_leave(uint32_t cell) {
    ++walk_;
    queue_.clear();
    size_t missing = 0;
    for (const CellGraph::Link& link : graph_.around(cell)) {
      if (patch_of_[link.cell] != patch_of_[cell]) continue;
      if (std::exchange(marks_[link.cell].to_reach, walk_) == walk_) continue;
      if (missing++ == 0) queue_.push_back(link.cell);
    }
    if (missing <= 1) return true;
    marks_[cell].reached = marks_[queue_[0]].reached = walk_;
    --missing;
    for (size_t i = 0; i < std::min(queue_.size(), kWalk); ++i)
      for (const CellGraph::Link& link : graph_.around(queue_[i])) {
        if (patch_of_[link.cell] != patch_of_[cell]) continue;
        if (std::exchange(marks_[link.cell].reached, walk_) == walk_) continue;
        if (marks_[link.cell].to_reach == walk_ && --missing == 0) return true;
        queue_.push_back(link.cell);
      }
    return false;
  }

  int64_t excess_of(uint32_t a, uint32_t b) const {
    return std::max<int64_t>(excess_[a], 0) + std::max<int64_t>(excess_[b], 0);
  }

  // Returns how many faces fewer are above limits.
  int64_t put(uint32_t cell, uint32_t to) {
    const uint32_t from = std::exchange(patch_of_[cell], to);
    const int64_t before = excess_of(from, to);
    excess_[from] -= graph_.face_counts[cell];
    excess_[to] += graph_.face_counts[cell];
    --cell_counts_[from];
    ++cell_counts_[to];
    return before - excess_of(from, to);
  }

  void offer(const Move& move) {
    if (marks_[move.cell].moved == pass_ || move.to == patch_of_[move.cell]) return;
    offers_.push_back(move);
    std::push_heap(offers_.begin(), offers_.end(), is_worse);
  }

  Move best_offer() {
    std::pop_heap(offers_.begin(), offers_.end(), is_worse);
    const Move move = offers_.back();
    offers_.pop_back();
    return move;
  }

  void search(uint32_t seed) {
    offers_.clear();
    offer(best_move(seed));
    made_.clear();
    size_t best_count = 0;
    double value = 0, best_value = 0;
    while (!offers_.empty() && made_.size() < best_count + kPatience) {
      const Move offered = best_offer();
      if (marks_[offered.cell].moved == pass_) continue;
      const Move move = best_move(offered.cell);
      if (move.gain < offered.gain) {
        offer(move);
        continue;
      }
      const uint32_t own = patch_of_[move.cell];
      if (move.to == own || !can_leave(move.cell)) continue;
      marks_[move.cell].moved = pass_;
      made_.push_back({move.cell, own, -move.gain});
      const int64_t balanced = put(move.cell, move.to);
      value += static_cast<double>(move.gain) + kExcessPrice * static_cast<double>(balanced);
      if (value > best_value) {
        best_value = value;
        best_count = made_.size();
      }
      for (const CellGraph::Link& link : graph_.around(move.cell))
        if (marks_[link.cell].moved != pass_) offer(best_move(link.cell));
    }
    for (; made_.size() > best_count; made_.pop_back()) {
      marks_[made_.back().cell].moved = 0;
      put(made_.back().cell, made_.back().to);
    }
    for (const Move& move : made_) {
      changed_.push_back(move.cell);
      for (const CellGraph::Link& link : graph_.around(move.cell)) changed_.push_back(link.cell);
    }
  }

  const CellGraph& graph_;
  std::vector<uint32_t>& patch_of_;
  std::vector<int64_t> excess_;  // faces of each patch above its limit
  std::vector<uint32_t> cell_counts_;
  std::vector<Marks> marks_;
  int pass_ = 0;
  uint32_t walk_ = 0;
  std::vector<uint32_t> queue_, changed_;
  std::vector<Move> sides_, offers_;
  std::vector<Move> made_;  // turned round
};

}  // namespace

void refine_border(const CellGraph& graph, std::span<const uint32_t> face_limits,
                   std::vector<uint32_t>& patch_of) {
  Refinement(graph, face_limits, patch_of).run();
}

}  // namespace psplit
