// gltf-psplit validate: every rule of the extension, on every patch.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "gltf_ext/validate.h"
#include "tools/gltf_psplit/commands.h"
#include "tools/gltf_psplit/progress.h"

namespace psplit {
namespace {

struct Arguments {
  std::string input, format = "text";
  BackendChoice backend;
};

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

Status run_validate(const Arguments& arguments, const Session& session) {
  std::vector<Finding> findings;
  const Expected<Document> document = read_document(arguments.input);
  if (document) {
    ProgressBar bar("validating", session.log);
    findings = validate_document(*document, find_backend(arguments.backend), session.pool);
  } else if (document.status().code() == StatusCode::kInvalidInput) {
    // An asset that cannot be read at all breaks the first rule.
    findings.push_back({"asset", document.status().message(), document.status().place(), true});
  } else {
    return document.status();
  }

  const auto error_count = static_cast<size_t>(
      std::ranges::count_if(findings, [](const Finding& finding) { return finding.error; }));
  std::string text;
  if (arguments.format == "json") {
    Json list = Json::array();
    for (const Finding& finding : findings) list.push_back(to_json(finding));
    const Json result{{"valid", error_count == 0},
                      {"errors", error_count},
                      {"warnings", findings.size() - error_count},
                      {"findings", std::move(list)}};
    text = report_text(result);
  } else {
    for (const Finding& finding : findings) text += to_text(finding);
    if (error_count == 0) text += arguments.input + ": valid\n";
  }
  if (Status status = write_text("-", text); !status.ok()) return status;
  if (error_count == 0) return {};
  const bool is_beyond = std::ranges::all_of(findings, [](const Finding& finding) {
    return !finding.error || finding.code == StatusCode::kUnsupported;
  });
  return {is_beyond ? StatusCode::kUnsupported : StatusCode::kInvalidInput,
          "breaks the rules: " + counted(error_count, "error"),
          {.file = arguments.input}};
}

}  // namespace

void add_validate_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand("validate", "Check an asset against every rule of the extension");
  command.add_option("IN", arguments->input, "A .gltf or .glb file; - is a GLB on stdin")->required();
  add_format_option(command, arguments->format);
  add_backend_options(command, arguments->backend);
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_validate(*arguments, session); };
  });
}

}  // namespace psplit
