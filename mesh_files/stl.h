// STL, in text and binary.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>

#include "mesh_files/mesh_file.h"
#include "mesh_files/scanner.h"

namespace psplit {

// Whether the file is STL in text. The word "solid" is not enough, because many programs begin the header of a
// binary file with it. A file is binary if its size matches its count of facets, and text if only text follows
// "solid".
bool is_text_stl(Scanner& scanner);
// Whether the size of the file matches its count of facets. False if the size is unknown.
bool has_size_of_binary_stl(Scanner& scanner);

// A normal and three positions, as binary files store them.
struct Facet {
  std::array<float, 3> normal;
  std::array<Position, 3> corners;
};

// A facet of a text file, whose numbers may be more precise than floats.
struct PreciseFacet {
  std::array<float, 3> normal;
  std::array<PrecisePosition, 3> corners;
};

// A corner of a facet: a position and a normal, compared bit for bit.
struct SoupPoint {
  std::array<float, 3> position, normal;

  bool operator==(const SoupPoint& other) const { return bits() == other.bits(); }
  size_t hash() const;

 private:
  std::array<uint32_t, 6> bits() const { return std::bit_cast<std::array<uint32_t, 6>>(*this); }
};

// Receives the facets of a file while it is read.
class FacetSink {
 public:
  virtual ~FacetSink() = default;
  // The next facet, of a binary file or of a text. Its positions are finite. The reader stops at the first
  // error.
  virtual Status add(const Facet& facet) = 0;
  virtual Status add(const PreciseFacet& facet) = 0;
  // The solid whose facets came since the last call. `offset` is the number of bytes that were read.
  virtual void end_solid(const std::string& name, uint64_t offset) = 0;
};

// The number of facets that the header of a binary file states. Nothing for a text or a file without a header.
std::optional<uint32_t> facet_count_of_binary_stl(Scanner& scanner);

// Errors: kInvalidInput with the line or byte (missing facets, words that are not numbers, positions that are
// not finite), and the sink's errors.
Status read_stl(Scanner& scanner, FacetSink& sink, Losses& losses);

// One object for each solid, with the normals of the facets. Points with equal position and normal, in floats
// relative to the origin, are one point. Errors: the same, and kInvalidInput if there are no facets.
Expected<MeshFile> read_stl(Scanner& scanner, const OriginChoice& choice);

}  // namespace psplit
