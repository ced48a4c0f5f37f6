// Bytes of a file as they arrive: from disk, a pipe or memory, and unpacked where gzip packed them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/status.h"

namespace psplit {

// One reader at a time. A stream that failed has no more bytes.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  // Fills the front of `to` and returns how many bytes that were; 0 at the end, or after a failure.
  virtual size_t read(std::span<uint8_t> to) = 0;

  // How many bytes there are in all, where that is known before they are read.
  virtual std::optional<uint64_t> size() const { return std::nullopt; }

  // Why there are no more bytes: ok at a proper end. kIo, or kInvalidInput for what gzip did not write.
  Status failure() const { return failure_; }

 protected:
  Status failure_;
};

// A file, or stdin for "-". Errors: kIo (folders included).
Expected<std::unique_ptr<ByteStream>> open_stream(const std::filesystem::path& path);

// Bytes that outlive the stream.
std::unique_ptr<ByteStream> memory_stream(std::span<const uint8_t> bytes);

// Whether bytes begin as gzip's files do.
bool is_gzip(std::span<const uint8_t> bytes);

// What `packed` holds, member by member. Bytes come as they are asked for, so that a small file that unpacks to
// a huge one costs no memory; kInvalidInput where it unpacks to over a hundred times its bytes and 64 MiB.
std::unique_ptr<ByteStream> unpack_gzip(std::unique_ptr<ByteStream> packed);

// `head` and then what is left of `rest`.
std::unique_ptr<ByteStream> join_streams(std::vector<uint8_t> head, std::unique_ptr<ByteStream> rest);

}  // namespace psplit
