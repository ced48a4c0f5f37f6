#include "mesh_files/stl.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "mesh_files/point_table.h"

namespace psplit {
namespace {

constexpr size_t kHeaderBytes = 84, kCountAt = 80, kFacetBytes = 50;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_word(std::string_view word, std::string_view expected) {
  return std::equal(word.begin(), word.end(), expected.begin(), expected.end(),
                    [](char a, char b) { return lower(a) == b; });
}

uint32_t facet_count_of(std::string_view header) {
  uint32_t count = 0;
  std::memcpy(&count, header.data() + kCountAt, sizeof(count));
  return count;
}

bool has_finite_corners(const auto& facet) {
  return std::ranges::all_of(facet.corners, [](const auto& corner) { return is_finite(corner); });
}

// Merges points with equal position and normal.
class SoupBuilder {
 public:
  void add(const Facet& facet) {
    std::array<uint32_t, 3> face;
    for (size_t i = 0; i < 3; ++i) face[i] = points_.find_or_add({facet.corners[i], facet.normal}).first;
    faces_.push_back(face);
  }

  size_t face_count() const { return faces_.size(); }

  Mesh take() {
    Mesh mesh;
    const std::vector<SoupPoint>& points = points_.points();
    mesh.point_count = static_cast<uint32_t>(points.size());
    mesh.faces = std::move(faces_);
    for (const char* semantic : {"POSITION", "NORMAL"}) {
      const bool normal = semantic[0] == 'N';
      Attribute attribute{semantic, ComponentType::kFloat32, 3, false, {}};
      attribute.values.resize(points.size() * sizeof(Position));
      for (size_t i = 0; i < points.size(); ++i)
        std::memcpy(attribute.values.data() + i * sizeof(Position),
                    normal ? points[i].normal.data() : points[i].position.data(), sizeof(Position));
      mesh.attributes.push_back(std::move(attribute));
    }
    points_.clear();
    faces_.clear();
    return mesh;
  }

 private:
  PointTable<SoupPoint> points_;
  Array<std::array<uint32_t, 3>> faces_;
};

// A mesh of each solid, in memory. The facets of a text wait until its origin is known: which corners are equal
// depends on it.
class SolidBuilder : public FacetSink {
 public:
  explicit SolidBuilder(Losses& losses) : losses_(losses) {}

  Status add(const Facet& facet) override {
    soup_.add(facet);
    return {};
  }

  Status add(const PreciseFacet& facet) override {
    facets_.push_back(facet);
    return {};
  }

  void end_solid(const std::string& name, uint64_t offset) override {
    name_ = name;
    if (soup_.face_count() == 0 && facets_.empty()) return;
    // Thousands of solids with one or two facets would take more memory than their bytes justify.
    constexpr size_t kFewSolids = 1024, kBytesOfSolid = 512;
    if (solids_.size() < kFewSolids + offset / kBytesOfSolid)
      take_solid();
    else
      losses_.say("solids of a few facets share a mesh: there are too many of them");
  }

  std::vector<MeshFileObject> take(const OriginChoice& choice) {
    if (soup_.face_count() > 0 || !facets_.empty()) take_solid();
    if (is_text_) make_meshes(choice);
    std::vector<MeshFileObject> objects;
    for (Solid& solid : solids_) objects.push_back(std::move(solid.object));
    return objects;
  }

 private:
  struct Solid {
    MeshFileObject object;
    std::vector<PreciseFacet> facets;  // of a text
  };

  void take_solid() {
    is_text_ = is_text_ || !facets_.empty();
    Solid& solid = solids_.emplace_back();
    solid.object.name = name_;
    solid.facets = std::exchange(facets_, {});
    solid.object.parts.push_back({soup_.take(), -1});
  }

  void make_meshes(const OriginChoice& choice) {
    std::vector<PositionSpread> spreads;
    for (const Solid& solid : solids_) {
      PositionSpread& spread = spreads.emplace_back();
      for (const PreciseFacet& facet : solid.facets)
        for (const PrecisePosition& corner : facet.corners) spread.add(corner);
    }
    const std::vector<PrecisePosition> origins = choose_origins(spreads, choice);
    double left = 0;
    for (size_t i = 0; i < solids_.size(); ++i) {
      Solid& solid = solids_[i];
      for (const PreciseFacet& precise : solid.facets) {
        Facet facet{precise.normal, {}};
        for (size_t corner = 0; corner < 3; ++corner) {
          facet.corners[corner] = relative_to(origins[i], precise.corners[corner]);
          left = std::max(left, lost_by(origins[i], precise.corners[corner]));
        }
        soup_.add(facet);
      }
      solid.facets = {};
      solid.object.origin = origins[i];
      solid.object.parts[0].mesh = soup_.take();
    }
    say_origins(spreads, origins, left, choice, losses_);
  }

  Losses& losses_;
  SoupBuilder soup_;
  std::vector<PreciseFacet> facets_;  // of the solid that is read
  bool is_text_ = false;
  std::vector<Solid> solids_;
  std::string name_;
};

class TextReader {
 public:
  TextReader(Scanner& scanner, FacetSink& sink, Losses& losses)
      : scanner_(scanner), sink_(sink), losses_(losses) {}

  Status read() {
    for (;;) {
      const std::string_view word = scanner_.next_word();
      if (word.empty()) break;
      if (is_word(word, "solid")) {
        if (Status status = begin_solid(); !status.ok()) return status;
      } else if (is_word(word, "facet") && inside_) {
        if (Status status = read_facet(); !status.ok()) return status;
      } else if (is_word(word, "endsolid") && inside_) {
        inside_ = false;
        sink_.end_solid(name_, scanner_.offset());
        scanner_.next_line();
      } else if (is_word(word, "color") && inside_) {  // a statement that some programs add
        losses_.say("colours of solids are left out");
        scanner_.next_line();
      } else {
        return error_at_line(scanner_.line(), in_quotes(word) + " where \"facet\" or \"endsolid\" is expected");
      }
    }
    return inside_ ? error_at_line(scanner_.line(), "the file ends before \"endsolid\"") : Status();
  }

 private:
  // A solid begins inside another: the end of the first is missing.
  Status begin_solid() {
    if (inside_) return error_at_line(scanner_.line(), "\"solid\" where \"facet\" or \"endsolid\" is expected");
    inside_ = true;
    const std::optional<std::string> name = scanner_.rest_of_line();
    if (!name) return error_at_line(scanner_.line(), "a name that is too long");
    name_ = *name;
    return {};
  }

  Status expect(std::initializer_list<std::string_view> words) {
    for (const std::string_view expected : words) {
      const std::string_view word = scanner_.next_word();
      if (word.empty()) return error_at_line(scanner_.line(), "the file ends inside a facet");
      if (!is_word(word, expected))
        return error_at_line(scanner_.line(),
                             in_quotes(word) + " where \"" + std::string(expected) + "\" is expected");
    }
    return {};
  }

  template <typename Number>
  Status read_vector(std::array<Number, 3>& vector) {
    for (Number& value : vector) {
      const std::string_view word = scanner_.next_word();
      if (word.empty()) return error_at_line(scanner_.line(), "the file ends inside a facet");
      const std::optional<double> number = parse_precise(word);
      if (!number) return error_at_line(scanner_.line(), in_quotes(word) + " is not a number");
      value = static_cast<Number>(*number);
    }
    return {};
  }

  Status read_facet() {
    PreciseFacet facet;
    const uint64_t line = scanner_.line();
    if (Status status = expect({"normal"}); !status.ok()) return status;
    if (Status status = read_vector(facet.normal); !status.ok()) return status;
    if (Status status = expect({"outer", "loop"}); !status.ok()) return status;
    for (PrecisePosition& corner : facet.corners) {
      if (Status status = expect({"vertex"}); !status.ok()) return status;
      if (Status status = read_vector(corner); !status.ok()) return status;
    }
    if (Status status = expect({"endloop", "endfacet"}); !status.ok()) return status;
    return has_finite_corners(facet) ? sink_.add(facet) : error_at_line(line, "a position that is not finite");
  }

  Scanner& scanner_;
  FacetSink& sink_;
  Losses& losses_;
  std::string name_;
  bool inside_ = false;
};

Status read_binary(Scanner& scanner, FacetSink& sink, Losses& losses) {
  const std::string_view header = scanner.peek(kHeaderBytes);
  if (header.size() < kHeaderBytes) return invalid_input("STL: the file ends inside its header");
  const uint32_t count = facet_count_of(header);
  scanner.skip(kHeaderBytes);
  const auto ends_early = [&](uint64_t there) {
    return invalid_input("STL: the file claims " + std::to_string(count) + " facets but ends after " +
                         std::to_string(there));
  };
  if (const auto left = scanner.bytes_left(); left && *left / kFacetBytes < count)
    return ends_early(*left / kFacetBytes);
  uint64_t with_attributes = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t offset = scanner.offset();
    const std::string_view bytes = scanner.peek(kFacetBytes);
    if (bytes.size() < kFacetBytes) return ends_early(i);
    Facet facet;
    static_assert(sizeof(facet) == 48);
    std::memcpy(&facet, bytes.data(), sizeof(facet));
    with_attributes += bytes[48] != 0 || bytes[49] != 0;
    scanner.skip(kFacetBytes);
    if (!has_finite_corners(facet))
      return error_at_byte(offset, "a position of facet " + std::to_string(i) + " is not finite");
    if (Status status = sink.add(facet); !status.ok()) return status;
  }
  losses.add("facet has two attribute bytes, which are left out",
             "facets have two attribute bytes each, which are left out", with_attributes);
  losses.add("byte after the last facet is not read", "bytes after the last facet are not read",
             scanner.drain());
  sink.end_solid("", scanner.offset());
  return {};
}

}  // namespace

size_t SoupPoint::hash() const {
  uint64_t state = 0x9e3779b97f4a7c15;
  for (const uint32_t word : bits()) {
    state = (state ^ word) * 0xff51afd7ed558ccd;
    state ^= state >> 32;
  }
  return static_cast<size_t>(state);
}

bool has_size_of_binary_stl(Scanner& scanner) {
  const std::optional<uint64_t> size = scanner.bytes_left();
  const std::string_view header = scanner.peek(kHeaderBytes);
  return size && header.size() == kHeaderBytes &&
         *size == kHeaderBytes + uint64_t{facet_count_of(header)} * kFacetBytes;
}

bool is_text_stl(Scanner& scanner) {
  if (has_size_of_binary_stl(scanner)) return false;
  std::string_view text = scanner.peek(size_t{1} << 16);
  constexpr std::string_view kSpaces = " \t\r\n";
  const size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos || text.size() - begin < 5 || !is_word(text.substr(begin, 5), "solid"))
    return false;
  // Names may be in any encoding. But no text contains a zero byte, and nearly every file of floats does.
  return text.find('\0') == std::string_view::npos;
}

Status read_stl(Scanner& scanner, FacetSink& sink, Losses& losses) {
  return is_text_stl(scanner) ? TextReader(scanner, sink, losses).read() : read_binary(scanner, sink, losses);
}

std::optional<uint32_t> facet_count_of_binary_stl(Scanner& scanner) {
  if (is_text_stl(scanner)) return std::nullopt;
  const std::string_view header = scanner.peek(kHeaderBytes);
  return header.size() < kHeaderBytes ? std::nullopt : std::optional(facet_count_of(header));
}

Expected<MeshFile> read_stl(Scanner& scanner, const OriginChoice& choice) {
  MeshFile file;
  SolidBuilder solids(file.losses);
  const bool is_text = is_text_stl(scanner);
  if (Status status = read_stl(scanner, solids, file.losses); !status.ok()) return status;
  file.objects = solids.take(choice);
  if (!is_text) settle_positions(file, choice);
  if (file.objects.empty() && scanner.failure().ok()) return invalid_input("STL: no facets");
  return file;
}

}  // namespace psplit
