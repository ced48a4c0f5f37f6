#include "tools/gltf_psplit/files/mesh_output.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>

#include "gltf_ext/document/named_binary.h"
#include "gltf_ext/document/place_images.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/view_in_place.h"
#include "mesh_files/mtl.h"
#include "mesh_files/write_mesh_file.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "system/image_type.h"
#include "system/uri.h"
#include "tools/gltf_psplit/preview/scene.h"
#include "tools/gltf_psplit/report/encode_report.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// A small file can repeat its meshes often and so fill a disk.
constexpr uint64_t kMostRepeats = 1000, kSpareFaces = 5'000'000;

// Names as lines of OBJ and MTL hold them, each used once.
class UniqueNames {
 public:
  std::string add(std::string name) {
    for (char& c : name)
      if (static_cast<unsigned char>(c) < ' ' || c == '\\' || c == '\x7f') c = '_';
    const size_t first = name.find_first_not_of(' '), last = name.find_last_not_of(' ');
    name = first == std::string::npos ? "unnamed" : name.substr(first, last - first + 1);
    std::string unique = name;
    for (int& number = last_number_[name]; !names_.insert(unique).second;)
      unique = name + "_" + std::to_string(number = std::max(number, 1) + 1);
    return unique;
  }

 private:
  std::set<std::string> names_;
  std::map<std::string, int> last_number_;  // a scene may show one mesh many times
};

// Whether a line of OBJ or MTL can hold the name of a file.
bool fits_line(std::string_view name) {
  return !name.starts_with('-') && !name.starts_with(' ') && !name.ends_with(' ') &&
         std::ranges::none_of(name, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\\'; });
}

bool is_identity(const Transform& t) {
  const auto is = [](Vec3 v, Vec3 to) { return v.x == to.x && v.y == to.y && v.z == to.z; };
  return is(t.x, {1, 0, 0}) && is(t.y, {0, 1, 0}) && is(t.z, {0, 0, 1}) && is(t.origin, {});
}

void place_value(const Transform& transform, bool mirrored, std::string_view semantic,
                 std::span<double> value) {
  if (value.size() < 3 || (semantic != "POSITION" && semantic != "NORMAL" && semantic != "TANGENT")) return;
  const Vec3 to = moved(transform, mirrored, semantic, {value[0], value[1], value[2]});
  value[0] = to.x, value[1] = to.y, value[2] = to.z;
  if (value.size() > 3 && mirrored) value[3] = -value[3];
}

bool has_extras(const Json& json) {
  if (json.is_object() && json.contains("extras")) return true;
  return json.is_structured() && std::ranges::any_of(json, has_extras);
}

// The parts of a scene, and what no mesh file can hold of it.
class SceneParts {
 public:
  // `format` may hold points, which are taken if there are no triangles.
  SceneParts(const Document& document, AssetFormat format, const ThreadPool& pool)
      : document_(document),
        takes_points_((format == AssetFormat::kPly || format == AssetFormat::kDraco) &&
                      std::ranges::none_of(
                          all_primitives(document),
                          [&](PrimitiveId id) { return document.records().primitive(id).has_triangles(); })),
        pool_(pool) {}

  Status read() {
    const Expected<std::vector<MeshInstance>> instances = scene_instances(document_);
    if (!instances) return instances.status();
    std::set<size_t> shown;
    for (const MeshInstance& instance : *instances) {
      shown.insert(instance.mesh);
      if (Status status = add(instance, instances->size() == 1); !status.ok()) return status;
      if (size_ > kSpareFaces + kMostRepeats * own_size_)
        return unsupported("the scene repeats its meshes too often to be written");
    }
    if (parts.empty())
      return unsupported(takes_points_ ? "the scene shows nothing" : "the scene shows no triangles");
    name_losses(document_.records().meshes.size() - shown.size());
    return {};
  }

  // Whether the parts are points.
  bool has_points() const { return takes_points_; }

  std::vector<PlacedPart> parts;
  std::map<int64_t, std::string> materials;  // the materials of parts, with their names
  std::vector<std::string> losses;           // what the scene has beside parts and materials
  size_t moved_count = 0;                    // objects that a node moves

 private:
  Status add(const MeshInstance& instance, bool only_one) {
    const std::string* const name = string_field(document_.json()["meshes"][instance.mesh], "name");
    const bool is_named = name != nullptr && !name->empty();
    std::string object;
    if (is_named || !only_one) object = names_.add(is_named ? *name : "mesh_" + std::to_string(instance.mesh));
    const Transform& transform = instance.to_world;
    const bool moves = !is_identity(transform);
    const bool mirrored = mirrors(transform);
    moved_count += moves;
    const std::vector<PrimitiveRecord>& primitives = document_.records().meshes[instance.mesh];
    for (size_t i = 0; i < primitives.size(); ++i) {
      if (!primitives[i].status.ok()) return primitives[i].status;
      if (!primitives[i].has_triangles() && !(takes_points_ && primitives[i].mode == kPointsMode)) {
        ++other_primitives_;
        continue;
      }
      has_morphs_ = has_morphs_ || !primitives[i].targets.empty();
      const Expected<MeshView> view = view_of_primitive({instance.mesh, i});
      if (!view) return view.status();
      PlacedPart part{object, material_name(primitives[i].material), *view, {}, mirrored};
      if (moves)
        part.place = [transform, mirrored](std::string_view semantic, std::span<double> value) {
          place_value(transform, mirrored, semantic, value);
        };
      size_ += size_of(part.view);
      parts.push_back(std::move(part));
    }
    return {};
  }

  uint64_t size_of(const MeshView& view) const {
    return takes_points_ ? view.point_count : view.indices.count / 3;
  }

  Expected<MeshView> view_of_primitive(PrimitiveId id) {
    const auto known = views_.find({id.mesh, id.primitive});
    if (known != views_.end()) return known->second;
    std::optional<MeshView> view = takes_points_ ? std::nullopt : valid_view_in_place(document_, id);
    if (!view) {
      Expected<Mesh> mesh = takes_points_ ? read_points(document_.records().primitive(id))
                                          : read_primitive(document_, id, cpu_backend(), pool_);
      if (!mesh) return mesh.status();
      take_targets(*mesh);
      view = psplit::view_of(meshes_.emplace_back(std::move(*mesh)));
    }
    own_size_ += size_of(*view);
    return views_.try_emplace({id.mesh, id.primitive}, std::move(*view)).first->second;
  }

  Expected<Mesh> read_points(const PrimitiveRecord& primitive) const {
    if (primitive.indices >= 0) return unsupported("points with indices are not written");
    Mesh points;
    for (const auto& [semantic, accessor] : primitive.attributes) {
      if (accessor < 0) return invalid_input(semantic + " has no accessor");
      Expected<AccessorData> data = read_accessor(document_, accessor);
      if (!data) return data.status();
      if (!points.attributes.empty() && data->count != points.point_count)
        return invalid_input(semantic + " has values for another number of points");
      points.point_count = data->count;
      points.attributes.push_back(
          {semantic, data->component_type, data->component_count, data->normalized, std::move(data->values)});
    }
    if (points.find("POSITION") == nullptr) return invalid_input("points without POSITION");
    return points;
  }

  std::string material_name(int64_t material) {
    const Json* const json = top_level_object(document_.json(), "materials", material);
    if (json == nullptr) return "";
    const auto [found, is_new] = materials.try_emplace(material);
    const std::string* const name = string_field(*json, "name");
    if (is_new)
      found->second = material_names_.add(name != nullptr ? *name : "material_" + std::to_string(material));
    return found->second;
  }

  void name_losses(size_t unseen_meshes) {
    const Json& json = document_.json();
    if (unseen_meshes > 0) losses.push_back(counted(unseen_meshes, "object") + " that the scene does not show");
    if (other_primitives_ > 0)
      losses.push_back(counted(other_primitives_, "primitive") + " of points or lines");
    if (has_morphs_) losses.push_back("morph targets");
    if (array_size(json, "scenes") > 1) losses.push_back("scenes beside the default one");
    for (const char* list : {"skins", "animations", "cameras"})
      if (array_size(json, list) > 0) losses.push_back(list);
    if (has_extras(json)) losses.push_back("extras");
    if (const Json* const used = array_field(json, "extensionsUsed"))
      for (const Json& name : *used)
        if (name.is_string() && name != kQuantizationExtensionName && name != "KHR_texture_transform")
          losses.push_back(name.get<std::string>());
  }

  const Document& document_;
  const bool takes_points_;
  const ThreadPool& pool_;
  std::deque<Mesh> meshes_;  // meshes whose values no buffer has as they are
  std::map<std::pair<size_t, size_t>, MeshView> views_;
  UniqueNames names_, material_names_;
  uint64_t size_ = 0, own_size_ = 0;  // faces, or points; with and without repetitions
  size_t other_primitives_ = 0;
  bool has_morphs_ = false;
};

// The MTL file of an OBJ, and its images.
class MaterialFiles {
 public:
  MaterialFiles(const Document& document, const fs::path& output, std::optional<ImagePlacement> placement,
                WriteReport& written)
      : document_(document), output_(output), placement_(placement), written_(written) {}

  // The features of the materials that MTL cannot hold. Writes nothing.
  std::set<std::string> losses(const std::map<int64_t, std::string>& materials) const {
    std::set<std::string> left_out;
    text_of(
        materials, [&](size_t image) { return extension_of(image); }, left_out);
    return left_out;
  }

  // Returns the name of the MTL file.
  Expected<std::string> write(const std::map<int64_t, std::string>& materials) {
    PackedDocument packed{document_.json(), {}, {}, Json::object(), Json::array(), {}};
    if (Status status =
            place_images(document_, output_, placement_.value_or(ImagePlacement::kCopy), packed, written_);
        !status.ok())
      return status;
    Status failed;
    std::set<std::string> unheard;
    const auto path_of_image = [&](size_t image) -> std::string {
      if (extension_of(image).empty()) return "";
      const Json& json = packed.json["images"][image];
      if (const std::string* const uri = string_field(json, "uri"); uri != nullptr && !is_data_uri(*uri))
        return path_of_uri(*uri, output_.parent_path()).generic_string();
      const Expected<std::vector<uint8_t>> bytes = embedded_bytes(image);
      if (!bytes) return "";
      const Expected<std::string> name =
          write_file_beside("_image" + std::to_string(image) + extension_of(image), *bytes, true);
      if (!name) failed = name.status();
      return name ? *name : "";
    };
    const std::string text = text_of(materials, path_of_image, unheard);
    if (!failed.ok()) return failed;
    return write_file_beside(".mtl", {reinterpret_cast<const uint8_t*>(text.data()), text.size()}, false);
  }

 private:
  std::string text_of(const std::map<int64_t, std::string>& materials, const PathOfImage& path_of_image,
                      std::set<std::string>& left_out) const {
    std::string text = "# made by gltf-psplit\n";
    for (const auto& [material, name] : materials)
      text += "\n" + mtl_text(document_.json(), material, name, path_of_image, left_out);
    return text;
  }

  // The extension of an image that MTL can name; empty for one on the web, of an unknown kind, or with a name
  // that a line cannot hold.
  std::string extension_of(size_t image) const {
    const std::string* const uri = string_field(document_.json()["images"][image], "uri");
    if (uri != nullptr && !is_data_uri(*uri)) {
      if (kind_of_uri(*uri) != UriKind::kRelative) return "";
      const fs::path file = path_of_uri(*uri, document_.source.parent_path());
      return fits_line(file.generic_string()) ? lower_extension(file) : "";
    }
    const Expected<std::vector<uint8_t>> bytes = embedded_bytes(image);
    const std::optional<ImageType> type = bytes ? image_type(*bytes) : std::nullopt;
    return type ? type->extension : "";
  }

  Expected<std::vector<uint8_t>> embedded_bytes(size_t image) const {
    const Json& json = document_.json()["images"][image];
    if (const std::string* const uri = string_field(json, "uri")) return decode_data_uri(*uri);
    const Expected<Span<const uint8_t>> bytes =
        buffer_view_bytes(document_, integer_field(json, "bufferView").value_or(-1));
    if (!bytes) return bytes.status();
    return std::vector<uint8_t>(bytes->begin(), bytes->end());
  }

  // "<output><ending>", or with a hash of the content in its name if another file has that name.
  Expected<std::string> write_file_beside(const std::string& ending, std::span<const uint8_t> bytes,
                                          bool is_image) {
    const std::string stem = output_.stem().string();
    const std::span<const uint8_t> parts[] = {bytes};
    const fs::path wanted = stem + ending;
    const fs::path names[] = {wanted,
                              path_with_digits(wanted, content_digits(parts), wanted.extension().string())};
    const Expected<fs::path> name = write_beside(output_.parent_path(), names, bytes);
    if (!name) return name.status();
    if (name->empty()) return io_failure(names[1].string() + " is another file");
    written_.files.push_back(output_.parent_path() / *name);
    if (is_image) ++written_.copied_images, written_.image_bytes += bytes.size();
    return name->string();
  }

  const Document& document_;
  fs::path output_;
  std::optional<ImagePlacement> placement_;
  WriteReport& written_;
};

Attribute placed_attribute(const PlacedPart& part, const MeshView::Values& attribute) {
  const auto& [semantic, values] = attribute;
  // Readers of a .drc take these as floats, and it cannot say that integers are normalized.
  const bool as_floats = (part.place && semantic == "TANGENT") || semantic == "POSITION" ||
                         semantic == "NORMAL" || semantic.starts_with("TEXCOORD_");
  Attribute placed{semantic,
                   as_floats ? ComponentType::kFloat32 : values.component_type,
                   values.component_count,
                   !as_floats && values.normalized,
                   {}};
  placed.values.resize(placed.stride() * values.count);
  for (size_t point = 0; point < values.count; ++point) {
    const std::array<float, 4> floats = as_floats ? part.floats_at(attribute, point) : std::array<float, 4>();
    std::memcpy(placed.values.data() + point * placed.stride(),
                as_floats ? static_cast<const void*>(floats.data()) : values.at(point), placed.stride());
  }
  return placed;
}

Mesh mesh_of(const PlacedPart& part) {
  Mesh mesh;
  mesh.point_count = part.view.point_count;
  for (const MeshView::Values& attribute : part.view.attributes)
    mesh.attributes.push_back(placed_attribute(part, attribute));
  mesh.faces.resize(part.face_count());
  for (size_t i = 0; i < mesh.faces.size(); ++i) mesh.faces[i] = part.face(i);
  return mesh;
}

// "200 points as a kD-tree: POSITION has 14 bits, COLOR_0 is exact".
std::string cloud_text(const EncodedMesh& encoded) {
  const EncodedPiece& piece = encoded.pieces[0];
  constexpr size_t kMethod = 8;
  std::vector<std::string> attributes;
  for (size_t i = 0; i < encoded.requests.size(); ++i) {
    const int bits = encoded.codings[i].bits;
    attributes.push_back(encoded.requests[i].semantic +
                         (bits == 0 ? " is exact" : " has " + counted(static_cast<uint64_t>(bits), "bit")));
  }
  return counted(piece.point_count, "point") +
         (piece.bytes[kMethod] == 1 ? " as a kD-tree: " : ", sequential: ") + joined(attributes);
}

Status write_draco(const std::string& path, const SceneParts& scene, const EncodeDocumentOptions& coding,
                   const Session& session, EncodeStatistics& lost) {
  EncodeOptions options = coding;
  const bool is_cloud = scene.has_points();
  options.storage = is_cloud ? Storage::kCloud : Storage::kOneStream;
  options.keep_duplicates = true;  // as Draco keeps them
  const Expected<EncodedMesh> encoded = encode(mesh_of(scene.parts.front()), options, session.pool);
  if (!encoded) return encoded.status();
  lost.dropped_faces += encoded->statistics.dropped_faces;
  lost.dropped_points += encoded->statistics.dropped_points;
  for (const PrecisionNote& note : encoded->notes)
    note.is_warning ? session.log.warning(path + ": " + note.text) : session.log.note(path + ": " + note.text);
  if (is_cloud) session.log.note(path + ": " + cloud_text(*encoded));
  return write_file(path, {encoded->pieces[0].bytes}, session.if_read_only());
}

// What the format cannot hold.
std::vector<std::string> losses_of(const SceneParts& scene, AssetFormat format, const MaterialFiles& files,
                                   bool lossless) {
  std::vector<std::string> losses;
  if (format == AssetFormat::kDraco) {
    const bool is_cloud = scene.has_points();
    for (const auto& [semantic, values] : scene.parts[0].view.attributes)
      if (semantic != "POSITION" && (semantic != "NORMAL" || (lossless && !is_cloud)) &&
          !semantic.starts_with("TEXCOORD_") && !semantic.starts_with("COLOR_"))
        losses.push_back("the name of " + semantic);
  } else {
    for (const std::string& semantic : attributes_left_out(format, scene.parts)) losses.push_back(semantic);
  }
  const bool holds_floats = format == AssetFormat::kStl || format == AssetFormat::kDraco;
  if (holds_floats && need_doubles(scene.parts))
    losses.push_back("digits of positions that floats cannot hold");
  if (format == AssetFormat::kObj)
    for (const std::string& name : files.losses(scene.materials)) losses.push_back("materials' " + name);
  else if (!scene.materials.empty())
    losses.push_back("materials");
  losses.insert(losses.end(), scene.losses.begin(), scene.losses.end());
  return losses;
}

}  // namespace

Status write_mesh_output(const Document& document, const std::string& path, AssetFormat format,
                         const MeshOutputOptions& options, const Session& session, WriteReport& written,
                         EncodeStatistics& lost) {
  if (format == AssetFormat::kObj && options.images == ImagePlacement::kEmbed)
    return wrong_usage("an OBJ cannot embed images: use --images copy or reference");
  SceneParts scene(document, format, session.pool);
  if (Status status = scene.read(); !status.ok())
    return std::move(status).at({.file = document.source.string()});
  const Expected<fs::path> target = follow_links(path);
  if (!target) return target.status();
  MaterialFiles files(document, fs::absolute(*target), options.images, written);
  const std::string extension = lower_extension(path);
  if (format == AssetFormat::kDraco && scene.parts.size() != 1)
    return unsupported("a .drc holds one primitive, but the scene shows " + std::to_string(scene.parts.size()),
                       {.file = path});
  if (format == AssetFormat::kObj && !scene.materials.empty() && !fits_line(target->stem().string()))
    return unsupported("an OBJ with materials names its MTL file, and no line can hold this name",
                       {.file = path});
  if (const std::string losses = joined(losses_of(scene, format, files, options.coding.lossless));
      !losses.empty()) {
    if (!options.accept_loss)
      return unsupported("a " + extension +
                             " cannot hold all of the asset: with --accept-loss it is written without " +
                             losses,
                         {.file = path});
    session.log.warning(path + ": is written without " + losses);
  }
  if (scene.moved_count > 0)
    session.log.note(path + ": nodes move " + counted(scene.moved_count, "object") +
                     ": positions are those of the scene");
  if (format != AssetFormat::kObj && scene.parts.size() > 1)
    session.log.note(path + ": " + counted(scene.parts.size(), "primitive") + " become one mesh");
  written.files = {path};
  if (Status status = check_positions(scene.parts); !status.ok()) return std::move(status).at({.file = path});
  if (format == AssetFormat::kDraco)
    return write_draco(path, scene, options.coding, session, lost).at({.file = path});
  std::string library;
  if (format == AssetFormat::kObj && !scene.materials.empty()) {
    const Expected<std::string> name = files.write(scene.materials);
    if (!name) return name.status().at({.file = path});
    library = *name;
  }
  // In OBJ a material stays in use until the next one.
  if (!library.empty())
    std::stable_partition(scene.parts.begin(), scene.parts.end(),
                          [](const PlacedPart& part) { return part.material.empty(); });
  return write_mesh_file(path, format, scene.parts, library, session.if_read_only()).at({.file = path});
}

}  // namespace psplit
