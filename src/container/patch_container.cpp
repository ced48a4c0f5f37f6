#include "src/container/patch_container.h"

#include <algorithm>
#include <array>
#include <utility>

#include "src/container/claims.h"
#include "src/core/workspace.h"

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

// The fixed part of the header, to version, residue flag and stream count.
Status read_fixed_header(std::span<const uint8_t> bytes, PatchContainer& container) {
  if (bytes.size() < kHeaderBytes) return invalid_input("container: shorter than its header");
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) return invalid_input("container: wrong magic");
  if (bytes[4] == 0 || bytes[4] > kContainerVersion)
    return unsupported("container: version " + std::to_string(bytes[4]) + " is not known");
  if ((bytes[5] & ~kFlagResidue) != 0) return invalid_input("container: unknown flags");
  if (load(&bytes[6], 2) != 0) return invalid_input("container: reserved bytes are not zero");
  const uint32_t count = load(&bytes[8], 4);
  // A Draco stream is never empty, so the bytes bound the count before anything is allocated.
  if (count == 0) return invalid_input("container: no streams");
  if (count > bytes.size() - kHeaderBytes) return invalid_input("container: more streams than bytes");
  container.bytes = bytes;
  container.version = bytes[4];
  container.has_residue = (bytes[5] & kFlagResidue) != 0;
  container.entries.resize(count);
  return {};
}

Status read_columns(PatchContainer& container) {
  const std::span<const uint8_t> bytes = container.bytes;
  const size_t count = container.entries.size();
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
  return {};
}

Status check_entry(const StreamEntry& entry, bool is_residue) {
  if (entry.stream_bytes == 0) return invalid_input("directory: an empty stream");
  if (entry.face_count == 0 && !is_residue) return invalid_input("directory: a patch without faces");
  if (entry.reference_count > entry.point_count) return invalid_input("directory: more references than points");
  if (entry.reference_count == 0 && entry.stitch_bytes > 0)
    return invalid_input("directory: a stitch map without references");
  if (!is_residue && entry.point_count > uint64_t{entry.face_count} * 3)
    return invalid_input("directory: more points than corners");
  return {};
}

// Checks the rows, and numbers what each of them owns.
Status sum_entries(PatchContainer& container) {
  const size_t count = container.entries.size();
  uint64_t points = 0, faces = 0;
  container.owned_base.reserve(count + 1);
  container.face_base.reserve(count + 1);
  for (uint32_t i = 0; i < count; ++i) {
    const StreamEntry& entry = container.entries[i];
    if (Status status = check_entry(entry, i >= container.patch_count()); !status.ok())
      return std::move(status).at({.patch = i});
    container.owned_base.push_back(static_cast<uint32_t>(points));
    container.face_base.push_back(static_cast<uint32_t>(faces));
    points += entry.point_count - entry.reference_count;
    faces += entry.face_count;
    // glTF's own limits: indices have 32 bits, and the largest of them is the restart value.
    if (points > 0xfffffffeu || faces > 0xffffffffu / 3)
      return invalid_input("directory: more points or faces than glTF can index", {.patch = i});
  }
  container.owned_base.push_back(static_cast<uint32_t>(points));
  container.face_base.push_back(static_cast<uint32_t>(faces));
  return {};
}

Status read_directory(std::span<const uint8_t> bytes, PatchContainer& container) {
  Status status = read_fixed_header(bytes, container);
  if (status.ok()) status = read_columns(container);
  if (status.ok()) status = sum_entries(container);
  if (status.ok() &&
      bytes.size() - container.header_bytes != container.stitch_bytes() + container.stream_bytes())
    status = invalid_input("container: its length is not the sum of its parts");
  return status;
}

void slice(PatchContainer& container) {
  size_t at = container.header_bytes;
  const auto next = [&](uint32_t bytes) {
    return container.bytes.subspan(std::exchange(at, at + bytes), bytes);
  };
  container.stitch.reserve(container.entries.size());
  container.streams.reserve(container.entries.size());
  for (const StreamEntry& entry : container.entries) container.stitch.push_back(next(entry.stitch_bytes));
  for (const StreamEntry& entry : container.entries) container.streams.push_back(next(entry.stream_bytes));
}

Expected<core::StreamHeader> read_header(const PatchContainer& container, uint32_t patch) {
  Expected<core::StreamHeader> header = read_stream_header(container.streams[patch]);
  if (!header) return header;
  const StreamEntry& entry = container.entries[patch];
  const bool is_residue = patch >= container.patch_count();
  if (header->edgebreaker == is_residue)
    return invalid_input(is_residue ? "the residue is not a sequential mesh"
                                    : "a patch is not an Edgebreaker mesh");
  const uint32_t faces = header->counts.face_count, claimed = entry.face_count;
  // A sequential stream needs faces to carry points that no face uses. The directory does not count them.
  if (is_residue ? faces < claimed : faces != claimed) return differs_from_directory("faces", faces, claimed);
  // The number of points of an Edgebreaker stream is known only after decoding.
  if (is_residue && header->point_count != entry.point_count)
    return differs_from_directory("points", header->point_count, entry.point_count);
  if (!is_residue && entry.point_count > uint64_t{3} * faces)
    return invalid_input("more points than its faces have corners");
  return header;
}

// A container of one patch that has no stitch map.
PatchContainer single(std::span<const uint8_t> stream, uint32_t face_count, uint32_t point_count) {
  PatchContainer container;
  container.bytes = stream;
  container.is_stock = true;
  container.entries = {{static_cast<uint32_t>(stream.size()), face_count, point_count, 0, 0}};
  container.stitch = {{}};
  container.streams = {stream};
  container.owned_base = {0, point_count};
  container.face_base = {0, face_count};
  return container;
}

}  // namespace

uint64_t PatchContainer::stitch_bytes() const {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.stitch_bytes;
  return sum;
}

uint64_t PatchContainer::stream_bytes() const {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.stream_bytes;
  return sum;
}

uint64_t PatchContainer::reference_count() const {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.reference_count;
  return sum;
}

uint32_t PatchContainer::likely_point_count(uint32_t patch) const {
  const uint32_t stated = entries[patch].point_count;
  return is_point_count_known ? stated : std::min(stated, core::likely_points(headers[patch]));
}

core::StitchRow PatchContainer::stitch_row(uint32_t patch) const {
  const StreamEntry& entry = entries[patch];
  return {{stitch[patch].data(), stitch[patch].size()},
          version,
          patch,
          entry.point_count,
          entry.reference_count,
          owned_base[patch],
          point_count()};
}

PatchContainer PatchContainer::alone(uint32_t patch) const {
  PatchContainer container = single(streams[patch], entries[patch].face_count, entries[patch].point_count);
  container.headers = {headers[patch]};
  return container;
}

void PatchContainer::expect_points(uint32_t count) {
  entries[0].point_count = owned_base[1] = count;
  is_point_count_known = true;
}

Expected<PatchContainer> open_container(std::span<const uint8_t> bytes) {
  PatchContainer container;
  if (Status status = read_directory(bytes, container); !status.ok()) return status;
  slice(container);
  container.headers.reserve(container.entries.size());
  for (uint32_t i = 0; i < container.entries.size(); ++i) {
    const Expected<core::StreamHeader> header = read_header(container, i);
    if (!header) return header.status().at({.patch = i});
    container.headers.push_back(*header);
  }
  if (Status status = check_claims(container); !status.ok()) return status;
  return container;
}

PatchContainer open_stream(std::span<const uint8_t> bytes, uint32_t most_points) {
  const Expected<core::StreamHeader> header = read_stream_header(bytes);
  Status refusal = header.status();
  if (refusal.ok() && bytes.size() > 0xffffffffu) refusal = unsupported("Draco stream: of more than 4 GiB");
  if (refusal.ok() && !header->edgebreaker && header->point_count > most_points)
    refusal = differs_from_directory("points", header->point_count, most_points);
  PatchContainer container = single(bytes, 0, 0);
  container.refusal = std::move(refusal);
  if (!container.refusal.ok()) return container;
  const uint64_t points = std::min<uint64_t>(core::most_points(*header), most_points);
  container = single(bytes, header->counts.face_count, static_cast<uint32_t>(points));
  container.headers = {*header};
  container.is_point_count_known = !header->edgebreaker;
  return container;
}

Status check_directory(std::span<const uint8_t> bytes) {
  PatchContainer container;
  return read_directory(bytes, container);
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
