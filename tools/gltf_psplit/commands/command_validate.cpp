// gltf-psplit validate: checks every rule of the extension, on every patch.
#include <CLI/CLI.hpp>
#include <memory>

#include "gltf_ext/convert/validate.h"
#include "mesh_files/draco_file.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/files/many_files.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/help_text.h"
#include "tools/gltf_psplit/options/memory_options.h"
#include "tools/gltf_psplit/options/session.h"
#include "tools/gltf_psplit/report/progress.h"
#include "tools/gltf_psplit/report/verdict.h"

namespace psplit {
namespace {

struct ValidateArguments {
  std::vector<std::string> inputs;
  std::string output = "-", format = "text";
  BackendChoice backend;
  MemoryChoice memory;
};

// A Draco file is valid if it decodes: reading it is the check.
bool is_draco_file(const std::string& input) {
  constexpr size_t kMagicBytes = 5;
  if (input == "-" || !is_disk_file(input)) return false;
  const Expected<std::vector<uint8_t>> head = read_file(input, kMagicBytes);
  return head && is_draco(*head);
}

// An asset that cannot be parsed breaks the first rule. Other failures, such as a missing file, are errors.
Expected<std::vector<Finding>> find_all(const std::string& input, const ValidateArguments& arguments,
                                        const Session& session) {
  const bool is_draco = is_draco_file(input);
  Expected<std::optional<MappedFile>> spooled = std::optional<MappedFile>();
  if (arguments.memory.bytes != 0) spooled = spool_input(input, spool_folder(arguments.memory));
  if (!spooled && spooled.status().code() != StatusCode::kInvalidInput) return spooled.status();
  const Expected<Document> document = !spooled   ? spooled.status()
                                      : is_draco ? read_input(input, session, arguments.backend.name,
                                                              FileAccess::kRead, {}, {}, PointClouds::kRead)
                                      : *spooled ? parse_document(**spooled, input)
                                                 : read_document(input, FileAccess::kMap);
  if (document) {
    if (Status status = check_not_an_input(arguments.output, "--output", *document); !status.ok())
      return status;
    ProgressBar bar("validating " + input, session.log);
    std::vector<Finding> findings = validate_document(*document, find_backend(arguments.backend), session.pool,
                                                      memory_limit(arguments.memory));
    if (Status failure = first_failure(findings); !failure.ok()) return failure;
    return findings;
  }
  const Status status = document.status();
  if (status.code() != StatusCode::kInvalidInput) return status;
  return std::vector<Finding>{{"asset", status.message(), status.place(), true}};
}

Status run_validate(const ValidateArguments& arguments, const Session& session) {
  if (Status status = check_inputs(arguments.inputs); !status.ok()) return status;
  if (Status status = check_not_an_input(arguments.output, "--output", arguments.inputs); !status.ok())
    return status;
  if (Status status = check_output_place(arguments.output, session.force); !status.ok()) return status;
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
    if (Status written = write_text(arguments.output, text, session.if_read_only()); !written.ok())
      return written;
  }
  return status;
}

}  // namespace

void add_validate_command(CLI::App& command, Action& action) {
  auto arguments = std::make_shared<ValidateArguments>();
  command
      .add_option("IN", arguments->inputs, "The inputs: .gltf, .glb or .drc files; - reads a GLB from stdin")
      ->required();
  add_format_option(command, arguments->format);
  add_text_output_option(command, arguments->output);
  add_backend_options(command, arguments->backend);
  add_memory_options(command, arguments->memory,
                     "Larger meshes are checked by the CPU in a temporary file of their size.");
  add_examples(command, {{"gltf-psplit validate dragon.glb", "list all errors, or say that the file is valid"},
                         {"gltf-psplit validate out/*.glb", "check several files; fail if any is invalid"},
                         {"gltf-psplit validate a.glb b.glb --format json",
                          "a JSON array with one object for each file"}});
  command.callback([arguments, &action] {
    action = [arguments](const Session& session) { return run_validate(*arguments, session); };
  });
}

}  // namespace psplit
