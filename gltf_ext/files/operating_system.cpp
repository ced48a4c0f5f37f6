#include "gltf_ext/files/operating_system.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace psplit {
namespace {

Status failure(const std::filesystem::path& path) {
  return io_failure("cannot use " + path.string() + ": " + std::strerror(errno));
}

}  // namespace

std::FILE* create_locked(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return nullptr;
  // A file system without locks is fine: no other process can take a lock to remove the file either.
  const bool is_taken = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  struct stat status {};
  const bool is_removed = ::fstat(descriptor, &status) == 0 && status.st_nlink == 0;
  if (!is_taken && !is_removed)
    if (std::FILE* file = ::fdopen(descriptor, "wb")) return file;
  const int error = is_taken || is_removed ? EEXIST : errno;
  ::close(descriptor);
  errno = error;
  return nullptr;
}

void remove_if_unlocked(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(path.c_str());
  ::close(descriptor);
}

void let_writes_past_size_limit_fail() { std::signal(SIGXFSZ, SIG_IGN); }

LockedLog::~LockedLog() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Expected<bool> LockedLog::open(const std::filesystem::path& path) {
  path_ = path;
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) return failure(path);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno == EWOULDBLOCK) return false;
  return failure(path);
}

Status LockedLog::append(std::string_view text) const {
  if (::write(descriptor_, text.data(), text.size()) == static_cast<ssize_t>(text.size())) return {};
  return failure(path_);
}

bool may_write_into(const std::filesystem::path& folder) { return ::access(folder.c_str(), W_OK | X_OK) == 0; }

bool is_terminal(std::FILE* stream) { return ::isatty(::fileno(stream)) == 1; }

size_t terminal_columns(std::FILE* stream) {
  winsize size{};
  return ::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
#endif
}

}  // namespace psplit
