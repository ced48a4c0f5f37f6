#include "tools/gltf_psplit/report/verdict.h"

#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

Json to_json(const Finding& finding) {
  const auto number_or_null = [](int64_t number) { return number < 0 ? Json(nullptr) : Json(number); };
  return {{"rule", finding.rule},
          {"severity", finding.error ? "error" : "warning"},
          {"message", finding.message},
          {"mesh", number_or_null(finding.place.mesh)},
          {"primitive", number_or_null(finding.place.primitive)},
          {"patch", number_or_null(finding.place.patch)}};
}

std::string to_text(const Finding& finding) {
  const Status located(StatusCode::kInvalidInput, finding.message, finding.place);
  return (finding.error ? "error [" : "warning [") + finding.rule + "] " + located.to_string() + "\n";
}

}  // namespace

Verdict verdict_of(const std::string& input, std::span<const Finding> findings) {
  Verdict verdict;
  Json list = Json::array();
  size_t errors = 0;
  bool is_beyond = true;  // all errors concern unsupported features
  for (const Finding& finding : findings) {
    if (finding.error) ++errors;
    if (finding.error && finding.code != StatusCode::kUnsupported) is_beyond = false;
    verdict.text += to_text(finding);
    list.push_back(to_json(finding));
  }
  const size_t warnings = findings.size() - errors;
  verdict.text += input + (errors == 0 ? ": valid" : ": invalid, " + counted(errors, "error")) +
                  (warnings == 0 ? "" : ", " + counted(warnings, "warning")) + "\n";
  verdict.json = {{"file", input},
                  {"valid", errors == 0},
                  {"errors", errors},
                  {"warnings", warnings},
                  {"findings", std::move(list)}};
  if (errors > 0)
    verdict.status = {is_beyond ? StatusCode::kUnsupported : StatusCode::kInvalidInput,
                      "breaks the rules: " + counted(errors, "error"),
                      {.file = input}};
  return verdict;
}

void warn_of_corrections(std::span<const Finding> corrections, const Log& log, const std::string& input) {
  for (const Finding& finding : corrections) {
    Place place = finding.place;
    place.file = input;
    log.warning(Status(StatusCode::kInvalidInput, finding.message + ": corrected", place).to_string());
  }
}

}  // namespace psplit
