#include "tools/gltf_psplit/options/encode_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "encoder/coding/position_bits.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/json/json.h"
#include "src/container/patch_container.h"
#include "system/float_text.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/count_option.h"
#include "tools/gltf_psplit/options/file_options.h"

namespace psplit {
namespace {

// Patches of 440 faces already take over a third more bytes than one stream (docs/benchmarks.md).
constexpr uint64_t kLeastPatchFaces = 440;

// What --gpu takes for the GPUs of a web page's visitors, with 500 to 3,000 lanes in flight: psplit/webgpu
// decodes a patch in each. 3,000 patches of this size are what its memory holds by default (128 MiB, 82 bytes a
// face), so no lane waits for memory, and a GPU of 500 lanes takes six rounds (docs/manual.md).
constexpr std::string_view kWeb = "web";
constexpr uint64_t kWebPatchFaces = 500;

// A profile does not depend on the machine: the same command writes the same bytes everywhere.
void apply_profile(EncodeArguments& arguments) {
  PatchTarget& target = arguments.options.patches;
  if (arguments.profile == "size") target.most = kMostPatchesForSize;
  if (arguments.profile != "speed") return;
  if (arguments.gpu.empty()) {
    target.faces = kSpeedPatchFaces;
    return;
  }
  if (arguments.gpu == kWeb) {
    target.faces = kWebPatchFaces;
    return;
  }
  target.count = patches_in_flight(*multiprocessors(arguments.gpu));
  target.least_faces = kLeastPatchFaces;
}

void add_profile_options(CLI::App& command, EncodeArguments& arguments) {
  CLI::Option* profile = add_choice_option(
      command, "--profile", arguments.profile, {"speed", "balanced", "size"},
      "balanced, the default: 2 to 16 patches, or patches of 30000 faces in larger primitives; about 2 % "
      "larger than one Draco stream. size: about 4 patches for each primitive, the smallest of Draco's "
      "predictions for each attribute of a patch, unless --encode-speed is given, and with --condense the "
      "smallest coding; encoding and decoding take longer. speed: patches of 4800 faces, in primitives of any "
      "size, or as many as the GPU of --gpu decodes at once. --patches and --patch-faces override the number "
      "of patches");
  command
      .add_option(
          "--gpu", arguments.gpu,
          "With --profile speed: the GPU to cut for, by name or by its number of multiprocessors, or web for "
          "the GPUs of a web page's visitors, with 500 to 3000 lanes: patches of 500 faces")
      ->check([](const std::string& gpu) {
        return gpu == kWeb || multiprocessors(gpu) ? std::string()
                                                   : gpu + " is not a known GPU; known are " + known_gpus() +
                                                         ", web, and any number of multiprocessors";
      })
      ->needs(profile)
      ->type_name("GPU");
}

void add_volume_option(CLI::App& command, EncodeArguments& arguments) {
  add_choice_option(
      command, "--quantization-volume", arguments.volume, {"primitive", "mesh", "scene"},
      "Which primitives share a quantization grid for positions, and one for weights: none (primitive), all of "
      "a mesh, or all of the scene. All other attributes have separate grids");
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
      .add_option("--skip", options.skip,
                  "Leave ATTRIBUTE out of all meshes, such as TEXCOORD_1, COLOR_0 or _CUSTOM. It is an error "
                  "if the asset needs it, for example the coordinates of a texture. unused: attributes that "
                  "no material and no skin reads. May be repeated")
      ->allow_extra_args(false)
      ->type_name("ATTRIBUTE");
}

void add_drop_option(CLI::App& command, std::vector<std::string>& names) {
  const auto holds_meshes = [](const std::string& name) {
    for (const char* known : {kExtensionName, kStockExtensionName, kQuantizationExtensionName,
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

// Returns false if the text is no fallback.
bool set_fallback(std::string_view text, EncodeDocumentOptions& options) {
  constexpr std::string_view kCoarse = "coarse";
  options.coarse_share = kCoarseShare;
  options.fallback = text == "none"           ? Fallback::kNone
                     : text == "uncompressed" ? Fallback::kUncompressed
                                              : Fallback::kCoarse;
  if (options.fallback != Fallback::kCoarse || text == kCoarse) return true;
  if (!text.starts_with(std::string(kCoarse) + "=") || !text.ends_with('%')) return false;
  text.remove_prefix(kCoarse.size() + 1);
  text.remove_suffix(1);
  double share = 0;
  const auto read = read_float(text.data(), text.data() + text.size(), share);
  options.coarse_share = share / 100;
  return read.ec == std::errc() && read.ptr == text.data() + text.size() && share > 0 && share <= 100;
}

void add_storage_options(CLI::App& command, EncodeArguments& arguments) {
  EncodeDocumentOptions& options = arguments.options;
  add_parsed_option(
      command, "--fallback", "WHAT",
      "What loaders without the extension get. none, the default: nothing. uncompressed: the geometry, stored "
      "beside the patches. coarse: a mesh of 0.5 % of the faces, which takes a few per cent of the bytes. "
      "coarse=SHARE%: a mesh of another share. A coarse mesh has at least " +
          std::to_string(kLeastCoarseFaces) + " faces, or a tenth of the faces of a small mesh",
      "is not none, uncompressed, coarse or coarse=SHARE%",
      [&options](const std::string& text) { return set_fallback(text, options); });
  add_choice_option(
      command, "--compat", arguments.compat, {"none", "khr"},
      "khr: each patch becomes a primitive of its own in KHR_draco_mesh_compression, which common loaders "
      "open. Each patch stores its own copy of points on borders, and decoding does not join them. By default "
      "at most 8 patches for each primitive, because each patch is a draw call");
  add_choice_option(
      command, "--morph-targets", arguments.morph_targets, {"fit", "keep", "sparse", "patches"},
      "sparse: sparse accessors where these take fewer bytes, and no data for targets that are zero "
      "everywhere; deltas stay exact, and every viewer reads them. patches: attributes of the patches, which "
      "take the fewest bytes; each primitive with targets gets PSPLIT_mesh_draco_patches. fit, the default: "
      "patches for primitives that are in patches anyway, because they are large, condensed, or "
      "--always-patches is given; sparse for all others. keep: as in the input");
}

void add_condense_options(CLI::App& command, EncodeArguments& arguments) {
  CLI::Option* condense = command.add_flag(
      "--condense", arguments.condense,
      "Condense the streams: code them with tables that all patches of a primitive share. Takes fewer bytes, "
      "but needs a loader that decodes condensed patches. Unsplit primitives, and the stock Draco and patches "
      "that are kept from the input, are condensed as well, if that makes the file smaller; the subcommand "
      "expand restores all streams. No effect with --compat khr");
  command
      .add_flag(
          "--no-condense", arguments.no_condense,
          "Do not condense streams; the default. Condensed patches of the input stay condensed: see expand")
      ->excludes(condense);
}

void add_meshopt_options(CLI::App& command, EncodeArguments& arguments) {
  // A flag: without "=" no word after it is its value.
  CLI::Option* meshopt = command.add_flag(
      "--meshopt", arguments.meshopt,
      "Let meshoptimizer compress the data that stay in buffer views: animations, instances, morph targets, "
      "points, lines, and plain meshes. ext, the default, writes EXT_meshopt_compression, which more loaders "
      "support; khr writes KHR_meshopt_compression, which is smaller, but only the newest loaders read. Key "
      "times, splines and all data without a precision option "
      "stay exact. decode makes the views plain. Not with --memory");
  meshopt->type_name("[=ext|khr]")->check([](const std::string& word) {
    return word == "true" || word == "ext" || word == "khr" ? std::string() : word + " is neither ext nor khr";
  });
  AnimationBits& bits = arguments.options.animation_bits;
  const auto add_bits = [&](const char* name, int& to, int least, int most, const char* what) {
    command.add_option(name, to, std::string("With --meshopt: bits for ") + what)
        ->check(CLI::Range(least, most))
        ->capture_default_str()
        ->type_name("BITS")
        ->needs(meshopt)
        ->excludes(command.get_option("--lossless"));
  };
  add_bits("--animation-translation-bits", bits.translation, kLeastAnimationBits, kMostAnimationBits,
           "the largest component of the translations in a track, or of all instances");
  add_bits("--animation-rotation-bits", bits.rotation, kLeastRotationBits, kMostRotationBits,
           "each component of rotations");
  add_bits("--animation-scale-bits", bits.scale, kLeastAnimationBits, kMostAnimationBits,
           "the largest component of the scales in a track");
  add_bits("--animation-weight-bits", bits.weight, 1, kMostWeightBits,
           "weights of morph targets, after the binary point");
}

// The given options that patches of the input cannot follow, because they are not encoded again.
std::string options_of_patches(const CLI::App& command, const EncodeDocumentOptions& options) {
  std::string given;
  for (const char* name : {"--patches", "--patch-faces", "--min-faces", "--profile", "--distance",
                           "--no-refine", "--quantize-position", "--quantize-normal", "--quantize-texcoord",
                           "--quantize-color", "--quantize-generic", "--quantize-morph", "--morph-targets",
                           "--quantization-volume", "--encode-speed", "--fallback", "--order", "--boxes"}) {
    const bool is_followed =
        name == std::string_view("--fallback") && options.fallback != Fallback::kUncompressed;
    if (command.count(name) > 0 && !is_followed) given += (given.empty() ? "" : ", ") + std::string(name);
  }
  return given;
}

struct Gpu {
  std::string_view name;
  uint32_t multiprocessors;
};

// Numbers of multiprocessors from NVIDIA's data sheets, of the variant with the most.
constexpr Gpu kGpus[] = {{"B200", 148},    {"H200", 132},    {"H100", 132},     {"A100", 108},
                         {"V100", 80},     {"L40S", 142},    {"L40", 142},      {"L4", 58},
                         {"A10", 72},      {"T4", 40},       {"RTX 5090", 170}, {"RTX 4090", 128},
                         {"RTX 4080", 76}, {"RTX 4070", 46}, {"RTX 4060", 24},  {"RTX 3090", 82},
                         {"RTX 3080", 68}, {"RTX 3070", 46}, {"RTX 3060", 28},  {"RTX 2080", 46}};

// The letters and digits of a name, in lower case.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// Metres, from a number with a unit. False if the text is not a length greater than 0.
bool parse_length(std::string_view text, double& in_metres) {
  double length = 0;
  const auto read = read_float(text.data(), text.data() + text.size(), length);
  if (read.ec != std::errc() || !(length > 0) || !std::isfinite(length)) return false;
  const std::string_view unit = text.substr(static_cast<size_t>(read.ptr - text.data()));
  for (const auto& [name, metres] : {std::pair<std::string_view, double>{"", 1},
                                     {"m", 1},
                                     {"cm", 1e2},
                                     {"mm", 1e3},
                                     {"um", 1e6},
                                     {"\u00b5m", 1e6}})
    if (unit == name) {
      in_metres = length / metres;
      return true;
    }
  return false;
}

// "X,Y,Z". False if the text is something else.
bool parse_point(std::string_view text, auto& point) {
  for (size_t axis = 0; axis < point.size(); ++axis) {
    const auto read = read_float(text.data(), text.data() + text.size(), point[axis]);
    if (read.ec != std::errc() || !std::isfinite(point[axis])) return false;
    text.remove_prefix(static_cast<size_t>(read.ptr - text.data()));
    if (axis + 1 == point.size()) break;
    if (!text.starts_with(',')) return false;
    text.remove_prefix(1);
  }
  return text.empty();
}

// False if the text is no order.
bool parse_order(std::string_view text, PatchOrder& order) {
  constexpr std::string_view kNear = "near:";
  order = {text == "size" ? PatchOrder::By::kSize : PatchOrder::By::kCut, {}};
  if (text == "cut" || text == "size") return true;
  if (!text.starts_with(kNear)) return false;
  order.by = PatchOrder::By::kNear;
  text.remove_prefix(kNear.size());
  return parse_point(text, order.point);
}

void add_order_options(CLI::App& command, EncodeDocumentOptions& options) {
  add_parsed_option(command, "--order", "ORDER",
                    "The order of a primitive's patches, in which they arrive and are shown. cut, the default: "
                    "each patch is near the previous one. size: the largest area first. near:X,Y,Z: the "
                    "nearest to this point first, in the mesh's own coordinates",
                    "is not cut, size or near:X,Y,Z",
                    [&options](const std::string& text) { return parse_order(text, options.order); });
  command.add_flag("--boxes", options.boxes,
                   "Store the bounding box of each patch, in 6 bytes, by which viewers choose the patches to "
                   "load first. Not with --compat khr");
}

// "none", or three numbers. False if the text is neither.
bool parse_origin(std::string_view text, OriginChoice& origin) {
  const bool is_none = text == "none";
  origin.by = is_none ? OriginChoice::By::kNone : OriginChoice::By::kGiven;
  origin.given.assign(is_none ? 0 : 1, {});
  return is_none || parse_point(text, origin.given[0]);
}

void add_position_options(CLI::App& command, EncodeDocumentOptions& options) {
  const std::string usual = std::to_string(options.position_bits);
  const auto set_bits = [&options](const std::string& text) {
    const bool is_auto = text == "auto";
    options.position_bits_by_edges = is_auto;
    options.given.position = !is_auto;
    if (is_auto) return true;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), options.position_bits);
    const bool is_number = read.ec == std::errc() && read.ptr == text.data() + text.size();
    return is_number && options.position_bits >= 1 && options.position_bits <= kMostGridBits;
  };
  CLI::Option* bits = add_parsed_option(
      command, "--quantize-position", "BITS",
      "Bits for each component of positions. auto: the fewest, at least " + std::to_string(kLeastBitsForEdges) +
          ", whose step is at most 1/20 of the length that 95 % of the edges exceed. Dense meshes get more "
          "than " +
          usual + ", and become larger; the summary says by how much",
      "is neither auto nor a number from 1 to " + std::to_string(kMostGridBits), set_bits);
  bits->default_str(usual);
  add_parsed_option(
      command, "--max-error", "LENGTH",
      "The largest error of positions; they get as many bits as this needs. LENGTH is 0.5mm, 20um, 1cm, 0.1m, "
      "or a number in the units of the input. A length with a unit assumes that the input is in metres, as "
      "glTF is: for a PLY, STL or OBJ in millimetres, write 0.5 for 0.5 mm. It applies to the mesh's own "
      "coordinates, before the transforms of nodes",
      "is not a length, such as 0.5mm, 20um or 0.001",
      [&options](const std::string& text) { return parse_length(text, options.max_position_error); })
      ->excludes(bits);
}

}  // namespace

void add_origin_option(CLI::App& command, OriginChoice& origin) {
  add_parsed_option(
      command, "--origin", "none|X,Y,Z",
      "The offset that is subtracted from the positions of a PLY, OBJ, STL or OFF, and becomes the translation "
      "of their nodes: none, or X,Y,Z. Default: whole numbers near the centre, if floats would lose more than "
      "half a step of the grid of the file's doubles or decimals, as happens far from the origin of a map "
      "projection; otherwise none. diff and decode add the offset again",
      "is neither none nor X,Y,Z", [&origin](const std::string& text) { return parse_origin(text, origin); });
}

void follow_bits(const EncodeDocumentOptions& options, OriginChoice& origin) {
  const bool is_exact = options.lossless || options.position_bits_by_edges || options.max_position_error > 0;
  origin.bits = is_exact ? 0 : options.position_bits;
  origin.is_lossless = options.lossless;
}

void add_coding_options(CLI::App& command, EncodeDocumentOptions& options, bool fits_mesh) {
  const auto add_bits = [&](const char* name, int& bits, bool& is_given, int least, const char* what) {
    command.add_option(name, bits, std::string("Bits for each component of ") + what)
        ->check(CLI::Range(least, kMostGridBits))
        ->each([&is_given](const std::string&) { is_given = true; })
        ->capture_default_str()
        ->type_name("BITS");
  };
  GivenBits& given = options.given;
  if (fits_mesh)
    add_position_options(command, options);
  else
    add_bits("--quantize-position", options.position_bits, given.position, 1, "positions");
  add_bits("--quantize-normal", options.normal_bits, given.normal, 2, "normals (octahedral)");
  add_bits("--quantize-texcoord", options.texcoord_bits, given.texcoord, 1, "texture coordinates");
  add_bits("--quantize-color", options.color_bits, given.color, 1, "colours stored as floats");
  add_bits("--quantize-generic", options.generic_bits, given.generic, 1,
           "all other float attributes. Without the option, attributes whose values are all whole numbers are "
           "kept exactly, with as many bits as they need");
  command
      .add_option("--quantize-morph", options.morph_bits,
                  "Bits of morph targets in patches: their deltas get the step that the grid of their base "
                  "attribute would have with these bits. Default: the step of that grid")
      ->check(CLI::Range(1, kMostGridBits))
      ->type_name("BITS");
  CLI::Option* lossless =
      command.add_flag("--lossless", options.lossless, "Keep every float exactly, without quantization");
  for (const char* name : {"--quantize-position", "--quantize-normal", "--quantize-texcoord",
                           "--quantize-color", "--quantize-generic", "--quantize-morph"})
    lossless->excludes(command.get_option(name));
  if (fits_mesh) lossless->excludes("--max-error");
  command
      .add_option("--encode-speed", options.encode_speed,
                  "Draco's speed: 0 makes the smallest files, 10 is fastest")
      ->check(CLI::Range(0, kMostEncodeSpeed))
      ->capture_default_str()
      ->type_name("SPEED");
  command
      .add_option_function<std::string>(
          "--encoder", [&options](const std::string& name) { options.by_libdraco = name == "draco"; },
          "Encoder of Draco streams: psplit, or draco for libdraco, which takes longer for the same bytes")
      ->check(CLI::IsMember({"psplit", "draco"}))
      ->check(refuse_missing_draco)
      ->default_str("psplit")
      ->type_name("NAME");
}

void add_partition_options(CLI::App& command, EncodeDocumentOptions& options) {
  const auto cut_as_the_paper = [&options](const std::string& distance) {
    options.method = PartitionMethod::kPaper;
    options.distance = distance == "geodesic" ? PathDistance::kGeodesic : PathDistance::kDijkstra;
  };
  command
      .add_option_function<std::string>(
          "--distance", cut_as_the_paper,
          "Cut with the method of the paper, which clusters faces around farthest-point samples. Distances are "
          "measured "
          "along edges (dijkstra) or across faces (geodesic). The default method cuts in levels and is faster")
      ->check(CLI::IsMember({"dijkstra", "geodesic"}))
      ->type_name("NAME");
  command.add_flag_callback(
      "--no-refine", [&options] { options.refine = false; },
      "Do not smooth the borders between patches, to measure the effect of refinement");
}

std::function<void()> add_encode_options(CLI::App& command, EncodeArguments& arguments) {
  EncodeDocumentOptions& options = arguments.options;
  CLI::Option* patches = add_count_option(command, "--patches", options.patches.count,
                                          "Number of patches, over all primitives together. Separate pieces "
                                          "that are smaller than a patch may add a few");
  CLI::Option* patch_faces =
      add_count_option(command, "--patch-faces", options.patches.faces, "Cut patches of about N faces each")
          ->excludes(patches);
  add_count_option(command, "--min-faces", options.patches.min_faces,
                   "Do not split primitives of fewer faces. Default: " + std::to_string(kMinFaces) +
                       "; with --patches, --patch-faces or --profile speed, split primitives of any size");
  command.add_flag("--always-patches", options.patches.always,
                   "Use PSPLIT_mesh_draco_patches also for primitives that are not split, instead of "
                   "KHR_draco_mesh_compression");
  add_profile_options(command, arguments);
  add_partition_options(command, options);
  add_order_options(command, options);
  add_coding_options(command, options, true);
  add_volume_option(command, arguments);
  add_origin_option(command, arguments.origin);
  add_keep_options(command, options);
  add_drop_option(command, arguments.drop_extensions);
  add_storage_options(command, arguments);
  add_condense_options(command, arguments);
  add_meshopt_options(command, arguments);
  command.add_flag("--no-verify", arguments.no_verify,
                   "Do not verify the result by decoding it and comparing it with the input");
  const CLI::Option* speed = command.get_option("--encode-speed");
  return [&arguments, &command, patches, patch_faces, speed] {
    if (patches->empty() && patch_faces->empty()) apply_profile(arguments);
    EncodeDocumentOptions& resolved = arguments.options;
    resolved.verify = !arguments.no_verify;
    follow_bits(resolved, arguments.origin);
    resolved.condense = !arguments.condense || arguments.no_condense ? Condense::kNo
                        : arguments.profile == "size"                ? Condense::kSmallest
                                                                     : Condense::kFast;
    resolved.choose_by_bytes = arguments.profile == "size" && speed->empty() && !resolved.by_libdraco;
    resolved.volume = arguments.volume == "mesh"    ? QuantizationVolume::kMesh
                      : arguments.volume == "scene" ? QuantizationVolume::kScene
                                                    : QuantizationVolume::kPrimitive;
    resolved.meshopt = command.count("--meshopt") == 0 ? MeshoptRest::kNo
                       : arguments.meshopt == "khr"    ? MeshoptRest::kKhr
                                                       : MeshoptRest::kExt;
    resolved.compat = arguments.compat == "khr" ? Compat::kKhr : Compat::kNone;
    resolved.morph_targets = arguments.morph_targets == "keep"      ? MorphTargets::kKeep
                             : arguments.morph_targets == "sparse"  ? MorphTargets::kSparse
                             : arguments.morph_targets == "patches" ? MorphTargets::kPatches
                                                                    : MorphTargets::kAsFits;
    if (resolved.compat == Compat::kKhr && resolved.morph_targets == MorphTargets::kPatches)
      throw CLI::ValidationError("--morph-targets", "--compat khr writes no patches");
    if (resolved.compat == Compat::kKhr && resolved.fallback == Fallback::kCoarse)
      throw CLI::ValidationError("--fallback", "coarse needs patches, and --compat khr writes none");
    resolved.options_of_patches = options_of_patches(command, resolved);
  };
}

void group_encode_options(CLI::App& command) {
  const std::vector<std::pair<const char*, std::vector<const char*>>> groups = {
      {"Patches",
       {"--patches", "--patch-faces", "--min-faces", "--always-patches", "--profile", "--gpu", "--distance",
        "--no-refine", "--order", "--boxes"}},
      {"Precision",
       {"--quantize-position", "--max-error", "--quantize-normal", "--quantize-texcoord", "--quantize-color",
        "--quantize-generic", "--quantize-morph", "--quantization-volume", "--lossless", "--origin",
        "--animation-translation-bits", "--animation-rotation-bits", "--animation-scale-bits",
        "--animation-weight-bits"}},
      {"Kept data", {"--keep-degenerate", "--keep-unused", "--keep-duplicates", "--skip", "--drop-extension"}},
      {"Output",
       {"--images", "--condense", "--no-condense", "--meshopt", "--morph-targets", "--fallback", "--compat",
        "--as"}},
  };
  for (const auto& [group, names] : groups)
    for (const char* name : names)
      if (CLI::Option* option = command.get_option_no_throw(name)) option->group(group);
}

std::string describe_options(const EncodeDocumentOptions& options, const OriginChoice& origin) {
  const EncodeDocumentOptions& o = options;
  Json described{
      {"format", kContainerVersion},
      {"patches", o.patches.count},
      {"least_patch_faces", o.patches.least_faces},
      {"patch_faces", o.patches.faces},
      {"most_patches", o.patches.most},
      {"min_faces", o.patches.min_faces},
      {"always_patches", o.patches.always},
      {"bits", {o.position_bits, o.normal_bits, o.texcoord_bits, o.color_bits, o.generic_bits, o.morph_bits}},
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
      {"morph_targets", static_cast<int>(o.morph_targets)},
      {"verify", o.verify}};
  const GivenBits& given = o.given;
  if (given.position || given.normal || given.texcoord || given.color || given.generic)
    described["given_bits"] = {given.position, given.normal, given.texcoord, given.color, given.generic};
  if (!o.skip.empty()) described["skip"] = o.skip;
  if (o.position_bits_by_edges) described["position_bits_by_edges"] = kLeastBitsForEdges;
  if (o.max_position_error > 0) described["max_position_error"] = o.max_position_error;
  if (o.order.by != PatchOrder::By::kCut) described["order"] = {static_cast<int>(o.order.by), o.order.point};
  if (o.by_libdraco) described["encoder"] = "draco";
  if (o.choose_by_bytes) described["choose_by_bytes"] = true;
  if (o.boxes) described["boxes"] = true;
  if (o.fallback == Fallback::kCoarse) described["coarse_share"] = o.coarse_share;
  if (origin.by == OriginChoice::By::kNone) described["origin"] = "none";
  if (origin.by == OriginChoice::By::kGiven) described["origin"] = origin.given;
  if (o.meshopt != MeshoptRest::kNo) {
    const AnimationBits& bits = o.animation_bits;
    described["meshopt"] = {static_cast<int>(o.meshopt), bits.translation, bits.rotation, bits.scale,
                            bits.weight};
  }
  if (o.condense != Condense::kNo)
    described["condense"] = o.condense == Condense::kSmallest ? "smallest" : "fast";
  return described.dump();
}

std::optional<uint32_t> multiprocessors(const std::string& gpu) {
  constexpr uint32_t kMost = 4096;
  uint32_t number = 0;
  const auto read = std::from_chars(gpu.data(), gpu.data() + gpu.size(), number);
  if (read.ec == std::errc() && read.ptr == gpu.data() + gpu.size())
    return number > 0 && number <= kMost ? std::optional(number) : std::nullopt;
  for (const Gpu& known : kGpus)
    if (plain(known.name) == plain(gpu)) return known.multiprocessors;
  return std::nullopt;
}

std::string known_gpus() {
  std::string names;
  for (const Gpu& known : kGpus) names += (names.empty() ? "" : ", ") + std::string(known.name);
  return names;
}

uint32_t patches_in_flight(uint32_t multiprocessors) {
  constexpr uint32_t kEach = 4 * 32, kMultiple = 512;
  return std::max(1u, (multiprocessors * kEach + kMultiple / 2) / kMultiple) * kMultiple;
}

}  // namespace psplit
