#include "mesh_files/byte_stream.h"

#define ZLIB_CONST
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>

#include "system/files.h"
#include "system/io_error.h"
#include "system/operating_system.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

Status failure(const char* what, const fs::path& path, int error) {
  return path_error(what, path, error).at({.file = path.string()});
}
Status read_failure(const fs::path& path, int error) { return failure("cannot read", path, error); }

class FileStream : public ByteStream {
 public:
  FileStream(std::FILE* file, fs::path path, std::optional<uint64_t> size, Progress progress)
      : file_(file), path_(std::move(path)), size_(size), progress_(std::move(progress)) {}

  size_t read(std::span<uint8_t> to) override {
    if (ended_) return 0;
    const size_t got = std::fread(to.data(), 1, to.size(), file_.get());
    ended_ = got < to.size();
    if (ended_ && std::ferror(file_.get()) != 0) failure_ = read_failure(path_, errno);
    done_ += got;
    if (progress_) progress_(done_, size_.value_or(0));
    return got;
  }
  std::optional<uint64_t> size() const override { return size_; }

 private:
  OpenFile file_;
  fs::path path_;
  std::optional<uint64_t> size_;
  Progress progress_;
  size_t done_ = 0;
  bool ended_ = false;
};

class MemoryStream : public ByteStream {
 public:
  explicit MemoryStream(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  size_t read(std::span<uint8_t> to) override {
    const size_t count = std::min(to.size(), bytes_.size() - at_);
    if (count > 0) std::memcpy(to.data(), bytes_.data() + at_, count);
    at_ += count;
    return count;
  }
  std::optional<uint64_t> size() const override { return bytes_.size(); }

 private:
  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
};

class JoinedStream : public ByteStream {
 public:
  JoinedStream(std::vector<uint8_t> head, std::unique_ptr<ByteStream> rest)
      : bytes_(std::move(head)), head_(bytes_), rest_(std::move(rest)) {}

  size_t read(std::span<uint8_t> to) override {
    if (const size_t got = head_.read(to); got > 0) return got;
    const size_t got = rest_->read(to);
    failure_ = rest_->failure();
    return got;
  }
  std::optional<uint64_t> size() const override { return rest_->size(); }

 private:
  const std::vector<uint8_t> bytes_;
  MemoryStream head_;
  std::unique_ptr<ByteStream> rest_;
};

class GzipStream : public ByteStream {
 public:
  explicit GzipStream(std::unique_ptr<ByteStream> packed) : packed_(std::move(packed)) {
    constexpr int kGzipOnly = 16 + MAX_WBITS;
    if (inflateInit2(&state_, kGzipOnly) != Z_OK) failure_ = runtime_failure("zlib cannot be initialized");
  }
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;
  ~GzipStream() override { inflateEnd(&state_); }

  size_t read(std::span<uint8_t> to) override {
    if (!failure_.ok() || ended_ || to.empty()) return 0;
    const size_t room = std::min<size_t>(to.size(), std::numeric_limits<uInt>::max());
    state_.next_out = to.data();
    state_.avail_out = static_cast<uInt>(room);
    while (state_.avail_out == room && failure_.ok() && !ended_) step();
    const size_t got = room - state_.avail_out;
    unpacked_bytes_ += got;
    if (unpacked_bytes_ > kFreeBytes && unpacked_bytes_ / kMostRatio > packed_bytes_ && failure_.ok())
      failure_ = invalid_input("gzip: unpacks to over " + std::to_string(kMostRatio) + " times its bytes");
    return failure_.ok() ? got : 0;
  }

 private:
  static constexpr uint64_t kMostRatio = 100, kFreeBytes = uint64_t{64} << 20;

  // Provides more packed bytes, unless there are none.
  bool refill() {
    if (state_.avail_in > 0) return true;
    const size_t got = packed_->read(buffer_);
    packed_bytes_ += got;
    state_.next_in = buffer_.data();
    state_.avail_in = static_cast<uInt>(got);
    if (got == 0) failure_ = packed_->failure();
    return got > 0;
  }

  void step() {
    if (!refill()) {
      if (failure_.ok()) failure_ = invalid_input("gzip: the file ends early");
      return;
    }
    const int result = inflate(&state_, Z_NO_FLUSH);
    if (result == Z_STREAM_END) return finish_member();
    if (result != Z_OK && result != Z_BUF_ERROR)
      failure_ = invalid_input(std::string("gzip: ") + (state_.msg == nullptr ? "broken data" : state_.msg));
  }

  // Another member may follow. Zeros that pad the file are ignored.
  void finish_member() {
    while (refill() && *state_.next_in == 0) {
      ++state_.next_in;
      --state_.avail_in;
    }
    ended_ = state_.avail_in == 0;
    if (ended_) return;
    const auto* const rest = state_.next_in;
    const uInt rest_count = state_.avail_in;
    inflateReset(&state_);
    state_.next_in = rest;
    state_.avail_in = rest_count;
  }

  std::unique_ptr<ByteStream> packed_;
  std::array<uint8_t, size_t{1} << 16> buffer_;
  z_stream state_{};
  uint64_t packed_bytes_ = 0, unpacked_bytes_ = 0;
  bool ended_ = false;
};

}  // namespace

Expected<std::unique_ptr<ByteStream>> open_byte_stream(const fs::path& path, const Progress& progress) {
  if (path == "-") return std::unique_ptr<ByteStream>(new FileStream(stdin, "stdin", std::nullopt, progress));
  std::error_code error;
  const uintmax_t bytes = fs::file_size(path, error);  // pipes and devices have none
  if (error == std::errc::is_a_directory) return read_failure(path, EISDIR);
  const std::optional<uint64_t> size = error ? std::nullopt : std::optional<uint64_t>(bytes);
  std::FILE* const file = open_file(path, "rb");
  if (file == nullptr) return failure("cannot open", path, errno);
  return std::unique_ptr<ByteStream>(new FileStream(file, path, size, progress));
}

std::unique_ptr<ByteStream> memory_stream(std::span<const uint8_t> bytes) {
  return std::make_unique<MemoryStream>(bytes);
}

bool is_gzip(std::span<const uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0x1f && bytes[1] == 0x8b && bytes[2] == 8;
}

std::unique_ptr<ByteStream> unpack_gzip(std::unique_ptr<ByteStream> packed) {
  return std::make_unique<GzipStream>(std::move(packed));
}

std::unique_ptr<ByteStream> join_streams(std::vector<uint8_t> head, std::unique_ptr<ByteStream> rest) {
  return std::make_unique<JoinedStream>(std::move(head), std::move(rest));
}

}  // namespace psplit
