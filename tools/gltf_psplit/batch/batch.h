// Encodes many assets, each as `encode` would, on one pool of threads.
#pragma once

#include <string>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/write_document.h"
#include "tools/gltf_psplit/batch/batch_plan.h"
#include "tools/gltf_psplit/options/encode_options.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {

struct BatchArguments {
  BatchRequest request;
  std::string folder;  // the output folder, as the user wrote it
  std::string report;  // empty: stdout, unless that is a terminal
  EncodeArguments encode;
  WriteOptions write;
};

// Writes every asset whose output is out of date, the report, and a summary to the log. If assets fail, the
// others are still written, and the status has the code of the first failure.
Status run_batch(const BatchArguments& arguments, const Session& session);

}  // namespace psplit
