#include "encoder/draco/patch_stream.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>
#include <numeric>

#include "encoder/coding/quantization.h"
#include "encoder/draco/patch_steps.h"

namespace psplit {
namespace {

draco::DataType draco_type(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return draco::DT_INT8;
    case ComponentType::kUint8: return draco::DT_UINT8;
    case ComponentType::kInt16: return draco::DT_INT16;
    case ComponentType::kUint16: return draco::DT_UINT16;
    case ComponentType::kUint32: return draco::DT_UINT32;
    case ComponentType::kFloat32: return draco::DT_FLOAT32;
  }
  return draco::DT_INVALID;
}

// Draco's attribute type selects the prediction. Normals that are not on the octahedral grid, and texture
// coordinates that are not pairs, must not get the schemes of their types, which cannot handle them.
draco::GeometryAttribute::Type draco_role(const Attribute& attribute, const AttributeCoding& coding) {
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (attribute.semantic == "POSITION") return draco::GeometryAttribute::POSITION;
  if (attribute.semantic == "NORMAL" && coding.octahedral) return draco::GeometryAttribute::NORMAL;
  if (starts("TEXCOORD_") && attribute.component_count == 2) return draco::GeometryAttribute::TEX_COORD;
  if (starts("COLOR_")) return draco::GeometryAttribute::COLOR;
  return draco::GeometryAttribute::GENERIC;
}

// Indices of the mesh's attributes in the order of their unique ids.
std::vector<size_t> attribute_order(const Mesh& mesh) {
  std::vector<size_t> order(mesh.attributes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_partition(order.begin(), order.end(),
                        [&](size_t i) { return mesh.attributes[i].semantic == "POSITION"; });
  return order;
}

// The distinct values of one attribute in a patch. `values` holds points of the mesh, ascending. `index` holds,
// for each point of the patch, the place of its value in `values`.
struct PatchValues {
  std::vector<uint32_t> values;
  std::vector<uint32_t> index;

  PatchValues(const std::vector<uint32_t>& value_of_point, const std::vector<uint32_t>& points) {
    index.reserve(points.size());
    for (uint32_t point : points) index.push_back(value_of_point[point]);
    values = index;
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    for (uint32_t& value : index)
      value = static_cast<uint32_t>(std::lower_bound(values.begin(), values.end(), value) - values.begin());
  }
};

void set_faces(draco::Mesh& mesh, const PatchMesh& patch) {
  mesh.set_num_points(static_cast<uint32_t>(patch.points.size()));
  mesh.SetNumFaces(patch.faces.size());
  for (uint32_t i = 0; i < patch.faces.size(); ++i) {
    const auto& face = patch.faces[i];
    mesh.SetFace(draco::FaceIndex(i),
                 {draco::PointIndex(face[0]), draco::PointIndex(face[1]), draco::PointIndex(face[2])});
  }
}

// Leaves room for `spare` values after those that points use. libdraco does not store them.
draco::PointAttribute* add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type role, uint8_t components,
                                     draco::DataType type, bool normalized, const PatchValues& values,
                                     size_t spare = 0) {
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(role, static_cast<int8_t>(components), type, normalized, values.values.size() + spare);
  attribute->SetExplicitMapping(values.index.size());
  for (uint32_t i = 0; i < values.index.size(); ++i)
    attribute->SetPointMapEntry(draco::PointIndex(i), draco::AttributeValueIndex(values.index[i]));
  return mesh.attribute(mesh.AddAttribute(std::move(attribute)));
}

void fill_mesh(draco::Mesh& mesh, const WeldedMesh& welded, const PatchMesh& patch,
               std::span<const AttributeCoding> codings) {
  set_faces(mesh, patch);
  for (size_t i : attribute_order(*welded.mesh)) {
    const Attribute& source = welded.mesh->attributes[i];
    const PatchValues values(welded.value_of_point[i], patch.points_of_values());
    const bool on_grid = codings[i].bits > 0 && !codings[i].octahedral;
    draco::PointAttribute* target =
        add_attribute(mesh, draco_role(source, codings[i]), source.component_count,
                      draco_type(source.component_type), source.normalized, values, on_grid ? 2 : 0);
    const size_t stride = source.stride();
    for (uint32_t v = 0; v < values.values.size(); ++v)
      target->SetAttributeValue(draco::AttributeValueIndex(v),
                                source.values.data() + values.values[v] * stride);
    if (!on_grid) continue;
    // Every patch must have the grid of the whole mesh, so the spare values are the extremes of that grid.
    const GridExtremes extremes =
        grid_extremes(codings[i]).value_or(GridExtremes{codings[i].origin, codings[i].origin});
    const auto spare = static_cast<uint32_t>(values.values.size());
    target->SetAttributeValue(draco::AttributeValueIndex(spare), extremes.low.data());
    target->SetAttributeValue(draco::AttributeValueIndex(spare + 1), extremes.high.data());
  }
}

Expected<std::vector<uint8_t>> run_encoder(draco::ExpertEncoder& encoder, const char* what) {
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok())
    return runtime_failure(std::string("libdraco cannot encode the ") + what + ": " + status.error_msg());
  return std::vector<uint8_t>(buffer.data(), buffer.data() + buffer.size());
}

// Each thread may encode a patch whose table of symbols is no larger than this.
constexpr uint64_t kFreeTableBytes = uint64_t{1} << 26;

Expected<std::vector<uint8_t>> encode(const WeldedMesh& welded, const PatchMesh& patch,
                                      std::span<const AttributeCoding> codings, int encode_speed, int method,
                                      bool compress_indices = false) {
  draco::Mesh mesh;
  fill_mesh(mesh, welded, patch, codings);
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(encode_speed, encode_speed);
  encoder.options().SetGlobalBool("compress_connectivity", compress_indices);  // for sequential streams
  int id = 0;
  for (size_t i : attribute_order(*welded.mesh)) {
    if (codings[i].bits > 0) encoder.SetAttributeQuantization(id, codings[i].bits);
    if (draco_role(welded.mesh->attributes[i], codings[i]) == draco::GeometryAttribute::TEX_COORD &&
        texture_prediction_may_overflow(welded, patch, codings, i, encode_speed))
      encoder.options().SetAttributeInt(id, "prediction_scheme", draco::MESH_PREDICTION_PARALLELOGRAM);
    ++id;
  }
  // Patches whose tables of symbols are large take their turn, so that threads do not multiply the memory.
  static std::mutex large_tables;
  std::unique_lock<std::mutex> turn(large_tables, std::defer_lock);
  if (symbol_table_bytes(welded, patch, codings, encode_speed) > kFreeTableBytes) turn.lock();
  return run_encoder(encoder, "mesh");
}

// The values that a patch uses of each attribute, in the order of unique ids.
std::vector<PatchValues> values_of_patch(const WeldedMesh& welded, const PatchMesh& patch) {
  std::vector<PatchValues> values;
  for (const size_t i : attribute_order(*welded.mesh))
    values.emplace_back(welded.value_of_point[i], patch.points);
  return values;
}

// The stream of a patch whose every attribute value is its own index.
Expected<std::vector<uint8_t>> encode_twin(const PatchMesh& patch, std::span<const PatchValues> values,
                                           int encode_speed) {
  draco::Mesh twin;
  set_faces(twin, patch);
  for (size_t k = 0; k < values.size(); ++k) {
    const auto role = k == 0 ? draco::GeometryAttribute::POSITION : draco::GeometryAttribute::GENERIC;
    draco::PointAttribute* target = add_attribute(twin, role, 1, draco::DT_UINT32, false, values[k]);
    for (uint32_t v = 0; v < values[k].values.size(); ++v)
      target->SetAttributeValue(draco::AttributeValueIndex(v), &v);
  }
  draco::ExpertEncoder encoder(twin);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(encode_speed, encode_speed);
  encoder.SetUseBuiltInAttributeCompression(false);
  for (int id = 0; id < twin.num_attributes(); ++id)
    if (const draco::Status status = encoder.SetAttributePredictionScheme(id, draco::PREDICTION_NONE);
        !status.ok())
      return runtime_failure(std::string("libdraco refuses an option: ") + status.error_msg());
  return run_encoder(encoder, "order of points");
}

// Finds the patch's point with the values of each decoded point of its twin: a point is the tuple of its
// values.
Expected<std::vector<uint32_t>> find_points(const draco::Mesh& twin, std::span<const PatchValues> values,
                                            size_t point_count) {
  const auto value = [&](size_t attribute, uint32_t point) { return values[attribute].index[point]; };
  std::vector<uint32_t> by_tuple(point_count);
  std::iota(by_tuple.begin(), by_tuple.end(), 0u);
  std::sort(by_tuple.begin(), by_tuple.end(), [&](uint32_t a, uint32_t b) {
    for (size_t k = 0; k < values.size(); ++k)
      if (value(k, a) != value(k, b)) return value(k, a) < value(k, b);
    return false;
  });
  std::vector<uint32_t> tuple(values.size()), points;
  points.reserve(twin.num_points());
  for (uint32_t i = 0; i < twin.num_points(); ++i) {
    for (size_t k = 0; k < values.size(); ++k) {
      const auto* attribute = twin.GetAttributeByUniqueId(static_cast<uint32_t>(k));
      attribute->GetMappedValue(draco::PointIndex(i), &tuple[k]);
    }
    const auto compare = [&](uint32_t point) {
      for (size_t k = 0; k < tuple.size(); ++k)
        if (value(k, point) != tuple[k]) return value(k, point) < tuple[k] ? -1 : 1;
      return 0;
    };
    const auto found = std::partition_point(by_tuple.begin(), by_tuple.end(),
                                            [&](uint32_t point) { return compare(point) < 0; });
    if (found == by_tuple.end() || compare(*found) != 0)
      return runtime_failure("libdraco decodes a point that the patch does not have");
    points.push_back(*found);
  }
  return points;
}

}  // namespace

std::vector<AttributeRequest> stream_requests(const Mesh& mesh) {
  std::vector<AttributeRequest> requests;
  for (const Attribute& attribute : mesh.attributes)
    requests.push_back(
        {attribute.semantic, 0, attribute.component_type, attribute.component_count, attribute.normalized});
  uint32_t next = 0;
  for (const size_t i : attribute_order(mesh)) requests[i].unique_id = next++;
  return requests;
}

Expected<std::vector<uint8_t>> encode_edgebreaker(const WeldedMesh& welded, const PatchMesh& patch,
                                                  std::span<const AttributeCoding> codings, int encode_speed) {
  return encode(welded, patch, codings, encode_speed, draco::MESH_EDGEBREAKER_ENCODING);
}

Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh& welded, const PatchMesh& patch,
                                                 std::span<const AttributeCoding> codings, int encode_speed) {
  constexpr int kMethod = draco::MESH_SEQUENTIAL_ENCODING;
  Expected<std::vector<uint8_t>> plain = encode(welded, patch, codings, encode_speed, kMethod);
  if (!plain) return plain;
  // libdraco's decoder refuses compressed indices unless at least three bytes for each face follow the header.
  constexpr size_t kMostHeaderBytes = 64;
  const size_t least = 3 * patch.faces.size() + kMostHeaderBytes;
  Expected<std::vector<uint8_t>> compressed = encode(welded, patch, codings, encode_speed, kMethod, true);
  const bool is_better = compressed && compressed->size() < plain->size() && compressed->size() >= least;
  return is_better ? std::move(compressed) : std::move(plain);
}

// Draco's order of decoded points follows from connectivity and seams alone, not from values. So this encodes
// and decodes a twin of the patch whose every attribute value is its own index. The values that come out name
// the points in the order of the real stream.
Expected<DecodedOrder> edgebreaker_order(const WeldedMesh& welded, const PatchMesh& patch, int encode_speed) {
  const std::vector<PatchValues> values = values_of_patch(welded, patch);
  Expected<std::vector<uint8_t>> stream = encode_twin(patch, values, encode_speed);
  if (!stream) return stream.status();
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream->data()), stream->size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    return runtime_failure(std::string("libdraco cannot decode the order of points: ") +
                           decoded.status().error_msg());
  const draco::Mesh& twin = *decoded.value();

  DecodedOrder order;
  order.faces.reserve(twin.num_faces());
  for (uint32_t i = 0; i < twin.num_faces(); ++i) {
    const draco::Mesh::Face& face = twin.face(draco::FaceIndex(i));
    order.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  Expected<std::vector<uint32_t>> points = find_points(twin, values, patch.points.size());
  if (!points) return points.status();
  order.patch_point = std::move(*points);
  return order;
}

}  // namespace psplit
