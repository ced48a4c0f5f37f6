// gltf-psplit diff: tells whether two assets hold the same meshes, and where they first differ.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <set>
#include <span>

#include "system/float_text.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/diff/column_limits.h"
#include "tools/gltf_psplit/diff/compare_assets.h"
#include "tools/gltf_psplit/diff/compared_asset.h"
#include "tools/gltf_psplit/diff/diff_report.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/memory_options.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

struct DiffArguments {
  std::string inputs[2], output = "-", format = "text";
  BackendChoice backend;
  std::vector<std::string> tolerances, attributes;
  bool scene = false;  // compare meshes at the places where nodes put them
  MemoryChoice memory;
};

// Whether it is a name of glTF's.
bool is_attribute_name(std::string_view name) {
  constexpr std::string_view kKinds[] = {"POSITION", "NORMAL",  "TANGENT", "TEXCOORD_",
                                         "COLOR_",   "JOINTS_", "WEIGHTS_"};
  const std::string kind = kind_of(std::string(name));
  return kind.starts_with('_') || std::ranges::any_of(kKinds, [&](std::string_view known) {
           const std::string_view set = std::string_view(kind).substr(std::min(known.size(), kind.size()));
           const bool is_number = std::ranges::all_of(set, [](char c) { return c >= '0' && c <= '9'; });
           return kind.starts_with(known) && is_number && set.empty() != known.ends_with('_');
         });
}

// "1e-4", or "NORMAL=0.01".
struct StatedTolerance {
  std::string attribute;
  double share = 0;
};
std::optional<StatedTolerance> parse_tolerance(const std::string& text) {
  const size_t equals = text.rfind('=');
  StatedTolerance tolerance;
  if (equals != std::string::npos) tolerance.attribute = text.substr(0, equals);
  const char* const begin = text.data() + (equals == std::string::npos ? 0 : equals + 1);
  const char* const end = text.data() + text.size();
  const auto read = read_float(begin, end, tolerance.share);
  const bool valid = read.ec == std::errc() && read.ptr == end && tolerance.share >= 0 && tolerance.share <= 1;
  return valid && equals != 0 ? std::optional(tolerance) : std::nullopt;
}

// An attribute of glTF that the options name may be missing in some of many assets. Any other name is misspelt,
// and would hide differences.
Status check_attributes(const CompareRules& rules, std::span<const AssetMeshes, 2> meshes, const Log& log) {
  std::set<std::string> present;
  for (const AssetMeshes& side : meshes)
    for (const AssetPrimitive& primitive : side.primitives)
      for (const MeshView::Values& attribute : primitive.view.attributes) {
        present.insert(attribute.semantic);
        present.insert(kind_of(attribute.semantic));
      }
  std::set<std::string> named(rules.attributes.begin(), rules.attributes.end());
  for (const auto& [attribute, share] : rules.tolerances)
    if (!attribute.empty()) named.insert(attribute);
  for (const std::string& attribute : named) {
    if (present.contains(attribute)) continue;
    if (!is_attribute_name(attribute))
      return wrong_usage("neither file has " + attribute + ", which is not an attribute of glTF");
    log.warning("neither file has " + attribute);
  }
  return {};
}

void log_what_is_not_compared(const AssetComparison& comparison, const std::string& first,
                              const std::string& second, const Log& log) {
  const auto note = [&](const AssetComparison::Counts& counts, const std::string& file) {
    if (counts.degenerate_alone > 0)
      log.note(file + ": " + counted(counts.degenerate_alone, "triangle") +
               " without area, here or on the grid of the other file, and without counterpart");
    if (counts.without_data > 0)
      log.note(file + ": " + counted(counts.without_data, "primitive") +
               " not compared, because the buffer with the values has no uri");
  };
  note(comparison.a, first);
  note(comparison.b, second);
  if (comparison.a.unused_points != comparison.b.unused_points)
    log.note("unused points: " + with_separators(comparison.a.unused_points) + " of " + first + ", " +
             with_separators(comparison.b.unused_points) + " of " + second);
  if (comparison.recut_meshes > 0)
    log.note(counted(comparison.recut_meshes, "mesh") +
             " divided into other primitives, and compared as wholes");
}

// Positions of mesh files are in doubles: they are read relative to the origins of the other file, so that
// their floats can be compared. A mesh file whose origin turns out to be another one is read again.
Expected<std::array<ComparedAsset, 2>> read_both(const std::string (&inputs)[2], const BackendChoice& backend,
                                                 const MemoryLimit* limit, const Session& session) {
  Expected<ComparedAsset> a = read_compared(inputs[0], backend, limit, session, {});
  if (!a) return a.status();
  Expected<ComparedAsset> b = read_compared(inputs[1], backend, limit, session, origin_beside(*a));
  if (!b) return b.status();
  if (a->is_mesh_file && a->origins != b->origins && inputs[0] != "-" && is_disk_file(inputs[0])) {
    a = read_compared(inputs[0], backend, limit, session, origin_beside(*b));
    if (!a) return a.status();
  }
  return std::array<ComparedAsset, 2>{std::move(*a), std::move(*b)};
}

// Nodes are not compared. But nodes of mesh files hold the origin that was subtracted from positions, and so
// does the translation in a file that was made of one.
void count_origins(std::array<ComparedAsset, 2>& assets) {
  if (!assets[0].is_mesh_file && !assets[1].is_mesh_file) return;
  for (ComparedAsset& asset : assets)
    for (AssetPrimitive& primitive : asset.meshes.primitives)
      primitive.set_origin(asset.origins[primitive.whole]);
}

// What floats lose far from the origin is no part of the grid, but a difference, if the other side is a mesh
// file that had to be read relative to another origin.
void limit_grids(std::array<ComparedAsset, 2>& assets) {
  if (!assets[0].is_mesh_file && !assets[1].is_mesh_file) return;
  if (assets[0].origins == assets[1].origins) return;
  constexpr double kRoundingOfFloats = 1e-7;
  for (ComparedAsset& asset : assets)
    for (AssetPrimitive& primitive : asset.meshes.primitives)
      if (const auto found = primitive.grids.find("POSITION"); found != primitive.grids.end()) {
        DeclaredGrid& grid = found->second;
        grid.within = std::min(grid.within, half_step(grid) + kRoundingOfFloats * double{grid.coding.range});
      }
}

// Both scenes around the same origin.
Status place_scenes(std::array<ComparedAsset, 2>& assets, const std::string (&inputs)[2]) {
  PositionSpread both;
  for (const size_t side : {0u, 1u}) {
    const Expected<PositionSpread> spread = spread_of_scene(assets[side].document, assets[side].meshes);
    if (!spread) return spread.status().at({.file = inputs[side]});
    both.add(*spread);
  }
  const PrecisePosition origin = choose_origins({&both, 1}, {})[0];
  for (const size_t side : {0u, 1u}) {
    Expected<AssetMeshes> placed = place_meshes(assets[side].document, assets[side].meshes, origin);
    if (!placed) return placed.status().at({.file = inputs[side]});
    assets[side].meshes = std::move(*placed);
  }
  return {};
}

Status run_diff(const DiffArguments& arguments, const Session& session) {
  const std::string(&inputs)[2] = arguments.inputs;
  CompareRules rules;
  rules.attributes = arguments.attributes;
  for (const std::string& text : arguments.tolerances)
    if (const auto tolerance = parse_tolerance(text)) rules.tolerances[tolerance->attribute] = tolerance->share;
  if (inputs[0] == "-" && inputs[1] == "-") return wrong_usage("stdin (-) can be only one of the two files");
  const MemoryLimit limit = memory_limit(arguments.memory);
  const bool fits = limit.allows(estimate_mesh_bytes(inputs[0], limit) + estimate_mesh_bytes(inputs[1], limit));
  if (!fits && arguments.scene)
    return wrong_usage("--scene needs both assets in memory, which is more than --memory allows");
  if (Status status = check_not_an_input(arguments.output, "--output", inputs); !status.ok()) return status;
  Expected<std::array<ComparedAsset, 2>> assets =
      read_both(inputs, arguments.backend, fits ? nullptr : &limit, session);
  if (!assets) return assets.status();
  for (const size_t side : {0u, 1u}) {
    for (const std::string& warning : (*assets)[side].warnings)
      session.log.warning(inputs[side] + ": " + warning);
    if (Status status = check_not_an_input(arguments.output, "--output", (*assets)[side].document);
        !status.ok())
      return status;
  }
  limit_grids(*assets);
  if (arguments.scene) {
    if (Status status = place_scenes(*assets, inputs); !status.ok()) return status;
  } else {
    count_origins(*assets);
  }
  const std::array<AssetMeshes, 2> meshes{std::move((*assets)[0].meshes), std::move((*assets)[1].meshes)};
  if (Status status = check_attributes(rules, meshes, session.log); !status.ok()) return status;
  const Expected<AssetComparison> comparison = [&] {
    const ProgressBar bar("comparing", session.log);
    return compare_assets(meshes[0], meshes[1], rules, {session.pool, fits ? 0 : limit.bytes});
  }();
  if (!comparison) return comparison.status();
  const std::string text = arguments.format == "json" ? report_text(to_json(*comparison))
                                                      : to_text(*comparison, inputs[0], inputs[1]);
  if (Status status = write_text(arguments.output, text, session.if_read_only()); !status.ok()) return status;
  log_what_is_not_compared(*comparison, inputs[0], inputs[1], session.log);
  if (comparison->same()) return {};
  const bool has_grids = std::ranges::any_of(meshes, [](const AssetMeshes& side) {
    return std::ranges::any_of(side.primitives, [](const AssetPrimitive& p) { return !p.grids.empty(); });
  });
  if (!has_grids && rules.tolerances.empty() && comparison->a.alone + comparison->b.alone > 0)
    session.log.note(
        "neither file declares a quantization grid (decoded files do not), so values must be equal; "
        "--tolerance allows differences");
  return {StatusCode::kDiffers, inputs[0] + " and " + inputs[1] + " do not hold the same meshes"};
}

}  // namespace

void add_diff_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<DiffArguments>();
  command
      .add_option(
          "A", arguments->inputs[0],
          "The first asset: a .gltf or .glb file, compressed or not, or a .drc, .ply, .obj, .stl or .off "
          "file, optionally gzipped; - reads stdin")
      ->required();
  command
      .add_option("B", arguments->inputs[1],
                  "The second asset. Without --scene, nodes are ignored, except for the origin of a PLY, OBJ, "
                  "STL or OFF, and for translations in an asset compared with one")
      ->required();
  separated_by_commas(
      command.add_option("--tolerance", arguments->tolerances,
                         "The allowed difference of values, as a share of the attribute's extent; 0: they must "
                         "be equal. Default: the error that the files' quantization grids allow"),
      "[NAME=]SHARE,...")
      ->check([](const std::string& text) {
        return std::string(parse_tolerance(text) ? ""
                                                 : text + " is neither a number from 0 to 1 nor NAME=NUMBER");
      });
  separated_by_commas(
      command.add_option("--attributes", arguments->attributes,
                         "Compare only positions and these attributes, for example NORMAL,TEXCOORD_0"),
      "NAME,...");
  command.add_flag(
      "--scene", arguments->scene,
      "Compare the default scenes as wholes: all meshes transformed by their nodes, however they are divided, "
      "without morph targets. For assets of tools that quantize positions and adjust nodes");
  add_memory_options(
      command, arguments->memory,
      "Two assets that need more are in temporary files of their size, and are compared part by part.");
  add_format_option(command, arguments->format);
  add_text_output_option(command, arguments->output);
  add_backend_options(command, arguments->backend);
  add_examples(command, {{"gltf-psplit diff dragon.ply dragon.glb",
                          "test whether the file that encode wrote holds the mesh; exit with 7 if not"},
                         {"gltf-psplit diff dragon.ply decoded.ply --tolerance 1e-4",
                          "let values differ by a ten-thousandth of the mesh's extent"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) -> Status {
      if (Status status = check_output_place(arguments->output, session.force); !status.ok()) return status;
      return run_diff(*arguments, session);
    };
  });
}

}  // namespace psplit
