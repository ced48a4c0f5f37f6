// Services that the standard library lacks: file locks, terminals, settings of the heap. All calls of the
// system are in system/posix and system/windows, of which a build has one
// (scripts/check-includes).
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "system/io_error.h"

namespace psplit {

// Prepares a process that is a command: the standard streams carry bytes as they are, and a terminal shows
// UTF-8. Returns the words of the command line in UTF-8, which stay until the process ends. Call it once.
std::vector<char*> start_command(int argc, char** argv);

// std::fopen for every path, whatever its characters, with the modes "rb", "wb" and "w+b". Other processes may
// rename and remove the file while it is open.
std::FILE* open_file(const std::filesystem::path& path, const char* mode);
// std::tmpfile, for users of any permissions.
std::FILE* open_temporary();
// std::fseek for every offset. False after an error, with its errno.
bool seek_to(std::FILE* file, uint64_t offset);

// What a path leads to, as std::filesystem::status tells it, but the names of devices that a folder of Windows
// does not show, such as NUL and COM1, are character devices.
std::filesystem::file_type file_type_at(const std::filesystem::path& path);
inline bool is_disk_file(const std::filesystem::path& path) {
  return file_type_at(path) == std::filesystem::file_type::regular;
}
// Whether ** of a pattern enters the entry at a path: a folder whose name does not begin with a dot and, on
// Windows, that is not both hidden and of the system. No links, because they may form cycles.
bool is_searched_folder(const std::filesystem::path& path);
// A name as the file system compares it: two names of one file become the same. On Windows, case does not
// count, nor do dots and spaces at the end of a part. On macOS, the case of A to Z does not count.
std::string name_to_compare(const std::string& name);
// A name of a new file, with _ for characters that no file system of this system takes.
std::string allowed_name(std::string name);

// What an error of a path says if the path may be longer than the system takes: "; ..." or nothing.
std::string length_hint(const std::filesystem::path& path);
// io_error with that. `error`: an errno, or a std::error_code.
template <typename Error>
Status path_error(const std::string& what, const std::filesystem::path& path, const Error& error) {
  const Status status = io_error(what, error);
  return {status.code(), status.message() + length_hint(path)};
}

// Renames a file, which may be open, also if `to` exists and is in use. Errors: as for io_error; kMayPass if
// another process keeps the file from being replaced. Then `to` is as it was, or the message tells its name.
Status replace_file(const std::filesystem::path& from, const std::filesystem::path& to);
// Gives a file a name that no file has; errc::file_exists if one has it. The old name may stay beside it.
std::error_code rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to);

// A new file, open for writing. It stays locked until it is closed or its process ends, even by a signal. Null
// if this fails. errno is then EEXIST if the name is taken, or if remove_if_unlocked removed the file
// meanwhile.
std::FILE* create_locked(const std::filesystem::path& path);

// Removes a file that no process has locked. The file stays if it cannot be locked, or if `before`, which is
// called while the lock is held, returns false.
void remove_if_unlocked(const std::filesystem::path& path, const std::function<bool()>& before = {});

// Writes the file's data to the disk, so that it survives a power failure. False after an error, with its
// errno.
bool sync_to_disk(std::FILE* file);
// Writes the names in a folder to the disk. Errors: as for io_error.
Status sync_to_disk(const std::filesystem::path& folder);

// Whether a file name matches a pattern of *, ? and []. A pattern that begins with one of these matches no
// file whose name begins with a dot.
bool matches_pattern(const std::string& name, const std::string& pattern);

// From now on, writing past the limit on a file's size (ulimit -f) fails instead of ending the process.
void let_writes_past_size_limit_fail();

// The exit codes of a process that ends here: gltf-psplit's codes for kIo and kMayPass.
inline constexpr int kExitIo = 2, kExitMayPass = 75;

// While it exists, SIGTERM, SIGINT and SIGHUP (on Windows: Ctrl-C, Ctrl-Break and the end of the console) end
// the process with kExitMayPass, unless the process ignores them: the files of RemovedAtStop are removed, and
// stderr gets a message. No destructor runs. One at a time.
class StopEndsProcess {
 public:
  StopEndsProcess();
  ~StopEndsProcess();
  StopEndsProcess(const StopEndsProcess&) = delete;
  StopEndsProcess& operator=(const StopEndsProcess&) = delete;
};

// A temporary file without a name: it disappears when the object is destroyed or the process ends, even by a
// signal. Not thread-safe.
class UnnamedFile {
 public:
  UnnamedFile() = default;
  UnnamedFile(UnnamedFile&& other) noexcept { *this = std::move(other); }
  UnnamedFile& operator=(UnnamedFile&& other) noexcept {
    std::swap(folder_, other.folder_);
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~UnnamedFile() { close(); }

  // Errors: as for io_error.
  static Expected<UnnamedFile> create(const std::filesystem::path& folder);
  // Writes at any offset; bytes between the old end and the offset are zeros. Errors: as for io_error, and
  // kMayPass for the limit on a file's size.
  Status write(uint64_t offset, std::span<const uint8_t> bytes);
  // Reads bytes that were written. Errors: as for io_error.
  Status read(uint64_t offset, std::span<uint8_t> to) const;
  // A name by which this process can open the file until it is closed. Empty if the system has no such names.
  std::filesystem::path path() const;
  // Gives the space back before the object is destroyed.
  void close();

 private:
  friend Expected<std::span<const uint8_t>> map_file(const UnnamedFile& file);
  friend Expected<std::span<uint8_t>> map_space(const UnnamedFile& file, uint64_t bytes);
  std::filesystem::path folder_;
  int descriptor_ = -1;
};

// Maps all bytes of a regular file for reading. Empty if the file is empty, or if it cannot be mapped: the
// caller then reads it. While any file is mapped, a handler for SIGBUS is installed. The system sends that
// signal when a mapped byte is used that the file no longer has, or that its device cannot read. The handler
// then writes a message that names the file to stderr, and ends the process with the code kIo; no destructor
// runs. It passes signals for other addresses on to the handler that was there before. Not safe: a program that
// installs its own handler for SIGBUS while a file is mapped; a read(2) into or from such memory returns EFAULT
// instead.
std::span<const uint8_t> map_file(const std::filesystem::path& path);
// Maps a temporary file, which may then be closed. Errors: as for io_error.
Expected<std::span<const uint8_t>> map_file(const UnnamedFile& file);
// Gives an empty file `bytes` zeros and maps them for reading and writing; the file may be closed then. The
// space is taken at once. Errors: as for io_error.
Expected<std::span<uint8_t>> map_space(const UnnamedFile& file, uint64_t bytes);
// Takes what map_file or map_space returned.
void unmap_file(std::span<const uint8_t> bytes);

// Returns the memory of those pages of a mapped file that are wholly in the range to the system; their content
// stays readable. Does nothing if the memory is not that of a mapped file. Thread-safe.
void release_mapped(std::span<const uint8_t> bytes);

// A file that grows by whole lines. One process at a time owns it, until the object is destroyed.
class LockedLog {
 public:
  LockedLog() = default;
  ~LockedLog();
  LockedLog(const LockedLog&) = delete;
  LockedLog& operator=(const LockedLog&) = delete;

  // Creates the file if it does not exist. Waits up to two seconds for an owner that is about to end. False if
  // another process then still owns the file. Errors: as for io_error.
  Expected<bool> open(const std::filesystem::path& path);
  // Opens the file for a process that works for its owner. The lock stays the owner's. Errors: as for
  // io_error.
  Status join(const std::filesystem::path& path);
  // Looks again whether the last line was cut short: another process may have appended to the same open file.
  void resume();
  // Writes lines in one call, so that a kill damages the last line at most. A line that could only be written
  // in part is ended by the next call. A power failure loses what was appended in the last second, or since the
  // last `sync`. Errors: as for io_error.
  Status append(std::string_view lines);
  // Waits until all lines are on the disk. Errors: as for io_error.
  Status sync();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool is_cut_short_ = false;
  std::chrono::steady_clock::time_point synced_;
};

// Whether another process owns the LockedLog at `path`. False if that is not known.
bool is_owned(const std::filesystem::path& path);

// A file that processes of one group hold together. Other groups wait until none of them holds it.
class GroupLock {
 public:
  GroupLock() = default;
  ~GroupLock();
  GroupLock(const GroupLock&) = delete;
  GroupLock& operator=(const GroupLock&) = delete;

  // Joins the group that is named so; the file keeps the name. False if processes of another group hold the
  // file for two seconds. Errors: as for io_error.
  Expected<bool> join(const std::filesystem::path& path, const std::string& group);
  // Holds the file alone. Returns the name of the last group that held it, or nothing if a process holds it for
  // two seconds. Errors: as for io_error.
  Expected<std::optional<std::string>> take(const std::filesystem::path& path);

 private:
  Status open(const std::filesystem::path& path);
  int descriptor_ = -1;
};

// Whether the files of a folder are in memory (tmpfs and ramfs of Linux). False if that is not known.
bool is_in_memory(const std::filesystem::path& folder);

// Whether this process may not write to an existing file, or nobody has the permission to: root respects that,
// too.
bool is_read_only(const std::filesystem::path& path);

// Gives an open file the permissions of another one and, if the system allows it, its owner and group.
void copy_permissions(const std::filesystem::path& from, std::FILE* to);

// Whether this process may create files in a folder.
bool may_write_into(const std::filesystem::path& folder);

bool is_terminal(std::FILE* stream);
// The width of the terminal. 0 if the stream is not a terminal, or if the width is unknown.
size_t terminal_columns(std::FILE* stream);

// To be called before large arrays are allocated and freed all the time: the process keeps the memory of freed
// arrays for later use, and takes it in large pages. Does nothing where the C library or the system has no such
// setting.
void expect_large_arrays();

}  // namespace psplit
