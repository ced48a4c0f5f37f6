#include "src/loader/older_streams.h"

#include <algorithm>
#include <cstring>

#include "src/container/write_faces.h"

namespace psplit {
namespace {

// The magic is followed by the version and the kind.
bool is_older_mesh(std::span<const uint8_t> stream) {
  constexpr size_t kMajor = 5, kMinor = 6, kKind = 7;
  constexpr uint8_t kMesh = 1;
  constexpr uint8_t kMagic[] = {'D', 'R', 'A', 'C', 'O'};
  return stream.size() > kKind && std::equal(std::begin(kMagic), std::end(kMagic), stream.begin()) &&
         std::pair(stream[kMajor], stream[kMinor]) < std::pair<uint8_t, uint8_t>(2, 2) &&
         stream[kKind] == kMesh;
}

}  // namespace

Expected<StreamDescription> describe_older(const OlderStreams* older, std::span<const uint8_t> stream,
                                           const Status& refusal) {
  if (refusal.code() != StatusCode::kUnsupported || !is_older_mesh(stream)) return refusal;
  if (older == nullptr)
    return unsupported(refusal.message() + "; a build with the encoder and libdraco decodes older ones");
  return older->describe(stream);
}

Status decode_older(const OlderStreams& older, std::span<const uint8_t> stream,
                    std::span<const AttributeRequest> requests, uint32_t point_count, uint32_t face_count,
                    const PrimitiveBuffers& out) {
  const Expected<Mesh> mesh = older.decode(stream, requests);
  if (!mesh) return mesh.status();
  if (mesh->point_count != point_count || mesh->faces.size() != face_count)
    return invalid_input("other bytes than those that were opened");
  write_faces(face_count, out.indices.data(), out.index_bytes,
              [&](uint32_t face, uint32_t k) { return mesh->faces[face][k]; });
  for (size_t k = 0; k < requests.size(); ++k) {
    const Attribute& attribute = mesh->attributes[k];
    for (size_t point = 0; point < point_count; ++point)
      std::memcpy(out.attributes[k].bytes.data() + point * out.attributes[k].stride,
                  attribute.values.data() + point * attribute.stride(), attribute.stride());
  }
  return {};
}

}  // namespace psplit
