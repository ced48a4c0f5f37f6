#include "gltf_ext/convert/condense_patches.h"

#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "encoder/condensing/condense.h"
#include "encoder/verify.h"
#include "src/container/patch_container.h"
#include "src/cpu/checked_decode.h"
#include "src/cpu/cpu_backend.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

// A container and its row of the report.
struct Condensed {
  std::vector<uint8_t> bytes;  // empty: the container stays
  PrimitiveReport report;
};

Expected<Condensed> condense_bytes(const StoredPrimitive& stored, const EncodeDocumentOptions& options,
                                   const ThreadPool& pool) {
  const Expected<PatchContainer> before = open_container(stored.bytes);
  if (!before) return before.status();
  Condensed result;
  result.report.skipped = "already in condensed patches";
  if (before->condensed_count() > 0) return result;
  EncodeStatistics& statistics = result.report.statistics;
  const Stopwatch encode_time;
  std::optional<CondensedContainer> after =
      condense_container(*before, stored.bytes.size(), options.condense_smallest, pool);
  statistics.encode_ms = encode_time.ms();
  result.report.skipped = "already in patches, which condensing does not make smaller";
  if (!after) return result;
  if (options.verify) {
    const ScopedStopwatch verify_time(statistics.verify_ms);
    const Expected<Mesh> decoded = cpu_backend().decode(*before, stored.requests, pool);
    if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
    if (Status status = verify_condensed(after->bytes, stored.requests, *decoded, pool); !status.ok())
      return status;
  }
  statistics.patch_count = before->patch_count();
  result.report.skipped.clear();
  result.report.stored_as = StoredAs::kPatches;
  result.report.keeps_streams = true;
  result.report.faces = before->face_count();
  result.report.points = before->point_count();
  result.report.bytes = after->bytes.size();
  result.report.streams = std::move(after->entries);
  result.report.has_residue = before->has_residue;
  result.report.head_bytes = after->head_bytes;
  result.bytes = std::move(after->bytes);
  return result;
}

}  // namespace

Expected<CondensedPatches> condense_patches(const Document& document, const EncodeDocumentOptions& options,
                                            const ThreadPool& pool, EncodeReports& reports) {
  std::map<int64_t, Condensed> condensed_of;  // by buffer view
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (primitive.storage() != PrimitiveStorage::kPatches || reports[id].stored_as != StoredAs::kAsItWas)
      continue;
    const Place place = place_of(document, id);
    const Expected<StoredPrimitive> stored = stored_primitive(document, id);
    if (!stored) return stored.status().at(place);
    const auto [found, is_new] = condensed_of.try_emplace(primitive.patches->view);
    if (is_new) {
      Expected<Condensed> condensed = condense_bytes(*stored, options, pool);
      if (!condensed) return condensed.status().at(place);
      found->second = std::move(*condensed);
    }
    PrimitiveReport& report = reports[id];
    if (found->second.bytes.empty()) {
      report.skipped = found->second.report.skipped;
      continue;
    }
    const uint64_t input_bytes = report.input_bytes;
    report = found->second.report;
    report.id = id;
    report.input_bytes = input_bytes;
    report.repeated = !is_new;
  }
  CondensedPatches patches;
  for (auto& [view, condensed] : condensed_of)
    if (!condensed.bytes.empty()) patches[view] = std::move(condensed.bytes);
  return patches;
}

Status condense_stock(const Document& document, EncodeJob& job) {
  const PrimitiveId id = job.group.ids.front();
  if (document.records().primitive(id).storage() != PrimitiveStorage::kStockDraco) return {};
  Expected<StoredPrimitive> stored = stored_primitive(document, id);
  if (!stored) return stored.status();
  PatchContainer stream = open_stream(stored->bytes, job.mesh.point_count);
  if (!stream.refusal.ok() || !stream.headers[0].edgebreaker) return {};
  stream.expect_points(job.mesh.point_count);
  const ThreadPool one(1);  // jobs run at once
  auto container = condense_container(stream, stored->bytes.size(), job.options.condense_smallest, one);
  if (!container) return {};

  EncodedMesh encoded;
  encoded.container = std::move(container->bytes);
  encoded.requests = std::move(stored->requests);
  Expected<PatchContainer> opened = open_container(encoded.container);
  if (!opened) return runtime_failure("verification: " + opened.status().to_string());
  Expected<CheckedMesh> decoded = decode_checked(*opened, encoded.requests, one);
  if (!decoded) return runtime_failure("verification: " + decoded.status().to_string());
  if (!decoded->streams[0].types.ok()) return {};
  encoded.entries = opened->entries;
  encoded.head_bytes = opened->head_bytes;
  encoded.source_point.resize(decoded->mesh.point_count);
  std::iota(encoded.source_point.begin(), encoded.source_point.end(), 0u);
  encoded.decoded = std::move(decoded->mesh);
  encoded.statistics.patch_count = 1;
  job.encoded = std::move(encoded);
  job.keeps_stream = true;
  return {};
}

}  // namespace psplit
