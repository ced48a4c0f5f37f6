// A stream of bytes from a disk, a pipe or memory; gzip data is unpacked.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"

namespace psplit {

// Not thread-safe. After a failure the stream has no more bytes.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  // Reads bytes into the front of `to` and returns their number; 0 at the end or after a failure.
  virtual size_t read(std::span<uint8_t> to) = 0;

  // The total number of bytes, if it is known before they are read.
  virtual std::optional<uint64_t> size() const { return std::nullopt; }

  // The reason why there are no more bytes: ok at a regular end, kIo, or kInvalidInput for invalid gzip data.
  Status failure() const { return failure_; }

 protected:
  Status failure_;
};

// A file, or stdin for "-". `progress` counts the bytes as they are on the disk; their total is 0 if it is not
// known. Errors: kIo (folders included).
Expected<std::unique_ptr<ByteStream>> open_byte_stream(const std::filesystem::path& path,
                                                       const Progress& progress = {});

// The bytes must outlive the stream.
std::unique_ptr<ByteStream> memory_stream(std::span<const uint8_t> bytes);

// Whether bytes begin with the signature of gzip.
bool is_gzip(std::span<const uint8_t> bytes);

// The unpacked content of `packed`, member by member. Bytes are unpacked on request, so that a small file that
// unpacks to a huge one takes no memory. Fails with kInvalidInput if it unpacks to more than a hundred times
// its bytes and more than 64 MiB.
std::unique_ptr<ByteStream> unpack_gzip(std::unique_ptr<ByteStream> packed);

// `head`, followed by the bytes that remain in `rest`.
std::unique_ptr<ByteStream> join_streams(std::vector<uint8_t> head, std::unique_ptr<ByteStream> rest);

}  // namespace psplit
