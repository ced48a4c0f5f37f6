// The morph targets of assets in condensed patches, beside meshoptimizer: psplit decodes the meshes with their
// targets and without them, and meshoptimizer's attribute codec decodes the same deltas, in turn, on one
// thread. scripts/targets runs it.
//
//   targets_benchmark ROUNDS FILE...
//
// prints a line of JSON for each asset. psplit's time is that with targets minus that without them, in
// milliseconds: the least of all rounds, and the median. All decoders write to memory that is there before,
// psplit floats of 12 bytes, meshoptimizer multiples of a step in 16 bits, of 8 bytes with padding as gltfpack
// stores them. Targets that are zero everywhere are left out: neither file stores any.
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>

#include "bench/asset_primitives.h"
#include "encoder/encode_mesh.h"
#include "gltf_ext/json/json.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "src/mesh/number_of.h"
#include "tools/gltf_psplit/compare/measure.h"

namespace psplit {
namespace {

// The meshes of an asset, in containers, and memory for what they decode to.
class DecodedByPsplit {
 public:
  Status add(const EncodedMesh& encoded) {
    const EncodedPiece& piece = encoded.pieces.front();
    bytes_.push_back(piece.bytes);
    requests_.push_back(encoded.requests);
    Expected<PatchContainer> container = open_container(bytes_.back());
    if (!container) return container.status();
    containers_.push_back(std::move(*container));
    tasks_.push_back({&containers_.back(), requests_.back()});
    Expected<PrimitiveBuffers> buffers = allocate_mesh(piece.point_count, piece.face_count, requests_.back(),
                                                       bytes_.back().size(), meshes_.emplace_back());
    if (!buffers) return buffers.status();
    buffers_.push_back(std::move(*buffers));
    return {};
  }
  Status decode(const ThreadPool& pool) const {
    const auto buffers_for = [&](size_t task, uint32_t, uint32_t) -> Expected<PrimitiveBuffers> {
      return buffers_[task];
    };
    for (Status& status : cpu_backend().decode_into(tasks_, buffers_for, pool, {}))
      if (!status.ok()) return std::move(status);
    return {};
  }
  size_t stored_bytes() const {
    size_t sum = 0;
    for (const std::vector<uint8_t>& bytes : bytes_) sum += bytes.size();
    return sum;
  }

 private:
  // What tasks_ points to stays where it is.
  std::deque<std::vector<uint8_t>> bytes_;
  std::deque<std::vector<AttributeRequest>> requests_;
  std::deque<PatchContainer> containers_;
  std::deque<Mesh> meshes_;
  std::vector<DecodeTask> tasks_;
  std::vector<PrimitiveBuffers> buffers_;
};

// The deltas of a target, encoded by meshoptimizer, and memory for them.
struct MeshoptTarget {
  static constexpr size_t kStride = 8;
  using Row = std::array<int16_t, kStride / sizeof(int16_t)>;

  std::vector<uint8_t> bytes;
  mutable std::vector<Row> rows;
};

Status decode(std::span<const MeshoptTarget> targets) {
  for (const MeshoptTarget& target : targets)
    if (meshopt_decodeVertexBuffer(target.rows.data(), target.rows.size(), MeshoptTarget::kStride,
                                   target.bytes.data(), target.bytes.size()) != 0)
      return runtime_failure("meshoptimizer cannot decode a target");
  return {};
}

// The meshes with and without their targets, the same targets by meshoptimizer, and their counts.
struct Targets {
  DecodedByPsplit with, without;
  std::vector<MeshoptTarget> meshopt;
  uint64_t meshes = 0, deltas = 0, nonzero_deltas = 0;
};

// The order of points in which gltfpack writes them.
std::vector<unsigned int> fetch_order(const Mesh& mesh) {
  std::vector<unsigned int> indices, remap(mesh.point_count);
  for (const auto& face : mesh.faces) indices.insert(indices.end(), face.begin(), face.end());
  meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), mesh.point_count);
  meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), indices.size(), mesh.point_count);
  return remap;
}

Status add_meshopt(const Mesh& mesh, size_t attribute, const AttributeCoding& coding,
                   std::span<const unsigned int> place_of, Targets& targets) {
  const Attribute& deltas = mesh.attributes[attribute];
  const double step = coding.range / (std::ldexp(1.0, coding.bits) - 1);
  MeshoptTarget target;
  target.rows.resize(mesh.point_count);
  for (size_t point = 0; point < mesh.point_count; ++point) {
    MeshoptTarget::Row row{};
    for (size_t k = 0; k < deltas.component_count; ++k) {
      const double steps =
          std::round(static_cast<double>(float_at(deltas, point * deltas.component_count + k)) / step);
      row[k] = static_cast<int16_t>(steps);
      if (row[k] != steps) return unsupported(deltas.semantic + " has deltas of more than 16 bits");
    }
    ++targets.deltas;
    targets.nonzero_deltas += row != MeshoptTarget::Row{};
    target.rows[place_of[point]] = row;
  }
  target.bytes = encode_meshopt_points(
      {reinterpret_cast<const uint8_t*>(target.rows.data()), target.rows.size() * MeshoptTarget::kStride},
      target.rows.size(), MeshoptTarget::kStride);
  targets.meshopt.push_back(std::move(target));
  return {};
}

// Encodes a mesh if it has deltas on a grid that are not all zero.
Status add(const MeshToEncode& source, const EncodeOptions& options, const ThreadPool& pool, Targets& targets) {
  const ReducedMesh reduced = reduce(source, options, pool);
  Mesh mesh = reduced.mesh;
  std::vector<AttributeCoding> codings = source.codings;
  const auto erase_targets = [&](auto is_unwanted) {
    for (size_t i = mesh.attributes.size(); i-- > 0;) {
      if (!target_of(mesh.attributes[i].semantic) || !is_unwanted(i)) continue;
      mesh.attributes.erase(mesh.attributes.begin() + static_cast<ptrdiff_t>(i));
      codings.erase(codings.begin() + static_cast<ptrdiff_t>(i));
    }
  };
  erase_targets([&](size_t i) {
    return codings[i].bits == 0 ||
           std::ranges::all_of(mesh.attributes[i].values, [](std::byte byte) { return byte == std::byte{0}; });
  });
  const StreamOptions stream = stream_options(options, source.patch_count);
  const auto encode_to = [&](DecodedByPsplit& decoded) {
    const Expected<EncodedMesh> encoded = encode_mesh(mesh, codings, stream, pool);
    return encoded ? decoded.add(*encoded) : encoded.status();
  };
  if (std::ranges::none_of(mesh.attributes,
                           [](const Attribute& of) { return target_of(of.semantic).has_value(); }))
    return {};
  if (Status status = encode_to(targets.with); !status.ok()) return status;
  const std::vector<unsigned int> order = fetch_order(mesh);
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    if (target_of(mesh.attributes[i].semantic))
      if (Status status = add_meshopt(mesh, i, codings[i], order, targets); !status.ok()) return status;
  erase_targets([](size_t) { return true; });
  ++targets.meshes;
  return encode_to(targets.without);
}

Status measure(const char* path, int rounds) {
  EncodeDocumentOptions options;
  options.condense = Condense::kFast;
  options.morph_targets = MorphTargets::kPatches;
  options.storage = Storage::kContainer;
  const ThreadPool pool(1);
  const Expected<Asset> file = read_asset(path, describe_stream);
  if (!file) return file.status();
  const Expected<PlannedJobs> jobs = read_and_plan(file->document, options, cpu_backend(), pool);
  if (!jobs) return jobs.status();
  Targets targets;
  for (const EncodeJob& job : jobs->jobs)
    if (Status status = add(job.source, options, pool, targets); !status.ok()) return status;
  if (targets.meshopt.empty()) return unsupported("no deltas that condensed patches would store");

  const std::array contenders{Contender{"psplit", [&] { return targets.with.decode(pool); }},
                              Contender{"psplit without targets", [&] { return targets.without.decode(pool); }},
                              Contender{"meshoptimizer", [&] { return decode(targets.meshopt); }}};
  const Expected<Measured> measured = measure_interleaved(contenders, {.count = rounds});
  if (!measured) return measured.status();
  const auto& [with, without, meshopt] =
      std::tie(measured->timings[0], measured->timings[1], measured->timings[2]);
  const double least = with.min_ms - without.min_ms, middle = with.median_ms - without.median_ms;
  size_t meshopt_bytes = 0;
  for (const MeshoptTarget& target : targets.meshopt) meshopt_bytes += target.bytes.size();
  const Json line{{"meshes", targets.meshes},
                  {"targets", targets.meshopt.size()},
                  {"deltas", targets.deltas},
                  {"nonzero_deltas", targets.nonzero_deltas},
                  {"psplit",
                   {{"bytes", targets.with.stored_bytes() - targets.without.stored_bytes()},
                    {"least_ms", least},
                    {"median_ms", middle},
                    {"without_targets_ms", without.min_ms},
                    {"spread", (with.upper_quartile_ms - with.lower_quartile_ms) / with.median_ms}}},
                  {"meshoptimizer",
                   {{"version", meshopt_version()},
                    {"codec", meshopt_codec_version()},
                    {"bytes", meshopt_bytes},
                    {"least_ms", meshopt.min_ms},
                    {"median_ms", meshopt.median_ms}}},
                  {"ratio", {{"least", least / meshopt.min_ms}, {"median", middle / meshopt.median_ms}}}};
  std::printf("%s\n", line.dump().c_str());
  return {};
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: targets_benchmark ROUNDS FILE...\n"), 1;
  for (int i = 2; i < argc; ++i) {
    const psplit::Status status = psplit::measure(argv[i], std::atoi(argv[1]));
    if (!status.ok()) return std::fprintf(stderr, "%s: %s\n", argv[i], status.to_string().c_str()), 1;
  }
  return 0;
}
