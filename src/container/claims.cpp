#include "src/container/claims.h"

#include <algorithm>

#include "src/core/workspace.h"

namespace psplit {

using core::Fault;

Status status_of(Fault fault) {
  if (fault == Fault::kNone) return {};
  const std::string message =
      (fault < Fault::kRow ? std::string("Draco stream: ") : std::string()) + core::fault_text(fault);
  const bool is_unsupported = fault == Fault::kVersion || fault == Fault::kRequest;
  return is_unsupported ? unsupported(message) : invalid_input(message);
}

Status wrong_version(std::span<const uint8_t> stream) {
  constexpr size_t kMajor = 5, kMinor = 6;  // behind "DRACO"
  const std::pair<uint8_t, uint8_t> version(stream[kMajor], stream[kMinor]);
  return unsupported("Draco stream: of bitstream " + std::to_string(version.first) + "." +
                     std::to_string(version.second) + ", which is " +
                     (version < std::pair<uint8_t, uint8_t>(2, 2) ? "older" : "newer") +
                     " than 2.2, the only one that is decoded");
}

Expected<core::StreamHeader> read_stream_header(std::span<const uint8_t> stream) {
  core::StreamHeader header;
  const Fault fault = core::read_stream_header(stream.data(), stream.size(), header);
  if (fault == Fault::kVersion) return wrong_version(stream);
  if (fault != Fault::kNone) return status_of(fault);
  const uint64_t elements =
      uint64_t{header.counts.face_count} + header.counts.vertex_limit + header.point_count;
  if (elements * 16 > core::justified_bytes(stream.size())) return status_of(Fault::kWorkspace);
  return header;
}

Status differs_from_directory(const char* what, uint32_t stream, uint32_t directory) {
  return invalid_input("the stream has " + std::to_string(stream) + " " + what + ", the directory says " +
                       std::to_string(directory));
}

Status wrong_coding(bool is_residue) {
  return invalid_input(is_residue ? "the residue is no sequential mesh" : "a patch is no Edgebreaker mesh");
}

Expected<Container> container_of_stream(std::span<const uint8_t> stream, uint32_t room) {
  const Expected<core::StreamHeader> header = read_stream_header(stream);
  if (!header) return header.status();
  if (stream.size() > 0xffffffffu) return unsupported("Draco stream: of more than 4 GiB");
  const auto point_count = static_cast<uint32_t>(std::min<uint64_t>(core::most_points(*header), room));
  Container container;
  container.is_stock = true;
  container.entries = {{static_cast<uint32_t>(stream.size()), header->counts.face_count, point_count, 0, 0}};
  container.stitch = {{}};
  container.streams = {stream};
  container.owned_base = {0, point_count};
  container.face_base = {0, header->counts.face_count};
  return container;
}

Expected<std::vector<core::StreamHeader>> check_claims(const Container& container) {
  std::vector<core::StreamHeader> headers;
  headers.reserve(container.entries.size());
  uint64_t elements = container.face_count();
  for (uint32_t i = 0; i < container.entries.size(); ++i) {
    const Expected<core::StreamHeader> header = read_stream_header(container.streams[i]);
    if (!header) return header.status().at({.patch = i});
    const StreamEntry& entry = container.entries[i];
    const bool is_residue = i >= container.patch_count();
    if (!container.is_stock && header->edgebreaker == is_residue)
      return wrong_coding(is_residue).at({.patch = i});
    const uint32_t faces = header->counts.face_count, claimed = entry.face_count;
    // A sequential stream needs faces to carry points that no face uses; the directory does not count them.
    if (is_residue ? faces < claimed : faces != claimed)
      return differs_from_directory("faces", faces, claimed).at({.patch = i});
    // Of other streams the number of points shows when they are decoded.
    if (!header->edgebreaker && header->point_count != entry.point_count)
      return differs_from_directory("points", header->point_count, entry.point_count).at({.patch = i});
    if (entry.point_count > uint64_t{3} * faces && header->edgebreaker)
      return invalid_input("more points than its faces have corners", {.patch = i});
    elements += entry.point_count;
    headers.push_back(*header);
  }
  if (uint64_t{container.point_count()} + container.reference_count() > 0xffffffffu)
    return unsupported("more points than 32-bit numbers can tell apart");
  if (elements * 16 > core::justified_bytes(container.stream_bytes())) return status_of(Fault::kWorkspace);
  return headers;
}

uint64_t justified_result_bytes(uint64_t stream_bytes) { return core::justified_bytes(stream_bytes); }

Status check_results(uint64_t point_count, uint64_t face_count, std::span<const AttributeRequest> requests,
                     uint64_t stream_bytes) {
  uint64_t point_bytes = 0;
  for (const AttributeRequest& request : requests)
    point_bytes += component_bytes(request.component_type) * request.component_count;
  const uint64_t most = justified_result_bytes(stream_bytes), face_bytes = 3 * sizeof(uint32_t);
  if (face_count > most / face_bytes ||
      (point_bytes > 0 && point_count > (most - face_count * face_bytes) / point_bytes))
    return status_of(Fault::kWorkspace);
  return {};
}

}  // namespace psplit
