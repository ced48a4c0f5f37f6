#include "tools/gltf_psplit/compare/comparison.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "encoder/encode_mesh.h"
#include "gltf_ext/convert/encode_job.h"
#include "psplit/encode.h"
#include "src/cpu/staged_decode.h"
#include "tools/gltf_psplit/compare/decode_as_loader.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

// All encoded data that the decoders are timed on. Contenders refer to its parts, so these must not move.
struct Encoded {
  std::vector<std::vector<EncodedMesh>> stock;  // one for each speed
  std::vector<MeshoptMesh> meshopt;
  std::vector<std::vector<EncodedMesh>> splits;  // one for each rule
};

std::vector<uint64_t> faces_of(std::span<const EncodeJob> jobs) {
  std::vector<uint64_t> faces;
  for (const EncodeJob& job : jobs) faces.push_back(job.face_count);
  return faces;
}

std::vector<int> all_speeds(const ComparisonOptions& options) {
  std::vector<int> speeds = options.stock_speeds;
  speeds.push_back(options.coding.encode_speed);
  std::ranges::sort(speeds);
  speeds.erase(std::unique(speeds.begin(), speeds.end()), speeds.end());
  return speeds;
}

MeshoptRow& row_of(Comparison& comparison, MeshoptForm form) {
  if (form == MeshoptForm::kPlain) return comparison.meshopt_plain;
  if (form == MeshoptForm::kZstd) return comparison.meshopt;
  return comparison.meshopt_brotli ? *comparison.meshopt_brotli : comparison.meshopt_brotli.emplace();
}

// `mesh` is the part of the job that encoders store.
Status encode_rivals(const EncodeJob& job, const Mesh& mesh, const EncodeDocumentOptions& coding,
                     const ThreadPool& pool, Encoded& encoded, Comparison& comparison) {
  EncodeOptions stock = coding.of_meshes();
  stock.storage = Storage::kOneStream;
  stock.by_libdraco = true;
  stock.verify = false;
  for (size_t i = 0; i < encoded.stock.size(); ++i) {
    StockRow& row = comparison.stock_speeds[i];
    stock.encode_speed = row.speed;
    Expected<EncodedMesh> stream = Status();
    row.encode_ms += elapsed_ms([&] { stream = encode(job.source, stock, pool); });
    if (!stream) return stream.status();
    stream->pieces[0].decoded = {};
    row.bytes += stream->pieces[0].bytes.size();
    encoded.stock[i].push_back(std::move(*stream));
  }
  Expected<MeshoptMesh> meshopt = encode_meshopt(mesh, job.source.codings);
  if (!meshopt) return meshopt.status();
  for (const MeshoptForm form : meshopt_forms()) row_of(comparison, form).bytes += meshopt->bytes(form).size();
  encoded.meshopt.push_back(std::move(*meshopt));
  return {};
}

Status encode_split(std::span<const EncodeJob> jobs, const PatchRule& rule, const EncodeDocumentOptions& coding,
                    std::span<const uint8_t> is_empty, const ThreadPool& pool, std::vector<EncodedMesh>& split,
                    SplitRow& row) {
  EncodeOptions options = apply_rule(coding, rule).of_meshes();
  options.verify = false;
  const std::vector<uint32_t> counts = patch_counts(faces_of(jobs), options.patches);
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (is_empty[i]) continue;
    // Patches whatever they cost; without a cut, what encode_document writes.
    options.patches.always = counts[i] > 1 || rule.condense;
    options.storage = options.patches.always ? Storage::kContainer : Storage::kAsFits;
    MeshToEncode source = jobs[i].source;
    source.patch_count = counts[i];
    source.is_condensed_later = false;
    Expected<EncodedMesh> mesh = encode(std::move(source), options, pool);
    if (!mesh) return mesh.status();
    const EncodedPiece& piece = mesh->pieces[0];
    const bool has_residue = mesh->statistics.patch_count < piece.entries.size();
    row.summary += summarize_streams(piece.entries, has_residue, piece.head_bytes, piece.bytes.size());
    row.partition_ms += mesh->statistics.partition_ms;
    row.encode_ms += mesh->statistics.encode_ms;
    split.push_back(std::move(*mesh));
  }
  return {};
}

Status decode_stock(std::span<const EncodedMesh> stock, const DecodeBackend& backend, const ThreadPool& one) {
  return decode_as_loader(stock, backend, one).status();
}

Status decode_rival(const Encoded& encoded, MeshoptForm form) {
  for (const MeshoptMesh& packed : encoded.meshopt) {
    const Expected<MeshoptDecoded> mesh = decode_meshopt(packed, form);
    if (!mesh) return mesh.status();
  }
  return {};
}

Status decode_split(std::span<const EncodedMesh> split, const DecodeBackend& backend, const ThreadPool& pool) {
  const Expected<DecodedCounts> decoded = decode_as_loader(split, backend, pool);
  if (!decoded) return decoded.status();
  // A stock stream repeats points, so these counts differ from the summary's.
  DecodedCounts stated;
  for (const EncodedMesh& mesh : split) {
    stated.faces += mesh.pieces[0].face_count;
    stated.points += mesh.pieces[0].point_count;
  }
  if (decoded->faces == stated.faces && decoded->points == stated.points) return {};
  return {StatusCode::kDiffers, "decoded faces and points are not those of the directory"};
}

Status decode_stages(std::span<const EncodedMesh> split, StageTimes& times) {
  for (const EncodedMesh& mesh : split) {
    const EncodedPiece& piece = mesh.pieces[0];
    Expected<PatchContainer> container =
        piece.is_container ? open_container(piece.bytes) : open_stream(piece.bytes);
    if (!container) return container.status();
    StagedInput input(std::move(*container), mesh.requests);
    // The first stage would pay for all memory, of which the system gives each page when it is first written.
    StageTimes cold;
    Status status = decode_with_core(input, /*in_step=*/true, cold);
    if (status.ok()) status = decode_with_core(input, /*in_step=*/true, times);
    if (!status.ok()) return runtime_failure(status.message());
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

Status encode_all(std::span<const EncodeJob> jobs, const ComparisonOptions& options, const ThreadPool& pool,
                  Encoded& encoded, Comparison& comparison) {
  for (const int speed : all_speeds(options)) comparison.stock_speeds.push_back({.speed = speed, .decode = {}});
  encoded.stock.resize(comparison.stock_speeds.size());
  std::vector<uint8_t> is_empty;
  for (const EncodeJob& job : jobs) {
    const Mesh mesh = reduce(job.source, options.coding.of_meshes(), pool).mesh;
    is_empty.push_back(mesh.faces.empty());
    if (mesh.faces.empty()) continue;
    comparison.faces += mesh.faces.size();
    comparison.points += mesh.point_count;
    if (Status status = encode_rivals(job, mesh, options.coding, pool, encoded, comparison); !status.ok())
      return status;
  }
  if (comparison.faces == 0) return unsupported("has no triangles");
  comparison.stock = *std::ranges::find(comparison.stock_speeds, options.coding.encode_speed, &StockRow::speed);
  encoded.splits.resize(options.rules.size());
  comparison.splits.resize(options.rules.size());
  for (size_t i = 0; i < options.rules.size(); ++i) comparison.splits[i].rule = options.rules[i];
  for (size_t i = 0; i < encoded.splits.size(); ++i) {
    SplitRow& row = comparison.splits[i];
    if (Status status =
            encode_split(jobs, options.rules[i], options.coding, is_empty, pool, encoded.splits[i], row);
        !status.ok())
      return status;
    row.overhead =
        static_cast<double>(row.summary.total_bytes) / static_cast<double>(comparison.stock.bytes) - 1;
  }
  return {};
}

// Everything that is timed, in an order that fill_timings follows. Contenders refer to the arguments.
std::vector<Contender> make_contenders(const Encoded& encoded, const Comparison& comparison,
                                       std::span<const DecodeBackend> backends,
                                       std::span<const std::unique_ptr<ThreadPool>> pools,
                                       const DecodeBackend& stock_backend, const ThreadPool& one,
                                       std::vector<std::vector<StageTimes>>& stage_rounds) {
  std::vector<Contender> contenders;
  for (size_t i = 0; i < encoded.stock.size(); ++i)
    contenders.push_back(
        {"stock Draco",
         [&stock = encoded.stock[i], &stock_backend, &one] { return decode_stock(stock, stock_backend, one); },
         comparison.stock_speeds[i].speed == comparison.stock.speed});
  for (const MeshoptForm form : meshopt_forms())
    contenders.push_back({"meshoptimizer", [&encoded, form] { return decode_rival(encoded, form); },
                          form == MeshoptForm::kZstd});
  for (size_t i = 0; i < encoded.splits.size(); ++i) {
    for (const DecodeBackend& backend : backends)
      for (const auto& decode_pool : pools)
        contenders.push_back({counted(comparison.splits[i].summary.patches, "patch"),
                              [&split = encoded.splits[i], &backend, &threads = *decode_pool] {
                                return decode_split(split, backend, threads);
                              },
                              is_own(backend) || backends.size() == 1});
    contenders.push_back({"stages",
                          [&split = encoded.splits[i], &rounds = stage_rounds[i]] {
                            return decode_stages(split, rounds.emplace_back());
                          },
                          false});
  }
  return contenders;
}

void fill_timings(std::span<const Timing> timings, const ComparisonOptions& options,
                  std::span<const DecodeBackend> backends,
                  std::span<const std::vector<StageTimes>> stage_rounds, Comparison& comparison) {
  auto next = timings.begin();
  for (StockRow& row : comparison.stock_speeds) {
    row.decode = *next++;
    if (row.speed == comparison.stock.speed) comparison.stock.decode = row.decode;
  }
  for (const MeshoptForm form : meshopt_forms()) row_of(comparison, form).decode = *next++;
  for (size_t i = 0; i < comparison.splits.size(); ++i) {
    SplitRow& row = comparison.splits[i];
    for (const DecodeBackend& backend : backends)
      for (const int threads : options.thread_counts) {
        const Timing timing = *next++;
        row.decode.push_back(
            {backend.name, threads, timing, comparison.stock.decode.median_ms / timing.median_ms});
      }
    ++next;                                                                // the stages, which time themselves
    row.stages = summarize_stages(std::span(stage_rounds[i]).subspan(1));  // the first round is not timed
  }
}

}  // namespace

EncodeDocumentOptions apply_rule(EncodeDocumentOptions coding, const PatchRule& rule) {
  coding.patches.count = rule.patches;
  coding.patches.faces = rule.patch_faces;
  coding.condense = !rule.condense           ? Condense::kNo
                    : coding.choose_by_bytes ? Condense::kSmallest
                                             : Condense::kFast;
  return coding;
}

uint64_t count_patches(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& coding,
                       const PatchRule& rule) {
  const std::vector<uint32_t> counts =
      patch_counts(faces_of(jobs), apply_rule(coding, rule).of_meshes().patches);
  return std::accumulate(counts.begin(), counts.end(), uint64_t{0});
}

Expected<Comparison> compare_codecs(std::span<const EncodeJob> jobs, const ComparisonOptions& options,
                                    std::span<const DecodeBackend> backends, const ThreadPool& pool,
                                    const Progress& progress) {
  Comparison comparison;
  Encoded encoded;
  if (Status status = encode_all(jobs, options, pool, encoded, comparison); !status.ok()) return status;
  std::vector<std::unique_ptr<ThreadPool>> pools;
  for (const int threads : options.thread_counts) pools.push_back(std::make_unique<ThreadPool>(threads));
  const ThreadPool one(1);
  const DecodeBackend stock_backend = draco_backend();
  std::vector<std::vector<StageTimes>> stage_rounds(encoded.splits.size());
  const std::vector<Contender> contenders =
      make_contenders(encoded, comparison, backends, pools, stock_backend, one, stage_rounds);
  const Expected<Measured> measured = measure_interleaved(contenders, options.rounds, progress);
  if (!measured) return measured.status();
  comparison.rounds = measured->rounds;
  fill_timings(measured->timings, options, backends, stage_rounds, comparison);
  return comparison;
}

}  // namespace psplit
