#include "system/operating_system.h"

#include <fcntl.h>
#include <fnmatch.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/vfs.h>
#endif

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "src/scratch_memory.h"
#include "system/child_process.h"
#include "system/io_error.h"
#include "system/mapped_ranges.h"
#include "system/removed_at_stop.h"
#include "system/shared_file.h"

namespace psplit {
namespace {

Status failure(const std::filesystem::path& path) { return io_error("cannot use " + path.string(), errno); }

// Some file systems cannot sync; they return EINVAL. On macOS, fsync leaves the data in the memory of the
// drive.
bool sync_descriptor(int descriptor) {
#ifdef F_FULLFSYNC
  if (::fcntl(descriptor, F_FULLFSYNC) != -1) return true;
#endif
  return ::fsync(descriptor) == 0 || errno == EINVAL;
}

// macOS refuses to read or write more than 2 GiB at once.
constexpr size_t kMostAtOnce = size_t{1} << 30;

struct sigaction handler_before;  // of SIGBUS

// Signal handlers call only async-signal-safe functions.
void print_in_handler(const char* text) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
}

void end_with_file_name(int signal_number, siginfo_t* info, void*) {
  const MappedRange* range = mapped_range_at(reinterpret_cast<uintptr_t>(info->si_addr));
  const bool is_sent = info->si_code <= 0;  // by a process, not by the use of memory
  if (is_sent || range == nullptr) {
    ::sigaction(signal_number, &handler_before, nullptr);
    // The faulting access repeats, and raises the signal again. macOS does not tell whether a signal was sent.
#ifndef __APPLE__
    if (is_sent)
#endif
      ::raise(signal_number);
    return;
  }
  print_in_handler("gltf-psplit: error: ");
  print_in_handler(range->name.load(std::memory_order_relaxed));
  print_in_handler(": the file became shorter, or its device failed, while it was read\n");
  ::_exit(kExitIo);
}

constexpr std::array kStopSignals = {SIGTERM, SIGINT, SIGHUP};
std::array<struct sigaction, kStopSignals.size()> stop_handlers_before;

void end_at_stop(int) {
  RemovedAtStop::remove_all([](const char* name) { ::unlink(name); });
  // On a terminal, the line of a progress bar is overwritten.
  print_in_handler(::isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "");
  print_in_handler("gltf-psplit: error: stopped by a signal\n");
  ::_exit(kExitMayPass);
}

void install_handler() {
  struct sigaction action {};
  action.sa_sigaction = end_with_file_name;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  ::sigaction(SIGBUS, &action, &handler_before);
}
void uninstall_handler() { ::sigaction(SIGBUS, &handler_before, nullptr); }

// Takes the space of a new file before it is used. The result is an errno. EINVAL and EOPNOTSUPP: a file system
// that cannot.
int take_space(int descriptor, off_t bytes) {
#ifdef __APPLE__
  fstore_t space{F_ALLOCATEALL, F_PEOFPOSMODE, 0, bytes, 0};
  if (::fcntl(descriptor, F_PREALLOCATE, &space) == -1) return errno == ENOTSUP ? EOPNOTSUPP : errno;
  return ::ftruncate(descriptor, bytes) == 0 ? 0 : errno;
#else
  return ::posix_fallocate(descriptor, 0, bytes);
#endif
}

bool enter(std::span<const uint8_t> bytes, const std::filesystem::path& path) {
  return enter_mapped(bytes, path, nullptr, install_handler);
}

#if defined(__GLIBC__) && defined(__linux__)
// Whether the system refuses memory that is reserved beyond what it has, even if it is never touched.
bool counts_reserved_memory() {
  std::ifstream mode("/proc/sys/vm/overcommit_memory");
  return mode.get() == '2';
}
#endif

}  // namespace

std::vector<char*> start_command(int argc, char** argv) { return {argv, argv + argc}; }

std::FILE* open_file(const std::filesystem::path& path, const char* mode) {
  std::FILE* const file = std::fopen(path.c_str(), mode);
#ifdef __APPLE__
  // There these begin where the descriptor was last used. A pipe cannot be moved, and is left.
  const bool is_shared = path.string().starts_with("/dev/fd/") || path == "/dev/stdin";
  if (file != nullptr && mode[0] == 'r' && is_shared) std::fseek(file, 0, SEEK_SET);
#endif
  return file;
}

std::FILE* open_temporary() { return std::tmpfile(); }

bool seek_to(std::FILE* file, uint64_t offset) {
  return ::fseeko(file, static_cast<off_t>(offset), SEEK_SET) == 0;
}

std::filesystem::file_type file_type_at(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::status(path, error).type();
}

bool is_searched_folder(const std::filesystem::path& path) {
  std::error_code error;
  return !path.filename().string().starts_with('.') &&
         std::filesystem::is_directory(std::filesystem::symlink_status(path, error));
}

std::string name_to_compare(const std::string& name) {
  std::string folded = name;
#ifdef __APPLE__
  for (char& c : folded) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
#endif
  return folded;
}
std::string allowed_name(std::string name) { return name; }
std::string length_hint(const std::filesystem::path&) { return ""; }

Status replace_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  return error ? io_error("cannot write", error) : Status();
}

std::error_code rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::create_hard_link(from, to, error);
  if (!error || error == std::errc::file_exists) return error;
  // Some file systems have no hard links.
  if (std::filesystem::exists(std::filesystem::symlink_status(to, error)))
    return std::make_error_code(std::errc::file_exists);
  std::filesystem::rename(from, to, error);
  return error;
}

std::span<const uint8_t> map_file(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return {};
  struct stat status {};
  const bool is_mappable = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0 &&
                           static_cast<uintmax_t>(status.st_size) <= SIZE_MAX;
  const size_t size = is_mappable ? static_cast<size_t>(status.st_size) : 0;
  void* address = is_mappable ? ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0) : MAP_FAILED;
  ::close(descriptor);
  if (address == MAP_FAILED) return {};
  const std::span<const uint8_t> bytes(static_cast<const uint8_t*>(address), size);
  if (enter(bytes, path)) return bytes;
  ::munmap(address, size);
  return {};
}

Expected<std::span<const uint8_t>> map_file(const UnnamedFile& file) {
  const std::string what = "cannot map a temporary file in " + file.folder_.string();
  struct stat status {};
  if (::fstat(file.descriptor_, &status) != 0) return io_error(what, errno);
  const auto size = static_cast<size_t>(status.st_size);
  if (size == 0) return std::span<const uint8_t>();
  void* const address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.descriptor_, 0);
  if (address == MAP_FAILED) return io_error(what, errno);
  const std::span<const uint8_t> bytes(static_cast<const uint8_t*>(address), size);
  if (enter(bytes, file.folder_ / "(temporary file)")) return bytes;
  ::munmap(address, size);
  return may_pass("too many mapped files");
}

Expected<std::span<uint8_t>> map_space(const UnnamedFile& file, uint64_t bytes) {
  constexpr const char* kName = "a temporary file";
  if (bytes == 0) return std::span<uint8_t>();
  if (bytes > static_cast<uint64_t>(PTRDIFF_MAX)) return io_error("cannot map " + std::string(kName), EFBIG);
  const int error = take_space(file.descriptor_, static_cast<off_t>(bytes));
  const bool is_sparse = error == EINVAL || error == EOPNOTSUPP;
  if ((error != 0 && !is_sparse) ||
      (is_sparse && ::ftruncate(file.descriptor_, static_cast<off_t>(bytes)) != 0))
    return space_error("cannot take " + std::to_string(bytes) + " bytes of temporary space",
                       is_sparse ? errno : error);
  const auto size = static_cast<size_t>(bytes);
  void* const address = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor_, 0);
  if (address == MAP_FAILED) return io_error("cannot map " + std::string(kName), errno);
  const std::span<uint8_t> mapped(static_cast<uint8_t*>(address), size);
  if (enter(mapped, kName)) return mapped;
  ::munmap(address, size);
  return io_error("cannot map " + std::string(kName), EMFILE);
}

void unmap_file(std::span<const uint8_t> bytes) {
  leave_mapped(bytes, uninstall_handler);
  ::munmap(const_cast<uint8_t*>(bytes.data()), bytes.size());
}

void release_mapped(std::span<const uint8_t> bytes) {
  const auto first = reinterpret_cast<uintptr_t>(bytes.data());
  const MappedRange* range = mapped_range_at(first);
  if (range == nullptr) return;
  const auto page = static_cast<uintptr_t>(::sysconf(_SC_PAGESIZE));
  const uintptr_t file_end = range->end.load(std::memory_order_relaxed);
  const uintptr_t last = std::min(first + bytes.size(), file_end);
  const uintptr_t begin = (first + page - 1) / page * page;
  // The last page of a file is usually not full.
  const uintptr_t end = last == file_end ? (last + page - 1) / page * page : last / page * page;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

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

void remove_if_unlocked(const std::filesystem::path& path, const std::function<bool()>& before) {
  // The file is opened for writing, because NFS locks no other files.
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && (!before || before())) ::unlink(path.c_str());
  ::close(descriptor);
}

bool sync_to_disk(std::FILE* file) { return std::fflush(file) == 0 && sync_descriptor(::fileno(file)); }

Status sync_to_disk(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return failure(folder);
  const Status status = sync_descriptor(descriptor) ? Status() : failure(folder);
  ::close(descriptor);
  return status;
}

bool matches_pattern(const std::string& name, const std::string& pattern) {
  return ::fnmatch(pattern.c_str(), name.c_str(), FNM_PERIOD) == 0;
}

StopEndsProcess::StopEndsProcess() {
  for (size_t i = 0; i < kStopSignals.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = end_at_stop;
    ::sigaction(kStopSignals[i], &action, &stop_handlers_before[i]);
    if (stop_handlers_before[i].sa_handler == SIG_IGN)  // as nohup does
      ::sigaction(kStopSignals[i], &stop_handlers_before[i], nullptr);
  }
}

StopEndsProcess::~StopEndsProcess() {
  for (size_t i = 0; i < kStopSignals.size(); ++i)
    ::sigaction(kStopSignals[i], &stop_handlers_before[i], nullptr);
}

void let_writes_past_size_limit_fail() { std::signal(SIGXFSZ, SIG_IGN); }

int shared_file::open(const std::filesystem::path& path, Access access) {
  const int flags = access == Access::kRead    ? O_RDONLY
                    : access == Access::kWrite ? O_RDWR | O_CREAT
                                               : O_RDWR | O_CREAT | O_APPEND;
  return ::open(path.c_str(), flags | O_CLOEXEC, 0666);
}
void shared_file::close(int descriptor) { ::close(descriptor); }

bool shared_file::try_lock(int descriptor, Lock lock) {
  return ::flock(descriptor, (lock == Lock::kAlone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0;
}
void shared_file::unlock(int descriptor) { ::flock(descriptor, LOCK_UN); }

int64_t shared_file::read_at(int descriptor, uint64_t offset, std::span<uint8_t> to) {
  return ::pread(descriptor, to.data(), std::min(to.size(), kMostAtOnce), static_cast<off_t>(offset));
}
int64_t shared_file::write_at(int descriptor, uint64_t offset, std::span<const uint8_t> bytes) {
  return ::pwrite(descriptor, bytes.data(), std::min(bytes.size(), kMostAtOnce), static_cast<off_t>(offset));
}
int64_t shared_file::append(int descriptor, std::string_view text) {
  return ::write(descriptor, text.data(), text.size());
}

uint64_t shared_file::size_of(int descriptor) {
  return static_cast<uint64_t>(std::max<off_t>(::lseek(descriptor, 0, SEEK_END), 0));
}
bool shared_file::set_size(int descriptor, uint64_t bytes) {
  return ::ftruncate(descriptor, static_cast<off_t>(bytes)) == 0;
}
bool shared_file::sync(int descriptor) { return sync_descriptor(descriptor); }

std::filesystem::path UnnamedFile::path() const {
  const std::filesystem::path path = "/dev/fd/" + std::to_string(descriptor_);
  std::error_code error;
  return std::filesystem::exists(path, error) ? path : std::filesystem::path();
}

Expected<UnnamedFile> UnnamedFile::create(const std::filesystem::path& folder) {
  UnnamedFile file;
  file.folder_ = folder.empty() ? "." : folder;
#ifdef O_TMPFILE
  file.descriptor_ = ::open(file.folder_.c_str(), O_RDWR | O_TMPFILE | O_CLOEXEC, 0600);
#endif
  if (file.descriptor_ < 0) {  // a file system without such files: the name exists for a moment
    std::string name = (file.folder_ / ".psplit-XXXXXX").string();
    file.descriptor_ = ::mkstemp(name.data());
    if (file.descriptor_ >= 0) {
      ::unlink(name.c_str());
      ::fcntl(file.descriptor_, F_SETFD, FD_CLOEXEC);
    }
  }
  if (file.descriptor_ < 0)
    return io_error("cannot create a temporary file in " + file.folder_.string(), errno);
  return file;
}

bool is_in_memory(const std::filesystem::path& folder) {
#ifdef __linux__
  constexpr uint32_t kTmpfs = 0x01021994, kRamfs = 0x858458f6;  // statfs(2)
  struct statfs status {};
  if (::statfs(folder.c_str(), &status) != 0) return false;
  const auto type = static_cast<uint32_t>(status.f_type);
  return type == kTmpfs || type == kRamfs;
#else
  static_cast<void>(folder);
  return false;
#endif
}

bool is_read_only(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return false;
  return (status.st_mode & (S_IWUSR | S_IWGRP | S_IWOTH)) == 0 || ::access(path.c_str(), W_OK) != 0;
}

void copy_permissions(const std::filesystem::path& from, std::FILE* to) {
  struct stat status {};
  if (::stat(from.c_str(), &status) != 0) return;
  const int descriptor = ::fileno(to);
  struct stat now {};
  if (::fstat(descriptor, &now) != 0) return;
  // Only root may give files away. Others may set a group that they belong to.
  const bool is_same = now.st_uid == status.st_uid && now.st_gid == status.st_gid;
  if (!is_same && ::fchown(descriptor, status.st_uid, status.st_gid) != 0 &&
      ::fchown(descriptor, static_cast<uid_t>(-1), status.st_gid) != 0)
    status.st_mode &= ~static_cast<mode_t>(S_IRWXG);  // meant for another group
  ::fchmod(descriptor, status.st_mode & (S_IRWXU | S_IRWXG | S_IRWXO));
}

bool may_write_into(const std::filesystem::path& folder) { return ::access(folder.c_str(), W_OK | X_OK) == 0; }

bool is_terminal(std::FILE* stream) { return ::isatty(::fileno(stream)) == 1; }

size_t terminal_columns(std::FILE* stream) {
  winsize size{};
  return ::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

void expect_large_arrays() {
#ifdef __GLIBC__
  // AddressSanitizer's malloc takes no options. It would write an eighth of the reserved memory.
  if (mallopt(M_MMAP_MAX, 0) != 1 || mallopt(M_TRIM_THRESHOLD, -1) != 1) return;
#if defined(__linux__)
  // malloc takes memory at the end of its own, and keeps it. So addresses are reserved for it, and asked to be
  // large pages when they are touched. Memory beyond them has small pages. Where addresses are limited, others
  // need them.
  const auto is_limited = [](auto resource) {
    struct rlimit limit {};
    return ::getrlimit(resource, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY;
  };
  if (is_limited(RLIMIT_AS) || is_limited(RLIMIT_DATA) || counts_reserved_memory()) return;
  const uint64_t size = machine_memory() / 2;
  void* const reserved = std::malloc(size);
  if (reserved != nullptr) prefer_large_pages(reserved, size);
  std::free(reserved);
#endif
#endif
}

}  // namespace psplit
