// One command on several files. A failure of one file does not stop the others.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// kUsage if stdin is named more than once.
Status check_inputs(std::span<const std::string> files);

// Runs `work` on each file. For a single file, returns its status. For several files, logs each failure and
// returns a status with the code of the first failure and the number of failures.
Status for_each_file(std::span<const std::string> files, const Log& log,
                     const std::function<Status(const std::string&)>& work);

// For one file, its JSON object; for several files, an array in their order.
Json results_json(std::vector<Json> results, size_t file_count);

// The array's element for a file that could not be read: {"file", "error": {"code", "message"}}.
Json failure_json(const std::string& file, const Status& status);

}  // namespace psplit
