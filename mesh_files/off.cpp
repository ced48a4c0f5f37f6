#include "mesh_files/off.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

namespace psplit {
namespace {

struct OffForm {
  bool texcoords = false, colors = false, normals = false, homogeneous = false, any_dimension = false;
};

// Geomview's "[ST][C][N][4][n]OFF".
std::optional<OffForm> form_of(std::string_view word) {
  OffForm form;
  const auto take = [&](std::string_view part) {
    if (!word.starts_with(part)) return false;
    word.remove_prefix(part.size());
    return true;
  };
  form.texcoords = take("ST");
  form.colors = take("C");
  form.normals = take("N");
  form.homogeneous = take("4");
  form.any_dimension = take("n");
  return word == "OFF" ? std::optional(form) : std::nullopt;
}

class OffReader {
 public:
  explicit OffReader(Scanner& scanner) : scanner_(scanner), polygons_(file_.losses) {}

  Expected<MeshFile> read() {
    if (!read_header() || !read_counts() || !read_vertices() || !read_faces()) return error_;
    polygons_.finish();
    if (!read_trailer()) return error_;
    if (mesh_.point_count == 0) return invalid_input("OFF: no vertices");
    file_.objects.push_back({"", {{std::move(mesh_), -1, std::move(positions_)}}});
    return std::move(file_);
  }

 private:
  bool fail(const std::string& what) {
    if (error_.ok()) error_ = error_at_line(scanner_.line(), what);
    return false;
  }

  // The next word, skipping comments; empty at the end of the file.
  std::string_view next_word() {
    for (;;) {
      const std::string_view word = scanner_.next_word();
      if (!word.starts_with('#')) return word;
      if (!scanner_.next_line()) return {};
    }
  }

  // The next word of this line, without comments; empty at its end.
  std::string_view word_of_line() {
    const std::string_view word = scanner_.word();
    if (!word.starts_with('#')) return word;
    scanner_.skip_rest_of_line();
    return {};
  }

  bool read_header() {
    const std::string_view word = next_word();
    const std::optional<OffForm> form = form_of(word);
    if (!form) {
      first_ = word;  // the number of vertices, if the keyword is missing
      return true;
    }
    form_ = *form;
    if (form_.homogeneous || form_.any_dimension) {
      error_ = unsupported("OFF: only vertices of three dimensions are read");
      return false;
    }
    const std::string_view next = next_word();
    if (next == "BINARY") {
      error_ = unsupported("OFF: binary files are not read");
      return false;
    }
    first_ = next;
    return true;
  }

  bool parse_count(std::string_view word, uint64_t& count) {
    const std::optional<int64_t> number = parse_integer(word);
    if (word.empty()) return fail("the file ends inside its header");
    if (!number || *number < 0) return fail(in_quotes(word) + " is not a number of vertices, faces or edges");
    count = static_cast<uint64_t>(*number);
    return true;
  }

  // The numbers of vertices, faces and edges. Edges are not used, and some files omit their number.
  bool read_counts() {
    uint64_t edge_count = 0;
    if (!parse_count(first_, vertex_count_) || !parse_count(next_word(), face_count_)) return false;
    if (const std::string_view word = word_of_line(); !word.empty() && !parse_count(word, edge_count))
      return false;
    const std::optional<uint64_t> left = scanner_.bytes_left();
    const bool countable = vertex_count_ < UINT32_MAX && face_count_ < UINT32_MAX;
    if (!countable || (left && 6 * vertex_count_ + 2 * face_count_ > *left + 2))  // bytes of digits and spaces
      return fail("the header claims " + std::to_string(vertex_count_) + " vertices and " +
                  std::to_string(face_count_) + " faces, and " +
                  (left ? std::to_string(*left) + " bytes" : "less") + " follow");
    return true;
  }

  // The float that is nearest to it is that of the word.
  bool read_number(double& value) {
    const std::string_view word = next_word();
    if (word.empty()) return fail("the file ends early");
    const std::optional<double> number = parse_precise(word);
    if (!number) return fail(in_quotes(word) + " is not a number");
    value = *number;
    return true;
  }

  bool append(Array<std::byte>& values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      double value = 0;
      if (!read_number(value)) return false;
      append_value(values, static_cast<float>(value));
    }
    return true;
  }

  static void append_value(Array<std::byte>& values, float value) {
    const size_t at = values.size();
    values.resize(at + sizeof(value));
    std::memcpy(values.data() + at, &value, sizeof(value));
  }

  // Colours have three or four numbers: the length of the first line decides.
  bool append_color(Array<std::byte>& values, uint64_t vertex) {
    std::vector<float> numbers;
    const size_t behind = form_.texcoords ? 2 : 0;
    for (std::string_view word = word_of_line(); !word.empty(); word = word_of_line()) {
      const std::optional<float> number = parse_float(word);
      if (!number) return fail(in_quotes(word) + " is not a number");
      numbers.push_back(*number);
      if (numbers.size() > 4 + behind) return fail("a vertex of too many numbers");
    }
    if (vertex == 0) color_count_ = numbers.size() == 4 + behind ? 4 : 3;
    if (numbers.size() != color_count_ + behind)
      return fail("a vertex of " + std::to_string(numbers.size()) + " numbers behind its position, where " +
                  std::to_string(color_count_ + behind) + " are expected");
    for (size_t i = 0; i < color_count_; ++i) {
      append_value(values, numbers[i]);
      whole_colors_ =
          whole_colors_ && numbers[i] == std::floor(numbers[i]) && numbers[i] >= 0 && numbers[i] <= 255;
      brightest_ = std::max(brightest_, numbers[i]);
    }
    for (size_t i = 0; i < behind; ++i) append_value(texcoords_, numbers[color_count_ + i]);
    return true;
  }

  bool read_vertices() {
    for (uint64_t i = 0; i < vertex_count_; ++i) {
      PrecisePosition& position = positions_.emplace_back();
      for (double& value : position)
        if (!read_number(value)) return false;
      if (!is_finite(position)) return fail("the position of vertex " + std::to_string(i) + " is not finite");
      if (form_.normals && !append(normals_, 3)) return false;
      if (form_.colors && !append_color(colors_, i)) return false;
      if (!form_.colors && form_.texcoords && !append(texcoords_, 2)) return false;
      // Some files have colours although their keyword states none.
      if (const std::string_view word = word_of_line(); !word.empty()) {
        ++with_more_;
        scanner_.next_line();
      }
    }
    mesh_.point_count = static_cast<uint32_t>(vertex_count_);
    scale_colors();
    flip_v(texcoords_);
    mesh_.attributes.push_back({"POSITION", ComponentType::kFloat32, 3, false, {}});
    add_attribute("NORMAL", 3, normals_);
    add_attribute("COLOR_0", static_cast<uint8_t>(color_count_), colors_);
    add_attribute("TEXCOORD_0", 2, texcoords_);
    file_.losses.add("vertex has more numbers than the header states, which are left out",
                     "vertices have more numbers than the header states, which are left out", with_more_);
    return true;
  }

  void scale_colors() {
    if (!whole_colors_ || brightest_ <= 1) return;
    for (size_t at = 0; at < colors_.size(); at += sizeof(float)) {
      float value = 0;
      std::memcpy(&value, colors_.data() + at, sizeof(value));
      value /= 255;
      std::memcpy(colors_.data() + at, &value, sizeof(value));
    }
  }

  void add_attribute(const char* semantic, uint8_t component_count, Array<std::byte>& values) {
    if (values.empty()) return;
    mesh_.attributes.push_back({semantic, ComponentType::kFloat32, component_count, false, std::move(values)});
  }

  bool read_corner(uint32_t& corner) {
    const std::string_view word = next_word();
    if (word.empty()) return fail("the file ends early");
    const std::optional<int64_t> number = parse_integer(word);
    if (!number) return fail(in_quotes(word) + " is not a vertex number");
    if (*number < 0 || *number >= mesh_.point_count)
      return fail("a face names vertex " + std::to_string(*number) + ", but there are " +
                  std::to_string(mesh_.point_count));
    corner = static_cast<uint32_t>(*number);
    return true;
  }

  bool read_faces() {
    std::vector<uint32_t> corners;
    std::vector<PrecisePosition> corner_positions;
    uint64_t with_colors = 0;
    for (uint64_t n = 0; n < face_count_; ++n) {
      const std::string_view word = next_word();
      if (word.empty())
        return fail("the file ends after " + std::to_string(n) + " of " + std::to_string(face_count_) +
                    " faces");
      const std::optional<int64_t> length = parse_integer(word);
      if (!length || *length < 0) return fail(in_quotes(word) + " is not a number of corners");
      corners.clear();
      corner_positions.clear();
      for (int64_t i = 0; i < *length; ++i) {
        uint32_t corner = 0;
        if (!read_corner(corner)) return false;
        corners.push_back(corner);
        if (*length > 3) corner_positions.push_back(positions_[corner]);
      }
      polygons_.add(corners, corner_positions, mesh_.faces);
      if (const std::string_view rest = word_of_line(); !rest.empty()) {
        ++with_colors;
        scanner_.next_line();
      }
    }
    file_.losses.add("face has a colour, which is left out", "faces have colours, which are left out",
                     with_colors);
    return true;
  }

  bool read_trailer() {
    const std::string_view word = next_word();
    return word.empty() || fail(in_quotes(word) + " is more than the header states");
  }

  Scanner& scanner_;
  MeshFile file_;
  PolygonReader polygons_;
  Mesh mesh_;
  Status error_;
  OffForm form_;
  std::string first_;  // the word after the keyword
  uint64_t vertex_count_ = 0, face_count_ = 0, with_more_ = 0;
  std::vector<PrecisePosition> positions_;
  Array<std::byte> normals_, colors_, texcoords_;
  size_t color_count_ = 3;
  bool whole_colors_ = true;
  float brightest_ = 0;
};

}  // namespace

bool is_off_keyword(std::string_view word) { return form_of(word).has_value(); }

Expected<MeshFile> read_off(Scanner& scanner) { return OffReader(scanner).read(); }

}  // namespace psplit
