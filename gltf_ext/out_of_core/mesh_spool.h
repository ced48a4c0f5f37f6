// A mesh of any size as it was read, in temporary files or in the buffers of a document.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/position_bits.h"
#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/stl.h"
#include "gltf_ext/out_of_core/cell_tree.h"
#include "gltf_ext/out_of_core/file_blocks.h"
#include "gltf_ext/primitive/mesh_view.h"

namespace psplit {

struct SpoolOptions {
  std::filesystem::path folder;  // of the temporary files
  // A mesh file, whose values are changed to what glTF requires (gltf_ext/mesh_files/repair_values.h).
  bool repairs = true;
  CodingOptions coding;
  std::set<std::string> skip{};  // semantics that are left out
  std::set<std::string> exact;   // semantics that stay exact: see choose_codings
  bool samples_edges = false;    // see MeshSpool::edges
  // Points that are equal stay apart: see has_numbered_points and has_proper_face.
  bool keep_duplicates = false;
  uint64_t most_zero_normals = 0;  // kept in memory, with about 64 bytes each
};

using Face = std::array<uint32_t, 3>;

// Takes a mesh as points and faces, or as facets. A point is stored as a record: the values of its attributes,
// one after the other. Three corners of a facet are three points; mesh_cells merges equal points.
class MeshSpool : public MeshSink, public FacetSink {
 public:
  // `losses` must outlive the object.
  static Expected<std::unique_ptr<MeshSpool>> create(SpoolOptions options, Losses& losses);

  // The mesh of a primitive, without a copy: its values are read where they are, and must outlive the object.
  // Nothing is repaired, and it is finished. `positions` is the name of positions in errors. Errors:
  // kInvalidInput, kUnsupported (32-bit integers, positions that are not floats).
  static Expected<std::unique_ptr<MeshSpool>> view(MeshView mesh, SpoolOptions options, Losses& losses,
                                                   const std::string& positions);

  Status begin(std::span<const Attribute> layout, size_t expected_points) override;
  Status add_points(std::span<const Attribute> block, size_t count) override;
  void expect_faces(size_t) override {}
  Status add_faces(std::span<const Face> faces) override;
  Expected<Position> position(uint32_t point) override;

  Status add(const Facet& facet) override;
  void end_solid(const std::string& name, uint64_t offset) override;

  // Call it after everything was added.
  Status finish();

  uint64_t point_count() const { return point_count_; }
  uint64_t face_count() const { return face_count_; }
  // Whether a face has three different points. Without one, there is nothing to encode, unless such faces are
  // kept.
  bool has_proper_face() const { return has_proper_face_; }
  bool is_soup() const { return is_soup_; }  // it came as facets: face i has the points 3i to 3i + 2
  // Whether the last attribute that begin() got was kPointNumber: points that are equal with it are one point
  // of the input. It is a part of the records, but not of attributes().
  bool has_numbered_points() const { return has_numbered_points_; }
  static constexpr const char* kPointNumber = "point number";
  const std::string& name() const { return name_; }  // of the solid, if there is only one
  // Those of the records that are read, without values. NORMAL is missing if no normal has a direction.
  const std::vector<Attribute>& attributes() const { return read_attributes_; }
  size_t record_bytes() const { return read_bytes_; }
  // Those of options.skip that were read.
  const std::vector<std::string>& skipped_attributes() const { return skipped_; }
  // The bounds of all positions, also of those that are not stored later.
  const Box& box() const { return box_; }
  // The sample of the edges of the whole mesh, if options.samples_edges.
  const EdgeSample& edges() const { return edges_; }
  // The bits that the options want for one of attributes().
  int bits_of(const Attribute& attribute) const {
    return wanted_bits(attribute, options_.coding, options_.exact);
  }

  // Calls the function with consecutive records, and the number of the first point; in blocks of facets for a
  // soup.
  using VisitPoints = std::function<Status(uint64_t first, std::span<const uint8_t> records)>;
  Status for_each_point(const VisitPoints& visit) const;
  Status for_each_position(const std::function<void(std::span<const Position>)>& visit) const;
  Position position_of(const uint8_t* record) const;
  // Not for a soup.
  Status for_each_face(const std::function<Status(std::span<const Face>)>& visit) const;

  // Of a soup: makes normals of records unit vectors, as repair_values does. Call it when equal points are
  // merged. Returns the number of changed normals among the records whose flag is set.
  uint64_t repair_soup(std::span<uint8_t> records, const std::vector<uint8_t>& counts) const;
  // The number of different points of a soup whose normals had no direction.
  uint64_t zero_normals_of_soup() const { return soup_sums_.size(); }

  // Gives the space of the files back.
  void close_files();

 private:
  MeshSpool(SpoolOptions options, Losses& losses) : options_(std::move(options)), losses_(losses) {}
  struct HashOfPoint {
    size_t operator()(const SoupPoint& point) const { return point.hash(); }
  };
  using Sum = std::array<double, 3>;

  Status measure_positions(const Attribute& positions);
  Status measure_view(const std::string& positions);
  void gather(uint64_t first, size_t count, std::span<uint8_t> records) const;
  void put_column(size_t attribute, const Attribute& column, std::span<uint8_t> records) const;
  void include(const Position& position) {
    for (size_t axis = 0; axis < position.size(); ++axis) {
      box_.low[axis] = std::min(box_.low[axis], position[axis]);
      box_.high[axis] = std::max(box_.high[axis], position[axis]);
    }
  }
  Status repair_block_normals(Attribute& normals, size_t count);
  Status too_many_zero_normals() const;
  Status sample_edges(uint64_t first, std::span<const Face> faces);
  Status look_for_proper_face(std::span<const Face> faces);
  Status read_faces(uint64_t first, std::span<Face> faces) const;
  Status read_record(uint32_t point, size_t offset, std::span<uint8_t> to);
  Expected<std::array<Position, 3>> corners_of(const Face& face);
  Status add_to_zero_normals(const Face& face);
  Status add_zero_facet(const Facet& facet);
  Status add_earlier_zero_facets();
  bool skips_normals_of_soup() const { return is_soup_ && options_.skip.contains("NORMAL"); }
  bool has_no_normals() const {
    return normal_ != kNone && (zero_count_ == point_count_ || skips_normals_of_soup());
  }

  static constexpr size_t kNone = SIZE_MAX;
  SpoolOptions options_;
  Losses& losses_;
  bool is_soup_ = false, has_proper_face_ = false, has_numbered_points_ = false;
  std::string name_;
  size_t solids_ = 0;
  std::vector<Attribute> attributes_, read_attributes_;
  std::vector<std::string> skipped_;
  std::vector<size_t> kept_;     // the number of each attribute in the layout that came
  std::vector<size_t> offsets_;  // of each attribute in a record
  size_t record_bytes_ = 0, read_bytes_ = 0;
  size_t position_ = kNone, normal_ = kNone;
  Box box_{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  AppendFile points_, faces_;
  std::optional<MeshView> view_;  // instead of these files
  uint64_t point_count_ = 0, face_count_ = 0;
  std::vector<uint8_t> block_;
  PagedFile pages_;

  EdgeSample edges_;
  uint64_t changed_normals_ = 0;
  // Points whose normals have no direction. While all points are so, they are only counted.
  uint64_t zero_count_ = 0;
  std::vector<uint32_t> zeros_;  // ascending
  std::vector<Sum> sums_;        // of the area vectors of the faces of each
  std::unordered_map<SoupPoint, Sum, HashOfPoint> soup_sums_;
};

}  // namespace psplit
