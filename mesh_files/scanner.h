// A window on a stream: it reads words and numbers of text and records of binary files without the whole file
// in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh_files/byte_stream.h"

namespace psplit {

// Lines end with \n, \r\n or a single \r. Spaces, tabs and ends of lines separate words.
class Scanner {
 public:
  explicit Scanner(std::unique_ptr<ByteStream> stream);

  // The next word of this line, empty at its end. It is valid until the next call. A word longer than
  // kLongestWord characters comes in pieces.
  std::string_view word();
  // The next word of this line or of later lines, empty at the end of the file.
  std::string_view next_word();
  // Skips the rest of this line, with its end or without it. False at the end of the file.
  bool next_line();
  bool skip_rest_of_line();
  // The rest of this line, without spaces at both ends. Nothing if it is longer than kLongestText.
  std::optional<std::string> rest_of_line();

  // The next `count` bytes (at most kMostPeeked), or all remaining bytes. Valid until the next call.
  std::string_view peek(size_t count);
  void skip(size_t count);  // bytes that peek returned
  // The lines that are in memory as a whole, from here on, if they end with \n, which is included. Empty
  // without such a line. Valid until the next call.
  std::string_view peek_lines();
  void skip_lines(size_t bytes,
                  uint64_t line_count);  // bytes that peek_lines returned, with their ends of lines
  // The number of remaining bytes, if it is known.
  std::optional<uint64_t> bytes_left() const;
  bool at_end() { return peek(1).empty(); }
  // Reads to the end and returns the number of bytes.
  uint64_t drain();

  uint64_t line() const { return line_; }  // counted from 1
  uint64_t offset() const { return offset_ + at_; }
  Status failure() const { return stream_->failure(); }  // the failure of the stream

  static constexpr size_t kLongestWord = 4096, kLongestText = size_t{1} << 16, kMostPeeked = size_t{1} << 17;

 private:
  // Reads more bytes after the remaining ones. False at the end.
  bool fill();
  void end_line();

  std::unique_ptr<ByteStream> stream_;
  std::unique_ptr<char[]> window_;  // not filled with zeros: most files are small
  size_t at_ = 0, end_ = 0;
  uint64_t offset_ = 0;  // offset of the window in the stream
  uint64_t line_ = 1;
};

// A number as C writes it, independent of the locale. Nothing if the word is not a number or out of the type's
// range. A number too small for the type is zero. Floats may be "nan" and "inf", in any case,
// and what C libraries print for these ("-1.#IND").
std::optional<float> parse_float(std::string_view word);
std::optional<double> parse_double(std::string_view word);
// The double nearest to the number, whose nearest float is what parse_float gives: where rounding twice would
// give another one, it is the next double. Nothing if parse_float gives nothing.
std::optional<double> parse_precise(std::string_view word);
// Decimal digits after at most one sign.
std::optional<int64_t> parse_integer(std::string_view word);

// "line 12: ..."
Status error_at_line(uint64_t line, const std::string& what);
// "byte 1234: ..."
Status error_at_byte(uint64_t offset, const std::string& what);
// A word as messages show it: quoted, shortened and printable.
std::string in_quotes(std::string_view word);

}  // namespace psplit
