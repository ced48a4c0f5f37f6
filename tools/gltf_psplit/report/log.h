// The log of gltf-psplit: errors, warnings and notes on stderr.
#pragma once

#include <string>

#include "psplit/base.h"

namespace psplit {

enum class Verbosity { kQuiet, kNormal, kVerbose };

// Lines on stderr, each "gltf-psplit: ...". Thread-safe.
class Log {
 public:
  explicit Log(Verbosity verbosity) : verbosity_(verbosity) {}
  void error(const Status& status) const;          // always
  void warning(const std::string& message) const;  // not with -q
  void note(const std::string& message) const;     // not with -q
  void detail(const std::string& message) const;   // only with -v
  bool shows_details() const { return verbosity_ == Verbosity::kVerbose; }
  void block(const std::string& lines) const;  // several lines, printed as they are; not with -q
  // Whether a progress bar is welcome: stderr is a terminal, and -q is not given.
  bool interactive() const;

 private:
  Verbosity verbosity_;
};

// Whether stdout is read by a person rather than by a program.
bool stdout_is_terminal();

}  // namespace psplit
