// The subcommands of gltf-psplit, and what they have in common.
#pragma once

#include <functional>
#include <string>

#include "gltf_ext/convert/convert.h"
#include "src/container/stream_description.h"
#include "tools/gltf_psplit/commands/messages.h"

namespace CLI {
class App;
}

namespace psplit {

// What every subcommand runs with, made from -q, -v and -j.
struct Session {
  Log log;
  ThreadPool pool;
  std::string version;       // of the command
  std::string command_line;  // as a shell takes it, without the folders of files: for reports
  Session(Verbosity verbosity, int thread_count, std::string its_version = "",
          std::string its_command_line = "")
      : log(verbosity),
        pool(thread_count),
        version(std::move(its_version)),
        command_line(std::move(its_command_line)) {}
};

using Action = std::function<Status(const Session&)>;

// Each adds its subcommand; a command line that names it sets `action` while it is parsed.
void add_encode_command(CLI::App& app, Action& action);
void add_batch_command(CLI::App& app, Action& action);
void add_decode_command(CLI::App& app, Action& action);
void add_inspect_command(CLI::App& app, Action& action);
void add_validate_command(CLI::App& app, Action& action);
void add_compare_command(CLI::App& app, Action& action);
void add_generate_command(CLI::App& app, Action& action);

// What decodes.
struct BackendChoice {
  std::string name = "auto";
  uint64_t gpu_memory = 0;  // bytes that the CUDA decoder may take of its device; 0 means what is free
};

// Options that several subcommands take; the arguments outlive the parse.
void add_coding_options(CLI::App& command, EncodeDocumentOptions& options);
void add_partition_options(CLI::App& command, EncodeDocumentOptions& options);
void add_backend_options(CLI::App& command, BackendChoice& choice);
// Where a glTF goes: a word after the input, or -o. To be added after the input's.
void add_output_option(CLI::App& command, std::string& path);
// Where a text or JSON goes that is stdout's by default.
void add_text_output_option(CLI::App& command, std::string& path);
void add_format_option(CLI::App& command, std::string& name,
                       const std::vector<std::string>& forms = {"text", "json"});

// The name is one that add_backend_options lets through.
DecodeBackend find_backend(const BackendChoice& choice);
// Whether there are streams enough to keep a device busy, and bytes enough to be worth the start: else `auto`
// takes the CPU.
bool is_worth_a_gpu(std::span<const DecodeTask> tasks);
// What describes streams with the decoder of that backend, libdraco where `auto` would fall back to it.
DescribeStream find_describer(const std::string& name);

// Any file that read_asset takes (gltf_ext/mesh_files/read_asset.h); what it warns of goes to the log. Of a
// Draco file the document holds the stream, which `backend` described. "-" is stdin.
Expected<Document> read_input(const std::string& path, const Log& log, const std::string& backend = "auto");
// Says which primitives were left as they are, and what others lost.
void log_reports(std::span<const PrimitiveReport> reports, const Log& log, const std::string& prefix = "");
// A text that appears whole or not at all; "-" is stdout.
Status write_text(const std::string& path, const std::string& text);

// JSON to be read by people too. Names of files need not be UTF-8; JSON must.
std::string report_text(const Json& report);

}  // namespace psplit
