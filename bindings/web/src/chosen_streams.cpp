#include "bindings/web/src/chosen_streams.h"

#include "src/container/claims.h"

namespace psplit::web {

void ChosenStreams::choose(std::vector<uint32_t> patches, std::unique_ptr<uint8_t[]> stitch_map,
                           PatchContainer& container) {
  patches_ = std::move(patches);
  stitch_map_ = std::move(stitch_map);
  const uint8_t* at = stitch_map_.get();
  for (const StreamEntry& entry : whole.entries) {
    const size_t bytes = at != nullptr ? entry.stitch_bytes : 0;
    whole.stitch.push_back({at, bytes});
    whole.streams.push_back({});
    at += bytes;
  }
  whole.headers.resize(whole.entries.size());
  // Its values at borders are decoded here.
  container.is_stock = true;
  container.head = whole.head;
  container.header_bytes = whole.header_bytes;
  container.entries.resize(patches_.size());
  container.owned_base.push_back(0);
  container.face_base.push_back(0);
  std::vector<uint32_t> needs, is_needed(whole.entries.size());
  for (size_t i = 0; i < patches_.size(); ++i) {
    StreamEntry& entry = container.entries[i];
    entry = whole.entries[patches_[i]];
    entry.reference_count = entry.stitch_bytes = 0;
    container.owned_base.push_back(container.owned_base[i] + entry.point_count);
    container.face_base.push_back(container.face_base[i] + entry.face_count);
    container.stitch.push_back({});
    needs.clear();
    if (at != nullptr) BorderValues::append_owners(whole, patches_[i], needs);
    needs.push_back(patches_[i]);
    for (const uint32_t stream : needs) {
      if (is_needed[stream] == 0) needed_.push_back(stream);
      is_needed[stream] = 1;
    }
    waits_for_.push_back(static_cast<uint32_t>(needed_.size()));
  }
}

uint64_t ChosenStreams::needed_bytes() const {
  uint64_t sum = 0;
  for (const uint32_t stream : needed_) sum += whole.entries[stream].stream_bytes;
  return sum;
}

void ChosenStreams::place(std::span<const uint8_t> memory) {
  whole.bytes = memory;
  const uint8_t* at = memory.data();
  for (const uint32_t stream : needed_) {
    whole.streams[stream] = {at, whole.entries[stream].stream_bytes};
    at += whole.entries[stream].stream_bytes;
  }
}

Status ChosenStreams::arrive(size_t arrived, PatchContainer& container) {
  for (; arrived_count_ < needed_.size(); ++arrived_count_) {
    const uint32_t stream = needed_[arrived_count_];
    const std::span<const uint8_t> bytes = whole.streams[stream];
    if (bytes.data() + bytes.size() > whole.bytes.data() + arrived) break;
    const Expected<core::StreamHeader> header = header_of_stream(whole, stream, needed_[0]);
    if (!header) return header.status().at({.patch = stream});
    whole.headers[stream] = *header;
  }
  const size_t first = container.headers.size();
  size_t end = first;
  while (end < patches_.size() && waits_for_[end] <= arrived_count_) ++end;
  const std::span<const uint32_t> added(patches_.data() + first, end - first);
  if (added.empty()) return {};
  Expected<BorderValues> borders = BorderValues::decode(whole, added);
  if (!borders) return borders.status();
  borders_ = std::move(*borders);
  for (const uint32_t patch : added) {
    container.streams.push_back(whole.streams[patch]);
    container.headers.push_back(whole.headers[patch]);
    borders_.complete(patch, container.headers.back());
  }
  return {};
}

Status ChosenStreams::in_whole(const Status& status) const {
  if (status.place().patch < 0) return status;
  return {status.code(), status.message(), {.patch = patches_[static_cast<size_t>(status.place().patch)]}};
}

}  // namespace psplit::web
