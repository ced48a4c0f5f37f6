// gltf-psplit validate: checks every rule of the extension, on every patch.
#include <CLI/CLI.hpp>
#include <memory>

#include "gltf_ext/convert/validate.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/many_files.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

struct Arguments {
  std::vector<std::string> inputs;
  std::string output = "-", format = "text";
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

// An asset that cannot be parsed breaks the first rule. Other failures, such as a missing file, are errors.
Expected<std::vector<Finding>> find_all(const std::string& input, const Arguments& arguments,
                                        const Session& session) {
  const Expected<Document> document = read_document(input);
  if (document) {
    if (Status status = check_not_an_input(arguments.output, "--output", *document); !status.ok())
      return status;
    ProgressBar bar("validating " + input, session.log);
    return validate_document(*document, find_backend(arguments.backend), session.pool);
  }
  const Status status = document.status();
  if (status.code() != StatusCode::kInvalidInput) return status;
  return std::vector<Finding>{{"asset", status.message(), status.place(), true}};
}

// The result for one file: its findings, and whether it is valid.
struct Verdict {
  std::string text;
  Json json;
  Status status;
};

Verdict verdict_of(const std::string& input, const std::vector<Finding>& findings) {
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

Status run_validate(const Arguments& arguments, const Session& session) {
  if (Status status = check_inputs(arguments.inputs); !status.ok()) return status;
  if (Status status = check_not_an_input(arguments.output, "--output", arguments.inputs); !status.ok())
    return status;
  if (Status status = check_output_place(arguments.output); !status.ok()) return status;
  const bool as_json = arguments.format == "json";
  const bool at_once = !as_json && arguments.output == "-";  // print each file as soon as it is checked
  std::vector<Json> results;
  std::string texts;
  bool spares_output = false;  // the output would replace a file that an asset needs
  const Status status = for_each_file(arguments.inputs, session.log, [&](const std::string& input) -> Status {
    const Expected<std::vector<Finding>> findings = find_all(input, arguments, session);
    if (!findings) {
      spares_output |= findings.status().code() == StatusCode::kUsage;
      if (arguments.inputs.size() > 1) results.push_back(failure_json(input, findings.status()));
      return findings.status();
    }
    Verdict verdict = verdict_of(input, *findings);
    results.push_back(std::move(verdict.json));
    if (!at_once)
      texts += verdict.text;
    else if (Status written = write_text("-", verdict.text); !written.ok())
      return written;
    return verdict.status;
  });
  if (!at_once && !results.empty() && !spares_output) {
    const std::string text =
        as_json ? report_text(results_json(std::move(results), arguments.inputs.size())) : texts;
    if (Status written = write_text(arguments.output, text); !written.ok()) return written;
  }
  return status;
}

}  // namespace

void add_validate_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand("validate", "Check assets against every rule of the extension");
  command.add_option("IN", arguments->inputs, "The inputs: .gltf or .glb files; - reads a GLB from stdin")
      ->required();
  add_format_option(command, arguments->format);
  add_text_output_option(command, arguments->output);
  add_backend_options(command, arguments->backend);
  add_examples(
      command,
      {{"gltf-psplit validate dragon.glb", "list what is wrong, or say that the file is valid"},
       {"gltf-psplit validate out/*.glb", "check several files; fail if any is invalid"},
       {"gltf-psplit validate a.glb b.glb --format json", "a JSON array with one object for each file"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_validate(*arguments, session); };
  });
}

}  // namespace psplit
