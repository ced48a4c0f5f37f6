#include "src/container/container.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace psplit {
namespace {

constexpr std::array<uint8_t, 4> kMagic = {'P', 'S', 'P', 'L'};
constexpr uint8_t kFlagResidue = 1;
constexpr size_t kFixedHeaderBytes = 12;
constexpr size_t kColumnDescriptorBytes = 8;

constexpr std::array<uint32_t StreamEntry::*, 5> kColumns = {
    &StreamEntry::stream_bytes, &StreamEntry::face_count, &StreamEntry::point_count,
    &StreamEntry::reference_count, &StreamEntry::stitch_bytes};
constexpr size_t kHeaderBytes = kFixedHeaderBytes + kColumns.size() * kColumnDescriptorBytes;

size_t align4(size_t value) { return (value + 3) & ~size_t{3}; }

uint32_t load(const uint8_t* at, size_t width) {
  uint32_t value = 0;
  for (size_t i = 0; i < width; ++i) value |= static_cast<uint32_t>(at[i]) << (8 * i);
  return value;
}

void append(std::vector<uint8_t>& bytes, uint32_t value, size_t width) {
  for (size_t i = 0; i < width; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

uint8_t width_of(uint32_t value) { return value == 0 ? 0 : value < 0x100 ? 1 : value < 0x10000 ? 2 : 4; }

}  // namespace

uint64_t Container::stitch_bytes() const {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.stitch_bytes;
  return sum;
}

uint64_t Container::stream_bytes() const {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.stream_bytes;
  return sum;
}

uint64_t Container::reference_count() const {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.reference_count;
  return sum;
}

Expected<Container> parse_container(std::span<const uint8_t> bytes) {
  if (bytes.size() < kHeaderBytes) return invalid_input("container: shorter than its header");
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) return invalid_input("container: wrong magic");
  if (bytes[4] == 0 || bytes[4] > kContainerVersion)
    return unsupported("container: version " + std::to_string(bytes[4]) + " is not known");
  if ((bytes[5] & ~kFlagResidue) != 0) return invalid_input("container: unknown flags");
  if (load(&bytes[6], 2) != 0) return invalid_input("container: reserved bytes are not zero");

  Container container;
  container.version = bytes[4];
  container.has_residue = (bytes[5] & kFlagResidue) != 0;
  const uint32_t count = load(&bytes[8], 4);
  // A Draco stream is never empty, so the bytes bound the count before anything is allocated.
  if (count == 0) return invalid_input("container: no streams");
  if (count > bytes.size() - kHeaderBytes) return invalid_input("container: more streams than bytes");
  container.entries.resize(count);

  size_t at = kHeaderBytes;
  for (size_t column = 0; column < kColumns.size(); ++column) {
    const uint8_t* descriptor = &bytes[kFixedHeaderBytes + column * kColumnDescriptorBytes];
    const uint32_t base = load(descriptor, 4);
    const size_t width = descriptor[4];
    if ((width != 0 && width != 1 && width != 2 && width != 4) || load(descriptor + 5, 3) != 0)
      return invalid_input("container: a directory column has an impossible width");
    if (bytes.size() - at < align4(count * width)) return invalid_input("container: ends within the directory");
    for (size_t i = 0; i < count; ++i) {
      const uint32_t offset = load(bytes.data() + at + i * width, width);
      if (offset > 0xffffffffu - base) return invalid_input("container: a directory value overflows");
      container.entries[i].*kColumns[column] = base + offset;
    }
    const auto padding = bytes.subspan(at + count * width, align4(count * width) - count * width);
    if (std::any_of(padding.begin(), padding.end(), [](uint8_t byte) { return byte != 0; }))
      return invalid_input("container: padding of the directory is not zero");
    at += align4(count * width);
  }
  container.header_bytes = at;

  uint64_t points = 0, faces = 0;
  container.owned_base.reserve(count + 1);
  container.face_base.reserve(count + 1);
  for (uint32_t i = 0; i < count; ++i) {
    const StreamEntry& entry = container.entries[i];
    const Place place{.patch = i};
    if (entry.stream_bytes == 0) return invalid_input("directory: an empty stream", place);
    const bool is_residue = container.has_residue && i + 1 == count;
    if (entry.face_count == 0 && !is_residue) return invalid_input("directory: a patch without faces", place);
    if (entry.reference_count > entry.point_count)
      return invalid_input("directory: more references than points", place);
    if (entry.reference_count == 0 && entry.stitch_bytes > 0)
      return invalid_input("directory: a stitch map without references", place);
    if (!is_residue && entry.point_count > uint64_t{entry.face_count} * 3)
      return invalid_input("directory: more points than corners", place);
    container.owned_base.push_back(static_cast<uint32_t>(points));
    container.face_base.push_back(static_cast<uint32_t>(faces));
    points += entry.point_count - entry.reference_count;
    faces += entry.face_count;
    // glTF's own limits: indices of 32 bits, the largest of them the restart value.
    if (points > 0xfffffffeu || faces > 0xffffffffu / 3)
      return invalid_input("directory: more points or faces than glTF can index", place);
  }
  container.owned_base.push_back(static_cast<uint32_t>(points));
  container.face_base.push_back(static_cast<uint32_t>(faces));

  if (bytes.size() - at != container.stitch_bytes() + container.stream_bytes())
    return invalid_input("container: its length is not the sum of its parts");
  container.stitch.reserve(count);
  container.streams.reserve(count);
  for (const StreamEntry& entry : container.entries) {
    container.stitch.push_back(bytes.subspan(at, entry.stitch_bytes));
    at += entry.stitch_bytes;
  }
  for (const StreamEntry& entry : container.entries) {
    container.streams.push_back(bytes.subspan(at, entry.stream_bytes));
    at += entry.stream_bytes;
  }
  return container;
}

std::vector<uint8_t> write_container(std::span<const StreamEntry> entries, bool has_residue,
                                     std::span<const std::vector<uint8_t>> stitch,
                                     std::span<const std::vector<uint8_t>> streams) {
  std::vector<uint8_t> bytes(kMagic.begin(), kMagic.end());
  bytes.push_back(kContainerVersion);
  bytes.push_back(has_residue ? kFlagResidue : 0);
  append(bytes, 0, 2);
  append(bytes, static_cast<uint32_t>(entries.size()), 4);

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
    append(bytes, low, 4);
    append(bytes, widths[column], 4);  // width and three zero bytes
  }
  for (size_t column = 0; column < kColumns.size(); ++column) {
    for (const StreamEntry& entry : entries)
      append(bytes, entry.*kColumns[column] - bases[column], widths[column]);
    bytes.resize(align4(bytes.size()));
  }
  for (const std::vector<uint8_t>& part : stitch) bytes.insert(bytes.end(), part.begin(), part.end());
  for (const std::vector<uint8_t>& part : streams) bytes.insert(bytes.end(), part.begin(), part.end());
  return bytes;
}

}  // namespace psplit
