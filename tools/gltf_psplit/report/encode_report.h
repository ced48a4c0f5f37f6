// What `encode` and `batch` report about an asset: rows of JSON, and lines of the log.
#pragma once

#include <map>
#include <span>
#include <string>

#include "gltf_ext/convert/coarse_primitives.h"
#include "gltf_ext/convert/sparse_targets.h"
#include "gltf_ext/json/json.h"
#include "psplit/gltf.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/patch_summary.h"

namespace psplit {

// One primitive's row of the report, or the sum of all rows.
struct EncodeRow {
  AttributeCoding position_coding;  // 0 bits in the sum of rows
  uint64_t input_faces = 0, input_points = 0;
  uint64_t input_bytes = 0;
  PatchSummary summary;
  EncodeStatistics statistics;

  EncodeRow& operator+=(const EncodeRow& other);
};

void append_row(Json& object, const EncodeRow& row);
// The row that append_row appended. Numbers that are missing are 0.
EncodeRow row_of(const Json& object);
std::string row_text(const EncodeRow& row);

// The bytes of all geometry before and after, including primitives that were left as they were.
struct GeometryBytes {
  uint64_t input = 0, output = 0;
};

// The result for an asset: the sum over all encoded primitives, a row of JSON for each primitive, and the
// number of primitives of each kind.
struct EncodeResult {
  EncodeRow total;
  GeometryBytes geometry;
  Json primitives = Json::array();
  size_t split_count = 0;        // in several patches, or in the extension
  size_t draco_count = 0;        // in one stream of KHR_draco_mesh_compression
  size_t recoded_count = 0;      // primitives whose streams are the input's, condensed
  uint64_t unsplit_streams = 0;  // primitives of draco_count whose geometry no earlier one has
  // Attributes that the user skips, and the number of primitives that had each.
  std::map<std::string, size_t> dropped_attributes;
  std::map<std::string, size_t> unused_attributes;  // attributes that --skip unused would leave out
  // Of quantized positions: the least and the most bits, about how many there are, and the sum of their bits.
  int least_bits = 0, most_bits = 0;
  uint64_t quantized_positions = 0, bits_of_positions = 0;
};
// `skipped`: the attributes that the user skips.
EncodeResult collect_rows(std::span<const PrimitiveReport> reports, std::span<const std::string> skipped,
                          const Log& log);

// Logs which primitives were left as they were, and what the others lost. Each line begins with `prefix`.
void log_reports(std::span<const PrimitiveReport> reports, const Log& log, const std::string& prefix = "");

// Warns if the geometry takes more bytes than before, and of skipped attributes that no primitive has.
void warn_of_result(const EncodeResult& result, const Log& log, const std::string& file);

// Advice about attributes that no material and no skin reads; empty if there are none.
std::string unused_text(const EncodeResult& result);

// How the meshes changed: "merged 12 duplicate points, dropped 3 degenerate faces"; empty if they did not.
std::string changes_text(const EncodeStatistics& statistics);

// "mesh data 1.15 MB in 45 patches; dropped 3 degenerate faces", for written_text. With the bits of positions,
// if the options let the mesh choose them.
std::string encode_summary(const EncodeResult& result, const EncodeDocumentOptions& options);

// Drops extensions that the user named (gltf_ext/document/extensions.h), and logs each. Returns the number of
// objects that had them, by name.
Json drop_extensions(Document& document, const std::vector<std::string>& names, const std::string& asset,
                     const Log& log);

// "276 morph targets in 690 kB, which --condense would store in patches, in fewer bytes"; empty if there are
// none.
std::string targets_text(const TargetCounts& counts);

// "4,355 coarse faces in 83 kB for loaders without the extension"; empty if there are none.
std::string coarse_text(const CoarseCounts& counts);
// Null if there are none.
Json coarse_json(const CoarseCounts& counts);

// The views of a document that meshoptimizer compressed, their bytes, and the bytes of the decoded values.
struct MeshoptCounts {
  size_t views = 0;
  uint64_t bytes = 0, decoded_bytes = 0;
};
MeshoptCounts meshopt_counts(const Document& document);
// "267 kB of other data in 80 kB"; empty if there is none.
std::string meshopt_text(const MeshoptCounts& counts);
// Null if there are none.
Json meshopt_json(const MeshoptCounts& counts);

}  // namespace psplit
