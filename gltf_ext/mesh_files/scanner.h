// A window on a stream: words and numbers of text, and records of binary files, without the file in memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gltf_ext/mesh_files/byte_stream.h"

namespace psplit {

// Lines end with \n, \r\n or a \r alone. Words are what spaces, tabs and ends of lines part.
class Scanner {
 public:
  explicit Scanner(std::unique_ptr<ByteStream> stream);

  // The next word of this line, empty at the line's end. It is valid until the next call. A word is at most
  // kLongestWord characters; what is longer comes in pieces.
  std::string_view word();
  // The next word of this line or of those that follow, empty at the end of the file.
  std::string_view next_word();
  // Skips what is left of this line, with its end or without; false where the file ends.
  bool next_line();
  bool skip_rest_of_line();
  // What is left of this line, but for spaces at both ends; nothing where that is over kLongestText.
  std::optional<std::string> rest_of_line();

  // The next `count` bytes, at most kMostPeeked, or all that are left. Valid until the next call.
  std::string_view peek(size_t count);
  void skip(size_t count);  // of those that peek returned
  // The number of bytes that are left, where that is known.
  std::optional<uint64_t> bytes_left() const;
  bool at_end() { return peek(1).empty(); }
  // Reads to the end, and returns how many bytes that were.
  uint64_t drain();

  uint64_t line() const { return line_; }  // from 1
  uint64_t offset() const { return offset_ + at_; }
  Status failure() const { return stream_->failure(); }  // of the stream

  static constexpr size_t kLongestWord = 4096, kLongestText = size_t{1} << 16, kMostPeeked = size_t{1} << 17;

 private:
  // More bytes behind those that are left; false where there are none.
  bool fill();
  void end_line();

  std::unique_ptr<ByteStream> stream_;
  std::vector<char> window_;
  size_t at_ = 0, end_ = 0;
  uint64_t offset_ = 0;  // of the window in the stream
  uint64_t line_ = 1;
};

// A number as C writes them, in any locale; nothing where the word is none, or is beyond what the type holds.
// What is too small for the type is zero. Floats may be "nan" and "inf", in any case.
std::optional<float> parse_float(std::string_view word);
std::optional<double> parse_double(std::string_view word);
// Decimal digits behind at most one sign.
std::optional<int64_t> parse_integer(std::string_view word);

// "line 12: ..."
Status error_at_line(uint64_t line, const std::string& what);
// "byte 1234: ..."
Status error_at_byte(uint64_t offset, const std::string& what);
// A word as messages show it: in quotes, short, and printable.
std::string in_quotes(std::string_view word);

}  // namespace psplit
