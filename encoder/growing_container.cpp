#include "encoder/growing_container.h"

#include <algorithm>
#include <utility>

#include "src/container/claims.h"
#include "src/core/in_step.h"

namespace psplit {
namespace {

// Several runs of bytes, one after the other.
class JoinedBytes : public StoredBytes {
 public:
  JoinedBytes(std::vector<uint8_t> head, std::unique_ptr<StoredBytes> maps,
              std::unique_ptr<StoredBytes> streams)
      : head_(std::move(head)), maps_(std::move(maps)), streams_(std::move(streams)) {}

  uint64_t size() const override { return head_.size() + maps_->size() + streams_->size(); }

  Status read(uint64_t offset, Span<uint8_t> to) override {
    if (offset < head_.size()) {
      const auto from = std::span(head_).subspan(static_cast<size_t>(offset));
      const size_t count = std::min(from.size(), to.size());
      std::copy_n(from.begin(), count, to.begin());
      offset += count;
      to = to.subspan(count);
    }
    uint64_t begin = head_.size();
    for (StoredBytes* piece : {maps_.get(), streams_.get()}) {
      const uint64_t end = begin + piece->size();
      if (!to.empty() && offset < end) {
        const auto count = static_cast<size_t>(std::min<uint64_t>(to.size(), end - offset));
        if (Status status = piece->read(offset - begin, to.first(count)); !status.ok()) return status;
        offset += count;
        to = to.subspan(count);
      }
      begin = end;
    }
    return {};
  }

 private:
  std::vector<uint8_t> head_;
  std::unique_ptr<StoredBytes> maps_, streams_;
};

Status append_all(std::span<const std::vector<uint8_t>> parts, Spill& spill) {
  for (const std::vector<uint8_t>& part : parts)
    if (Status status = spill.append(part); !status.ok()) return status;
  return {};
}

uint64_t sum_of(std::span<const StreamEntry> entries, uint32_t StreamEntry::*column) {
  uint64_t sum = 0;
  for (const StreamEntry& entry : entries) sum += entry.*column;
  return sum;
}

}  // namespace

Expected<GrowingContainer> GrowingContainer::begin(const MakeSpill& make_spill) {
  GrowingContainer container;
  for (std::unique_ptr<Spill>* spill : {&container.maps_, &container.streams_, &container.walks_}) {
    Expected<std::unique_ptr<Spill>> made = make_spill();
    if (!made) return made.status();
    *spill = std::move(*made);
  }
  container.directory_.owned_base = {0};
  container.directory_.face_base = {0};
  return container;
}

bool GrowingContainer::has_room_for(std::span<const StreamEntry> entries, uint64_t most_points) const {
  const uint64_t decoded = sum_of(entries, &StreamEntry::point_count);
  const uint64_t references = sum_of(entries, &StreamEntry::reference_count);
  const uint64_t points = point_count() + decoded - references;
  const uint64_t faces = face_count() + sum_of(entries, &StreamEntry::face_count);
  // The limits of sum_entries (patch_container.cpp) and of check_claims.
  return points <= std::min<uint64_t>(most_points, 0xfffffffe) && faces <= 0xffffffffu / 3 &&
         points + directory_.reference_count() + references <= 0xffffffffu;
}

Status GrowingContainer::append(std::span<const StreamEntry> entries,
                                std::span<const std::vector<uint8_t>> maps,
                                std::span<const std::vector<uint8_t>> streams, bool has_residue) {
  directory_.has_residue = has_residue;
  last_.first = stream_count();
  for (const StreamEntry& entry : entries) {
    directory_.entries.push_back(entry);
    directory_.owned_base.push_back(point_count() + entry.point_count - entry.reference_count);
    directory_.face_base.push_back(face_count() + entry.face_count);
  }
  last_.end = stream_count();
  if (Status status = append_all(maps, *maps_); !status.ok()) return status;
  return append_all(streams, *streams_);
}

// The streams from `first` to the last.
Expected<GrowingContainer::Opened> GrowingContainer::open_from(uint32_t first) const {
  const std::span<const StreamEntry> rows = entries().subspan(first);
  const uint64_t map_bytes = sum_of(rows, &StreamEntry::stitch_bytes);
  const uint64_t stream_bytes = sum_of(rows, &StreamEntry::stream_bytes);
  Opened opened{std::vector<uint8_t>(static_cast<size_t>(map_bytes + stream_bytes)), directory_};
  std::span<uint8_t> maps = std::span(opened.bytes).first(static_cast<size_t>(map_bytes));
  std::span<uint8_t> streams = std::span(opened.bytes).subspan(static_cast<size_t>(map_bytes));
  Status status = maps_->read(maps_->size() - map_bytes, maps);
  if (status.ok()) status = streams_->read(streams_->size() - stream_bytes, streams);
  if (!status.ok()) return status;

  PatchContainer& container = opened.container;
  container.bytes = opened.bytes;
  container.headers.resize(stream_count());
  container.stitch.resize(stream_count());
  container.streams.resize(stream_count());
  for (uint32_t i = first; i < stream_count(); ++i) {
    const StreamEntry& entry = container.entries[i];
    container.stitch[i] = maps.first(entry.stitch_bytes);
    container.streams[i] = streams.first(entry.stream_bytes);
    maps = maps.subspan(entry.stitch_bytes);
    streams = streams.subspan(entry.stream_bytes);
    Expected<core::StreamHeader> header = read_stream_header(container.streams[i]);
    if (!header) return header.status().at({.patch = i});
    const bool is_residue = i >= directory_.patch_count();
    const uint32_t faces = header->counts.face_count;
    if (header->edgebreaker == is_residue)
      return invalid_input("a patch is not an Edgebreaker mesh, or the residue is one", {.patch = i});
    if (is_residue ? faces < entry.face_count : faces != entry.face_count)
      return differs_from_directory("faces", faces, entry.face_count).at({.patch = i});
    container.headers[i] = *header;
  }
  return opened;
}

// Gives the decoder the walks of earlier streams that runs name.
Status GrowingContainer::load_walks(const PatchContainer& window, ContainerDecoder& decoder) {
  for (uint32_t i = last_.first; i < last_.end; ++i) {
    core::StitchReader reader(window.stitch_row(i));
    for (core::StitchReader::Run run; reader.next_run(run);) {
      if (run.owner >= last_.first) continue;
      std::vector<uint32_t>& walk = decoder.stitched(run.owner).walk;
      if (!walk.empty()) continue;
      const uint64_t begin = run.owner > 0 ? walk_ends_[run.owner - 1] : 0;
      walk.resize(static_cast<size_t>((walk_ends_[run.owner] - begin) / sizeof(uint32_t)));
      const std::span<uint8_t> bytes(reinterpret_cast<uint8_t*>(walk.data()), walk.size() * sizeof(uint32_t));
      if (Status status = walks_->read(begin, bytes); !status.ok()) return status;
    }
  }
  return {};
}

Status GrowingContainer::keep_walks(ContainerDecoder& decoder) {
  for (uint32_t i = last_.first; i < last_.end; ++i) {
    const std::vector<uint32_t>& walk = decoder.stitched(i).walk;
    const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(walk.data()),
                                         walk.size() * sizeof(uint32_t));
    if (Status status = walks_->append(bytes); !status.ok()) return status;
    walk_ends_.push_back(walks_->size());
  }
  return {};
}

Expected<Mesh> GrowingContainer::decode_last(std::span<const AttributeRequest> requests,
                                             const ThreadPool& pool) {
  Expected<Opened> opened = open_from(last_.first);
  if (!opened) return opened.status();
  PatchContainer& window = opened->container;
  // A decoder skips the walks if no row has references. Later streams will refer to these walks.
  if (!window.has_residue) window.entries.push_back({.reference_count = 1});
  Mesh mesh;
  const Expected<PrimitiveBuffers> out =
      allocate_mesh(point_count() - first_point(last_.first), face_count() - directory_.face_base[last_.first],
                    requests, opened->bytes.size(), mesh);
  if (!out) return out.status();
  const Watch watch;
  // In step even if that leaves threads without work: each thread takes memory for its streams.
  const uint32_t count = last_.end - last_.first, groups = count / core::kInStep;
  Steps steps(watch, count);
  ContainerDecoder decoder({&window, requests}, last_, *out, pool, steps);
  pool.for_each(groups + count % core::kInStep, [&](size_t task) {
    const auto i = static_cast<uint32_t>(task);
    if (i < groups)
      decoder.decode_streams(last_.first + i * core::kInStep, core::kInStep);
    else
      decoder.decode_streams(last_.first + groups * (core::kInStep - 1) + i, 1);
  });
  for (uint32_t i = last_.first; i < last_.end; ++i)
    if (Status status = decoder.stitched(i).status; !status.ok()) return status;
  if (Status status = load_walks(window, decoder); !status.ok()) return status;
  for (uint32_t i = last_.first; i < last_.end; ++i) {
    if (Status status = decoder.resolve_references(i).at({.patch = i}); !status.ok()) return status;
    decoder.write_references(i);
  }
  if (Status status = keep_walks(decoder); !status.ok()) return status;
  return mesh;
}

Status GrowingContainer::check_size(std::span<const AttributeRequest> requests) const {
  if (Status status = check_claims(directory_); !status.ok()) return status;
  return check_results(point_count(), face_count(), requests,
                       directory_.stitch_bytes() + directory_.stream_bytes());
}

std::unique_ptr<StoredBytes> GrowingContainer::finish(std::span<const uint8_t> head) {
  walks_.reset();
  return std::make_unique<JoinedBytes>(write_front(head), std::move(maps_), std::move(streams_));
}

}  // namespace psplit
