// A buffer of a file to be written, composed of bytes that are elsewhere in memory: nothing is copied.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

class PackedBuffer {
 public:
  // glTF requires 4; property tables of EXT_structural_metadata have 8-byte values.
  static constexpr uint64_t kAlignment = 8;

  // Returns the offset of the bytes, a multiple of kAlignment. The bytes must outlive the buffer.
  uint64_t add(std::span<const uint8_t> bytes) {
    pad(kAlignment);
    const uint64_t start = size_;
    append(bytes);
    return start;
  }
  uint64_t add(std::vector<uint8_t>&& bytes) {
    owned_.push_back(std::move(bytes));
    return add(std::span<const uint8_t>(owned_.back()));
  }

  // Appends zeros up to a multiple of `alignment`, which is at most kAlignment.
  void pad(uint64_t alignment) {
    static constexpr uint8_t kZeros[kAlignment] = {};
    append(std::span(kZeros).first(static_cast<size_t>((alignment - size_ % alignment) % alignment)));
  }

  uint64_t size() const { return size_; }
  const std::vector<std::span<const uint8_t>>& parts() const { return parts_; }

 private:
  void append(std::span<const uint8_t> bytes) {
    if (bytes.empty()) return;
    parts_.push_back(bytes);
    size_ += bytes.size();
  }

  std::vector<std::vector<uint8_t>> owned_;
  std::vector<std::span<const uint8_t>> parts_;
  uint64_t size_ = 0;
};

}  // namespace psplit
