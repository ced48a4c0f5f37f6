#include "tools/gltf_psplit/report/progress.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

#include "system/operating_system.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPatience = std::chrono::seconds(1);
constexpr auto kRefresh = std::chrono::milliseconds(100);
constexpr size_t kBarWidth = 20;
// A line that wraps cannot be cleared.
constexpr size_t kLineWidth = 79;

std::string rate_text(const WorkDone& work, double seconds) {
  const bool of_steps = work.amount_noun.empty();
  const double amount = static_cast<double>(of_steps ? work.done : work.amount);
  if (amount == 0 || seconds <= 0) return "";
  const auto rate = static_cast<uint64_t>(amount / seconds);
  if ((of_steps ? work.noun : work.amount_noun) == "byte") return as_bytes(rate) + "/s, ";
  // A rate below two steps a second says nothing.
  if (of_steps && rate < 2) return "";
  return with_separators(rate) + " " + plural(of_steps ? work.noun : work.amount_noun) + "/s, ";
}

// "9 s left", "4 min left": as if all steps took as long as those before.
std::string time_left_text(const WorkDone& work, double seconds) {
  if (work.done == 0 || work.done >= work.total || seconds <= 0) return "";
  const double left = seconds * static_cast<double>(work.total - work.done) / static_cast<double>(work.done);
  constexpr double kMinute = 60, kHour = 3600;
  const auto rounded = [left](double unit) {
    return with_separators(static_cast<uint64_t>(left / unit + 0.5));
  };
  return " " +
         (left < 2 * kMinute ? rounded(1) + " s"
          : left < 2 * kHour ? rounded(kMinute) + " min"
                             : rounded(kHour) + " h") +
         " left,";
}

// Bytes are rounded: "12.3 of 45.6 MB" says more than all digits.
std::string steps_text(const WorkDone& work) {
  if (work.noun == "byte") return as_bytes(work.done) + " of " + as_bytes(work.total);
  return with_separators(work.done) + " of " + counted(work.total, work.noun);
}

}  // namespace

std::string progress_line(const std::string& label, const WorkDone& work, double seconds) {
  std::string line = printable(label);
  // A bar of one step says nothing.
  if (work.total > 1) {
    const size_t filled =
        work.done >= work.total ? kBarWidth : static_cast<size_t>(kBarWidth * work.done / work.total);
    line += " [" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] " + steps_text(work) +
            "," + time_left_text(work, seconds);
  }
  if (!work.stage.empty()) line += " " + work.stage + ",";
  line += " " + rate_text(work, seconds);
  const std::string elapsed = with_decimals(seconds, 1) + " s";
  if (line.size() + elapsed.size() <= kLineWidth) return line + elapsed;
  // A full line does without the time that has passed.
  line.resize(std::min(line.find_last_not_of(", ") + 1, kLineWidth));
  return line;
}

struct ProgressBar::Painter {
  std::string label;
  std::mutex mutex;
  std::condition_variable wake;
  WorkDone work;
  Clock::time_point phase_begin;
  bool finished = false;
  std::thread thread;

  void paint() {
    const Clock::time_point begin = Clock::now();
    phase_begin = begin;
    const size_t columns = terminal_columns(stderr);
    const size_t width = columns == 0 ? kLineWidth : std::min(kLineWidth, columns - 1);
    bool painted = false;
    std::unique_lock lock(mutex);
    for (Clock::time_point next = begin + kPatience; !wake.wait_until(lock, next, [&] { return finished; });
         next = Clock::now() + kRefresh) {
      const double seconds = std::chrono::duration<double>(Clock::now() - phase_begin).count();
      std::fprintf(
          stderr, "\r\033[K%s",
          progress_line(work.label.empty() ? label : work.label, work, seconds).substr(0, width).c_str());
      std::fflush(stderr);
      painted = true;
    }
    if (painted) std::fputs("\r\033[K", stderr);
  }
};

ProgressBar::ProgressBar(std::string label, const Log& log) {
  if (!log.interactive()) return;
  painter_ = std::make_unique<Painter>();
  painter_->label = std::move(label);
  painter_->thread = std::thread([painter = painter_.get()] { painter->paint(); });
}

ProgressBar::~ProgressBar() {
  if (!painter_) return;
  {
    const std::lock_guard lock(painter_->mutex);
    painter_->finished = true;
  }
  painter_->wake.notify_one();
  painter_->thread.join();
}

Progress ProgressBar::callback(const std::string& noun, const std::string& label) {
  if (!painter_) return {};
  return [this, noun, label](size_t done, size_t total) {
    WorkDone work;
    work.done = done;
    work.total = total;
    work.noun = noun;
    work.label = label;
    show(work);
  };
}

void ProgressBar::show(const WorkDone& work) {
  if (!painter_) return;
  const std::lock_guard lock(painter_->mutex);
  if (painter_->work.label != work.label) painter_->phase_begin = Clock::now();
  painter_->work = work;
}

}  // namespace psplit
