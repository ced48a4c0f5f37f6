// gltf-psplit compare: bytes and milliseconds of patches, of stock Draco and of meshoptimizer, in one table. Of
// two assets, whether they hold the same meshes (sameness.h).
#include <CLI/CLI.hpp>
#include <memory>

#include "decoder_cuda/psplit_cuda.h"
#include "tools/gltf_psplit/commands.h"
#include "tools/gltf_psplit/comparison.h"
#include "tools/gltf_psplit/progress.h"
#include "tools/gltf_psplit/sameness.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, format = "text";
  BackendChoice backend;
  ComparisonOptions options;
  SamenessOptions sameness;
};

constexpr uint64_t kDefaultPatchFaces[] = {19200, 4800, 1200};

// The triangle primitives of an uncompressed asset, or of a .drc file, of which there may be no original.
Expected<std::vector<Mesh>> read_meshes(const Document& document, const Session& session) {
  std::vector<PrimitiveId> ids;
  for (const PrimitiveId id : all_primitives(document)) {
    const Place place{.mesh = static_cast<int64_t>(id.mesh), .primitive = static_cast<int64_t>(id.primitive)};
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status().at(place);
    if (kind->storage != PrimitiveStorage::kPlain && !document.from_draco)
      return unsupported(
          "is compressed already: decode it first, and compare from the original if there is one", place);
    if (!kind->triangles) {
      session.log.note(describe_place(id.mesh, id.primitive) + " is left out: no triangles");
      continue;
    }
    ids.push_back(id);
  }
  std::vector<Mesh> meshes;
  for (Expected<Mesh>& mesh : read_primitives(document, ids, find_backend({}), session.pool)) {
    if (!mesh) return mesh.status();
    if (!mesh->faces.empty()) meshes.push_back(std::move(*mesh));
  }
  if (meshes.empty()) return unsupported("holds no triangles");
  return meshes;
}

std::vector<uint64_t> default_patch_counts(uint64_t faces) {
  std::vector<uint64_t> counts;
  for (const uint64_t patch_faces : kDefaultPatchFaces) {
    const uint64_t count = std::max<uint64_t>(1, (faces + patch_faces / 2) / patch_faces);
    if (counts.empty() || counts.back() != count) counts.push_back(count);
  }
  return counts;
}

Json to_json(const Comparison& comparison) {
  Json result{{"faces", comparison.faces}, {"points", comparison.points}};
  result["stock"] = {{"bytes", comparison.stock.bytes},
                     {"encode_ms", comparison.stock.encode_ms},
                     {"decode_ms", comparison.stock.decode.median_ms},
                     {"decode_min_ms", comparison.stock.decode.min_ms},
                     {"decode_max_ms", comparison.stock.decode.max_ms}};
  result["meshopt"] = {{"bytes", comparison.meshopt.bytes},
                       {"decode_ms", comparison.meshopt.decode.median_ms},
                       {"decode_min_ms", comparison.meshopt.decode.min_ms},
                       {"decode_max_ms", comparison.meshopt.decode.max_ms}};
  result["splits"] = Json::array();
  for (const SplitRow& row : comparison.splits) {
    Json split{{"patches", row.summary.patches},           {"patch_faces", row.mean_patch_faces()},
               {"bytes", row.summary.total_bytes},         {"overhead", row.overhead},
               {"replication", row.summary.replication()}, {"balance", row.summary.balance()},
               {"partition_ms", row.partition_ms},         {"encode_ms", row.encode_ms}};
    split["decode"] = Json::array();
    for (const DecodeRow& decode : row.decode)
      split["decode"].push_back({{"backend", decode.backend},
                                 {"threads", decode.threads},
                                 {"median_ms", decode.timing.median_ms},
                                 {"min_ms", decode.timing.min_ms},
                                 {"max_ms", decode.timing.max_ms},
                                 {"speedup", decode.speedup}});
    result["splits"].push_back(std::move(split));
  }
  return result;
}

std::string to_text(const Comparison& comparison, const Arguments& arguments) {
  const auto per_point = [&](uint64_t bytes) {
    return with_decimals(8 * static_cast<double>(bytes) / static_cast<double>(comparison.points), 2);
  };
  const auto over_stock = [&](uint64_t bytes) {
    return as_percent(static_cast<double>(bytes) / static_cast<double>(comparison.stock.bytes) - 1);
  };
  // Cells of one decoder: name, threads, median, min, max, speed-up, million triangles a second.
  const auto timing_cells = [&](const std::string& decoder, int threads, const Timing& timing) {
    return std::vector<std::string>{
        decoder,
        std::to_string(threads),
        with_decimals(timing.median_ms, 1),
        with_decimals(timing.min_ms, 1),
        with_decimals(timing.max_ms, 1),
        with_decimals(comparison.stock.decode.median_ms / timing.median_ms, 2) + "x",
        with_decimals(static_cast<double>(comparison.faces) / timing.median_ms / 1000, 1)};
  };
  const auto join = [](std::vector<std::string> left, const std::vector<std::string>& right) {
    left.insert(left.end(), right.begin(), right.end());
    return left;
  };

  TextTable table({"codec", "patches", "faces/patch", "bytes", "bits/point", "overhead", "replication",
                   "balance", "partition ms", "encode ms", "decoder", "threads", "decode ms", "min", "max",
                   "speed-up", "Mtri/s"});
  table.add(
      join({"stock Draco", "1", with_separators(comparison.faces), with_separators(comparison.stock.bytes),
            per_point(comparison.stock.bytes), "", "", "", "", with_decimals(comparison.stock.encode_ms, 0)},
           timing_cells("draco", 1, comparison.stock.decode)));
  table.add(join({"meshopt + zstd", "", "", with_separators(comparison.meshopt.bytes),
                  per_point(comparison.meshopt.bytes), over_stock(comparison.meshopt.bytes), "", "", "", ""},
                 timing_cells("meshopt", 1, comparison.meshopt.decode)));
  for (const SplitRow& row : comparison.splits) {
    std::vector<std::string> head{"psplit",
                                  with_separators(row.summary.patches),
                                  with_decimals(row.mean_patch_faces(), 0),
                                  with_separators(row.summary.total_bytes),
                                  per_point(row.summary.total_bytes),
                                  as_percent(row.overhead),
                                  as_share(row.summary.replication()),
                                  with_decimals(row.summary.balance(), 3),
                                  with_decimals(row.partition_ms, 0),
                                  with_decimals(row.encode_ms, 0)};
    for (const DecodeRow& decode : row.decode) {
      table.add(join(head, timing_cells(decode.backend, decode.threads, decode.timing)));
      head.assign(head.size(), "");
    }
  }
  const EncodeDocumentOptions& coding = arguments.options.coding;
  return arguments.input + ": " + counted(comparison.faces, "face") + ", " +
         counted(comparison.points, "point") + "\n\n" + table.to_string() + "\nDraco speed " +
         std::to_string(coding.encode_speed) + ", positions " +
         counted(static_cast<uint64_t>(coding.position_bits), "bit") + "; decode: median of " +
         counted(static_cast<uint64_t>(arguments.options.repeat), "interleaved round") +
         "; stock Draco and meshopt use one thread; speed-up over stock Draco\n";
}

Status run_compare(Arguments arguments, const Session& session) {
  Expected<std::vector<Mesh>> meshes = [&]() -> Expected<std::vector<Mesh>> {
    const ProgressBar bar("reading", session.log);
    const Expected<Document> document = read_input(arguments.input);
    if (!document) return document.status();
    return read_meshes(*document, session);
  }();
  if (!meshes) return meshes.status().at({.file = arguments.input});
  ComparisonOptions& options = arguments.options;
  if (options.patch_counts.empty()) {
    uint64_t faces = 0;
    for (const Mesh& mesh : *meshes) faces += mesh.faces.size();
    options.patch_counts = default_patch_counts(faces);
  }
  options.thread_counts = {1};
  if (session.pool.thread_count() > 1) options.thread_counts.push_back(session.pool.thread_count());

  // By default every decoder there is.
  std::vector<DecodeBackend> backends;
  for (const std::string name : {"cuda", "cpu", "draco"}) {
    const bool is_there = name != "cuda" || cuda_available(nullptr);
    if (arguments.backend.name == name || (arguments.backend.name == "auto" && is_there))
      backends.push_back(find_backend({name, arguments.backend.gpu_memory}));
  }
  const Expected<Comparison> comparison = [&] {
    ProgressBar bar("comparing", session.log);
    return compare_codecs(*meshes, options, backends, session.pool, bar.callback());
  }();
  if (!comparison) return comparison.status().at({.file = arguments.input});
  return write_text(
      "-", arguments.format == "json" ? report_text(to_json(*comparison)) : to_text(*comparison, arguments));
}

}  // namespace

void add_compare_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand(
      "compare",
      "Measure patches, stock Draco and meshoptimizer on the same meshes; or, of two assets, "
      "tell whether they hold the same meshes");
  command
      .add_option("IN", arguments->input,
                  "An uncompressed .gltf or .glb file, or .ply, .obj, .stl, .drc; - is a GLB or Draco on stdin")
      ->required();
  add_sameness_options(command, arguments->sameness);
  command
      .add_option("--patches", arguments->options.patch_counts,
                  "Patch counts, over all primitives; by default those of 19200, 4800 and 1200 faces a patch")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}))
      ->type_name("A,B,C");
  command
      .add_option("--repeat", arguments->options.repeat, "Timed rounds; each decodes with every decoder once")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str()
      ->type_name("N");
  add_format_option(command, arguments->format);
  add_backend_options(command, arguments->backend);
  add_coding_options(command, arguments->options.coding);
  // What is for measuring has nothing to say of two assets.
  for (const char* name :
       {"--patches", "--repeat", "--encode-speed", "--quantize-position", "--quantize-normal",
        "--quantize-texcoord", "--quantize-color", "--quantize-generic"})
    command.get_option("B")->excludes(command.get_option(name));
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) {
      if (arguments->sameness.second.empty()) return run_compare(*arguments, session);
      return run_sameness(arguments->input, arguments->sameness, arguments->format, arguments->backend,
                          session);
    };
  });
}

}  // namespace psplit
