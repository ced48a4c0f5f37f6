#include "system/operating_system.h"

#include <fcntl.h>
#include <io.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <shared_mutex>
#include <thread>
#include <utility>

#include "system/io_error.h"
#include "system/mapped_ranges.h"
#include "system/removed_at_stop.h"
#include "system/shared_file.h"
#include "system/temporary_file.h"
#include "system/windows/path_facet.h"
#include "system/windows/system_calls.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Others may read, write, rename and remove what this process has open, as on other systems.
constexpr DWORD kShareAll = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

HANDLE handle_of(int descriptor) { return reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor)); }
HANDLE handle_of(std::FILE* file) { return handle_of(::_fileno(file)); }

Status failure(const fs::path& path) { return io_error("cannot use " + path.string(), errno_of_last_error()); }

SystemHandle open_handle(const fs::path& path, DWORD access, DWORD creation,
                         DWORD flags = FILE_ATTRIBUTE_NORMAL) {
  return own(::CreateFileW(path.c_str(), access, kShareAll, nullptr, creation, flags, nullptr));
}

// -1 after an error, with its errno.
int descriptor_of(SystemHandle handle, int flags) {
  if (handle == nullptr) {
    errno = errno_of_last_error();
    return -1;
  }
  const int descriptor =
      ::_open_osfhandle(reinterpret_cast<intptr_t>(handle.get()), flags | _O_BINARY | _O_NOINHERIT);
  if (descriptor >= 0) handle.release();
  return descriptor;
}

std::FILE* stream_of(SystemHandle handle, const char* mode) {
  const bool reads = *mode == 'r', updates = std::strchr(mode, '+') != nullptr;
  const int descriptor = descriptor_of(std::move(handle), updates ? _O_RDWR : reads ? _O_RDONLY : _O_WRONLY);
  if (descriptor < 0) return nullptr;
  std::FILE* const file = ::_fdopen(descriptor, mode);
  if (file == nullptr) ::_close(descriptor);
  return file;
}

OVERLAPPED at_offset(uint64_t offset) {
  OVERLAPPED place{};
  place.Offset = static_cast<DWORD>(offset);
  place.OffsetHigh = static_cast<DWORD>(offset >> 32);
  return place;
}

// The system's locks keep other processes from reading and writing locked bytes. So the lock is on one byte
// beyond any file, and only processes that ask for the lock notice it.
constexpr uint64_t kLockedByte = uint64_t{1} << 62;

bool try_lock(HANDLE handle, bool is_shared) {
  OVERLAPPED place = at_offset(kLockedByte);
  const DWORD flags = LOCKFILE_FAIL_IMMEDIATELY | (is_shared ? 0 : LOCKFILE_EXCLUSIVE_LOCK);
  return ::LockFileEx(handle, flags, 0, 1, 0, &place) != 0;
}
bool is_locked_by_other() {
  const DWORD error = ::GetLastError();
  return error == ERROR_LOCK_VIOLATION || error == ERROR_IO_PENDING;
}
// Not a disk: nothing to wait for.
bool sync_handle(HANDLE handle) {
  return ::FlushFileBuffers(handle) != 0 || ::GetLastError() == ERROR_INVALID_FUNCTION ||
         ::GetLastError() == ERROR_INVALID_HANDLE;
}

uint64_t size_of(HANDLE handle) {
  LARGE_INTEGER size{};
  return ::GetFileSizeEx(handle, &size) != 0 ? static_cast<uint64_t>(size.QuadPart) : 0;
}

bool set_size(HANDLE handle, uint64_t bytes) {
  LARGE_INTEGER size{};
  size.QuadPart = static_cast<LONGLONG>(bytes);
  return ::SetFilePointerEx(handle, size, nullptr, FILE_BEGIN) != 0 && ::SetEndOfFile(handle) != 0;
}

constexpr size_t kMostAtOnce = size_t{1} << 30;

// The count, or after a failure -1, with the errno.
int64_t or_errno(bool is_ok, DWORD count) {
  if (is_ok) return count;
  errno = errno_of_last_error();
  return -1;
}

void* exception_handler = nullptr;

void print_in_handler(const char* text) {
  DWORD written = 0;
  ::WriteFile(::GetStdHandle(STD_ERROR_HANDLE), text, static_cast<DWORD>(std::strlen(text)), &written, nullptr);
}

// The device of a mapped file failed. Here a mapped file cannot become shorter.
LONG CALLBACK end_with_file_name(EXCEPTION_POINTERS* exception) {
  const EXCEPTION_RECORD& record = *exception->ExceptionRecord;
  if (record.ExceptionCode != EXCEPTION_IN_PAGE_ERROR || record.NumberParameters < 2)
    return EXCEPTION_CONTINUE_SEARCH;
  const MappedRange* range = mapped_range_at(record.ExceptionInformation[1]);
  if (range == nullptr) return EXCEPTION_CONTINUE_SEARCH;
  print_in_handler("gltf-psplit: error: ");
  print_in_handler(range->name.load(std::memory_order_relaxed));
  print_in_handler(": the file's device failed while it was read\n");
  ::TerminateProcess(::GetCurrentProcess(), kExitIo);
  return EXCEPTION_CONTINUE_SEARCH;
}

void install_handler() { exception_handler = ::AddVectoredExceptionHandler(1, end_with_file_name); }
void uninstall_handler() { ::RemoveVectoredExceptionHandler(exception_handler); }

// Maps the first bytes of a file, of which there is one or more. Null after an error: the file may be shorter.
void* map_handle(HANDLE file, uint64_t bytes, bool writes) {
  const SystemHandle section =
      own(::CreateFileMappingW(file, nullptr, writes ? PAGE_READWRITE : PAGE_READONLY,
                               static_cast<DWORD>(bytes >> 32), static_cast<DWORD>(bytes), nullptr));
  if (section == nullptr) return nullptr;
  return ::MapViewOfFile(section.get(), writes ? FILE_MAP_WRITE : FILE_MAP_READ, 0, 0,
                         static_cast<SIZE_T>(bytes));
}

SystemHandle duplicate(HANDLE handle) {
  HANDLE copy = nullptr;
  ::DuplicateHandle(::GetCurrentProcess(), handle, ::GetCurrentProcess(), &copy, 0, FALSE,
                    DUPLICATE_SAME_ACCESS);
  return own(copy);
}

// Maps a file and enters it. The file stays open for as long, because a temporary file ends with its last
// handle. Errors: as for io_error.
Expected<std::span<uint8_t>> map_and_enter(SystemHandle file, uint64_t bytes, bool writes,
                                           const fs::path& name) {
  if (file == nullptr) return failure(name);
  void* const address = map_handle(file.get(), bytes, writes);
  if (address == nullptr) return io_error("cannot map " + name.string(), errno_of_last_error());
  const std::span<uint8_t> mapped(static_cast<uint8_t*>(address), static_cast<size_t>(bytes));
  if (enter_mapped(mapped, name, file.get(), install_handler)) {
    file.release();
    return mapped;
  }
  ::UnmapViewOfFile(address);
  return may_pass("too many mapped files");
}

UINT output_code_page = 0;  // of the terminal before this process; 0 if there is none
void restore_terminal() {
  if (output_code_page != 0) ::SetConsoleOutputCP(output_code_page);
}

// Locked, shared, while a file that is being replaced is aside under another name: the process must not end
// then.
std::shared_mutex files_are_aside;

// The system calls it in a thread of its own, so that it may do anything.
BOOL WINAPI end_at_stop(DWORD) {
  files_are_aside.lock();
  RemovedAtStop::remove_all([](const char* name) { ::DeleteFileW(wide(name).c_str()); });
  // On a terminal, the line of a progress bar is overwritten.
  print_in_handler(is_terminal(stderr) ? "\r\033[K" : "");
  print_in_handler("gltf-psplit: error: stopped by a signal\n");
  restore_terminal();
  ::TerminateProcess(::GetCurrentProcess(), kExitMayPass);
  return TRUE;
}

// It has the name of a TemporaryFile, and is locked as one: after a power failure it is still there.
SystemHandle create_unnamed(const fs::path& folder) {
  constexpr int kTries = 16;
  for (int i = 0; i < kTries; ++i) {
    SystemHandle handle =
        open_handle(temporary_path(folder / "x"), GENERIC_READ | GENERIC_WRITE | DELETE, CREATE_NEW,
                    FILE_ATTRIBUTE_TEMPORARY | FILE_ATTRIBUTE_HIDDEN | FILE_FLAG_DELETE_ON_CLOSE);
    if (handle == nullptr && ::GetLastError() != ERROR_FILE_EXISTS) return nullptr;
    if (handle == nullptr || (!try_lock(handle.get(), false) && is_locked_by_other())) continue;
    remove_dead_temporaries_once(folder);
    return handle;
  }
  ::SetLastError(ERROR_FILE_EXISTS);
  return nullptr;
}

// The names of the file system do not tell upper case from lower case.
std::string upper_case(std::string_view text) {
  const std::wstring from = wide(text);
  std::wstring to(from.size(), L'\0');
  const int size = static_cast<int>(from.size());
  if (size > 0)
    ::LCMapStringEx(LOCALE_NAME_INVARIANT, LCMAP_UPPERCASE, from.data(), size, to.data(), size, nullptr,
                    nullptr, 0);
  return utf8(to);
}

// The tag of the entry at a path if it is a link or another reparse point; otherwise 0.
DWORD reparse_tag(const fs::path& path) {
  WIN32_FIND_DATAW found{};
  const HANDLE search = ::FindFirstFileW(path.c_str(), &found);
  if (search == INVALID_HANDLE_VALUE) return 0;
  ::FindClose(search);
  return (found.dwFileAttributes & FILE_ATTRIBUTE_REPARSE_POINT) != 0 ? found.dwReserved0 : 0;
}

// Scanners and clients of storages open files for moments, in which they cannot be renamed. Tries for a while,
// and returns the last error, or 0.
template <typename Rename>
DWORD rename_patiently(const Rename& rename) {
  for (const auto deadline = Clock::now() + kLockPatience;; std::this_thread::sleep_for(kLockRefresh)) {
    if (rename()) return 0;
    const DWORD error = ::GetLastError();
    const bool may_be_short =
        error == ERROR_ACCESS_DENIED || error == ERROR_SHARING_VIOLATION || error == ERROR_LOCK_VIOLATION;
    if (!may_be_short || Clock::now() > deadline) return error;
  }
}

DWORD move_patiently(const fs::path& from, const fs::path& to) {
  return rename_patiently([&] { return ::MoveFileExW(from.c_str(), to.c_str(), 0) != 0; });
}

// The whole path of a file, as the system understands it; empty if there is none. The standard library makes
// one of a drive from that of a server.
std::wstring full_path(const fs::path& path) {
  std::wstring whole(32768, L'\0');
  const auto room = static_cast<DWORD>(whole.size());
  whole.resize(std::min(::GetFullPathNameW(path.c_str(), room, whole.data(), nullptr), room));
  return whole;
}

// Replaces a file as other systems do: programs that have it open keep the old one. Windows 10 and NTFS can;
// FAT, older systems that share a folder, and older wine refuse.
bool replace_open_file(const fs::path& from, const fs::path& to) {
  constexpr auto kRenameEx = static_cast<FILE_INFO_BY_HANDLE_CLASS>(22);  // some headers lack FileRenameInfoEx
  constexpr DWORD kReplace = 1, kAsPosix = 2;
  const std::wstring name = full_path(to);
  const size_t bytes = name.size() * sizeof(wchar_t);
  std::vector<std::byte> memory(sizeof(FILE_RENAME_INFO) + bytes);
  auto* const info = reinterpret_cast<FILE_RENAME_INFO*>(memory.data());
  info->Flags = kReplace | kAsPosix;
  info->FileNameLength = static_cast<DWORD>(bytes);
  std::memcpy(info->FileName, name.c_str(), bytes);
  const SystemHandle file = open_handle(from, DELETE | SYNCHRONIZE, OPEN_EXISTING);
  return !name.empty() && file != nullptr &&
         ::SetFileInformationByHandle(file.get(), kRenameEx, info, static_cast<DWORD>(memory.size())) != 0;
}

// Whether the first character of a name matches the set after a '['. Moves `pattern` past its ']'. A set
// without end is no set.
std::optional<bool> matches_set(char letter, std::string_view& pattern) {
  std::string_view rest = pattern;
  const bool negated = rest.starts_with('!') || rest.starts_with('^');
  if (negated) rest.remove_prefix(1);
  bool found = false;
  for (bool is_first = true; !rest.empty() && (is_first || rest[0] != ']'); is_first = false) {
    const char low = rest[0];
    const bool is_range = rest.size() > 2 && rest[1] == '-' && rest[2] != ']';
    found = found || (low <= letter && letter <= (is_range ? rest[2] : low));
    rest.remove_prefix(is_range ? 3 : 1);
  }
  if (rest.empty()) return std::nullopt;
  pattern = rest.substr(1);
  return found != negated;
}

// One character of UTF-8.
size_t bytes_of_character(std::string_view text) {
  size_t bytes = 1;
  while (bytes < text.size() && (static_cast<unsigned char>(text[bytes]) & 0xc0) == 0x80) ++bytes;
  return bytes;
}

bool matches(std::string_view name, std::string_view pattern) {
  while (!pattern.empty()) {
    const char first = pattern[0];
    pattern.remove_prefix(1);
    if (first == '*') {
      for (size_t i = 0; i <= name.size(); ++i)
        if (matches(name.substr(i), pattern)) return true;
      return false;
    }
    if (name.empty()) return false;
    if (first == '?') {
      name.remove_prefix(bytes_of_character(name));
      continue;
    }
    const std::optional<bool> in_set = first == '[' ? matches_set(name[0], pattern) : std::nullopt;
    if (!in_set.value_or(first == name[0])) return false;
    name.remove_prefix(1);
  }
  return name.empty();
}

}  // namespace

std::error_code rename_to_new(const fs::path& from, const fs::path& to) {
  const DWORD error = move_patiently(from, to);
  return error == 0 ? std::error_code() : std::error_code(errno_of(error), std::generic_category());
}

std::vector<char*> start_command(int argc, char** argv) {
  // A crash ends the process; no dialogue waits for a user.
  ::SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX);
  for (std::FILE* const stream : {stdin, stdout, stderr}) ::_setmode(::_fileno(stream), _O_BINARY);
  for (std::FILE* const stream : {stdout, stderr}) {
    DWORD mode = 0;
    if (::GetConsoleMode(handle_of(stream), &mode) == 0) continue;
    ::SetConsoleMode(handle_of(stream), mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
    if (output_code_page != 0) continue;
    output_code_page = ::GetConsoleOutputCP();
    ::SetConsoleOutputCP(CP_UTF8);
    std::atexit(restore_terminal);
  }
  // The arguments of `main` have lost the characters that the code page lacks.
  int count = 0;
  wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  if (words == nullptr) return {argv, argv + argc};
  static std::vector<std::string> texts;
  for (int i = 0; i < count; ++i) texts.push_back(utf8(words[i]));
  ::LocalFree(words);
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  return result;
}

std::FILE* open_file(const fs::path& path, const char* mode) {
  const bool reads = *mode == 'r', updates = std::strchr(mode, '+') != nullptr;
  const DWORD access = updates ? GENERIC_READ | GENERIC_WRITE : reads ? GENERIC_READ : GENERIC_WRITE;
  return stream_of(open_handle(path, access, reads ? OPEN_EXISTING : CREATE_ALWAYS), mode);
}

std::FILE* open_temporary() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  return stream_of(create_unnamed(folder), "w+b");
}

bool seek_to(std::FILE* file, uint64_t offset) {
  return ::_fseeki64(file, static_cast<int64_t>(offset), SEEK_SET) == 0;
}

fs::file_type file_type_at(const fs::path& path) {
  if (full_path(path).starts_with(L"\\\\.\\")) return fs::file_type::character;
  std::error_code error;
  return fs::status(path, error).type();
}

bool is_searched_folder(const fs::path& path) {
  constexpr DWORD kHidden = FILE_ATTRIBUTE_HIDDEN | FILE_ATTRIBUTE_SYSTEM;  // as $RECYCLE.BIN is
  const DWORD attributes = ::GetFileAttributesW(path.c_str());
  if (attributes == INVALID_FILE_ATTRIBUTES || (attributes & FILE_ATTRIBUTE_DIRECTORY) == 0 ||
      (attributes & kHidden) == kHidden || path.filename().string().starts_with('.'))
    return false;
  const DWORD tag = reparse_tag(path);  // folders of storages have other tags
  return tag != IO_REPARSE_TAG_MOUNT_POINT && tag != IO_REPARSE_TAG_SYMLINK;
}

std::string name_to_compare(const std::string& name) {
  std::string text;
  for (size_t at = 0; at <= name.size();) {
    const size_t end = std::min(name.find_first_of("/\\", at), name.size());
    const std::string part = name.substr(at, end - at);
    const size_t last = part.find_last_not_of(". ");
    text += part == "." || part == ".." ? part : part.substr(0, last + 1);
    if (end < name.size()) text += '/';
    at = end + 1;
  }
  return upper_case(text);
}

std::string allowed_name(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return std::string_view("<>:\"|?*").find(c) != std::string_view::npos; }, '_');
  return name;
}

std::string length_hint(const fs::path& path) {
  constexpr size_t kMost = 247;  // characters of a folder; files have some more
  if (full_path(path).size() <= kMost) return "";
  const FARPROC found = ::GetProcAddress(::GetModuleHandleW(L"ntdll.dll"), "RtlAreLongPathsEnabled");
  const auto are_long_paths_enabled = reinterpret_cast<BOOLEAN(WINAPI*)()>(reinterpret_cast<void*>(found));
  if (are_long_paths_enabled != nullptr && are_long_paths_enabled() != 0) return "";
  return "; Windows takes so long a path only if LongPathsEnabled is set in its registry";
}

Status replace_file(const fs::path& from, const fs::path& to) {
  const DWORD before = ::GetFileAttributesW(to.c_str());
  const bool exists = before != INVALID_FILE_ATTRIBUTES;
  const bool was_read_only = exists && (before & FILE_ATTRIBUTE_READONLY) != 0;
  if (was_read_only) ::SetFileAttributesW(to.c_str(), before & ~static_cast<DWORD>(FILE_ATTRIBUTE_READONLY));
  // No other run removes a file of this name, which may be the only copy.
  const fs::path aside = temporary_path(to).replace_extension(".replaced");
  bool is_aside = false;
  const std::shared_lock no_stop(files_are_aside);
  DWORD error = rename_patiently([&] {
    if (replace_open_file(from, to) || ::MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING) != 0)
      return true;
    // A file that is open or mapped can be renamed, unless one who has it open forbids that.
    const bool is_in_use =
        ::GetLastError() == ERROR_ACCESS_DENIED || ::GetLastError() == ERROR_USER_MAPPED_FILE;
    is_aside = is_in_use && exists && ::MoveFileExW(to.c_str(), aside.c_str(), 0) != 0;
    return is_aside;
  });
  std::string hint;
  if (is_aside) error = move_patiently(from, to);
  if (is_aside && error != 0 && move_patiently(aside, to) != 0)
    hint = "; the file that was there is now " + aside.string();
  if (is_aside && error == 0 && ::DeleteFileW(aside.c_str()) == 0) {
    // It is mapped. As a temporary file it goes with its last handle, which stays open until this process ends,
    // or when another process finds it.
    const fs::path dead = temporary_path(to);
    ::MoveFileExW(aside.c_str(), dead.c_str(), 0);
    open_handle(dead, DELETE, OPEN_EXISTING, FILE_FLAG_DELETE_ON_CLOSE).release();
  }
  // The new file has the permission of the one that it replaced; if that stayed, it has its own.
  if (was_read_only)
    ::SetFileAttributesW(to.c_str(),
                         ::GetFileAttributesW(to.c_str()) | static_cast<DWORD>(FILE_ATTRIBUTE_READONLY));
  if (error == 0) return {};
  const Status status = io_error("cannot write", errno_of(error));
  return {status.code(), status.message() + hint};
}

std::span<const uint8_t> map_file(const fs::path& path) {
  SystemHandle file = open_handle(path, GENERIC_READ, OPEN_EXISTING);
  if (file == nullptr || ::GetFileType(file.get()) != FILE_TYPE_DISK) return {};
  const uint64_t size = size_of(file.get());
  if (size == 0 || size > SIZE_MAX) return {};
  const Expected<std::span<uint8_t>> mapped = map_and_enter(std::move(file), size, false, path);
  return mapped ? *mapped : std::span<const uint8_t>();
}

Expected<std::span<const uint8_t>> map_file(const UnnamedFile& file) {
  const HANDLE handle = handle_of(file.descriptor_);
  const uint64_t size = size_of(handle);
  if (size == 0) return std::span<const uint8_t>();
  const Expected<std::span<uint8_t>> mapped =
      map_and_enter(duplicate(handle), size, false, file.folder_ / "(temporary file)");
  if (!mapped) return mapped.status();
  return std::span<const uint8_t>(*mapped);
}

Expected<std::span<uint8_t>> map_space(const UnnamedFile& file, uint64_t bytes) {
  if (bytes == 0) return std::span<uint8_t>();
  if (bytes > static_cast<uint64_t>(PTRDIFF_MAX)) return io_error("cannot map a temporary file", EFBIG);
  const HANDLE handle = handle_of(file.descriptor_);
  if (!set_size(handle, bytes))
    return space_error("cannot take " + std::to_string(bytes) + " bytes of temporary space",
                       errno_of_last_error());
  return map_and_enter(duplicate(handle), bytes, true, "a temporary file");
}

void unmap_file(std::span<const uint8_t> bytes) {
  void* const file = leave_mapped(bytes, uninstall_handler);
  ::UnmapViewOfFile(bytes.data());
  ::CloseHandle(file);
}

void release_mapped(std::span<const uint8_t> bytes) {
  const auto first = reinterpret_cast<uintptr_t>(bytes.data());
  const MappedRange* range = mapped_range_at(first);
  if (range == nullptr) return;
  SYSTEM_INFO system{};
  ::GetSystemInfo(&system);
  const uintptr_t page = system.dwPageSize, file_end = range->end.load(std::memory_order_relaxed);
  const uintptr_t last = std::min(first + bytes.size(), file_end);
  const uintptr_t begin = (first + page - 1) / page * page;
  // The last page of a file is usually not full.
  const uintptr_t end = last == file_end ? (last + page - 1) / page * page : last / page * page;
  // To unlock pages that are not locked takes them out of the working set.
  if (begin < end) ::VirtualUnlock(reinterpret_cast<void*>(begin), end - begin);
}

std::FILE* create_locked(const fs::path& path) {
  SystemHandle handle = open_handle(path, GENERIC_WRITE, CREATE_NEW);
  const bool is_taken = handle != nullptr && !try_lock(handle.get(), false) && is_locked_by_other();
  FILE_STANDARD_INFO info{};
  const bool is_removed =
      handle != nullptr &&
      ::GetFileInformationByHandleEx(handle.get(), FileStandardInfo, &info, sizeof(info)) != 0 &&
      (info.DeletePending != 0 || info.NumberOfLinks == 0);
  if (is_taken || is_removed) {
    errno = EEXIST;
    return nullptr;
  }
  return stream_of(std::move(handle), "wb");
}

void remove_if_unlocked(const fs::path& path, const std::function<bool()>& before) {
  const SystemHandle handle =
      open_handle(path, GENERIC_READ | GENERIC_WRITE, OPEN_EXISTING, FILE_FLAG_OPEN_REPARSE_POINT);
  if (handle == nullptr || !try_lock(handle.get(), false)) return;
  if (!before || before()) ::DeleteFileW(path.c_str());
}

bool sync_to_disk(std::FILE* file) {
  if (std::fflush(file) != 0) return false;
  if (sync_handle(handle_of(file))) return true;
  errno = errno_of_last_error();
  return false;
}

// The file system writes the names of files itself.
Status sync_to_disk(const fs::path&) { return {}; }

bool matches_pattern(const std::string& name, const std::string& pattern) {
  const bool shows_hidden = pattern.starts_with('.');
  return (shows_hidden || !name.starts_with('.')) && matches(upper_case(name), upper_case(pattern));
}

StopEndsProcess::StopEndsProcess() { ::SetConsoleCtrlHandler(end_at_stop, TRUE); }
StopEndsProcess::~StopEndsProcess() { ::SetConsoleCtrlHandler(end_at_stop, FALSE); }

// There is no such limit.
void let_writes_past_size_limit_fail() {}

int shared_file::open(const fs::path& path, Access access) {
  // With the right to append alone, each write appends.
  const DWORD rights = access == Access::kRead    ? GENERIC_READ
                       : access == Access::kWrite ? GENERIC_READ | GENERIC_WRITE
                                                  : GENERIC_READ | FILE_APPEND_DATA;
  const int flags = access == Access::kRead ? _O_RDONLY : access == Access::kWrite ? _O_RDWR : _O_APPEND;
  return descriptor_of(open_handle(path, rights, access == Access::kRead ? OPEN_EXISTING : OPEN_ALWAYS), flags);
}
void shared_file::close(int descriptor) { ::_close(descriptor); }

bool shared_file::try_lock(int descriptor, Lock lock) {
  if (psplit::try_lock(handle_of(descriptor), lock == Lock::kTogether)) return true;
  errno = is_locked_by_other() ? EWOULDBLOCK : errno_of_last_error();
  return false;
}
void shared_file::unlock(int descriptor) {
  OVERLAPPED place = at_offset(kLockedByte);
  ::UnlockFileEx(handle_of(descriptor), 0, 1, 0, &place);
}

int64_t shared_file::read_at(int descriptor, uint64_t offset, std::span<uint8_t> to) {
  OVERLAPPED place = at_offset(offset);
  DWORD got = 0;
  const auto size = static_cast<DWORD>(std::min(to.size(), kMostAtOnce));
  const bool is_ok = ::ReadFile(handle_of(descriptor), to.data(), size, &got, &place) != 0;
  return or_errno(is_ok, got);
}
int64_t shared_file::write_at(int descriptor, uint64_t offset, std::span<const uint8_t> bytes) {
  OVERLAPPED place = at_offset(offset);
  DWORD written = 0;
  const auto size = static_cast<DWORD>(std::min(bytes.size(), kMostAtOnce));
  const bool is_ok = ::WriteFile(handle_of(descriptor), bytes.data(), size, &written, &place) != 0;
  return or_errno(is_ok, written);
}
int64_t shared_file::append(int descriptor, std::string_view text) {
  DWORD written = 0;
  const auto size = static_cast<DWORD>(text.size());
  const bool is_ok = ::WriteFile(handle_of(descriptor), text.data(), size, &written, nullptr) != 0;
  return or_errno(is_ok || written > 0, written);
}

uint64_t shared_file::size_of(int descriptor) { return psplit::size_of(handle_of(descriptor)); }
bool shared_file::set_size(int descriptor, uint64_t bytes) {
  return or_errno(psplit::set_size(handle_of(descriptor), bytes), 0) == 0;
}
bool shared_file::sync(int descriptor) { return or_errno(sync_handle(handle_of(descriptor)), 0) == 0; }

// It has a name, and goes with its last handle.
fs::path UnnamedFile::path() const {
  std::wstring name(32768, L'\0');
  const DWORD size =
      ::GetFinalPathNameByHandleW(handle_of(descriptor_), name.data(), static_cast<DWORD>(name.size()), 0);
  name.resize(size < name.size() ? size : 0);
  return name;
}

Expected<UnnamedFile> UnnamedFile::create(const fs::path& folder) {
  UnnamedFile file;
  file.folder_ = folder.empty() ? "." : folder;
  file.descriptor_ = descriptor_of(create_unnamed(file.folder_), _O_RDWR);
  if (file.descriptor_ < 0)
    return io_error("cannot create a temporary file in " + file.folder_.string(), errno);
  return file;
}

bool is_in_memory(const fs::path&) { return false; }

bool is_read_only(const fs::path& path) {
  const DWORD attributes = ::GetFileAttributesW(path.c_str());
  if (attributes == INVALID_FILE_ATTRIBUTES) return false;
  if ((attributes & FILE_ATTRIBUTE_READONLY) != 0) return true;
  return open_handle(path, GENERIC_WRITE, OPEN_EXISTING) == nullptr && ::GetLastError() == ERROR_ACCESS_DENIED;
}

// A new file has the permissions that its folder gives; replace_file keeps what a file has of its own.
void copy_permissions(const fs::path&, std::FILE*) {}

bool may_write_into(const fs::path& folder) {
  return open_handle(folder, FILE_ADD_FILE, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS) != nullptr;
}

bool is_terminal(std::FILE* stream) {
  DWORD mode = 0;
  return ::GetConsoleMode(handle_of(stream), &mode) != 0;
}

size_t terminal_columns(std::FILE* stream) {
  CONSOLE_SCREEN_BUFFER_INFO screen{};
  if (::GetConsoleScreenBufferInfo(handle_of(stream), &screen) == 0) return 0;
  return static_cast<size_t>(screen.srWindow.Right - screen.srWindow.Left + 1);
}

void expect_large_arrays() {}

}  // namespace psplit
