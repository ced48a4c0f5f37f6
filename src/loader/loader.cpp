#include "psplit/loader.h"

#include <string>

#include "psplit/decode.h"
#include "src/catch_exceptions.h"
#include "src/container/claims.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "src/loader/check_buffers.h"
#include "src/loader/older_streams.h"

namespace psplit {

struct CompressedPrimitive::State {
  std::shared_ptr<const PatchContainer> container;
  std::vector<AttributeRequest> attributes;
  const OlderStreams* older = nullptr;  // decodes the stream if the container refuses it
};

namespace {

Status check_attributes(std::span<const AttributeRequest> attributes) {
  for (const AttributeRequest& request : attributes) {
    if (component_bytes(request.component_type) == 0)
      return unsupported(request.semantic + " has the component type " +
                         std::to_string(static_cast<int>(request.component_type)));
    if (request.component_count == 0 || request.component_count > 16)
      return invalid_input(request.semantic + " has " + std::to_string(request.component_count) +
                           " components");
  }
  return {};
}

Status check_counts(const PrimitiveSource& source, const PatchContainer& container) {
  const uint64_t points = container.point_count(), indices = uint64_t{3} * container.face_count();
  const char* const stored = container.is_stock ? ", the stream has " : ", the directory says ";
  const auto differ = [&](const char* what, uint64_t accessors, uint64_t count) {
    return invalid_input("the accessors have " + std::to_string(accessors) + " " + what + stored +
                         std::to_string(count));
  };
  if (source.point_count != 0 && source.point_count != points)
    return differ("points", source.point_count, points);
  if (source.index_count != 0 && source.index_count != indices)
    return differ("indices", source.index_count, indices);
  return {};
}

Expected<PrimitiveBuffers> check_buffers(std::span<const AttributeRequest> attributes,
                                         const PrimitiveBuffers& out, uint32_t point_count,
                                         uint32_t face_count) {
  std::vector<NamedSize> sizes;
  for (const AttributeRequest& request : attributes) sizes.push_back({request.semantic, request.value_bytes()});
  return check_buffers(sizes, out, point_count, face_count);
}

// A Draco stream as a container of one patch. The number of points of an Edgebreaker stream is the accessors'.
// Decoding compares it with the stream's.
Expected<PatchContainer> open_draco(const PrimitiveSource& source) {
  PatchContainer container = open_stream(source.bytes);
  if (!container.refusal.ok()) {
    const Expected<StreamDescription> described = describe_older(source.older, source.bytes, container.refusal);
    if (!described) return described.status();
    container.entries[0].face_count = container.face_base[1] = described->face_count;
    container.expect_points(described->point_count);
    return container;
  }
  if (!container.is_point_count_known) {
    uint64_t points = source.point_count;
    if (points == 0) {
      const Expected<StreamOutline> outline = outline_stream(source.bytes);
      if (!outline) return outline.status();
      points = outline->description.point_count;
    }
    // More points than the stream can have are an error of check_counts.
    if (points <= container.point_count()) container.expect_points(static_cast<uint32_t>(points));
  }
  // The caller takes memory according to the counts.
  if (Status status = check_claims(container); !status.ok()) return status;
  return container;
}

// Decodes each task into its buffers, which have room for the container's counts.
std::vector<Status> run(std::span<const DecodeTask> tasks, std::span<const PrimitiveBuffers> buffers,
                        const LoadOptions& options) {
  const DecodeBackend backend = options.backend == nullptr ? cpu_backend() : *options.backend;
  const auto buffers_for = [&](size_t i, uint32_t points, uint32_t faces) -> Expected<PrimitiveBuffers> {
    const PatchContainer& container = *tasks[i].container;
    if (points != container.point_count())
      return differs_from_directory("points", points, container.point_count());
    if (faces != container.face_count()) return differs_from_directory("faces", faces, container.face_count());
    return buffers[i];
  };
  const Watch watch{options.progress, options.stop};
  if (watch.stopped()) return std::vector<Status>(tasks.size(), cancelled());
  // The caller's callback and executor may throw.
  Expected<std::vector<Status>> statuses = catch_exceptions([&]() -> Expected<std::vector<Status>> {
    if (options.pool != nullptr) return backend.decode_into(tasks, buffers_for, *options.pool, watch);
    return backend.decode_into(tasks, buffers_for, ThreadPool(), watch);
  });
  return statuses ? std::move(*statuses) : std::vector<Status>(tasks.size(), statuses.status());
}

}  // namespace

uint64_t most_result_bytes(uint64_t stored_bytes) { return justified_result_bytes(stored_bytes); }

Expected<CompressedPrimitive> CompressedPrimitive::open(PrimitiveSource source) {
  if (Status status = check_attributes(source.attributes); !status.ok()) return status;
  Expected<PatchContainer> container =
      source.compression == Compression::kDraco ? open_draco(source) : open_container(source.bytes);
  if (!container) return container.status();
  if (Status status = check_counts(source, *container); !status.ok()) return status;
  if (Status status = check_results(container->point_count(), container->face_count(), source.attributes,
                                    source.bytes.size());
      !status.ok())
    return status;
  return CompressedPrimitive(
      std::make_shared<const State>(State{std::make_shared<const PatchContainer>(std::move(*container)),
                                          std::move(source.attributes), source.older}));
}

Expected<CompressedPrimitive> CompressedPrimitive::with_attributes(
    std::vector<AttributeRequest> attributes) const {
  if (Status status = check_attributes(attributes); !status.ok()) return status;
  if (Status status = check_results(point_count(), face_count(), attributes, bytes().size()); !status.ok())
    return status;
  return CompressedPrimitive(
      std::make_shared<const State>(State{state_->container, std::move(attributes), state_->older}));
}

const PatchContainer& CompressedPrimitive::container() const { return *state_->container; }
Span<const uint8_t> CompressedPrimitive::bytes() const { return container().bytes; }
Compression CompressedPrimitive::compression() const {
  return container().is_stock ? Compression::kDraco : Compression::kPatches;
}
uint32_t CompressedPrimitive::point_count() const { return container().point_count(); }
uint32_t CompressedPrimitive::face_count() const { return container().face_count(); }
uint32_t CompressedPrimitive::least_index_bytes() const { return psplit::least_index_bytes(point_count()); }
uint64_t CompressedPrimitive::value_bytes(size_t attribute) const {
  return uint64_t{attributes()[attribute].value_bytes()} * point_count();
}
const std::vector<AttributeRequest>& CompressedPrimitive::attributes() const { return state_->attributes; }

uint32_t CompressedPrimitive::patch_count() const { return static_cast<uint32_t>(container().entries.size()); }
bool CompressedPrimitive::has_residue() const { return container().has_residue; }

PatchSizes CompressedPrimitive::patch(uint32_t number) const {
  const StreamEntry& entry = container().entries[number];
  return {entry.face_count,
          entry.point_count,
          entry.stream_bytes,
          container().face_base[number],
          container().owned_base[number],
          entry.point_count - entry.reference_count};
}

Expected<std::vector<PatchBox>> CompressedPrimitive::patch_boxes() const {
  return psplit::patch_boxes(container());
}

const OlderStreams* CompressedPrimitive::older() const {
  return container().is_stock && !container().refusal.ok() ? state_->older : nullptr;
}

Status CompressedPrimitive::decode(const PrimitiveBuffers& out, const LoadOptions& options) const {
  const PrimitiveLoad load{*this, out};
  return std::move(decode_primitives({&load, 1}, options).front());
}

Status CompressedPrimitive::decode_patch(uint32_t number, const PrimitiveBuffers& out,
                                         const LoadOptions& options) const {
  if (number >= patch_count()) return wrong_usage("there is no patch " + std::to_string(number));
  if (older() != nullptr) return decode(out, options);
  const PatchContainer alone = container().alone(number);
  const Expected<PrimitiveBuffers> buffers =
      check_buffers(attributes(), out, alone.point_count(), alone.face_count());
  if (!buffers) return buffers.status();
  const DecodeTask task{&alone, attributes()};
  return std::move(run({&task, 1}, {&*buffers, 1}, options).front()).at({.patch = number});
}

std::vector<Status> decode_primitives(Span<const PrimitiveLoad> loads, const LoadOptions& options) {
  std::vector<Status> statuses(loads.size());
  std::vector<DecodeTask> tasks;
  std::vector<PrimitiveBuffers> buffers;
  std::vector<size_t> places;  // of the tasks among `loads`
  for (size_t i = 0; i < loads.size(); ++i) {
    const CompressedPrimitive& primitive = loads[i].primitive;
    Expected<PrimitiveBuffers> checked =
        check_buffers(primitive.attributes(), loads[i].out, primitive.point_count(), primitive.face_count());
    statuses[i] = checked.status();
    if (!checked) continue;
    if (const OlderStreams* const older = primitive.older()) {
      const bool is_stopped = options.stop != nullptr && *options.stop;
      statuses[i] = is_stopped ? cancelled()
                               : decode_older(*older, primitive.bytes(), primitive.attributes(),
                                              primitive.point_count(), primitive.face_count(), *checked);
      continue;
    }
    tasks.push_back({&primitive.container(), primitive.attributes()});
    buffers.push_back(std::move(*checked));
    places.push_back(i);
  }
  if (tasks.empty()) return statuses;
  std::vector<Status> decoded = run(tasks, buffers, options);
  for (size_t n = 0; n < places.size(); ++n) statuses[places[n]] = std::move(decoded[n]);
  return statuses;
}

}  // namespace psplit
