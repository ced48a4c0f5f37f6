// Compares the CUDA decoder on this machine's GPU with libdraco on one thread and with psplit's CPU backend on
// all threads: first the bits, then the times. Prints a table, and writes JSON to the file that --json names.
//
//   gpu_benchmark [--quick] [--json FILE] [--only FACES/PATCH_FACES[/condensed]]
//
// With --only, one mesh of positions is decoded, and neither libdraco nor scenes are measured: for a profiler.
#include <cuda_runtime_api.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bench/samples.h"
#include "psplit/cuda.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void check(cudaError_t error) {
  if (error != cudaSuccess) give_up(runtime_failure(cudaGetErrorString(error)));
}
template <typename T>
T check(Expected<T> expected) {
  if (!expected) give_up(expected.status());
  return std::move(*expected);
}
void check(const Status& status) {
  if (!status.ok()) give_up(status);
}

struct DeviceMemory {
  void* data = nullptr;
  explicit DeviceMemory(size_t bytes) { check(cudaMalloc(&data, bytes)); }
  ~DeviceMemory() { (void)cudaFree(data); }
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;
};

// Bytes per second, read and written, of a copy on the device.
double copy_bandwidth() {
  constexpr size_t kBytes = size_t{1} << 30;
  const DeviceMemory from(kBytes), to(kBytes);
  cudaEvent_t start, end;
  check(cudaEventCreate(&start));
  check(cudaEventCreate(&end));
  std::vector<double> times;
  for (int i = 0; i < 12; ++i) {
    check(cudaEventRecord(start));
    check(cudaMemcpyAsync(to.data, from.data, kBytes, cudaMemcpyDeviceToDevice));
    check(cudaEventRecord(end));
    check(cudaEventSynchronize(end));
    float ms = 0;
    check(cudaEventElapsedTime(&ms, start, end));
    times.push_back(ms);
  }
  return 2.0 * kBytes / (median(times) * 1e-3);
}

// Results for a mesh as one stream.
double stock_ms(const Mesh& mesh, int speed) {
  const Sample whole = encode_sample(mesh, 1, speed);
  const PatchContainer container = check(open_container(whole.container));
  const auto start = Clock::now();
  (void)check(draco_backend().decode(container.alone(0), whole.requests, ThreadPool(1)));
  return ms_since(start);
}

// Measures one mesh. libdraco is left out if `stock` is 0. The function is long because the decoder, its
// buffers and the bits that the CPU must reproduce belong to one sample.
Json measure(const Mesh& mesh, uint32_t patch_faces, bool condensed, int speed, double stock,
             double bandwidth) {
  const auto patch_count = static_cast<uint32_t>(mesh.faces.size() / patch_faces);
  const Sample sample = encode_sample(mesh, std::max(patch_count, 1u), speed, condensed);
  const PatchContainer container = check(open_container(sample.container));
  // The indices and each attribute have memory of their own.
  size_t output_bytes = size_t{12} * container.face_count();
  const DeviceMemory indices(output_bytes);
  std::vector<std::unique_ptr<DeviceMemory>> values;
  CudaPrimitive primitive{.container = &container, .indices = indices.data};
  for (const AttributeRequest& request : sample.requests) {
    const auto stride =
        static_cast<uint32_t>(component_bytes(request.component_type)) * request.component_count;
    const size_t bytes = size_t{container.point_count()} * stride;
    output_bytes += bytes;
    values.push_back(std::make_unique<DeviceMemory>(bytes));
    primitive.attributes.push_back(
        {request.unique_id, request.component_type, request.component_count, values.back()->data, stride});
  }

  CudaDecoder decoder = check(CudaDecoder::create());
  decoder.measure(true);
  std::map<std::string, std::vector<double>> stages;
  std::vector<double> kernels, with_upload, with_download;
  const ThreadPool pool;
  std::vector<std::byte> downloaded(output_bytes);
  constexpr int kWarm = 2, kRuns = 9;
  for (int run = 0; run < kWarm + kRuns; ++run) {
    const auto start = Clock::now();
    check(decoder.start({&primitive, 1}, &pool));
    check(decoder.finish());
    const double decoded = ms_since(start);
    size_t at = size_t{12} * container.face_count();
    check(cudaMemcpy(downloaded.data(), indices.data, at, cudaMemcpyDeviceToHost));
    for (size_t i = 0; i < values.size(); ++i) {
      const size_t bytes = size_t{container.point_count()} * primitive.attributes[i].stride;
      check(cudaMemcpy(downloaded.data() + at, values[i]->data, bytes, cudaMemcpyDeviceToHost));
      at += bytes;
    }
    const double copied = ms_since(start);
    const auto times = decoder.take_times();
    if (run < kWarm) continue;
    double total = 0;
    for (const auto& [stage, ms] : times) {
      stages[stage].push_back(ms);
      if (stage != "upload" && stage != "faults") total += ms;
    }
    kernels.push_back(total);
    with_upload.push_back(decoded);
    with_download.push_back(copied);
  }

  std::vector<double> cpu_times;
  for (int run = 0; run < 3; ++run) {
    const auto start = Clock::now();
    const Mesh decoded = check(cpu_backend().decode(container, sample.requests, pool));
    cpu_times.push_back(ms_since(start));
    if (run > 0) continue;
    const std::byte* at = downloaded.data();
    bool same = std::memcmp(at, decoded.faces.data(), 12 * decoded.faces.size()) == 0;
    at += 12 * decoded.faces.size();
    for (const Attribute& attribute : decoded.attributes) {
      same = same && std::memcmp(at, attribute.values.data(), attribute.values.size()) == 0;
      at += attribute.values.size();
    }
    if (!same) give_up({StatusCode::kDiffers, "the GPU's result differs from the CPU's"});
  }
  const auto start = Clock::now();
  if (stock > 0) (void)check(draco_backend().decode(container, sample.requests, ThreadPool(1)));
  const double draco = ms_since(start);

  const double ms = median(kernels);
  const auto faces = static_cast<double>(container.face_count());
  Json row{
      {"faces", container.face_count()},
      {"attributes", sample.requests.size()},
      {"speed", speed},
      {"patch_faces", patch_faces},
      {"condensed", condensed},
      {"patches", container.patch_count()},
      {"bytes", sample.container.size()},
      {"kernels_ms", ms},
      {"upload_ms", median(with_upload)},
      {"download_ms", median(with_download)},
      {"cpu_threads", pool.thread_count()},
      {"cpu_ms", median(cpu_times)},
      {"draco_patches_ms", draco},
      {"stock_ms", stock},
      {"triangles_per_s", faces / (ms * 1e-3)},
      {"output_bytes_per_s", static_cast<double>(output_bytes) / (ms * 1e-3)},
      {"times_stock", stock / ms},
      {"times_stock_with_upload", stock / median(with_upload)},
      {"times_output_at_copy_bandwidth", ms * 1e-3 * bandwidth / (2.0 * static_cast<double>(output_bytes))},
      {"stages_ms", Json::object()}};
  for (const auto& [stage, times] : stages) row["stages_ms"][stage] = median(times);
  std::printf("%9u %5zu %5d %7u %9s %10.3f %10.3f %10.3f %9.1f %9.1f %8.2f %7.1f %7.0fx %7.0fx %7.1fx\n",
              container.face_count(), sample.requests.size(), speed, container.patch_count(),
              condensed ? "condensed" : "draco", ms, median(with_upload), median(with_download),
              median(cpu_times), stock, faces / (ms * 1e6), static_cast<double>(output_bytes) / (ms * 1e6),
              stock / ms, stock / median(with_upload), row["times_output_at_copy_bandwidth"].get<double>());
  for (const auto& [stage, times] : stages)
    std::printf("            %-14s %8.3f ms\n", stage.c_str(), median(times));
  std::fflush(stdout);
  return row;
}

// A scene of many small primitives in one batch, each in `patch_count` patches, or as stock Draco if that is 1.
// Times whole calls, also of libdraco on one thread and of the CPU backend on all threads.
Json measure_scene(size_t primitive_count, uint64_t faces, uint32_t patch_count) {
  constexpr size_t kDifferent = 16;
  std::vector<Sample> samples;
  std::vector<PatchContainer> containers;
  for (uint64_t seed = 1; seed <= kDifferent; ++seed)
    samples.push_back(
        encode_sample(check(generate_shape({Shape::kBlob, faces, seed, false, false}, ThreadPool())).front(),
                      patch_count, 5));
  std::vector<DecodeTask> tasks;
  for (const Sample& sample : samples) containers.push_back(check(open_container(sample.container)));
  if (patch_count == 1)
    for (size_t n = 0; n < samples.size(); ++n) containers[n] = open_stream(containers[n].streams[0]);
  uint64_t total_faces = 0;
  for (size_t i = 0; i < primitive_count; ++i) {
    const size_t n = i % kDifferent;
    tasks.push_back({&containers[n], samples[n].requests});
    total_faces += containers[n].face_count();
  }
  const ThreadPool pool, one(1);
  const DecodeBackend cuda = cuda_backend();
  const auto timed = [&](const DecodeBackend& backend, const ThreadPool& threads) {
    std::vector<double> times;
    for (int round = 0; round < 4; ++round) {
      const auto start = Clock::now();
      for (const Expected<Mesh>& mesh : backend.decode(tasks, threads, {})) check(mesh.status());
      if (round > 0) times.push_back(ms_since(start));
    }
    return median(times);
  };
  const double gpu = timed(cuda, pool), cpu = timed(cpu_backend(), pool), draco = timed(draco_backend(), one);
  std::printf(
      "%zu primitives, %llu faces, %s: CUDA to the host's memory %.1f ms, CPU %.1f ms, libdraco %.1f ms\n",
      primitive_count, static_cast<unsigned long long>(total_faces),
      patch_count == 1 ? "stock streams" : "patches", gpu, cpu, draco);
  return {{"primitives", primitive_count},
          {"faces", total_faces},
          {"patches", patch_count},
          {"host_ms", gpu},
          {"cpu_ms", cpu},
          {"draco_ms", draco},
          {"cpu_threads", pool.thread_count()}};
}

struct Batch {
  uint64_t faces = 0;
  bool all_attributes = false;
  int speed = 5;
  std::vector<uint32_t> patch_faces;
  bool plain = true, condensed = true;
};

int run(bool quick, const char* json_path, const Batch* only) {
  std::string why;
  if (!cuda_available(&why)) {
    std::printf("skipped: %s\n", why.c_str());
    return 0;
  }
  const auto start = Clock::now();
  check(cuda_warm_up());
  const double first_use = ms_since(start);
  cudaDeviceProp device;
  check(cudaGetDeviceProperties(&device, 0));
  const double bandwidth = copy_bandwidth();
  std::printf("%s, %d multiprocessors, copies at %.0f GB/s (read and written), first use %.0f ms\n\n",
              device.name, device.multiProcessorCount, bandwidth * 1e-9, first_use);
  std::printf(
      "    faces attrs speed patches   streams kernels ms  +upload ms +download ms  cpu ms  stock ms   Gtri/s  "
      "  GB/s "
      "x stock +upload x floor\n");
  Json result{{"device", device.name},
              {"copy_bytes_per_s", bandwidth},
              {"first_use_ms", first_use},
              {"rows", Json::array()}};
  std::vector<Batch> batches{{1'000'000, false, 5, {440, 1200, 4800}},
                             {10'000'000, false, 5, {440, 1200, 4800}},
                             {4'000'000, true, 5, {440, 1200}}};
  if (!quick) {
    batches.push_back({28'000'000, false, 5, {440, 1200}, true, false});
    for (const int speed : {0, 10}) batches.push_back({10'000'000, false, speed, {1200}, true, false});
    for (const int speed : {0, 10}) batches.push_back({4'000'000, true, speed, {1200}, true, false});
  }
  // A file has the number of faces that it has.
  const bool is_file = std::getenv("PSPLIT_BENCH_MESH") != nullptr;
  if (is_file) batches = {{0, false, 5, {440, 1200, 4800}}, {0, true, 5, {440, 1200, 4800}}};
  if (only != nullptr) batches = {*only};
  for (const Batch& batch : batches) {
    const Mesh mesh = bench_mesh(batch.faces, batch.all_attributes);
    const double stock = only == nullptr ? stock_ms(mesh, batch.speed) : 0;
    for (const uint32_t patch_faces : batch.patch_faces)
      for (const bool condensed : {false, true})
        if (condensed ? batch.condensed : batch.plain)
          result["rows"].push_back(measure(mesh, patch_faces, condensed, batch.speed, stock, bandwidth));
  }
  if (only == nullptr && !is_file)
    for (const uint32_t patch_count : {1, 4})
      result["scenes"].push_back(measure_scene(4000, 2000, patch_count));
  if (json_path != nullptr) {
    std::FILE* file = std::fopen(json_path, "w");
    if (file == nullptr) give_up(io_failure("cannot be written", {.file = json_path}));
    std::fprintf(file, "%s\n", result.dump(2).c_str());
    std::fclose(file);
  }
  return 0;
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  bool quick = false;
  const char* json_path = nullptr;
  psplit::Batch only;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0) quick = true;
    if (i + 1 == argc) break;
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[++i];
    if (std::strcmp(argv[i], "--only") == 0) {
      const std::string row = argv[++i];
      const size_t slash = row.find('/');
      if (slash == std::string::npos) psplit::give_up({psplit::StatusCode::kUsage, "--only FACES/PATCH_FACES"});
      only.faces = std::strtoull(row.c_str(), nullptr, 10);
      only.patch_faces = {static_cast<uint32_t>(std::strtoul(row.c_str() + slash + 1, nullptr, 10))};
      only.condensed = row.ends_with("/condensed");
      only.plain = !only.condensed;
    }
  }
  return psplit::run(quick, json_path, only.patch_faces.empty() ? nullptr : &only);
}
