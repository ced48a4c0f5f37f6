#include "src/cpu/container_decoder.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "src/container/stored_type.h"
#include "src/container/write_faces.h"
#include "src/core/stitch.h"
#include "src/cpu/decode_in_scratch.h"

namespace psplit {

using core::Fault;

ContainerDecoder::ContainerDecoder(const DecodeTask& task, const PrimitiveBuffers& out, const ThreadPool& pool,
                                   Steps& steps, std::vector<StreamFindings>* findings)
    : ContainerDecoder(task, {0, static_cast<uint32_t>(task.container->entries.size())}, out, pool, steps,
                       findings) {}

ContainerDecoder::ContainerDecoder(const DecodeTask& task, StreamRange range, const PrimitiveBuffers& out,
                                   const ThreadPool& pool, Steps& steps, std::vector<StreamFindings>* findings)
    : container_(*task.container),
      requests_(task.requests),
      has_references_(container_.reference_count() > 0),
      range_(range),
      out_(out),
      pool_(pool),
      steps_(steps),
      findings_(findings),
      patches_(container_.entries.size()) {}

Status ContainerDecoder::decode_borders(StreamRange streams) {
  Expected<BorderValues> borders = BorderValues::decode(container_, streams.first, streams.end, pool_);
  if (!borders) return borders.status();
  borders_ = std::move(*borders);
  return {};
}

Status ContainerDecoder::decode() {
  if (Status status = decode_borders(range_); !status.ok()) return status;
  decode_first_round(range_);
  if (steps_.stopped()) return cancelled();
  if (Status status = first_failure(range_); !status.ok()) return status;
  decode_second_round(range_);
  return first_failure(range_);
}

Status ContainerDecoder::decode_in_windows(uint64_t most_faces,
                                           const std::function<void(StreamRange)>& finish) {
  // After an error the windows go on, to find an error that decode() reports before it: that of a border, then
  // that of a stream, then that of a reference.
  Status stream_error, reference_error;
  for (StreamRange window = window_from(range_.first, most_faces); window.first < range_.end;
       window = window_from(window.end, most_faces)) {
    if (Status status = decode_borders(window); !status.ok()) return status;
    decode_first_round(window);
    if (steps_.stopped()) return cancelled();
    if (stream_error.ok()) stream_error = first_failure(window);
    if (stream_error.ok() && reference_error.ok()) {
      decode_second_round(window);
      reference_error = first_failure(window);
    }
    for (uint32_t i = window.first; i < window.end; ++i) {
      StitchedPatch kept;
      kept.walk = std::move(patches_[i].walk);
      kept.status = std::move(patches_[i].status);
      patches_[i] = std::move(kept);
    }
    finish(window);
  }
  return stream_error.ok() ? reference_error : stream_error;
}

StreamRange ContainerDecoder::window_from(uint32_t first, uint64_t most_faces) const {
  uint32_t end = std::min(first + 1, range_.end);
  while (end < range_.end && container_.face_base[end + 1] - container_.face_base[first] <= most_faces) ++end;
  return {first, end};
}

void ContainerDecoder::decode_first_round(StreamRange window) {
  const uint32_t count = window.end - window.first;
  // Streams go in step only if that leaves no thread without work.
  const uint32_t in_step = count / kInStep >= static_cast<uint32_t>(pool_.thread_count()) ? count / kInStep : 0;
  pool_.for_each(in_step + (count - in_step * kInStep), [&](size_t task) {
    if (steps_.stopped()) return;
    const auto i = static_cast<uint32_t>(task);
    if (i < in_step)
      decode_streams(window.first + i * kInStep, kInStep);
    else
      decode_streams(window.first + in_step * (kInStep - 1) + i, 1);
  });
}

void ContainerDecoder::decode_second_round(StreamRange window) {
  pool_.for_each(window.end - window.first, [&](size_t i) {
    const auto patch = static_cast<uint32_t>(window.first + i);
    patches_[patch].status = resolve_references(patch).at({.patch = patch});
    if (!patches_[patch].status.ok()) return;
    write_references(patch);
    check_copies(patch);
  });
}

Status ContainerDecoder::first_failure(StreamRange window) const {
  for (uint32_t i = window.first; i < window.end; ++i)
    if (!patches_[i].status.ok()) return patches_[i].status;
  return {};
}

void ContainerDecoder::decode_streams(uint32_t first, uint32_t count) {
  const ScratchPool::Lease lease(scratch_pool());
  if (count == kInStep)
    decode_patches(first, *lease);
  else
    decode_patch(first, *lease);
  steps_.finish(count);
}

void ContainerDecoder::decode_patch(uint32_t i, Scratch& scratch) {
  Status status = with_decoded(
      container_, borders_, i, requests_, scratch,
      [&](const auto& patch, core::Arena& arena) { return write_patch(i, patch, arena, scratch.numbers); });
  patches_[i].status = std::move(status).at({.patch = i});
}

// Patches [first, first + kInStep).
void ContainerDecoder::decode_patches(uint32_t first, Scratch& scratch) {
  std::array<StreamTask, kInStep> tasks;
  for (uint32_t n = 0; n < kInStep; ++n) tasks[n] = {&container_, first + n, requests_};
  const auto left =
      decode_in_step<kInStep>(tasks, borders_, scratch, [&](uint32_t n, const auto& patch, core::Arena& arena) {
        auto status = write_patch(first + n, patch, arena, scratch.numbers);
        if (!status) return false;
        patches_[first + n].status = std::move(*status).at({.patch = first + n});
        return true;
      });
  for (uint32_t n = 0; n < kInStep; ++n)
    if (left[n]) decode_patch(first + n, scratch);
}

template <typename Index>
std::optional<Status> ContainerDecoder::write_patch(uint32_t i, const core::Patch<Index>& patch,
                                                    core::Arena& arena, std::vector<uint32_t>& numbers) {
  const StreamEntry& entry = container_.entries[i];
  if (patch.point_count != entry.point_count)
    return differs_from_directory("points", patch.point_count, entry.point_count);
  std::vector<const core::Attribute<Index>*> attributes;
  if (Status status = find_attributes(patch, requests_, attributes); !status.ok()) return status;
  core::View<Index> border;
  if (has_references_ && core::walk_border(patch, arena, border) == Fault::kWorkspace) return std::nullopt;
  numbers.resize(entry.point_count);
  const Fault fault =
      core::number_mesh_points(core::SerialLanes(), container_.stitch_row(i), core::View<const Index>(border),
                               core::View<uint32_t>(numbers.data(), numbers.size()), references_of(i));
  if (fault != Fault::kNone) return status_of(fault);

  const uint32_t total = container_.point_count(), first_face = container_.face_base[i];
  std::vector<Placeholder>& placeholders = patches_[i].placeholders;
  placeholders.clear();
  with_indices(out_.indices.data(), out_.index_bytes, [&]<typename Out>(Out* out) {
    out += size_t{3} * (first_face - container_.face_base[range_.first]);
    for (uint32_t face = 0; face < entry.face_count; ++face)
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t number = numbers[patch.point_at[4 * face + k]];
        *out++ = static_cast<Out>(number);
        if (number >= total) placeholders.push_back({3 * (first_face + face) + k, number - total});
      }
  });
  const size_t first_point = container_.owned_base[range_.first];
  PointVertices<Index> vertices(patch);
  for (size_t k = 0; k < requests_.size(); ++k) {
    const size_t stride = out_.attributes[k].stride;
    // The address of the mesh's point 0. Only addresses of points that the range owns are made to pointers.
    const uintptr_t values =
        reinterpret_cast<uintptr_t>(out_.attributes[k].bytes.data()) - first_point * stride;
    const uint32_t* const number_of = numbers.data();
    const uintptr_t first_value = values + (numbers.empty() ? 0 : numbers.front()) * stride;
    Status status =
        !PSPLIT_IS_SMALL_CODE && !has_references_ && patch.point_count > 0
            ? write_attribute_at(patch, *attributes[k], requests_[k], vertices,
                                 reinterpret_cast<std::byte*>(first_value), stride)
            : write_attribute(patch, *attributes[k], requests_[k], vertices, [=](uint32_t point) -> std::byte* {
                // The owner writes; every copy holds the same bits.
                const uint32_t number = number_of[point];
                return number < total ? reinterpret_cast<std::byte*>(values + number * stride) : nullptr;
              });
    if (!status.ok()) return status;
  }
  if (!PSPLIT_IS_SMALL_CODE && findings_ != nullptr) {
    check_types<Index>(i, attributes);
    if (Status status = keep_copies<Index>(i, patch, attributes, numbers); !status.ok()) return status;
  }
  patches_[i].walk.resize(border.size());
  for (size_t at = 0; at < border.size(); ++at) {
    const uint32_t number = numbers[border[at]];
    patches_[i].walk[at] = number < total ? number : core::kNoPoint;
  }
  return Status();
}

template <typename Index>
void ContainerDecoder::check_types(uint32_t i, std::span<const core::Attribute<Index>* const> attributes) {
  Status& types = (*findings_)[i].types;
  for (size_t k = requests_.size(); k-- > 0;)
    if (attributes[k]->type != stored_type(requests_[k].component_type))
      types = invalid_input(requests_[k].semantic + " is stored in another type than its accessor's",
                            {.patch = static_cast<int64_t>(i)});
}

// Keeps the values of references. Copies in the residue may have any values.
template <typename Index>
Status ContainerDecoder::keep_copies(uint32_t i, const core::Patch<Index>& patch,
                                     std::span<const core::Attribute<Index>* const> attributes,
                                     const std::vector<uint32_t>& numbers) {
  if (i >= container_.patch_count()) return {};
  StitchedPatch& stitched = patches_[i];
  const uint32_t total = container_.point_count();
  stitched.copied_points.resize(stitched.references.size());
  for (uint32_t point = 0; point < numbers.size(); ++point)
    if (numbers[point] >= total) stitched.copied_points[numbers[point] - total] = point;
  stitched.copies.resize(requests_.size());
  PointVertices<Index> vertices(patch);
  for (size_t k = 0; k < requests_.size(); ++k) {
    const size_t width = requests_[k].value_bytes();
    std::vector<std::byte>& copies = stitched.copies[k];
    copies.resize(stitched.references.size() * width);
    Status status =
        write_attribute(patch, *attributes[k], requests_[k], vertices, [&](uint32_t point) -> std::byte* {
          return numbers[point] < total ? nullptr : copies.data() + (numbers[point] - total) * width;
        });
    if (!status.ok()) return status;
  }
  return {};
}

// Reports the first attribute with a difference, at its first decoded point.
void ContainerDecoder::check_copies(uint32_t i) {
  StitchedPatch& patch = patches_[i];
  for (size_t k = 0; k < patch.copies.size(); ++k) {
    const size_t width = requests_[k].value_bytes();
    const AttributeBuffer& out = out_.attributes[k];
    size_t first = patch.references.size();
    for (size_t r = 0; r < patch.references.size(); ++r)
      if ((first == patch.references.size() || patch.copied_points[r] < patch.copied_points[first]) &&
          std::memcmp(patch.copies[k].data() + r * width, out.bytes.data() + patch.references[r] * out.stride,
                      width) != 0)
        first = r;
    if (first == patch.references.size()) continue;
    (*findings_)[i].copies =
        invalid_input(requests_[k].semantic + " of decoded point " +
                          std::to_string(patch.copied_points[first]) + " differs from that of point " +
                          std::to_string(patch.references[first]) + ", of which it is a copy",
                      {.patch = static_cast<int64_t>(i)});
    return;
  }
}

core::View<uint32_t> ContainerDecoder::references_of(uint32_t i) {
  std::vector<uint32_t>& references = patches_[i].references;
  references.resize(container_.entries[i].reference_count);
  return {references.data(), references.size()};
}

Status ContainerDecoder::resolve_references(uint32_t i) {
  const core::View<uint32_t> numbers = references_of(i);
  const auto walk_of = [&](uint32_t stream, uint32_t place) {
    const std::vector<uint32_t>& walk = patches_[stream].walk;
    return place < walk.size() ? walk[place] : core::kNoPoint;
  };
  const auto owned_of = [&](uint32_t stream, uint32_t rank) {
    const uint32_t base = container_.owned_base[stream];
    return rank < container_.owned_base[stream + 1] - base ? base + rank : core::kNoPoint;
  };
  const Fault fault =
      core::resolve_references(core::SerialLanes(), container_.stitch_row(i), walk_of, owned_of, numbers);
  return status_of(fault);
}

void ContainerDecoder::write_references(uint32_t i) {
  const StitchedPatch& patch = patches_[i];
  const size_t first_corner = size_t{3} * container_.face_base[range_.first];
  with_indices(out_.indices.data(), out_.index_bytes, [&]<typename Out>(Out* out) {
    for (const Placeholder& placeholder : patch.placeholders)
      out[placeholder.corner - first_corner] = static_cast<Out>(patch.references[placeholder.reference]);
  });
}

Expected<CheckedMesh> decode_checked(const PatchContainer& container,
                                     std::span<const AttributeRequest> requests, const ThreadPool& pool) {
  CheckedMesh result;
  result.streams.resize(container.entries.size());
  const Expected<PrimitiveBuffers> out = allocate_mesh(container.point_count(), container.face_count(),
                                                       requests, container.bytes.size(), result.mesh);
  if (!out) return out.status();
  const Watch watch;
  Steps steps(watch, container.entries.size());
  if (Status status = ContainerDecoder({&container, requests}, *out, pool, steps, &result.streams).decode();
      !status.ok())
    return status;
  return result;
}

std::vector<Status> decode_checked_into(std::span<const CheckedTask> tasks, const ThreadPool& pool,
                                        const Watch& watch) {
  size_t streams = 0;
  std::vector<size_t> order;  // the largest first, so that no thread begins one when all others are done
  for (const CheckedTask& task : tasks) {
    streams += task.task.container->entries.size();
    order.push_back(order.size());
  }
  const auto size_of = [&](size_t i) { return tasks[i].task.container->bytes.size(); };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return size_of(a) > size_of(b); });
  Steps steps(watch, streams);
  std::vector<Status> statuses(tasks.size());
  pool.for_each(order.size(), [&](size_t place) {
    const auto& [task, buffers, findings] = tasks[order[place]];
    statuses[order[place]] = ContainerDecoder(task, buffers, pool, steps, findings).decode();
  });
  return statuses;
}

core::Fault decode_wide(const core::StreamHeader& header, core::Arena& arena, core::Patch<uint32_t>& out) {
  return core::decode_patch<uint32_t>(header, arena, out);
}

}  // namespace psplit
