#include "system/files.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>

#include "system/io_error.h"
#include "system/mapped_file.h"
#include "system/operating_system.h"
#include "system/temporary_file.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// `error`: an errno, or a std::error_code.
template <typename Error>
Status failure(const char* what, const fs::path& path, const Error& error) {
  return path_error(std::string("cannot ") + what, path, error)
      .at({.file = path == "-" ? "stdin" : path.string()});
}

bool write_parts(std::FILE* file, FileParts parts) {
  for (const auto part : parts)
    if (!visit_and_release(part, [file](std::span<const uint8_t> step) {
          return std::fwrite(step.data(), 1, step.size(), file) == step.size();
        }))
      return false;
  return std::fflush(file) == 0;
}

}  // namespace

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

Expected<std::vector<uint8_t>> read_file(const fs::path& path, uint64_t limit) {
  std::error_code error;
  const uint64_t stated = path == "-" ? 0 : fs::file_size(path, error);
  if (error == std::errc::is_a_directory) return failure("read", path, EISDIR);
  const OpenFile file(path == "-" ? stdin : open_file(path, "rb"));
  if (file == nullptr) return failure("open", path, errno);

  // The array grows with the bytes that arrive: a pipe has no size, and a stated one may be wrong.
  // Some C libraries read less than 2 GiB at once.
  constexpr uint64_t kBlock = uint64_t{1} << 20, kMost = uint64_t{1} << 30;
  std::vector<uint8_t> bytes;
  uint64_t room = error || stated == 0 ? kBlock : stated + 1;  // with one byte more, the end is seen
  bytes.reserve(static_cast<size_t>(std::min(room, limit)));
  while (bytes.size() < limit) {
    const auto wanted = static_cast<size_t>(std::min({room, limit - bytes.size(), kMost}));
    const size_t before = bytes.size();
    bytes.resize(before + wanted);
    const size_t got = std::fread(bytes.data() + before, 1, wanted, file.get());
    bytes.resize(before + got);
    if (got < wanted) break;
    room = std::max(kBlock, uint64_t{bytes.capacity() - bytes.size()});
  }
  if (std::ferror(file.get()) != 0) return failure("read", path, errno);
  return bytes;
}

Status write_file(const fs::path& path, std::initializer_list<std::span<const uint8_t>> parts,
                  IfReadOnly if_read_only) {
  return write_file(path, FileParts(parts.begin(), parts.size()), if_read_only);
}

Status write_file(const fs::path& path, FileParts parts, IfReadOnly if_read_only) {
  return write_file(
      path, [parts](std::FILE* file) { return write_parts(file, parts); }, if_read_only);
}

Status write_file(const fs::path& path, const std::function<bool(std::FILE*)>& write, IfReadOnly if_read_only) {
  const auto write_whole = [&](std::FILE* file) { return write(file) && std::fflush(file) == 0; };
  if (path == "-") return write_whole(stdout) ? Status() : failure("write", "stdout", errno);

  const fs::file_type type = file_type_at(path);
  if (type == fs::file_type::character || type == fs::file_type::fifo) {  // written to, never replaced
    const OpenFile file(open_file(path, "wb"));
    return file != nullptr && write_whole(file.get()) ? Status() : failure("write", path, errno);
  }

  const Expected<fs::path> target = follow_links(path);
  if (!target) return target.status();
  if (type == fs::file_type::directory) return failure("write", path, EISDIR);
  const bool replaces = fs::exists(fs::file_status(type));
  if (replaces && if_read_only == IfReadOnly::kFail && is_read_only(*target))
    return io_failure("cannot write: the file is read-only", {.file = path.string()});

  TemporaryFile temporary(*target);
  if (temporary.is_open() && replaces) copy_permissions(*target, temporary.file());
  if (!temporary.is_open() || !write_whole(temporary.file())) return failure("write", path, errno);
  return temporary.rename_to(*target).at({.file = path.string()});
}

Status make_folders(const fs::path& folder) {
  std::error_code error;
  // Without the drive, std::filesystem would name another cause.
  if (const fs::path root = folder.root_path(); !root.empty() && !fs::exists(root, error))
    return io_error("cannot make the folder " + folder.string(), ENOENT);
  fs::create_directories(folder, error);
  return error ? path_error("cannot make the folder " + folder.string(), folder, error) : Status();
}

std::string whole_name(const fs::path& path) {
  std::error_code error;
  return name_to_compare(fs::weakly_canonical(path, error).string());
}

Expected<fs::path> follow_links(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as in Linux
  fs::path target = path;
  std::error_code error;
  for (int i = 0; i < kMostLinks; ++i) {
    if (!fs::is_symlink(target, error)) return target;
    target = target.parent_path() / fs::read_symlink(target, error);
    // The folder may be a link too, and ".." starts from where it leads to.
    const fs::path folder = fs::canonical(target.parent_path().empty() ? "." : target.parent_path(), error);
    if (!error) target = folder / target.filename();
  }
  return failure("follow the link", path, ELOOP);
}

Expected<bool> write_new_file(const fs::path& path, std::span<const uint8_t> bytes) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(path, error))) return false;
  TemporaryFile temporary(path);
  const std::span<const uint8_t> parts[] = {bytes};
  if (!temporary.is_open() || !write_parts(temporary.file(), parts)) return failure("write", path, errno);
  if (const std::error_code renamed = temporary.rename_to_new(path); renamed == std::errc::file_exists)
    return false;
  else if (renamed)
    return failure("write", path, renamed);
  return true;
}

}  // namespace psplit
