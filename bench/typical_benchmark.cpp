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

#include "bench/asset_primitives.h"
#include "encoder/libdraco/draco_backend.h"
#include "gltf_ext/json/json.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "src/cpu/staged_decode.h"
#include "tools/gltf_psplit/compare/decode_as_loader.h"
#include "tools/gltf_psplit/compare/measure.h"

namespace psplit {
namespace {

constexpr const char* name_of(MeshoptForm form) {
  return form == MeshoptForm::kPlain ? "plain" : form == MeshoptForm::kZstd ? "zstd" : "brotli";
}

EncodeDocumentOptions options_of(int speed) {
  EncodeDocumentOptions options;
  options.encode_speed = speed;
  options.storage = Storage::kOneStream;
  return options;
}

// The stages of each stream alone.
Status decode_stages(std::span<const EncodedMesh> streams, StageTimes& least) {
  StageTimes times;
  for (const EncodedMesh& stream : streams) {
    StagedInput input(open_stream(stream.pieces[0].bytes), stream.requests);
    if (Status status = decode_with_core(input, /*in_step=*/false, times); !status.ok()) return status;
  }
  for (double StageTimes::*stage : {&StageTimes::connectivity_ms, &StageTimes::seams_ms, &StageTimes::chains_ms,
                                    &StageTimes::prediction_ms, &StageTimes::output_ms})
    least.*stage = least.*stage == 0 ? times.*stage : std::min(least.*stage, times.*stage);
  return {};
}

Status measure(const AssetPrimitives& asset, int speed, int rounds) {
  const ThreadPool one(1), two(2);
  const Expected<std::vector<EncodedMesh>> encoded = encode_asset_primitives(asset, options_of(speed), two);
  if (!encoded) return encoded.status();
  uint64_t bytes = 0, points = 0;
  for (const EncodedMesh& stream : *encoded) {
    bytes += stream.pieces[0].bytes.size();
    points += stream.pieces[0].point_count;
  }
  StageTimes stages;
  const auto decode = [&](const DecodeBackend& backend, const ThreadPool& pool) {
    return decode_as_loader(*encoded, backend, pool).status();
  };
  std::vector<Contender> contenders{{"psplit", [&] { return decode(cpu_backend(), one); }},
                                    {"psplit, two threads", [&] { return decode(cpu_backend(), two); }},
                                    {"libdraco", [&] { return decode(draco_backend(), one); }},
                                    {"stages", [&] { return decode_stages(*encoded, stages); }}};
  const size_t before = contenders.size();
  for (const MeshoptForm form : meshopt_forms())
    contenders.push_back({"meshoptimizer", [&asset, form] { return decode_meshopt_all(asset.meshopt, form); }});
  const Expected<Measured> measured = measure_interleaved(contenders, {.count = rounds});
  if (!measured) return measured.status();
  const std::vector<Timing>& timings = measured->timings;
  const Timing& ours = timings[0];
  Json line{
      {"speed", speed},
      {"faces", asset.faces},
      {"points", points},
      {"primitives", asset.jobs.size()},
      {"most_faces", asset.most_faces},
      {"bytes", bytes},
      {"psplit_ms", timings[0].min_ms},
      {"psplit_spread", ours.upper_quartile_ms / ours.median_ms - ours.lower_quartile_ms / ours.median_ms},
      {"psplit_two_threads_ms", timings[1].min_ms},
      {"libdraco_ms", timings[2].min_ms},
      {"stages_ms",
       {stages.connectivity_ms, stages.seams_ms, stages.chains_ms, stages.prediction_ms, stages.output_ms}}};
  Json& rival = line["meshoptimizer"];
  rival = {{"version", meshopt_version()}, {"codec", meshopt_codec_version()}};
  for (size_t i = 0; i < meshopt_forms().size(); ++i) {
    const MeshoptForm form = meshopt_forms()[i];
    uint64_t packed = 0;
    for (const MeshoptMesh& mesh : asset.meshopt) packed += mesh.bytes(form).size();
    rival[name_of(form)] = {{"bytes", packed}, {"ms", timings[before + i].min_ms}};
  }
  std::printf("%s\n", line.dump().c_str());
  return {};
}

Status measure(const char* path, const std::string& speeds, int rounds) {
  const ThreadPool pool(2);
  const Expected<Asset> file = read_asset(path, describe_draco_stream);
  if (!file) return file.status();
  const Expected<AssetPrimitives> asset = read_asset_primitives(file->document, options_of(5), pool);
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
