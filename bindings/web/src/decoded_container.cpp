#include "bindings/web/src/decoded_container.h"

#include <algorithm>

#include "src/container/claims.h"
#include "src/cpu/decode_in_scratch.h"

namespace psplit::web {
namespace {

using StitchedPatch = ContainerDecoder::StitchedPatch;
using Placeholder = ContainerDecoder::Placeholder;

// A list in words: the number of its items, and the items.
template <typename T>
void append_list(const std::vector<T>& list, std::vector<uint32_t>& words) {
  words.push_back(static_cast<uint32_t>(list.size()));
  const auto* const items = reinterpret_cast<const uint32_t*>(list.data());
  words.insert(words.end(), items, items + list.size() * (sizeof(T) / sizeof(uint32_t)));
}
template <typename T>
void take_list(const uint32_t*& words, std::vector<T>& list) {
  const uint32_t count = *words++;
  const auto* const items = reinterpret_cast<const T*>(words);
  list.assign(items, items + count);
  words += count * (sizeof(T) / sizeof(uint32_t));
}

}  // namespace

Expected<std::unique_ptr<DecodedContainer>> DecodedContainer::open(std::unique_ptr<uint8_t[]> bytes,
                                                                   size_t size, Arrival arrival) {
  std::unique_ptr<DecodedContainer> opened(new DecodedContainer());
  opened->is_outline_ = arrival == Arrival::kOutline;
  PatchContainer& container = opened->is_outline_ ? opened->chosen_.emplace().whole : opened->container_;
  const bool is_whole = arrival == Arrival::kWhole;
  if (Status status = open_front({bytes.get(), size}, is_whole, container); !status.ok()) return status;
  if (!opened->is_outline_) {
    const uint64_t total = container.total_bytes();
    if (total > 0xffffffffu) return status_of(core::Fault::kWorkspace);
    if (!is_whole) bytes.reset(new uint8_t[static_cast<size_t>(total)]);
    container.place({bytes.get(), static_cast<size_t>(total)});
    opened->bytes_ = std::move(bytes);
    if (Status status = container.read_headers(is_whole ? total : 0); !status.ok()) return status;
  }
  if (Status status = check_claims(container); !status.ok()) return status;
  return opened;
}

uint32_t DecodedContainer::arrive(size_t arrived) {
  const uint32_t before = arrived_count();
  if (chosen_) {
    stream_failure_ = chosen_->arrive(arrived, container_);
    return arrived_count();
  }
  stream_failure_ = container_.read_headers(arrived);
  if (stream_failure_.ok() && decoder_) stream_failure_ = decoder_->decode_borders({before, arrived_count()});
  return arrived_count();
}

const std::vector<uint32_t>& DecodedContainer::choose(std::vector<uint32_t> patches,
                                                      std::unique_ptr<uint8_t[]> stitch_map) {
  chosen_->choose(std::move(patches), std::move(stitch_map), container_);
  is_outline_ = false;
  return chosen_->needed();
}

Status DecodedContainer::place_chosen() {
  const uint64_t total = chosen_->needed_bytes();
  if (total > 0xffffffffu) return status_of(core::Fault::kWorkspace);
  bytes_.reset(new uint8_t[static_cast<size_t>(total)]);
  container_.bytes = {bytes_.get(), static_cast<size_t>(total)};
  chosen_->place(container_.bytes);
  return {};
}

Status DecodedContainer::in_whole(Status status) const {
  return chosen_ ? chosen_->in_whole(status) : std::move(status);
}

Status DecodedContainer::describe() {
  const Expected<BorderValues> borders = BorderValues::decode(container_, 0, 1, pool_);
  if (!borders) return borders.status();
  const ScratchPool::Lease lease(scratch_pool());
  Status status = with_decoded(container_, *borders, 0, {}, *lease, [&](const auto& patch, core::Arena&) {
    for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
      const auto& attribute = patch.attributes[i];
      stored_.push_back({attribute.semantic, static_cast<uint32_t>(attribute.type), attribute.components,
                         attribute.normalized, attribute.unique_id});
    }
    return Status();
  });
  return in_whole(std::move(status).at({.patch = 0}));
}

Status DecodedContainer::begin(StreamRange range) {
  range_ = range;
  next_ = range.first;
  is_resolved_.assign(container_.entries.size(), 0);
  if (Status status =
          check_results(container_.point_count(), container_.face_count(), requests_, container_.total_bytes());
      !status.ok())
    return status;
  Expected<PrimitiveBuffers> buffers =
      allocate_mesh(container_.owned_base[range.end] - container_.owned_base[range.first],
                    container_.face_base[range.end] - container_.face_base[range.first], requests_,
                    container_.total_bytes(), part_);
  if (!buffers) return buffers.status();
  buffers_ = std::move(*buffers);
  decoder_.emplace(DecodeTask{&container_, requests_}, range_, buffers_, pool_, steps_);
  return decoder_->decode_borders({range_.first, std::min(range_.end, arrived_count())});
}

uint32_t DecodedContainer::decode_streams() {
  const uint32_t first = next_, end = std::min(range_.end, arrived_count());
  if (!stream_failure_.ok() || first == end) return 0;
  const uint32_t count = end - first < kInStep ? 1 : kInStep;
  decoder_->decode_streams(first, count);
  next_ += count;
  for (uint32_t i = first; i < next_; ++i) {
    StitchedPatch& stitched = decoder_->stitched(i);
    if (!stitched.status.ok()) {
      stream_failure_ = in_whole(std::move(stitched.status));
      return 0;
    }
    if (!refers_only_to_range(i)) continue;
    Status status = decoder_->resolve_references(i).at({.patch = i});
    is_resolved_[i] = status.ok();
    if (status.ok())
      decoder_->write_references(i);
    else if (reference_failure_.ok())
      reference_failure_ = std::move(status);
    std::vector<uint32_t>().swap(stitched.references);
    std::vector<Placeholder>().swap(stitched.placeholders);
  }
  return count;
}

DecodedContainer::Stage DecodedContainer::failed_stage() const {
  if (!stream_failure_.ok()) return Stage::kStreams;
  return reference_failure_.ok() ? Stage::kNone : Stage::kReferences;
}

const Status& DecodedContainer::failure() const {
  return stream_failure_.ok() ? reference_failure_ : stream_failure_;
}

// The stream is decoded, so its row is not broken.
bool DecodedContainer::refers_only_to_range(uint32_t stream) const {
  if (range_.first == 0) return true;
  core::StitchReader reader(container_.stitch_row(stream));
  for (core::StitchReader::Run run; reader.next_run(run);)
    if (run.owner < range_.first) return false;
  for (core::StitchReader::Pair pair; reader.next_pair(pair);)
    if (!pair.is_repeat && pair.owner < range_.first) return false;
  return true;
}

const std::vector<uint32_t>& DecodedContainer::stitching() {
  stitching_.clear();
  for (uint32_t i = range_.first; i < next_; ++i) {
    const StitchedPatch& stitched = decoder_->stitched(i);
    append_list(stitched.walk, stitching_);
    append_list(stitched.references, stitching_);
    append_list(stitched.placeholders, stitching_);
  }
  return stitching_;
}

void DecodedContainer::add_stitching(uint32_t first, std::span<const uint32_t> words) {
  const uint32_t *at = words.data(), *const end = at + words.size();
  for (uint32_t i = first; at != end; ++i) {
    StitchedPatch& stitched = decoder_->stitched(i);
    take_list(at, stitched.walk);
    take_list(at, stitched.references);
    take_list(at, stitched.placeholders);
    is_resolved_[i] = stitched.references.empty();
  }
}

Status DecodedContainer::resolve_rest() {
  for (uint32_t i = 0; i < container_.entries.size(); ++i) {
    if (is_resolved_[i] != 0) continue;
    if (Status status = decoder_->resolve_references(i); !status.ok())
      return std::move(status).at({.patch = i});
    const StitchedPatch& stitched = decoder_->stitched(i);
    for (const Placeholder& placeholder : stitched.placeholders) {
      corrections_.push_back(placeholder.corner);
      corrections_.push_back(stitched.references[placeholder.reference]);
    }
  }
  return {};
}

}  // namespace psplit::web
