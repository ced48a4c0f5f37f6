// Patches against stock Draco and meshoptimizer, on the same meshes, in one run: what `compare` prints.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "tools/gltf_psplit/compare/measure.h"
#include "tools/gltf_psplit/report/patch_summary.h"

namespace psplit {

struct ComparisonOptions {
  std::vector<uint64_t> patch_counts;       // over all meshes together
  std::vector<int> thread_counts;           // of the decoders of patches
  std::vector<int> stock_speeds{0, 5, 10};  // of stock Draco, beside coding.encode_speed
  int repeat = 5;
  // Bits or lossless, and speed, the same for patches and for stock Draco; how patches are cut.
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
  // Of the core, on one thread (src/cpu/staged_decode.h): all but stitching, and without a residue.
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
  StockRow stock;                      // at coding.encode_speed: what all ratios refer to
  std::vector<StockRow> stock_speeds;  // ascending, that one among them
  MeshoptRow meshopt, meshopt_plain;   // with zstd on top, and without
  std::vector<SplitRow> splits;
};

// Encoding runs once, with `pool`; decoding is timed by measure_interleaved. Before that, the decoded counts
// are checked against the containers' (kDiffers).
Expected<Comparison> compare_codecs(std::span<const Mesh> meshes, const ComparisonOptions& options,
                                    std::span<const DecodeBackend> backends, const ThreadPool& pool,
                                    const Progress& progress = {});

}  // namespace psplit
