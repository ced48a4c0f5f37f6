#include "tools/gltf_psplit/report/encode_report.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/json/json_fields.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

const char* name_of(StoredAs storage) {
  switch (storage) {
    case StoredAs::kAsItWas: return "as it was";
    case StoredAs::kPatches: return "patches";
    case StoredAs::kDraco: return "draco";
    case StoredAs::kPatchPrimitives: return "patch primitives";
  }
  return "";
}

// The numbers of one or more rows with their names in JSON.
template <typename Visit, typename... Rows>
void visit_input_numbers(const Visit& visit, Rows&... rows) {
  visit("faces", rows.input_faces...);
  visit("points", rows.input_points...);
  visit("bytes", rows.input_bytes...);
}

template <typename Visit, typename... Rows>
void visit_statistics(const Visit& visit, Rows&... rows) {
  visit("merged_points", rows.statistics.merged_points...);
  visit("dropped_faces", rows.statistics.dropped_faces...);
  visit("dropped_points", rows.statistics.dropped_points...);
  visit("residue_faces", rows.statistics.residue_faces...);
  visit("residue_points", rows.statistics.residue_points...);
  visit("partition_ms", rows.statistics.partition_ms...);
  visit("encode_ms", rows.statistics.encode_ms...);
  visit("verify_ms", rows.statistics.verify_ms...);
}

// How exact positions are; empty if they are exact, and for the sum of rows.
std::string position_text(const EncodeRow& row) {
  const AttributeCoding& coding = row.position_coding;
  if (coding.bits == 0) return "";
  const std::optional<double>& error = row.statistics.position_error;
  return "; positions of " + std::to_string(coding.bits) + " bits, a step of " +
         with_digits(grid_step(coding), 3) + ", at most " + with_digits(distance_bound(coding), 3) + " off" +
         (error ? ", measured " + with_digits(*error, 3) : "");
}

// The bits that the mesh chose, and their cost. The lowest bits of positions are noise that nothing predicts:
// each takes about a bit of the output.
std::string chosen_bits_text(const EncodeResult& result) {
  if (result.most_bits == 0) return "";
  std::string text = "; positions of " + std::to_string(result.least_bits);
  if (result.most_bits > result.least_bits) text += " to " + std::to_string(result.most_bits);
  text += " bits";
  const int usual = EncodeDocumentOptions().position_bits;
  const double usual_bits = usual * static_cast<double>(result.quantized_positions);
  constexpr double kBytesOfABit = 3 * 0.93 / 8;  // in all components of a position
  const double more_bytes = kBytesOfABit * (static_cast<double>(result.bits_of_positions) - usual_bits);
  const double usual_bytes = static_cast<double>(result.total.summary.total_bytes) - more_bytes;
  const double share = std::fabs(more_bytes) / usual_bytes;
  if (!(share >= 0.005)) return text;
  return text + ", about " + with_decimals(share * 100, 0) + " % " + (more_bytes > 0 ? "more" : "fewer") +
         " bytes than with " + std::to_string(usual);
}

}  // namespace

EncodeRow& EncodeRow::operator+=(const EncodeRow& other) {
  const auto add = [](const char*, auto& sum, const auto& number) { sum += number; };
  visit_input_numbers(add, *this, other);
  visit_statistics(add, *this, other);
  summary += other.summary;
  if (const std::optional<double>& error = other.statistics.position_error)
    statistics.position_error = std::max(statistics.position_error.value_or(0), *error);
  return *this;
}

void append_row(Json& object, const EncodeRow& row) {
  visit_input_numbers([&](const char* name, uint64_t number) { object["input"][name] = number; }, row);
  append_summary(object, row.summary);
  visit_statistics([&](const char* name, auto number) { object[name] = number; }, row);
  if (const std::optional<double>& error = row.statistics.position_error) object["position_error"] = *error;
  if (const AttributeCoding& coding = row.position_coding; coding.bits > 0)
    object["position_grid"] = {
        {"bits", coding.bits}, {"step", grid_step(coding)}, {"error_bound", distance_bound(coding)}};
}

EncodeRow row_of(const Json& object) {
  const auto read = [](const Json* place, const char* name, auto& number) {
    using Number = std::remove_reference_t<decltype(number)>;
    if (place != nullptr) number = static_cast<Number>(number_field(*place, name).value_or(0));
  };
  EncodeRow row;
  const Json* const input = object_field(object, "input");
  visit_input_numbers([&](const char* name, uint64_t& number) { read(input, name, number); }, row);
  for (const auto& [group, name, number] : kSummaryNumbers)
    read(group == nullptr ? &object : object_field(object, group), name, row.summary.*number);
  visit_statistics([&](const char* name, auto& number) { read(&object, name, number); }, row);
  row.statistics.position_error = number_field(object, "position_error");
  return row;
}

std::string row_text(const EncodeRow& row) {
  const PatchSummary& summary = row.summary;
  const uint64_t map_bytes = summary.directory_bytes + summary.head_bytes + summary.stitch_bytes;
  const double map_share =
      summary.total_bytes == 0 ? 0 : static_cast<double>(map_bytes) / static_cast<double>(summary.total_bytes);
  return counted(summary.patches, "patch") + ", " + counted(summary.faces, "face") + ", " +
         counted(summary.points, "point") + ", " + counted(summary.total_bytes, "byte") + " (" +
         with_decimals(summary.bits_per_point(), 2) + " bits per point; overhead: replication " +
         as_share(summary.replication()) + ", directory" + (summary.head_bytes > 0 ? ", head" : "") +
         " and stitch map " + as_share(map_share) + "); partition " + as_duration(row.statistics.partition_ms) +
         ", all of encoding " + as_duration(row.statistics.encode_ms) + ", verification " +
         as_duration(row.statistics.verify_ms) + position_text(row);
}

Json drop_extensions(Document& document, const std::vector<std::string>& names, const std::string& asset,
                     const Log& log) {
  Json counts = Json::object();
  for (const std::string& name : names) {
    const std::optional<size_t> count = drop_extension(document, name);
    if (count) counts[name] = *count;
    log.note(asset + ": " + name + (count ? " is dropped from " + counted(*count, "object") : " is not used"));
  }
  return counts;
}

EncodeResult collect_rows(std::span<const PrimitiveReport> reports, std::span<const std::string> skipped,
                          const Log& log) {
  EncodeResult result;
  for (const std::string& attribute : skipped)
    if (attribute != kUnusedAttributes) result.dropped_attributes[attribute] = 0;
  for (const PrimitiveReport& report : reports) {
    Json object = object_with_room(32);
    object["mesh"] = report.id.mesh;
    object["primitive"] = report.id.primitive;
    object["stored_as"] = name_of(report.stored_as);
    if (report.repeated) object["repeated"] = true;
    result.geometry.input += report.input_bytes;
    if (!report.repeated) result.geometry.output += report.bytes;
    if (report.stored_as == StoredAs::kAsItWas) {
      object["skipped"] = report.skipped;
      object["input"] = {{"faces", report.faces}, {"points", report.points}, {"bytes", report.input_bytes}};
    } else {
      const EncodeRow row{
          report.position_coding,
          report.faces,
          report.points,
          report.input_bytes,
          summarize_streams(report.streams, report.has_residue, report.head_bytes, report.bytes),
          report.statistics};
      append_row(object, row);
      if (!report.repeated) result.total += row;
      if (const int bits = report.position_coding.bits; bits > 0 && !report.repeated) {
        result.least_bits = result.least_bits == 0 ? bits : std::min(result.least_bits, bits);
        result.most_bits = std::max(result.most_bits, bits);
        // Points on seams share their positions. A mesh has about half as many positions as faces.
        const uint64_t positions = std::min(row.summary.points, row.summary.faces / 2) + row.summary.references;
        result.quantized_positions += positions;
        result.bits_of_positions += positions * static_cast<uint64_t>(bits);
      }
      ++(report.stored_as == StoredAs::kDraco ? result.draco_count : result.split_count);
      if (report.stored_as == StoredAs::kDraco && !report.repeated) ++result.unsplit_streams;
      if (log.shows_details())
        log.detail(describe_place(report.id.mesh, report.id.primitive) + ": " + row_text(row));
    }
    if (report.keeps_streams) {
      object["keeps_streams"] = true;
      ++result.recoded_count;
    }
    if (!report.notes.empty()) object["notes"] = report.notes;
    if (!report.warnings.empty()) object["warnings"] = report.warnings;
    if (!report.dropped_attributes.empty()) object["dropped_attributes"] = report.dropped_attributes;
    for (const std::string& attribute : report.dropped_attributes) ++result.dropped_attributes[attribute];
    if (!report.unused_attributes.empty()) object["unused_attributes"] = report.unused_attributes;
    for (const std::string& attribute : report.unused_attributes) ++result.unused_attributes[attribute];
    result.primitives.push_back(std::move(object));
  }
  return result;
}

void log_reports(std::span<const PrimitiveReport> reports, const Log& log, const std::string& prefix) {
  for (const PrimitiveReport& report : reports) {
    const std::string place = prefix + describe_place(report.id.mesh, report.id.primitive);
    if (!report.skipped.empty()) log.note(place + " is left as it is: " + report.skipped);
    for (const std::string& note : report.notes) log.note(place + ": " + note);
    for (const std::string& warning : report.warnings) log.warning(place + ": " + warning);
  }
}

void warn_of_result(const EncodeResult& result, const Log& log, const std::string& file) {
  for (const auto& [attribute, count] : result.dropped_attributes)
    if (count == 0) log.warning(file + ": no primitive has " + attribute + ", which is to be skipped");
  if (result.geometry.output <= result.geometry.input) return;
  log.warning(file + ": the meshes take " + with_separators(result.geometry.output) + " bytes, more than the " +
              with_separators(result.geometry.input) + " of the input");
}

std::string unused_text(const EncodeResult& result) {
  std::string text;
  for (const auto& [attribute, count] : result.unused_attributes)
    text += (text.empty() ? "nothing reads " : ", ") + attribute + " of " + counted(count, "primitive");
  return text.empty() ? text : text + "; --skip unused leaves out what nothing reads";
}

std::string changes_text(const EncodeStatistics& statistics) {
  std::string text;
  const auto add = [&](const char* verb, uint64_t count, const char* noun) {
    if (count == 0) return;
    text += (text.empty() ? "" : ", ") + std::string(verb) + " " + counted(count, noun);
  };
  add("merged", statistics.merged_points, "duplicate point");
  add("dropped", statistics.dropped_faces, "degenerate face");
  add("dropped", statistics.dropped_points, "unused point");
  add("kept", statistics.residue_faces, "degenerate face");
  return text;
}

std::string encode_summary(const EncodeResult& result, const EncodeDocumentOptions& options) {
  std::string dropped;
  for (const auto& [attribute, count] : result.dropped_attributes)
    if (count > 0) dropped += "; left out " + attribute + " of " + counted(count, "primitive");
  if (result.split_count + result.draco_count == 0) return "nothing was encoded" + dropped;
  // The sum counts a stream that was not split as a patch.
  const uint64_t streams = result.total.summary.patches;
  const uint64_t patches = streams - std::min(streams, result.unsplit_streams);
  std::string stored = patches > 0 ? counted(patches, "patch") : "";
  if (result.unsplit_streams > 0)
    stored += (stored.empty() ? "" : " and ") + counted(result.unsplit_streams, "unsplit primitive");
  std::string text = "mesh data " + as_bytes(result.total.summary.total_bytes) + " in " + stored;
  if (result.recoded_count > 0)
    text += "; " + counted(result.recoded_count, "primitive") + " condensed without encoding again";
  if (options.chooses_position_bits()) text += chosen_bits_text(result);
  const std::string changes = changes_text(result.total.statistics);
  return text + (changes.empty() ? "" : "; ") + changes + dropped;
}

std::string targets_text(const TargetCounts& counts) {
  if (counts.all == 0) return "";
  std::string text = counted(counts.all, "morph target");
  if (counts.in_patches == counts.all) return text + " in patches";
  if (counts.in_patches > 0)
    text += ", " + with_separators(counts.in_patches) + " of them in patches, the others";
  text += " in " + as_bytes(counts.bytes);
  if (counts.in_patches == 0 && counts.bytes > 0) text += ", which --morph-targets patches makes smaller";
  return text;
}

std::string coarse_text(const CoarseCounts& counts) {
  if (counts.primitives == 0) return "";
  return counted(counts.faces, "coarse face") + " in " + as_bytes(counts.bytes) +
         " for loaders without the extension";
}

Json coarse_json(const CoarseCounts& counts) {
  if (counts.primitives == 0) return nullptr;
  return {{"primitives", counts.primitives},
          {"faces", counts.faces},
          {"points", counts.points},
          {"bytes", counts.bytes}};
}

MeshoptCounts meshopt_counts(const Document& document) {
  MeshoptCounts counts;
  for (const ViewRecord& view : document.records().views) {
    if (!view.meshopt) continue;
    ++counts.views;
    counts.bytes += view.meshopt->range.bytes;
    counts.decoded_bytes += view.range.bytes;
  }
  return counts;
}

std::string meshopt_text(const MeshoptCounts& counts) {
  if (counts.views == 0) return "";
  return as_bytes(counts.decoded_bytes) + " of other data in " + as_bytes(counts.bytes);
}

Json meshopt_json(const MeshoptCounts& counts) {
  if (counts.views == 0) return nullptr;
  return {{"views", counts.views}, {"bytes", counts.bytes}, {"decoded_bytes", counts.decoded_bytes}};
}

}  // namespace psplit
