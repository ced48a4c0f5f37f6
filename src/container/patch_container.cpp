#include "src/container/patch_container.h"

#include <algorithm>
#include <array>
#include <utility>

#include "src/container/border_values.h"
#include "src/container/claims.h"
#include "src/container/column_directory.h"
#include "src/container/condensed_directory.h"
#include "src/container/condensed_head.h"
#include "src/container/little_endian.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

constexpr std::array<uint8_t, 4> kMagic = {'P', 'S', 'P', 'L'};
constexpr uint8_t kFlagResidue = 1;
constexpr size_t kFixedHeaderBytes = 12;
constexpr size_t kCondensedHeaderBytes = kFixedHeaderBytes + 8;

// The fixed part of the header, to version, residue flag and stream count.
Status read_fixed_header(std::span<const uint8_t> bytes, PatchContainer& container) {
  if (bytes.size() < kCondensedHeaderBytes) return invalid_input("container: shorter than its header");
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) return invalid_input("container: wrong magic");
  if (bytes[4] == 0 || bytes[4] > kCondensedContainerVersion)
    return unsupported("container: version " + std::to_string(bytes[4]) + " is not known");
  if ((bytes[5] & ~kFlagResidue) != 0) return invalid_input("container: unknown flags");
  if (load_integer(&bytes[6], 2) != 0) return invalid_input("container: reserved bytes are not zero");
  const uint32_t count = load_integer(&bytes[8], 4);
  // A stream is never empty, so the bytes bound the count before anything is allocated.
  if (count == 0) return invalid_input("container: no streams");
  if (count > bytes.size() - kCondensedHeaderBytes) return invalid_input("container: more streams than bytes");
  container.bytes = bytes;
  container.version = bytes[4];
  container.has_residue = (bytes[5] & kFlagResidue) != 0;
  container.entries.resize(count);
  return {};
}

// Versions 1 and 2.
Status read_columns(PatchContainer& container) {
  const Expected<size_t> read =
      read_column_directory(container.bytes.subspan(kFixedHeaderBytes), container.entries);
  if (!read) return read.status();
  container.header_bytes = kFixedHeaderBytes + *read;
  return {};
}

// Version 3. The rows name skeletons, so the head is read first.
Status read_head_and_rows(PatchContainer& container) {
  const std::span<const uint8_t> rest = container.bytes.subspan(kCondensedHeaderBytes);
  const uint32_t directory_bytes = load_integer(&container.bytes[kFixedHeaderBytes], 4);
  container.head_bytes = load_integer(&container.bytes[kFixedHeaderBytes + 4], 4);
  if (directory_bytes > rest.size() || container.head_bytes > rest.size() - directory_bytes)
    return invalid_input("container: ends within the directory or the head");
  if (container.entries.size() * kLeastRowBits > uint64_t{8} * directory_bytes)
    return invalid_input("container: more streams than rows in the directory");
  container.header_bytes = kCondensedHeaderBytes + directory_bytes + container.head_bytes;
  if (container.head_bytes > 0) {
    Expected<CondensedHead> head = read_condensed_head(rest.subspan(directory_bytes, container.head_bytes));
    if (!head) return head.status();
    container.head = std::make_shared<const CondensedHead>(std::move(*head));
  }
  const auto skeleton_count = static_cast<uint32_t>(container.head ? container.head->skeletons.size() : 0);
  Status status = read_condensed_directory(rest.first(directory_bytes), skeleton_count, container.entries);
  if (status.ok() && container.head && container.condensed_count() == 0)
    status = invalid_input("container: a head, but no condensed stream");
  return status;
}

Status check_entry(const StreamEntry& entry, bool is_residue) {
  if (entry.stream_bytes == 0) return invalid_input("directory: an empty stream");
  if (entry.is_condensed && is_residue) return invalid_input("directory: the residue is condensed");
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
  if (status.ok()) {
    const bool has_head = container.version == kCondensedContainerVersion;
    status = has_head ? read_head_and_rows(container) : read_columns(container);
  }
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
  const StreamEntry& entry = container.entries[patch];
  Expected<core::StreamHeader> header = entry.is_condensed ? read_condensed_header(container, patch)
                                                           : read_stream_header(container.streams[patch]);
  if (!header) return header;
  const bool is_residue = patch >= container.patch_count();
  if (header->edgebreaker == is_residue)
    return invalid_input(is_residue ? "the residue is not a sequential mesh"
                                    : "a patch is not an Edgebreaker mesh");
  const uint32_t faces = header->counts.face_count, claimed = entry.face_count;
  // A sequential stream needs faces to carry points that no face uses. The directory does not count them.
  if (is_residue ? faces < claimed : faces != claimed) return differs_from_directory("faces", faces, claimed);
  if (container.head && container.head->has_borders && !is_residue) {
    if (!entry.is_condensed) return invalid_input("it is stored, but values at borders are shared");
    const core::StreamHeader& first = patch > 0 ? container.headers[0] : *header;
    if (header->condensed.border_components != first.condensed.border_components)
      return invalid_input("its shared values have other components than those of patch 0");
  }
  // The number of points of an Edgebreaker stream is known only after decoding.
  if (is_residue && header->point_count != entry.point_count)
    return differs_from_directory("points", header->point_count, entry.point_count);
  if (!is_residue && entry.point_count > uint64_t{3} * faces)
    return invalid_input("more points than its faces have corners");
  return header;
}

std::vector<uint8_t> fixed_header(uint8_t version, bool has_residue, size_t stream_count) {
  std::vector<uint8_t> bytes(kMagic.begin(), kMagic.end());
  bytes.push_back(version);
  bytes.push_back(has_residue ? kFlagResidue : 0);
  append_integer(bytes, 0, 2);
  append_integer(bytes, static_cast<uint32_t>(stream_count), 4);
  return bytes;
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

uint32_t PatchContainer::condensed_count() const {
  return static_cast<uint32_t>(std::count_if(entries.begin(), entries.end(),
                                             [](const StreamEntry& entry) { return entry.is_condensed; }));
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
  if (Status status = read_directory(bytes, container); !status.ok()) return status;
  slice(container);
  constexpr uint64_t kLeastStreamBytes = 4;  // a section of a condensed stream; Draco streams have more
  container.headers.reserve(
      std::min<uint64_t>(container.entries.size(), container.stream_bytes() / kLeastStreamBytes));
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
  std::vector<uint8_t> bytes = fixed_header(kContainerVersion, has_residue, entries.size());
  append_column_directory(entries, bytes);
  append_parts(stitch, bytes);
  append_parts(streams, bytes);
  return bytes;
}

std::optional<std::vector<uint8_t>> write_condensed_container(std::span<const StreamEntry> entries,
                                                              bool has_residue, std::span<const uint8_t> head,
                                                              std::span<const std::vector<uint8_t>> stitch,
                                                              std::span<const std::vector<uint8_t>> streams) {
  const auto directory = write_condensed_directory(entries, count_skeletons(head));
  if (!directory) return std::nullopt;
  std::vector<uint8_t> bytes = fixed_header(kCondensedContainerVersion, has_residue, entries.size());
  append_integer(bytes, static_cast<uint32_t>(directory->size()), 4);
  append_integer(bytes, static_cast<uint32_t>(head.size()), 4);
  bytes.insert(bytes.end(), directory->begin(), directory->end());
  bytes.insert(bytes.end(), head.begin(), head.end());
  append_parts(stitch, bytes);
  append_parts(streams, bytes);
  return bytes;
}

}  // namespace psplit
