#include "system/temporary_file.h"

#include <cerrno>
#include <mutex>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "system/content_hash.h"
#include "system/operating_system.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = ".psplit-", kEnd = ".part";
constexpr size_t kDigits = 8;  // random digits, followed by as many check digits

// A hash of the random digits.
std::string check_digits(std::string_view digits) {
  ContentHash hash;
  hash.add_framed(digits);
  return hash.hex().substr(0, kDigits);
}

}  // namespace

fs::path temporary_path(const fs::path& target) {
  thread_local std::random_device random;  // to make one takes longer than to write a small file
  std::string digits;
  for (auto bits = static_cast<uint32_t>(random()); digits.size() < kDigits; bits >>= 4)
    digits += "0123456789abcdef"[bits & 15];
  return target.parent_path() / (std::string(kMark) + digits + check_digits(digits) + std::string(kEnd));
}

bool is_temporary_name(const fs::path& path) {
  const std::string name = path.filename().string();
  if (name.size() != kMark.size() + 2 * kDigits + kEnd.size() || !name.starts_with(kMark) ||
      !name.ends_with(kEnd))
    return false;
  return name.substr(kMark.size() + kDigits, kDigits) == check_digits(name.substr(kMark.size(), kDigits));
}

void remove_dead_temporaries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (is_temporary_name(entry->path()) && entry->symlink_status(error).type() == fs::file_type::regular)
      found.push_back(entry->path());
  for (const fs::path& path : found) remove_if_unlocked(path);
}

void remove_dead_temporaries_once(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> done;
  {
    const std::lock_guard lock(mutex);
    if (!done.insert(folder).second) return;
  }
  remove_dead_temporaries(folder);
}

TemporaryFile::TemporaryFile(const fs::path& target) {
  const fs::path folder = target.parent_path();
  remove_dead_temporaries_once(folder.empty() ? "." : folder);
  constexpr int kTries = 16;
  for (int i = 0; i < kTries; ++i) {
    path_ = temporary_path(target);
    removed_at_stop_.emplace(path_);  // first, because a signal may come at any time
    file_ = create_locked(path_);
    if (file_ != nullptr) return;
    const int error = errno;
    removed_at_stop_.reset();
    errno = error;
    if (error != EEXIST) return;
  }
}

TemporaryFile::~TemporaryFile() {
  if (file_ == nullptr) return;
  const int saved = errno;  // the caller reports it
  std::error_code ignored;
  if (!path_.empty()) fs::remove(path_, ignored);
  std::fclose(file_);
  errno = saved;
}

Status TemporaryFile::rename_to(const fs::path& target) {
  Status status = replace_file(path_, target);
  if (status.ok()) path_.clear();
  return status;
}

std::error_code TemporaryFile::rename_to_new(const fs::path& target) {
  return psplit::rename_to_new(path_, target);  // the destructor removes the other name
}

}  // namespace psplit
