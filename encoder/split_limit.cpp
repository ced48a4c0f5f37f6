#include "encoder/split_limit.h"

#include <algorithm>
#include <numeric>

namespace psplit {
namespace {

// What all streams take.
struct SplitBytes {
  uint64_t streams = 0, tables = 0, largest_tables = 0;
  uint64_t points = 0;

  explicit SplitBytes(const Streams& of) {
    for (const std::vector<uint8_t>& bytes : of.bytes) streams += bytes.size();
    for (const size_t bytes : of.table_bytes) {
      tables += bytes;
      largest_tables = std::max<uint64_t>(largest_tables, bytes);
    }
    for (const OwnedStream& stream : of.owned) points += stream.points.size();
  }

  // Tables that one stream would not have. Its own may be larger than the largest here.
  uint64_t repeated_tables() const { return tables - largest_tables; }
};

// Of an entry of the directory.
constexpr uint64_t kEntryBytes = 8;

// Whether nearly all points have six faces, as those of grids and of surfaces that were made by rule. One
// stream follows the rows of such a mesh, and patches do not: that may cost a tenth, which no border shows. Of
// meshes that were scanned or sculpted, about a third of the points have six faces; of those that were remeshed
// with care, three quarters.
bool has_rows(const Mesh& mesh) {
  constexpr double kShare = 0.9;
  std::vector<uint8_t> faces_of(mesh.point_count, 0);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face)
      if (faces_of[point] < 7) ++faces_of[point];
  const auto with_six = std::ranges::count(faces_of, uint8_t{6});
  return static_cast<double>(with_six) > kShare * static_cast<double>(mesh.point_count);
}

}  // namespace

bool may_exceed_limit(const Mesh& mesh, const Streams& streams, const StreamOptions& options) {
  // A reference of a run takes a tenth of a byte, and one that is named alone about so many.
  constexpr double kReferenceBytes = 1.2;
  if (options.choose_by_bytes) return true;
  // The bound is not exact: predictions at borders are worse, too, and one stream may have larger tables. Of
  // many patches these even out, and tables of their own fit them better.
  constexpr size_t kMany = 8;
  const double certain = (streams.bytes.size() < kMany ? 0.85 : 0.93) * options.most_split_percent / 100;
  const SplitBytes bytes(streams);
  const auto references =
      static_cast<double>(bytes.points - std::min<uint64_t>(bytes.points, mesh.point_count));
  const auto values = static_cast<double>(bytes.streams - std::min(bytes.streams, bytes.tables));
  double more = values * references / static_cast<double>(std::max<uint64_t>(1, bytes.points));
  if (!options.shares_tables) more += static_cast<double>(bytes.repeated_tables());
  if (!streams.are_alone(options.alone))
    more += kReferenceBytes * references + static_cast<double>(kEntryBytes * streams.bytes.size());
  return more > certain * (static_cast<double>(bytes.streams) - more) || has_rows(mesh);
}

uint64_t stored_bytes(const Mesh& mesh, const Streams& streams, const StreamOptions& options,
                      const ThreadPool& pool) {
  const SplitBytes bytes(streams);
  const uint64_t values = bytes.streams - (options.shares_tables ? bytes.repeated_tables() : 0);
  if (streams.are_alone(options.alone)) return values;
  std::vector<PointOwner> owners(mesh.point_count);
  const Stitching stitching = build_stitching(streams.owned, 0, owners, pool);
  return std::accumulate(stitching.maps.begin(), stitching.maps.end(),
                         values + kEntryBytes * streams.bytes.size(),
                         [](uint64_t sum, const std::vector<uint8_t>& map) { return sum + map.size(); });
}

}  // namespace psplit
