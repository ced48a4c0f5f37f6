// Measures patches, stock Draco and meshoptimizer on the same meshes, in one run.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "tools/gltf_psplit/compare/measure.h"
#include "tools/gltf_psplit/report/patch_summary.h"

namespace psplit {

struct ComparisonOptions {
  std::vector<uint64_t> patch_counts;       // each over all meshes together
  std::vector<int> thread_counts;           // for decoding patches
  std::vector<int> stock_speeds{0, 5, 10};  // in addition to coding.encode_speed
  int repeat = 5;
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
  StockRow stock;                      // at coding.encode_speed; all ratios refer to it
  std::vector<StockRow> stock_speeds;  // by ascending speed, including `stock`
  MeshoptRow meshopt, meshopt_plain;   // with zstd, and without
  std::vector<SplitRow> splits;
};

// Encodes once, with `pool`, and times decoding with measure_interleaved. kDiffers if the decoded faces and
// points of a container are not those that its directory states.
Expected<Comparison> compare_codecs(std::span<const Mesh> meshes, const ComparisonOptions& options,
                                    std::span<const DecodeBackend> backends, const ThreadPool& pool,
                                    const Progress& progress = {});

}  // namespace psplit
