// A progress bar on stderr for work that takes over a second on a terminal.
#pragma once

#include <memory>
#include <string>

#include "src/container/decode_backend.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// How far some work is.
struct WorkDone {
  uint64_t done = 0, total = 0;  // steps
  std::string noun = "step";
  std::string stage;  // what is going on where steps do not tell
  // What the rate is of, so far: "face", or "byte". By default it is of steps.
  uint64_t amount = 0;
  std::string amount_noun;
};

// "encoding [#####...............] 120 of 450 patches, 1,234,567 faces/s, 3.4 s". Without a second step there
// is no bar, and no rate before anything is done.
std::string progress_line(const std::string& label, const WorkDone& work, double seconds);

// Draws from a thread of its own, so that time passes on the screen while one long step runs, and wipes its
// line when destroyed. Does nothing at all where the log is not interactive.
class ProgressBar {
 public:
  ProgressBar(std::string label, const Log& log);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Takes the numbers of steps done and in total, from any thread; the bar must outlive it. Empty where nothing
  // is drawn.
  Progress callback(const std::string& noun = "step");
  // For what has more to say; from any thread.
  void show(const WorkDone& work);
  bool is_drawn() const { return painter_ != nullptr; }

 private:
  struct Painter;
  std::unique_ptr<Painter> painter_;
};

}  // namespace psplit
