#include "gltf_ext/convert/encode_large_mesh.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <utility>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/encode_parts.h"
#include "encoder/shared_codings.h"
#include "gltf_ext/convert/memory_model.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/convert/texture_reads.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/out_of_core/cell_parts.h"
#include "gltf_ext/out_of_core/file_blocks.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "gltf_ext/primitive/view_in_place.h"

namespace psplit {
namespace {

Expected<std::unique_ptr<Spill>> make_spill_in(const std::filesystem::path& folder) {
  Expected<AppendFile> file = AppendFile::create(folder);
  if (!file) return file.status();
  return std::unique_ptr<Spill>(std::make_unique<AppendFile>(std::move(*file)));
}

PartsOptions options_of_parts(const EncodeOptions& options, const OutOfCoreOptions& limits, uint64_t faces) {
  PartsOptions result;
  const PatchTarget& target = options.patches;
  const uint64_t most = target.most > 0 ? target.most : UINT64_MAX;
  if (target.faces > 0)
    result.patch_faces = target.faces;
  else if (target.count > 0)
    result.patch_faces = std::max<uint64_t>({1, faces / target.count, target.least_faces});
  else
    result.patch_faces = std::max(result.patch_faces, faces / most);
  result.streams = stream_options(options, 1);
  result.most_points = limits.most_container_points;
  return result;
}

// The codings of the whole mesh, with the bits that encode_document chooses.
Expected<std::vector<AttributeCoding>> codings_of(const LargeMesh& mesh, const CellParts& parts,
                                                  const EncodeDocumentOptions& options) {
  std::vector<AttributeCoding> codings = parts.codings();
  const double step = options.position_bits_by_edges ? step_for_edges(mesh.edges().lengths()) : 0;
  const auto max_error =
      options.position_bits_by_edges ? std::nullopt : std::optional(options.max_position_error);
  for (size_t i = 0; i < codings.size() && options.chooses_position_bits(); ++i) {
    if (mesh.attributes()[i].semantic != "POSITION" || codings[i].bits == 0) continue;
    const Expected<int> bits = choose_position_bits(codings[i], max_error, step);
    if (!bits) return bits.status();
    codings[i].bits = *bits;
  }
  return codings;
}

// Replaces codings that lose what the mesh tells apart, as guard_precision does for meshes in memory.
Expected<std::vector<PrecisionNote>> guard_parts(const LargeMesh& mesh, CellParts& parts,
                                                 const CodingOptions& options,
                                                 const std::map<std::string, double>& texture_scales,
                                                 const ThreadPool& pool,
                                                 std::vector<AttributeCoding>& codings) {
  GuardedMesh guarded{[&](const GuardedMesh::VisitPart& visit) {
    for (uint32_t number = 0; number < parts.part_count(); ++number) {
      const Expected<MeshPart> part = parts.read(number);
      if (!part) return part.status();
      visit(part->mesh, {});
    }
    return Status();
  }};
  std::vector<int> wanted;
  for (const Attribute& attribute : mesh.attributes()) {
    wanted.push_back(mesh.bits_of(attribute));
    const auto scale = texture_scales.find(attribute.semantic);
    guarded.texture_scales.push_back(scale == texture_scales.end() ? 1 : scale->second);
  }
  return guard_codings(guarded, mesh.attributes(), options, wanted, pool, codings);
}

// Rounds the weights of the parts that it passes on, as plan() does.
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
uint64_t least_bytes(const LargeMesh& mesh, std::span<const AttributeCoding> codings,
                     const CellStatistics& statistics) {
  if (codings.size() > 1 || codings[0].bits > 0) return 0;
  return mesh.record_bytes() * (statistics.points - statistics.merged_points - statistics.dropped_points);
}

EncodeJob job_of(EncodedMesh encoded, const CellStatistics& statistics, const LargeMesh& mesh,
                 std::vector<AttributeCoding> codings) {
  EncodeJob job;
  job.source.mesh.attributes = mesh.attributes();
  job.source.codings = std::move(codings);
  job.encoded = std::move(encoded);
  job.encoded.statistics.merged_points = statistics.merged_points;
  job.encoded.statistics.dropped_faces = statistics.dropped_faces;
  job.encoded.statistics.dropped_points = statistics.dropped_points;
  job.face_count = statistics.faces;
  job.points_in_parts = statistics.points;
  job.note_storage();
  return job;
}

// The coding of an asset's meshes.
CodingOptions coding_of(const Document& document, const EncodeDocumentOptions& options) {
  CodingOptions coding = options.with_first_bits();
  coding.exact.merge(metadata_attributes(document.json()));
  return coding;
}

Expected<EncodeJob> encode_large_mesh(const LargeMesh& mesh, const EncodeDocumentOptions& options,
                                      const CodingOptions& coding, const OutOfCoreOptions& limits,
                                      const ThreadPool& pool,
                                      const std::map<std::string, double>& texture_scales,
                                      const Progress& progress) {
  PartsOptions parts_options = options_of_parts(options.of_meshes(), limits, mesh.face_count());
  const MemoryPlan plan(limits, mesh.record_bytes(), pool.thread_count(), parts_options.patch_faces);
  parts_options.patch_faces = std::min(parts_options.patch_faces, plan.most_patch_faces);
  parts_options.most_residue_points = plan.most_residue_points;
  parts_options.condensed_points = plan.condensed_points;
  const uint64_t cells_bytes = mesh.is_soup() ? 0 : mesh.point_count() * sizeof(CellAssignment::Cell);
  if (plan.buffer_bytes + cells_bytes > plan.all)
    return Status(StatusCode::kUsage,
                  std::to_string(mesh.point_count()) + " points need --memory " +
                      std::to_string((kProcessOfParts + plan.buffer_bytes + cells_bytes) / 1000000 + 1) + "MB");
  Expected<std::unique_ptr<CellParts>> parts =
      CellParts::make(mesh,
                      {limits.temporary, plan.cost, plan.buffer_bytes, parts_options.streams.keep_duplicates,
                       !parts_options.streams.drop_degenerate, !parts_options.streams.drop_unused},
                      pool);
  if (!parts) return parts.status();
  Expected<std::vector<AttributeCoding>> codings = codings_of(mesh, **parts, options);
  if (!codings) return codings.status();
  Expected<std::vector<PrecisionNote>> notes =
      guard_parts(mesh, **parts, coding, texture_scales, pool, *codings);
  if (!notes) return notes.status();
  const CellStatistics& statistics = (*parts)->statistics();
  std::atomic<size_t> done = 0;
  if (progress)
    parts_options.streams.patch_encoded = [&](size_t faces) {
      progress(done += faces, static_cast<size_t>(statistics.kept_faces));
    };
  if (limits.to_glb) {
    if (Status status = check_glb_bytes(least_bytes(mesh, *codings, statistics), true); !status.ok())
      return status;
    parts_options.part_written = [](uint64_t bytes) { return check_glb_bytes(bytes, true); };
  }
  const MakeSpill make_spill = [&] { return make_spill_in(limits.temporary); };
  RoundedParts rounded(**parts, *codings);
  std::optional<ThreadPool> fewer;
  if (plan.thread_count < pool.thread_count()) fewer.emplace(plan.thread_count);
  Expected<EncodedMesh> encoded =
      encode_parts(rounded, *codings, parts_options, make_spill, fewer ? *fewer : pool);
  if (!encoded) return encoded.status();
  EncodeJob job = job_of(std::move(*encoded), statistics, mesh, std::move(*codings));
  job.source.notes = std::move(*notes);
  job.warnings = (*parts)->losses();
  return job;
}

// The options of one primitive. PatchTarget::count is of all primitives together, which have `all_faces`.
EncodeDocumentOptions with_share_of_patches(EncodeDocumentOptions options, uint64_t faces, uint64_t all_faces) {
  const uint64_t counts[] = {faces, all_faces - faces};
  if (options.patches.count > 0)
    options.patches.count = distribute_patches(counts, options.patches.count).front();
  return options;
}

// Nothing if the primitive stays as it is, because all of its triangles are degenerate.
Expected<std::optional<EncodeJob>> encode_in_parts(const Document& document, const PrimitiveGroup& group,
                                                   const EncodeDocumentOptions& options,
                                                   const OutOfCoreOptions& limits, const ThreadPool& pool,
                                                   const Progress& progress,
                                                   const std::function<void()>& forget) {
  const PrimitiveId id = group.ids.front();
  const PrimitiveRecord& primitive = document.records().primitive(id);
  const ExpectedSizes size = stated_size(document, id);
  if (!primitive.targets.empty()) return unsupported("morph targets do not fit into --memory");
  if (extension_field(document.json()["meshes"][id.mesh], "EXT_mesh_manifold") != nullptr)
    return unsupported("EXT_mesh_manifold does not fit into --memory");
  Status status = document.spooled ? check_space_of_parts(size, limits.temporary)
                                   : check_temporary_space(size, limits.temporary, limits.note);
  if (!status.ok()) return status;
  Expected<MeshView> view = view_in_place(document, id);
  if (!view) return view.status();
  const CodingOptions coding = coding_of(document, options);
  std::span<const uint8_t> numbers;
  if (document.spooled) numbers = document.spooled->numbers;
  const Expected<LargeMesh> mesh = LargeMesh::open(
      std::move(*view), numbers, {coding, options.position_bits_by_edges, options.keep_duplicates, forget},
      "accessor " + std::to_string(primitive.accessor_of("POSITION")));
  if (!mesh) return mesh.status();
  if (!mesh->has_proper_face() && !options.keep_degenerate) return std::optional<EncodeJob>();
  Expected<EncodeJob> job =
      encode_large_mesh(*mesh, options, coding, limits, pool, texture_scales(document, group.ids), progress);
  if (!job) return job.status();
  return std::optional(std::move(*job));
}

}  // namespace

SpoolOptions spool_options(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits) {
  return {limits.temporary, MemoryPlan(limits, 0).most_zero_normals, options.keep_duplicates};
}

Expected<std::vector<EncodeJob>> encode_large_primitives(const Document& document,
                                                         const EncodeDocumentOptions& options,
                                                         SelectedPrimitives& selected,
                                                         const OutOfCoreOptions& limits, const ThreadPool& pool,
                                                         const Progress& progress,
                                                         const std::function<void()>& forget) {
  std::vector<EncodeJob> jobs;
  for (const PrimitiveGroup& group : selected.large) {
    const PrimitiveId id = group.ids.front();
    const EncodeDocumentOptions own =
        with_share_of_patches(options, stated_size(document, id).faces, selected.face_count);
    Expected<std::optional<EncodeJob>> job =
        encode_in_parts(document, group, own, limits, pool, progress, forget);
    if (!job) return job.status().at(place_of(document, id));
    if (!*job) {
      selected.skip(group, kOnlyDegenerate);
      continue;
    }
    (*job)->group = group;
    jobs.push_back(std::move(**job));
  }
  return jobs;
}

}  // namespace psplit
