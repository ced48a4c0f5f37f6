#include "tools/gltf_psplit/sameness/large_sameness_report.h"

#include <algorithm>
#include <cstdio>

#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

std::string corner_text(const std::array<float, 3>& corner) {
  char text[80];
  std::snprintf(text, sizeof text, "(%.6g %.6g %.6g)", double{corner[0]}, double{corner[1]}, double{corner[2]});
  return text;
}

const char* name_of(LargeVerdict verdict) {
  return verdict == LargeVerdict::kSame        ? "same"
         : verdict == LargeVerdict::kUndecided ? "undecided"
                                               : "differs";
}

}  // namespace

std::string to_text(const LargeComparison& comparison, const std::string& first, const std::string& second) {
  const LargeVerdict verdict = comparison.verdict();
  LargeComparison::Mesh all = comparison.sum();
  std::string text = name_of(verdict);
  text += verdict == LargeVerdict::kSame ? " by sums of hashes: " : ": ";
  if (comparison.mesh_counts[0] != comparison.mesh_counts[1])
    text += counted(comparison.mesh_counts[0], "mesh") + " in " + first + ", " +
            counted(comparison.mesh_counts[1], "mesh") + " in " + second + "; ";
  for (size_t i = 0; i < comparison.meshes.size(); ++i) {
    const LargeComparison::Mesh& mesh = comparison.meshes[i];
    if (mesh.verdict == LargeVerdict::kSame) continue;
    text += "mesh " + std::to_string(i) + ": " + counted(mesh.triangles[0], "triangle") + " in " + first +
            ", " + counted(mesh.triangles[1], "triangle") + " in " + second;
    if (!mesh.what.empty()) text += "; " + mesh.what;
    if (mesh.differing_cells > 0)
      text += "; differences of " + joined(mesh.differing) + " in " + with_separators(mesh.differing_cells) +
              " of 4,096 cells, between " + corner_text(mesh.difference.low) + " and " +
              corner_text(mesh.difference.high);
    text += "\n";
  }
  if (verdict == LargeVerdict::kSame) text += counted(all.triangles[0], "triangle") + "\n";
  if (!text.ends_with('\n')) text += "\n";
  std::ranges::sort(all.rounded);
  std::ranges::sort(all.undecided);
  if (!all.rounded.empty()) text += "rounded to the grid of the other asset: " + joined(all.rounded) + "\n";
  if (!all.undecided.empty())
    text += "not compared, because types or grids differ: " + joined(all.undecided) + "\n";
  return text;
}

Json to_json(const LargeComparison& comparison) {
  Json meshes = Json::array();
  for (const LargeComparison::Mesh& mesh : comparison.meshes) {
    Json object{{"verdict", name_of(mesh.verdict)},
                {"same", mesh.verdict == LargeVerdict::kSame},
                {"triangles", {mesh.triangles[0], mesh.triangles[1]}},
                {"degenerate", {mesh.degenerate[0], mesh.degenerate[1]}},
                {"rounded", mesh.rounded},
                {"differing", mesh.differing},
                {"not_compared", mesh.undecided}};
    if (!mesh.what.empty()) object["what"] = mesh.what;
    if (mesh.differing_cells > 0)
      object["difference"] = {
          {"cells", mesh.differing_cells}, {"min", mesh.difference.low}, {"max", mesh.difference.high}};
    meshes.push_back(std::move(object));
  }
  return {{"verdict", name_of(comparison.verdict())},
          {"same", comparison.verdict() == LargeVerdict::kSame},
          {"method", "sums of hashes"},
          {"mesh_counts", {comparison.mesh_counts[0], comparison.mesh_counts[1]}},
          {"meshes", std::move(meshes)}};
}

}  // namespace psplit
