#include "gltf_ext/out_of_core/encode_spool.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <optional>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "gltf_ext/convert/draco_extension.h"
#include "gltf_ext/files/mapped_file.h"
#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/mesh_files/repair_values.h"
#include "gltf_ext/out_of_core/cell_parts.h"
#include "gltf_ext/out_of_core/spill_file.h"

namespace psplit {
namespace {

// What the process takes beside the part that is encoded: libraries, threads, windows on files.
constexpr uint64_t kProcessBytes = uint64_t{48} << 20;
constexpr uint32_t kMostShortPoints = 65535;  // index 65535 would restart a strip

PartsOptions options_of_parts(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
                              uint64_t faces) {
  PartsOptions result;
  if (options.patch_faces > 0) {
    result.patch_faces = options.patch_faces;
  } else if (options.patches > 0) {
    result.patch_faces = std::max<uint64_t>({1, faces / options.patches, options.least_patch_faces});
  } else if (options.most_patches > 0) {
    result.patch_faces = std::max(result.patch_faces, faces / options.most_patches);
  }
  result.encode_speed = options.encode_speed;
  result.verify = options.verify;
  result.refine = options.refine;
  result.method = options.method;
  result.distance = options.distance;
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

std::vector<PrimitiveReport> reports_of(const EncodedParts& encoded, const CellStatistics& statistics,
                                        const MeshSpool& spool, std::span<const AttributeCoding> codings) {
  std::vector<PrimitiveReport> list;
  const auto position = std::ranges::find(spool.attributes(), "POSITION", &Attribute::semantic);
  for (const PartsContainer& container : encoded.containers) {
    PrimitiveReport& report = list.emplace_back();
    report.id = {0, list.size() - 1};
    report.stored_as = StoredAs::kPatches;
    report.bytes = container.bytes->size();
    report.streams = container.entries;
    report.position_coding = codings[static_cast<size_t>(position - spool.attributes().begin())];
  }
  PrimitiveReport& first = list.front();
  first.faces = statistics.faces;
  first.points = statistics.points;
  first.input_bytes = statistics.points * spool.record_bytes() +
                      statistics.faces * 3 * (statistics.points > kMostShortPoints ? 4 : 2);
  first.statistics = encoded.statistics;
  first.statistics.merged_points = statistics.merged_points;
  first.statistics.dropped_faces = statistics.dropped_faces;
  first.statistics.dropped_points = statistics.dropped_points;
  return list;
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
  Json& json = document.json;
  for (const char* list : {"buffers", "bufferViews"})
    if (!json[list].is_array()) json[list] = Json::array();
  const Json view{{"buffer", json["buffers"].size()}, {"byteOffset", 0}, {"byteLength", bytes.size()}};
  json["buffers"].push_back({{"byteLength", bytes.size()}});
  json["bufferViews"].push_back(view);
  document.buffers.emplace_back(std::move(*mapped));
  return static_cast<int64_t>(json["bufferViews"].size()) - 1;
}

void set_counts(Document& document, const PrimitiveGroup& group, const PartsContainer& container) {
  const Json json = primitive_json(document, group.ids.front());
  const auto accessor = [&](const Json& index) -> Json& {
    return document.json["accessors"][static_cast<size_t>(integer_value(index).value_or(0))];
  };
  for (const auto& [semantic, index] : json["attributes"].items())
    accessor(index)["count"] = container.point_count;
  Json& indices = accessor(json["indices"]);
  indices["count"] = uint64_t{container.face_count} * 3;
  const bool is_narrow = container.point_count <= kMostShortPoints;
  indices["componentType"] = static_cast<int>(is_narrow ? ComponentType::kUint16 : ComponentType::kUint32);
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
  // The other half is for the part. It must not depend on the threads, because parts change the output.
  cost = {kFace, kPoint + kValueByte * record_bytes, all - all / 2};
  if (limits.most_part_faces > 0) cost = {1, 0, limits.most_part_faces};
}

Expected<EncodedSpool> encode_spool(MeshSpool& spool, const EncodeDocumentOptions& options,
                                    const OutOfCoreOptions& limits, Losses& losses, const ThreadPool& pool,
                                    const Progress& progress) {
  PartsOptions parts_options = options_of_parts(options, limits, spool.face_count());
  const MemoryPlan plan(limits, spool.record_bytes(), pool.thread_count(), parts_options.patch_faces);
  const uint64_t cells_bytes = spool.is_soup() ? 0 : spool.point_count() * sizeof(CellAssignment::Cell);
  if (plan.buffer_bytes + cells_bytes > plan.all)
    return Status(StatusCode::kUsage,
                  std::to_string(spool.point_count()) + " points need --memory " +
                      std::to_string((kProcessBytes + plan.buffer_bytes + cells_bytes) / 1000000 + 1) + "MB");
  Expected<std::unique_ptr<CellParts>> parts =
      CellParts::make(spool, {limits.temporary, plan.cost, plan.buffer_bytes}, pool);
  if (!parts) return parts.status();
  const Expected<std::vector<AttributeCoding>> codings = codings_of(spool, **parts, options);
  if (!codings) return codings.status();
  const CellStatistics& statistics = (*parts)->statistics();
  if (spool.is_soup() && spool.attributes().size() > 1)
    say_normals(statistics.changed_normals, spool.zero_normals_of_soup(), losses);
  std::atomic<size_t> done = 0;
  if (progress)
    parts_options.patch_encoded = [&](size_t faces) {
      progress(done += faces, static_cast<size_t>(statistics.kept_faces));
    };
  if (limits.to_glb) {
    if (Status status = check_glb_bytes(least_bytes(spool, *codings, statistics), true); !status.ok())
      return status;
    parts_options.part_written = [](uint64_t bytes) { return check_glb_bytes(bytes, true); };
  }
  const MakeSpill make_spill = [&] { return SpillFile::create(limits.temporary); };
  RoundedParts rounded(**parts, *codings);
  std::optional<ThreadPool> fewer;
  if (plan.thread_count < pool.thread_count()) fewer.emplace(plan.thread_count);
  Expected<EncodedParts> encoded =
      encode_parts(rounded, *codings, parts_options, make_spill, fewer ? *fewer : pool);
  if (!encoded) return encoded.status();
  EncodedSpool result{spool.attributes(), std::move(*encoded), {}};
  result.reports = reports_of(result.encoded, statistics, spool, *codings);
  return result;
}

Status store_containers(Document& document, std::span<const PrimitiveGroup> groups, EncodedSpool& spool,
                        const std::filesystem::path& folder, std::span<const int64_t> freed) {
  std::vector<int64_t> views;
  for (PartsContainer& container : spool.encoded.containers) {
    const Expected<int64_t> view = add_container(document, *container.bytes, folder);
    if (!view) return view.status();
    views.push_back(*view);
    container.bytes.reset();
  }
  PrimitiveEditor editor(document);
  for (size_t i = 0; i < groups.size(); ++i) {
    const Mesh bounds = mesh_of_bounds(spool.encoded.containers[i], spool.attributes);
    editor.set_geometry(groups[i], bounds, {}, GeometryData::kStoredElsewhere);
    set_draco_extension(document, groups[i], kExtensionName, views[i], spool.encoded.requests);
  }
  list_extension(document, kExtensionName, true);
  for (const int64_t accessor : freed) editor.release(accessor);
  editor.finish();
  for (size_t i = 0; i < groups.size(); ++i) set_counts(document, groups[i], spool.encoded.containers[i]);
  return {};
}

Mesh mesh_of_bounds(const PartsContainer& container, const std::vector<Attribute>& attributes) {
  Mesh mesh;
  mesh.point_count = 2;
  mesh.faces.push_back({0, 1, 1});
  for (size_t i = 0; i < attributes.size(); ++i) {
    Attribute& attribute = mesh.attributes.emplace_back(attributes[i]);
    attribute.values.resize(2 * attribute.stride());
    const size_t width = component_bytes(attribute.component_type);
    const bool is_float = attribute.component_type == ComponentType::kFloat32;
    for (size_t c = 0; c < attribute.component_count; ++c)
      for (size_t k = 0; k < 2; ++k) {
        const double value = (k == 0 ? container.bounds[i].least : container.bounds[i].most)[c];
        std::byte* const to = attribute.values.data() + (k * attribute.component_count + c) * width;
        const auto whole = static_cast<int64_t>(value);  // little-endian, as glTF
        const auto number = static_cast<float>(value);
        std::memcpy(to, is_float ? static_cast<const void*>(&number) : &whole, width);
      }
  }
  return mesh;
}

}  // namespace psplit
