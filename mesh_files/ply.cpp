#include "mesh_files/ply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "mesh_files/face_texcoords.h"
#include "mesh_files/mtl.h"
#include "mesh_files/own_semantics.h"
#include "mesh_files/plain_numbers.h"
#include "mesh_files/plain_rows.h"
#include "mesh_files/rounded_numbers.h"

namespace psplit {
namespace {

constexpr size_t kNoAttribute = SIZE_MAX;

// The destination of a property of a vertex.
struct Target {
  size_t attribute = kNoAttribute;  // kNoAttribute: it is left out
  size_t component = 0;
};

ComponentType stored_type_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8: return ComponentType::kInt8;
    case PlyType::kUint8: return ComponentType::kUint8;
    case PlyType::kInt16: return ComponentType::kInt16;
    case PlyType::kUint16: return ComponentType::kUint16;
    default: return ComponentType::kFloat32;
  }
}

// The attributes of a vertex, and the destination of each property. The attributes hold the values of a block
// of points.
class VertexLayout {
 public:
  explicit VertexLayout(const PlyElement& element) : element_(element), targets_(element.properties.size()) {}

  // False if there are no positions.
  bool plan(Losses& losses) {
    if (!take("POSITION", {"x", "y", "z"}, ComponentType::kFloat32, false)) return false;
    for (const char* name : {"x", "y", "z"}) {
      const PlyType type = element_.properties[find(name)].type;
      is_precise_ =
          is_precise_ || type == PlyType::kFloat64 || type == PlyType::kInt32 || type == PlyType::kUint32;
    }
    take("NORMAL", {"nx", "ny", "nz"}, ComponentType::kFloat32, false);
    take_colors();
    for (const auto& [s, t] :
         {std::pair{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}})
      if (texcoord_ == kNoAttribute && take("TEXCOORD_0", {s, t}, ComponentType::kFloat32, false))
        texcoord_ = attributes_.size() - 1;
    std::string kept;
    for (size_t i = 0; i < element_.properties.size(); ++i) {
      const PlyProperty& property = element_.properties[i];
      if (property.is_list) losses.say("the lists " + in_quotes(property.name) + " of vertices are left out");
      if (property.is_list || targets_[i].attribute != kNoAttribute) continue;
      targets_[i] = {attributes_.size(), 0};
      attributes_.push_back({own_.add(property.name), stored_type_of(property.type), 1, false, {}});
      kept += (kept.empty() ? "" : ", ") + attributes_.back().semantic;
    }
    if (!kept.empty()) losses.say("other properties of vertices become attributes: " + kept);
    return true;
  }

  std::vector<Attribute>& attributes() { return attributes_; }
  // Whether positions may say more than floats can. Then they are in positions(), and not among the attributes.
  bool is_precise() const { return is_precise_; }
  std::vector<PrecisePosition>& positions() { return positions_; }
  const std::vector<Target>& targets() const { return targets_; }
  void flip_texcoords() {
    if (texcoord_ != kNoAttribute) flip_v(attributes_[texcoord_].values);
  }

 private:
  size_t find(std::string_view name) const {
    for (size_t i = 0; i < element_.properties.size(); ++i)
      if (!element_.properties[i].is_list && element_.properties[i].name == name) return i;
    return kNoAttribute;
  }

  bool take(const char* semantic, const std::vector<const char*>& names, ComponentType type, bool normalized) {
    std::vector<size_t> found;
    for (const char* name : names) found.push_back(find(name));
    if (std::ranges::find(found, kNoAttribute) != found.end()) return false;
    for (size_t i = 0; i < found.size(); ++i) targets_[found[i]] = {attributes_.size(), i};
    attributes_.push_back({semantic, type, static_cast<uint8_t>(names.size()), normalized, {}});
    return true;
  }

  void take_colors() {
    static const std::vector<std::vector<const char*>> kNames = {
        {"red", "green", "blue", "alpha"},
        {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"},
        {"r", "g", "b", "a"}};
    for (std::vector<const char*> names : kNames) {
      if (find(names[0]) == kNoAttribute) continue;
      const PlyType type = element_.properties[find(names[0])].type;
      const auto has_type = [&](const char* name) {
        return find(name) != kNoAttribute && element_.properties[find(name)].type == type;
      };
      if (!has_type(names[3])) names.pop_back();
      const bool floats = type == PlyType::kFloat32 || type == PlyType::kFloat64;
      if (!floats && type != PlyType::kUint8 && type != PlyType::kUint16) continue;
      if (std::ranges::all_of(names, has_type) && take("COLOR_0", names, stored_type_of(type), !floats)) return;
    }
  }

  const PlyElement& element_;
  std::vector<Attribute> attributes_;
  std::vector<PrecisePosition> positions_;
  bool is_precise_ = false;
  std::vector<Target> targets_;
  OwnSemantics own_;
  size_t texcoord_ = kNoAttribute;
};

template <typename T>
T load_value(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes, sizeof(T));
  if (swap) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

double load_double(const char* bytes, PlyType type, bool swap) {
  switch (type) {
    case PlyType::kInt8: return load_value<int8_t>(bytes, swap);
    case PlyType::kUint8: return load_value<uint8_t>(bytes, swap);
    case PlyType::kInt16: return load_value<int16_t>(bytes, swap);
    case PlyType::kUint16: return load_value<uint16_t>(bytes, swap);
    case PlyType::kInt32: return load_value<int32_t>(bytes, swap);
    case PlyType::kUint32: return load_value<uint32_t>(bytes, swap);
    case PlyType::kFloat32: return double{load_value<float>(bytes, swap)};
    case PlyType::kFloat64: return load_value<double>(bytes, swap);
  }
  return 0;
}

std::pair<double, double> range_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8: return {-0x80, 0x7f};
    case PlyType::kUint8: return {0, 0xff};
    case PlyType::kInt16: return {-0x8000, 0x7fff};
    case PlyType::kUint16: return {0, 0xffff};
    case PlyType::kInt32: return {-2147483648.0, 2147483647.0};
    case PlyType::kUint32: return {0, 4294967295.0};
    default: return {-HUGE_VAL, HUGE_VAL};
  }
}

// Reads values one after the other from text or binary data. Keeps the first error.
class Values {
 public:
  Values(Scanner& scanner, PlyEncoding encoding)
      : scanner_(scanner),
        text_(encoding == PlyEncoding::kText),
        swap_((encoding == PlyEncoding::kLittleEndian) != (std::endian::native == std::endian::little)) {}

  bool is_text() const { return text_; }
  bool swaps() const { return swap_; }
  Scanner& scanner() { return scanner_; }

  // Reads a float directly as a float, so that a number in text is not rounded twice.
  bool next(PlyType type, double& value) {
    if (text_) return next_of_text(type, value);
    const std::string_view bytes = scanner_.peek(ply_type_bytes(type));
    if (bytes.size() < ply_type_bytes(type)) return fail("the file ends inside its " + what_);
    value = load_double(bytes.data(), type, swap_);
    scanner_.skip(bytes.size());
    return true;
  }

  // In text, an element ends with its line.
  bool end_element() {
    if (!text_) return true;
    const std::string_view word = scanner_.word();
    return word.empty() || fail(in_quotes(word) + " is more than the header states");
  }

  // Sets the error, with this place, and returns false.
  bool fail(const std::string& what) {
    if (error_.ok())
      error_ = text_ ? error_at_line(scanner_.line(), what) : error_at_byte(scanner_.offset(), what);
    return false;
  }
  bool fail(Status status) {
    if (error_.ok()) error_ = std::move(status);
    return false;
  }
  const Status& error() const { return error_; }
  void set_element(const std::string& name) { what_ = "element " + in_quotes(name); }

 private:
  bool next_of_text(PlyType type, double& value) {
    const std::string_view word = scanner_.next_word();
    if (word.empty()) return fail("the file ends inside its " + what_);
    const bool is_whole = type != PlyType::kFloat32 && type != PlyType::kFloat64;
    if (is_whole)
      if (const std::optional<int64_t> integer = parse_integer(word))
        return in_range(type, word, static_cast<double>(*integer), value);
    const std::optional<double> number =
        type == PlyType::kFloat32 ? std::optional<double>(parse_float(word)) : parse_double(word);
    if (!number) return fail(in_quotes(word) + " is not a number");
    if (is_whole && !(std::floor(*number) == *number)) return fail(in_quotes(word) + " is not a whole number");
    return in_range(type, word, *number, value);
  }

  bool in_range(PlyType type, std::string_view word, double number, double& value) {
    const auto [least, most] = range_of(type);
    if (number < least || number > most) return fail(in_quotes(word) + " is out of its type's range");
    value = number;
    return true;
  }

  Scanner& scanner_;
  bool text_, swap_;
  std::string what_;
  Status error_;
};

// Reads a vertex whose properties are all floats or small whole numbers.
class PlainVertexReader {
 public:
  using Rows = std::vector<Array<std::byte>>;  // the values of each attribute

  PlainVertexReader(const PlyElement& element, VertexLayout& layout) {
    for (const Attribute& attribute : layout.attributes()) strides_.push_back(attribute.stride());
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      is_possible_ &= !property.is_list && property.type != PlyType::kFloat64;
      const Target& target = layout.targets()[i];
      if (target.attribute == kNoAttribute) continue;
      const ComponentType type = layout.attributes()[target.attribute].component_type;
      columns_.push_back({target.attribute, target.component * component_bytes(type), component_bytes(type),
                          type == ComponentType::kFloat32, property.type == PlyType::kFloat32,
                          range_of(property.type).second});
    }
    is_possible_ &= columns_.size() == element.properties.size() && !layout.is_precise();
  }

  bool is_possible() const { return is_possible_; }

  void reserve(Rows& rows, size_t count) const {
    rows.resize(strides_.size());
    for (size_t i = 0; i < strides_.size(); ++i) rows[i].reserve(count * strides_[i]);
  }
  void resize(Rows& rows, size_t count) const {
    rows.resize(strides_.size());
    for (size_t i = 0; i < strides_.size(); ++i) rows[i].resize(count * strides_[i]);
  }

  const char* read_row(const char* at, const char* end, Rows& rows, size_t row) const {
    bool is_first = true;
    for (const Column& column : columns_) {
      if (!is_first && !skip_blanks(at)) return nullptr;
      is_first = false;
      std::byte* const to = rows[column.attribute].data() + row * strides_[column.attribute] + column.offset;
      if (column.is_float) {
        float value = 0;
        at = parse_plain_float(at, end, value);
        std::memcpy(to, &value, sizeof value);
      } else {
        uint32_t value = 0;
        at = parse_plain_integer(at, end, value);
        if (static_cast<double>(value) > column.most) return nullptr;
        const auto as_float = static_cast<float>(value);
        if (column.becomes_float && static_cast<double>(as_float) != static_cast<double>(value))
          return nullptr;  // to be counted
        // Little-endian, as every host of this library.
        const uint32_t bits = column.becomes_float ? std::bit_cast<uint32_t>(as_float) : value;
        std::memcpy(to, &bits, column.width);
      }
      if (at == nullptr) return nullptr;
    }
    return at;
  }

 private:
  struct Column {
    size_t attribute, offset, width;
    bool becomes_float, is_float;
    double most;
  };
  std::vector<Column> columns_;
  std::vector<size_t> strides_;  // of attributes
  bool is_possible_ = true;
};

// Reads a triangle that has no other properties.
class PlainTriangleReader {
 public:
  using Rows = Array<std::array<uint32_t, 3>>;

  explicit PlainTriangleReader(uint32_t point_count) : point_count_(point_count) {}

  void reserve(Rows& rows, size_t count) const { rows.reserve(count); }
  void resize(Rows& rows, size_t count) const { rows.resize(count); }

  const char* read_row(const char* at, const char* end, Rows& rows, size_t row) const {
    if (*at++ != '3') return nullptr;
    std::array<uint32_t, 3> triangle;
    for (uint32_t& corner : triangle) {
      if (!skip_blanks(at)) return nullptr;
      at = parse_plain_integer(at, end, corner);
      if (at == nullptr || corner >= point_count_) return nullptr;
    }
    rows[row] = triangle;
    return at;
  }

 private:
  uint32_t point_count_;
};

// Decides when plain rows are tried: rarely, if many rows are not plain.
class PlainAttempts {
 public:
  explicit PlainAttempts(bool is_possible) : is_possible_(is_possible) {}

  bool is_due(uint64_t row) const { return is_possible_ && row >= next_; }
  // An attempt read `count` rows up to `row`. `is_complete`: it came to no other row.
  void note(uint64_t row, uint64_t count, bool is_complete) {
    if (is_complete && count > 0) return;
    wait_ = count < wait_ ? std::min(2 * wait_, kMostWait) : kLeastWait;
    next_ = row + wait_;
  }

 private:
  static constexpr uint64_t kLeastWait = 1 << 10, kMostWait = 1 << 20;
  bool is_possible_;
  uint64_t next_ = 0, wait_ = kLeastWait;
};

class PlyReader {
 public:
  // `texcoords` gets the texture coordinates of faces. Null: they are left out.
  PlyReader(Scanner& scanner, const PlyHeader& header, MeshSink& sink, Losses& losses, FaceTexcoords* texcoords,
            const ThreadPool& pool)
      : header_(header),
        pool_(pool),
        values_(scanner, header.encoding),
        sink_(sink),
        losses_(losses),
        polygons_(losses),
        texcoords_(texcoords) {}

  Status read() {
    for (const PlyElement& element : header_.elements) {
      values_.set_element(element.name);
      const PlyProperty* const indices = indices_of(element);
      const bool reads = element.name == "vertex" ? read_vertices(element)
                         : indices != nullptr     ? read_faces(element, *indices)
                                                  : skip_element(element);
      if (!reads) return values_.error();
    }
    polygons_.finish();
    if (!read_trailer()) return values_.error();
    return point_count_ == 0 ? invalid_input("PLY: no vertices") : Status();
  }

 private:
  static constexpr uint64_t kMostPoints = UINT32_MAX - 1;

  static const PlyProperty* indices_of(const PlyElement& element) {
    if (element.name != "face" && element.name != "faces" && element.name != "tristrips") return nullptr;
    for (const PlyProperty& property : element.properties)
      if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index"))
        return &property;
    return nullptr;
  }

  // The fewest bytes that an element can take.
  static uint64_t least_bytes(const PlyElement& element, bool text) {
    uint64_t bytes = 0;
    for (const PlyProperty& property : element.properties)
      bytes += text ? 2 : ply_type_bytes(property.is_list ? property.count_type : property.type);
    return bytes;
  }

  // Fails if the rest of the file cannot hold the elements. Returns how many elements arrays may be sized for
  // before they are read: at most their number, and only what the file's known size justifies.
  bool justify(const PlyElement& element, size_t& count) {
    constexpr uint64_t kBlind = 1 << 16;
    const std::optional<uint64_t> left = values_.scanner().bytes_left();
    const uint64_t each = std::max<uint64_t>(1, least_bytes(element, values_.is_text()));
    // The last number of a text needs no space after it.
    const uint64_t most = left ? (*left + 1) / each : kBlind;
    if (left && element.count > most && !element.properties.empty())
      return values_.fail("the header claims " + std::to_string(element.count) + " elements " +
                          in_quotes(element.name) + ", which take " + std::to_string(each) +
                          " bytes each or more, and " + std::to_string(*left) + " bytes are left");
    count = static_cast<size_t>(std::min(element.count, most));
    return true;
  }

  void store(Attribute& attribute, size_t index, PlyType type, double value) {
    std::byte* const to = attribute.values.data() + index * component_bytes(attribute.component_type);
    const auto put = [&](auto stored) { std::memcpy(to, &stored, sizeof(stored)); };
    switch (attribute.component_type) {
      case ComponentType::kInt8: return put(static_cast<int8_t>(value));
      case ComponentType::kUint8: return put(static_cast<uint8_t>(value));
      case ComponentType::kInt16: return put(static_cast<int16_t>(value));
      case ComponentType::kUint16: return put(static_cast<uint16_t>(value));
      default: break;
    }
    const bool is_whole = type != PlyType::kFloat32 && type != PlyType::kFloat64;
    if (is_whole && !has_float(value)) say_rounded("whole number", attribute.semantic, 1, losses_);
    // A double beyond the range of floats becomes infinite.
    const bool fits = !(std::fabs(value) > double{std::numeric_limits<float>::max()});
    put(fits ? static_cast<float>(value)
             : std::copysign(HUGE_VALF, static_cast<float>(std::copysign(1.0, value))));
  }

  bool read_vertices(const PlyElement& element) {
    if (element.count > kMostPoints) return values_.fail("more vertices than 32 bits can count");
    VertexLayout layout(element);
    if (!layout.plan(losses_)) return values_.fail("vertices without x, y and z");
    size_t expected = 0;
    if (!justify(element, expected)) return false;
    if (!take(sink_.begin(layout.attributes(), expected, layout.is_precise()))) return false;
    constexpr uint64_t kBlock = 1024;  // points
    const PlainVertexReader plain(element, layout);
    PlainAttempts attempts(values_.is_text() && plain.is_possible());
    for (uint64_t first = 0; first < element.count;) {
      if (attempts.is_due(first)) {
        if (!read_plain_vertices(plain, layout, element.count, attempts, first)) return false;
        continue;
      }
      const auto count = static_cast<size_t>(std::min(kBlock, element.count - first));
      for (Attribute& attribute : layout.attributes()) attribute.values.resize(count * attribute.stride());
      if (layout.is_precise()) layout.positions().resize(count);
      for (size_t i = 0; i < count; ++i)
        if (!read_vertex(element, layout, first, i)) return false;
      layout.flip_texcoords();
      if (!take(sink_.add_points(layout.attributes(), count, layout.positions()))) return false;
      first += count;
    }
    has_vertices_ = true;
    point_count_ = static_cast<uint32_t>(element.count);
    return true;
  }

  // Reads the next plain rows, and adds their number to `row`.
  bool read_plain_vertices(const PlainVertexReader& reader, VertexLayout& layout, uint64_t end,
                           PlainAttempts& attempts, uint64_t& row) {
    auto slices = read_plain_rows<PlainVertexReader::Rows>(values_.scanner(), end - row, reader, pool_);
    uint64_t count = 0;
    for (auto& slice : slices) {
      if (slice.row_count == 0) continue;
      count += slice.row_count;
      for (size_t i = 0; i < slice.rows.size(); ++i) layout.attributes()[i].values.swap(slice.rows[i]);
      layout.flip_texcoords();
      if (!take(sink_.add_points(layout.attributes(), static_cast<size_t>(slice.row_count), {}))) return false;
    }
    row += count;
    attempts.note(row, count, slices.back().is_complete);
    return true;
  }

  // Vertex `first + i`, which is point i of the block.
  bool read_vertex(const PlyElement& element, VertexLayout& layout, uint64_t first, size_t i) {
    for (size_t k = 0; k < element.properties.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      if (property.is_list) {
        if (!skip_list(property)) return false;
        continue;
      }
      double value = 0;
      if (!values_.next(property.type, value)) return false;
      const Target& target = layout.targets()[k];
      if (target.attribute == 0 && layout.is_precise()) {
        layout.positions()[i][target.component] = value;
        continue;
      }
      Attribute& attribute = layout.attributes()[target.attribute];
      store(attribute, i * attribute.component_count + target.component, property.type, value);
    }
    if (layout.is_precise() ? !is_finite(layout.positions()[i])
                            : !is_finite(position_at(layout.attributes()[0], static_cast<uint32_t>(i))))
      return values_.fail("the position of vertex " + std::to_string(first + i) + " is not finite");
    return values_.end_element();
  }

  bool read_length(const PlyProperty& property, uint64_t& length) {
    double value = 0;
    if (!values_.next(property.count_type, value)) return false;
    if (value < 0) return values_.fail("a list of negative length");
    length = static_cast<uint64_t>(value);
    return true;
  }

  bool skip_list(const PlyProperty& property) {
    uint64_t length = 0;
    if (!read_length(property, length)) return false;
    double value = 0;
    for (uint64_t i = 0; i < length; ++i)
      if (!values_.next(property.type, value)) return false;
    return true;
  }

  bool skip_property(const PlyProperty& property) {
    double value = 0;
    return property.is_list ? skip_list(property) : values_.next(property.type, value);
  }

  bool skip_element(const PlyElement& element) {
    if (element.count == 0 || element.properties.empty()) return true;
    losses_.say("the elements " + in_quotes(element.name) + " are left out");
    size_t count = 0;
    if (!justify(element, count)) return false;
    for (uint64_t n = 0; n < element.count; ++n) {
      for (const PlyProperty& property : element.properties)
        if (!skip_property(property)) return false;
      if (!values_.end_element()) return false;
    }
    return true;
  }

  bool read_faces(const PlyElement& element, const PlyProperty& indices) {
    if (element.count > 0 && !has_vertices_) return values_.fail("faces before their vertices are not read");
    size_t reserved = 0;
    if (!justify(element, reserved)) return false;
    sink_.expect_faces(reserved);
    const bool strips = element.name == "tristrips";
    plan_texcoords(element, strips);
    std::string left_out;
    for (const PlyProperty& property : element.properties)
      if (&property != &indices && &property != coordinates_ && &property != texture_number_)
        left_out += (left_out.empty() ? "" : ", ") + in_quotes(property.name);
    if (!left_out.empty() && element.count > 0)
      losses_.say("other properties of faces are left out: " + left_out);
    const PlainTriangleReader plain(point_count_);
    PlainAttempts attempts(values_.is_text() && element.properties.size() == 1 && !strips);
    for (uint64_t n = 0; n < element.count; ++n) {
      while (attempts.is_due(n) && n < element.count)
        if (!read_plain_triangles(plain, element.count, attempts, n)) return false;
      if (n == element.count) break;
      for (const PlyProperty& property : element.properties) {
        const bool reads = &property == coordinates_      ? read_coordinates(property)
                           : &property == texture_number_ ? read_texture_number(property)
                           : &property != &indices        ? skip_property(property)
                           : strips                       ? read_strips(property)
                                                          : read_polygon(property);
        if (!reads) return false;
      }
      if (!strips) add_polygon();
      if (!values_.end_element() || (faces_.size() >= kMostFaces && !pass_faces())) return false;
    }
    return pass_faces();
  }

  // Reads the next plain rows, and adds their number to `row`.
  bool read_plain_triangles(const PlainTriangleReader& reader, uint64_t end, PlainAttempts& attempts,
                            uint64_t& row) {
    const auto slices = read_plain_rows<PlainTriangleReader::Rows>(values_.scanner(), end - row, reader, pool_);
    uint64_t count = 0;
    for (const auto& slice : slices) {
      count += slice.row_count;
      if (slice.row_count < kMostFaces)
        faces_.insert(faces_.end(), slice.rows.begin(), slice.rows.end());
      else if (!pass_faces() || !pass_faces(slice.rows))
        return false;
    }
    row += count;
    attempts.note(row, count, slices.back().is_complete);
    return faces_.size() < kMostFaces || pass_faces();
  }

  // Finds the properties of texture coordinates. MeshLab writes "texcoord", followed by "texnumber".
  void plan_texcoords(const PlyElement& element, bool strips) {
    coordinates_ = texture_number_ = nullptr;
    texture_ = 0;
    if (texcoords_ == nullptr || strips) return;
    for (const PlyProperty& property : element.properties)
      if (property.is_list && property.name == "texcoord") coordinates_ = &property;
    for (const PlyProperty& property : element.properties)
      if (coordinates_ != nullptr && !property.is_list && property.name == "texnumber")
        texture_number_ = &property;
    if (coordinates_ != nullptr) texcoords_->pad(passed_faces_);
  }

  bool read_coordinates(const PlyProperty& property) {
    uint64_t length = 0;
    if (!read_length(property, length)) return false;
    corner_texcoords_.clear();
    for (uint64_t i = 0; i < length; ++i) {
      double value = 0;
      if (!values_.next(property.type, value)) return false;
      // PLY counts v from the bottom of the image, glTF from the top.
      corner_texcoords_.push_back(i % 2 == 0 ? static_cast<float>(value) : 1 - static_cast<float>(value));
    }
    return true;
  }

  bool read_texture_number(const PlyProperty& property) {
    double value = 0;
    if (!values_.next(property.type, value)) return false;
    texture_ = value >= 0 && value <= INT32_MAX ? static_cast<int32_t>(value) : FaceTexcoords::kNoTexture;
    return true;
  }

  // All properties of the polygon are read.
  void add_polygon() {
    if (coordinates_ == nullptr) return polygons_.add(corners_, positions_, faces_);
    corner_numbers_.resize(corners_.size());
    std::iota(corner_numbers_.begin(), corner_numbers_.end(), 0);
    triangles_.clear();
    polygons_.add(corner_numbers_, positions_, triangles_);
    const bool fits = corner_texcoords_.size() == 2 * corners_.size();
    if (!fits && !corner_texcoords_.empty())
      losses_.add("face has texture coordinates for another number of corners: left out",
                  "faces have texture coordinates for another number of corners: left out");
    for (const std::array<uint32_t, 3>& triangle : triangles_) {
      std::array<float, 6> texcoords{};
      for (size_t i = 0; i < 6 && fits; ++i) texcoords[i] = corner_texcoords_[2 * triangle[i / 2] + i % 2];
      texcoords_->corners.push_back(texcoords);
      texcoords_->textures.push_back(fits ? texture_ : FaceTexcoords::kNone);
      faces_.push_back({corners_[triangle[0]], corners_[triangle[1]], corners_[triangle[2]]});
    }
  }

  bool pass_faces() {
    if (!pass_faces(faces_)) return false;
    faces_.clear();
    return true;
  }
  bool pass_faces(std::span<const std::array<uint32_t, 3>> faces) {
    if (!take(sink_.add_faces(faces))) return false;
    passed_faces_ += faces.size();
    if (texcoords_ != nullptr && !texcoords_->textures.empty()) texcoords_->pad(passed_faces_);
    return true;
  }

  bool take(Status status) { return status.ok() || values_.fail(std::move(status)); }

  bool read_corner(PlyType type, uint32_t& corner) {
    double value = 0;
    return values_.next(type, value) && take_corner("face", value, corner);
  }

  bool take_corner(const char* element, double value, uint32_t& corner) {
    if (value >= 0 && value < point_count_ && std::floor(value) == value) {
      corner = static_cast<uint32_t>(value);
      return true;
    }
    const std::string name =
        std::fabs(value) < 1e15 ? std::to_string(static_cast<int64_t>(value)) : "out of range";
    return values_.fail(std::string("a ") + element + " names vertex " + name + ", but there are " +
                        std::to_string(point_count_));
  }

  bool read_polygon(const PlyProperty& property) {
    uint64_t length = 0;
    if (!read_length(property, length)) return false;
    corners_.clear();
    positions_.clear();
    for (uint64_t i = 0; i < length; ++i) {
      uint32_t corner = 0;
      if (!read_corner(property.type, corner)) return false;
      corners_.push_back(corner);
      if (length <= 3) continue;
      const Expected<PrecisePosition> position = sink_.position(corner);
      if (!position) return values_.fail(position.status());
      positions_.push_back(*position);
    }
    return true;
  }

  // Every corner makes a triangle with the two corners before it, with alternating orientation. -1 begins a new
  // strip.
  bool read_strips(const PlyProperty& property) {
    uint64_t length = 0;
    if (!read_length(property, length)) return false;
    std::array<uint32_t, 3> last{};
    uint64_t count = 0;
    for (uint64_t i = 0; i < length; ++i) {
      double value = 0;
      if (!values_.next(property.type, value)) return false;
      if (value == -1) {
        count = 0;
        continue;
      }
      last = {last[1], last[2], 0};
      if (!take_corner("strip", value, last[2])) return false;
      if (++count < 3) continue;
      const auto [a, b, c] = last;
      // Strips that turn repeat an index: such triangles draw nothing and are skipped.
      if (a == b || b == c || c == a) continue;
      faces_.push_back(count % 2 == 1 ? std::array{a, b, c} : std::array{b, a, c});
    }
    return true;
  }

  // Text after the last element is an error. Binary files may end with any padding.
  bool read_trailer() {
    Scanner& scanner = values_.scanner();
    if (!values_.is_text()) {
      losses_.add("byte after the last element is not read", "bytes after the last element are not read",
                  scanner.drain());
      return true;
    }
    if (const std::string_view word = scanner.next_word(); !word.empty())
      return values_.fail(in_quotes(word) + " is more than the header states");
    return true;
  }

  static constexpr size_t kMostFaces = 4096;  // that are kept before the sink gets them
  const PlyHeader& header_;
  const ThreadPool& pool_;
  Values values_;
  MeshSink& sink_;
  Losses& losses_;
  PolygonReader polygons_;
  uint32_t point_count_ = 0;
  bool has_vertices_ = false;
  Array<std::array<uint32_t, 3>> faces_;
  uint64_t passed_faces_ = 0;  // to the sink
  // The polygon that is being cut.
  std::vector<uint32_t> corners_, corner_numbers_;
  std::vector<PrecisePosition> positions_;
  Array<std::array<uint32_t, 3>> triangles_;
  std::vector<float> corner_texcoords_;
  int32_t texture_ = 0;
  // Of the element that is read; null without them.
  const PlyProperty* coordinates_ = nullptr;
  const PlyProperty* texture_number_ = nullptr;
  FaceTexcoords* texcoords_;
};

// The material of each texture that a comment names, or -1.
std::vector<int64_t> add_materials(const std::vector<std::string>& textures, MeshFile& file) {
  std::vector<int64_t> materials;
  for (const std::string& path : textures) {
    materials.push_back(-1);
    if (!can_be_texture(path, file.losses)) continue;
    materials.back() = static_cast<int64_t>(file.materials.size());
    file.materials.push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorTexture", {{"index", add_texture(path, file)}}}, {"metallicFactor", 0}}}});
  }
  return materials;
}

}  // namespace

Status read_ply(Scanner& scanner, const PlyHeader& header, MeshSink& sink, Losses& losses,
                const ThreadPool& pool) {
  if (!header.textures.empty()) losses.say("textures are left out: the file is read part by part");
  return PlyReader(scanner, header, sink, losses, nullptr, pool).read();
}

Expected<MeshFile> read_ply(Scanner& scanner, const ThreadPool& pool) {
  Expected<PlyHeader> header = read_ply_header(scanner);
  if (!header) return header.status();
  MeshFile file;
  MeshBuilder builder;
  FaceTexcoords texcoords;
  Status status = PlyReader(scanner, *header, builder, file.losses, &texcoords, pool).read();
  if (!status.ok()) return status;
  MeshFilePart whole = builder.take();
  const Mesh& mesh = whole.mesh;
  const bool of_faces = !texcoords.textures.empty();
  if (!of_faces && mesh.find("TEXCOORD_0") == nullptr && !header->textures.empty()) {
    file.losses.say("textures are left out: there are no texture coordinates");
    header->textures.clear();
  }
  if (!of_faces && header->textures.size() > 1) {
    file.losses.say("only the first texture is used: faces do not say which they have");
    header->textures.resize(1);
  }
  const std::vector<int64_t> materials = add_materials(header->textures, file);
  MeshFileObject& object = file.objects.emplace_back();
  if (of_faces)
    object.parts = parts_with_texcoords(std::move(whole), texcoords, materials, file.losses);
  else
    object.parts.push_back(std::move(whole));
  if (!of_faces && !materials.empty()) object.parts[0].material = materials[0];
  return file;
}

}  // namespace psplit
