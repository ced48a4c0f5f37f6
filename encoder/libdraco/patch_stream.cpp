#include "encoder/libdraco/patch_stream.h"

#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_encoder.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>

#include "encoder/coding/quantization.h"
#include "encoder/libdraco/draco_types.h"
#include "encoder/libdraco/unfused_values.h"
#include "encoder/stitching/stitch_map.h"
#include "encoder/stream/attribute_plan.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/stream/patch_steps.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

draco::GeometryAttribute::Type draco_role(const Attribute& attribute, const AttributeCoding& coding) {
  return static_cast<draco::GeometryAttribute::Type>(draco_semantic(attribute, coding));
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

// The values of each attribute in the order of unique ids.
std::vector<PatchValues> values_of_patch(const WeldedMesh& welded, const std::vector<uint32_t>& points) {
  std::vector<PatchValues> values;
  for (const size_t i : attribute_order(*welded.mesh)) values.emplace_back(welded.value_of_point[i], points);
  return values;
}

// Leaves room for `spare` values after the values of points. libdraco does not store them.
draco::PointAttribute* add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type role, uint8_t components,
                                     draco::DataType type, bool normalized, const PatchValues& values,
                                     size_t spare) {
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(role, static_cast<int8_t>(components), type, normalized, values.values.size() + spare);
  attribute->SetExplicitMapping(values.index.size());
  for (uint32_t i = 0; i < values.index.size(); ++i)
    attribute->SetPointMapEntry(draco::PointIndex(i), draco::AttributeValueIndex(values.index[i]));
  return mesh.attribute(mesh.AddAttribute(std::move(attribute)));
}

void fill_mesh(draco::Mesh& mesh, const WeldedMesh& welded, const PatchMesh& patch,
               std::span<const PatchValues> values_of_attributes, std::span<const AttributeCoding> codings) {
  set_faces(mesh, patch);
  const PatchValues* next_values = values_of_attributes.data();
  for (size_t i : attribute_order(*welded.mesh)) {
    const Attribute& source = welded.mesh->attributes[i];
    const PatchValues& values = *next_values++;
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

// Each thread may encode a patch whose table of symbols is no larger than this.
constexpr uint64_t kFreeTableBytes = uint64_t{1} << 26;

// A patch as libdraco's encoders take it, and the options of its streams.
struct DracoInput {
  draco::Mesh mesh;
  draco::ExpertEncoder encoder{mesh};
  uint64_t table_bytes = 0;

  DracoInput(const WeldedMesh& welded, const PatchMesh& patch, std::span<const PatchValues> values,
             std::span<const AttributeCoding> codings, int encode_speed) {
    fill_mesh(mesh, welded, patch, values, codings);
    encoder.SetSpeedOptions(encode_speed, encode_speed);
    int id = 0;
    for (size_t i : attribute_order(*welded.mesh)) {
      if (codings[i].bits > 0) encoder.SetAttributeQuantization(id, codings[i].bits);
      if (encode_speed < kSpeedWithoutPositions && codings[i].bits > 0 &&
          draco_role(welded.mesh->attributes[i], codings[i]) == draco::GeometryAttribute::TEX_COORD &&
          texture_prediction_may_overflow(welded, patch, codings, i))
        encoder.options().SetAttributeInt(id, "prediction_scheme", draco::MESH_PREDICTION_PARALLELOGRAM);
      ++id;
    }
    table_bytes = symbol_table_bytes(welded, patch, codings, encode_speed);
  }

  // `encode` fills the buffer.
  template <typename Encode>
  Expected<std::vector<uint8_t>> run(Encode encode) const {
    // Patches whose tables of symbols are large take their turn, so that threads do not multiply the memory.
    static std::mutex large_tables;
    std::unique_lock<std::mutex> turn(large_tables, std::defer_lock);
    if (table_bytes > kFreeTableBytes) turn.lock();
    draco::EncoderBuffer buffer;
    const draco::Status status = encode(&buffer);
    if (!status.ok())
      return runtime_failure(std::string("libdraco cannot encode the mesh: ") + status.error_msg());
    return std::vector<uint8_t>(buffer.data(), buffer.data() + buffer.size());
  }
};

// For each value of an attribute, in the order of the decoded values, the patch's point where libdraco's
// encoder met it.
std::vector<uint32_t> points_met(const draco::MeshEdgebreakerEncoder& encoder, size_t attribute,
                                 const PatchMesh& patch) {
  const draco::MeshAttributeIndicesEncodingData& data =
      *encoder.GetAttributeEncodingData(static_cast<int>(attribute));
  std::vector<uint32_t> points;
  points.reserve(data.encoded_attribute_value_index_to_corner_map.size());
  for (const draco::CornerIndex& corner : data.encoded_attribute_value_index_to_corner_map)
    points.push_back(patch.faces[corner.value() / 3][corner.value() % 3]);
  return points;
}

// Finds the patch's point of each decoded point. A point is the tuple of its values.
class PointFinder {
 public:
  // `met` has the points_met of each attribute.
  PointFinder(std::span<const std::vector<uint32_t>> met, const draco::Mesh& decoded, const PatchMesh& patch,
              std::span<const PatchValues> values)
      : patch_(patch), values_(values), points_met_(met) {
    for (size_t k = 0; k < values.size(); ++k)
      attributes_.push_back(decoded.GetAttributeByUniqueId(static_cast<uint32_t>(k)));
    met_.resize(values.size());
  }

  std::optional<uint32_t> find(uint32_t decoded_point) {
    for (size_t k = 0; k < values_.size(); ++k) {
      const uint32_t value = attributes_[k]->mapped_index(draco::PointIndex(decoded_point)).value();
      if (value >= points_met_[k].size()) return std::nullopt;
      met_[k] = points_met_[k][value];
    }
    for (const uint32_t point : met_)
      if (compare(point) == 0) return point;
    // Where seams of several attributes meet, the encoder may have met each value at another point.
    if (by_tuple_.empty()) sort_points();
    const auto found = std::partition_point(by_tuple_.begin(), by_tuple_.end(),
                                            [&](uint32_t point) { return compare(point) < 0; });
    if (found == by_tuple_.end() || compare(*found) != 0) return std::nullopt;
    return *found;
  }

 private:
  uint32_t value(size_t attribute, uint32_t point) const { return values_[attribute].index[point]; }

  // The tuple of the point with the values that were met.
  int compare(uint32_t point) const {
    for (size_t k = 0; k < values_.size(); ++k) {
      const uint32_t a = value(k, point), b = value(k, met_[k]);
      if (a != b) return a < b ? -1 : 1;
    }
    return 0;
  }

  void sort_points() {
    by_tuple_.resize(patch_.points.size());
    std::iota(by_tuple_.begin(), by_tuple_.end(), 0u);
    std::sort(by_tuple_.begin(), by_tuple_.end(), [&](uint32_t a, uint32_t b) {
      for (size_t k = 0; k < values_.size(); ++k)
        if (value(k, a) != value(k, b)) return value(k, a) < value(k, b);
      return false;
    });
  }

  const PatchMesh& patch_;
  const std::span<const PatchValues> values_;
  const std::span<const std::vector<uint32_t>> points_met_;
  std::vector<const draco::PointAttribute*> attributes_;
  std::vector<uint32_t> met_;  // for each attribute the patch's point where the encoder met the value
  std::vector<uint32_t> by_tuple_;
};

// The decoded values have the types of the mesh's attributes.
void copy_values(const draco::Mesh& from, const Mesh& source, Mesh& to) {
  for (const AttributeRequest& request : stream_requests(source)) {
    Attribute& attribute = to.attributes.emplace_back(
        Attribute{request.semantic, request.component_type, request.component_count, request.normalized, {}});
    const draco::PointAttribute& values = *from.GetAttributeByUniqueId(request.unique_id);
    const size_t stride = attribute.stride();
    attribute.values.resize(stride * to.point_count);
    for (uint32_t i = 0; i < to.point_count; ++i)
      std::memcpy(attribute.values.data() + i * stride,
                  values.GetAddress(values.mapped_index(draco::PointIndex(i))), stride);
  }
}

}  // namespace

Expected<EncodedPatch> encode_edgebreaker(const WeldedMesh& welded, const PatchMesh& patch,
                                          std::span<const AttributeCoding> codings, int encode_speed,
                                          bool with_values) {
  const std::vector<PatchValues> values = values_of_patch(welded, patch.points);
  EncodedPatch encoded;
  std::vector<std::vector<uint32_t>> met;
  {
    // The encoder's memory is given back before the decoder takes its own.
    DracoInput input(welded, patch, values, codings, encode_speed);
    draco::MeshEdgebreakerEncoder encoder;
    encoder.SetMesh(input.mesh);
    Expected<std::vector<uint8_t>> bytes = input.run(
        [&](draco::EncoderBuffer* buffer) { return encoder.Encode(input.encoder.options(), buffer); });
    if (!bytes) return bytes.status();
    encoded.bytes = std::move(*bytes);
    for (size_t k = 0; k < values.size(); ++k) met.push_back(points_met(encoder, k, patch));
  }
  const auto decoded = decode_unfused(encoded.bytes, /*keep_quantized=*/false);
  if (!decoded.ok())
    return runtime_failure(std::string("libdraco cannot decode what it encoded: ") +
                           decoded.status().error_msg());
  const draco::Mesh& mesh = *decoded.value();
  encoded.decoded.point_count = mesh.num_points();
  encoded.decoded.faces.reserve(mesh.num_faces());
  for (uint32_t i = 0; i < mesh.num_faces(); ++i) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(i));
    encoded.decoded.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  PointFinder finder(met, mesh, patch, values);
  encoded.patch_point.reserve(mesh.num_points());
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const std::optional<uint32_t> point = finder.find(i);
    if (!point) return runtime_failure("libdraco decodes a point that the patch does not have");
    encoded.patch_point.push_back(*point);
  }
  encoded.walk = border_walk(encoded.decoded.faces, encoded.decoded.point_count);
  if (with_values) copy_values(mesh, *welded.mesh, encoded.decoded);
  return encoded;
}

Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh& welded, const PatchMesh& patch,
                                                 std::span<const AttributeCoding> codings, int encode_speed) {
  const std::vector<PatchValues> values = values_of_patch(welded, patch.points_of_values());
  DracoInput input(welded, patch, values, codings, encode_speed);
  input.encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  const auto encode = [&](bool compress_indices) {
    input.encoder.options().SetGlobalBool("compress_connectivity", compress_indices);
    return input.run([&](draco::EncoderBuffer* buffer) { return input.encoder.EncodeToBuffer(buffer); });
  };
  Expected<std::vector<uint8_t>> plain = encode(false);
  if (!plain) return plain;
  // libdraco's decoder refuses compressed indices unless at least three bytes for each face follow the header.
  constexpr size_t kMostHeaderBytes = 64;
  const size_t least = 3 * patch.faces.size() + kMostHeaderBytes;
  Expected<std::vector<uint8_t>> compressed = encode(true);
  const bool is_better = compressed && compressed->size() < plain->size() && compressed->size() >= least;
  return is_better ? std::move(compressed) : std::move(plain);
}

uint64_t symbol_table_bytes(const WeldedMesh& welded, const PatchMesh& patch,
                            std::span<const AttributeCoding> codings, int encode_speed) {
  const bool compares = encode_speed < 2;
  const int few_bits = compares ? 21 : 24;  // 64 MB
  uint64_t most = 0;
  for (size_t i = 0; i < codings.size(); ++i) {
    const AttributeCoding& coding = codings[i];
    if (coding.bits <= few_bits) continue;
    // A correction is at most as large as the patch is wide. Corrections of normals are modulo the grid's
    // width.
    double low = 0, high = std::ldexp(1.0, coding.bits);
    if (!coding.octahedral) {
      const Attribute& attribute = welded.mesh->attributes[i];
      std::swap(low, high);
      for (const uint32_t point : patch.points_of_values())
        for (size_t c = 0; c < attribute.component_count; ++c) {
          const float value = float_at(attribute, size_t{point} * attribute.component_count + c);
          const double step{grid_place(value, coding.origin[c], coding.range, coding.bits)};
          low = std::min(low, step);
          high = std::max(high, step);
        }
    }
    most = std::max(most, 4 * static_cast<uint64_t>(high - low));
  }
  return compares ? 8 * most : most;
}

}  // namespace psplit
