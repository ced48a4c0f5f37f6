// One command on several files: all are worked on, whatever becomes of the others.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// kUsage where stdin is named more than once.
Status check_inputs(std::span<const std::string> files);

// The status of one file is returned as it is. Of several, each failure is logged, and what is returned has the
// code of the first one and says how many there were.
Status for_each_file(std::span<const std::string> files, const Log& log,
                     const std::function<Status(const std::string&)>& work);

// The JSON of several files is an array, in their order; that of one is its object.
Json results_json(std::vector<Json> results, size_t file_count);

// What stands in that array for a file that could not be read: {"file", "error": {"code", "message"}}.
Json failure_json(const std::string& file, const Status& status);

}  // namespace psplit
