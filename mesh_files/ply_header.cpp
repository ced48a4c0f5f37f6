#include "mesh_files/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>

namespace psplit {
namespace {

std::optional<PlyType> type_of(std::string_view name) {
  struct Name {
    std::string_view name;
    PlyType type;
  };
  static constexpr std::array<Name, 16> kNames = {{{"char", PlyType::kInt8},
                                                   {"int8", PlyType::kInt8},
                                                   {"uchar", PlyType::kUint8},
                                                   {"uint8", PlyType::kUint8},
                                                   {"short", PlyType::kInt16},
                                                   {"int16", PlyType::kInt16},
                                                   {"ushort", PlyType::kUint16},
                                                   {"uint16", PlyType::kUint16},
                                                   {"int", PlyType::kInt32},
                                                   {"int32", PlyType::kInt32},
                                                   {"uint", PlyType::kUint32},
                                                   {"uint32", PlyType::kUint32},
                                                   {"float", PlyType::kFloat32},
                                                   {"float32", PlyType::kFloat32},
                                                   {"double", PlyType::kFloat64},
                                                   {"float64", PlyType::kFloat64}}};
  const auto found = std::ranges::find(kNames, name, &Name::name);
  return found == kNames.end() ? std::nullopt : std::optional(found->type);
}

class HeaderReader {
 public:
  explicit HeaderReader(Scanner& scanner) : scanner_(scanner) {}

  Expected<PlyHeader> read() {
    if (scanner_.word() != "ply") return error("it does not begin with \"ply\"");
    // The first byte of binary data may look like the end of a line. So the line of end_header must end as the
    // first line does.
    const std::string_view end = scanner_.peek(2);
    const bool two_bytes = end == "\r\n", lone_return = !two_bytes && end.starts_with('\r');
    bool has_format = false;
    for (;;) {
      if (!scanner_.next_line()) return error("the file ends inside the header");
      const std::string_view keyword = scanner_.word();
      Status status;
      if (keyword == "end_header") break;
      if (keyword == "format") {
        status = read_format();
        has_format = true;
      } else if (keyword == "element") {
        status = read_element();
      } else if (keyword == "property") {
        status = read_property();
      } else if (keyword == "comment") {
        read_comment();
      } else if (!keyword.empty() && keyword != "obj_info" && keyword != "Created") {
        status = error(in_quotes(keyword) + " is not a keyword of PLY");
      }
      if (!status.ok()) return status;
    }
    if (!has_format) return error("the header has no format");
    if (lone_return && header_.encoding != PlyEncoding::kText)
      scanner_.skip(1);
    else
      scanner_.next_line();
    return std::move(header_);
  }

 private:
  Status error(const std::string& what) const { return error_at_line(scanner_.line(), what); }

  void read_comment() {
    if (scanner_.word() != "TextureFile" || header_.textures.size() == kMostTextures) return;
    if (const std::optional<std::string> name = scanner_.rest_of_line(); name && !name->empty())
      header_.textures.push_back(*name);
  }

  Status read_format() {
    const std::string_view name = scanner_.word();
    if (name == "ascii")
      header_.encoding = PlyEncoding::kText;
    else if (name == "binary_little_endian")
      header_.encoding = PlyEncoding::kLittleEndian;
    else if (name == "binary_big_endian")
      header_.encoding = PlyEncoding::kBigEndian;
    else
      return error(in_quotes(name) + " is not a format of PLY");
    const std::string_view version = scanner_.word();
    return version == "1.0" ? Status() : error("PLY " + in_quotes(version) + " is not version 1.0");
  }

  Status read_element() {
    PlyElement element;
    element.name = scanner_.word();
    const std::string_view word = scanner_.word();
    const std::optional<int64_t> count = parse_integer(word);
    if (element.name.empty() || !count || *count < 0)
      return error(in_quotes(word) + " is not a number of elements");
    element.count = static_cast<uint64_t>(*count);
    for (const PlyElement& other : header_.elements)
      if (other.name == element.name) return error("a second element " + in_quotes(element.name));
    if (header_.elements.size() == kMostElements) return error("too many elements");
    header_.elements.push_back(std::move(element));
    return {};
  }

  Status read_property() {
    if (header_.elements.empty()) return error("a property before any element");
    PlyProperty property;
    std::string_view word = scanner_.word();
    property.is_list = word == "list";
    if (property.is_list) {
      word = scanner_.word();
      const std::optional<PlyType> type = type_of(word);
      if (!type || *type >= PlyType::kFloat32)
        return error(in_quotes(word) + " is not a type for the length of a list");
      property.count_type = *type;
      word = scanner_.word();
    }
    const std::optional<PlyType> type = type_of(word);
    if (!type) return error(in_quotes(word) + " is not a type of PLY");
    property.type = *type;
    property.name = scanner_.word();
    if (property.name.empty()) return error("a property without a name");
    std::vector<PlyProperty>& properties = header_.elements.back().properties;
    for (const PlyProperty& other : properties)
      if (other.name == property.name) return error("a second property " + in_quotes(property.name));
    if (properties.size() == kMostProperties) return error("too many properties");
    properties.push_back(std::move(property));
    return {};
  }

  static constexpr size_t kMostElements = 64, kMostProperties = 256, kMostTextures = 4096;
  Scanner& scanner_;
  PlyHeader header_;
};

}  // namespace

size_t ply_type_bytes(PlyType type) {
  static constexpr std::array<size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

Expected<PlyHeader> read_ply_header(Scanner& scanner) { return HeaderReader(scanner).read(); }

}  // namespace psplit
