#include "encoder/stream/encode_stream.h"

#include <utility>

#include "encoder/stream/patch_steps.h"
#include "encoder/stream/stream_steps.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

struct Written {
  EncodedConnectivity connectivity;
  std::vector<uint8_t> bytes;
};

Expected<Written> encode_at_speed(const WeldedMesh& welded, const PatchMesh& patch,
                                  std::span<const AttributeCoding> codings, std::span<const DracoLabel> labels,
                                  int encode_speed) {
  const ConnectivityChoices choices = choose_connectivity(encode_speed, patch.faces.size());
  Expected<EncodedConnectivity> connectivity = connect_patch(welded, patch, choices);
  if (!connectivity) return connectivity.status();
  const core::View<core::Group<uint32_t>> groups = connectivity->patch.groups;
  const StreamTraits traits{
      .speed = encode_speed, .point_count = static_cast<uint32_t>(patch.points.size()), .labels = labels};
  Expected<EncodedAttributes> attributes = encode_attributes(
      {welded, codings, patch.points}, traits,
      [&](size_t texcoords) { return texture_prediction_may_overflow(welded, patch, codings, texcoords); },
      {groups.data(), groups.size()}, connectivity->point_of_corner);
  if (!attributes) return attributes.status();

  Expected<std::vector<uint8_t>> bytes =
      write_stream(*connectivity, std::move(*attributes), choices.valence, symbol_level_of(encode_speed));
  if (!bytes) return bytes.status();
  return Written{std::move(*connectivity), std::move(*bytes)};
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

Expected<Mesh> decode_stream(const Mesh& mesh, std::span<const uint8_t> bytes) {
  Expected<Mesh> decoded = cpu_backend().decode(open_stream(bytes), stream_requests(mesh), ThreadPool(1));
  if (!decoded) return runtime_failure("an encoded stream is refused: " + decoded.status().to_string());
  return decoded;
}

Expected<EncodedPatch> encode_stream(const WeldedMesh& welded, const PatchMesh& patch,
                                     std::span<const AttributeCoding> codings, int encode_speed,
                                     bool with_values) {
  Expected<Written> written = encode_at_speed(welded, patch, codings, {}, encode_speed);
  if (!written) return written.status();
  return describe_stream(welded, written->connectivity, std::move(written->bytes), with_values);
}

Expected<LabelledStream> encode_labelled(const WeldedMesh& welded, const PatchMesh& patch,
                                         std::span<const AttributeCoding> codings,
                                         std::span<const DracoLabel> labels, int encode_speed) {
  Expected<Written> written = encode_at_speed(welded, patch, codings, labels, encode_speed);
  if (!written) return written.status();
  const core::Patch<uint32_t>& decoded = written->connectivity.patch;
  return LabelledStream{std::move(written->bytes), decoded.point_count, decoded.face_count};
}

}  // namespace psplit
