// Whole assets as they are shipped: each primitive one stock Draco stream. psplit's decoder on one thread and
// on two, libdraco, and meshoptimizer alone and with zstd and brotli, which gets the same grids, decode all
// primitives in turn.
//
//   typical_benchmark SPEEDS ROUNDS FILE...
//
// prints a line of JSON for each asset that has triangles, and each of Draco's speeds, which commas separate.
//
// Times are the least of all rounds, in milliseconds, with memory for the meshes that is allocated each time.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "encoder/encode_mesh.h"
#include "encoder/libdraco/draco_backend.h"
#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/json/json.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "src/cpu/staged_decode.h"
#include "tools/gltf_psplit/compare/decode_as_loader.h"
#include "tools/gltf_psplit/compare/measure.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"

namespace psplit {
namespace {

constexpr const char* name_of(MeshoptForm form) {
  return form == MeshoptForm::kPlain ? "plain" : form == MeshoptForm::kZstd ? "zstd" : "brotli";
}

// What both codecs store of an asset.
struct Primitives {
  std::vector<EncodeJob> jobs;  // those with triangles
  std::vector<MeshoptMesh> meshopt;
  uint64_t faces = 0, most_faces = 0;
};

struct Encoded {
  std::vector<EncodedMesh> streams;
  uint64_t points = 0, bytes = 0;
};

EncodeDocumentOptions options_of(int speed) {
  EncodeDocumentOptions options;
  options.encode_speed = speed;
  options.storage = Storage::kOneStream;
  return options;
}

Expected<Primitives> read(const char* path, const EncodeDocumentOptions& options, const ThreadPool& pool) {
  const Expected<Asset> asset = read_asset(path, describe_draco_stream);
  if (!asset) return asset.status();
  Expected<PlannedJobs> jobs = read_and_plan(asset->document, options, cpu_backend(), pool);
  if (!jobs) return jobs.status();
  Primitives out;
  for (EncodeJob& job : jobs->jobs) {
    const Mesh mesh = reduce(job.source, options, pool).mesh;
    if (mesh.faces.empty()) continue;
    Expected<MeshoptMesh> meshopt = encode_meshopt(mesh, job.source.codings);
    if (!meshopt) return meshopt.status();
    out.faces += mesh.faces.size();
    out.most_faces = std::max<uint64_t>(out.most_faces, mesh.faces.size());
    out.meshopt.push_back(std::move(*meshopt));
    out.jobs.push_back(std::move(job));
  }
  return out;
}

Expected<Encoded> encode(const Primitives& asset, const EncodeDocumentOptions& options,
                         const ThreadPool& pool) {
  Encoded out;
  for (const EncodeJob& job : asset.jobs) {
    Expected<EncodedMesh> stream = psplit::encode(job.source, options, pool);
    if (!stream) return stream.status();
    out.points += stream->pieces[0].point_count;
    out.bytes += stream->pieces[0].bytes.size();
    out.streams.push_back(std::move(*stream));
  }
  return out;
}

Status decode_rival(std::span<const MeshoptMesh> meshes, MeshoptForm form) {
  for (const MeshoptMesh& mesh : meshes)
    if (const auto decoded = decode_meshopt(mesh, form); !decoded) return decoded.status();
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

Status measure(const Primitives& asset, int speed, int rounds) {
  const ThreadPool one(1), two(2);
  const Expected<Encoded> encoded = encode(asset, options_of(speed), two);
  if (!encoded) return encoded.status();
  StageTimes stages;
  const auto decode = [&](const DecodeBackend& backend, const ThreadPool& pool) {
    return decode_as_loader(encoded->streams, backend, pool).status();
  };
  std::vector<Contender> contenders{{"psplit", [&] { return decode(cpu_backend(), one); }},
                                    {"psplit, two threads", [&] { return decode(cpu_backend(), two); }},
                                    {"libdraco", [&] { return decode(draco_backend(), one); }},
                                    {"stages", [&] { return decode_stages(*encoded, stages); }}};
  const size_t before = contenders.size();
  for (const MeshoptForm form : meshopt_forms())
    contenders.push_back({"meshoptimizer", [&asset, form] { return decode_rival(asset.meshopt, form); }});
  const Expected<std::vector<Timing>> timings = measure_interleaved(contenders, rounds);
  if (!timings) return timings.status();
  const Timing& ours = (*timings)[0];
  Json line{
      {"speed", speed},
      {"faces", asset.faces},
      {"points", encoded->points},
      {"primitives", asset.jobs.size()},
      {"most_faces", asset.most_faces},
      {"bytes", encoded->bytes},
      {"psplit_ms", (*timings)[0].min_ms},
      {"psplit_spread", ours.upper_quartile_ms / ours.median_ms - ours.lower_quartile_ms / ours.median_ms},

      {"psplit_two_threads_ms", (*timings)[1].min_ms},
      {"libdraco_ms", (*timings)[2].min_ms},
      {"stages_ms",
       {stages.connectivity_ms, stages.seams_ms, stages.chains_ms, stages.prediction_ms, stages.output_ms}}};
  Json& rival = line["meshoptimizer"];
  rival = {{"version", meshopt_version()}, {"codec", meshopt_codec_version()}};
  for (size_t i = 0; i < meshopt_forms().size(); ++i) {
    const MeshoptForm form = meshopt_forms()[i];
    uint64_t bytes = 0;
    for (const MeshoptMesh& mesh : asset.meshopt) bytes += mesh.bytes(form).size();
    rival[name_of(form)] = {{"bytes", bytes}, {"ms", (*timings)[before + i].min_ms}};
  }
  std::printf("%s\n", line.dump().c_str());
  return {};
}

Status measure(const char* path, const std::string& speeds, int rounds) {
  const ThreadPool pool(2);
  const Expected<Primitives> asset = read(path, options_of(5), pool);
  if (!asset) return asset.status();
  std::istringstream list(asset->faces == 0 ? "" : speeds);
  for (std::string speed; std::getline(list, speed, ',');)
    if (Status status = measure(*asset, std::atoi(speed.c_str()), rounds); !status.ok()) return status;
  return {};
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  if (argc < 4) return std::fprintf(stderr, "usage: typical_benchmark SPEEDS ROUNDS FILE...\n"), 1;
  int failed = 0;
  for (int i = 3; i < argc; ++i) {
    const psplit::Status status = psplit::measure(argv[i], argv[1], std::atoi(argv[2]));
    if (status.ok()) continue;
    std::fprintf(stderr, "%s: %s\n", argv[i], status.to_string().c_str());
    failed = 1;
  }
  return failed;
}
