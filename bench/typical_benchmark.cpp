// Whole assets as they are shipped: each primitive one stock Draco stream. psplit's decoder on one thread and
// on two, libdraco, and meshoptimizer with zstd, which gets the same grids, decode all primitives in turn.
//
//   typical_benchmark SPEED ROUNDS FILE...     prints a line of JSON for each asset that has triangles
//
// Times are the least of all rounds, in milliseconds, with memory for the meshes that is allocated each time.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "encoder/encode_mesh.h"
#include "encoder/libdraco/draco_backend.h"
#include "gltf_ext/convert/read_jobs.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "src/cpu/staged_decode.h"
#include "tools/gltf_psplit/compare/measure.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"

namespace psplit {
namespace {

struct Encoded {
  std::vector<EncodedMesh> streams;
  std::vector<MeshoptMesh> meshopt;
  uint64_t faces = 0, points = 0, most_faces = 0, bytes = 0, meshopt_bytes = 0;
};

Expected<Encoded> encode(const char* path, int speed, const ThreadPool& pool) {
  const Expected<Asset> asset = read_asset(path, describe_draco_stream);
  if (!asset) return asset.status();
  EncodeDocumentOptions options;
  options.encode_speed = speed;
  options.storage = Storage::kOneStream;
  const Expected<PlannedJobs> jobs = read_and_plan(asset->document, options, cpu_backend(), pool);
  if (!jobs) return jobs.status();
  Encoded out;
  for (const EncodeJob& job : jobs->jobs) {
    const Mesh mesh = reduce(job.source, options, pool).mesh;
    if (mesh.faces.empty()) continue;
    Expected<EncodedMesh> stream = psplit::encode(job.source, options, pool);
    if (!stream) return stream.status();
    Expected<MeshoptMesh> meshopt = encode_meshopt(mesh, job.source.codings);
    if (!meshopt) return meshopt.status();
    out.faces += mesh.faces.size();
    out.points += stream->pieces[0].point_count;
    out.most_faces = std::max<uint64_t>(out.most_faces, mesh.faces.size());
    out.bytes += stream->pieces[0].bytes.size();
    out.meshopt_bytes += meshopt->compressed.size();
    out.streams.push_back(std::move(*stream));
    out.meshopt.push_back(std::move(*meshopt));
  }
  return out;
}

Status decode(const Encoded& asset, const DecodeBackend& backend, const ThreadPool& pool) {
  std::vector<PatchContainer> opened;
  for (const EncodedMesh& stream : asset.streams) opened.push_back(open_stream(stream.pieces[0].bytes));
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < opened.size(); ++i) tasks.push_back({&opened[i], asset.streams[i].requests});
  for (const Expected<Mesh>& mesh : backend.decode(tasks, pool))
    if (!mesh) return mesh.status();
  return {};
}

Status decode_rival(const Encoded& asset) {
  for (const MeshoptMesh& mesh : asset.meshopt)
    if (const auto decoded = decode_meshopt(mesh); !decoded) return decoded.status();
  return {};
}

// The stages of each stream alone.
Status decode_stages(const Encoded& asset, StageTimes& least) {
  StageTimes times;
  for (const EncodedMesh& stream : asset.streams) {
    StagedInput input(open_stream(stream.pieces[0].bytes), stream.requests);
    if (Status status = decode_with_core(input, /*in_step=*/false, times); !status.ok()) return status;
  }
  for (double StageTimes::*stage : {&StageTimes::connectivity_ms, &StageTimes::seams_ms, &StageTimes::chains_ms,
                                    &StageTimes::prediction_ms, &StageTimes::output_ms})
    least.*stage = least.*stage == 0 ? times.*stage : std::min(least.*stage, times.*stage);
  return {};
}

Status measure(const char* path, int speed, int rounds) {
  const ThreadPool one(1), two(2);
  const Expected<Encoded> asset = encode(path, speed, two);
  if (!asset) return asset.status();
  if (asset->faces == 0) return {};
  StageTimes stages;
  const std::vector<Contender> contenders{
      {"psplit", [&] { return decode(*asset, cpu_backend(), one); }},
      {"psplit, two threads", [&] { return decode(*asset, cpu_backend(), two); }},
      {"libdraco", [&] { return decode(*asset, draco_backend(), one); }},
      {"meshoptimizer", [&] { return decode_rival(*asset); }},
      {"stages", [&] { return decode_stages(*asset, stages); }}};
  const Expected<std::vector<Timing>> timings = measure_interleaved(contenders, rounds);
  if (!timings) return timings.status();
  std::printf(
      "{\"faces\": %llu, \"points\": %llu, \"primitives\": %zu, \"most_faces\": %llu, \"bytes\": %llu, "
      "\"meshopt_bytes\": %llu, \"psplit_ms\": %.4f, \"psplit_two_threads_ms\": %.4f, \"libdraco_ms\": %.4f, "
      "\"meshopt_ms\": %.4f, \"stages_ms\": [%.4f, %.4f, %.4f, %.4f, %.4f]}\n",
      static_cast<unsigned long long>(asset->faces), static_cast<unsigned long long>(asset->points),
      asset->streams.size(), static_cast<unsigned long long>(asset->most_faces),
      static_cast<unsigned long long>(asset->bytes), static_cast<unsigned long long>(asset->meshopt_bytes),
      (*timings)[0].min_ms, (*timings)[1].min_ms, (*timings)[2].min_ms, (*timings)[3].min_ms,
      stages.connectivity_ms, stages.seams_ms, stages.chains_ms, stages.prediction_ms, stages.output_ms);
  return {};
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  if (argc < 4) return std::fprintf(stderr, "usage: typical_benchmark SPEED ROUNDS FILE...\n"), 1;
  int failed = 0;
  for (int i = 3; i < argc; ++i) {
    const psplit::Status status = psplit::measure(argv[i], std::atoi(argv[1]), std::atoi(argv[2]));
    if (status.ok()) continue;
    std::fprintf(stderr, "%s: %s\n", argv[i], status.to_string().c_str());
    failed = 1;
  }
  return failed;
}
