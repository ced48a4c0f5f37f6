// Text for a terminal: wrapped paragraphs, and tables.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace psplit {

// The words of `text` in lines of at most `width` columns. Every line except the first begins with `indent`
// spaces. A word that is longer than `width` has a line of its own.
std::string wrap_text(const std::string& text, size_t width, size_t indent);

// The text with its control characters, which a terminal would obey, as escapes: "\\x1B". Names of files and
// texts of assets may hold any. Tabs stay, and line feeds if `keeps_lines` is true.
std::string printable(const std::string& text, bool keeps_lines = false);

// The width of tables, unless --wide asks for all columns.
inline constexpr size_t kTableWidth = 100;

// Each column is as wide as its widest cell. The first `left_columns` are aligned left, the others right.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header, size_t left_columns = 1);
  void add(std::vector<std::string> row);
  // Drops all columns whose header is not among these.
  void keep_columns(std::span<const std::string> headers);
  // Aligns the last column left: for names and lists, which may have any length.
  void align_last_left() { last_left_ = true; }
  std::string to_string() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  size_t left_columns_;
  bool last_left_ = false;
};

// The words in a line, with `between` between them.
std::string joined(const std::vector<std::string>& words, const char* between = ", ");

}  // namespace psplit
