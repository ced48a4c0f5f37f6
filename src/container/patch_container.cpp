#include "src/container/patch_container.h"

#include <algorithm>
#include <array>
#include <utility>

#include "src/container/border_values.h"
#include "src/container/claims.h"
#include "src/container/condensed_head.h"
#include "src/container/directory.h"
#include "src/core/byte_reader.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

constexpr std::array<uint8_t, 4> kMagic = {'P', 'S', 'P', 'L'};
constexpr uint8_t kFlagResidue = 1;
constexpr uint16_t kCodecDraco = 0;
constexpr size_t kHeaderBytes = 20;

// The header, to the lengths of directory and head.
Status read_header(std::span<const uint8_t> bytes, PatchContainer& container, uint32_t& directory_bytes) {
  if (bytes.size() < kHeaderBytes) return invalid_input("container: shorter than its header");
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) return invalid_input("container: wrong magic");
  core::ByteReader reader(bytes.data(), bytes.size());
  reader.skip(kMagic.size());
  const uint32_t version = reader.u8(), flags = reader.u8(), codec = reader.u16(), count = reader.u32();
  directory_bytes = reader.u32();
  container.head_bytes = reader.u32();
  if (version != kContainerVersion)
    return unsupported("container: version " + std::to_string(version) + " is not known");
  if ((flags & ~uint32_t{kFlagResidue}) != 0) return unsupported("container: a flag that is not known");
  if (codec != kCodecDraco)
    return unsupported("container: codec " + std::to_string(codec) +
                       " of its streams is not known; only 0 is, Draco 2.2");
  if (count == 0) return invalid_input("container: no streams");
  const uint64_t rest = bytes.size() - kHeaderBytes;
  if (uint64_t{directory_bytes} + container.head_bytes > rest)
    return invalid_input("container: ends within the directory or the head");
  // The bytes bound the count before anything is allocated.
  if (count * kLeastRowBits > uint64_t{8} * directory_bytes)
    return invalid_input("container: more streams than rows in the directory");
  container.has_residue = (flags & kFlagResidue) != 0;
  container.header_bytes = kHeaderBytes + uint64_t{directory_bytes} + container.head_bytes;
  container.entries.resize(count);
  return {};
}

Status read_rows_and_head(std::span<const uint8_t> bytes, PatchContainer& container, uint32_t directory_bytes) {
  const std::span<const uint8_t> rest = bytes.subspan(kHeaderBytes);
  const Expected<uint32_t> skeleton_count =
      read_directory(rest.first(directory_bytes), container.has_residue, container.entries);
  if (!skeleton_count) return skeleton_count.status();
  Expected<CondensedHead> head = read_condensed_head(rest.subspan(directory_bytes, container.head_bytes));
  if (!head) return head.status();
  if (*skeleton_count > head->skeletons.size())
    return invalid_input("container: the directory counts more skeletons than the head has");
  if (head->skeletons.empty()) return {};
  container.head = std::make_shared<const CondensedHead>(std::move(*head));
  return container.condensed_count() > 0
             ? Status()
             : invalid_input("container: tables of condensed streams, but no condensed stream");
}

Status check_entry(const StreamEntry& entry, bool is_residue) {
  if (entry.stream_bytes == 0) return invalid_input("directory: an empty stream");
  if (entry.face_count == 0 && !is_residue) return invalid_input("directory: a patch without faces");
  if (entry.reference_count > entry.point_count) return invalid_input("directory: more references than points");
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

void append_integer(std::vector<uint8_t>& bytes, size_t value, size_t width) {
  for (size_t i = 0; i < width; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

void append_parts(std::span<const std::vector<uint8_t>> parts, std::vector<uint8_t>& bytes) {
  for (const std::vector<uint8_t>& part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
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

void PatchContainer::place(std::span<const uint8_t> memory) {
  bytes = memory;
  size_t at = header_bytes;
  const auto next = [&](uint32_t count) { return bytes.subspan(std::exchange(at, at + count), count); };
  stitch.reserve(entries.size());
  streams.reserve(entries.size());
  constexpr uint64_t kLeastStreamBytes = 4;  // a section of a condensed stream; Draco streams have more
  headers.reserve(static_cast<size_t>(std::min<uint64_t>(entries.size(), stream_bytes() / kLeastStreamBytes)));
  for (const StreamEntry& entry : entries) stitch.push_back(next(entry.stitch_bytes));
  for (const StreamEntry& entry : entries) streams.push_back(next(entry.stream_bytes));
}

Status PatchContainer::read_headers(uint64_t arrived) {
  for (auto i = static_cast<uint32_t>(headers.size()); i < entries.size(); ++i) {
    const uint8_t* const end = streams[i].data() + streams[i].size();
    if (static_cast<uint64_t>(end - bytes.data()) > arrived) break;
    const Expected<core::StreamHeader> header = header_of_stream(*this, i);
    if (!header) return header.status().at({.patch = i});
    headers.push_back(*header);
  }
  return {};
}

uint32_t PatchContainer::condensed_count() const {
  return static_cast<uint32_t>(std::count_if(entries.begin(), entries.end(),
                                             [](const StreamEntry& entry) { return entry.is_condensed; }));
}

bool PatchContainer::has_borders() const { return head != nullptr && head->has_borders; }

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
          patch,
          entry.point_count,
          entry.reference_count,
          owned_base[patch],
          point_count()};
}

PatchContainer PatchContainer::alone(uint32_t patch) const {
  PatchContainer container = single(streams[patch], entries[patch].face_count, entries[patch].point_count);
  container.entries[0].is_condensed = entries[patch].is_condensed;
  container.entries[0].skeleton = entries[patch].skeleton;
  container.headers = {headers[patch]};
  container.head = head;
  container.borders = borders;
  Expected<BorderValues> decoded = BorderValues::decode(*this, patch);
  container.refusal = decoded.status();
  if (!decoded || decoded->empty()) return container;
  container.borders = std::make_shared<const BorderValues>(std::move(*decoded));
  container.borders->complete(patch, container.headers[0]);
  return container;
}

void PatchContainer::expect_points(uint32_t count) {
  entries[0].point_count = owned_base[1] = count;
  is_point_count_known = true;
}

Expected<PatchContainer> open_container(std::span<const uint8_t> bytes) {
  PatchContainer container;
  if (Status status = open_front(bytes, true, container); !status.ok()) return status;
  container.place(bytes);
  if (Status status = container.read_headers(bytes.size()); !status.ok()) return status;
  if (Status status = check_claims(container); !status.ok()) return status;
  return container;
}

Status open_front(std::span<const uint8_t> bytes, bool is_whole, PatchContainer& container) {
  uint32_t directory_bytes = 0;
  Status status = read_header(bytes, container, directory_bytes);
  if (status.ok()) status = read_rows_and_head(bytes, container, directory_bytes);
  if (status.ok()) status = sum_entries(container);
  if (status.ok() && is_whole && bytes.size() != container.total_bytes())
    status = invalid_input("container: its length is not the sum of its parts");
  return status;
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
  return open_front(bytes, true, container);
}

std::vector<uint8_t> write_container(std::span<const StreamEntry> entries, bool has_residue,
                                     std::span<const std::vector<uint8_t>> stitch,
                                     std::span<const std::vector<uint8_t>> streams,
                                     std::span<const uint8_t> head) {
  const std::vector<uint8_t> directory = write_directory(entries, has_residue);
  std::vector<uint8_t> bytes(kMagic.begin(), kMagic.end());
  append_integer(bytes, kContainerVersion, 1);
  append_integer(bytes, has_residue ? kFlagResidue : 0, 1);
  append_integer(bytes, kCodecDraco, 2);
  for (const size_t number : {entries.size(), directory.size(), head.size()}) append_integer(bytes, number, 4);
  bytes.insert(bytes.end(), directory.begin(), directory.end());
  bytes.insert(bytes.end(), head.begin(), head.end());
  append_parts(stitch, bytes);
  append_parts(streams, bytes);
  return bytes;
}

std::vector<uint8_t> with_head_section(const PatchContainer& container, HeadSection type,
                                       std::span<const uint8_t> section) {
  constexpr size_t kHeadBytesAt = kHeaderBytes - sizeof(uint32_t);
  std::vector<uint8_t> added, length;
  append_head_section(type, section, added);
  append_integer(length, container.head_bytes + added.size(), sizeof(uint32_t));
  std::vector<uint8_t> bytes(container.bytes.begin(), container.bytes.end());
  std::copy(length.begin(), length.end(), bytes.begin() + kHeadBytesAt);
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(container.header_bytes), added.begin(), added.end());
  return bytes;
}

}  // namespace psplit
