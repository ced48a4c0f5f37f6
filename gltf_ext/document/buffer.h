// The bytes of a buffer of a document.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "src/span.h"
#include "system/mapped_file.h"

namespace psplit {

// Owned bytes, or the bytes of a mapped file that other buffers may share. Reading is the same for both.
class Buffer {
 public:
  Buffer() = default;
  Buffer(std::vector<uint8_t> bytes) : owned_(std::move(bytes)) {}
  Buffer(MappedFile file) : file_(std::move(file)) {}

  Span<const uint8_t> bytes() const { return is_mapped() ? file_.bytes() : Span(owned_); }
  const uint8_t* data() const { return bytes().data(); }
  size_t size() const { return bytes().size(); }
  const uint8_t* begin() const { return bytes().begin(); }
  const uint8_t* end() const { return bytes().end(); }
  bool empty() const { return bytes().empty(); }
  bool is_mapped() const { return !file_.bytes().empty(); }

  // The bytes, to be changed: those of a mapped file are copied first.
  std::vector<uint8_t>& own() {
    if (is_mapped()) {
      owned_.reserve(file_.bytes().size());
      visit_and_release(file_.bytes(), [&](Span<const uint8_t> step) {
        owned_.insert(owned_.end(), step.begin(), step.end());
        return true;
      });
      file_ = {};
    }
    return owned_;
  }

  // Only the range stays, which must be within bytes().
  void cut_to(size_t offset, size_t length) {
    if (is_mapped()) {
      file_ = file_.range(offset, length);
    } else {
      owned_.resize(offset + length);
      owned_.erase(owned_.begin(), owned_.begin() + static_cast<std::ptrdiff_t>(offset));
    }
  }

 private:
  std::vector<uint8_t> owned_;  // empty while a file is mapped
  MappedFile file_;
};

}  // namespace psplit
