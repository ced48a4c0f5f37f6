#include "src/container/column_directory.h"

#include <algorithm>
#include <array>

#include "src/container/little_endian.h"

namespace psplit {
namespace {

constexpr std::array<uint32_t StreamEntry::*, 5> kColumns = {
    &StreamEntry::stream_bytes, &StreamEntry::face_count, &StreamEntry::point_count,
    &StreamEntry::reference_count, &StreamEntry::stitch_bytes};
constexpr size_t kDescriptorBytes = kColumnDescriptorBytes / kColumns.size();

size_t align4(size_t value) { return (value + 3) & ~size_t{3}; }

uint8_t width_of(uint32_t value) { return value == 0 ? 0 : value < 0x100 ? 1 : value < 0x10000 ? 2 : 4; }

}  // namespace

Expected<size_t> read_column_directory(std::span<const uint8_t> bytes, std::span<StreamEntry> entries) {
  if (bytes.size() < kColumnDescriptorBytes) return invalid_input("container: shorter than its header");
  const size_t count = entries.size();
  size_t at = kColumnDescriptorBytes;
  for (size_t column = 0; column < kColumns.size(); ++column) {
    const uint8_t* descriptor = &bytes[column * kDescriptorBytes];
    const uint32_t base = load_integer(descriptor, 4);
    const size_t width = descriptor[4];
    if ((width != 0 && width != 1 && width != 2 && width != 4) || load_integer(descriptor + 5, 3) != 0)
      return invalid_input("container: a directory column has an impossible width");
    if (bytes.size() - at < align4(count * width)) return invalid_input("container: ends within the directory");
    for (size_t i = 0; i < count; ++i) {
      const uint32_t offset = load_integer(bytes.data() + at + i * width, width);
      if (offset > 0xffffffffu - base) return invalid_input("container: a directory value overflows");
      entries[i].*kColumns[column] = base + offset;
    }
    const auto padding = bytes.subspan(at + count * width, align4(count * width) - count * width);
    if (std::any_of(padding.begin(), padding.end(), [](uint8_t byte) { return byte != 0; }))
      return invalid_input("container: padding of the directory is not zero");
    at += align4(count * width);
  }
  return at;
}

void append_column_directory(std::span<const StreamEntry> entries, std::vector<uint8_t>& bytes) {
  std::array<uint32_t, kColumns.size()> bases{};
  std::array<uint8_t, kColumns.size()> widths{};
  for (size_t column = 0; column < kColumns.size(); ++column) {
    uint32_t low = 0xffffffffu, high = 0;
    for (const StreamEntry& entry : entries) {
      low = std::min(low, entry.*kColumns[column]);
      high = std::max(high, entry.*kColumns[column]);
    }
    bases[column] = low;
    widths[column] = width_of(high - low);
    append_integer(bytes, low, 4);
    append_integer(bytes, widths[column], 4);  // width and three zero bytes
  }
  for (size_t column = 0; column < kColumns.size(); ++column) {
    for (const StreamEntry& entry : entries)
      append_integer(bytes, entry.*kColumns[column] - bases[column], widths[column]);
    bytes.resize(align4(bytes.size()));
  }
}

}  // namespace psplit
