// The lines of what another process writes into a pipe.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace psplit {

// Lines out of the bytes of a pipe.
class PipeLines {
 public:
  void add(std::string_view text) { text_ += text; }
  std::optional<std::string> next() {
    const size_t end = text_.find('\n', begin_);
    if (end == std::string::npos) {
      text_.erase(0, begin_);
      begin_ = 0;
      return std::nullopt;
    }
    std::string line = text_.substr(begin_, end - begin_);
    begin_ = end + 1;
    return line;
  }

 private:
  std::string text_;
  size_t begin_ = 0;
};

// The last lines of what a command printed, as one line.
class LastLines {
 public:
  void add(std::string_view text) {
    text_ += text;
    if (text_.size() > 2 * kMostBytes) text_.erase(0, text_.size() - kMostBytes);
  }
  std::string joined() const {
    std::vector<std::string> lines;
    std::string line;
    for (const char byte : text_ + "\n") {
      if (byte != '\n' && byte != '\r') {
        line += static_cast<unsigned char>(byte) < ' ' ? ' ' : byte;
      } else if (line.find_first_not_of(' ') != std::string::npos) {
        lines.push_back(std::exchange(line, ""));
      }
    }
    std::string text;
    for (size_t i = lines.size() - std::min(lines.size(), kMostLines); i < lines.size(); ++i)
      text += (text.empty() ? "" : " | ") + lines[i];
    return text.size() > kMostBytes ? "..." + text.substr(text.size() - kMostBytes) : text;
  }

 private:
  static constexpr size_t kMostLines = 3, kMostBytes = 600;
  std::string text_;
};

}  // namespace psplit
