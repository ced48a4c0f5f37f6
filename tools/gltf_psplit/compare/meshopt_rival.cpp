#include "tools/gltf_psplit/compare/meshopt_rival.h"

#include <meshoptimizer.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "src/mesh/number_of.h"

namespace psplit {
namespace {

constexpr int kZstdLevel = 19;
// Version 1 of the attribute codec became stable in 0.23.
constexpr int kVertexCodec = MESHOPTIMIZER_VERSION >= 230 ? 1 : 0;

struct PlainStream {
  std::vector<uint8_t> bytes;
  size_t stride = 0;
  bool octahedral = false;
};

// The places of all values on the grid of `coding`.
PlainStream quantize_to_grid(const Attribute& attribute, size_t point_count, const AttributeCoding& coding) {
  const size_t component_count = attribute.component_count;
  const double most = std::ldexp(1.0, coding.bits) - 1, scale = coding.range > 0 ? most / coding.range : 0;
  const size_t value_bytes = coding.bits <= 8 ? 1 : coding.bits <= 16 ? 2 : 4;
  PlainStream stream;
  stream.stride = (component_count * value_bytes + 3) / 4 * 4;
  stream.bytes.resize(point_count * stream.stride);
  for (size_t point = 0; point < point_count; ++point) {
    for (size_t component = 0; component < component_count; ++component) {
      const double value = static_cast<double>(float_at(attribute, point * component_count + component)) -
                           coding.origin[component];
      const auto step = static_cast<uint32_t>(std::lround(std::clamp(value * scale, 0.0, most)));
      for (size_t k = 0; k < value_bytes; ++k)
        stream.bytes[point * stream.stride + component * value_bytes + k] =
            static_cast<uint8_t>(step >> (8 * k));
    }
  }
  return stream;
}

PlainStream quantize_octahedral(const Attribute& attribute, size_t point_count, int bits) {
  std::vector<float> vectors(point_count * 4, 0);
  for (size_t point = 0; point < point_count; ++point)
    for (size_t component = 0; component < attribute.component_count; ++component)
      vectors[point * 4 + component] = float_at(attribute, point * attribute.component_count + component);
  const size_t stride = bits <= 8 ? 4 : 8;
  PlainStream stream{std::vector<uint8_t>(point_count * stride), stride, true};
  meshopt_encodeFilterOct(stream.bytes.data(), point_count, stride, std::min(bits, 16), vectors.data());
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

PlainStream quantize(const Attribute& attribute, size_t point_count, const AttributeCoding& coding) {
  if (coding.bits == 0) return pad_to_words(attribute, point_count);
  const bool is_tangent = attribute.semantic == "TANGENT" && attribute.component_count == 4;
  return coding.octahedral || is_tangent ? quantize_octahedral(attribute, point_count, coding.bits)
                                         : quantize_to_grid(attribute, point_count, coding);
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

Expected<MeshoptMesh> encode_meshopt(const Mesh& mesh, std::span<const AttributeCoding> codings) {
  MeshoptMesh result;
  if (mesh.faces.empty()) return result;
  std::vector<uint32_t> indices;
  indices.reserve(mesh.faces.size() * 3);
  for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
  size_t point_count = mesh.point_count;
  std::vector<PlainStream> streams;
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    streams.push_back(quantize(mesh.attributes[i], point_count, codings[i]));

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
