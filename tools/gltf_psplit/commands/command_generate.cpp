// gltf-psplit generate: writes one of the built-in sample meshes.
#include <CLI/CLI.hpp>
#include <bit>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <string>

#include "gltf_ext/json/json.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "mesh_files/write_mesh_file.h"
#include "psplit/base.h"
#include "psplit/document.h"
#include "psplit/parallel.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/commands/character_document.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

struct GenerateArguments {
  std::string output, shape = "terrain";
  ShapeOptions options;
};

const std::map<std::string, Shape> kShapes{
    {"terrain", Shape::kTerrain}, {"blob", Shape::kBlob}, {"gyroid", Shape::kGyroid}, {"scene", Shape::kScene}};

const std::string kCharacter = "character";

constexpr double kSpacing = 2.5;  // shapes are about two units wide

// Adds a mesh on a node of its own, to the right of the meshes before it.
void append_mesh(Document& document, const Mesh& mesh) {
  Json& json = document.json();
  const size_t number = json["meshes"].size();
  json["meshes"].push_back({{"primitives", Json::array({append_primitive(document, mesh)})}});
  json["scenes"][0]["nodes"].push_back(json["nodes"].size());
  json["nodes"].push_back(
      {{"mesh", number}, {"translation", Json::array({kSpacing * static_cast<double>(number), 0.0, 0.0})}});
}

void log_generated(const GenerateArguments& arguments, uint64_t faces, uint64_t points, const Log& log) {
  const std::string bytes = sizes_text({{}, bytes_on_disk(arguments.output)});
  log.note((arguments.output == "-" ? "stdout" : arguments.output) + ": " + bytes +
           (bytes.empty() ? "" : ", ") + arguments.shape + ", " + counted(faces, "face") + ", " +
           counted(points, "point"));
}

static_assert(std::endian::native == std::endian::little);

constexpr size_t kFaceBytes = 1 + 3 * sizeof(int32_t);

std::string header_text(const ShapeStream& shape, bool normals) {
  std::string properties;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    if (normals || name[0] != 'n') properties += std::string("property float ") + name + "\n";
  return ply_header_text(shape.point_count(), properties, shape.face_count());
}

// Two growing regions of the file: the points, and the faces after all points.
class PlyWriter {
 public:
  PlyWriter(std::FILE* file, uint64_t points_at, uint64_t faces_at)
      : file_(file), points_at_(points_at), faces_at_(faces_at) {}

  bool append(const ShapePiece& piece) { return append_points(piece) && append_faces(piece); }

 private:
  bool append_points(const ShapePiece& piece) {
    constexpr size_t kVector = 3 * sizeof(float);
    if (piece.normals.empty())
      return write(points_at_, piece.positions.data(), piece.positions.size() * kVector);
    bytes_.resize(piece.positions.size() * 2 * kVector);
    uint8_t* to = bytes_.data();
    for (size_t i = 0; i < piece.positions.size(); ++i, to += 2 * kVector) {
      std::memcpy(to, piece.positions[i].data(), kVector);
      std::memcpy(to + kVector, piece.normals[i].data(), kVector);
    }
    return write(points_at_, bytes_.data(), bytes_.size());
  }

  bool append_faces(const ShapePiece& piece) {
    bytes_.resize(piece.faces.size() * kFaceBytes);
    uint8_t* to = bytes_.data();
    for (const auto& face : piece.faces) {
      *to = 3;
      std::memcpy(to + 1, face.data(), kFaceBytes - 1);
      to += kFaceBytes;
    }
    return write(faces_at_, bytes_.data(), bytes_.size());
  }

  bool write(uint64_t& at, const void* bytes, size_t size) {
    if (!seek_to(file_, at)) return false;
    at += size;
    return std::fwrite(bytes, 1, size, file_) == size;
  }

  std::FILE* file_;
  uint64_t points_at_, faces_at_;
  Array<uint8_t> bytes_;
};

// Writes little-endian PLY: x y z and, if the shape has normals, nx ny nz as floats; faces as a uchar 3 and
// three ints. The file appears whole or not at all (system/files.h). It must be a regular file, because
// points and faces are written to two places alternately. `progress` counts faces. Errors: as for write_file.
Status write_ply(const std::string& path, const ShapeStream& shape, bool normals, const ThreadPool& pool,
                 const Progress& progress, IfReadOnly if_read_only) {
  const std::string header = header_text(shape, normals);
  const uint64_t point_bytes = (normals ? 6 : 3) * sizeof(float);
  const auto write = [&](std::FILE* file) {
    if (std::fwrite(header.data(), 1, header.size(), file) != header.size()) return false;
    PlyWriter writer(file, header.size(), header.size() + shape.point_count() * point_bytes);
    uint64_t done = 0;
    const auto take = [&](ShapePiece&& piece) {
      if (!writer.append(piece)) return io_failure("cannot write");
      done += piece.faces.size();
      if (progress) progress(done, shape.face_count());
      return Status();
    };
    return shape.read(pool, take).ok();
  };
  return write_file(path, write, if_read_only);
}

Status generate_ply(const GenerateArguments& arguments, const Session& session) {
  if (Status status = check_output_place(arguments.output, session.force); !status.ok()) return status;
  Expected<ShapeStream> shape = [&] {
    const ProgressBar bar("measuring", session.log);
    return ShapeStream::open(arguments.options, session.pool);
  }();
  if (!shape) return std::move(shape).status().at({.file = arguments.output});
  {
    ProgressBar bar("generating", session.log);
    const bool normals = arguments.options.normals;
    if (Status status = write_ply(arguments.output, *shape, normals, session.pool, bar.callback("face"),
                                  session.if_read_only());
        !status.ok())
      return std::move(status).at({.file = arguments.output});
  }
  log_generated(arguments, shape->face_count(), shape->point_count(), session.log);
  return {};
}

Status write_generated(const GenerateArguments& arguments, const Document& document, const Session& session) {
  WriteOptions write;
  write.replace_read_only = session.force;
  return write_document(document, arguments.output, write).at({.file = arguments.output});
}

Status generate_character_asset(const GenerateArguments& arguments, const Session& session) {
  const Expected<Character> character = [&] {
    const ProgressBar bar("generating", session.log);
    return generate_character(arguments.options.faces, arguments.options.seed, session.pool);
  }();
  if (!character) return character.status();
  Document document = character_document(*character);
  document.json()["meshes"][0]["name"] = arguments.shape;
  if (Status status = write_generated(arguments, document, session); !status.ok()) return status;
  log_generated(arguments, character->mesh.faces.size(), character->mesh.point_count, session.log);
  return {};
}

Status run_generate(GenerateArguments arguments, const Session& session) {
  const bool is_ply = lower_extension(arguments.output) == ".ply";
  if (arguments.shape == kCharacter) {
    if (is_ply)
      return wrong_usage("a .ply file holds no skin and no morph targets: write a .glb or .gltf file");
    if (Status status = check_output_path(arguments.output, session.force, ".ply"); !status.ok()) return status;
    return generate_character_asset(arguments, session);
  }
  arguments.options.shape = kShapes.at(arguments.shape);
  if (is_ply) return generate_ply(arguments, session);
  if (Status status = check_output_path(arguments.output, session.force, ".ply"); !status.ok()) return status;
  const Expected<std::vector<Mesh>> meshes = [&] {
    const ProgressBar bar("generating", session.log);
    return generate_shape(arguments.options, session.pool);
  }();
  if (!meshes) return meshes.status();
  if (meshes->empty()) return runtime_failure("the shape has no meshes");
  Document document = document_from_mesh(meshes->front());
  for (size_t i = 1; i < meshes->size(); ++i) append_mesh(document, (*meshes)[i]);
  uint64_t faces = 0, points = 0;
  for (size_t i = 0; i < meshes->size(); ++i) {
    document.json()["meshes"][i]["name"] =
        meshes->size() == 1 ? arguments.shape : arguments.shape + " " + std::to_string(i + 1);
    faces += (*meshes)[i].faces.size();
    points += (*meshes)[i].point_count;
  }
  if (Status status = write_generated(arguments, document, session); !status.ok()) return status;
  log_generated(arguments, faces, points, session.log);
  return {};
}

}  // namespace

void add_generate_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<GenerateArguments>();
  arguments->options.faces = 100000;
  arguments->options.seed = 1;
  add_word_option(
      command, "-o,--output,OUT", arguments->output, "FILE",
      "The output: a .glb or .gltf file, or a binary .ply file, whose mesh may be larger than memory; - "
      "writes a GLB to stdout")
      ->required();
  add_choice_option(
      command, "--shape", arguments->shape, {"terrain", "blob", "gyroid", "scene", kCharacter},
      "terrain: an open sheet; blob: a bumpy ball; gyroid: a solid of high genus; scene: six objects "
      "of different sizes; character: a body with seams, a skin, morph targets and an animation. Not for a "
      ".ply");
  add_count_option(command, "--faces", arguments->options.faces,
                   "The approximate number of faces, for example 250000, 250k, 1.5M or 1e6");
  command
      .add_option("--seed", arguments->options.seed, "A number that selects one of many samples of the shape")
      ->capture_default_str()
      ->type_name("S");
  command.add_flag("--normals", arguments->options.normals, "Add normals. A character always has them");
  command.add_flag(
      "--texcoords", arguments->options.texcoords,
      "Add texture coordinates, in several charts with seams. Not for a .ply. A character always has "
      "them");
  add_examples(
      command,
      {{"gltf-psplit generate blob.glb --shape blob --faces 1e6", "a ball of a million faces"},
       {"gltf-psplit generate hero.glb --shape character --faces 30k", "a character as games have them"},
       {"gltf-psplit generate - --faces 20k | gltf-psplit encode - out.glb",
        "encode without a file in between"},
       {"gltf-psplit generate scan.ply --faces 100M", "a mesh of 1.9 GB, in little memory"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_generate(*arguments, session); };
  });
}

}  // namespace psplit
