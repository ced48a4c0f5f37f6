// What the commands have in common that write assets and reports: options, protection of inputs, and what is
// said.
#pragma once

#include <span>
#include <string>

#include "gltf_ext/document/document.h"
#include "tools/gltf_psplit/commands/messages.h"

namespace CLI {
class App;
}

namespace psplit {

// --images; the option outlives the parse.
void add_images_option(CLI::App& command, WriteOptions& options);
// The value of --images that the options came of, for a record of them.
std::string describe_images(const WriteOptions& options);

// kUsage where writing `path`, named by `option`, would replace a file that the document was read from, or one
// that it names: its images, and what its extensions name. By links as well.
Status check_not_an_input(const std::string& path, const std::string& option, const Document& document);
// The same of files by their names alone, before any is read.
Status check_not_an_input(const std::string& path, const std::string& option,
                          std::span<const std::string> inputs);
// The same of the files of an output.
Status check_not_an_output(const std::string& path, const std::string& option, const WriteReport& written);

// Says what dangles, and what has another name.
void log_written(const WriteReport& report, const Log& log, const std::string& prefix = "");
// The same as JSON: "images" and "warnings" of an asset.
void append_written(Json& object, const WriteReport& report);

}  // namespace psplit
