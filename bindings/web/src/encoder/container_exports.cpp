// The exports of the encoder of containers. Meshes are added by calls that return where their values go. Then
// their codings are chosen together, and each is encoded by a call of its own.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "bindings/web/src/exports.h"
#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/coding/step_grid.h"
#include "encoder/encode_mesh.h"
#include "encoder/encode_streams.h"
#include "encoder/patch_counts.h"
#include "encoder/shared_codings.h"
#include "encoder/welding/reduce.h"

// The module's only import: is told the number of faces of each encoded patch.
extern "C" [[clang::import_module("psplit"), clang::import_name("patch_encoded")]] void patch_encoded(
    uint32_t faces);

namespace psplit::web {
namespace {

enum class Profile : uint32_t { kBalanced, kSpeed, kSize };
enum class PositionBits : uint32_t { kStated, kByEdges, kByError };
enum class Condense : uint32_t { kNo, kFast, kSmallest };

// What encode.js writes, in this order.
struct Options {
  double patches, patch_faces, min_faces, profile;
  double position_bits, normal_bits, texcoord_bits, color_bits, generic_bits, lossless;
  double position_bits_by, max_error;
  double speed, by_bytes, keep_duplicates, keep_degenerate, keep_unused;
  double condense, boxes, order, near_x, near_y, near_z, verify;
};

struct Source {
  Mesh mesh;
  size_t group;
  Array<std::byte> distinct;  // points that differ in these bytes are not merged
  std::vector<AttributeCoding> codings;
  uint32_t patch_count = 1;
};

// Data that keeps points apart whose attributes are equal: the caller's, and weights before rounding.
struct Distinct {
  std::vector<std::byte> bytes;
  size_t stride = 0;

  explicit Distinct(const Source& source) {
    std::vector<const Array<std::byte>*> sources{&source.distinct};
    for (const Attribute& attribute : source.mesh.attributes)
      if (attribute.semantic.starts_with("WEIGHTS_")) sources.push_back(&attribute.values);
    const size_t points = source.mesh.point_count;
    for (const auto* values : sources) stride += points == 0 ? 0 : values->size() / points;
    bytes.resize(stride * points);
    size_t offset = 0;
    for (const auto* values : sources) {
      const size_t width = points == 0 ? 0 : values->size() / points;
      for (size_t i = 0; i < points && width > 0; ++i)
        std::memcpy(bytes.data() + i * stride + offset, values->data() + i * width, width);
      offset += width;
    }
  }
};

struct Encoding {
  std::vector<std::unique_ptr<Source>> sources;
  std::set<std::string> exact;
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

EncodeOptions encode_options(const Options& from) {
  EncodeOptions options;
  options.encode_speed = static_cast<int>(from.speed);
  options.choose_by_bytes = from.by_bytes != 0;
  options.keep_duplicates = from.keep_duplicates != 0;
  options.drop_degenerate = from.keep_degenerate == 0;
  options.drop_unused = from.keep_unused == 0;
  options.condense = static_cast<Condense>(from.condense) != Condense::kNo;
  options.condense_smallest = static_cast<Condense>(from.condense) == Condense::kSmallest;
  options.boxes = from.boxes != 0;
  options.order = {static_cast<PatchOrder::By>(from.order), {from.near_x, from.near_y, from.near_z}};
  options.verify = from.verify != 0;
  options.patch_encoded = [](size_t faces) { patch_encoded(static_cast<uint32_t>(faces)); };
  return options;
}

CodingOptions coding_options(const Options& from) {
  const auto by = static_cast<PositionBits>(from.position_bits_by);
  CodingOptions options{static_cast<int>(from.position_bits), static_cast<int>(from.normal_bits),
                        static_cast<int>(from.texcoord_bits), static_cast<int>(from.color_bits),
                        static_cast<int>(from.generic_bits),  from.lossless != 0};
  options.give_changed_bits();
  if (by == PositionBits::kStated) return options;
  options.position_bits = kMostPositionBits;
  options.given.position = by == PositionBits::kByError;
  return options;
}

Status choose(const Options& from, Encoding& encoding, size_t& failed) {
  encoding.options = encode_options(from);
  std::vector<MeshToCode> meshes;
  std::vector<uint64_t> faces;
  for (failed = 0; failed < encoding.sources.size(); ++failed) {
    Source& source = *encoding.sources[failed];
    const std::vector<AttributeCoding> none(source.mesh.attributes.size());
    if (Status status = check_mesh(source.mesh, none); !status.ok()) return status;
    if (source.mesh.faces.empty()) return invalid_input("the mesh has no triangles");
    faces.push_back(source.mesh.faces.size());
    const ReduceOptions reduce{encoding.options.keep_duplicates, encoding.options.drop_degenerate,
                               encoding.options.drop_unused};
    meshes.push_back({&source.mesh, source.group, [&source, reduce] {
                        const Distinct distinct(source);
                        return stored_points(source.mesh, reduce, distinct.bytes, distinct.stride);
                      }});
  }
  const CodingOptions coding = coding_options(from);
  auto codings = choose_shared_codings(meshes, coding, encoding.exact, encoding.pool);
  if (const auto by = static_cast<PositionBits>(from.position_bits_by); by != PositionBits::kStated) {
    const auto max_error = by == PositionBits::kByError ? std::optional(from.max_error) : std::nullopt;
    if (Status status = choose_position_bits(meshes, max_error, codings, failed); !status.ok()) return status;
  }
  guard_precision(meshes, coding, encoding.exact, codings, encoding.pool);
  const std::vector<uint32_t> counts = patch_counts(faces, patch_target(from));
  for (size_t i = 0; i < counts.size(); ++i) {
    encoding.sources[i]->codings = std::move(codings[i]);
    encoding.sources[i]->patch_count = counts[i];
  }
  return {};
}

Expected<EncodedMesh> encode(Encoding& encoding, Source& source) {
  const Distinct distinct(source);
  round_weights(source.mesh, source.codings);
  encoding.options.patch_count = source.patch_count;
  return encode_mesh(source.mesh, source.codings, encoding.options, encoding.pool, distinct.bytes,
                     distinct.stride);
}

}  // namespace

PSPLIT_WEB_EXPORT(new_encoding) Encoding* new_encoding() { return new Encoding; }
PSPLIT_WEB_EXPORT(free_encoding) void free_encoding(Encoding* encoding) { delete encoding; }
// Adds a mesh. Returns where its faces go, three numbers of points for each. Meshes of a group share grids.
PSPLIT_WEB_EXPORT(add_mesh)
void* add_mesh(Encoding* encoding, uint32_t point_count, uint32_t face_count, uint32_t group) {
  Source& source = *encoding->sources.emplace_back(new Source{});
  source.group = group;
  source.mesh.point_count = point_count;
  source.mesh.faces.resize(face_count);
  return source.mesh.faces.data();
}
// Adds an attribute to the last mesh. `type` is glTF's. Returns where its values go, one for each point.
PSPLIT_WEB_EXPORT(add_attribute)
void* add_attribute(Encoding* encoding, const char* name, uint32_t name_bytes, uint32_t type,
                    uint32_t components, bool normalized) {
  Mesh& mesh = encoding->sources.back()->mesh;
  Attribute& attribute = mesh.attributes.emplace_back(Attribute{
      {name, name_bytes}, static_cast<ComponentType>(type), static_cast<uint8_t>(components), normalized, {}});
  attribute.values.resize(mesh.point_count * attribute.stride());
  return attribute.values.data();
}
// Returns where bytes go that keep points of the last mesh apart, `stride` for each point.
PSPLIT_WEB_EXPORT(add_distinct) void* add_distinct(Encoding* encoding, uint32_t stride) {
  Source& source = *encoding->sources.back();
  source.distinct.resize(size_t{stride} * source.mesh.point_count);
  return source.distinct.data();
}
// Keeps the attributes of this name exactly.
PSPLIT_WEB_EXPORT(keep_exactly) void keep_exactly(Encoding* encoding, const char* name, uint32_t name_bytes) {
  encoding->exact.emplace(name, name_bytes);
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
    for (size_t k = 0; k < source->codings.size(); ++k)
      if (source->mesh.attributes[k].semantic == "POSITION" && source->codings[k].bits > 0)
        grids.push_back(&source->codings[k]);
  return fit_to_offsets(grids, {offsets, count});
}
// Encodes a mesh, once; what encode() returned before is gone then. Returns words that encode_job.js names, and
// for each attribute its unique id, bits, and the address of its decoded values. Null after an error.
PSPLIT_WEB_EXPORT(encode) const uint32_t* encode_one(Encoding* encoding, uint32_t i) {
  encoding->encoded = {};
  const std::unique_ptr<Source> source = std::move(encoding->sources[i]);
  Expected<EncodedMesh> made = encode(*encoding, *source);
  if (!keep_error(made.status())) return nullptr;
  EncodedMesh& encoded = encoding->encoded = std::move(*made);
  const auto address = [](const auto& array) { return reinterpret_cast<uint32_t>(array.data()); };
  const EncodeStatistics& statistics = encoded.statistics;
  encoding->words = {address(encoded.container),
                     static_cast<uint32_t>(encoded.container.size()),
                     encoded.decoded.point_count,
                     static_cast<uint32_t>(encoded.decoded.faces.size()),
                     statistics.patch_count,
                     static_cast<uint32_t>(encoded.entries.size()),
                     static_cast<uint32_t>(statistics.merged_points),
                     static_cast<uint32_t>(statistics.dropped_points),
                     static_cast<uint32_t>(statistics.dropped_faces),
                     encoded.head_bytes,
                     address(encoded.source_point),
                     address(encoded.decoded.faces)};
  for (size_t k = 0; k < encoded.requests.size(); ++k) {
    encoding->words.push_back(encoded.requests[k].unique_id);
    encoding->words.push_back(static_cast<uint32_t>(source->codings[k].bits));
    encoding->words.push_back(address(encoded.decoded.attributes[k].values));
  }
  return encoding->words.data();
}
// Of the last mesh: the largest distance between a position and its decoded one. NaN if it was not verified.
PSPLIT_WEB_EXPORT(position_error) double position_error(const Encoding* encoding) {
  return encoding->encoded.statistics.position_error.value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace psplit::web
