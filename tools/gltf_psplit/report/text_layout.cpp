#include "tools/gltf_psplit/report/text_layout.h"

#include <algorithm>
#include <sstream>

namespace psplit {

std::string wrap_text(const std::string& text, size_t width, size_t indent) {
  std::istringstream words(text);
  std::string lines, word;
  size_t column = 0;
  while (words >> word) {
    if (column > 0 && column + 1 + word.size() > width) {
      lines += "\n" + std::string(indent, ' ');
      column = 0;
    } else if (column > 0) {
      lines += " ";
      ++column;
    }
    lines += word;
    column += word.size();
  }
  return lines;
}

std::string printable(const std::string& text, bool keeps_lines) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string shown;
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto before = i == 0 ? '\0' : text[i - 1];
    // UTF-8 writes the controls U+0080 to U+009F as C2 and a byte from 80 to 9F.
    const bool is_upper = before == '\xC2' && byte >= 0x80 && byte < 0xa0;
    if ((byte >= 0x20 && byte != 0x7f && !is_upper) || byte == '\t' || (keeps_lines && byte == '\n')) {
      shown += text[i];
      continue;
    }
    if (is_upper) shown.pop_back();
    shown += std::string(is_upper ? "\\u00" : "\\x") + kHex[byte >> 4] + kHex[byte & 15];
  }
  return shown;
}

TextTable::TextTable(std::vector<std::string> header, size_t left_columns) : left_columns_(left_columns) {
  rows_.push_back(std::move(header));
}

void TextTable::add(std::vector<std::string> row) {
  row.resize(rows_.front().size());
  rows_.push_back(std::move(row));
}

void TextTable::keep_columns(std::span<const std::string> headers) {
  std::vector<size_t> kept;
  size_t left_columns = 0;
  for (size_t i = 0; i < rows_.front().size(); ++i) {
    if (std::ranges::find(headers, rows_.front()[i]) == headers.end()) continue;
    if (i < left_columns_) ++left_columns;
    kept.push_back(i);
  }
  for (std::vector<std::string>& row : rows_) {
    std::vector<std::string> cells;
    for (const size_t i : kept) cells.push_back(std::move(row[i]));
    row = std::move(cells);
  }
  left_columns_ = left_columns;
}

std::string TextTable::to_string() const {
  std::vector<size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - row[i].size(), ' ');
      const bool left = i < left_columns_ || (last_left_ && i + 1 == row.size());
      line += (i == 0 ? "" : "  ") + (left ? row[i] + padding : padding + row[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

}  // namespace psplit
