#include "psplit/encode.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <utility>

#include "encoder/coding/choose_codings.h"
#include "encoder/coding/grid_places.h"
#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/coding/target_codings.h"
#include "encoder/encode_mesh.h"
#include "encoder/encode_streams.h"
#include "encoder/shared_codings.h"
#include "encoder/stream/cloud_stream.h"
#include "encoder/welding/reduce.h"
#include "src/catch_exceptions.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

Status check_bits(const char* what, int bits, int least) {
  if (bits == 0 || (bits >= least && bits <= kMostGridBits)) return {};
  return wrong_usage(std::string(what) + ": " + std::to_string(bits) + " bits; " + std::to_string(least) +
                     " to " + std::to_string(kMostGridBits) + " are possible, and 0 for exact values");
}

Status check_options(const EncodeOptions& options) {
  for (const auto& [what, bits] :
       {std::pair("positions", options.position_bits), std::pair("texture coordinates", options.texcoord_bits),
        std::pair("colours", options.color_bits), std::pair("generic attributes", options.generic_bits),
        std::pair("morph targets", options.morph_bits)})
    if (Status status = check_bits(what, bits, 1); !status.ok()) return status;
  if (Status status = check_bits("normals", options.normal_bits, 2); !status.ok()) return status;
  if (options.encode_speed < 0 || options.encode_speed > kMostEncodeSpeed)
    return wrong_usage("encode speed " + std::to_string(options.encode_speed) + "; 0 to " +
                       std::to_string(kMostEncodeSpeed) + " are possible");
  if (options.storage == Storage::kCloud && options.position_bits_by_edges)
    return wrong_usage("a point cloud has no edges that choose the bits of its positions");
  return {};
}

ReduceOptions reduce_options(const EncodeOptions& options) {
  if (options.storage == Storage::kInOrder || options.storage == Storage::kCloud)
    return {.keep_duplicates = true};
  const bool is_stock = options.storage == Storage::kOneStream;
  // A patch of its own cannot store unused points.
  const bool cannot_keep_unused = is_stock || options.storage == Storage::kStreams;
  return {options.keep_duplicates, !options.keep_degenerate || is_stock,
          !options.keep_unused || cannot_keep_unused};
}

// What keeps points apart whose attributes are equal: `stride` bytes for each.
struct DistinctBytes {
  std::vector<std::byte> bytes{};
  size_t stride = 0;

  explicit DistinctBytes(const MeshToEncode& mesh) {
    std::vector<PointData> sources = mesh.distinct;
    for (const Attribute& attribute : mesh.unrounded) sources.push_back({attribute.values, attribute.stride()});
    for (const PointData& source : sources) stride += source.width;
    const size_t points = mesh.mesh.point_count;
    bytes.resize(stride * points);
    size_t offset = 0;
    for (const auto& [values, width] : sources) {
      for (size_t i = 0; i < points && width > 0; ++i)
        std::memcpy(bytes.data() + i * stride + offset, values.data() + i * width, width);
      offset += width;
    }
  }
};

Status check_input(const MeshToEncode& mesh, bool is_cloud) {
  const std::vector<AttributeCoding> exactly(mesh.mesh.attributes.size());
  if (Status status = check_mesh(mesh.mesh, exactly); !status.ok()) return status;
  if (is_cloud && !mesh.mesh.faces.empty()) return invalid_input("a point cloud has no faces");
  if (is_cloud && mesh.mesh.point_count == 0) return invalid_input("the point cloud has no points");
  if (!is_cloud && mesh.mesh.faces.empty()) return invalid_input("the mesh has no triangles");
  for (const PointData& data : mesh.distinct)
    if (data.values.size() != data.width * mesh.mesh.point_count)
      return invalid_input("data beside the attributes have another number of points");
  return {};
}

// libdraco takes a grid from the extremes of the values, so none may be outside.
Status check_inside(const Attribute& attribute, const AttributeCoding& grid) {
  if (attribute.component_type != ComponentType::kFloat32 || grid.origin.size() != attribute.component_count)
    return wrong_usage(attribute.semantic + " has another number of components than its grid");
  for (size_t i = 0; i < attribute.values.size() / sizeof(float); ++i) {
    const float value = float_at(attribute, i);
    const float low = grid.origin[i % grid.origin.size()];
    if (!(value >= low && value - low <= grid.range))
      return invalid_input("point " + std::to_string(i / grid.origin.size()) + " is outside of the grid");
  }
  return {};
}

// Codings that the caller states for single attributes. Weights are rounded together, so they have common bits.
Status apply_own_codings(const EncodeOptions& options, MeshToEncode& mesh) {
  for (const auto& [i, own] : mesh.own_codings) {
    if (i >= mesh.codings.size()) return wrong_usage("there is no attribute " + std::to_string(i));
    Attribute& attribute = mesh.mesh.attributes[i];
    if (Status status = check_bits(attribute.semantic.c_str(), own.bits, 1); !status.ok()) return status;
    CodingOptions coding{
        own.bits, own.bits, own.bits, own.bits, own.bits, false, {true, true, true, true, true}};
    coding.exact = options.exact;
    if (own.grid)
      if (Status status = check_inside(attribute, *own.grid); !status.ok()) return status;
    mesh.codings[i] = own.grid ? *own.grid : choose_coding(attribute, coding);
  }
  int weight_bits = 0;
  for (size_t i = 0; i < mesh.codings.size(); ++i) {
    const int bits = mesh.codings[i].bits;
    if (bits == 0 || !mesh.mesh.attributes[i].semantic.starts_with("WEIGHTS_")) continue;
    if (weight_bits != 0 && bits != weight_bits) return wrong_usage("WEIGHTS_n have different bits");
    weight_bits = bits;
  }
  return {};
}

// Normals of a cloud get a grid of their components if everything else allows a tree.
void prefer_tree(const EncodeOptions& options, MeshToEncode& cloud) {
  std::vector<AttributeCoding> codings = cloud.codings;
  for (size_t i = 0; i < codings.size(); ++i) {
    if (!codings[i].octahedral) continue;
    Expected<AttributeCoding> grid = fit_grid(cloud.mesh.attributes[i], codings[i].bits);
    if (!grid) return;
    codings[i] = std::move(*grid);
  }
  if (becomes_tree(cloud.mesh, codings, options.encode_speed)) cloud.codings = std::move(codings);
}

// Says which whole numbers the given bits round.
void note_rounded_numbers(const EncodeOptions& options, const ThreadPool& pool, MeshToEncode& mesh) {
  if (!options.given.generic) return;
  const StoredFlags stored = stored_points(mesh, options, pool);
  std::vector<PrecisionNote> losses;
  for (size_t i = 0; i < mesh.codings.size(); ++i) {
    const Attribute& attribute = mesh.mesh.attributes[i];
    std::string loss =
        loss_of_whole_numbers(attribute, wanted_bounds(attribute, options, stored), mesh.codings[i]);
    if (!loss.empty()) losses.push_back({std::move(loss), /*is_warning=*/true});
  }
  mesh.notes.insert(mesh.notes.begin(), losses.begin(), losses.end());
}

// Keeps the weights as they were, and rounds the mesh's weights.
void round_mesh_weights(MeshToEncode& mesh) {
  for (size_t i = 0; i < mesh.codings.size(); ++i)
    if (mesh.mesh.attributes[i].semantic.starts_with("WEIGHTS_") && mesh.codings[i].bits > 0)
      mesh.unrounded.push_back(mesh.mesh.attributes[i]);
  round_weights(mesh.mesh, mesh.codings);
}

void free_arrays(Mesh& mesh) {
  mesh.faces = {};
  mesh.faces.shrink_to_fit();
  for (Attribute& attribute : mesh.attributes) attribute.values = Array<std::byte>();  // {} keeps the memory
}

#ifdef __cpp_exceptions
struct Stopped {};
#endif

// If `freed` is not null, it is the mesh, whose faces and values are freed as soon as they can be.
Expected<EncodedMesh> encode_planned(const MeshToEncode& source, const EncodeOptions& options,
                                     const ThreadPool& pool, const Watch& watch, Mesh* freed) {
  if (source.codings.size() != source.mesh.attributes.size()) return wrong_usage("the mesh is not planned");
  const size_t face_count = source.mesh.faces.size();
  std::atomic<size_t> done = 0;
  StreamOptions streams = stream_options(options, source.patch_count);
  streams.condense &= !source.is_condensed_later;
  if (source.needs_container && streams.alone == Alone::kWhole) streams.alone = Alone::kNone;
  // Edgebreaker has no faces that repeat a point.
  streams.in_order =
      options.storage == Storage::kInOrder ||
      (options.storage == Storage::kOneStream && std::ranges::all_of(source.mesh.faces, repeats_a_point));
  streams.is_cloud = options.storage == Storage::kCloud;
  if (watch.progress) streams.patch_encoded = [&](size_t faces) { watch.progress(done += faces, face_count); };
  streams.stop = watch.stop;
  if (freed != nullptr) streams.free_input = [freed] { free_arrays(*freed); };
  const auto encode_on = [&](const ThreadPool& threads) {
    const DistinctBytes distinct(source);
    return encode_mesh(source.mesh, source.codings, streams, threads, distinct.bytes, distinct.stride);
  };
  // The caller's callback and executor may throw.
  Expected<EncodedMesh> encoded = catch_exceptions([&]() -> Expected<EncodedMesh> {
#ifdef __cpp_exceptions
    // When the caller stops the work, all tasks that are left are left out. Stages divide their work into many
    // tasks, so none of them has to ask. Without exceptions only encode_streams asks, before each patch.
    const ThreadPool asking(pool.thread_count(), [&](size_t count, const std::function<void(size_t)>& body) {
      pool.for_each(count, [&](size_t i) {
        if (watch.stopped()) throw Stopped();
        body(i);
      });
    });
    try {
      return encode_on(watch.stop != nullptr ? asking : pool);
    } catch (const Stopped&) {
      return cancelled();
    }
#else
    return encode_on(pool);
#endif
  });
  if (freed != nullptr) free_arrays(*freed);
  if (!encoded) return encoded;
  encoded->codings = source.codings;
  encoded->notes = source.notes;
  // Faces that are dropped, or in no patch, count as done.
  if (watch.progress && done < face_count)
    if (Status status = catch_exceptions([&]() -> Status {
          watch.progress(face_count, face_count);
          return {};
        });
        !status.ok())
      return status;
  return encoded;
}

}  // namespace

StreamOptions stream_options(const EncodeOptions& options, uint32_t patch_count) {
  StreamOptions result;
  result.patch_count = patch_count;
  result.most_split_percent = options.asks_for_patches() ? 0 : kMostSplitPercent;
  result.shares_tables = options.condense != Condense::kNo;
  result.order = options.order;
  result.boxes = options.boxes;
  result.encode_speed = options.encode_speed;
  result.choose_by_bytes = options.choose_by_bytes;
  result.by_libdraco = options.by_libdraco;
  const ReduceOptions reduce = reduce_options(options);
  result.keep_duplicates = reduce.keep_duplicates;
  result.drop_degenerate = reduce.drop_degenerate;
  result.drop_unused = reduce.drop_unused;
  result.condense = options.condense != Condense::kNo;
  result.condense_smallest = options.condense == Condense::kSmallest;
  result.alone = options.storage == Storage::kStreams || options.storage == Storage::kOneStream ? Alone::kAll
                 : options.storage == Storage::kContainer || options.patches.always             ? Alone::kNone
                                                                                                : Alone::kWhole;
  result.verify = options.verify;
  result.refine = options.refine;
  result.method = options.method;
  result.distance = options.distance;
  if (options.storage != Storage::kOneStream) return result;
  result.patch_count = 1;
  result.boxes = result.condense = false;
  return result;
}

EncodeOptions EncodeOptions::with_first_bits() const {
  EncodeOptions coding = *this;
  coding.give_changed_bits();
  if (!chooses_position_bits()) return coding;
  coding.position_bits = kMostGridBits;
  coding.given.position = !position_bits_by_edges;
  return coding;
}

Expected<Mesh> mesh_of(const MeshView& view) {
  Mesh mesh;
  mesh.point_count = view.point_count;
  const auto has_room = [](const ValuesView& values) {
    const size_t size = values.value_bytes();
    return values.count == 0 ||
           (values.bytes.size() >= size && (values.bytes.size() - size) / values.step() >= values.count - 1);
  };
  const ValuesView& indices = view.indices;
  const bool are_indices = indices.component_type == ComponentType::kUint8 ||
                           indices.component_type == ComponentType::kUint16 ||
                           indices.component_type == ComponentType::kUint32;
  if (!indices.bytes.empty() && (!are_indices || indices.component_count != 1))
    return unsupported("indices are unsigned integers of 8, 16 or 32 bits");
  if (!indices.bytes.empty() && !has_room(indices)) return wrong_usage("indices: too few bytes");
  const size_t index_count = indices.bytes.empty() ? view.point_count : indices.count;
  if (index_count % 3 != 0) return wrong_usage("the indices are not whole faces");
  mesh.faces.resize(index_count / 3);
  for (size_t i = 0; i < mesh.faces.size(); ++i)
    mesh.faces[i] = {view.index(3 * i), view.index(3 * i + 1), view.index(3 * i + 2)};
  for (const auto& [semantic, values] : view.attributes) {
    if (semantic.empty()) return wrong_usage("an attribute has no name");
    if (mesh.find(semantic) != nullptr) return wrong_usage("two attributes have the name " + semantic);
    if (values.value_bytes() == 0 || values.component_count > 16)
      return unsupported(semantic + " has " + std::to_string(values.component_count) + " components");
    if (values.step() < values.value_bytes())
      return wrong_usage("the stride of " + semantic + " is less than its size");
    if (values.count != view.point_count || !has_room(values))
      return wrong_usage(semantic + " has no values for " + std::to_string(view.point_count) + " points");
    Attribute& attribute = mesh.attributes.emplace_back(
        Attribute{semantic, values.component_type, values.component_count, values.normalized, {}});
    const size_t size = values.value_bytes();
    attribute.values.resize(size * values.count);
    for (size_t point = 0; point < values.count; ++point)
      std::memcpy(attribute.values.data() + point * size, values.at(point), size);
  }
  return mesh;
}

namespace {

Status plan_all(Span<MeshToEncode* const> meshes, const EncodeOptions& options, const ThreadPool& pool,
                Span<const KeptMesh> kept, size_t& mesh_of_error) {
  mesh_of_error = 0;
  if (Status status = check_options(options); !status.ok()) return status;
  const EncodeOptions coding = options.with_first_bits();
  const bool is_cloud = options.storage == Storage::kCloud;
  std::vector<uint64_t> faces;
  for (mesh_of_error = 0; mesh_of_error < meshes.size(); ++mesh_of_error) {
    if (Status status = check_input(*meshes[mesh_of_error], is_cloud); !status.ok()) return status;
    faces.push_back(meshes[mesh_of_error]->mesh.faces.size());
  }
  SharedCodings chosen = choose_shared_codings(meshes, coding, pool, kept);
  if (options.chooses_position_bits()) {
    const auto max_error =
        options.position_bits_by_edges ? std::nullopt : std::optional(options.max_position_error);
    Status status = choose_position_bits(meshes, max_error, chosen.codings, mesh_of_error);
    if (!status.ok()) return status;
  }
  auto notes = guard_precision(meshes, coding, chosen, pool);
  const std::vector<uint32_t> counts = patch_counts(faces, options.patches);
  for (mesh_of_error = 0; mesh_of_error < meshes.size(); ++mesh_of_error) {
    MeshToEncode& mesh = *meshes[mesh_of_error];
    mesh.codings = std::move(chosen.codings[mesh_of_error]);
    mesh.notes = std::move(notes[mesh_of_error]);
    mesh.patch_count = counts[mesh_of_error];
    if (Status status = apply_own_codings(coding, mesh); !status.ok()) return status;
    if (is_cloud) prefer_tree(options, mesh);
    note_rounded_numbers(coding, pool, mesh);
    round_mesh_weights(mesh);
  }
  choose_target_codings(meshes, coding);
  return {};
}

}  // namespace

Status plan(Span<MeshToEncode* const> meshes, const EncodeOptions& options, const ThreadPool& pool,
            Span<const KeptMesh> kept, size_t* failed) {
  size_t at = 0;
  return catch_exceptions(
      [&] { return plan_all(meshes, options, pool, kept, failed == nullptr ? at : *failed); });
}

Expected<EncodedMesh> encode(const MeshToEncode& mesh, const EncodeOptions& options, const ThreadPool& pool,
                             const Watch& watch) {
  return encode_planned(mesh, options, pool, watch, nullptr);
}

Expected<EncodedMesh> encode(MeshToEncode&& mesh, const EncodeOptions& options, const ThreadPool& pool,
                             const Watch& watch) {
  return encode_planned(mesh, options, pool, watch, &mesh.mesh);
}

Expected<EncodedMesh> encode(Mesh mesh, const EncodeOptions& options, const ThreadPool& pool,
                             const Watch& watch) {
  MeshToEncode source{std::move(mesh)};
  MeshToEncode* const planned[] = {&source};
  if (Status status = plan(planned, options, pool); !status.ok()) return status;
  return encode(std::move(source), options, pool, watch);
}

StoredFlags stored_points(const MeshToEncode& mesh, const EncodeOptions& options, const ThreadPool& pool) {
  const DistinctBytes distinct(mesh);
  StoredFlags stored = stored_points(mesh.mesh, reduce_options(options), pool, distinct.bytes, distinct.stride);
  if (std::ranges::find(stored, 0) == stored.end()) stored = StoredFlags();
  return stored;
}

ReducedMesh reduce(const MeshToEncode& mesh, const EncodeOptions& options, const ThreadPool& pool) {
  const DistinctBytes distinct(mesh);
  ReduceOptions reduced = reduce_options(options);
  reduced.compared = places_on_grids(mesh.mesh, mesh.codings);
  return reduce(mesh.mesh, reduced, pool, distinct.bytes, distinct.stride);
}

}  // namespace psplit
