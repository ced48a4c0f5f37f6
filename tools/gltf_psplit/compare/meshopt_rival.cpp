#include "tools/gltf_psplit/compare/meshopt_rival.h"

#include <meshoptimizer.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

namespace psplit {
namespace {

constexpr int kZstdLevel = 19;
constexpr int kOctahedralBits = 8;
// Version 1 of the attribute codec became stable in 0.23.
constexpr int kVertexCodec = MESHOPTIMIZER_VERSION >= 230 ? 1 : 0;

struct PlainStream {
  std::vector<uint8_t> bytes;
  size_t stride = 0;
  bool octahedral = false;
};

float float_at(const Attribute& attribute, size_t point, size_t component) {
  float value = 0;
  std::memcpy(&value, attribute.values.data() + (point * attribute.component_count + component) * sizeof value,
              sizeof value);
  return value;
}

// Quantizes to `bits` bits of 16-bit integers, with one grid for all components, as Draco does.
PlainStream quantize_to_grid(const Attribute& attribute, size_t point_count, int bits) {
  const size_t component_count = attribute.component_count;
  std::vector<float> low(component_count, 0), high(component_count, 0);
  for (size_t point = 0; point < point_count; ++point) {
    for (size_t component = 0; component < component_count; ++component) {
      const float value = float_at(attribute, point, component);
      low[component] = point == 0 ? value : std::min(low[component], value);
      high[component] = point == 0 ? value : std::max(high[component], value);
    }
  }
  double range = 0;
  for (size_t component = 0; component < component_count; ++component)
    range = std::max(range, static_cast<double>(high[component]) - low[component]);
  const double scale = range > 0 ? ((1 << bits) - 1) / range : 0;

  PlainStream stream;
  stream.stride = (component_count * sizeof(uint16_t) + 3) / 4 * 4;
  stream.bytes.resize(point_count * stream.stride);
  for (size_t point = 0; point < point_count; ++point) {
    for (size_t component = 0; component < component_count; ++component) {
      const double steps =
          (static_cast<double>(float_at(attribute, point, component)) - low[component]) * scale;
      const auto value = static_cast<uint16_t>(std::lround(steps));
      std::memcpy(stream.bytes.data() + point * stream.stride + component * sizeof value, &value, sizeof value);
    }
  }
  return stream;
}

PlainStream quantize_octahedral(const Attribute& attribute, size_t point_count) {
  std::vector<float> vectors(point_count * 4, 0);
  for (size_t point = 0; point < point_count; ++point)
    for (size_t component = 0; component < attribute.component_count; ++component)
      vectors[point * 4 + component] = float_at(attribute, point, component);
  PlainStream stream{std::vector<uint8_t>(point_count * 4), 4, true};
  meshopt_encodeFilterOct(stream.bytes.data(), point_count, stream.stride, kOctahedralBits, vectors.data());
  return stream;
}

PlainStream quantize_to_bytes(const Attribute& attribute, size_t point_count) {
  PlainStream stream{std::vector<uint8_t>(point_count * 4), 4, false};
  for (size_t point = 0; point < point_count; ++point)
    for (size_t component = 0; component < attribute.component_count; ++component)
      stream.bytes[point * 4 + component] = static_cast<uint8_t>(
          std::lround(255 * std::clamp(float_at(attribute, point, component), 0.0f, 1.0f)));
  return stream;
}

PlainStream pad_to_words(const Attribute& attribute, size_t point_count) {
  PlainStream stream;
  stream.stride = (attribute.stride() + 3) / 4 * 4;
  stream.bytes.resize(point_count * stream.stride);
  for (size_t point = 0; point < point_count; ++point)
    std::memcpy(stream.bytes.data() + point * stream.stride,
                attribute.values.data() + point * attribute.stride(), attribute.stride());
  return stream;
}

PlainStream quantize(const Attribute& attribute, size_t point_count, const MeshoptBits& bits) {
  const std::string& name = attribute.semantic;
  const size_t component_count = attribute.component_count;
  if (!bits.lossless && attribute.component_type == ComponentType::kFloat32) {
    if (name == "POSITION") return quantize_to_grid(attribute, point_count, std::min(bits.position, 16));
    if (name.starts_with("TEXCOORD_"))
      return quantize_to_grid(attribute, point_count, std::min(bits.texcoord, 16));
    const bool is_vector =
        (name == "NORMAL" && component_count == 3) || (name == "TANGENT" && component_count == 4);
    if (is_vector) return quantize_octahedral(attribute, point_count);
    if (name.starts_with("COLOR_") && component_count <= 4) return quantize_to_bytes(attribute, point_count);
  }
  return pad_to_words(attribute, point_count);
}

// Renumbers points according to a remap table with `kept` targets.
void remap_points(std::vector<uint32_t>& indices, std::vector<PlainStream>& streams, size_t point_count,
                  size_t kept, const std::vector<unsigned int>& remap) {
  meshopt_remapIndexBuffer(indices.data(), indices.data(), indices.size(), remap.data());
  for (PlainStream& stream : streams) {
    std::vector<uint8_t> moved(kept * stream.stride);
    meshopt_remapVertexBuffer(moved.data(), stream.bytes.data(), point_count, stream.stride, remap.data());
    stream.bytes = std::move(moved);
  }
}

}  // namespace

Expected<MeshoptMesh> encode_meshopt(const Mesh& mesh, const MeshoptBits& bits) {
  MeshoptMesh result;
  if (mesh.faces.empty()) return result;
  std::vector<uint32_t> indices;
  indices.reserve(mesh.faces.size() * 3);
  for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
  size_t point_count = mesh.point_count;
  std::vector<PlainStream> streams;
  for (const Attribute& attribute : mesh.attributes) streams.push_back(quantize(attribute, point_count, bits));

  std::vector<unsigned int> remap(point_count);
  std::vector<meshopt_Stream> views;
  for (const PlainStream& stream : streams)
    views.push_back({stream.bytes.data(), stream.stride, stream.stride});
  size_t kept = meshopt_generateVertexRemapMulti(remap.data(), indices.data(), indices.size(), point_count,
                                                 views.data(), views.size());
  remap_points(indices, streams, point_count, kept, remap);
  point_count = kept;

  meshopt_optimizeVertexCacheStrip(indices.data(), indices.data(), indices.size(), point_count);
  remap.resize(point_count);
  kept = meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), indices.size(), point_count);
  remap_points(indices, streams, point_count, kept, remap);
  point_count = kept;

  result.index_count = indices.size();
  result.point_count = point_count;
  meshopt_encodeIndexVersion(1);
  meshopt_encodeVertexVersion(kVertexCodec);
  std::vector<uint8_t> packed(meshopt_encodeIndexBufferBound(indices.size(), point_count));
  result.index_bytes = meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size());
  packed.resize(result.index_bytes);
  for (const PlainStream& stream : streams) {
    const size_t offset = packed.size();
    packed.resize(offset + meshopt_encodeVertexBufferBound(point_count, stream.stride));
    const size_t encoded = meshopt_encodeVertexBuffer(packed.data() + offset, packed.size() - offset,
                                                      stream.bytes.data(), point_count, stream.stride);
    packed.resize(offset + encoded);
    result.streams.push_back({stream.stride, stream.octahedral, encoded});
  }
  result.compressed.resize(ZSTD_compressBound(packed.size()));
  const size_t size = ZSTD_compress(result.compressed.data(), result.compressed.size(), packed.data(),
                                    packed.size(), kZstdLevel);
  if (ZSTD_isError(size)) return runtime_failure(std::string("zstd: ") + ZSTD_getErrorName(size));
  result.compressed.resize(size);
  result.packed = std::move(packed);
  return result;
}

Expected<MeshoptDecoded> decode_meshopt(const MeshoptMesh& mesh, MeshoptForm form) {
  MeshoptDecoded decoded;
  if (mesh.index_count == 0) return decoded;
  std::vector<uint8_t> unpacked;
  if (form == MeshoptForm::kZstd) {
    unpacked.resize(mesh.packed.size());
    const size_t size =
        ZSTD_decompress(unpacked.data(), unpacked.size(), mesh.compressed.data(), mesh.compressed.size());
    if (size != unpacked.size()) return runtime_failure("zstd did not return the original bytes");
  }
  const std::span<const uint8_t> packed = form == MeshoptForm::kZstd ? unpacked : mesh.packed;
  size_t encoded_bytes = mesh.index_bytes;
  for (const MeshoptStream& stream : mesh.streams) encoded_bytes += stream.encoded_bytes;
  if (packed.size() != encoded_bytes) return runtime_failure("meshoptimizer's streams are incomplete");
  decoded.indices.resize(mesh.index_count);
  if (meshopt_decodeIndexBuffer(decoded.indices.data(), mesh.index_count, sizeof(uint32_t), packed.data(),
                                mesh.index_bytes) != 0)
    return runtime_failure("meshoptimizer cannot decode its indices");
  size_t offset = mesh.index_bytes;
  for (const MeshoptStream& stream : mesh.streams) {
    std::vector<uint8_t>& bytes = decoded.streams.emplace_back(mesh.point_count * stream.stride);
    if (meshopt_decodeVertexBuffer(bytes.data(), mesh.point_count, stream.stride, packed.data() + offset,
                                   stream.encoded_bytes) != 0)
      return runtime_failure("meshoptimizer cannot decode its vertices");
    if (stream.octahedral) meshopt_decodeFilterOct(bytes.data(), mesh.point_count, stream.stride);
    offset += stream.encoded_bytes;
  }
  return decoded;
}

// 180 means 0.18, and 1000 means 1.0.
std::string meshopt_version() {
  constexpr int kVersion = MESHOPTIMIZER_VERSION;
  const std::string patch = kVersion % 10 == 0 ? "" : "." + std::to_string(kVersion % 10);
  return std::to_string(kVersion / 1000) + "." + std::to_string(kVersion / 10 % 100) + patch;
}
int meshopt_codec_version() { return kVertexCodec; }
std::string zstd_version() { return ZSTD_versionString(); }

}  // namespace psplit
