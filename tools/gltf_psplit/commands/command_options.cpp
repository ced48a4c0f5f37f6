#include <CLI/CLI.hpp>
#include <filesystem>
#include <mutex>
#include <optional>

#include "decoder_cuda/psplit_cuda.h"
#include "encoder/draco/draco_backend.h"
#include "gltf_ext/files/files.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "src/container/container.h"
#include "src/cpu/cpu_backend.h"
#include "tools/gltf_psplit/commands/commands.h"

namespace psplit {
namespace {

// CUDA where there is a device and enough for it to do, the CPU for what that does not take, and libdraco for
// what both do not: streams of versions before 2.2. A device is looked for when first there is enough to do.
DecodeBackend fastest_backend(uint64_t gpu_memory) {
  struct Cuda {
    std::once_flag looked_for;
    std::optional<DecodeBackend> backend;
  };
  return {"auto", [cuda = std::make_shared<Cuda>(), gpu_memory, cpu = cpu_backend(), draco = draco_backend()](
                      std::span<const DecodeTask> tasks, const ThreadPool& pool, const Progress& progress) {
            std::vector<const DecodeBackend*> backends{&cpu, &draco};
            if (is_worth_a_gpu(tasks)) {
              std::call_once(cuda->looked_for, [&] {
                if (cuda_available(nullptr)) cuda->backend = cuda_backend(gpu_memory);
              });
              if (cuda->backend) backends.insert(backends.begin(), &*cuda->backend);
            }
            std::vector<Expected<Mesh>> meshes = backends[0]->decode(tasks, pool, progress);
            for (size_t next = 1; next < backends.size(); ++next) {
              std::vector<size_t> left;
              std::vector<DecodeTask> tasks_left;
              for (size_t i = 0; i < tasks.size(); ++i) {
                // A device may run out of memory where the host does not.
                const StatusCode code = meshes[i].status().code();
                if (code != StatusCode::kUnsupported && code != StatusCode::kRuntimeFailure) continue;
                left.push_back(i);
                tasks_left.push_back(tasks[i]);
              }
              if (left.empty()) break;
              std::vector<Expected<Mesh>> decoded = backends[next]->decode(tasks_left, pool, {});
              for (size_t n = 0; n < left.size(); ++n) meshes[left[n]] = std::move(decoded[n]);
            }
            return meshes;
          }};
}

}  // namespace

// Not measured yet: a device decodes a stream more slowly than a core does, and starting it takes longer than
// some hundred kilobytes take a CPU.
bool is_worth_a_gpu(std::span<const DecodeTask> tasks) {
  constexpr size_t kFewestStreams = 64, kFewestBytes = size_t{256} << 10;
  size_t bytes = 0, streams = 0;
  for (const DecodeTask& task : tasks) bytes += task.bytes.size();
  if (bytes < kFewestBytes) return false;
  for (size_t i = 0; i < tasks.size() && streams < kFewestStreams; ++i) {
    if (tasks[i].is_stream)
      ++streams;
    else if (const Expected<Container> container = parse_container(tasks[i].bytes))
      streams += container->entries.size();
  }
  return streams >= kFewestStreams;
}

void add_coding_options(CLI::App& command, EncodeDocumentOptions& options) {
  const auto add_bits = [&](const char* name, int& bits, int least, const char* what) {
    command.add_option(name, bits, std::string("Bits of each component of ") + what)
        ->check(CLI::Range(least, 30))
        ->capture_default_str()
        ->type_name("BITS");
  };
  add_bits("--quantize-position", options.position_bits, 1, "positions");
  add_bits("--quantize-normal", options.normal_bits, 2, "normals, on an octahedron");
  add_bits("--quantize-texcoord", options.texcoord_bits, 1, "texture coordinates");
  add_bits("--quantize-color", options.color_bits, 1, "colours stored as floats");
  add_bits("--quantize-generic", options.generic_bits, 1, "all other floats");
  CLI::Option* lossless = command.add_flag("--lossless", options.lossless, "Keep every float exactly as it is");
  for (const char* name : {"--quantize-position", "--quantize-normal", "--quantize-texcoord",
                           "--quantize-color", "--quantize-generic"})
    lossless->excludes(command.get_option(name));
  command.add_option("--encode-speed", options.encode_speed, "Draco's speed: 0 is smallest, 10 is fastest")
      ->check(CLI::Range(0, 10))
      ->capture_default_str()
      ->type_name("SPEED");
}

void add_partition_options(CLI::App& command, EncodeDocumentOptions& options) {
  const auto cut_as_the_paper = [&options](const std::string& distance) {
    options.method = PartitionMethod::kPaper;
    options.distance = distance == "geodesic" ? PathDistance::kGeodesic : PathDistance::kDijkstra;
  };
  command
      .add_option_function<std::string>(
          "--distance", cut_as_the_paper,
          "Cut by the paper's own method, around farthest points, with this distance between faces: "
          "dijkstra, along edges, or geodesic, across faces. By default in levels, which is faster")
      ->check(CLI::IsMember({"dijkstra", "geodesic"}))
      ->type_name("NAME");
  command.add_flag_callback(
      "--no-refine", [&options] { options.refine = false; },
      "Leave borders between patches as jagged as clustering makes them: to see what refinement gains");
}

void add_backend_options(CLI::App& command, BackendChoice& choice) {
  command
      .add_option("--backend", choice.name, "Decoder: auto takes the fastest there is; draco is stock libdraco")
      ->check(CLI::IsMember({"auto", "cuda", "cpu", "draco"}))
      ->capture_default_str()
      ->type_name("NAME");
  command
      .add_option(
          "--gpu-memory", choice.gpu_memory,
          "What the CUDA decoder may take of its device, as in 512MB or 4GB; more comes in parts, with the "
          "same result. By default what is free")
      ->check(
          [](const std::string& text) { return std::string(text.starts_with('-') ? "must be positive" : ""); })
      ->transform(CLI::AsSizeValue(false))
      ->type_name("SIZE");
}

void add_output_option(CLI::App& command, std::string& path) {
  command.add_option("-o,--output,OUT", path, "A .glb or .gltf file; - is a GLB on stdout")
      ->required()
      ->type_name("FILE");
}

void add_text_output_option(CLI::App& command, std::string& path) {
  command.add_option("-o,--output", path, "Where the result goes; - is stdout")
      ->capture_default_str()
      ->type_name("FILE");
}

void add_format_option(CLI::App& command, std::string& name, const std::vector<std::string>& forms) {
  command.add_option("--format", name, "Form of the result")
      ->check(CLI::IsMember(forms))
      ->capture_default_str()
      ->type_name("FORM");
}

DecodeBackend find_backend(const BackendChoice& choice) {
  if (choice.name == "cuda") return cuda_backend(choice.gpu_memory);
  if (choice.name == "cpu") return cpu_backend();
  return choice.name == "draco" ? draco_backend() : fastest_backend(choice.gpu_memory);
}

DescribeStream find_describer(const std::string& name) {
  if (name == "cpu") return describe_stream;
  if (name == "draco") return describe_draco_stream;
  return [](std::span<const uint8_t> stream) {
    Expected<StreamDescription> description = describe_stream(stream);
    if (description || description.status().code() != StatusCode::kUnsupported) return description;
    return describe_draco_stream(stream);
  };
}

Expected<Document> read_input(const std::string& path, const Log& log, const std::string& backend) {
  Expected<Asset> asset = read_asset(path, find_describer(backend));
  if (!asset) return asset.status();
  for (const std::string& warning : asset->warnings) log.warning(path + ": " + warning);
  return std::move(asset->document);
}

void log_reports(std::span<const PrimitiveReport> reports, const Log& log, const std::string& prefix) {
  for (const PrimitiveReport& report : reports) {
    const std::string place = prefix + describe_place(report.id.mesh, report.id.primitive);
    if (!report.skipped.empty()) log.note(place + " is left as it is: " + report.skipped);
    for (const std::string& warning : report.warnings) log.warning(place + ": " + warning);
  }
}

Status write_text(const std::string& path, const std::string& text) {
  return write_file(path, {{reinterpret_cast<const uint8_t*>(text.data()), text.size()}});
}

std::string report_text(const Json& report) {
  return report.dump(2, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) + "\n";
}

}  // namespace psplit
