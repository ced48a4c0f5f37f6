#include "tools/gltf_psplit/report/progress.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

#include "gltf_ext/files/operating_system.h"
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
  if (work.amount_noun == "byte") return as_bytes(rate) + "/s, ";
  // A rate below two steps a second says nothing.
  if (of_steps && rate < 2) return "";
  return with_separators(rate) + " " + plural(of_steps ? work.noun : work.amount_noun) + "/s, ";
}

}  // namespace

std::string progress_line(const std::string& label, const WorkDone& work, double seconds) {
  std::string line = printable(label);
  // A bar of one step says nothing.
  if (work.total > 1) {
    const size_t filled =
        work.done >= work.total ? kBarWidth : static_cast<size_t>(kBarWidth * work.done / work.total);
    line += " [" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] " +
            with_separators(work.done) + " of " + counted(work.total, work.noun) + ",";
  }
  if (!work.stage.empty()) line += " " + work.stage + ",";
  line += " " + rate_text(work, seconds) + with_decimals(seconds, 1) + " s";
  if (line.size() > kLineWidth) line.resize(kLineWidth);
  return line;
}

struct ProgressBar::Painter {
  std::string label;
  std::mutex mutex;
  std::condition_variable wake;
  WorkDone work;
  bool finished = false;
  std::thread thread;

  void paint() {
    const Clock::time_point begin = Clock::now();
    const size_t columns = terminal_columns(stderr);
    const size_t width = columns == 0 ? kLineWidth : std::min(kLineWidth, columns - 1);
    bool painted = false;
    std::unique_lock lock(mutex);
    for (Clock::time_point next = begin + kPatience; !wake.wait_until(lock, next, [&] { return finished; });
         next = Clock::now() + kRefresh) {
      const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      std::fprintf(stderr, "\r\033[K%s", progress_line(label, work, seconds).substr(0, width).c_str());
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

Progress ProgressBar::callback(const std::string& noun) {
  if (!painter_) return {};
  return [this, noun](size_t done, size_t total) {
    WorkDone work;
    work.done = done;
    work.total = total;
    work.noun = noun;
    show(work);
  };
}

void ProgressBar::show(const WorkDone& work) {
  if (!painter_) return;
  const std::lock_guard lock(painter_->mutex);
  painter_->work = work;
}

}  // namespace psplit
