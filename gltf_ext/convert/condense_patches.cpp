#include "gltf_ext/convert/condense_patches.h"

#include <map>
#include <memory>

#include "encoder/condensing/condense_container.h"
#include "gltf_ext/convert/replace_streams.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/json/json_fields.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

// A container and its row of the report.
struct Condensed {
  std::vector<uint8_t> bytes;  // empty: the container stays
  PrimitiveReport report;
};

bool decode_alike(const PatchContainer& a, const PatchContainer& b, std::span<const AttributeRequest> requests,
                  const ThreadPool& pool) {
  const Expected<Mesh> of_a = cpu_backend().decode(a, requests, pool);
  const Expected<Mesh> of_b = cpu_backend().decode(b, requests, pool);
  if (!of_a || !of_b || of_a->faces != of_b->faces) return false;
  return std::ranges::equal(of_a->attributes, of_b->attributes, {}, &Attribute::values, &Attribute::values);
}

Expected<Condensed> condense_bytes(const StoredPrimitive& stored, const EncodeDocumentOptions& options,
                                   const ThreadPool& pool) {
  const Expected<PatchContainer> before = open_container(stored.bytes);
  if (!before) return before.status();
  Condensed result;
  result.report.skipped = "already in condensed patches";
  if (before->version == kCondensedContainerVersion) return result;
  result.report.skipped = "already in patches of container version 1";
  if (before->version != kContainerVersion) return result;
  const Stopwatch encode_time;
  auto bytes = condense_container(*before, options.condense_smallest, pool);
  result.report.skipped = "already in patches, which condensing does not make smaller";
  if (!bytes || bytes->size() >= stored.bytes.size()) return result;
  result.report.statistics.encode_ms = encode_time.ms();

  const Expected<PatchContainer> after = open_container(*bytes);
  if (!after) return runtime_failure("verification: " + after.status().to_string());
  const Stopwatch verify_time;
  if (options.verify && !decode_alike(*before, *after, stored.requests, pool))
    return runtime_failure("verification: condensed patches decode to another mesh");
  result.report.statistics.verify_ms = options.verify ? verify_time.ms() : 0;
  result.report.statistics.patch_count = after->patch_count();
  result.report.skipped.clear();
  result.report.stored_as = StoredAs::kPatches;
  result.report.keeps_streams = true;
  result.report.faces = after->face_count();
  result.report.points = after->point_count();
  result.report.bytes = bytes->size();
  result.report.streams = after->entries;
  result.report.has_residue = after->has_residue;
  result.report.head_bytes = after->head_bytes;
  result.bytes = std::move(*bytes);
  return result;
}

}  // namespace

Status condense_patches(Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool,
                        EncodeReports& reports) {
  std::map<int64_t, Condensed> condensed_of;  // by buffer view
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind || kind->storage != PrimitiveStorage::kPatches || reports[id].stored_as != StoredAs::kAsItWas)
      continue;
    const Place place{document.source.string(), static_cast<int64_t>(id.mesh),
                      static_cast<int64_t>(id.primitive)};
    const Expected<StoredPrimitive> stored = stored_primitive(document, id, kExtensionName);
    if (!stored) return stored.status().at(place);
    const Json& extension = *extension_field(primitive_json(document, id), kExtensionName);
    const auto [found, is_new] = condensed_of.try_emplace(*integer_field(extension, "bufferView"));
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
  StreamReplacements replacements;
  for (const auto& [view, condensed] : condensed_of)
    if (!condensed.bytes.empty()) replacements[view] = condensed.bytes;
  replace_streams(document, replacements);
  drop_unused(document, {});
  return {};
}

}  // namespace psplit
