#include "tools/gltf_psplit/report/log.h"

#include <cstdio>

#include "system/operating_system.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

// One call for each line, so that the lines of several threads do not mix.
void print_line(const std::string& line) {
  std::fputs(("gltf-psplit: " + printable(line) + "\n").c_str(), stderr);
}

}  // namespace

void Log::error(const Status& status) const { print_line("error: " + status.to_string()); }
void Log::warning(const std::string& message) const {
  if (verbosity_ != Verbosity::kQuiet) print_line("warning: " + message);
}
void Log::note(const std::string& message) const {
  if (verbosity_ != Verbosity::kQuiet) print_line(message);
}
void Log::detail(const std::string& message) const {
  if (shows_details()) print_line(message);
}
void Log::block(const std::string& lines) const {
  if (verbosity_ != Verbosity::kQuiet) std::fputs(printable(lines, true).c_str(), stderr);
}
bool Log::interactive() const { return verbosity_ != Verbosity::kQuiet && is_terminal(stderr); }

bool stdout_is_terminal() { return is_terminal(stdout); }

}  // namespace psplit
