// The output of commands that write a text or JSON, on stdout by default.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/files/files.h"
#include "gltf_ext/json/json.h"
#include "src/status.h"

namespace CLI {
class App;
}

namespace psplit {

// -o: where the text goes. `path` must outlive the parse.
void add_text_output_option(CLI::App& command, std::string& path);
// --format: one of `forms`. `name` must outlive the parse.
void add_format_option(CLI::App& command, std::string& name,
                       const std::vector<std::string>& forms = {"text", "json"});

// Writes the whole text or, on an error, nothing; "-" is stdout.
Status write_text(const std::string& path, const std::string& text,
                  IfReadOnly if_read_only = IfReadOnly::kFail);

// Indented JSON. Names of files need not be UTF-8, but JSON must be: other bytes become U+FFFD.
std::string report_text(const Json& report);

}  // namespace psplit
