// Rows of plain numbers in text, which all threads read at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh_files/scanner.h"
#include "psplit/parallel.h"

namespace psplit {

// The rows that one thread has read.
template <typename Rows>
struct PlainSlice {
  Rows rows;
  uint64_t row_count = 0, line_count = 0;
  const char* end = nullptr;  // of what was read
  bool is_complete = false;   // otherwise the next row is not plain
};

// Returns whether there was a blank.
inline bool skip_blanks(const char*& at, const char* end) {
  const char* const begin = at;
  while (at != end && (*at == ' ' || *at == '\t')) ++at;
  return at != begin;
}

// Reads up to `most` rows from `at` to `end`, where a line ends. Each row is one line. `read_row(at, end)`
// returns the end of the row's last number, or null if the row is not plain; `store_row(rows)` keeps the row
// that it read.
template <typename Rows, typename Reader>
void read_plain_slice(const char* at, const char* end, uint64_t most, Reader reader, PlainSlice<Rows>& slice) {
  const auto ends_line = [&](const char* c) { return *c == '\n' || (*c == '\r' && c != end && c[1] == '\n'); };
  while (slice.row_count < most) {
    while (skip_blanks(at, end) || (at != end && ends_line(at))) {
      if (at == end || !ends_line(at)) continue;
      slice.line_count += *at == '\n' ? 1 : 0;
      ++at;
    }
    if (at == end) break;
    const char* behind = reader.read_row(at, end);
    if (behind == nullptr) break;
    skip_blanks(behind, end);
    if (!ends_line(behind)) break;
    reader.store_row(slice.rows);
    ++slice.row_count;
    at = behind;
  }
  slice.end = at;
  slice.is_complete = at == end || slice.row_count == most;
}

// Reads rows from the lines that the scanner has in memory. Ends before the first row that is not plain:
// is_complete of the last slice is false then. Slices are in order. A Reader has read_row and store_row as
// above, and is copied for each thread.
template <typename Rows, typename Reader>
std::vector<PlainSlice<Rows>> read_plain_rows(Scanner& scanner, uint64_t most, const Reader& reader,
                                              const ThreadPool& pool) {
  constexpr size_t kLeastBytes = size_t{1} << 15;  // of a slice
  std::vector<PlainSlice<Rows>> slices(1);
  const std::string_view text = scanner.peek_lines();
  if (text.empty()) return slices;
  const char* const begin = text.data();
  const char* const end = begin + text.size() - 1;
  // A first row tells whether the others are worth a try.
  read_plain_slice(begin, end, std::min<uint64_t>(most, 1), reader, slices[0]);
  if (slices[0].row_count == 1 && most > 1) {
    // No thread may read what comes behind the last row.
    const bool may_divide = static_cast<uint64_t>(std::count(begin, end, '\n')) < most;
    const char* const rest = slices[0].end;
    const size_t count = may_divide ? std::clamp<size_t>(static_cast<size_t>(end - rest) / kLeastBytes, 1,
                                                         static_cast<size_t>(pool.thread_count()))
                                    : 1;
    slices.resize(count + 1);
    const auto border = [&](size_t i) {
      const char* const about = rest + static_cast<size_t>(end - rest) * i / count;
      return i == 0 ? rest : i == count ? end : std::find(about, end, '\n');
    };
    pool.for_each(
        count, [&](size_t i) { read_plain_slice(border(i), border(i + 1), most - 1, reader, slices[i + 1]); });
  }
  const auto last = std::ranges::find(slices, false, &PlainSlice<Rows>::is_complete);
  if (last != slices.end()) slices.erase(last + 1, slices.end());
  uint64_t line_count = 0;
  for (const PlainSlice<Rows>& slice : slices) line_count += slice.line_count;
  scanner.skip_lines(static_cast<size_t>(slices.back().end - begin), line_count);
  return slices;
}

}  // namespace psplit
