#include "tools/gltf_psplit/options/encode_options.h"

#include <CLI/CLI.hpp>

#include "gltf_ext/json/json.h"
#include "src/container/container.h"
#include "tools/gltf_psplit/options/coding_options.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/gpus.h"

namespace psplit {
namespace {

// Work for four threads, at less than a third of what 16 cost.
constexpr uint64_t kMostPatchesForSize = 4;
// Patches of 440 faces take more than a third more bytes than one stream already (docs/benchmarks.md).
constexpr uint64_t kLeastPatchFaces = 440;

// Nothing of the machine counts: the same command writes the same bytes everywhere.
void apply_profile(EncodeArguments& arguments) {
  EncodeDocumentOptions& options = arguments.options;
  if (arguments.profile == "size") options.most_patches = kMostPatchesForSize;
  if (arguments.profile != "speed") return;
  if (arguments.gpu.empty()) {
    options.patch_faces = kSpeedPatchFaces;
    return;
  }
  options.patches = patches_in_flight(*multiprocessors(arguments.gpu));
  options.least_patch_faces = kLeastPatchFaces;
}

}  // namespace

std::function<void()> add_encode_options(CLI::App& command, EncodeArguments& arguments) {
  EncodeDocumentOptions& options = arguments.options;
  CLI::Option* patches =
      add_count_option(command, "--patches", options.patches, "Patches of all primitives together");
  CLI::Option* patch_faces =
      add_count_option(command, "--patch-faces", options.patch_faces, "Faces of a patch, about")
          ->excludes(patches);
  add_count_option(command, "--min-faces", options.min_faces,
                   "Primitives of fewer faces stay whole; by default " + std::to_string(kMinFaces) +
                       ", or none with --patches or --patch-faces");
  command.add_flag("--always-patches", options.always_patches,
                   "Use PSPLIT_mesh_draco_patches for primitives that stay whole too, not "
                   "KHR_draco_mesh_compression");
  CLI::Option* profile =
      command
          .add_option("--profile", arguments.profile,
                      "balanced, the default: about 2 % over one Draco stream, 2 to 16 patches and above that "
                      "patches of 30000 faces; size: 4 patches of a primitive at most; speed: patches of 4800 "
                      "faces, or as many as the GPU of --gpu decodes at once. --patches and --patch-faces win "
                      "over it")
          ->check(CLI::IsMember({"speed", "balanced", "size"}))
          ->type_name("NAME");
  command
      .add_option("--gpu", arguments.gpu,
                  "The GPU of --profile speed, by name or by its number of multiprocessors")
      ->check([](const std::string& gpu) {
        return multiprocessors(gpu) ? std::string()
                                    : gpu + " is not known: " + known_gpus() + " are, or a number";
      })
      ->needs(profile)
      ->type_name("GPU");
  add_partition_options(command, options);
  add_coding_options(command, options);
  command
      .add_option("--quantization-volume", arguments.volume,
                  "What shares one quantization grid: primitive, mesh or scene")
      ->check(CLI::IsMember({"primitive", "mesh", "scene"}))
      ->capture_default_str()
      ->type_name("WHAT");
  command.get_option("--lossless")->excludes("--quantization-volume");
  command.add_flag("--keep-degenerate", options.keep_degenerate,
                   "Keep faces that repeat an index, which draw nothing");
  command.add_flag("--keep-unused", options.keep_unused, "Keep points that no face uses");
  command.add_flag("--keep-duplicates", options.keep_duplicates,
                   "Keep points that are equal in everything apart");
  command
      .add_option("--fallback", arguments.fallback,
                  "For loaders without the extension: none, or uncompressed geometry beside the patches")
      ->check(CLI::IsMember({"none", "uncompressed"}))
      ->capture_default_str()
      ->type_name("KIND");
  command
      .add_option(
          "--compat", arguments.compat,
          "khr: each patch becomes a primitive of its own in KHR_draco_mesh_compression, which any loader "
          "opens today; points on borders are stored in each, and not joined again. By default 8 patches of "
          "a primitive at most: each is a draw call")
      ->check(CLI::IsMember({"none", "khr"}))
      ->capture_default_str()
      ->type_name("KIND");
  command.add_flag("--no-verify", arguments.no_verify,
                   "Do not decode the result and compare it with the input");
  return [&arguments, patches, patch_faces] {
    if (patches->empty() && patch_faces->empty()) apply_profile(arguments);
    EncodeDocumentOptions& resolved = arguments.options;
    resolved.verify = !arguments.no_verify;
    resolved.volume = arguments.volume == "mesh"    ? QuantizationVolume::kMesh
                      : arguments.volume == "scene" ? QuantizationVolume::kScene
                                                    : QuantizationVolume::kPrimitive;
    resolved.fallback = arguments.fallback == "uncompressed" ? Fallback::kUncompressed : Fallback::kNone;
    resolved.compat = arguments.compat == "khr" ? Compat::kKhr : Compat::kNone;
  };
}

void group_encode_options(CLI::App& command) {
  const std::vector<std::pair<const char*, std::vector<const char*>>> groups = {
      {"Patches",
       {"--patches", "--patch-faces", "--min-faces", "--always-patches", "--profile", "--gpu", "--distance",
        "--no-refine"}},
      {"Precision",
       {"--quantize-position", "--quantize-normal", "--quantize-texcoord", "--quantize-color",
        "--quantize-generic", "--quantization-volume", "--lossless"}},
      {"What is kept", {"--keep-degenerate", "--keep-unused", "--keep-duplicates"}},
      {"What is written", {"--images", "--fallback", "--compat", "--as"}},
  };
  for (const auto& [group, names] : groups)
    for (const char* name : names)
      if (CLI::Option* option = command.get_option_no_throw(name)) option->group(group);
}

std::string describe_options(const EncodeDocumentOptions& options) {
  const EncodeDocumentOptions& o = options;
  return Json{{"format", kContainerVersion},
              {"patches", o.patches},
              {"least_patch_faces", o.least_patch_faces},
              {"patch_faces", o.patch_faces},
              {"most_patches", o.most_patches},
              {"min_faces", o.min_faces},
              {"always_patches", o.always_patches},
              {"bits", {o.position_bits, o.normal_bits, o.texcoord_bits, o.color_bits, o.generic_bits}},
              {"volume", static_cast<int>(o.volume)},
              {"refine", o.refine},
              {"method", static_cast<int>(o.method)},
              {"distance", static_cast<int>(o.distance)},
              {"encode_speed", o.encode_speed},
              {"lossless", o.lossless},
              {"keep_degenerate", o.keep_degenerate},
              {"keep_unused", o.keep_unused},
              {"keep_duplicates", o.keep_duplicates},
              {"fallback", static_cast<int>(o.fallback)},
              {"compat", static_cast<int>(o.compat)},
              {"verify", o.verify}}
      .dump();
}

}  // namespace psplit
