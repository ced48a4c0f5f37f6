// What the start of a viewer sees: the first decode of a process, many tiny streams, and a pool that wakes.
// scripts/first-decode runs it.
//
//   first_decode --write FOLDER FILE...      encodes built-in meshes and glTF assets by each codec, and writes
//                                            FOLDER/NAME.json and .bin
//   first_decode CODEC THREADS SAMPLE        decodes SAMPLE.CODEC, and prints a line of JSON
//
// CODEC is psplit, libdraco or meshoptimizer. The line has milliseconds of wall clock. The first decode
// includes making the pool and getting memory from the system. After it come the second decode, the least of
// the later ones, and the median of decodes after a sleep, when threads must wake and other programs used the
// caches.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <thread>

#include "bench/asset_primitives.h"
#include "encoder/libdraco/draco_backend.h"
#include "gltf_ext/json/json.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "tools/gltf_psplit/compare/decode_as_loader.h"
#include "tools/gltf_psplit/compare/measure.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

constexpr int kWarmRounds = 20, kWakes = 5;
constexpr std::chrono::milliseconds kSleep{100};

// ---- Samples ----

Status write_sample(const std::string& path, const Json& head, const std::vector<uint8_t>& bytes) {
  std::ofstream text(path + ".json"), binary(path + ".bin", std::ios::binary);
  text << head;
  binary.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  text.close();
  binary.close();
  return text && binary ? Status() : runtime_failure(path + " cannot be written");
}

Json request_json(const AttributeRequest& request) {
  return {{"semantic", request.semantic},
          {"id", request.unique_id},
          {"type", static_cast<int>(request.component_type)},
          {"components", request.component_count},
          {"normalized", request.normalized}};
}

Status write_streams(const std::string& path, const AssetPrimitives& asset,
                     std::span<const EncodedMesh> meshes) {
  Json head{{"faces", asset.faces}, {"meshes", Json::array()}};
  std::vector<uint8_t> all;
  for (const EncodedMesh& mesh : meshes) {
    const EncodedPiece& piece = mesh.pieces[0];
    Json row{{"bytes", piece.bytes.size()}, {"container", piece.is_container}, {"requests", Json::array()}};
    for (const AttributeRequest& request : mesh.requests) row["requests"].push_back(request_json(request));
    head["meshes"].push_back(std::move(row));
    all.insert(all.end(), piece.bytes.begin(), piece.bytes.end());
  }
  return write_sample(path, head, all);
}

Status write_meshopt(const std::string& path, const AssetPrimitives& asset) {
  Json head{{"faces", asset.faces}, {"meshes", Json::array()}};
  std::vector<uint8_t> all;
  for (const MeshoptMesh& mesh : asset.meshopt) {
    Json row{{"bytes", mesh.with_zstd.size()}, {"packed", mesh.packed.size()},    {"indices", mesh.index_count},
             {"points", mesh.point_count},     {"index_bytes", mesh.index_bytes}, {"streams", Json::array()}};
    for (const MeshoptStream& stream : mesh.streams)
      row["streams"].push_back({stream.stride, static_cast<int>(stream.filter), stream.encoded_bytes});
    head["meshes"].push_back(std::move(row));
    all.insert(all.end(), mesh.with_zstd.begin(), mesh.with_zstd.end());
  }
  return write_sample(path, head, all);
}

Status write_samples(const std::string& path, const AssetPrimitives& asset, const ThreadPool& pool) {
  EncodeDocumentOptions ours, stock;
  stock.storage = Storage::kOneStream;
  for (const auto& [codec, options] : {std::pair("psplit", ours), std::pair("libdraco", stock)}) {
    const auto meshes = encode_asset_primitives(asset, options, pool);
    if (!meshes) return meshes.status();
    if (Status status = write_streams(path + "." + codec, asset, *meshes); !status.ok()) return status;
  }
  return write_meshopt(path + ".meshoptimizer", asset);
}

// `count` meshes of that shape, with seeds of their own.
Expected<AssetPrimitives> generate(ShapeOptions shape, uint32_t count, const ThreadPool& pool) {
  AssetPrimitives all;
  for (uint32_t i = 0; i < count; ++i) {
    shape.seed = i + 1;
    Expected<std::vector<Mesh>> meshes = generate_shape(shape, pool);
    if (!meshes) return meshes.status();
    Expected<AssetPrimitives> one =
        read_asset_primitives(document_from_mesh(std::move(meshes->front())), {}, pool);
    if (!one) return one.status();
    all.faces += one->faces;
    all.jobs.push_back(std::move(one->jobs.at(0)));
    all.meshopt.push_back(std::move(one->meshopt.at(0)));
  }
  return all;
}

Status write_all(const std::string& folder, std::span<char* const> files) {
  const ThreadPool pool;
  struct Built {
    const char* name;
    ShapeOptions shape;
    uint32_t count;
  };
  for (const auto& [name, shape, count] :
       {Built{"a mesh of 2,000 faces", {Shape::kBlob, 2000, 1, true, true}, 1},
        Built{"a mesh of 300,000 faces", {Shape::kBlob, 300000, 1, true, true}, 1},
        Built{"1,000 meshes of 200 faces", {Shape::kTerrain, 200, 1, true, true}, 1000}}) {
    const Expected<AssetPrimitives> asset = generate(shape, count, pool);
    if (!asset) return asset.status();
    if (Status status = write_samples(folder + "/" + name, *asset, pool); !status.ok()) return status;
  }
  for (const char* file : files) {
    const Expected<Asset> asset = read_asset(file, describe_draco_stream);
    if (!asset) return asset.status();
    const Expected<AssetPrimitives> primitives = read_asset_primitives(asset->document, {}, pool);
    if (!primitives) return primitives.status().at({.file = file});
    const std::string name = std::filesystem::path(file).stem().string();
    if (Status status = write_samples(folder + "/" + name, *primitives, pool); !status.ok()) return status;
  }
  return {};
}

// ---- The process that decodes ----

struct Sample {
  uint64_t faces = 0;
  std::vector<EncodedMesh> meshes;
  std::vector<MeshoptMesh> meshopt;
};

Sample read_sample(const std::string& path) {
  Json head;
  std::ifstream(path + ".json") >> head;
  std::ifstream file(path + ".bin", std::ios::binary);
  file.exceptions(std::ios::failbit | std::ios::badbit);  // a sample that ends early is not to be timed
  Sample sample;
  sample.faces = head.at("faces");
  for (const Json& row : head.at("meshes")) {
    std::vector<uint8_t> bytes(row.at("bytes").get<size_t>());
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (row.contains("requests")) {
      EncodedMesh& mesh = sample.meshes.emplace_back();
      EncodedPiece& piece = mesh.pieces.emplace_back();
      piece.bytes = std::move(bytes);
      piece.is_container = row.at("container");
      for (const Json& request : row.at("requests"))
        mesh.requests.push_back({request.at("semantic"), request.at("id"),
                                 static_cast<ComponentType>(request.at("type").get<int>()),
                                 request.at("components"), request.at("normalized")});
      continue;
    }
    MeshoptMesh& mesh = sample.meshopt.emplace_back();
    mesh.with_zstd = std::move(bytes);
    mesh.packed.resize(row.at("packed").get<size_t>());
    mesh.index_count = row.at("indices");
    mesh.point_count = row.at("points");
    mesh.index_bytes = row.at("index_bytes");
    for (const Json& stream : row.at("streams"))
      mesh.streams.push_back({stream.at(0), static_cast<MeshoptFilter>(stream.at(1).get<int>()), stream.at(2)});
  }
  return sample;
}

long page_faults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

Status measure(const std::string& codec, int threads, const std::string& path) {
  const Sample sample = read_sample(path + "." + codec);
  std::unique_ptr<ThreadPool> pool;
  Status status;
  const auto decode_ms = [&] {
    return elapsed_ms([&] {
      if (!pool) pool = std::make_unique<ThreadPool>(threads);
      status = codec == "meshoptimizer"
                   ? decode_meshopt_all(sample.meshopt, MeshoptForm::kZstd)
                   : decode_as_loader(sample.meshes, codec == "psplit" ? cpu_backend() : draco_backend(), *pool)
                         .status();
    });
  };
  const long before = page_faults();
  const double first_ms = decode_ms();
  const long faults = page_faults() - before;
  if (!status.ok()) return status;
  const double second_ms = decode_ms();
  double warm_ms = second_ms;
  for (int i = 0; i < kWarmRounds; ++i) warm_ms = std::min(warm_ms, decode_ms());
  std::vector<double> woken_ms;
  for (int i = 0; i < kWakes; ++i) {
    std::this_thread::sleep_for(kSleep);
    woken_ms.push_back(decode_ms());
  }
  if (!status.ok()) return status;
  const Json line{{"faces", sample.faces},
                  {"meshes", sample.meshes.size() + sample.meshopt.size()},
                  {"first_ms", first_ms},
                  {"faults", faults},
                  {"second_ms", second_ms},
                  {"warm_ms", warm_ms},
                  {"woken_ms", summarize_samples(woken_ms).median_ms},
                  {"meshoptimizer", meshopt_version()},
                  {"codec", meshopt_codec_version()}};
  std::printf("%s\n", line.dump().c_str());
  return {};
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  psplit::Status status;
  if (first == "--write" && argc > 2)
    status = psplit::write_all(argv[2], std::span(argv + 3, static_cast<size_t>(argc) - 3));
  else if (argc == 4 && (first == "psplit" || first == "libdraco" || first == "meshoptimizer"))
    status = psplit::measure(first, std::atoi(argv[2]), argv[3]);
  else
    return std::fprintf(stderr,
                        "usage: first_decode --write FOLDER FILE... | first_decode CODEC THREADS SAMPLE\n"),
           1;
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.to_string().c_str());
  return 1;
}
