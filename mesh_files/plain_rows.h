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

// Skips blanks of a text that does not end with them. Returns whether there were some.
inline bool skip_blanks(const char*& at) {
  const char* const begin = at;
  while (*at == ' ' || *at == '\t') ++at;
  return at != begin;
}

// Reads up to `most` rows from `at` to `end`, where a line ends with \n. Each row is one line. `resize(rows,
// n)` gives rows memory for n of them; `read_row(at, end, rows, n)` reads row n, and returns the end of its
// last number, or null if the row is not plain.
template <typename Rows, typename Reader>
void read_plain_slice(const char* at, const char* end, uint64_t most, const Reader& reader,
                      PlainSlice<Rows>& slice) {
  constexpr uint64_t kBlock = 1024;  // rows
  const auto ends_line = [&](const char* c) { return *c == '\n' || (*c == '\r' && c != end && c[1] == '\n'); };
  for (uint64_t room = 0; slice.row_count < most;) {
    while (skip_blanks(at) || (at != end && ends_line(at))) {
      if (at == end || !ends_line(at)) continue;
      slice.line_count += *at == '\n' ? 1 : 0;
      ++at;
    }
    if (at == end) break;
    if (slice.row_count == room)
      reader.resize(slice.rows, static_cast<size_t>(room += std::min(kBlock, most - room)));
    const char* behind = reader.read_row(at, end, slice.rows, static_cast<size_t>(slice.row_count));
    if (behind == nullptr) break;
    skip_blanks(behind);
    if (!ends_line(behind)) break;
    ++slice.row_count;
    at = behind;
  }
  reader.resize(slice.rows, static_cast<size_t>(slice.row_count));
  slice.end = at;
  slice.is_complete = at == end || slice.row_count == most;
}

// How many lines end in these characters. Counts of bytes are vectors of bytes.
inline uint64_t line_ends(const char* begin, const char* end) {
  constexpr ptrdiff_t kMost = 240;  // what a byte can count
  uint64_t all = 0;
  while (begin != end) {
    const char* const block_end = begin + std::min(kMost, end - begin);
    uint8_t count = 0;
    for (; begin != block_end; ++begin) count = static_cast<uint8_t>(count + (*begin == '\n' ? 1 : 0));
    all += count;
  }
  return all;
}

// The end of the first `most` of the lines that end at `end`, and the number of these lines.
inline std::pair<const char*, uint64_t> first_lines(const char* begin, const char* end, uint64_t most) {
  constexpr ptrdiff_t kBlock = 1 << 14;
  uint64_t line_count = 0;
  for (const char* block = begin; block < end;) {
    const char* const block_end = block + std::min(kBlock, end - block);
    const uint64_t in_block = line_ends(block, block_end);
    if (line_count + in_block < most) {
      line_count += in_block;
      block = block_end;
      continue;
    }
    for (;; ++block) {
      block = std::find(block, block_end, '\n');
      if (++line_count == most) return {block, most};
    }
  }
  return {end, line_count + 1};
}

// Reads rows from the lines that the scanner has in memory. Ends before the first row that is not plain:
// is_complete of the last slice is false then. Slices are in order. A Reader has resize and read_row as above,
// and reserve(rows, count), so that rows can grow to `count` without being moved. All threads share it.
template <typename Rows, typename Reader>
std::vector<PlainSlice<Rows>> read_plain_rows(Scanner& scanner, uint64_t most, const Reader& reader,
                                              const ThreadPool& pool) {
  constexpr size_t kLeastBytes = size_t{1} << 15;  // of a slice
  std::vector<PlainSlice<Rows>> slices(1);
  const std::string_view text = scanner.peek_lines();
  if (text.empty()) return slices;
  const char* const begin = text.data();
  const char* const text_end = begin + text.size() - 1;
  // A first row tells whether the others are worth a try.
  read_plain_slice(begin, text_end, std::min<uint64_t>(most, 1), reader, slices[0]);
  if (slices[0].row_count == 1 && most > 1) {
    const char* const rest = slices[0].end;
    // Each row is in a line of its own, so the rest has no more rows than lines. No thread reads what comes
    // after the last row. A line ends where the first row does.
    const auto [end, line_count] = first_lines(rest, text_end, most);
    const size_t bytes = static_cast<size_t>(end - rest);
    const size_t count = std::clamp<size_t>(bytes / kLeastBytes, 1, static_cast<size_t>(pool.thread_count()));
    slices.resize(count + 1);
    const auto border = [&, last = end](size_t i) {
      return i == 0 ? rest : i == count ? last : std::find(rest + bytes * i / count, last, '\n');
    };
    pool.for_each(count, [&, lines = line_count](size_t i) {
      // Lines differ in length.
      const uint64_t expected = lines / count;
      reader.reserve(slices[i + 1].rows, static_cast<size_t>(expected + expected / 16));
      read_plain_slice(border(i), border(i + 1), most - 1, reader, slices[i + 1]);
    });
  }
  const auto last = std::ranges::find(slices, false, &PlainSlice<Rows>::is_complete);
  if (last != slices.end()) slices.erase(last + 1, slices.end());
  uint64_t line_count = 0;
  for (const PlainSlice<Rows>& slice : slices) line_count += slice.line_count;
  scanner.skip_lines(static_cast<size_t>(slices.back().end - begin), line_count);
  return slices;
}

}  // namespace psplit
