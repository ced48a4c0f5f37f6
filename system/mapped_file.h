// A read-only view of the bytes of a file, which may be larger than memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "psplit/base.h"

namespace psplit {

class UnnamedFile;

// Copies share the file; it is closed with the last of them. All functions are thread-safe. If the system
// cannot map the file, its bytes are read.
class MappedFile {
 public:
  // The whole of a regular file, or its first `limit` bytes if it is longer. Errors: as for read_file.
  static Expected<MappedFile> open(const std::filesystem::path& path, uint64_t limit = UINT64_MAX);

  // The bytes that were written to a temporary file, whose space is given back with the last copy. Empty if
  // there are none. Errors: kMayPass if it cannot be mapped.
  static Expected<MappedFile> open(const UnnamedFile& file);

  Span<const uint8_t> bytes() const { return bytes_; }
  // What keeps the bytes.
  std::shared_ptr<const void> owner() const { return owner_; }

  // A view of a part of the file. The range must be within bytes().
  MappedFile range(uint64_t offset, uint64_t length) const;

 private:
  friend class FileMemory;
  std::shared_ptr<const void> owner_;
  Span<const uint8_t> bytes_;
};

// Memory in a temporary file, for results that may be larger than the memory of the machine: at first zeros.
// The file has no name, so that it disappears with the process. Copies share it.
class FileMemory {
 public:
  // Takes the space at once. Errors: as for io_error, such as a full disk.
  static Expected<FileMemory> create(const std::filesystem::path& folder, uint64_t bytes);

  Span<uint8_t> bytes() const { return bytes_; }
  // A read-only view of the memory.
  MappedFile view() const;

 private:
  std::shared_ptr<const void> owner_;
  Span<uint8_t> bytes_;
};

// The step in which large ranges are processed and then released, in bytes.
inline constexpr uint64_t kReleaseStep = uint64_t{8} << 20;

// Calls `visit` for the bytes in steps of kReleaseStep, and releases each step that is a part of a MappedFile.
// `visit` returns whether to continue. Returns false if it stopped.
bool visit_and_release(Span<const uint8_t> bytes, const std::function<bool(Span<const uint8_t>)>& visit);

}  // namespace psplit
