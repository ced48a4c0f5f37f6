#include "tools/gltf_psplit/files/text_output.h"

#include <CLI/CLI.hpp>

#include "gltf_ext/files/files.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {

void add_text_output_option(CLI::App& command, std::string& path) {
  command.add_option("-o,--output", path, "File for the result; - is stdout")
      ->capture_default_str()
      ->type_name("FILE");
}

void add_format_option(CLI::App& command, std::string& name, const std::vector<std::string>& forms) {
  command.add_option("--format", name, "Format of the result")
      ->check(CLI::IsMember(forms))
      ->capture_default_str()
      ->type_name("FORM");
}

Status write_text(const std::string& path, const std::string& text, IfReadOnly if_read_only) {
  if (path == "-" && stdout_is_terminal()) {
    const std::string shown = printable(text, true);
    return write_file(path, {{reinterpret_cast<const uint8_t*>(shown.data()), shown.size()}});
  }
  return write_file(path, {{reinterpret_cast<const uint8_t*>(text.data()), text.size()}}, if_read_only);
}

std::string report_text(const Json& report) {
  return report.dump(2, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) + "\n";
}

}  // namespace psplit
