#include "tools/gltf_psplit/progress.h"

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

namespace psplit {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPatience = std::chrono::seconds(1);
constexpr auto kRefresh = std::chrono::milliseconds(100);
constexpr size_t kBarWidth = 30;

}  // namespace

std::string progress_line(const std::string& label, size_t done, size_t total, double seconds) {
  std::string line = label;
  // One step says nothing about how far it is.
  if (total > 1) {
    const size_t filled = done >= total ? kBarWidth : kBarWidth * done / total;
    line += " [" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] " +
            std::to_string(done) + "/" + std::to_string(total);
  }
  return line + " " + with_decimals(seconds, 1) + " s";
}

struct ProgressBar::Painter {
  std::string label;
  std::mutex mutex;
  std::condition_variable wake;
  size_t done = 0, total = 0;
  bool finished = false;
  std::thread thread;

  void paint() {
    const Clock::time_point begin = Clock::now();
    bool painted = false;
    std::unique_lock lock(mutex);
    for (Clock::time_point next = begin + kPatience; !wake.wait_until(lock, next, [&] { return finished; });
         next = Clock::now() + kRefresh) {
      const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      std::fprintf(stderr, "\r\033[K%s", progress_line(label, done, total, seconds).c_str());
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

Progress ProgressBar::callback() {
  if (!painter_) return {};
  return [painter = painter_.get()](size_t done, size_t total) {
    const std::lock_guard lock(painter->mutex);
    painter->done = done;
    painter->total = total;
  };
}

}  // namespace psplit
