// Buffered access to temporary files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "encoder/spill.h"
#include "psplit/base.h"
#include "system/mapped_file.h"
#include "system/operating_system.h"

namespace psplit {

// The bytes of an array or a vector of plain values.
std::span<const uint8_t> bytes_of(const auto& values) {
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(values[0])};
}

// A temporary file that grows at its end.
class AppendFile : public Spill {
 public:
  static Expected<AppendFile> create(const std::filesystem::path& folder);

  Status append(Span<const uint8_t> bytes) override;
  Status read(uint64_t offset, Span<uint8_t> to) override {
    Status status = flush();
    return status.ok() ? file_.read(offset, to) : std::move(status);
  }
  uint64_t size() const override { return written_ + buffer_.size(); }
  // Writes the buffered bytes: file() contains only flushed bytes.
  Status flush();
  // Replaces bytes that were flushed.
  Status rewrite(uint64_t offset, std::span<const uint8_t> bytes) { return file_.write(offset, bytes); }
  const UnnamedFile& file() const { return file_; }
  // All bytes. The space is theirs: nothing else is called after that. Errors: as for the file.
  Expected<MappedFile> map();
  void close() { *this = AppendFile(); }

 private:
  UnnamedFile file_;
  std::vector<uint8_t> buffer_;
  uint64_t written_ = 0;
};

// Records in buckets, all in one temporary file. The number of records of each bucket is known before.
class BucketFile {
 public:
  // `counts` has the most records of each bucket. `memory`: about the bytes for all buffers together.
  static Expected<BucketFile> create(const std::filesystem::path& folder, std::span<const uint64_t> counts,
                                     size_t record_bytes, uint64_t memory);

  Status add(uint32_t bucket, std::span<const uint8_t> record);
  // Writes all buffers and frees them. Call it before the first read().
  Status finish();
  uint64_t count(uint32_t bucket) const { return buckets_[bucket].count; }
  // Reads records of a bucket from the number `first` on.
  Status read(uint32_t bucket, uint64_t first, std::span<uint8_t> to) const;

 private:
  struct Bucket {
    uint64_t begin = 0;  // its first record
    uint64_t count = 0;
    uint32_t buffered = 0;
  };
  Status write(uint32_t bucket);

  UnnamedFile file_;
  std::vector<Bucket> buckets_;
  size_t record_bytes_ = 0;
  uint32_t most_buffered_ = 1;
  std::vector<uint8_t> buffers_;
};

// Random reads of a file through a few pages in memory. The file must not change.
class PagedFile {
 public:
  Status read(const UnnamedFile& file, uint64_t file_bytes, uint64_t offset, std::span<uint8_t> to);

 private:
  static constexpr uint64_t kPage = uint64_t{1} << 14;
  static constexpr size_t kPages = 256;
  std::vector<uint8_t> pages_;
  std::vector<uint64_t> page_at_;
};

}  // namespace psplit
