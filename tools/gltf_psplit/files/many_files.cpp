#include "tools/gltf_psplit/files/many_files.h"

#include <algorithm>

#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {

Status check_inputs(std::span<const std::string> files) {
  if (std::ranges::count(files, "-") > 1) return wrong_usage("stdin (-) can be named only once");
  return {};
}

Status for_each_file(std::span<const std::string> files, const Log& log,
                     const std::function<Status(const std::string&)>& work) {
  if (files.size() == 1) return work(files.front());
  StatusCode first = StatusCode::kOk;
  size_t failed = 0;
  for (const std::string& file : files) {
    const Status status = work(file);
    if (status.ok()) continue;
    log.error(status);
    if (failed++ == 0) first = status.code();
  }
  if (failed == 0) return {};
  return {first, std::to_string(failed) + " of " + counted(files.size(), "file") + " failed"};
}

Json results_json(std::vector<Json> results, size_t file_count) {
  if (file_count == 1 && results.size() == 1) return std::move(results.front());
  Json array = Json::array();
  for (Json& result : results) array.push_back(std::move(result));
  return array;
}

Json failure_json(const std::string& file, const Status& status) {
  return {{"file", file}, {"error", {{"code", exit_code(status.code())}, {"message", status.to_string()}}}};
}

}  // namespace psplit
