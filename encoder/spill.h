// Bytes that do not have to fit into memory, for example in a temporary file.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "psplit/base.h"

namespace psplit {

// Not thread-safe.
class StoredBytes {
 public:
  virtual ~StoredBytes() = default;
  virtual uint64_t size() const = 0;
  // Fills all of `to` from place `offset` on. The range is within size(). Errors: kIo.
  virtual Status read(uint64_t offset, Span<uint8_t> to) = 0;
};

// Bytes are appended and read in any order of calls.
class Spill : public StoredBytes {
 public:
  // Errors: kIo, for example a full disk. After an error the spill may hold anything.
  virtual Status append(Span<const uint8_t> bytes) = 0;
};

// Makes an empty spill. Errors: kIo.
using MakeSpill = std::function<Expected<std::unique_ptr<Spill>>()>;

// Bytes in memory.
class MemorySpill : public Spill {
 public:
  uint64_t size() const override { return bytes_.size(); }
  Status read(uint64_t offset, Span<uint8_t> to) override {
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
    return {};
  }
  Status append(Span<const uint8_t> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return {};
  }

 private:
  std::vector<uint8_t> bytes_;
};
inline Expected<std::unique_ptr<Spill>> make_memory_spill() { return std::unique_ptr<Spill>(new MemorySpill); }

}  // namespace psplit
