// Writes a mesh of any size into temporary files, which become the buffers of a document.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "gltf_ext/out_of_core/file_blocks.h"
#include "mesh_files/mesh_file.h"
#include "mesh_files/stl.h"

namespace psplit {

struct SpoolOptions {
  std::filesystem::path folder;    // of the temporary files
  uint64_t most_zero_normals = 0;  // kept in memory, with about 64 bytes each
  bool numbers_points = false;     // points of an OBJ or STL get SpooledPoints::numbers
  OriginChoice origin{};
};

// Takes a mesh as points and faces, or as facets, of which each corner becomes a point. Changes the values to
// what glTF requires (mesh_files/repair_values.h). Positions in doubles stay so in their file until
// all are there, because the origin depends on all; what depends on positions in floats waits for that.
class MeshSpool : public MeshSink, public FacetSink {
 public:
  // `losses` must outlive the object.
  MeshSpool(const SpoolOptions& options, Losses& losses) : options_(options), losses_(losses) {}

  Status begin(std::span<const Attribute> layout, size_t expected_points, bool are_precise) override;
  Status add_points(std::span<const Attribute> block, size_t count,
                    std::span<const PrecisePosition> positions) override;
  void expect_faces(size_t) override {}
  Status add_faces(std::span<const std::array<uint32_t, 3>> faces) override;
  Expected<PrecisePosition> position(uint32_t point) override;

  Status add(const Facet& facet) override { return add_facet(facet); }
  Status add(const PreciseFacet& facet) override { return add_facet(facet); }
  void end_solid(const std::string& name, uint64_t offset) override;

  // An attribute of this name is the last, and becomes SpooledPoints::numbers.
  static constexpr const char* kPointNumber = "point number";

  uint64_t face_count() const { return face_count_; }

  // Call it after everything was added. The document has one primitive, with the material of that number, in
  // the first object of `file` or in one that is named as the only solid. NORMAL is missing if no normal has a
  // direction. Errors: as for the files; kUnsupported without faces, or if an accessor cannot count them.
  Expected<Document> finish(MeshFile file, int64_t material);

 private:
  // The values of an attribute, as a buffer of glTF has them.
  struct Column {
    Attribute attribute;  // without values
    size_t stride = 0;
    AppendFile file{};
    PagedFile pages{};
  };
  struct HashOfPoint {
    size_t operator()(const SoupPoint& point) const { return point.hash(); }
  };
  using Sum = std::array<double, 3>;

  template <typename AnyFacet>
  Status add_facet(const AnyFacet& facet);
  Status measure_positions(std::span<const Position> positions);
  Status append_precise(const Attribute& floats, std::span<const PrecisePosition> positions);
  // Makes floats of the doubles.
  Status settle_positions();
  Status add_late_zero_normals();
  template <typename T>
  Status read_point(size_t column, uint32_t point, T& value);
  Expected<Position> float_position(uint32_t point);
  Status repair_block_normals(Attribute& normals, size_t count);
  Status too_many_zero_normals() const;
  Status add_to_zero_normals(const std::array<uint32_t, 3>& face);
  Status add_zero_facet(const Facet& facet);
  Status add_zero_facets(bool are_all_zero);
  Status flush_facets();
  Status replace_zero_normals();
  bool has_no_normals() const { return normal_ != kNone && zero_count_ == point_count_; }

  static constexpr size_t kNone = SIZE_MAX;
  const SpoolOptions options_;
  Losses& losses_;
  std::vector<Column> columns_;
  AppendFile faces_;
  size_t position_ = kNone, normal_ = kNone;
  std::array<double, 3> low_{INFINITY, INFINITY, INFINITY}, high_{-INFINITY, -INFINITY, -INFINITY};
  uint64_t point_count_ = 0, face_count_ = 0;
  bool are_precise_ = false;  // the file of positions has doubles
  PositionSpread spread_;     // of these
  PrecisePosition origin_{};

  bool is_soup_ = false;           // it came as facets
  std::vector<Attribute> facets_;  // the values of facets that wait to be written
  std::vector<PrecisePosition> facet_positions_;
  std::string name_;  // of the solid, if there is only one
  size_t solids_ = 0;

  uint64_t changed_normals_ = 0;
  // Points whose normals have no direction. While all points are so, they are only counted.
  uint64_t zero_count_ = 0;
  std::vector<uint32_t> zeros_;  // ascending; not of a soup
  std::vector<Sum> sums_;        // of the area vectors of the faces of each
  std::unordered_map<SoupPoint, Sum, HashOfPoint> soup_sums_;
};

}  // namespace psplit
