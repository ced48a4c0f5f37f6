// Measures patches, stock Draco and meshoptimizer on the same meshes, in one run.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_job.h"
#include "psplit/gltf.h"
#include "tools/gltf_psplit/compare/measure.h"
#include "tools/gltf_psplit/report/patch_summary.h"

namespace psplit {

// How the meshes are cut, as EncodeDocumentOptions has it: `patches` over all meshes together, or patches of
// `patch_faces` faces, or, if both are 0, as `encode` cuts by default.
struct PatchRule {
  uint64_t patches = 0, patch_faces = 0;
  bool condense = false;  // as --condense
};

struct ComparisonOptions {
  std::vector<PatchRule> rules;             // one row of patches for each
  std::vector<int> thread_counts;           // for decoding patches
  std::vector<int> stock_speeds{0, 5, 10};  // in addition to coding.encode_speed
  Rounds rounds;
  // Precision and speed, the same for patches and for stock Draco; how patches are cut.
  EncodeDocumentOptions coding;
};

struct StockRow {
  int speed = 0;  // Draco's
  uint64_t bytes = 0;
  double encode_ms = 0;
  Timing decode;
};

struct MeshoptRow {
  uint64_t bytes = 0;
  Timing decode;
};

struct StageRow {
  std::string name;
  Timing timing;
};

struct DecodeRow {
  std::string backend;
  int threads = 1;
  Timing timing;
  double speedup = 0;  // stock's median / this median
};

struct SplitRow {
  PatchRule rule;
  PatchSummary summary;
  double overhead = 0;                     // bytes / stock bytes - 1
  double partition_ms = 0, encode_ms = 0;  // encode_ms includes partition_ms
  std::vector<DecodeRow> decode;
  // Times of the core on one thread (src/cpu/staged_decode.h), without stitching and without the residue.
  std::vector<StageRow> stages;
  double mean_patch_faces() const {
    return summary.patches == 0
               ? 0
               : static_cast<double>(summary.patch_faces) / static_cast<double>(summary.patches);
  }
};

// Sums over all meshes. Stock Draco and meshoptimizer decode on one thread, mesh after mesh.
struct Comparison {
  uint64_t faces = 0, points = 0;
  StockRow stock;                            // at coding.encode_speed; all ratios refer to it
  std::vector<StockRow> stock_speeds;        // by ascending speed, including `stock`
  MeshoptRow meshopt, meshopt_plain;         // with zstd, and without
  std::optional<MeshoptRow> meshopt_brotli;  // with brotli, if this build has it
  std::vector<SplitRow> splits;
  int rounds = 0;  // that were timed
};

// Whether the decoder of a DecodeBackend or of a DecodeRow is psplit's own.
inline bool is_own(const DecodeBackend& backend) { return backend.name != "draco"; }
inline bool is_own(const DecodeRow& row) { return row.backend != "draco"; }

// `coding` with the rule's patches.
EncodeDocumentOptions apply_rule(EncodeDocumentOptions coding, const PatchRule& rule);

// The number of patches that the rule makes of all jobs.
uint64_t count_patches(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& coding,
                       const PatchRule& rule);

// Measures what read_jobs read with options.coding. Meshes are stored as encode_document stores them if the
// rule's number of patches is asked for: one that is not cut is a stock Draco stream, unless it is condensed.
// Stock Draco and meshoptimizer get the same codings, and the mesh without duplicate points, degenerate faces
// and unused points. EncodeJobs without a face are skipped.
//
// Encodes once, with `pool`, and times decoding with measure_interleaved: psplit's with decode_as_loader.
// kDiffers if the decoded faces and points of a container differ from its directory. Needs libdraco
// (has_draco).
Expected<Comparison> compare_codecs(std::span<const EncodeJob> jobs, const ComparisonOptions& options,
                                    std::span<const DecodeBackend> backends, const ThreadPool& pool,
                                    const Progress& progress = {});

}  // namespace psplit
