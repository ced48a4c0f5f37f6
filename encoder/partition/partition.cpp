#include "encoder/partition/partition.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "encoder/partition/cell_graph.h"
#include "encoder/partition/paper_method.h"
#include "encoder/partition/partition_steps.h"

namespace psplit {
namespace {

// A cell of a later level has about kMembers cells of the level before.
constexpr uint32_t kMembers = 2;
// Coarsening ends at about this many cells per patch.
constexpr uint32_t kCellsPerPatch = 20;
// How borders are cut anew at four kinds of levels: `middle` at the first cells, unless they are the only level
// of cells; `coarse` where a patch has fewer than kCoarseCells cells, and at an only level; `finer` at the
// other levels whose cells have more than `finer_faces` faces; `fine` at faces. Bands are wide at levels with
// few cells, and narrow at levels with many.
constexpr uint32_t kCoarseCells = 160;
constexpr RecutOptions kNoCuts{0, 0};
struct Recuts {
  uint32_t first_faces;  // of a first cell, about
  uint32_t finer_faces;
  RecutOptions coarse, finer, middle, fine;
};

// The plan for patches of about `share` faces. Small patches have less spare room, so their borders take more
// rounds. In large ones a band with the same share of the faces is wider, and more of the border is drawn in
// coarse cells, which the paper's method does not have. Of the largest, the border is about one point of a
// hundred: there it pays to cut it coarsely.
Recuts recuts_for(double share, PartitionMethod method) {
  constexpr double kSmallPatch = 800, kMiddlePatch = 2400, kLargePatch = 9600, kWidePatch = 4800;

  if (share < kSmallPatch) return {8, 0, {3, 4}, kNoCuts, {2, 2}, {3, 2}};
  if (method == PartitionMethod::kPaper) return {8, 0, {3, 4}, kNoCuts, {1, 2}, {2, 2}};
  if (share < kMiddlePatch) return {16, 0, {3, 4}, kNoCuts, {1, 2}, {2, 2}};
  const double width = std::min(1.0, std::sqrt(kWidePatch / share));
  if (share < kLargePatch) return {16, 30, {3, 3}, {3, 3}, {2, 2 * width}, {1, 2 * width}};
  return {32, 60, {3, 3}, {1, 3}, {1, 2 * width}, {1, width}};
}

// No cell has more than this share of a patch's faces.
constexpr double kLargestCell = 0.15;
// The faces of the largest patch divided by the mean. A tighter limit leaves less room for shorter borders.
constexpr double kBalance = 1.05;
// No patch starts with more than this many shares. A share is the number of faces divided by that of patches.
constexpr double kLargestStart = 1.1;

// Graphs of larger and larger cells. coarse_of[i] has for each cell of graphs[i] its cell in graphs[i + 1].
struct Levels {
  std::vector<CellGraph> graphs;
  std::vector<std::vector<uint32_t>> coarse_of;
};

Levels coarsen(CellGraph cells, uint32_t patch_count, uint32_t face_limit, const ThreadPool& pool) {
  Levels levels;
  levels.graphs.push_back(std::move(cells));
  while (levels.graphs.back().cell_count() > uint64_t{kCellsPerPatch} * patch_count) {
    const uint32_t cell_count = levels.graphs.back().cell_count();
    Coarsening coarsening = grow_cells(levels.graphs.back(), kMembers, face_limit, pool);
    if (coarsening.count > cell_count - cell_count / 20) break;  // few cells find a partner
    levels.graphs.push_back(contract(levels.graphs.back(), coarsening, pool));
    levels.coarse_of.push_back(std::move(coarsening.coarse_of));
  }
  return levels;
}

struct Component {
  std::vector<uint32_t> cells;
  uint64_t face_count = 0;
};

// The largest component first; components of equal size in the order of their first cells.
std::vector<Component> connected_components(const CellGraph& graph) {
  std::vector<Component> components;
  std::vector<uint8_t> seen(graph.cell_count(), 0);
  for (uint32_t start = 0; start < graph.cell_count(); ++start) {
    if (std::exchange(seen[start], uint8_t{1}) != 0) continue;
    Component& component = components.emplace_back(Component{{start}, 0});
    for (size_t i = 0; i < component.cells.size(); ++i) {
      component.face_count += graph.face_counts[component.cells[i]];
      for (const CellGraph::Link& link : graph.around(component.cells[i]))
        if (std::exchange(seen[link.cell], uint8_t{1}) == 0) component.cells.push_back(link.cell);
    }
  }
  std::stable_sort(components.begin(), components.end(),
                   [](const Component& a, const Component& b) { return a.face_count > b.face_count; });
  return components;
}

// A component larger than a patch gets patches in proportion to its faces. The other components are packed,
// each into the fullest patch that has room.
std::vector<PatchSet> share_out(const CellGraph& graph, double share) {
  const auto largest = static_cast<uint64_t>(std::max(kLargestStart * share, 1.0));
  std::vector<PatchSet> sets;
  std::multimap<uint64_t, size_t> packed;  // from the faces of a set to its number
  uint32_t next_patch = 0;
  for (Component& component : connected_components(graph)) {
    if (component.face_count > largest) {
      const double shares = static_cast<double>(component.face_count) / share;
      const auto patch_count =
          static_cast<uint32_t>(std::max(std::round(shares), std::ceil(shares / kLargestStart)));
      sets.push_back({std::move(component.cells), next_patch, patch_count});
      next_patch += patch_count;
      continue;
    }
    const auto above = packed.upper_bound(largest - component.face_count);
    if (above == packed.begin()) {
      packed.insert({component.face_count, sets.size()});
      sets.push_back({std::move(component.cells), next_patch++, 1});
      continue;
    }
    const auto [face_count, set] = *std::prev(above);
    packed.erase(std::prev(above));
    packed.insert({face_count + component.face_count, set});
    sets[set].cells.insert(sets[set].cells.end(), component.cells.begin(), component.cells.end());
  }
  return sets;
}

// The number of faces up to which refinement may let each patch grow.
std::vector<uint32_t> face_limits(const CellGraph& graph, std::span<const PatchSet> sets) {
  std::vector<uint32_t> limits;
  for (const PatchSet& set : sets) {
    const double mean = static_cast<double>(graph.faces_of(set.cells)) / set.patch_count;
    const double limit = std::max(std::floor(mean * kBalance), std::ceil(mean));
    limits.insert(limits.end(), set.patch_count, static_cast<uint32_t>(limit));
  }
  return limits;
}

// Numbers for patches, breadth-first over their neighbours, so that these have similar numbers. Empty patches
// get kNoCell.
std::vector<uint32_t> neighbourly_numbers(const CellGraph& cells, std::span<const uint32_t> patch_of,
                                          size_t patch_count) {
  std::vector<std::pair<uint32_t, uint32_t>> borders;
  for (uint32_t cell = 0; cell < cells.cell_count(); ++cell)
    cells.for_each_link(cell, [&](uint32_t next, uint32_t) {
      const std::pair border(patch_of[cell], patch_of[next]);
      if (border.first != border.second && (borders.empty() || borders.back() != border))
        borders.push_back(border);
    });
  std::sort(borders.begin(), borders.end());
  borders.erase(std::unique(borders.begin(), borders.end()), borders.end());
  std::vector<uint32_t> number(patch_count, kNoCell), queue;
  uint32_t count = 0;
  for (const uint32_t start : patch_of) {
    if (number[start] != kNoCell) continue;
    queue.assign(1, start);
    number[start] = count++;
    for (size_t i = 0; i < queue.size(); ++i) {
      auto border = std::lower_bound(borders.begin(), borders.end(), std::pair(queue[i], 0u));
      for (; border != borders.end() && border->first == queue[i]; ++border)
        if (number[border->second] == kNoCell) {
          number[border->second] = count++;
          queue.push_back(border->second);
        }
    }
  }
  return number;
}

// The patch of each cell of a level, from the patches of the next coarser level.
std::vector<uint32_t> project(std::span<const uint32_t> coarse_of, std::span<const uint32_t> patch_of) {
  std::vector<uint32_t> finer;
  finer.reserve(coarse_of.size());
  for (const uint32_t cell : coarse_of) finer.push_back(patch_of[cell]);
  return finer;
}

// The patches before their borders are refined.
struct Start {
  Coarsening first_cells;
  Levels levels;
  std::vector<uint32_t> face_limits;  // of each patch
  std::vector<uint32_t> patch_of;     // of each cell of the coarsest level
};

Start start_in_levels(const FaceGraph& graph, uint32_t patch_count, uint32_t first_faces,
                      const ThreadPool& pool) {
  const double share = static_cast<double>(graph.cell_count()) / patch_count;
  const auto face_limit = static_cast<uint32_t>(std::max(kLargestCell * share, 1.0));
  Start start;
  start.first_cells = grow_cells(graph, std::min(first_faces, face_limit), face_limit, pool);
  start.levels = coarsen(contract(graph, start.first_cells, pool), patch_count, face_limit, pool);
  const CellGraph& coarsest = start.levels.graphs.back();
  std::vector<PatchSet> sets = share_out(coarsest, share);
  start.face_limits = face_limits(coarsest, sets);
  start.patch_of.resize(coarsest.cell_count());
  halve_sets(coarsest, std::move(sets), start.patch_of, pool);
  return start;
}

// The paper's patches are divided into cells again, so that borders are first refined in larger steps.
Start start_of_paper(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const FaceGraph& graph, uint32_t patch_count, uint32_t first_faces,
                     const PartitionOptions& options, const ThreadPool& pool) {
  const uint32_t face_count = graph.cell_count();
  constexpr uint64_t kSamplesPerPatch = 16;  // N of the paper's M x N samples for M patches
  const uint64_t samples = kSamplesPerPatch * patch_count;
  DistanceMap map(faces, vertex_count, graph, options.distance);
  const Clusters clusters = cluster_faces(
      map, graph,
      sample_faces(map, face_count, static_cast<uint32_t>(std::min<uint64_t>(samples, face_count))));
  const CellGraph cells =
      contract(graph, {clusters.cell_of, static_cast<uint32_t>(clusters.centres.size())}, pool);
  const std::vector<PatchSet> sets = share_out(cells, static_cast<double>(face_count) / patch_count);
  const std::vector<uint32_t> patch_of_face = group_clusters(map, graph, clusters, cells, sets);

  FaceGraph within = graph;
  const auto is_between = [&](uint32_t a, uint32_t b) { return patch_of_face[a] != patch_of_face[b]; };
  for (uint32_t face = 0; face < face_count; ++face)
    for (uint32_t& next : within.neighbours[face])
      if (next != kNoCell && is_between(face, next)) next = kNoCell;
  std::erase_if(within.extra, [&](const auto& link) { return is_between(link.face, link.other); });
  Start start;
  start.face_limits = face_limits(cells, sets);
  start.first_cells = grow_cells(within, first_faces, kNoCell, pool);
  start.levels.graphs.push_back(contract(graph, start.first_cells, pool));
  start.patch_of.resize(start.first_cells.count);
  for (uint32_t face = 0; face < face_count; ++face)
    start.patch_of[start.first_cells.coarse_of[face]] = patch_of_face[face];
  return start;
}

// Patches before their borders are cut at faces.
struct CutCells {
  std::vector<uint32_t> patch_of_face;
  std::vector<uint32_t> limits;  // of each patch
};

// Cuts cells of faces, the largest first, and numbers the patches. Borders still run along the first cells.
CutCells cut_cells(Start start, uint32_t wanted, const Recuts& recuts, bool refine, const ThreadPool& pool) {
  const Levels& levels = start.levels;
  std::vector<uint32_t>& patch_of = start.patch_of;
  const size_t face_count = start.first_cells.coarse_of.size();
  const auto options_for = [&](size_t level, uint64_t cell_count) {
    if (level == 0 && !levels.coarse_of.empty()) return recuts.middle;
    if (level == 0 || cell_count < uint64_t{kCoarseCells} * wanted) return recuts.coarse;
    return cell_count * recuts.finer_faces < face_count ? recuts.finer : kNoCuts;
  };
  for (size_t level = levels.coarse_of.size();; --level) {
    const CellGraph& cells = levels.graphs[level];
    const RecutOptions options = options_for(level, cells.cell_count());
    if (refine && options.rounds > 0) recut_borders(cells, start.face_limits, options, patch_of, pool);
    if (level == 0) break;
    patch_of = project(levels.coarse_of[level - 1], patch_of);
  }
  const std::vector<uint32_t> number =
      neighbourly_numbers(levels.graphs[0], patch_of, start.face_limits.size());
  CutCells cut;
  cut.limits.resize(number.size() - static_cast<size_t>(std::ranges::count(number, kNoCell)));
  for (size_t patch = 0; patch < number.size(); ++patch)
    if (number[patch] != kNoCell) cut.limits[number[patch]] = start.face_limits[patch];
  for (uint32_t& patch : patch_of) patch = number[patch];
  cut.patch_of_face = project(start.first_cells.coarse_of, patch_of);
  return cut;
}

// Calls `free_faces` when the faces are not needed any more. Frees its own memory early, too, because the
// partition takes more memory than any other step of encoding.
template <typename FreeFaces>
Partition partition_of(Span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                       const PartitionOptions& options, const ThreadPool& pool, const FreeFaces& free_faces) {
  const size_t face_count = faces.size();
  Partition partition;
  if (face_count == 0) return partition;
  const auto wanted = static_cast<uint32_t>(std::clamp<size_t>(options.patch_count, 1, face_count));
  if (wanted == 1 || wanted == face_count) {
    partition.patch_count = wanted;
    partition.patch_of_face.resize(face_count);
    if (wanted > 1) std::iota(partition.patch_of_face.begin(), partition.patch_of_face.end(), 0u);
    return partition;
  }
  const Recuts recuts = recuts_for(static_cast<double>(face_count) / wanted, options.method);
  FaceGraph graph = face_graph(faces, vertex_count, pool);
  const bool is_paper = options.method == PartitionMethod::kPaper;
  if (!is_paper) free_faces();
  Start start = is_paper ? start_of_paper(faces, vertex_count, graph, wanted, recuts.first_faces, options, pool)
                         : start_in_levels(graph, wanted, recuts.first_faces, pool);
  CutCells cut = cut_cells(std::move(start), wanted, recuts, options.refine, pool);
  if (options.refine) recut_borders(graph, cut.limits, recuts.fine, cut.patch_of_face, pool);
  partition.patch_count = static_cast<uint32_t>(cut.limits.size());
  partition.patch_of_face = std::move(cut.patch_of_face);
  if (graph.extra.empty()) partition.neighbours = std::move(graph.neighbours);
  return partition;
}

}  // namespace

Partition partition_faces(Span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                          const PartitionOptions& options, const ThreadPool& pool) {
  return partition_of(faces, vertex_count, options, pool, [] {});
}

Partition partition_faces(std::vector<std::array<uint32_t, 3>>&& faces, uint32_t vertex_count,
                          const PartitionOptions& options, const ThreadPool& pool) {
  std::vector<std::array<uint32_t, 3>> own = std::move(faces);
  return partition_of(own, vertex_count, options, pool, [&] { own = std::vector<std::array<uint32_t, 3>>(); });
}

std::vector<uint32_t> distribute_patches(Span<const uint64_t> face_counts, uint64_t patch_count) {
  uint64_t total = std::accumulate(face_counts.begin(), face_counts.end(), uint64_t{0});
  // Products of two numbers below 2^32 do not overflow.
  constexpr uint64_t kMost = 0xffffffff;
  int shift = 0;
  for (; total > kMost; total >>= 1) ++shift;
  patch_count = std::min(patch_count, kMost);
  std::vector<uint32_t> shares;
  for (const uint64_t faces : face_counts) {
    const uint64_t share = total == 0 ? 0 : (faces >> shift) * patch_count / total;
    shares.push_back(static_cast<uint32_t>(std::clamp<uint64_t>(share, 1, kMost)));
  }
  return shares;
}

}  // namespace psplit
