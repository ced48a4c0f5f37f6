// The lines of a text file of any length, in little memory.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "psplit/base.h"

namespace psplit {

class TextLines {
 public:
  // "-" is stdin. Errors: as for io_error.
  static Expected<TextLines> open(const std::filesystem::path& path);
  // From the position of a file that is open, and that stays the caller's.
  static TextLines of(std::FILE* file);

  // The next line without its line feed, valid until the next call. False at the end and after an error.
  bool next(std::string_view& line);
  uint64_t number() const { return number_; }  // of the line that `next` returned, from 1
  uint64_t offset() const { return offset_; }  // of its first byte, from where the lines begin
  // Whether that line had a line feed. The last line of a file that is still written has none.
  bool is_whole() const { return is_whole_; }
  const Status& status() const { return status_; }  // the error that ended the lines, if there was one

 private:
  struct Close {
    bool owns;
    void operator()(std::FILE* file) const {
      if (owns) std::fclose(file);
    }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::string name_, text_;
  size_t begin_ = 0;
  uint64_t number_ = 0, offset_ = 0, next_offset_ = 0;
  bool is_whole_ = true, at_end_ = false;
  Status status_;
};

}  // namespace psplit
