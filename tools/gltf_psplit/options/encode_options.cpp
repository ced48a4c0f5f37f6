#include "tools/gltf_psplit/options/encode_options.h"

#include <CLI/CLI.hpp>
#include <string_view>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/json/json.h"
#include "src/container/patch_container.h"
#include "tools/gltf_psplit/options/coding_options.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/gpus.h"

namespace psplit {
namespace {

// Four patches keep four threads busy, at less than a third of the cost of 16 patches.
constexpr uint64_t kMostPatchesForSize = 4;
// Patches of 440 faces already take over a third more bytes than one stream (docs/benchmarks.md).
constexpr uint64_t kLeastPatchFaces = 440;

// A profile does not depend on the machine: the same command writes the same bytes everywhere.
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

void add_profile_options(CLI::App& command, EncodeArguments& arguments) {
  CLI::Option* profile =
      command
          .add_option(
              "--profile", arguments.profile,
              "balanced, the default: about 2 % larger than one Draco stream; 2 to 16 patches, and patches of "
              "30000 faces for larger primitives. size: at most 4 patches of a primitive, and with --condense "
              "the smallest coding. speed: patches of "
              "4800 faces, or as many as the GPU of --gpu decodes at once. --patches and --patch-faces "
              "override the profile")
          ->check(CLI::IsMember({"speed", "balanced", "size"}))
          ->type_name("NAME");
  command
      .add_option("--gpu", arguments.gpu,
                  "With --profile speed: the GPU to cut for, by name or by its number of multiprocessors")
      ->check([](const std::string& gpu) {
        return multiprocessors(gpu) ? std::string()
                                    : gpu + " is not a known GPU; known are " + known_gpus() +
                                          ", and any number of multiprocessors";
      })
      ->needs(profile)
      ->type_name("GPU");
}

void add_volume_option(CLI::App& command, EncodeArguments& arguments) {
  command
      .add_option(
          "--quantization-volume", arguments.volume,
          "Which primitives share a quantization grid: none (primitive), those of a mesh, or all of the scene")
      ->check(CLI::IsMember({"primitive", "mesh", "scene"}))
      ->capture_default_str()
      ->type_name("WHAT");
  command.get_option("--lossless")->excludes("--quantization-volume");
}

void add_keep_options(CLI::App& command, EncodeDocumentOptions& options) {
  command.add_flag("--keep-degenerate", options.keep_degenerate,
                   "Keep degenerate faces, which repeat an index and draw nothing");
  command.add_flag("--keep-unused", options.keep_unused, "Keep points that no face uses");
  command.add_flag("--keep-duplicates", options.keep_duplicates,
                   "Do not merge points that are equal in all attributes, or equal after quantization at the "
                   "same position");
  command
      .add_option(
          "--skip", options.skip,
          "Leave ATTRIBUTE out of all meshes, such as TEXCOORD_1, COLOR_0 or _CUSTOM. It is an error if the "
          "asset needs it, as a texture needs its coordinates. May be repeated")
      ->allow_extra_args(false)
      ->type_name("ATTRIBUTE");
}

void add_drop_option(CLI::App& command, std::vector<std::string>& names) {
  const auto holds_meshes = [](const std::string& name) {
    for (const char* known : {kExtensionName, kStockExtensionName, "KHR_mesh_quantization",
                              "EXT_meshopt_compression", "KHR_meshopt_compression"})
      if (name == known) return name + " holds the meshes themselves, and cannot be dropped";
    return std::string();
  };
  command
      .add_option(
          "--drop-extension", names,
          "Remove an extension from the whole asset, for example FB_ngon_encoding, which depends on the "
          "order of faces: a primitive with such an extension stays as it is. Repeat the option for "
          "several extensions")
      ->allow_extra_args(false)
      ->check(holds_meshes)
      ->type_name("NAME");
}

void add_storage_options(CLI::App& command, EncodeArguments& arguments) {
  command
      .add_option(
          "--fallback", arguments.fallback,
          "What loaders without the extension find: nothing, or uncompressed geometry beside the patches")
      ->check(CLI::IsMember({"none", "uncompressed"}))
      ->capture_default_str()
      ->type_name("KIND");
  command
      .add_option("--compat", arguments.compat,
                  "khr: each patch becomes a primitive of its own in KHR_draco_mesh_compression, which common "
                  "loaders open. Points on borders are stored once for each patch, and decoding does not join "
                  "them. At most 8 patches of a primitive by default, because each is a draw call")
      ->check(CLI::IsMember({"none", "khr"}))
      ->capture_default_str()
      ->type_name("KIND");
}

void add_condense_options(CLI::App& command, EncodeArguments& arguments) {
  CLI::Option* condense = command.add_flag(
      "--condense", arguments.condense,
      "Condense the streams: code them with tables that all patches of a primitive share. That takes fewer "
      "bytes, and needs a loader that decodes condensed patches. Stock Draco that is not split, and patches of "
      "the input, are condensed as they are; the subcommand expand restores them. No effect with --compat khr");
  command
      .add_flag("--no-condense", arguments.no_condense,
                "Do not condense streams; the default. Condensed patches of the input stay: see expand")
      ->excludes(condense);
}

// The given options that patches of the input cannot follow, because they are not encoded again.
std::string options_of_patches(const CLI::App& command, const EncodeDocumentOptions& options) {
  std::string given;
  for (const char* name :
       {"--patches", "--patch-faces", "--min-faces", "--profile", "--distance", "--no-refine",
        "--quantize-position", "--quantize-normal", "--quantize-texcoord", "--quantize-color",
        "--quantize-generic", "--quantization-volume", "--encode-speed", "--fallback"}) {
    const bool is_default = name == std::string_view("--fallback") && options.fallback == Fallback::kNone;
    if (command.count(name) > 0 && !is_default) given += (given.empty() ? "" : ", ") + std::string(name);
  }
  return given;
}

}  // namespace

std::function<void()> add_encode_options(CLI::App& command, EncodeArguments& arguments) {
  EncodeDocumentOptions& options = arguments.options;
  CLI::Option* patches = add_count_option(command, "--patches", options.patches,
                                          "Number of patches, over all primitives together");
  CLI::Option* patch_faces =
      add_count_option(command, "--patch-faces", options.patch_faces, "Cut patches of about N faces each")
          ->excludes(patches);
  add_count_option(command, "--min-faces", options.min_faces,
                   "Do not split primitives of fewer faces. Default: " + std::to_string(kMinFaces) +
                       "; with --patches or --patch-faces, split primitives of any size");
  command.add_flag("--always-patches", options.always_patches,
                   "Use PSPLIT_mesh_draco_patches also for primitives that are not split, instead of "
                   "KHR_draco_mesh_compression");
  add_profile_options(command, arguments);
  add_partition_options(command, options);
  add_coding_options(command, options, true);
  add_volume_option(command, arguments);
  add_keep_options(command, options);
  add_drop_option(command, arguments.drop_extensions);
  add_storage_options(command, arguments);
  add_condense_options(command, arguments);
  command.add_flag("--no-verify", arguments.no_verify,
                   "Do not check the result by decoding it and comparing it with the input");
  return [&arguments, &command, patches, patch_faces] {
    if (patches->empty() && patch_faces->empty()) apply_profile(arguments);
    EncodeDocumentOptions& resolved = arguments.options;
    resolved.verify = !arguments.no_verify;
    resolved.condense = arguments.condense && !arguments.no_condense;
    resolved.condense_smallest = resolved.condense && arguments.profile == "size";
    resolved.volume = arguments.volume == "mesh"    ? QuantizationVolume::kMesh
                      : arguments.volume == "scene" ? QuantizationVolume::kScene
                                                    : QuantizationVolume::kPrimitive;
    resolved.fallback = arguments.fallback == "uncompressed" ? Fallback::kUncompressed : Fallback::kNone;
    resolved.compat = arguments.compat == "khr" ? Compat::kKhr : Compat::kNone;
    resolved.options_of_patches = options_of_patches(command, resolved);
  };
}

void group_encode_options(CLI::App& command) {
  const std::vector<std::pair<const char*, std::vector<const char*>>> groups = {
      {"Patches",
       {"--patches", "--patch-faces", "--min-faces", "--always-patches", "--profile", "--gpu", "--distance",
        "--no-refine"}},
      {"Precision",
       {"--quantize-position", "--max-error", "--quantize-normal", "--quantize-texcoord", "--quantize-color",
        "--quantize-generic", "--quantization-volume", "--lossless"}},
      {"What is kept",
       {"--keep-degenerate", "--keep-unused", "--keep-duplicates", "--skip", "--drop-extension"}},
      {"What is written", {"--images", "--condense", "--no-condense", "--fallback", "--compat", "--as"}},
  };
  for (const auto& [group, names] : groups)
    for (const char* name : names)
      if (CLI::Option* option = command.get_option_no_throw(name)) option->group(group);
}

std::string describe_options(const EncodeDocumentOptions& options) {
  const EncodeDocumentOptions& o = options;
  Json described{{"format", kContainerVersion},
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
                 {"verify", o.verify}};
  if (!o.skip.empty()) described["skip"] = o.skip;
  if (o.position_bits_by_edges) described["position_bits_by_edges"] = kLeastBitsForEdges;
  if (o.max_position_error > 0) described["max_position_error"] = o.max_position_error;
  if (o.condense) described["condense"] = {kCondensedContainerVersion, o.condense_smallest};
  return described.dump();
}

}  // namespace psplit
