#include "mesh_files/write_mesh_file.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "mesh_files/repair_values.h"
#include "mesh_files/stl.h"

namespace psplit {
namespace {

static_assert(std::endian::native == std::endian::little);

uint64_t points_of(std::span<const PlacedPart> parts) {
  uint64_t count = 0;
  for (const PlacedPart& part : parts) count += part.view.point_count;
  return count;
}

uint64_t faces_of(std::span<const PlacedPart> parts) {
  uint64_t count = 0;
  for (const PlacedPart& part : parts) count += part.face_count();
  return count;
}

Position position_of(const PlacedPart& part, const MeshView::Values& positions, size_t point) {
  const std::array<float, 4> floats = part.floats_at(positions, point);
  return {floats[0], floats[1], floats[2]};
}

// ---- PLY

// An attribute of all parts, and the names of its properties.
struct PlyColumn {
  std::string semantic;
  std::vector<std::string> names;
  ComponentType type = ComponentType::kFloat32;
  bool is_double = false;
};

const char* ply_name(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return "char";
    case ComponentType::kUint8: return "uchar";
    case ComponentType::kInt16: return "short";
    case ComponentType::kUint16: return "ushort";
    case ComponentType::kUint32: return "uint";
    case ComponentType::kFloat32: break;
  }
  return "float";
}

// Whether all parts store the attribute with this type.
bool all_store(std::span<const PlacedPart> parts, std::string_view semantic, ComponentType type,
               bool normalized) {
  return std::ranges::all_of(parts, [&](const PlacedPart& part) {
    const MeshView::Values* const found = part.find(semantic);
    return found != nullptr && found->values.component_type == type && found->values.normalized == normalized;
  });
}

// The property of an attribute "_NAME", whose reader makes the same attribute of it; empty if there is none.
std::string property_of(std::string_view semantic) {
  static const std::set<std::string_view> kTaken = {"x", "y", "z", "nx", "ny", "nz",  "r",     "g",    "b",
                                                    "a", "s", "t", "u",  "v",  "red", "green", "blue", "alpha"};
  std::string name;
  for (const char c : semantic.substr(1)) {
    const bool is_upper = c >= 'A' && c <= 'Z';
    if (!is_upper && !(c >= '0' && c <= '9') && c != '_') return "";
    name += is_upper ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return kTaken.contains(name) || name.starts_with("diffuse_") || name.starts_with("texture_") ? "" : name;
}

std::vector<PlyColumn> ply_columns(std::span<const PlacedPart> parts) {
  std::vector<PlyColumn> columns{{"POSITION", {"x", "y", "z"}}};
  if (all_have(parts, "NORMAL", 3)) columns.push_back({"NORMAL", {"nx", "ny", "nz"}});
  const bool alpha = all_have(parts, "COLOR_0", 4);
  if (alpha || all_have(parts, "COLOR_0", 3)) {
    PlyColumn& column = columns.emplace_back(PlyColumn{"COLOR_0", {"red", "green", "blue"}});
    if (alpha) column.names.push_back("alpha");
    for (const ComponentType type : {ComponentType::kUint8, ComponentType::kUint16})
      if (all_store(parts, "COLOR_0", type, true)) column.type = type;
  }
  if (all_have(parts, "TEXCOORD_0", 2)) columns.push_back({"TEXCOORD_0", {"s", "t"}});
  if (parts.empty()) return columns;
  for (const auto& [semantic, values] : parts[0].view.attributes) {
    if (!semantic.starts_with('_') || !all_have(parts, semantic, 1) || property_of(semantic).empty() ||
        !all_store(parts, semantic, values.component_type, false) ||
        values.component_type == ComponentType::kUint32)
      continue;
    columns.push_back({semantic, {property_of(semantic)}, values.component_type});
  }
  return columns;
}

void write_ply_point(FileBuffer& out, const PlacedPart& part, const PlyColumn& column,
                     const MeshView::Values& attribute, size_t point) {
  if (column.type != ComponentType::kFloat32)
    return out.put(attribute.values.at(point), attribute.values.value_bytes());
  if (column.is_double) {
    const std::array<double, 4> doubles = part.doubles_at(attribute, point);
    return out.put(doubles.data(), column.names.size() * sizeof(double));
  }
  std::array<float, 4> floats = part.floats_at(attribute, point);
  if (column.semantic == "TEXCOORD_0") floats[1] = 1 - floats[1];
  out.put(floats.data(), column.names.size() * sizeof(float));
}

bool write_ply(FileBuffer& out, std::span<const PlacedPart> parts) {
  std::vector<PlyColumn> columns = ply_columns(parts);
  columns[0].is_double = need_doubles(parts);
  std::string properties;
  for (const PlyColumn& column : columns)
    for (const std::string& name : column.names)
      properties +=
          std::string("property ") + (column.is_double ? "double" : ply_name(column.type)) + " " + name + "\n";
  out.text(ply_header_text(points_of(parts), properties, faces_of(parts)));
  for (const PlacedPart& part : parts) {
    std::vector<const MeshView::Values*> values;
    for (const PlyColumn& column : columns) values.push_back(part.find(column.semantic));
    for_each_block(part, [&](size_t first, size_t end) {
      for (size_t point = first; point < end; ++point)
        for (size_t i = 0; i < columns.size(); ++i) write_ply_point(out, part, columns[i], *values[i], point);
    });
  }
  uint32_t base = 0;
  for (const PlacedPart& part : parts) {
    for (size_t i = 0; i < part.face_count(); ++i) {
      std::array<uint32_t, 3> face = part.face(i);
      for (uint32_t& point : face) point += base;
      out.value(uint8_t{3});
      out.value(face);
    }
    base += part.view.point_count;
  }
  return out.flush();
}

// ---- OBJ

class ObjWriter {
 public:
  ObjWriter(FileBuffer& out, bool colors) : out_(out), colors_(colors) {}

  // `all_digits`: of positions, as doubles have them.
  void add(const PlacedPart& part, bool all_digits) {
    const MeshView::Values* const positions = part.find("POSITION");
    const MeshView::Values* const colors = colors_ ? part.find("COLOR_0") : nullptr;
    const MeshView::Values* const normals = part.find("NORMAL");
    const MeshView::Values* const texcoords = part.find("TEXCOORD_0");
    if (part.object != object_) out_.text("o " + part.object + "\n");
    object_ = part.object;
    for_each_block(part, [&](size_t first, size_t end) {
      for (size_t point = first; point < end; ++point) {
        if (all_digits)
          write("v", part.doubles_at(*positions, point), 3);
        else
          write("v", part.floats_at(*positions, point), 3);
        if (colors != nullptr) write("", part.floats_at(*colors, point), 3);
        out_.text("\n");
        if (texcoords != nullptr) write_texcoord(part.floats_at(*texcoords, point));
        if (normals == nullptr) continue;
        write("vn", part.floats_at(*normals, point), 3);
        out_.text("\n");
      }
    });
    if (part.material != material_) out_.text("usemtl " + part.material + "\n");
    material_ = part.material;
    for (size_t i = 0; i < part.face_count(); ++i) {
      out_.text("f");
      for (const uint32_t point : part.face(i)) write_corner(point, texcoords != nullptr, normals != nullptr);
      out_.text("\n");
    }
    positions_ += part.view.point_count;
    if (texcoords != nullptr) texcoords_ += part.view.point_count;
    if (normals != nullptr) normals_ += part.view.point_count;
  }

 private:
  template <typename Number>
  void number(Number number) {
    std::array<char, 32> text;
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
    out_.put(text.data(), static_cast<size_t>(end - text.data()));
  }

  void write(std::string_view keyword, const auto& values, size_t count) {
    out_.text(keyword);
    for (size_t i = 0; i < count; ++i) {
      out_.text(" ");
      number(values[i]);
    }
  }

  // OBJ counts v from the bottom of the image, glTF from the top.
  void write_texcoord(const std::array<float, 4>& value) {
    write("vt", value, 1);
    out_.text(" ");
    number(1 - double{value[1]});
    out_.text("\n");
  }

  void write_corner(uint32_t point, bool texcoords, bool normals) {
    out_.text(" ");
    number(positions_ + point);
    if (texcoords || normals) out_.text("/");
    if (texcoords) number(texcoords_ + point);
    if (normals) out_.text("/");
    if (normals) number(normals_ + point);
  }

  FileBuffer& out_;
  bool colors_;
  std::string object_, material_;
  uint64_t positions_ = 1, texcoords_ = 1, normals_ = 1;  // of the next part's first point
};

bool obj_has_colors(std::span<const PlacedPart> parts) {
  return std::ranges::all_of(parts, [](const PlacedPart& part) {
    return all_have({&part, 1}, "COLOR_0", 3) || all_have({&part, 1}, "COLOR_0", 4);
  });
}

// Whether every colour has an alpha of 1, or none.
bool is_opaque(const PlacedPart& part) {
  const MeshView::Values& colors = *part.find("COLOR_0");
  bool opaque = true;
  if (colors.values.component_count == 4)
    for_each_block(part, [&](size_t first, size_t end) {
      for (size_t point = first; opaque && point < end; ++point) opaque = part.floats_at(colors, point)[3] == 1;
    });
  return opaque;
}

bool write_obj(FileBuffer& out, std::span<const PlacedPart> parts, const std::string& library) {
  out.text("# made by gltf-psplit\n");
  if (!library.empty()) out.text("mtllib " + library + "\n");
  ObjWriter writer(out, obj_has_colors(parts));
  const bool are_doubles = need_doubles(parts);
  for (size_t first = 0, end = 0; first < parts.size(); first = end) {
    // The shortest digits of floats denote other doubles, which a reader may take them for.
    PositionSpread object;
    for (; end < parts.size() && parts[end].object == parts[first].object; ++end)
      if (!are_doubles) object.add(position_spread(parts[end]));
    for (size_t i = first; i < end; ++i) writer.add(parts[i], are_doubles || is_far(object));
  }
  return out.flush();
}

// ---- STL

bool write_stl(FileBuffer& out, std::span<const PlacedPart> parts) {
  std::array<char, 80> header{"binary STL, made by gltf-psplit"};  // a text file would begin with "solid"
  out.value(header);
  out.value(static_cast<uint32_t>(faces_of(parts)));
  for (const PlacedPart& part : parts) {
    const MeshView::Values& positions = *part.find("POSITION");
    for (size_t i = 0; i < part.face_count(); ++i) {
      Facet facet{};
      const std::array<uint32_t, 3> face = part.face(i);
      for (size_t corner = 0; corner < 3; ++corner)
        facet.corners[corner] = position_of(part, positions, face[corner]);
      const std::array<double, 3> area = area_vector(facet.corners);
      if (std::hypot(area[0], area[1], area[2]) > 0) facet.normal = normal_of_faces(area);
      out.value(facet);
      out.value(uint16_t{0});
    }
  }
  return out.flush();
}

}  // namespace

Status check_positions(std::span<const PlacedPart> parts) {
  for (const PlacedPart& part : parts) {
    if (!all_have({&part, 1}, "POSITION", 3)) return unsupported("a POSITION that is not of 3 components");
    const MeshView::Values& positions = *part.find("POSITION");
    bool finite = true;
    for_each_block(part, [&](size_t first, size_t end) {
      for (size_t point = first; finite && point < end; ++point)
        for (const float value : position_of(part, positions, point)) finite = finite && std::isfinite(value);
    });
    if (!finite) return unsupported("a position that is not finite");
  }
  return {};
}

std::string ply_header_text(uint64_t point_count, const std::string& properties, uint64_t face_count) {
  const std::string faces = "element face " + std::to_string(face_count) + "\nproperty list uchar " +
                            (point_count > INT32_MAX ? "uint" : "int") + " vertex_indices\n";
  return "ply\nformat binary_little_endian 1.0\ncomment made by gltf-psplit\nelement vertex " +
         std::to_string(point_count) + "\n" + properties + (face_count > 0 ? faces : "") + "end_header\n";
}

std::set<std::string> attributes_left_out(AssetFormat format, std::span<const PlacedPart> parts) {
  std::set<std::string> kept{"POSITION"};
  if (format == AssetFormat::kPly)
    for (const PlyColumn& column : ply_columns(parts)) kept.insert(column.semantic);
  if (format == AssetFormat::kObj) kept.insert({"NORMAL", "TEXCOORD_0"});
  if (format == AssetFormat::kObj && obj_has_colors(parts)) kept.insert("COLOR_0");
  std::set<std::string> left_out;
  for (const PlacedPart& part : parts)
    for (const auto& [semantic, values] : part.view.attributes)
      if (!kept.contains(semantic))
        left_out.insert(semantic);
      else if (format == AssetFormat::kObj && semantic == "COLOR_0" && !is_opaque(part))
        left_out.insert("the alpha of COLOR_0");
  return left_out;
}

Status write_mesh_file(const std::filesystem::path& path, AssetFormat format, std::span<const PlacedPart> parts,
                       const std::string& library, IfReadOnly if_read_only) {
  if (Status status = check_positions(parts); !status.ok()) return status;
  constexpr uint64_t kMost = std::numeric_limits<uint32_t>::max() - 1;
  if (format != AssetFormat::kStl && points_of(parts) > kMost)
    return unsupported("more points than such a file can count");
  if (format == AssetFormat::kStl && faces_of(parts) > kMost)
    return unsupported("more faces than an STL can count");
  const auto write = [&](std::FILE* file) {
    FileBuffer out(file);
    return format == AssetFormat::kPly   ? write_ply(out, parts)
           : format == AssetFormat::kObj ? write_obj(out, parts, library)
                                         : write_stl(out, parts);
  };
  return write_file(path, write, if_read_only);
}

}  // namespace psplit
