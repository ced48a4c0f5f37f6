#include "gltf_ext/out_of_core/file_blocks.h"

#include <algorithm>
#include <cstring>

namespace psplit {
namespace {

constexpr size_t kAppendBuffer = size_t{1} << 20;

}  // namespace

Expected<AppendFile> AppendFile::create(const std::filesystem::path& folder) {
  Expected<UnnamedFile> file = UnnamedFile::create(folder);
  if (!file) return file.status();
  AppendFile result;
  result.file_ = std::move(*file);
  result.buffer_.reserve(kAppendBuffer);
  return result;
}

Status AppendFile::append(Span<const uint8_t> bytes) {
  if (buffer_.size() + bytes.size() > kAppendBuffer)
    if (Status status = flush(); !status.ok()) return status;
  if (bytes.size() > kAppendBuffer) {
    Status status = file_.write(written_, bytes);
    if (status.ok()) written_ += bytes.size();
    return status;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return {};
}

Status AppendFile::flush() {
  Status status = file_.write(written_, buffer_);
  if (!status.ok()) return status;
  written_ += buffer_.size();
  buffer_.clear();
  return {};
}

Expected<MappedFile> AppendFile::map() {
  if (Status status = flush(); !status.ok()) return status;
  Expected<MappedFile> mapped = MappedFile::open(file_);
  close();
  return mapped;
}

Expected<BucketFile> BucketFile::create(const std::filesystem::path& folder, std::span<const uint64_t> counts,
                                        size_t record_bytes, uint64_t memory) {
  constexpr uint64_t kMostBufferBytes = uint64_t{1} << 17;  // of a bucket: more saves no time
  Expected<UnnamedFile> file = UnnamedFile::create(folder);
  if (!file) return file.status();
  BucketFile result;
  result.file_ = std::move(*file);
  result.record_bytes_ = record_bytes;
  result.buckets_.resize(counts.size());
  uint64_t begin = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    result.buckets_[i].begin = begin;
    begin += counts[i];
  }
  const uint64_t each = std::min(memory / std::max<uint64_t>(1, counts.size()), kMostBufferBytes);
  result.most_buffered_ = static_cast<uint32_t>(std::max<uint64_t>(1, each / record_bytes));
  result.buffers_.resize(counts.size() * result.most_buffered_ * record_bytes);
  return result;
}

Status BucketFile::add(uint32_t index, std::span<const uint8_t> record) {
  Bucket& bucket = buckets_[index];
  std::memcpy(buffers_.data() + (size_t{index} * most_buffered_ + bucket.buffered) * record_bytes_,
              record.data(), record_bytes_);
  return ++bucket.buffered == most_buffered_ ? write(index) : Status();
}

Status BucketFile::write(uint32_t index) {
  Bucket& bucket = buckets_[index];
  const std::span<const uint8_t> bytes = std::span(buffers_).subspan(
      size_t{index} * most_buffered_ * record_bytes_, bucket.buffered * record_bytes_);
  Status status = file_.write((bucket.begin + bucket.count) * record_bytes_, bytes);
  bucket.count += bucket.buffered;
  bucket.buffered = 0;
  return status;
}

Status BucketFile::finish() {
  for (uint32_t i = 0; i < buckets_.size(); ++i)
    if (Status status = write(i); !status.ok()) return status;
  buffers_ = std::vector<uint8_t>();
  return {};
}

Status BucketFile::read(uint32_t bucket, uint64_t first, std::span<uint8_t> to) const {
  return file_.read((buckets_[bucket].begin + first) * record_bytes_, to);
}

Status PagedFile::read(const UnnamedFile& file, uint64_t file_bytes, uint64_t offset, std::span<uint8_t> to) {
  constexpr uint64_t kNoPage = UINT64_MAX;
  if (pages_.empty()) {
    pages_.resize(kPages * kPage);
    page_at_.assign(kPages, kNoPage);
  }
  while (!to.empty()) {
    const uint64_t page = offset / kPage, within = offset % kPage;
    const size_t slot = page % kPages;
    uint8_t* const bytes = pages_.data() + slot * kPage;
    if (page_at_[slot] != page) {
      page_at_[slot] = kNoPage;
      const uint64_t count = std::min(kPage, file_bytes - page * kPage);
      if (Status status = file.read(page * kPage, {bytes, static_cast<size_t>(count)}); !status.ok())
        return status;
      page_at_[slot] = page;
    }
    const size_t count = std::min<size_t>(to.size(), kPage - within);
    std::memcpy(to.data(), bytes + within, count);
    to = to.subspan(count);
    offset += count;
  }
  return {};
}

}  // namespace psplit
