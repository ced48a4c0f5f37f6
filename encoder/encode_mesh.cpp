#include "encoder/encode_mesh.h"

#include <algorithm>
#include <cstring>

#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/stitching/build_stitching.h"
#include "encoder/verify.h"
#include "encoder/welding/reduce.h"
#include "encoder/welding/weld.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

Status check_input(const Mesh& mesh, std::span<const AttributeCoding> codings, std::span<const std::byte> extra,
                   size_t extra_stride) {
  if (mesh.find("POSITION") == nullptr) return invalid_input("the mesh has no POSITION");
  if (mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  if (codings.size() != mesh.attributes.size()) return invalid_input("one coding is needed per attribute");
  if (extra.size() != extra_stride * mesh.point_count) return invalid_input("extra data of the wrong size");
  for (size_t i = 0; i < codings.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    const AttributeCoding& coding = codings[i];
    const bool is_float = attribute.component_type == ComponentType::kFloat32;
    if (attribute.component_count < 1 || attribute.component_count > 16)
      return unsupported(attribute.semantic + " has " + std::to_string(attribute.component_count) +
                         " components");
    if (attribute.values.size() != attribute.stride() * mesh.point_count)
      return invalid_input(attribute.semantic + " has values for another number of points");
    // glTF has none, and libdraco's encoder takes memory by the largest value.
    if (attribute.component_type == ComponentType::kUint32)
      return unsupported(attribute.semantic + " holds 32-bit integers");
    if (coding.bits == 0) continue;
    if (!is_float || coding.bits < (coding.octahedral ? 2 : 1) || coding.bits > 30)
      return invalid_input(attribute.semantic + " cannot be quantized to " + std::to_string(coding.bits) +
                           " bits");
    if (coding.octahedral ? attribute.component_count != 3 : coding.origin.size() != attribute.component_count)
      return invalid_input(attribute.semantic + " has no grid of its number of components");
    if (!coding.octahedral && !grid_extremes(coding))
      return invalid_input(attribute.semantic + ": no floats are exactly its grid's range apart; see fit_grid");
  }
  for (const auto& face : mesh.faces)
    for (uint32_t point : face)
      if (point >= mesh.point_count)
        return invalid_input("an index is " + std::to_string(point) + ", but there are " +
                             std::to_string(mesh.point_count) + " points");
  return {};
}

// Faces by patch, those that repeat an index set aside: Edgebreaker cannot carry them.
struct Cut {
  std::vector<std::vector<uint32_t>> patches;  // faces of the mesh
  std::vector<uint32_t> residue_faces;
};

Cut cut_faces(const Mesh& mesh, const WeldedMesh& welded, const EncodeOptions& options,
              const ThreadPool& pool) {
  size_t position = 0;
  while (mesh.attributes[position].semantic != "POSITION") ++position;
  const std::vector<uint32_t>& vertex = welded.value_of_point[position];
  std::vector<uint32_t> number(mesh.point_count, kNone);
  uint32_t vertex_count = 0;
  Cut cut;
  std::vector<uint32_t> regular;
  std::vector<std::array<uint32_t, 3>> vertices;
  for (uint32_t i = 0; i < mesh.faces.size(); ++i) {
    std::array<uint32_t, 3> face{};
    for (size_t c = 0; c < 3; ++c) face[c] = vertex[mesh.faces[i][c]];
    if (repeats_a_point(face)) {  // two points of one face are never one vertex (separate_flat_faces)
      cut.residue_faces.push_back(i);
      continue;
    }
    for (uint32_t& v : face) {
      if (number[v] == kNone) number[v] = vertex_count++;
      v = number[v];
    }
    regular.push_back(i);
    vertices.push_back(face);
  }
  if (vertices.empty()) return cut;
  Partition partition;
  if (options.patch_of_face.empty()) {
    PartitionOptions partition_options;
    partition_options.patch_count = options.patch_count;
    partition_options.refine = options.refine;
    partition_options.method = options.method;
    partition_options.distance = options.distance;
    partition = partition_faces(vertices, vertex_count, partition_options, pool);
  } else {
    for (const uint32_t face : regular) partition.patch_of_face.push_back(options.patch_of_face[face]);
    partition.patch_count =
        *std::max_element(partition.patch_of_face.begin(), partition.patch_of_face.end()) + 1;
  }
  cut.patches.resize(partition.patch_count);
  for (size_t i = 0; i < regular.size(); ++i) cut.patches[partition.patch_of_face[i]].push_back(regular[i]);
  std::erase_if(cut.patches, [](const std::vector<uint32_t>& faces) { return faces.empty(); });
  return cut;
}

PatchMesh extract(const Mesh& mesh, std::span<const uint32_t> faces) {
  PatchMesh patch;
  patch.faces.reserve(faces.size());
  patch.points.reserve(faces.size() * 3);
  for (uint32_t face : faces)
    for (uint32_t point : mesh.faces[face]) patch.points.push_back(point);
  std::sort(patch.points.begin(), patch.points.end());
  patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
  const auto local = [&](uint32_t point) {
    return static_cast<uint32_t>(std::lower_bound(patch.points.begin(), patch.points.end(), point) -
                                 patch.points.begin());
  };
  for (uint32_t face : faces) {
    const auto& points = mesh.faces[face];
    patch.faces.push_back({local(points[0]), local(points[1]), local(points[2])});
  }
  return patch;
}

// The faces set aside, the points that no other stream has, and faces of padding that bring the stream as many
// corners as a sequential decoder wants for its points.
struct Residue {
  PatchMesh patch;
  uint32_t face_count = 0;   // without padding
  uint32_t owned_count = 0;  // points that no other stream has
};

Residue extract_residue(const Mesh& mesh, const Cut& cut, bool standalone) {
  Residue residue;
  residue.patch = extract(mesh, cut.residue_faces);
  residue.face_count = static_cast<uint32_t>(cut.residue_faces.size());
  enum Use : uint8_t { kUnused, kInResidue, kInPatch };
  std::vector<uint8_t> use(mesh.point_count, kUnused);
  for (const uint32_t point : residue.patch.points) use[point] = kInResidue;
  for (const auto& faces : cut.patches)
    for (const uint32_t face : faces)
      for (const uint32_t point : mesh.faces[face]) use[point] = kInPatch;
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    residue.owned_count += use[point] == kInPatch ? 0 : 1;
    if (use[point] == kUnused) residue.patch.points.push_back(point);
  }
  while (residue.patch.faces.size() * 3 < residue.patch.points.size()) residue.patch.faces.push_back({0, 0, 0});
  if (standalone) return residue;
  // A copy's values are its owner's, whatever stands here: the value before it costs least.
  for (const uint32_t point : residue.patch.points)
    residue.patch.value_points.push_back(use[point] != kInPatch ? point
                                         : residue.patch.value_points.empty()
                                             ? residue.patch.points.front()
                                             : residue.patch.value_points.back());
  return residue;
}

}  // namespace

Expected<EncodedMesh> encode_mesh(const Mesh& input, std::span<const AttributeCoding> codings,
                                  const EncodeOptions& options, const ThreadPool& pool,
                                  std::span<const std::byte> extra_point_data, size_t extra_stride) {
  if (Status status = check_input(input, codings, extra_point_data, extra_stride); !status.ok()) return status;
  const Stopwatch total;
  EncodedMesh encoded;
  EncodeStatistics& statistics = encoded.statistics;
  const ReducedMesh reduced =
      reduce(input, {options.keep_duplicates, options.drop_degenerate, options.drop_unused}, extra_point_data,
             extra_stride);
  statistics.merged_points = reduced.merged_points;
  statistics.dropped_faces = reduced.dropped_faces;
  statistics.dropped_points = reduced.dropped_points;
  const Mesh& mesh = reduced.mesh;
  if (mesh.faces.empty()) return unsupported("no triangles but degenerate ones");
  if (!options.patch_of_face.empty() && options.patch_of_face.size() != mesh.faces.size())
    return Status(StatusCode::kUsage, "a partition of another number of faces");
  WeldedMesh welded = weld(mesh, pool);
  separate_flat_faces(welded);

  const Stopwatch partition_time;
  const Cut cut = cut_faces(mesh, welded, options, pool);
  statistics.partition_ms = partition_time.ms();
  const size_t patch_count = cut.patches.size();
  statistics.patch_count = static_cast<uint32_t>(patch_count);
  statistics.residue_faces = cut.residue_faces.size();

  std::vector<OwnedStream> streams(patch_count);
  std::vector<std::vector<uint8_t>> stream_bytes(patch_count);
  std::vector<Status> statuses(patch_count);
  pool.for_each(patch_count, [&](size_t i) {
    const PatchMesh patch = extract(mesh, cut.patches[i]);
    Expected<std::vector<uint8_t>> bytes = encode_edgebreaker(welded, patch, codings, options.encode_speed);
    Expected<DecodedOrder> order = edgebreaker_order(welded, patch, options.encode_speed);
    if (!bytes || !order) {
      statuses[i] = (bytes ? order.status() : bytes.status()).at({.patch = static_cast<int64_t>(i)});
      return;
    }
    stream_bytes[i] = std::move(*bytes);
    streams[i].faces = std::move(order->faces);
    streams[i].points.reserve(order->patch_point.size());
    for (uint32_t point : order->patch_point) streams[i].points.push_back(patch.points[point]);
    if (options.patch_encoded) options.patch_encoded(cut.patches[i].size());
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);

  Residue residue = extract_residue(mesh, cut, options.standalone_residue);
  const bool has_residue = !residue.patch.points.empty();
  statistics.residue_points = residue.owned_count;
  if (has_residue) {
    Expected<std::vector<uint8_t>> bytes =
        encode_sequential(welded, residue.patch, codings, options.encode_speed);
    if (!bytes) return bytes.status();
    stream_bytes.push_back(std::move(*bytes));
    residue.patch.faces.resize(residue.face_count);
    streams.push_back({std::move(residue.patch.faces), std::move(residue.patch.points), true});
  }

  Stitching stitching = build_stitching(streams, mesh.point_count, pool);
  std::vector<StreamEntry> entries;
  for (size_t i = 0; i < streams.size(); ++i) {
    if (stream_bytes[i].size() > 0xffffffffu) return unsupported("a patch takes more than 4 GB");
    entries.push_back({static_cast<uint32_t>(stream_bytes[i].size()),
                       static_cast<uint32_t>(streams[i].faces.size()),
                       static_cast<uint32_t>(streams[i].points.size()), stitching.reference_counts[i],
                       static_cast<uint32_t>(stitching.maps[i].size())});
  }
  encoded.container = write_container(entries, has_residue, stitching.maps, stream_bytes);
  encoded.unique_ids = stream_unique_ids(mesh);
  statistics.encode_ms = total.ms();

  if (options.verify) {
    const Stopwatch verify_time;
    std::vector<AttributeRequest> requests;
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Attribute& attribute = mesh.attributes[i];
      requests.push_back({attribute.semantic, encoded.unique_ids[i], attribute.component_type,
                          attribute.component_count, attribute.normalized});
    }
    const Expected<PatchContainer> container = open_container(encoded.container);
    if (!container) return runtime_failure("verification: " + container.status().to_string());
    Expected<Mesh> decoded = draco_backend().decode(*container, requests, pool);
    if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
    if (Status status = verify_decoded(mesh, codings, *decoded, stitching.source_point); !status.ok())
      return status;
    encoded.decoded = std::move(*decoded);
    statistics.verify_ms = verify_time.ms();
  }
  encoded.source_point = std::move(stitching.source_point);
  for (uint32_t& point : encoded.source_point) point = reduced.source_point[point];
  return encoded;
}

}  // namespace psplit
