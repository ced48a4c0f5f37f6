#include "tools/gltf_psplit/compare/meshopt_rival.h"

#include <meshoptimizer.h>
#include <zstd.h>
#ifdef PSPLIT_HAS_BROTLI
#include <brotli/decode.h>
#include <brotli/encode.h>
#endif

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
  MeshoptFilter filter = MeshoptFilter::kNone;
  std::vector<uint8_t> as_colors{};  // the values for the filter of colours, with this stride; or empty
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
  PlainStream stream{std::vector<uint8_t>(point_count * stride), stride, MeshoptFilter::kOctahedral};
  meshopt_encodeFilterOct(stream.bytes.data(), point_count, stride, std::min(bits, 16), vectors.data());
  return stream;
}

#if MESHOPTIMIZER_VERSION >= 1000
// In the range of the grid, so that both have the same steps. The filter keeps fewer bits of transparency.
std::vector<uint8_t> filter_colors(const Attribute& attribute, size_t point_count,
                                   const AttributeCoding& coding, size_t stride) {
  const bool fits = attribute.semantic.starts_with("COLOR_") && attribute.component_count >= 3 &&
                    coding.bits >= 2 && coding.bits <= 16 && stride == (coding.bits <= 8 ? 4 : 8);
  if (!fits || coding.range <= 0) return {};
  std::vector<float> colors(point_count * 4, 1);
  for (size_t point = 0; point < point_count; ++point) {
    const size_t first = point * attribute.component_count;
    for (size_t k = 0; k < 3; ++k)
      colors[point * 4 + k] = std::clamp(
          static_cast<float>((static_cast<double>(float_at(attribute, first + k)) - coding.origin[k]) /
                             coding.range),
          0.0f, 1.0f);
    if (attribute.component_count == 4 && float_at(attribute, first + 3) != 1) return {};
  }
  std::vector<uint8_t> filtered(point_count * stride);
  meshopt_encodeFilterColor(filtered.data(), point_count, stride, coding.bits, colors.data());
  return filtered;
}

void unfilter_colors(std::vector<uint8_t>& bytes, size_t point_count, size_t stride) {
  meshopt_decodeFilterColor(bytes.data(), point_count, stride);
}
#else
std::vector<uint8_t> filter_colors(const Attribute&, size_t, const AttributeCoding&, size_t) { return {}; }
void unfilter_colors(std::vector<uint8_t>&, size_t, size_t) {}
#endif

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
  if (coding.octahedral || is_tangent) return quantize_octahedral(attribute, point_count, coding.bits);
  PlainStream stream = quantize_to_grid(attribute, point_count, coding);
  stream.as_colors = filter_colors(attribute, point_count, coding, stream.stride);
  return stream;
}

// Renumbers points according to a remap table with `kept` targets.
void remap_points(std::vector<uint32_t>& indices, std::vector<PlainStream>& streams, size_t point_count,
                  size_t kept, const std::vector<unsigned int>& remap) {
  meshopt_remapIndexBuffer(indices.data(), indices.data(), indices.size(), remap.data());
  const auto move = [&](std::vector<uint8_t>& bytes, size_t stride) {
    if (bytes.empty()) return;
    std::vector<uint8_t> moved(kept * stride);
    meshopt_remapVertexBuffer(moved.data(), bytes.data(), point_count, stride, remap.data());
    bytes = std::move(moved);
  };
  for (PlainStream& stream : streams) {
    move(stream.bytes, stream.stride);
    move(stream.as_colors, stream.stride);
  }
}

Status add_zstd(MeshoptMesh& mesh) {
  mesh.with_zstd.resize(ZSTD_compressBound(mesh.packed.size()));
  const size_t size = ZSTD_compress(mesh.with_zstd.data(), mesh.with_zstd.size(), mesh.packed.data(),
                                    mesh.packed.size(), kZstdLevel);
  if (ZSTD_isError(size)) return runtime_failure(std::string("zstd: ") + ZSTD_getErrorName(size));
  mesh.with_zstd.resize(size);
  return {};
}

bool undo_zstd(std::span<const uint8_t> compressed, std::vector<uint8_t>& bytes) {
  return ZSTD_decompress(bytes.data(), bytes.size(), compressed.data(), compressed.size()) == bytes.size();
}

#ifdef PSPLIT_HAS_BROTLI
constexpr MeshoptForm kForms[] = {MeshoptForm::kPlain, MeshoptForm::kZstd, MeshoptForm::kBrotli};

Status add_brotli(MeshoptMesh& mesh) {
  size_t size = BrotliEncoderMaxCompressedSize(mesh.packed.size());
  mesh.with_brotli.resize(size);
  if (BrotliEncoderCompress(BROTLI_MAX_QUALITY, BROTLI_MAX_WINDOW_BITS, BROTLI_MODE_GENERIC, mesh.packed.size(),
                            mesh.packed.data(), &size, mesh.with_brotli.data()) != BROTLI_TRUE)
    return runtime_failure("brotli cannot compress meshoptimizer's streams");
  mesh.with_brotli.resize(size);
  return {};
}

bool undo_brotli(std::span<const uint8_t> compressed, std::vector<uint8_t>& bytes) {
  size_t size = bytes.size();
  return BrotliDecoderDecompress(compressed.size(), compressed.data(), &size, bytes.data()) ==
             BROTLI_DECODER_RESULT_SUCCESS &&
         size == bytes.size();
}
#else
constexpr MeshoptForm kForms[] = {MeshoptForm::kPlain, MeshoptForm::kZstd};

Status add_brotli(MeshoptMesh&) { return {}; }
bool undo_brotli(std::span<const uint8_t>, std::vector<uint8_t>&) { return false; }
#endif

}  // namespace

std::vector<uint8_t> encode_meshopt_points(std::span<const uint8_t> rows, size_t row_count, size_t stride) {
  std::vector<uint8_t> encoded(meshopt_encodeVertexBufferBound(row_count, stride));
#if MESHOPTIMIZER_VERSION >= 230
  constexpr int kHighestLevel = 3;
  const size_t size = meshopt_encodeVertexBufferLevel(encoded.data(), encoded.size(), rows.data(), row_count,
                                                      stride, kHighestLevel, kVertexCodec);
#else
  const size_t size =
      meshopt_encodeVertexBuffer(encoded.data(), encoded.size(), rows.data(), row_count, stride);
#endif
  encoded.resize(size);
  return encoded;
}

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
  std::vector<uint8_t> packed(meshopt_encodeIndexBufferBound(indices.size(), point_count));
  result.index_bytes = meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size());
  packed.resize(result.index_bytes);
  for (const PlainStream& stream : streams) {
    std::vector<uint8_t> encoded = encode_meshopt_points(stream.bytes, point_count, stream.stride);
    MeshoptFilter filter = stream.filter;
    if (!stream.as_colors.empty()) {
      std::vector<uint8_t> colors = encode_meshopt_points(stream.as_colors, point_count, stream.stride);
      if (colors.size() < encoded.size()) {
        encoded = std::move(colors);
        filter = MeshoptFilter::kColor;
      }
    }
    packed.insert(packed.end(), encoded.begin(), encoded.end());
    result.streams.push_back({stream.stride, filter, encoded.size()});
  }
  result.packed = std::move(packed);
  if (Status status = add_zstd(result); !status.ok()) return status;
  if (Status status = add_brotli(result); !status.ok()) return status;
  return result;
}

Expected<MeshoptDecoded> decode_meshopt(const MeshoptMesh& mesh, MeshoptForm form) {
  MeshoptDecoded decoded;
  if (mesh.index_count == 0) return decoded;
  std::vector<uint8_t> unpacked;
  if (form != MeshoptForm::kPlain) {
    unpacked.resize(mesh.packed.size());
    if (!(form == MeshoptForm::kZstd ? undo_zstd : undo_brotli)(mesh.bytes(form), unpacked))
      return runtime_failure(std::string(form == MeshoptForm::kZstd ? "zstd" : "brotli") +
                             " did not return the original bytes");
  }
  const std::span<const uint8_t> packed = form == MeshoptForm::kPlain ? mesh.packed : unpacked;
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
    if (stream.filter == MeshoptFilter::kOctahedral)
      meshopt_decodeFilterOct(bytes.data(), mesh.point_count, stream.stride);
    if (stream.filter == MeshoptFilter::kColor) unfilter_colors(bytes, mesh.point_count, stream.stride);
    offset += stream.encoded_bytes;
  }
  return decoded;
}

std::span<const MeshoptForm> meshopt_forms() { return kForms; }

// 180 means 0.18, and 1000 means 1.0.
std::string meshopt_version() {
  constexpr int kVersion = MESHOPTIMIZER_VERSION;
  const std::string patch = kVersion % 10 == 0 ? "" : "." + std::to_string(kVersion % 10);
  return std::to_string(kVersion / 1000) + "." + std::to_string(kVersion / 10 % 100) + patch;
}
int meshopt_codec_version() { return kVertexCodec; }
std::string zstd_version() { return ZSTD_versionString(); }
#ifdef PSPLIT_HAS_BROTLI
std::string brotli_version() {
  const uint32_t version = BrotliDecoderVersion();
  return std::to_string(version >> 24) + "." + std::to_string(version >> 12 & 0xfff) + "." +
         std::to_string(version & 0xfff);
}
#else
std::string brotli_version() { return ""; }
#endif

}  // namespace psplit
