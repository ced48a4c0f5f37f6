// A progress bar on stderr. It appears on a terminal if the work takes longer than a second.
#pragma once

#include <memory>
#include <string>

#include "psplit/decode.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// The progress of some work.
struct WorkDone {
  uint64_t done = 0, total = 0;  // steps
  std::string noun = "step";
  std::string stage{};  // the current activity, if the steps do not name it
  // What the rate counts: `amount_noun` ("face", "byte") and how many are done. By default the rate counts
  // steps.
  uint64_t amount = 0;
  std::string amount_noun{};
  std::string label{};  // of the line from now on; by default that of the bar
};

// "encoding [#####...............] 120 of 450 patches, 9 s left, 1,234,567 faces/s, 3.4 s". A single step has
// no bar, and there are no rate and no time left before anything is done. `seconds` have passed under this
// label.
std::string progress_line(const std::string& label, const WorkDone& work, double seconds);

// Draws from its own thread, so that the time advances on the screen while one long step runs. Clears its line
// when it is destroyed. Draws nothing if the log is not interactive.
class ProgressBar {
 public:
  ProgressBar(std::string label, const Log& log);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Takes the number of steps done and their total; 0 if it is not known. Thread-safe; the bar must outlive it.
  // Empty if nothing is drawn. A label that differs from the last one begins a new phase of the work.
  Progress callback(const std::string& noun = "step", const std::string& label = "");
  // Shows what the callback cannot: a stage, an amount. Thread-safe.
  void show(const WorkDone& work);

 private:
  struct Painter;
  std::unique_ptr<Painter> painter_;
};

}  // namespace psplit
