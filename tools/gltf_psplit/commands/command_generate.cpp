// gltf-psplit generate: writes one of the built-in sample meshes.
#include <CLI/CLI.hpp>
#include <cstring>
#include <map>
#include <memory>

#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/document/write_document.h"
#include "gltf_ext/files/files.h"
#include "gltf_ext/primitive/accessors.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/ply_output.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

struct Arguments {
  std::string output, shape = "terrain";
  ShapeOptions options;
};

const std::map<std::string, Shape> kShapes{
    {"terrain", Shape::kTerrain}, {"blob", Shape::kBlob}, {"gyroid", Shape::kGyroid}, {"scene", Shape::kScene}};

constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr double kSpacing = 2.5;  // shapes are about two units wide

AccessorData index_data(const Mesh& mesh) {
  AccessorData data;
  data.count = static_cast<uint32_t>(mesh.faces.size() * 3);
  // Short indices must not be 65535, which is glTF's primitive restart value.
  data.component_type = mesh.point_count <= 65535 ? ComponentType::kUint16 : ComponentType::kUint32;
  data.values.resize(data.count * component_bytes(data.component_type));
  size_t offset = 0;
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) {
      const auto short_point = static_cast<uint16_t>(point);
      const size_t size = component_bytes(data.component_type);
      std::memcpy(data.values.data() + offset, size == 2 ? static_cast<const void*>(&short_point) : &point,
                  size);
      offset += size;
    }
  return data;
}

// Adds a mesh on a node of its own, to the right of the meshes before it.
void append_mesh(Document& document, const Mesh& mesh) {
  Json attributes = Json::object();
  for (const Attribute& attribute : mesh.attributes) {
    const AccessorData data{attribute.component_type, attribute.component_count, attribute.normalized,
                            mesh.point_count, attribute.values};
    attributes[attribute.semantic] =
        append_accessor(document, data, kArrayBuffer, attribute.semantic == "POSITION");
  }
  const int64_t indices = append_accessor(document, index_data(mesh), kElementArrayBuffer, false);
  Json& json = document.json;
  const size_t number = json["meshes"].size();
  json["meshes"].push_back({{"primitives", Json::array({{{"attributes", attributes}, {"indices", indices}}})}});
  json["scenes"][0]["nodes"].push_back(json["nodes"].size());
  json["nodes"].push_back(
      {{"mesh", number}, {"translation", Json::array({kSpacing * static_cast<double>(number), 0.0, 0.0})}});
}

void log_generated(const Arguments& arguments, uint64_t faces, uint64_t points, const Log& log) {
  const std::string bytes = sizes_text({{}, bytes_on_disk(arguments.output)});
  log.note((arguments.output == "-" ? "stdout" : arguments.output) + ": " + bytes +
           (bytes.empty() ? "" : ", ") + arguments.shape + ", " + counted(faces, "face") + ", " +
           counted(points, "point"));
}

Status generate_ply(const Arguments& arguments, const Session& session) {
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

Status run_generate(Arguments arguments, const Session& session) {
  arguments.options.shape = kShapes.at(arguments.shape);
  if (lower_extension(arguments.output) == ".ply") return generate_ply(arguments, session);
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
    document.json["meshes"][i]["name"] =
        meshes->size() == 1 ? arguments.shape : arguments.shape + " " + std::to_string(i + 1);
    faces += (*meshes)[i].faces.size();
    points += (*meshes)[i].point_count;
  }
  WriteOptions write;
  write.replace_read_only = session.force;
  if (Status status = write_document(document, arguments.output, write); !status.ok())
    return std::move(status).at({.file = arguments.output});
  log_generated(arguments, faces, points, session.log);
  return {};
}

}  // namespace

void add_generate_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  arguments->options.faces = 100000;
  arguments->options.seed = 1;
  CLI::App& command =
      *app.add_subcommand("generate", "Make a sample mesh. The same options always make the same mesh");
  command
      .add_option(
          "-o,--output,OUT", arguments->output,
          "The output: a .glb or .gltf file, or a binary .ply file, whose mesh may be larger than memory; - "
          "writes a GLB to stdout")
      ->required()
      ->type_name("FILE");
  command
      .add_option(
          "--shape", arguments->shape,
          "terrain: an open sheet; blob: a bumpy ball; gyroid: a solid of high genus; scene: six objects "
          "of different sizes")
      ->check(CLI::IsMember({"terrain", "blob", "gyroid", "scene"}))
      ->capture_default_str()
      ->type_name("NAME");
  add_count_option(command, "--faces", arguments->options.faces,
                   "About how many faces, for example 250000, 250k, 1.5M or 1e6");
  command
      .add_option("--seed", arguments->options.seed, "A number that selects one of many samples of the shape")
      ->capture_default_str()
      ->type_name("S");
  command.add_flag("--normals", arguments->options.normals, "Add normals");
  command.add_flag("--texcoords", arguments->options.texcoords,
                   "Add texture coordinates, in several charts with seams");
  add_examples(command,
               {{"gltf-psplit generate blob.glb --shape blob --faces 1e6", "a ball of a million faces"},
                {"gltf-psplit generate - --faces 20k | gltf-psplit encode - out.glb",
                 "encode without a file in between"},
                {"gltf-psplit generate scan.ply --faces 100M", "a mesh of 1.9 GB, in little memory"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_generate(*arguments, session); };
  });
}

}  // namespace psplit
