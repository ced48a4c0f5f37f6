#include "gltf_ext/convert/join_points.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "encoder/condensing/condense.h"
#include "encoder/encode_mesh.h"
#include "encoder/stitching/build_stitching.h"
#include "encoder/verify.h"
#include "gltf_ext/document/asset_records.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

Stitching stitch_to_itself(const EncodedPiece& stream, const ThreadPool& pool) {
  const OwnedStream owned{stream.source_point, border_walk(stream.decoded.faces, stream.decoded.point_count)};
  std::vector<PointOwner> owners(*std::ranges::max_element(stream.source_point) + size_t{1});
  return build_stitching({&owned, 1}, 0, owners, pool);
}

std::vector<uint8_t> container_of(const EncodedPiece& stream, const Stitching& stitching) {
  StreamEntry stitched = stream.entries[0];
  stitched.reference_count = stitching.reference_counts[0];
  stitched.stitch_bytes = static_cast<uint32_t>(stitching.maps[0].size());
  return write_container({&stitched, 1}, false, stitching.maps, {&stream.bytes, 1});
}

// Whether both have the same triangles in the same order, whatever the numbers of their points.
bool has_same_triangles(const Mesh& a, const Mesh& b) {
  if (a.faces.size() != b.faces.size() || a.attributes.size() != b.attributes.size()) return false;
  for (size_t k = 0; k < a.attributes.size(); ++k) {
    const size_t stride = a.attributes[k].stride();
    const std::byte *values = a.attributes[k].values.data(), *others = b.attributes[k].values.data();
    for (size_t f = 0; f < a.faces.size(); ++f)
      for (size_t c = 0; c < 3; ++c)
        if (std::memcmp(values + a.faces[f][c] * stride, others + b.faces[f][c] * stride, stride) != 0)
          return false;
  }
  return true;
}

// The bytes that the file has for a point beside the stream.
uint64_t bytes_of_point(const EncodeJob& job, bool with_fallback) {
  uint64_t bytes = 0;
  if (with_fallback)
    for (const Attribute& attribute : job.source.mesh.attributes) bytes += attribute.stride();
  for (const MorphAttribute& morph : job.morphs)
    if (!morph.sparse) bytes += component_bytes(morph.data.component_type) * morph.data.component_count;
  return bytes;
}

// An upper bound of the bytes that a container costs the file beside its own: the names in both lists of
// extensions, and padding. The rest of its JSON is no longer than that of stock Draco.
uint64_t most_other_bytes(const EncodeJob& job) {
  constexpr uint64_t kListed = 2 * (std::string_view(kExtensionName).size() + 8), kAlignment = 4;
  return kListed + kAlignment * (1 + job.source.mesh.attributes.size() + job.morphs.size());
}

}  // namespace

Status join_repeated_points(EncodeJob& job, const EncodeDocumentOptions& options, const ThreadPool& pool) {
  EncodedMesh& encoded = job.encoded;
  EncodedPiece& lone = encoded.pieces[0];
  const Stopwatch encode_time;
  const Expected<PatchContainer> stream = open_piece(lone);
  if (!stream) return runtime_failure("verification: " + stream.status().to_string());
  Stitching stitching = stitch_to_itself(lone, pool);
  const uint64_t joined_count = stitching.reference_counts[0];
  if (joined_count == 0) return {};
  const std::vector<uint8_t> plain = container_of(lone, stitching);
  const Expected<PatchContainer> opened = open_container(plain);
  if (!opened) return runtime_failure("verification: " + opened.status().to_string());
  const uint64_t data_saved = joined_count * bytes_of_point(job, options.fallback != Fallback::kNone);
  const auto condense = [&](const PatchContainer& container) {
    return condense_container(container, lone.bytes.size() + data_saved,
                              options.condense == Condense::kSmallest, pool);
  };
  std::optional<CondensedContainer> joined = condense(*opened);
  if (!joined || joined->bytes.size() + most_other_bytes(job) > lone.bytes.size() + data_saved) return {};
  const std::optional<CondensedContainer> apart = condense(*stream);
  const uint64_t bytes_apart = std::min((apart ? apart->bytes : lone.bytes).size(), lone.bytes.size());
  if (joined->bytes.size() > bytes_apart + data_saved) return {};
  encoded.statistics.encode_ms += encode_time.ms();

  const ScopedStopwatch verify_time(encoded.statistics.verify_ms);
  Expected<Mesh> mesh = cpu_backend().decode(*opened, encoded.requests, pool);
  if (!mesh) return runtime_failure("verification: " + mesh.status().to_string());
  if (options.verify) {
    if (!has_same_triangles(*mesh, lone.decoded))
      return runtime_failure("verification: joined points make other triangles");
    if (Status status = verify_condensed(joined->bytes, encoded.requests, *mesh, pool); !status.ok())
      return status;
  }
  lone.is_container = true;
  lone.bytes = std::move(joined->bytes);
  lone.entries = std::move(joined->entries);
  lone.head_bytes = joined->head_bytes;
  lone.point_count = lone.used_point_count = mesh->point_count;
  lone.decoded = std::move(*mesh);
  lone.source_point = std::move(stitching.source_point);
  job.note_storage();
  return {};
}

}  // namespace psplit
