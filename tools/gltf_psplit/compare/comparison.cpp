#include "tools/gltf_psplit/compare/comparison.h"

#include <algorithm>
#include <memory>

#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/draco/stock_stream.h"
#include "encoder/encode_mesh.h"
#include "encoder/partition/partition.h"
#include "src/cpu/staged_decode.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

// All encoded data that the decoders are timed on. Contenders refer to its parts, so these must not move.
struct Encoded {
  struct Stock {
    std::vector<StockStream> streams;
    std::vector<std::vector<AttributeRequest>> requests;
  };
  struct Split {
    std::vector<EncodedMesh> meshes;
    std::vector<std::vector<AttributeRequest>> requests;
  };
  std::vector<Stock> stock;  // one for each speed
  std::vector<MeshoptMesh> meshopt;
  std::vector<Split> splits;
};

Expected<AttributeCoding> choose_coding(const Attribute& attribute, const EncodeDocumentOptions& options) {
  const std::string& name = attribute.semantic;
  if (options.lossless || attribute.component_type != ComponentType::kFloat32) return AttributeCoding{};
  if (name == "NORMAL" && attribute.component_count == 3)
    return AttributeCoding{.bits = options.normal_bits, .octahedral = true, .origin = {}, .range = 0};
  int bits = options.generic_bits;
  if (name == "POSITION") bits = options.position_bits;
  if (name.starts_with("TEXCOORD_")) bits = options.texcoord_bits;
  if (name.starts_with("COLOR_")) bits = options.color_bits;
  return fit_grid(attribute, bits);
}

std::vector<AttributeRequest> make_requests(const Mesh& mesh, std::span<const uint32_t> unique_ids) {
  std::vector<AttributeRequest> requests;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    requests.push_back({attribute.semantic, unique_ids[i], attribute.component_type, attribute.component_count,
                        attribute.normalized});
  }
  return requests;
}

std::vector<int> all_speeds(const ComparisonOptions& options) {
  std::vector<int> speeds = options.stock_speeds;
  speeds.push_back(options.coding.encode_speed);
  std::ranges::sort(speeds);
  speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());
  return speeds;
}

Status encode_rivals(const Mesh& mesh, std::span<const AttributeCoding> codings,
                     const ComparisonOptions& options, Encoded& encoded, Comparison& comparison) {
  for (size_t i = 0; i < encoded.stock.size(); ++i) {
    StockRow& row = comparison.stock_speeds[i];
    Expected<StockStream> stock = Status();
    row.encode_ms += elapsed_ms([&] { stock = encode_stock_stream(mesh, codings, row.speed); });
    if (!stock) return stock.status();
    row.bytes += stock->bytes.size();
    encoded.stock[i].requests.push_back(make_requests(mesh, stock->unique_ids));
    encoded.stock[i].streams.push_back(std::move(*stock));
  }
  Expected<MeshoptMesh> meshopt = encode_meshopt(
      mesh, {options.coding.position_bits, options.coding.texcoord_bits, options.coding.lossless});
  if (!meshopt) return meshopt.status();
  comparison.meshopt.bytes += meshopt->compressed.size();
  comparison.meshopt_plain.bytes += meshopt->packed.size();
  encoded.meshopt.push_back(std::move(*meshopt));
  return {};
}

Status encode_split(std::span<const Mesh> meshes, std::span<const std::vector<AttributeCoding>> codings,
                    uint64_t patch_count, const ComparisonOptions& options, const ThreadPool& pool,
                    Encoded::Split& split, SplitRow& row) {
  std::vector<uint64_t> face_counts;
  for (const Mesh& mesh : meshes) face_counts.push_back(mesh.faces.size());
  const std::vector<uint32_t> shares = distribute_patches(face_counts, patch_count);
  for (size_t i = 0; i < meshes.size(); ++i) {
    EncodeOptions encode_options;
    encode_options.patch_count = shares[i];
    encode_options.encode_speed = options.coding.encode_speed;
    encode_options.verify = false;
    encode_options.refine = options.coding.refine;
    encode_options.method = options.coding.method;
    encode_options.distance = options.coding.distance;
    Expected<EncodedMesh> mesh = encode_mesh(meshes[i], codings[i], encode_options, pool);
    if (!mesh) return mesh.status();
    const Expected<PatchSummary> summary = summarize_container(mesh->container);
    if (!summary) return summary.status();
    row.summary += *summary;
    row.partition_ms += mesh->statistics.partition_ms;
    row.encode_ms += mesh->statistics.encode_ms;
    split.requests.push_back(make_requests(meshes[i], mesh->unique_ids));
    split.meshes.push_back(std::move(*mesh));
  }
  return {};
}

Status decode_stock(const Encoded::Stock& stock, const DecodeBackend& backend) {
  const ThreadPool one(1);
  for (size_t i = 0; i < stock.streams.size(); ++i) {
    const Expected<Mesh> mesh = backend.decode(open_stream(stock.streams[i].bytes), stock.requests[i], one);
    if (!mesh) return mesh.status();
  }
  return {};
}

Status decode_rival(const Encoded& encoded, MeshoptForm form) {
  for (const MeshoptMesh& packed : encoded.meshopt) {
    const Expected<MeshoptDecoded> mesh = decode_meshopt(packed, form);
    if (!mesh) return mesh.status();
  }
  return {};
}

Status decode_split(const Encoded::Split& split, const PatchSummary& summary, const DecodeBackend& backend,
                    const ThreadPool& pool) {
  uint64_t faces = 0, points = 0;
  std::vector<DecodeTask> tasks;
  std::vector<PatchContainer> containers;
  for (const EncodedMesh& mesh : split.meshes) {
    Expected<PatchContainer> container = open_container(mesh.container);
    if (!container) return container.status();
    containers.push_back(std::move(*container));
  }
  for (size_t i = 0; i < containers.size(); ++i) tasks.push_back({&containers[i], split.requests[i]});
  for (const Expected<Mesh>& mesh : backend.decode(tasks, pool, {})) {
    if (!mesh) return mesh.status();
    faces += mesh->faces.size();
    points += mesh->point_count;
  }
  if (faces == summary.faces && points == summary.points) return {};
  return {StatusCode::kDiffers, "decoded faces and points are not those of the directory"};
}

Status decode_stages(const Encoded::Split& split, StageTimes& times) {
  for (size_t i = 0; i < split.meshes.size(); ++i) {
    StagedInput input(*open_container(split.meshes[i].container), split.requests[i]);
    const core::Fault fault = decode_with_core(input, /*in_step=*/true, times);
    if (fault != core::Fault::kNone) return runtime_failure(core::fault_text(fault));
  }
  return {};
}

// Summarizes each stage over all rounds.
std::vector<StageRow> summarize_stages(std::span<const StageTimes> rounds) {
  constexpr std::pair<const char*, double StageTimes::*> kStages[] = {
      {"connectivity", &StageTimes::connectivity_ms},
      {"seams", &StageTimes::seams_ms},
      {"traversal and symbols", &StageTimes::chains_ms},
      {"prediction", &StageTimes::prediction_ms},
      {"output", &StageTimes::output_ms}};
  std::vector<StageRow> rows;
  for (const auto& [name, stage] : kStages) {
    std::vector<double> samples_ms;
    for (const StageTimes& times : rounds) samples_ms.push_back(times.*stage);
    rows.push_back({name, summarize_samples(std::move(samples_ms))});
  }
  return rows;
}

}  // namespace

Expected<Comparison> compare_codecs(std::span<const Mesh> meshes, const ComparisonOptions& options,
                                    std::span<const DecodeBackend> backends, const ThreadPool& pool,
                                    const Progress& progress) {
  Comparison comparison;
  Encoded encoded;
  for (const int speed : all_speeds(options)) comparison.stock_speeds.push_back({.speed = speed, .decode = {}});
  encoded.stock.resize(comparison.stock_speeds.size());
  std::vector<std::vector<AttributeCoding>> codings;
  for (const Mesh& mesh : meshes) {
    comparison.faces += mesh.faces.size();
    comparison.points += mesh.point_count;
    std::vector<AttributeCoding>& mesh_codings = codings.emplace_back();
    for (const Attribute& attribute : mesh.attributes) {
      Expected<AttributeCoding> coding = choose_coding(attribute, options.coding);
      if (!coding) return coding.status();
      mesh_codings.push_back(std::move(*coding));
    }
    if (Status status = encode_rivals(mesh, mesh_codings, options, encoded, comparison); !status.ok())
      return status;
  }
  const auto base = std::ranges::find(comparison.stock_speeds, options.coding.encode_speed, &StockRow::speed);
  encoded.splits.resize(options.patch_counts.size());
  comparison.splits.resize(options.patch_counts.size());
  for (size_t i = 0; i < encoded.splits.size(); ++i) {
    SplitRow& row = comparison.splits[i];
    if (Status status =
            encode_split(meshes, codings, options.patch_counts[i], options, pool, encoded.splits[i], row);
        !status.ok())
      return status;
    row.overhead = static_cast<double>(row.summary.total_bytes) / static_cast<double>(base->bytes) - 1;
  }

  std::vector<std::unique_ptr<ThreadPool>> pools;
  for (const int threads : options.thread_counts) pools.push_back(std::make_unique<ThreadPool>(threads));
  const DecodeBackend stock_backend = draco_backend();
  std::vector<Contender> contenders;
  for (const Encoded::Stock& stock : encoded.stock)
    contenders.push_back({"stock Draco", [&] { return decode_stock(stock, stock_backend); }});
  for (const MeshoptForm form : {MeshoptForm::kZstd, MeshoptForm::kPlain})
    contenders.push_back({"meshoptimizer", [&encoded, form] { return decode_rival(encoded, form); }});
  std::vector<std::vector<StageTimes>> stage_rounds(encoded.splits.size());
  for (size_t i = 0; i < encoded.splits.size(); ++i) {
    for (const DecodeBackend& backend : backends)
      for (const auto& decode_pool : pools)
        contenders.push_back({counted(comparison.splits[i].summary.patches, "patch"),
                              [&encoded, &comparison, &backend, &threads = *decode_pool, i] {
                                return decode_split(encoded.splits[i], comparison.splits[i].summary, backend,
                                                    threads);
                              }});
    contenders.push_back({"stages", [&split = encoded.splits[i], &rounds = stage_rounds[i]] {
                            return decode_stages(split, rounds.emplace_back());
                          }});
  }
  const Expected<std::vector<Timing>> timings = measure_interleaved(contenders, options.repeat, progress);
  if (!timings) return timings.status();

  size_t next = 0;
  for (StockRow& row : comparison.stock_speeds) row.decode = (*timings)[next++];
  comparison.stock = *base;
  comparison.meshopt.decode = (*timings)[next++];
  comparison.meshopt_plain.decode = (*timings)[next++];
  for (size_t i = 0; i < comparison.splits.size(); ++i) {
    SplitRow& row = comparison.splits[i];
    for (const DecodeBackend& backend : backends)
      for (const int threads : options.thread_counts) {
        const Timing timing = (*timings)[next++];
        row.decode.push_back(
            {backend.name, threads, timing, comparison.stock.decode.median_ms / timing.median_ms});
      }
    ++next;
    row.stages = summarize_stages(std::span(stage_rounds[i]).subspan(1));  // the first round is not timed
  }
  return comparison;
}

}  // namespace psplit
