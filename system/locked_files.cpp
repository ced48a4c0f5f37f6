// The logs, locks and temporary files of operating_system.h, on all systems.
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <thread>

#include "system/operating_system.h"
#include "system/shared_file.h"

namespace psplit {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kSyncInterval = std::chrono::seconds(1);

Status use_failure(const std::filesystem::path& path) { return io_error("cannot use " + path.string(), errno); }
Status lock_failure(const std::filesystem::path& path) {
  return io_error("cannot lock " + path.string(), errno);
}

// False if another process holds the lock for as long as kLockPatience.
Expected<bool> lock_alone(int descriptor, const std::filesystem::path& path) {
  const auto deadline = Clock::now() + kLockPatience;
  while (!shared_file::try_lock(descriptor, shared_file::Lock::kAlone)) {
    if (errno != EWOULDBLOCK) return lock_failure(path);
    if (Clock::now() > deadline) return false;
    std::this_thread::sleep_for(kLockRefresh);
  }
  return true;
}

// The name of the group in the file of a GroupLock.
std::string read_name(int descriptor) {
  std::array<uint8_t, 64> text;
  const int64_t size = shared_file::read_at(descriptor, 0, text);
  return {text.begin(), text.begin() + std::max<int64_t>(size, 0)};
}

// The file is never empty in between, also if the disk is full.
bool write_name(int descriptor, const std::string& name) {
  const std::span bytes(reinterpret_cast<const uint8_t*>(name.data()), name.size());
  return shared_file::write_at(descriptor, 0, bytes) == static_cast<int64_t>(name.size()) &&
         shared_file::set_size(descriptor, name.size());
}

}  // namespace

Status space_error(const std::string& what, int error) {
  return error == EFBIG ? may_pass(what + ": the limit on a file's size is reached") : io_error(what, error);
}

LockedLog::~LockedLog() {
  if (descriptor_ < 0) return;
  shared_file::sync(descriptor_);
  shared_file::close(descriptor_);
}

Status LockedLog::join(const std::filesystem::path& path) {
  path_ = path;
  descriptor_ = shared_file::open(path, shared_file::Access::kAppend);
  return descriptor_ < 0 ? use_failure(path) : Status();
}

Expected<bool> LockedLog::open(const std::filesystem::path& path) {
  if (Status status = join(path); !status.ok()) return status;
  const Expected<bool> locked = lock_alone(descriptor_, path);
  if (!locked || !*locked) return locked;
  resume();
  return true;
}

void LockedLog::resume() {
  if (descriptor_ < 0) return;
  uint8_t last = '\n';
  const uint64_t end = shared_file::size_of(descriptor_);
  is_cut_short_ = end > 0 && shared_file::read_at(descriptor_, end - 1, {&last, 1}) == 1 && last != '\n';
}

Status LockedLog::append(std::string_view lines) {
  std::string text = is_cut_short_ ? "\n" : "";
  text += lines;
  const int64_t written = shared_file::append(descriptor_, text);
  if (written == static_cast<int64_t>(text.size())) {
    is_cut_short_ = false;
    return Clock::now() - synced_ < kSyncInterval ? Status() : sync();
  }
  if (written < 0) return use_failure(path_);
  // A write in part has no error of its own: the disk is full.
  is_cut_short_ = true;
  errno = ENOSPC;
  return use_failure(path_);
}

Status LockedLog::sync() {
  synced_ = Clock::now();
  return shared_file::sync(descriptor_) ? Status() : use_failure(path_);
}

bool is_owned(const std::filesystem::path& path) {
  const int descriptor = shared_file::open(path, shared_file::Access::kRead);
  if (descriptor < 0) return false;
  // A shared lock, for a moment: one who wants to own the file then waits.
  const bool is_free = shared_file::try_lock(descriptor, shared_file::Lock::kTogether) || errno != EWOULDBLOCK;
  shared_file::close(descriptor);
  return !is_free;
}

GroupLock::~GroupLock() {
  if (descriptor_ >= 0) shared_file::close(descriptor_);
}

Status GroupLock::open(const std::filesystem::path& path) {
  descriptor_ = shared_file::open(path, shared_file::Access::kWrite);
  return descriptor_ < 0 ? use_failure(path) : Status();
}

Expected<bool> GroupLock::join(const std::filesystem::path& path, const std::string& group) {
  if (Status status = open(path); !status.ok()) return status;
  for (const auto deadline = Clock::now() + kLockPatience;; std::this_thread::sleep_for(kLockRefresh)) {
    // The first process of a group is alone for the moment in which it writes the name.
    if (shared_file::try_lock(descriptor_, shared_file::Lock::kAlone)) {
      const bool is_named = read_name(descriptor_) == group || write_name(descriptor_, group);
      const Status status = is_named ? Status() : use_failure(path);
      shared_file::unlock(descriptor_);  // a lock is not exchanged for a shared one: others may be first
      if (!status.ok()) return status;
    } else if (errno != EWOULDBLOCK) {
      return lock_failure(path);
    }
    if (shared_file::try_lock(descriptor_, shared_file::Lock::kTogether)) {
      if (read_name(descriptor_) == group) return true;
      shared_file::unlock(descriptor_);
    } else if (errno != EWOULDBLOCK) {
      return lock_failure(path);
    }
    if (Clock::now() > deadline) return false;
  }
}

Expected<std::optional<std::string>> GroupLock::take(const std::filesystem::path& path) {
  if (Status status = open(path); !status.ok()) return status;
  const Expected<bool> locked = lock_alone(descriptor_, path);
  if (!locked) return locked.status();
  return *locked ? std::optional(read_name(descriptor_)) : std::nullopt;
}

void UnnamedFile::close() {
  if (descriptor_ >= 0) shared_file::close(descriptor_);
  descriptor_ = -1;
}

Status UnnamedFile::write(uint64_t offset, std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const int64_t written = shared_file::write_at(descriptor_, offset, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      return space_error("cannot write a temporary file in " + folder_.string(), written == 0 ? ENOSPC : errno);
    bytes = bytes.subspan(static_cast<size_t>(written));
    offset += static_cast<uint64_t>(written);
  }
  return {};
}

Status UnnamedFile::read(uint64_t offset, std::span<uint8_t> to) const {
  while (!to.empty()) {
    const int64_t got = shared_file::read_at(descriptor_, offset, to);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      return io_error("cannot read a temporary file in " + folder_.string(), got == 0 ? EIO : errno);
    to = to.subspan(static_cast<size_t>(got));
    offset += static_cast<uint64_t>(got);
  }
  return {};
}

}  // namespace psplit
