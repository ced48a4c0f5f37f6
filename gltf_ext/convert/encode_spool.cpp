#include "gltf_ext/convert/encode_spool.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/mesh_files/repair_values.h"
#include "gltf_ext/out_of_core/cell_parts.h"
#include "gltf_ext/out_of_core/file_blocks.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

// What the process takes beside the part that is encoded: libraries, threads, windows on files.
constexpr uint64_t kProcessBytes = uint64_t{48} << 20;
constexpr uint32_t kMostShortPoints = 65535;  // index 65535 would restart a strip

Expected<std::unique_ptr<Spill>> make_spill_in(const std::filesystem::path& folder) {
  Expected<AppendFile> file = AppendFile::create(folder);
  if (!file) return file.status();
  return std::unique_ptr<Spill>(std::make_unique<AppendFile>(std::move(*file)));
}

PartsOptions options_of_parts(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
                              uint64_t faces) {
  PartsOptions result;
  const PatchTarget& target = options.patches;
  const uint64_t most = target.most > 0                  ? target.most
                        : options.compat == Compat::kKhr ? kMostPatchPrimitives
                                                         : UINT64_MAX;
  if (target.faces > 0)
    result.patch_faces = target.faces;
  else if (target.count > 0)
    result.patch_faces = std::max<uint64_t>({1, faces / target.count, target.least_faces});
  else
    result.patch_faces = std::max(result.patch_faces, faces / most);
  result.streams = options_of_streams(options);
  result.most_points = limits.most_container_points;
  return result;
}

// The codings of the whole mesh, with the bits that encode_document chooses.
Expected<std::vector<AttributeCoding>> codings_of(const MeshSpool& spool, const CellParts& parts,
                                                  const EncodeDocumentOptions& options) {
  std::vector<AttributeCoding> codings = parts.codings();
  for (size_t i = 0; i < codings.size() && options.chooses_position_bits(); ++i) {
    if (spool.attributes()[i].semantic != "POSITION" || codings[i].bits == 0) continue;
    const Expected<int> bits = options.position_bits_by_edges
                                   ? position_bits_for_step(codings[i], step_for_edges(spool.edges().lengths()))
                                   : position_bits_for_error(codings[i], options.max_position_error);
    if (!bits) return bits.status();
    codings[i].bits = *bits;
  }
  return codings;
}

// Rounds the weights of the parts that it passes on, as read_jobs does.
class RoundedParts : public MeshParts {
 public:
  RoundedParts(MeshParts& parts, std::span<const AttributeCoding> codings) : parts_(parts), codings_(codings) {}

  uint32_t part_count() const override { return parts_.part_count(); }
  uint32_t shared_count() const override { return parts_.shared_count(); }
  Expected<MeshPart> read(uint32_t number) override {
    Expected<MeshPart> part = parts_.read(number);
    if (part) round_weights(part->mesh, codings_);
    return part;
  }

 private:
  MeshParts& parts_;
  const std::span<const AttributeCoding> codings_;
};

// The bytes that the streams take at least: positions without a grid, which Draco stores as they are. If there
// are other attributes, points may share their positions, and only encoding tells how many do.
uint64_t least_bytes(const MeshSpool& spool, std::span<const AttributeCoding> codings,
                     const CellStatistics& statistics) {
  if (codings.size() > 1 || codings[0].bits > 0) return 0;
  return spool.record_bytes() * (statistics.points - statistics.merged_points - statistics.dropped_points);
}

PrimitiveReport report_of(const EncodedParts& encoded, const CellStatistics& statistics, const MeshSpool& spool,
                          std::span<const AttributeCoding> codings, bool is_alone) {
  PrimitiveReport report;
  const auto position = std::ranges::find(spool.attributes(), "POSITION", &Attribute::semantic);
  report.position_coding = codings[static_cast<size_t>(position - spool.attributes().begin())];
  report.stored_as = !is_alone                        ? StoredAs::kPatches
                     : encoded.containers.size() == 1 ? StoredAs::kDraco
                                                      : StoredAs::kPatchPrimitives;
  for (const PartsContainer& container : encoded.containers) {
    report.bytes += container.bytes->size();
    report.head_bytes += container.head_bytes;
    report.streams.insert(report.streams.end(), container.entries.begin(), container.entries.end());
  }
  report.has_residue = encoded.statistics.patch_count < report.streams.size();
  report.faces = statistics.faces;
  report.points = statistics.points;
  report.input_bytes = statistics.points * spool.record_bytes() +
                       statistics.faces * 3 * (statistics.points > kMostShortPoints ? 4 : 2);
  report.statistics = encoded.statistics;
  report.statistics.merged_points = statistics.merged_points;
  report.statistics.dropped_faces = statistics.dropped_faces;
  report.statistics.dropped_points = statistics.dropped_points;
  return report;
}

// The bytes of a container as a buffer of their own. Returns the buffer view.
Expected<int64_t> add_container(Document& document, StoredBytes& bytes, const std::filesystem::path& folder) {
  Expected<UnnamedFile> file = UnnamedFile::create(folder);
  if (!file) return file.status();
  constexpr uint64_t kWindow = uint64_t{4} << 20;
  std::vector<uint8_t> window;
  for (uint64_t at = 0; at < bytes.size(); at += window.size()) {
    window.resize(static_cast<size_t>(std::min(kWindow, bytes.size() - at)));
    if (Status status = bytes.read(at, window); !status.ok()) return status;
    if (Status status = file->write(at, window); !status.ok()) return status;
  }
  Expected<MappedFile> mapped = MappedFile::open(*file);
  if (!mapped) return mapped.status();
  const size_t buffer = append_buffer(document, std::move(*mapped));
  Json& views = document.json()["bufferViews"];
  views.push_back({{"buffer", buffer}, {"byteOffset", 0}, {"byteLength", bytes.size()}});
  return static_cast<int64_t>(views.size()) - 1;
}

// The accessors describe a mesh whose values are stored elsewhere.
void describe(const PrimitiveGroup& group, const PartsContainer& container,
              std::span<const Attribute> attributes, PrimitiveEditor& editor) {
  MeshView mesh;
  mesh.point_count = container.point_count;
  mesh.indices = {index_type(mesh.point_count), 1, false, container.face_count * 3, {}, 0};
  std::vector<PrimitiveEditor::Bounds> bounds;
  for (size_t k = 0; k < attributes.size(); ++k) {
    const Attribute& a = attributes[k];
    mesh.attributes.push_back(
        {a.semantic, {a.component_type, a.component_count, a.normalized, mesh.point_count, {}, 0}});
    bounds.push_back({bound_json(container.bounds[k].least, a.component_type),
                      bound_json(container.bounds[k].most, a.component_type)});
  }
  bounds.push_back({Json::array({0}), Json::array({container.used_point_count - 1})});
  editor.describe_geometry(group, mesh, bounds);
}

// The mesh that the container or the lone stream decodes to.
Expected<MeshInFile> decode_fallback(std::span<const uint8_t> bytes, const PartsContainer& container,
                                     std::span<const AttributeRequest> requests, bool is_alone,
                                     const OutOfCoreOptions& limits, const ThreadPool& pool) {
  if (!is_alone) {
    const Expected<PatchContainer> opened = open_container(bytes);
    if (!opened) return opened.status();
    return decode_to_file(*opened, requests, {limits.memory, limits.temporary}, pool);
  }
  Expected<MeshInFile> mesh =
      lay_out_in_file(requests, container.point_count, container.face_count, limits.temporary);
  if (!mesh) return mesh;
  const PatchContainer stream = open_stream(bytes, container.point_count);
  const DecodeTask task{&stream, requests};
  const auto buffers = [&](size_t, uint32_t, uint32_t) {
    return Expected<PrimitiveBuffers>(mesh->laid_out.buffers);
  };
  Status status = draco_backend().decode_into({&task, 1}, buffers, pool, {}).front();
  if (!status.ok()) return status;
  return mesh;
}

}  // namespace

MemoryPlan::MemoryPlan(const OutOfCoreOptions& limits, size_t record_bytes, int most_threads,
                       uint64_t patch_faces) {
  constexpr uint64_t kMostBuffers = uint64_t{64} << 20, kZeroNormal = 64;
  all = std::max(limits.memory, kLeastMemory) - kProcessBytes;
  buffer_bytes = std::min(all / 8, kMostBuffers);
  most_zero_normals = all / 8 / kZeroNormal;
  // Peaks of encode_parts were 110 bytes for each face of a part of 0.3 to 5 million faces with positions, 130
  // with normals, and 540 bytes for each face of the patch of a thread. These are a quarter more.
  constexpr uint64_t kFace = 100, kPoint = 40, kValueByte = 5, kPatchFace = 680;
  const uint64_t thread_bytes = std::max<uint64_t>(1, patch_faces * kPatchFace);
  thread_count = static_cast<int>(
      std::clamp<uint64_t>(all / 2 / thread_bytes, 1, static_cast<uint64_t>(std::max(1, most_threads))));
  most_patch_faces = all / 2 / kPatchFace;
  constexpr uint64_t kLeftPoint = 64, kLeftValueByte = 4, kCondensedPoint = 160, kCondensedValueByte = 8;
  most_residue_points = all / 4 / (kLeftPoint + kLeftValueByte * record_bytes);
  condensed_points = all / 3 / (kCondensedPoint + kCondensedValueByte * record_bytes);
  // The other half is for the part. It must not depend on the threads, because parts change the output.
  cost = {kFace, kPoint + kValueByte * record_bytes, all - all / 2};
  if (limits.most_part_faces > 0) cost = {1, 0, limits.most_part_faces};
}

Expected<EncodedSpool> encode_spool(MeshSpool& spool, const EncodeDocumentOptions& options,
                                    const OutOfCoreOptions& limits, Losses& losses, const ThreadPool& pool,
                                    const Progress& progress) {
  PartsOptions parts_options = options_of_parts(options, limits, spool.face_count());
  const MemoryPlan plan(limits, spool.record_bytes(), pool.thread_count(), parts_options.patch_faces);
  parts_options.patch_faces = std::min(parts_options.patch_faces, plan.most_patch_faces);
  parts_options.most_residue_points = plan.most_residue_points;
  parts_options.condensed_points = plan.condensed_points;
  const uint64_t cells_bytes = spool.is_soup() ? 0 : spool.point_count() * sizeof(CellAssignment::Cell);
  if (plan.buffer_bytes + cells_bytes > plan.all)
    return Status(StatusCode::kUsage,
                  std::to_string(spool.point_count()) + " points need --memory " +
                      std::to_string((kProcessBytes + plan.buffer_bytes + cells_bytes) / 1000000 + 1) + "MB");
  Expected<std::unique_ptr<CellParts>> parts =
      CellParts::make(spool,
                      {limits.temporary, plan.cost, plan.buffer_bytes, parts_options.streams.keep_duplicates,
                       !parts_options.streams.drop_degenerate, !parts_options.streams.drop_unused},
                      pool);
  if (!parts) return parts.status();
  const Expected<std::vector<AttributeCoding>> codings = codings_of(spool, **parts, options);
  if (!codings) return codings.status();
  const CellStatistics& statistics = (*parts)->statistics();
  if (spool.is_soup() && spool.attributes().size() > 1)
    say_normals(statistics.changed_normals, spool.zero_normals_of_soup(), losses);
  std::atomic<size_t> done = 0;
  if (progress)
    parts_options.streams.patch_encoded = [&](size_t faces) {
      progress(done += faces, static_cast<size_t>(statistics.kept_faces));
    };
  if (limits.to_glb) {
    if (Status status = check_glb_bytes(least_bytes(spool, *codings, statistics), true); !status.ok())
      return status;
    parts_options.part_written = [](uint64_t bytes) { return check_glb_bytes(bytes, true); };
  }
  const MakeSpill make_spill = [&] { return make_spill_in(limits.temporary); };
  RoundedParts rounded(**parts, *codings);
  std::optional<ThreadPool> fewer;
  if (plan.thread_count < pool.thread_count()) fewer.emplace(plan.thread_count);
  Expected<EncodedParts> encoded =
      encode_parts(rounded, *codings, parts_options, make_spill, fewer ? *fewer : pool);
  if (!encoded) return encoded.status();
  EncodedSpool result{spool.attributes(), std::move(*encoded), {}};
  result.report =
      report_of(result.encoded, statistics, spool, *codings, parts_options.streams.alone == Alone::kAll);
  return result;
}

Status store_containers(Document& document, std::span<const PrimitiveGroup> groups, EncodedSpool& spool,
                        const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
                        const ThreadPool& pool, PrimitiveEditor& editor) {
  const char* const extension = options.compat == Compat::kKhr ? kStockExtensionName : kExtensionName;
  const bool with_fallback = options.fallback == Fallback::kUncompressed;
  for (size_t i = 0; i < groups.size(); ++i) {
    PartsContainer& container = spool.encoded.containers[i];
    const Expected<int64_t> view = add_container(document, *container.bytes, limits.temporary);
    if (!view) return view.status();
    container.bytes.reset();
    if (with_fallback) {
      const Expected<MeshInFile> mesh =
          decode_fallback(document.buffers.back(), container, spool.encoded.requests,
                          options.compat == Compat::kKhr, limits, pool);
      if (!mesh) return mesh.status();
      editor.set_geometry_in_file(groups[i], *mesh);
    } else {
      describe(groups[i], container, spool.attributes, editor);
    }
    set_draco_extension(document, groups[i], extension, *view, spool.encoded.requests);
  }
  list_extension(document, extension, !with_fallback);
  return {};
}

}  // namespace psplit
