#include "gltf_ext/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace psplit {

std::FILE* create_locked(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return nullptr;
  // Where a file system has no locks, nobody can take one to remove the file either.
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

}  // namespace psplit
