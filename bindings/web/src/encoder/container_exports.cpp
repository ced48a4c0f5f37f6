// The exports of the encoder of containers. Meshes are added by calls that return where their values go. Then
// their codings are chosen together, and each is encoded by a call of its own.
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "bindings/web/src/exports.h"
#include "encoder/coding/step_grid.h"
#include "psplit/encode.h"

// The module's only import: is told the number of faces of the mesh that are encoded.
extern "C" [[clang::import_module("psplit"), clang::import_name("faces_encoded")]] void faces_encoded(
    uint32_t faces);

namespace psplit::web {
namespace {

enum class Profile : uint32_t { kBalanced, kSpeed, kSize };
enum class PositionBits : uint32_t { kStated, kByEdges, kByError };

// What encode.js writes, in this order.
struct Options {
  double patches, patch_faces, min_faces, profile;
  double position_bits, normal_bits, texcoord_bits, color_bits, generic_bits, morph_bits, lossless;
  double position_bits_by, max_error;
  double speed, by_bytes, keep_duplicates, keep_degenerate, keep_unused;
  double condense, boxes, order, near_x, near_y, near_z, verify, points;
};

struct Source {
  MeshToEncode mesh{};
  Array<std::byte> distinct{};  // points that differ in these bytes are not merged
};

struct Encoding {
  std::vector<std::unique_ptr<Source>> sources;
  EncodeOptions options;
  EncodedMesh encoded;
  std::vector<uint32_t> words;
  ThreadPool pool{1};
};

PatchTarget patch_target(const Options& from) {
  PatchTarget target;
  target.count = static_cast<uint64_t>(from.patches);
  target.faces = static_cast<uint64_t>(from.patch_faces);
  target.min_faces = static_cast<uint64_t>(from.min_faces);
  if (target.count > 0 || target.faces > 0) return target;
  if (static_cast<Profile>(from.profile) == Profile::kSpeed) target.faces = kSpeedPatchFaces;
  if (static_cast<Profile>(from.profile) == Profile::kSize) target.most = kMostPatchesForSize;
  return target;
}

void read_options(const Options& from, EncodeOptions& options) {
  options.patches = patch_target(from);
  options.patches.always = true;
  options.storage = Storage::kContainer;
  options.position_bits = static_cast<int>(from.position_bits);
  options.normal_bits = static_cast<int>(from.normal_bits);
  options.texcoord_bits = static_cast<int>(from.texcoord_bits);
  options.color_bits = static_cast<int>(from.color_bits);
  options.generic_bits = static_cast<int>(from.generic_bits);
  options.morph_bits = static_cast<int>(from.morph_bits);
  options.lossless = from.lossless != 0;
  const auto by = static_cast<PositionBits>(from.position_bits_by);
  options.position_bits_by_edges = by == PositionBits::kByEdges;
  options.max_position_error = by == PositionBits::kByError ? from.max_error : 0;
  options.encode_speed = static_cast<int>(from.speed);
  options.choose_by_bytes = from.by_bytes != 0;
  options.keep_duplicates = from.keep_duplicates != 0;
  options.keep_degenerate = from.keep_degenerate != 0;
  options.keep_unused = from.keep_unused != 0;
  options.condense = static_cast<Condense>(from.condense);
  options.boxes = from.boxes != 0;
  options.order = {static_cast<PatchOrder::By>(from.order), {from.near_x, from.near_y, from.near_z}};
  options.verify = from.verify != 0;
  if (from.points != 0) options.storage = Storage::kCloud;
}

Status choose(const Options& from, Encoding& encoding, size_t& failed) {
  read_options(from, encoding.options);
  std::vector<MeshToEncode*> meshes;
  for (const std::unique_ptr<Source>& source : encoding.sources) {
    const Array<std::byte>& distinct = source->distinct;
    if (!distinct.empty())
      source->mesh.distinct = {{distinct, distinct.size() / source->mesh.mesh.point_count}};
    meshes.push_back(&source->mesh);
  }
  return plan(meshes, encoding.options, encoding.pool, {}, &failed);
}

}  // namespace

PSPLIT_WEB_EXPORT(new_encoding) Encoding* new_encoding() { return new Encoding; }
PSPLIT_WEB_EXPORT(free_encoding) void free_encoding(Encoding* encoding) { delete encoding; }
// Adds a mesh. Returns where its faces go, three numbers of points for each. Meshes of a group share grids.
PSPLIT_WEB_EXPORT(add_mesh)
void* add_mesh(Encoding* encoding, uint32_t point_count, uint32_t face_count, uint32_t group) {
  Source& source = *encoding->sources.emplace_back(new Source{});
  source.mesh.group = group;
  Mesh& mesh = source.mesh.mesh;
  mesh.point_count = point_count;
  mesh.faces.resize(face_count);
  return mesh.faces.data();
}
// Adds an attribute to the last mesh. `type` is glTF's. Returns where its values go, one for each point.
PSPLIT_WEB_EXPORT(add_attribute)
void* add_attribute(Encoding* encoding, const char* name, uint32_t name_bytes, uint32_t type,
                    uint32_t components, bool normalized) {
  Mesh& mesh = encoding->sources.back()->mesh.mesh;
  Attribute& attribute = mesh.attributes.emplace_back(Attribute{
      {name, name_bytes}, static_cast<ComponentType>(type), static_cast<uint8_t>(components), normalized, {}});
  attribute.values.resize(mesh.point_count * attribute.stride());
  return attribute.values.data();
}
// Returns where bytes go that keep points of the last mesh apart, `stride` for each point.
PSPLIT_WEB_EXPORT(add_distinct) void* add_distinct(Encoding* encoding, uint32_t stride) {
  Source& source = *encoding->sources.back();
  source.distinct.resize(size_t{stride} * source.mesh.mesh.point_count);
  return source.distinct.data();
}
// Keeps the attributes of this name exactly.
PSPLIT_WEB_EXPORT(keep_exactly) void keep_exactly(Encoding* encoding, const char* name, uint32_t name_bytes) {
  encoding->options.exact.emplace(name, name_bytes);
}
// Chooses codings and numbers of patches when all meshes are there. Returns -1, or the number of the mesh of an
// error.
PSPLIT_WEB_EXPORT(choose_codings) int32_t choose_codings(Encoding* encoding, const Options* options) {
  size_t failed = 0;
  return keep_error(choose(*options, *encoding, failed)) ? -1 : static_cast<int32_t>(failed);
}
// Fits the grid of positions to `count` offsets between meshes, once codings are chosen. False if that does not
// make surfaces meet that touched.
PSPLIT_WEB_EXPORT(fit_offsets)
bool fit_offsets(Encoding* encoding, const std::array<double, 3>* offsets, uint32_t count) {
  std::vector<AttributeCoding*> grids;
  for (const auto& source : encoding->sources)
    for (size_t k = 0; k < source->mesh.codings.size(); ++k)
      if (source->mesh.mesh.attributes[k].semantic == "POSITION" && source->mesh.codings[k].bits > 0)
        grids.push_back(&source->mesh.codings[k]);
  return fit_to_offsets(grids, {offsets, count});
}
// Encodes a mesh, once; what encode() returned before is gone then. Returns words that encode_job.js names, and
// for each attribute its unique id, bits, and the address of its decoded values. Null after an error.
PSPLIT_WEB_EXPORT(encode) const uint32_t* encode_one(Encoding* encoding, uint32_t i) {
  encoding->encoded = {};
  const std::unique_ptr<Source> source = std::move(encoding->sources[i]);
  const auto report = [](size_t done, size_t) { faces_encoded(static_cast<uint32_t>(done)); };
  Expected<EncodedMesh> made =
      encode(std::move(source->mesh), encoding->options, encoding->pool, Watch{report, nullptr});
  if (!keep_error(made.status())) return nullptr;
  EncodedMesh& encoded = encoding->encoded = std::move(*made);
  const EncodedPiece& piece = encoded.pieces[0];
  const auto address = [](const auto& array) { return reinterpret_cast<uint32_t>(array.data()); };
  const EncodeStatistics& statistics = encoded.statistics;
  encoding->words = {address(piece.bytes),
                     static_cast<uint32_t>(piece.bytes.size()),
                     piece.decoded.point_count,
                     static_cast<uint32_t>(piece.decoded.faces.size()),
                     statistics.patch_count,
                     static_cast<uint32_t>(piece.entries.size()),
                     static_cast<uint32_t>(statistics.merged_points),
                     static_cast<uint32_t>(statistics.dropped_points),
                     static_cast<uint32_t>(statistics.dropped_faces),
                     piece.head_bytes,
                     address(piece.source_point),
                     address(piece.decoded.faces)};
  for (size_t k = 0; k < encoded.requests.size(); ++k) {
    encoding->words.push_back(encoded.requests[k].unique_id);
    encoding->words.push_back(static_cast<uint32_t>(encoded.codings[k].bits));
    encoding->words.push_back(address(piece.decoded.attributes[k].values));
  }
  return encoding->words.data();
}
// The largest distance between a position of the last mesh and its decoded one; NaN if it was not verified.
PSPLIT_WEB_EXPORT(position_error) double position_error(const Encoding* encoding) {
  return encoding->encoded.statistics.position_error.value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace psplit::web
