#include "tools/gltf_psplit/diff/diff_report.h"

#include <cstdio>
#include <map>
#include <optional>

#include "psplit/mesh.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

std::string short_number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string vector_text(const std::vector<double>& values) {
  std::string text = "(";
  for (const double value : values) {
    char digits[40];
    std::snprintf(digits, sizeof digits, text.size() > 1 ? " %.9g" : "%.9g", value);
    text += digits;
  }
  return text + ")";
}

// "1,000 triangles and 20 lines"
std::string elements_text(const AssetComparison::Counts& counts) {
  std::string text;
  const auto add = [&](uint64_t count, const char* noun) {
    if (count > 0) text += (text.empty() ? "" : " and ") + counted(count, noun);
  };
  add(counts.triangles, "triangle");
  add(counts.lines, "line");
  add(counts.points, "point");
  return text.empty() ? "nothing" : text;
}

std::string same_text(const AssetComparison& comparison) {
  std::string text = "same: " + elements_text(comparison.a);
  if (comparison.a.triangles != comparison.b.triangles)
    text += " and " + elements_text(comparison.b) + ", of which " +
            with_separators(comparison.a.degenerate_alone + comparison.b.degenerate_alone) +
            " without area have no counterpart,";
  text += " in " + counted(comparison.a.primitives, "primitive");
  if (comparison.a.primitives != comparison.b.primitives)
    text += " and " + with_separators(comparison.b.primitives);
  std::string differences;
  const auto add = [&](const std::string& name, const AssetComparison::Values& values) {
    if (values.largest > 0)
      differences += (differences.empty() ? "" : ", ") + name + " " + short_number(values.largest) +
                     " (tolerance " + short_number(values.tolerance) + ")";
  };
  // Of hundreds of morph targets, the one that comes nearest to its tolerance.
  std::map<std::string, AssetComparison::Values> of_targets;
  for (const AssetComparison::Values& values : comparison.values) {
    const std::optional<MorphTarget> target = target_of(values.attribute);
    if (!target) {
      add(values.attribute, values);
      continue;
    }
    AssetComparison::Values& worst = of_targets[target->semantic];
    if (values.largest * worst.tolerance >= worst.largest * values.tolerance) worst = values;
  }
  for (const auto& [semantic, values] : of_targets) add(semantic + " of morph targets", values);
  return text + (differences.empty() ? ", every value equal" : ", largest difference " + differences) + "\n";
}

std::string difference_text(const AssetDifference& difference, const std::string& whose,
                            const std::string& other) {
  if (difference.mesh < 0) return difference.what;
  std::string text =
      whose + ": " +
      describe_place(static_cast<uint64_t>(difference.mesh), static_cast<uint64_t>(difference.primitive));
  const std::string noun = difference.corner_count == 3   ? "face "
                           : difference.corner_count == 2 ? "line "
                                                          : "point ";
  if (difference.element >= 0) text += ", " + noun + std::to_string(difference.element);
  const std::string corner = "corner " + std::to_string(difference.corner);
  if (!difference.other.empty())
    return text + ", " + corner + ": " + difference.attribute + " is " + vector_text(difference.value) +
           ", and " + vector_text(difference.other) + " in the nearest of " + other + ", " + noun +
           std::to_string(difference.partner);
  text += " " + difference.what;
  if (!difference.value.empty())
    text += "; " + corner + " has " + difference.attribute + " " + vector_text(difference.value);
  if (difference.partner >= 0) text += "; nearest is " + noun + std::to_string(difference.partner);
  return text;
}

Json to_json(const AssetComparison::Counts& counts) {
  return {{"triangles", counts.triangles},
          {"lines", counts.lines},
          {"points", counts.points},
          {"primitives", counts.primitives},
          {"without_counterpart", counts.alone},
          {"degenerate_without_counterpart", counts.degenerate_alone},
          {"unused_points", counts.unused_points},
          {"without_data", counts.without_data}};
}

Json to_json(const AssetDifference& difference) {
  const auto number = [](int64_t value) { return value < 0 ? Json(nullptr) : Json(value); };
  Json object{{"in", difference.in_b ? "b" : "a"}, {"what", difference.what}};
  object["mesh"] = number(difference.mesh);
  object["primitive"] = number(difference.primitive);
  object["element"] = number(difference.element);
  object["corner"] = number(difference.corner);
  object["counterpart"] = number(difference.partner);
  object["attribute"] = difference.attribute.empty() ? Json(nullptr) : Json(difference.attribute);
  object["value"] = difference.value.empty() ? Json(nullptr) : Json(difference.value);
  object["other_value"] = difference.other.empty() ? Json(nullptr) : Json(difference.other);
  return object;
}

}  // namespace

std::string to_text(const AssetComparison& comparison, const std::string& first, const std::string& second) {
  if (comparison.same()) return same_text(comparison);
  const AssetDifference& difference = *comparison.first;
  const auto share = [](const AssetComparison::Counts& counts, const std::string& file) {
    return with_separators(counts.alone) + " of " + elements_text(counts) + " of " + file;
  };
  return "differs: " +
         difference_text(difference, difference.in_b ? second : first, difference.in_b ? first : second) +
         "\nwithout counterpart: " + share(comparison.a, first) + ", " + share(comparison.b, second) + "\n";
}

Json to_json(const AssetComparison& comparison) {
  Json result{{"same", comparison.same()}, {"a", to_json(comparison.a)}, {"b", to_json(comparison.b)}};
  result["attributes"] = Json::array();
  for (const AssetComparison::Values& values : comparison.values)
    result["attributes"].push_back({{"semantic", values.attribute},
                                    {"largest_difference", values.largest},
                                    {"tolerance", values.tolerance}});
  result["recut_meshes"] = comparison.recut_meshes;
  result["first_difference"] = comparison.first ? to_json(*comparison.first) : Json(nullptr);
  return result;
}

}  // namespace psplit
