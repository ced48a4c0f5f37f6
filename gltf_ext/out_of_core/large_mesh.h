// A mesh of any size in the buffers of a document, read point by point.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/position_bits.h"
#include "gltf_ext/out_of_core/cell_tree.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "psplit/base.h"

namespace psplit {

using Face = std::array<uint32_t, 3>;

// A point is read as a record: the values of its attributes, one after the other, as they are stored.
class LargeMesh {
 public:
  struct Options {
    CodingOptions coding{};
    bool samples_edges = false;    // see edges()
    bool keep_duplicates = false;  // points that are equal stay apart: see has_proper_face()
    std::function<void()> forget{};
  };

  // The values of `mesh` must outlive the object, or the call of forget(). `positions` is the name of positions
  // in errors. `numbers`: if not empty, 12 bytes for each point, which follow its values in its record. Errors:
  // kInvalidInput (positions that are not finite, indices), kUnsupported (32-bit integers, positions that are
  // not floats, no faces).
  static Expected<LargeMesh> open(MeshView mesh, std::span<const uint8_t> numbers, Options options,
                                  const std::string& positions);

  uint64_t point_count() const { return mesh_.point_count; }
  uint64_t face_count() const { return mesh_.indices.count / 3; }
  // Whether a face has three different points. Without one, there is nothing to encode, unless such faces are
  // kept.
  bool has_proper_face() const { return has_proper_face_; }
  bool is_soup() const { return mesh_.indices.bytes.empty(); }  // face i has the points 3i to 3i + 2
  // The attributes of the records, without values, and without the numbers.
  const std::vector<Attribute>& attributes() const { return attributes_; }
  size_t record_bytes() const { return record_bytes_; }
  // The bounds of all positions, also of positions that are not stored later.
  const Box& box() const { return box_; }
  // The sample of the edges of the whole mesh, if options.samples_edges.
  const EdgeSample& edges() const { return edges_; }
  // The bits that the options want for one of attributes().
  int bits_of(const Attribute& attribute) const { return wanted_bits(attribute, options_.coding); }
  // The coding of one of attributes(), by the bounds of all values that are stored.
  CodingBounds bounds_for(const Attribute& values) const { return wanted_bounds(values, options_.coding); }
  AttributeCoding coding_of(const Attribute& attribute, const CodingBounds& bounds) const {
    return choose_coding(attribute, bounds, options_.coding);
  }

  // Calls the function with consecutive records, and the number of the first point; in blocks of facets for a
  // soup.
  using VisitPoints = std::function<Status(uint64_t first, std::span<const uint8_t> records)>;
  Status for_each_point(const VisitPoints& visit) const;
  Status for_each_position(const std::function<void(std::span<const Position>)>& visit) const;
  Position position_of(const uint8_t* record) const;
  Status for_each_face(const std::function<Status(std::span<const Face>)>& visit) const;

  // Nothing is read any more.
  void forget() const {
    if (options_.forget) options_.forget();
  }

 private:
  LargeMesh(MeshView mesh, Options options) : mesh_(std::move(mesh)), options_(std::move(options)) {}
  Status measure_positions(const std::string& positions);
  Status measure_faces();
  Position position_at(uint32_t point) const;
  void gather(uint64_t first, size_t count, std::span<uint8_t> records) const;
  void look_for_proper_face(std::span<const Face> faces);
  Status read_faces(uint64_t first, std::span<Face> faces) const;

  MeshView mesh_;  // the numbers are its last attribute
  Options options_;
  std::vector<Attribute> attributes_;
  size_t record_bytes_ = 0;
  size_t position_ = 0, position_offset_ = 0;
  bool has_proper_face_ = false;
  Box box_{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  EdgeSample edges_;
};

}  // namespace psplit
