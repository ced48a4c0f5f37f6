#include "gltf_ext/document/meshopt_codec.h"

#include <algorithm>

#include "gltf_ext/document/meshopt_library.h"
#include "gltf_ext/document/meshopt_vertices.h"

namespace psplit {
namespace {

bool is_version_1(const MeshoptRecord& view, std::span<const uint8_t> bytes) {
  return view.mode == "ATTRIBUTES" && !bytes.empty() && bytes[0] == kVerticesOfVersion1;
}

}  // namespace

bool is_legal_meshopt(const MeshoptRecord& view) {
  const size_t stride = view.stride;
  if (view.mode != "ATTRIBUTES") {
    const bool whole = view.mode == "INDICES" || (view.mode == "TRIANGLES" && view.count % 3 == 0);
    return whole && (stride == 2 || stride == 4) && view.filter == "NONE";
  }
  if (!is_row_of_vertices(stride)) return false;
  if (view.filter == "OCTAHEDRAL" || view.filter == "COLOR") return stride == 4 || stride == 8;
  if (view.filter == "QUATERNION") return stride == 8;
  return view.filter == "NONE" || view.filter == "EXPONENTIAL";
}

bool is_readable_meshopt(const MeshoptRecord& view, std::span<const uint8_t> bytes) {
  return bytes.empty() || is_version_1(view, bytes) || library_reads(view, bytes[0]);
}

uint64_t most_decoded_bytes(const MeshoptRecord& view, std::span<const uint8_t> bytes) {
  // Version 0 stores sixteen zeros in two bits. The other codecs take at least a byte for a triangle or an
  // index.
  constexpr uint64_t kMostOfLibrary = 64;
  return (is_version_1(view, bytes) ? kMostBytesOfVersion1 : kMostOfLibrary) * bytes.size();
}

bool decode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* rows) {
  if (is_version_1(view, bytes)) return decode_vertices(bytes, view.stride, {rows, view.decoded_bytes()});
  return library_decode(view, bytes, rows);
}

std::vector<uint8_t> encode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> rows) {
  const bool is_new = view.mode == "ATTRIBUTES" && view.is_khr;
  std::vector<uint8_t> bytes = is_new ? encode_vertices(rows, view.stride) : library_encode(view, rows);
  // Lists of triangles come back with other corners first, where the codec likes these more.
  std::vector<uint8_t> decoded(rows.size());
  const bool is_exact = !bytes.empty() && is_readable_meshopt(view, bytes) &&
                        decode_meshopt_rows(view, bytes, decoded.data()) && std::ranges::equal(decoded, rows);
  return is_exact ? bytes : std::vector<uint8_t>();
}

}  // namespace psplit
