// A progress bar on stderr for work that takes over a second on a terminal.
#pragma once

#include <memory>
#include <string>

#include "gltf_ext/convert.h"
#include "tools/gltf_psplit/messages.h"

namespace psplit {

// Draws from a thread of its own, so that time passes on the screen while one long step runs, and wipes its
// line when destroyed. Does nothing at all where the log is not interactive.
class ProgressBar {
 public:
  ProgressBar(std::string label, const Log& log);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Takes the numbers of steps done and in total, from any thread; the bar must outlive it.
  Progress callback();

 private:
  struct Painter;
  std::unique_ptr<Painter> painter_;
};

// The bar itself; without a total it only shows the time.
std::string progress_line(const std::string& label, size_t done, size_t total, double seconds);

}  // namespace psplit
