#include "system/text_lines.h"

#include <cerrno>

#include "system/io_error.h"
#include "system/operating_system.h"

namespace psplit {

Expected<TextLines> TextLines::open(const std::filesystem::path& path) {
  if (path == "-") return of(stdin);
  TextLines lines;
  lines.name_ = path.string();
  lines.file_ = {open_file(path, "rb"), Close{true}};
  if (lines.file_ == nullptr) return io_error("cannot open", errno, {.file = lines.name_});
  return lines;
}

TextLines TextLines::of(std::FILE* file) {
  TextLines lines;
  lines.name_ = file == stdin ? "stdin" : "";
  lines.file_ = {file, Close{false}};
  return lines;
}

bool TextLines::next(std::string_view& line) {
  constexpr size_t kBlock = size_t{1} << 18;
  size_t searched = begin_;
  size_t end = text_.find('\n', searched);
  while (end == std::string::npos && !at_end_) {
    text_.erase(0, begin_);
    begin_ = 0;
    searched = text_.size();
    text_.resize(searched + kBlock);
    const size_t got = std::fread(text_.data() + searched, 1, kBlock, file_.get());
    if (got < kBlock && std::ferror(file_.get()) != 0)
      status_ = io_error("cannot read", errno, {.file = name_});
    at_end_ = got < kBlock;
    text_.resize(searched + got);
    end = text_.find('\n', searched);
  }
  is_whole_ = end != std::string::npos;
  if (!is_whole_) end = text_.size();
  if (!status_.ok() || (end == begin_ && !is_whole_)) return false;
  line = std::string_view(text_).substr(begin_, end - begin_);
  begin_ = end + (is_whole_ ? 1 : 0);
  offset_ = next_offset_;
  next_offset_ += line.size() + (is_whole_ ? 1 : 0);
  ++number_;
  return true;
}

}  // namespace psplit
