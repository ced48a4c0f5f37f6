// Works on many assets, each as `encode` (or another command) would, on one pool of threads.
#pragma once

#include <optional>
#include <string>

#include "gltf_ext/document/document.h"
#include "psplit/document.h"
#include "tools/gltf_psplit/batch/batch_plan.h"
#include "tools/gltf_psplit/batch/batch_report.h"
#include "tools/gltf_psplit/batch/manifest.h"
#include "tools/gltf_psplit/batch/shard.h"
#include "tools/gltf_psplit/batch/staging.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {

struct BatchArguments {
  BatchVerb verb = BatchVerb::kEncode;
  BatchRequest request;  // the inputs, unless there is a manifest
  std::string manifest;
  std::string folder;  // the output folder, as the user wrote it
  std::optional<Shard> shard;
  std::string report;  // empty: stdout, unless that is a terminal, or this is a shard, or progress is JSON
  bool progress_as_json = false;  // a row on stdout for each asset that ended, at once
  bool reports_by_default = true;
  bool dry_run = false, force = false;
  bool prune = false;         // run prune_outputs instead
  bool summarize = false;     // end with one line on stderr, also if the log is quiet
  uint64_t max_failures = 0;  // this many assets may fail for good without failing the batch
  double timeout_s = 0;       // for each asset; 0: none
  uint64_t memory = 0;        // bytes; 0: default_memory
  StagingCommands staging;
  EncodeArguments encode;
  WriteOptions write;
};

// Does the work on every asset whose result is out of date, and writes the report, and a summary to the log. If
// assets fail, the others are still done. The status is kMayPass if a signal stopped the batch or if an asset
// failed for a cause that may pass; otherwise it has the code of the first failure, if more assets failed than
// max_failures.
//
// The work is done in a child process. If it crashes or is killed, the assets that it worked on are tried once
// more, one at a time, so that only the culprit fails.
Status run_batch(const BatchArguments& arguments, const Session& session);

// Lists on stdout the outputs in the folder that a batch made from inputs that are gone; with `force` it
// removes them. The input was below the base folder of `arguments.request`, whose inputs no longer name it.
// Outputs that changed since stay, and so do images beside a .gltf. kMayPass if a batch is running there.
Status prune_outputs(const BatchArguments& arguments, const Session& session);

// Plans a batch of `arguments.request` into a file (manifest.h). `options` are the words of the command line
// that every shard has to use. `with_hashes`: the hash of every input is added. kUsage if the file is an input.
Status plan_into_file(const BatchArguments& arguments, const std::vector<std::string>& options,
                      bool with_hashes, const std::string& path, const Session& session);

// Joins the reports of all shards in a folder, and writes the report as run_batch does. If all shards have
// finished, it also joins their records. Before that it changes nothing, and tells how far they are; the status
// is then kMayPass. Otherwise it is the status of the whole batch.
Status merge_batch(const BatchArguments& arguments, const Session& session);

}  // namespace psplit
