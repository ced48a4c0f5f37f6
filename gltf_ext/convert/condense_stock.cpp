#include "gltf_ext/convert/condense_stock.h"

#include <numeric>

#include "encoder/condensing/condense_container.h"
#include "src/container/claims.h"
#include "src/cpu/checked_decode.h"

namespace psplit {
namespace {

// The container, if it is smaller than the stream.
std::optional<std::vector<uint8_t>> condensed_container(std::span<const uint8_t> stream, uint32_t face_count,
                                                        uint32_t point_count, bool smallest,
                                                        const ThreadPool& pool) {
  const std::vector<std::vector<uint8_t>> streams = {{stream.begin(), stream.end()}}, no_stitch_map = {{}};
  const StreamEntry entry{.face_count = face_count, .point_count = point_count};
  auto container = condense_container({entry}, false, no_stitch_map, streams, smallest, pool);
  if (container && container->size() >= stream.size()) container.reset();
  return container;
}

}  // namespace

Status condense_stock(const Document& document, EncodeJob& job) {
  const PrimitiveId id = job.group.ids.front();
  const Expected<PrimitiveKind> kind = primitive_kind(document, id);
  if (!kind || kind->storage != PrimitiveStorage::kStockDraco) return {};
  Expected<StoredPrimitive> stored = stored_primitive(document, id, kStockExtensionName);
  if (!stored) return stored.status();
  const Expected<core::StreamHeader> header = read_stream_header(stored->bytes);
  if (!header || !header->edgebreaker) return {};
  const ThreadPool one(1);  // jobs run at once
  auto container = condensed_container(stored->bytes, header->counts.face_count, job.mesh.point_count,
                                       job.options.condense_smallest, one);
  if (!container) return {};

  EncodedMesh encoded;
  encoded.container = std::move(*container);
  encoded.requests = std::move(stored->requests);
  Expected<PatchContainer> opened = open_container(encoded.container);
  if (!opened) return runtime_failure("verification: " + opened.status().to_string());
  Expected<CheckedMesh> decoded = decode_checked(*opened, encoded.requests, one);
  if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
  if (!decoded->streams[0].types.ok()) return {};
  encoded.opened = std::make_shared<const PatchContainer>(std::move(*opened));
  encoded.source_point.resize(decoded->mesh.point_count);
  std::iota(encoded.source_point.begin(), encoded.source_point.end(), 0u);
  encoded.decoded = std::move(decoded->mesh);
  encoded.statistics.patch_count = 1;
  job.encoded = std::move(encoded);
  job.keeps_stream = true;
  return {};
}

}  // namespace psplit
