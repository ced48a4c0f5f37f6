#include "mesh_files/obj.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>
#include <set>
#include <type_traits>

#include "mesh_files/asset_format.h"
#include "mesh_files/point_table.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = UINT32_MAX;

using Corner = ObjCorner;

// A point of a part. Parts share no points.
struct Point {
  uint32_t part = 0;
  Corner corner;
  bool operator==(const Point& other) const { return part == other.part && corner == other.corner; }
  size_t hash() const {
    uint64_t state = uint64_t{corner.position} << 32 | corner.texcoord;
    state = (state ^ state >> 33) * 0xff51afd7ed558ccd;
    state ^= uint64_t{corner.normal} << 32 | part;
    state = (state ^ state >> 33) * 0xc4ceb9fe1a85ec53;
    return static_cast<size_t>(state ^ state >> 29);
  }
};

// The largest index of one kind that a face names, and its line: the vertex may follow later in the file.
struct Named {
  uint64_t most = 0, line = 0;
};

class ObjReader {
 public:
  // With a sink, values and faces go to it, and not into memory.
  ObjReader(Scanner& scanner, const OpenLibrary& open_library, ObjSink* sink)
      : scanner_(scanner), open_library_(open_library), sink_(sink), polygons_(file_.losses) {}

  Expected<MeshFile> read() {
    if (Status status = read_lines(); !status.ok()) return status;
    finish();
    return std::move(file_);
  }

  Expected<ObjHead> read_head() {
    if (Status status = read_lines(); !status.ok()) return status;
    say_losses();
    const auto [object, material] = only_part_.value_or(std::pair(object_, material_));
    file_.objects.push_back({object_names_[object], {}});
    const int64_t used = use(material);
    return ObjHead{std::move(file_), used};
  }

 private:
  Status read_lines() {
    do {
      if (!read_line()) return error_;
    } while (scanner_.next_line());
    if (!add_pending()) return error_;
    polygons_.finish();
    if (named_.most > positions_.count)
      return error_at_line(named_.line, "a face names vertex " + std::to_string(named_.most) +
                                            ", but there are " + std::to_string(positions_.count));
    return positions_.count == 0 ? invalid_input("OBJ: no vertices") : Status();
  }

  // The values of "v", "vt" or "vn". They are empty if there is a sink.
  template <typename Value>
  struct Values {
    ObjValues kind;
    std::vector<Value> values{};
    size_t count = 0;
    const Value& operator[](size_t i) const { return values[i]; }
  };
  template <typename Value>
  bool put(Values<Value>& to, const Value& value) {
    ++to.count;
    if (sink_ == nullptr)
      to.values.push_back(value);
    else if constexpr (std::is_same_v<Value, PrecisePosition>)
      error_ = sink_->add_position(value);
    else
      error_ = sink_->add_value(to.kind, value);
    return error_.ok();
  }

  struct Part {
    size_t object = 0;
    int64_t material = -1;
    bool texcoords = false, normals = false;
    uint32_t point_count = 0;
    Array<std::array<uint32_t, 3>> faces;
    auto key() const { return std::tuple(object, material, texcoords, normals); }
  };

  bool fail(const std::string& what) {
    if (error_.ok()) error_ = error_at_line(scanner_.line(), what);
    return false;
  }

  // The next word of this line, or of the next line if a backslash ends this one.
  std::string_view word() {
    for (;;) {
      const std::string_view found = scanner_.word();
      if (found.starts_with('#')) {
        scanner_.skip_rest_of_line();
        return {};
      }
      if (!found.ends_with('\\')) return found;
      word_before_end_ = found;
      const std::string_view next = scanner_.peek(1);
      if (!next.starts_with('\n') && !next.starts_with('\r')) return word_before_end_;
      scanner_.next_line();
      word_before_end_.pop_back();
      if (!word_before_end_.empty()) return word_before_end_;
    }
  }

  bool read_line() {
    const std::string_view keyword = word();
    if (keyword.empty()) return true;
    if (keyword == "v") return read_position();
    if (keyword == "vt") return read_texcoord();
    if (keyword == "vn") return read_normal();
    if (keyword == "f" || keyword == "fo") return read_face();
    if (keyword == "o") return begin_object();
    if (keyword == "usemtl") return use_material();
    if (keyword == "mtllib") return read_library();
    if (keyword == "l" || keyword == "p") {
      file_.losses.add("line or point is left out", "lines and points are left out");
    } else if (keyword != "g" && keyword != "s" && keyword != "vp") {
      const std::string name = in_quotes(keyword);
      // All statements of OBJ begin with a letter; otherwise the file is not OBJ.
      if (!std::isalpha(static_cast<unsigned char>(keyword[0])))
        return fail(name + " is not a statement of OBJ");
      if (++unknown_count_ <= kMostUnknown) file_.losses.say("lines that begin with " + name + " are left out");
    }
    while (!word().empty()) {  // the statement may continue in the next line
    }
    return true;
  }

  // Reads numbers to the end of the line, at most values.size(). False if a word is not a number.
  // The nearest float of each is that of its word.
  bool read_numbers(std::span<double> values, size_t& count) {
    for (count = 0;; ++count) {
      const std::string_view found = word();
      if (found.empty()) return true;
      if (count == values.size()) return true;
      const std::optional<double> number = parse_precise(found);
      if (!number) return fail(in_quotes(found) + " is not a number");
      values[count] = *number;
    }
  }

  static std::array<float, 3> floats_of(const double* values) {
    return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
  }

  bool read_position() {
    std::array<double, 7> values;
    size_t count = 0;
    if (!read_numbers(values, count)) return false;
    if (count < 3) return fail("a vertex of fewer than 3 numbers");
    if (positions_.count == kNone - 1) return fail("more vertices than 32 bits can count");
    const PrecisePosition position{values[0], values[1], values[2]};
    if (!is_finite(position)) return fail("a position that is not finite");
    if (!put(positions_, position)) return false;
    // Either all vertices have colours, or colours are left out.
    if (count == 6 && colors_.count + 1 == positions_.count) return put(colors_, floats_of(&values[3]));
    if (count == 6 || colors_.count > 0) some_lack_colors_ = true;
    return true;
  }

  // 1 - v is rounded once: v may have more digits than a float.
  bool read_texcoord() {
    std::array<double, 3> values{};
    size_t count = 0;
    for (; count < values.size(); ++count) {
      const std::string_view found = word();
      if (found.empty()) break;
      const std::optional<double> number =
          count == 1 ? parse_double(found) : std::optional<double>(parse_float(found));
      if (!number) return fail(in_quotes(found) + " is not a number");
      values[count] = *number;
    }
    if (count == 0) return fail("texture coordinates without a number");
    if (texcoords_.count == kNone - 1) return fail("more texture coordinates than 32 bits can count");
    return put(texcoords_, std::array{static_cast<float>(values[0]), static_cast<float>(1 - values[1])});
  }

  bool read_normal() {
    std::array<double, 3> values{};
    size_t count = 0;
    if (!read_numbers(values, count)) return false;
    if (count < 3) return fail("a normal of fewer than 3 numbers");
    if (normals_.count == kNone - 1) return fail("more normals than 32 bits can count");
    return put(normals_, floats_of(values.data()));
  }

  // An index of a corner: counted from 1, or from the end if it is negative.
  bool parse_index(std::string_view text, size_t count, uint32_t& index) {
    const std::optional<int64_t> number = parse_integer(text);
    if (!number) return fail(in_quotes(text) + " is not a vertex number");
    if (*number == 0) return fail("a face names vertex 0, but vertices are counted from 1");
    if (*number < 0 && static_cast<uint64_t>(-(*number + 1)) >= count)
      return fail("a face names vertex " + std::to_string(*number) + ", but there are " +
                  std::to_string(count) + " before it");
    const int64_t found = *number < 0 ? static_cast<int64_t>(count) + *number : *number - 1;
    if (found >= int64_t{kNone}) return fail("a face names vertex " + std::to_string(*number));
    index = static_cast<uint32_t>(found);
    return true;
  }

  // "7", "7/1", "7//2" or "7/1/2".
  bool parse_corner(std::string_view text, Corner& corner) {
    const size_t first = std::min(text.find('/'), text.size());
    if (!parse_index(text.substr(0, first), positions_.count, corner.position)) return false;
    if (corner.position >= named_.most) named_ = {uint64_t{corner.position} + 1, scanner_.line()};
    if (first == text.size()) return true;
    const std::string_view rest = text.substr(first + 1);
    const size_t second = std::min(rest.find('/'), rest.size());
    if (second > 0 && !parse_index(rest.substr(0, second), texcoords_.count, corner.texcoord)) return false;
    if (second + 1 >= rest.size()) return true;
    return parse_index(rest.substr(second + 1), normals_.count, corner.normal);
  }

  bool read_face() {
    corners_.clear();
    bool known = true;
    for (std::string_view found = word(); !found.empty(); found = word()) {
      Corner corner;
      if (!parse_corner(found, corner)) return false;
      const auto is_there = [](uint32_t index, size_t count) { return index == kNone || index < count; };
      known = known && is_there(corner.position, positions_.count) &&
              is_there(corner.texcoord, texcoords_.count) && is_there(corner.normal, normals_.count);
      corners_.push_back(corner);
    }
    if (sink_ != nullptr) return give_face();
    if (known) return add_face(corners_, object_, material_);
    // A face may come before its vertices: it is then processed at the end of the file.
    pending_.push_back({corners_, object_, material_});
    return true;
  }

  bool give_face() {
    const std::pair part(object_, material_);
    error_ = only_part_.value_or(part) == part
                 ? sink_->add_face(corners_)
                 : unsupported("OBJ: faces of several objects or materials are not read part by part");
    only_part_ = part;
    return error_.ok();
  }

  bool add_face(std::vector<Corner>& corners, size_t object, int64_t material) {
    bool texcoords = true, normals = true;
    for (Corner& corner : corners) {
      const auto check = [&](uint32_t& index, size_t count, uint64_t& missing) {
        if (index != kNone && index >= count) ++missing, index = kNone;
        return index != kNone;
      };
      texcoords = check(corner.texcoord, texcoords_.count, missing_texcoords_) && texcoords;
      normals = check(corner.normal, normals_.count, missing_normals_) && normals;
    }
    Part* const part = part_of(object, material, texcoords, normals);
    if (part == nullptr) return false;
    const auto part_number = static_cast<uint32_t>(part - parts_.data());
    numbers_.clear();
    corner_positions_.clear();
    for (Corner corner : corners) {
      if (!texcoords) corner.texcoord = kNone;
      if (!normals) corner.normal = kNone;
      if (points_.points().size() == kNone - 1) return fail("more points than 32 bits can count");
      const auto [index, is_new] = points_.find_or_add({part_number, corner});
      if (is_new) numbers_in_parts_.push_back(part->point_count++);
      numbers_.push_back(numbers_in_parts_[index]);
      if (corners.size() > 3) corner_positions_.push_back(positions_[corner.position]);
    }
    polygons_.add(numbers_, corner_positions_, part->faces);
    return true;
  }

  bool add_pending() {
    for (Pending& face : pending_) {
      for (const Corner& corner : face.corners)
        if (corner.position >= positions_.count) return true;  // named_ reports it
      if (!add_face(face.corners, face.object, face.material)) return false;
    }
    return true;
  }

  // A part takes few bytes of OBJ but many bytes of JSON.
  Part* part_of(size_t object, int64_t material, bool texcoords, bool normals) {
    Part wanted{object, material, texcoords, normals, 0, {}};
    if (last_part_ < parts_.size() && parts_[last_part_].key() == wanted.key()) return &parts_[last_part_];
    const auto [found, is_new] = part_numbers_.try_emplace(wanted.key(), parts_.size());
    last_part_ = found->second;
    if (!is_new) return &parts_[last_part_];
    constexpr size_t kFewParts = 1024, kBytesOfPart = 128;
    if (parts_.size() >= kFewParts + scanner_.offset() / kBytesOfPart) {
      error_ = unsupported("OBJ: " + std::to_string(parts_.size()) + " objects and materials in " +
                           std::to_string(scanner_.offset()) + " bytes are too many");
      return nullptr;
    }
    parts_.push_back(std::move(wanted));
    return &parts_.back();
  }

  bool begin_object() {
    const std::optional<std::string> name = scanner_.rest_of_line();
    if (!name) return fail("a name that is too long");
    // A repeated name continues its object. The first name also names the unnamed object, if that has no faces.
    const auto [found, is_new] = object_numbers_.try_emplace(*name, object_names_.size());
    if (is_new) object_names_.push_back(*name);
    object_ = found->second;
    return true;
  }

  bool use_material() {
    const std::optional<std::string> name = scanner_.rest_of_line();
    if (!name) return fail("a name that is too long");
    const auto [found, is_new] =
        material_numbers_.try_emplace(*name, static_cast<int64_t>(material_names_.size()));
    if (is_new) material_names_.push_back(*name);
    material_ = found->second;
    return true;
  }

  // The line names one file, whose name may contain spaces, or several files. Each existing library is read
  // once.
  bool read_library() {
    const std::optional<std::string> line = scanner_.rest_of_line();
    if (!line || line->empty()) return fail("a library without a name, or with one that is too long");
    if (add_library(*line)) return true;
    bool found = false;
    for (size_t at = 0; at < line->size() && line->find_first_of(" \t") != std::string::npos;) {
      const size_t end = std::min(line->find_first_of(" \t", at), line->size());
      if (end > at) found = add_library(line->substr(at, end - at)) || found;
      at = end + 1;
    }
    if (!found) file_.losses.say("the library of materials " + in_quotes(*line) + " cannot be read");
    return true;
  }

  // Returns whether the file exists.
  bool add_library(const std::string& name) {
    constexpr size_t kMostLibraries = 64;
    if (libraries_.contains(name)) return true;
    if (libraries_.size() == kMostLibraries) return false;
    Expected<std::unique_ptr<ByteStream>> stream = open_library_(name);
    if (!stream) return false;
    libraries_.insert(name);
    if (Expected<Scanner> scanner = open_scanner(std::move(*stream)))
      materials_.read(*scanner, file_.losses);
    else
      file_.losses.say("the library of materials " + in_quotes(name) +
                       " is not read: " + scanner.status().message());
    return true;
  }

  template <size_t N>
  static Attribute attribute_of(const char* semantic, const std::vector<std::array<float, N>>& values,
                                const std::vector<uint32_t>& indices) {
    Attribute attribute{semantic, ComponentType::kFloat32, static_cast<uint8_t>(N), false, {}};
    attribute.values.resize(indices.size() * sizeof(values[0]));
    for (size_t i = 0; i < indices.size(); ++i)
      std::memcpy(attribute.values.data() + i * sizeof(values[0]), values[indices[i]].data(),
                  sizeof(values[0]));
    return attribute;
  }

  // Gathers the attributes of each part's points.
  MeshFilePart gathered(Part& part, const std::vector<uint32_t>& points) const {
    MeshFilePart result;
    Mesh& mesh = result.mesh;
    mesh.point_count = part.point_count;
    mesh.faces = std::move(part.faces);
    std::vector<uint32_t> indices(points.size());
    const auto fill = [&](auto member) {
      for (size_t i = 0; i < points.size(); ++i) indices[i] = points_.points()[points[i]].corner.*member;
    };
    fill(&Corner::position);
    mesh.attributes.push_back({"POSITION", ComponentType::kFloat32, 3, false, {}});
    result.positions.reserve(indices.size());
    for (const uint32_t index : indices) result.positions.push_back(positions_[index]);
    if (colors_.count > 0 && !some_lack_colors_)
      mesh.attributes.push_back(attribute_of("COLOR_0", colors_.values, indices));
    if (part.normals) {
      fill(&Corner::normal);
      mesh.attributes.push_back(attribute_of("NORMAL", normals_.values, indices));
    }
    if (part.texcoords) {
      fill(&Corner::texcoord);
      mesh.attributes.push_back(attribute_of("TEXCOORD_0", texcoords_.values, indices));
    }
    return result;
  }

  // The index of a material in file_.
  int64_t use(int64_t material) {
    return material < 0 ? -1 : materials_.use(material_names_[static_cast<size_t>(material)], file_);
  }

  void say_losses() {
    Losses& losses = file_.losses;
    if (unknown_count_ > kMostUnknown) losses.say("lines that begin with other words are left out");
    if (some_lack_colors_) losses.say("some vertices have no colours: all colours are left out");
    say_missing(losses, missing_texcoords_, missing_normals_);
  }

  void finish() {
    points_.drop_table();
    numbers_in_parts_ = std::vector<uint32_t>();
    say_losses();
    std::vector<std::vector<uint32_t>> points_of_part(parts_.size());
    for (uint32_t i = 0; i < points_.points().size(); ++i)
      points_of_part[points_.points()[i].part].push_back(i);
    for (const std::string& name : object_names_) file_.objects.push_back({name, {}});
    for (size_t i = 0; i < parts_.size(); ++i) {
      Part& part = parts_[i];
      if (part.faces.empty()) continue;
      const int64_t material = use(part.material);
      file_.objects[part.object].parts.push_back(gathered(part, points_of_part[i]));
      file_.objects[part.object].parts.back().material = material;
      points_of_part[i] = {};
    }
    if (has_only_points(file_)) file_.objects[0].parts.push_back(vertices());
  }

  // The vertices of a file without faces. Nothing says which normals they have.
  MeshFilePart vertices() const {
    MeshFilePart part;
    part.mesh.point_count = static_cast<uint32_t>(positions_.count);
    part.mesh.attributes.push_back({"POSITION", ComponentType::kFloat32, 3, false, {}});
    std::vector<uint32_t> indices(positions_.count);
    std::iota(indices.begin(), indices.end(), 0u);
    for (const uint32_t index : indices) part.positions.push_back(positions_[index]);
    if (colors_.count > 0 && !some_lack_colors_)
      part.mesh.attributes.push_back(attribute_of("COLOR_0", colors_.values, indices));
    return part;
  }

  struct Pending {
    std::vector<Corner> corners;
    size_t object;
    int64_t material;
  };

  static constexpr size_t kMostUnknown = 8;
  Scanner& scanner_;
  const OpenLibrary& open_library_;
  ObjSink* const sink_;
  std::optional<std::pair<size_t, int64_t>> only_part_;  // of a sink: its object and its material
  MeshFile file_;
  PolygonReader polygons_;
  MaterialLibrary materials_;
  Status error_;
  std::string word_before_end_;

  Values<PrecisePosition> positions_{ObjValues::kPosition};
  Values<std::array<float, 3>> normals_{ObjValues::kNormal}, colors_{ObjValues::kColor};
  Values<std::array<float, 2>> texcoords_{ObjValues::kTexcoord};
  bool some_lack_colors_ = false;

  std::vector<std::string> object_names_{""}, material_names_;
  std::map<std::string, size_t> object_numbers_;
  std::map<std::string, int64_t> material_numbers_;
  std::set<std::string> libraries_;
  size_t object_ = 0;
  int64_t material_ = -1;

  std::vector<Part> parts_;
  std::map<std::tuple<size_t, int64_t, bool, bool>, size_t> part_numbers_;
  size_t last_part_ = 0;
  PointTable<Point> points_;
  std::vector<uint32_t> numbers_in_parts_;  // of these points
  std::vector<Pending> pending_;
  Named named_;
  uint64_t missing_texcoords_ = 0, missing_normals_ = 0, unknown_count_ = 0;

  std::vector<Corner> corners_;  // the corners of one face
  std::vector<uint32_t> numbers_;
  std::vector<PrecisePosition> corner_positions_;
};

}  // namespace

void say_missing(Losses& losses, uint64_t texcoords, uint64_t normals) {
  losses.add("corner names texture coordinates that do not exist: its face gets none",
             "corners name texture coordinates that do not exist: their faces get none", texcoords);
  losses.add("corner names a normal that does not exist: its face gets none",
             "corners name normals that do not exist: their faces get none", normals);
}

Expected<MeshFile> read_obj(Scanner& scanner, const OpenLibrary& open_library) {
  return ObjReader(scanner, open_library, nullptr).read();
}

Expected<ObjHead> read_obj_into(Scanner& scanner, const OpenLibrary& open_library, ObjSink& sink) {
  return ObjReader(scanner, open_library, &sink).read_head();
}

}  // namespace psplit
