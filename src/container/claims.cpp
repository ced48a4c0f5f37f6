#include "src/container/claims.h"

#include "src/container/condensed_head.h"
#include "src/core/condensed/condensed_header.h"
#include "src/core/workspace.h"

namespace psplit {
namespace {

using core::Fault;

// Names the bitstream of a stream whose header gives Fault::kVersion.
Status wrong_version(std::span<const uint8_t> stream) {
  constexpr size_t kMajor = 5, kMinor = 6;  // after "DRACO"
  const std::pair<uint8_t, uint8_t> version(stream[kMajor], stream[kMinor]);
  return unsupported("Draco stream: of bitstream " + std::to_string(version.first) + "." +
                     std::to_string(version.second) + ", which is " +
                     (version < std::pair<uint8_t, uint8_t>(2, 2) ? "older" : "newer") +
                     " than 2.2, the only one that is decoded");
}

// The header, unless it has a fault or claims more than the stream's bytes justify.
Expected<core::StreamHeader> justified_header(Fault fault, const core::StreamHeader& header,
                                              size_t stream_bytes) {
  const uint64_t elements =
      uint64_t{header.counts.face_count} + header.counts.vertex_limit + header.point_count;
  if (fault == Fault::kNone && elements * 16 > core::justified_bytes(stream_bytes)) fault = Fault::kWorkspace;
  if (fault != Fault::kNone) return status_of(fault);
  return header;
}

Expected<core::StreamHeader> read_condensed_header(const PatchContainer& container, uint32_t patch) {
  const StreamEntry& entry = container.entries[patch];
  const std::vector<uint8_t>& skeleton = container.head->skeletons[entry.skeleton];
  const std::span<const uint8_t> stream = container.streams[patch];
  core::StreamHeader header;
  const Fault fault = core::read_condensed_header(
      {skeleton.data(), skeleton.size()}, {stream.data(), stream.size()}, container.head->models(),
      entry.face_count, entry.point_count, header, header.condensed);
  return justified_header(fault, header, stream.size());
}

}  // namespace

Status status_of(Fault fault) {
  if (fault == Fault::kNone) return {};
  const std::string message =
      (fault < Fault::kRow ? std::string("Draco stream: ") : std::string()) + core::fault_text(fault);
  const bool is_unsupported = fault == Fault::kVersion || fault == Fault::kRequest;
  return is_unsupported ? unsupported(message) : invalid_input(message);
}

Expected<core::StreamHeader> read_stream_header(std::span<const uint8_t> stream) {
  core::StreamHeader header;
  const Fault fault = core::read_stream_header(stream.data(), stream.size(), header);
  if (fault == Fault::kVersion) return wrong_version(stream);
  return justified_header(fault, header, stream.size());
}

Expected<core::StreamHeader> header_of_stream(const PatchContainer& container, uint32_t patch, uint32_t first) {
  const StreamEntry& entry = container.entries[patch];
  Expected<core::StreamHeader> header = core::kReadsCondensed && entry.is_condensed
                                            ? read_condensed_header(container, patch)
                                            : read_stream_header(container.streams[patch]);
  if (!header) return header;
  const bool is_residue = patch >= container.patch_count();
  if (header->edgebreaker == is_residue)
    return invalid_input(is_residue ? "the residue is not a sequential mesh"
                                    : "a patch is not an Edgebreaker mesh");
  const uint32_t faces = header->counts.face_count, claimed = entry.face_count;
  // A sequential stream needs faces to carry points that no face uses. The directory does not count them.
  if (is_residue ? faces < claimed : faces != claimed) return differs_from_directory("faces", faces, claimed);
  if (container.has_borders() && !is_residue) {
    if (!entry.is_condensed) return invalid_input("it is stored, but values at borders are shared");
    const core::StreamHeader& other = patch != first ? container.headers[first] : *header;
    if (header->condensed.border_components != other.condensed.border_components)
      return invalid_input("its shared values have other components than those of patch " +
                           std::to_string(first));
  }
  // The number of points of an Edgebreaker stream is known only after decoding.
  if (is_residue && header->point_count != entry.point_count)
    return differs_from_directory("points", header->point_count, entry.point_count);
  if (!is_residue && entry.point_count > uint64_t{3} * faces)
    return invalid_input("more points than its faces have corners");
  return header;
}

Status check_claims(const PatchContainer& container) {
  if (uint64_t{container.point_count()} + container.reference_count() > 0xffffffffu)
    return unsupported("more points than 32-bit numbers can tell apart");
  uint64_t elements = container.face_count();
  for (const StreamEntry& entry : container.entries) elements += entry.point_count;
  return elements * 16 > core::justified_bytes(container.stream_bytes()) ? status_of(Fault::kWorkspace)
                                                                         : Status();
}

Status check_results(uint64_t point_count, uint64_t face_count, std::span<const AttributeRequest> requests,
                     uint64_t stored_bytes) {
  uint64_t point_bytes = 0;
  for (const AttributeRequest& request : requests) point_bytes += request.value_bytes();
  return check_results(point_count, face_count, point_bytes, stored_bytes);
}

Status check_results(uint64_t point_count, uint64_t face_count, uint64_t point_bytes, uint64_t stored_bytes) {
  const uint64_t most = justified_result_bytes(stored_bytes), face_bytes = 3 * sizeof(uint32_t);
  if (face_count > most / face_bytes ||
      (point_bytes > 0 && point_count > (most - face_count * face_bytes) / point_bytes))
    return status_of(Fault::kWorkspace);
  return {};
}

Status check_request(const AttributeRequest& request, uint32_t components) {
  constexpr uint32_t kMostComponents = 16;
  const std::string name = request.semantic + " (unique id " + std::to_string(request.unique_id) + ")";
  if (components == 0) return invalid_input("Draco stream: no attribute for " + name);
  if (request.component_count == 0 || request.component_count > kMostComponents ||
      components != request.component_count)
    return invalid_input("Draco stream: " + name + " has " + std::to_string(components) + " components, not " +
                         std::to_string(request.component_count));
  return {};
}

uint64_t justified_result_bytes(uint64_t stored_bytes) { return core::justified_bytes(stored_bytes); }

Status differs_from_directory(const char* what, uint32_t stream, uint32_t directory) {
  return invalid_input("the stream has " + std::to_string(stream) + " " + what + ", the directory says " +
                       std::to_string(directory));
}

}  // namespace psplit
