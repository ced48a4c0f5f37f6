#include "tools/gltf_psplit/files/text_output.h"

#include "gltf_ext/json/json_text.h"
#include "system/files.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {

Status write_text(const std::string& path, const std::string& text, IfReadOnly if_read_only) {
  if (path == "-" && stdout_is_terminal()) {
    const std::string shown = printable(text, true);
    return write_file(path, {{reinterpret_cast<const uint8_t*>(shown.data()), shown.size()}});
  }
  return write_file(path, {{reinterpret_cast<const uint8_t*>(text.data()), text.size()}}, if_read_only);
}

std::string report_text(const Json& report) { return json_lines(report) + "\n"; }

}  // namespace psplit
