#include "src/loader/loader.h"

#include <string>

#include "src/container/claims.h"
#include "src/cpu/cpu_backend.h"

namespace psplit {

struct CompressedPrimitive::State {
  Container container;  // of the one stream, where the compression is kDraco
  std::span<const uint8_t> bytes;
  Compression compression;
  std::vector<AttributeRequest> attributes;
};

namespace {

constexpr uint32_t kMost16BitPoints = 0xffff;  // glTF keeps the largest index for restarts

Status usage(std::string message) { return {StatusCode::kUsage, std::move(message)}; }

size_t value_size(const AttributeRequest& request) {
  return component_bytes(request.component_type) * request.component_count;
}

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

Status check_counts(const PrimitiveSource& source, const Container& container) {
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

// The buffers as a target for so many points and faces, when it is known that they have the room.
Expected<MeshTarget> make_target(std::span<const AttributeRequest> attributes, const PrimitiveBuffers& out,
                                 uint32_t point_count, uint32_t face_count) {
  if (out.index_bytes != 2 && out.index_bytes != 4)
    return usage("indices of " + std::to_string(out.index_bytes) + " bytes");
  if (out.index_bytes == 2 && point_count > kMost16BitPoints)
    return usage(std::to_string(point_count) + " points are too many for indices of 2 bytes");
  if (out.indices.size() / out.index_bytes / 3 < face_count)
    return usage("the buffer of indices has no room for " + std::to_string(face_count) + " faces");
  if (reinterpret_cast<uintptr_t>(out.indices.data()) % out.index_bytes != 0)
    return usage("the buffer of indices is not aligned");
  if (out.attributes.size() != attributes.size())
    return usage(std::to_string(out.attributes.size()) + " buffers for " + std::to_string(attributes.size()) +
                 " attributes");
  MeshTarget target{point_count, face_count, out.indices.data(), out.index_bytes, {}};
  for (size_t k = 0; k < attributes.size(); ++k) {
    const size_t size = value_size(attributes[k]), given = out.attributes[k].bytes.size();
    const size_t stride = out.attributes[k].stride == 0 ? size : out.attributes[k].stride;
    if (stride < size) return usage("the stride of " + attributes[k].semantic + " is less than its size");
    if (point_count > 0 && (given < size || (given - size) / stride < point_count - 1))
      return usage("the buffer of " + attributes[k].semantic + " has no room for " +
                   std::to_string(point_count) + " points");
    target.attributes.push_back({out.attributes[k].bytes.data(), stride});
  }
  return target;
}

// A Draco stream as a container of one patch: of Edgebreaker, the number of points is the accessors', which
// decoding compares with the stream's.
Expected<Container> open_stream(const PrimitiveSource& source) {
  Expected<Container> container = container_of_stream(source.bytes);
  if (!container) return container;
  const Expected<core::StreamHeader> header = read_stream_header(source.bytes);
  if (!header->edgebreaker) return container;
  uint64_t points = source.point_count;
  if (points == 0) {
    const Expected<StreamDescription> description = describe_stream(source.bytes);
    if (!description) return description.status();
    points = description->point_count;
  }
  // More than the stream can have is for check_counts.
  if (points <= container->point_count()) {
    container->entries[0].point_count = static_cast<uint32_t>(points);
    container->owned_base[1] = container->entries[0].point_count;
  }
  return container;
}

std::vector<Status> run(std::span<const DecodeTask> tasks, std::span<const MeshTarget> targets,
                        const LoadOptions& options) {
  const DecodeBackend backend = options.backend == nullptr ? cpu_backend() : *options.backend;
  return backend.decode_to(tasks, targets, ThreadPool(options.thread_count), {options.progress, options.stop});
}

}  // namespace

uint64_t most_result_bytes(uint64_t stored_bytes) { return justified_result_bytes(stored_bytes); }

Expected<CompressedPrimitive> CompressedPrimitive::open(PrimitiveSource source) {
  if (Status status = check_attributes(source.attributes); !status.ok()) return status;
  Expected<Container> container =
      source.compression == Compression::kDraco ? open_stream(source) : parse_container(source.bytes);
  if (!container) return container.status();
  // Whoever asks for sizes takes memory by them.
  if (Status status = check_claims(*container).status(); !status.ok()) return status;
  if (Status status = check_counts(source, *container); !status.ok()) return status;
  if (Status status = check_results(container->point_count(), container->face_count(), source.attributes,
                                    source.bytes.size());
      !status.ok())
    return status;
  return CompressedPrimitive(std::make_shared<const State>(
      State{std::move(*container), source.bytes, source.compression, std::move(source.attributes)}));
}

std::span<const uint8_t> CompressedPrimitive::bytes() const { return state_->bytes; }
Compression CompressedPrimitive::compression() const { return state_->compression; }
uint32_t CompressedPrimitive::point_count() const { return state_->container.point_count(); }
uint32_t CompressedPrimitive::face_count() const { return state_->container.face_count(); }
uint32_t CompressedPrimitive::least_index_bytes() const { return point_count() <= kMost16BitPoints ? 2 : 4; }
uint64_t CompressedPrimitive::value_bytes(size_t attribute) const {
  return uint64_t{value_size(state_->attributes[attribute])} * point_count();
}
const std::vector<AttributeRequest>& CompressedPrimitive::attributes() const { return state_->attributes; }

uint32_t CompressedPrimitive::patch_count() const {
  return static_cast<uint32_t>(state_->container.entries.size());
}
bool CompressedPrimitive::has_residue() const { return state_->container.has_residue; }

PatchSizes CompressedPrimitive::patch(uint32_t number) const {
  const Container& container = state_->container;
  const StreamEntry& entry = container.entries[number];
  return {entry.face_count,
          entry.point_count,
          entry.stream_bytes,
          container.face_base[number],
          container.owned_base[number],
          entry.point_count - entry.reference_count};
}

Status CompressedPrimitive::decode(const PrimitiveBuffers& out, const LoadOptions& options) const {
  const PrimitiveLoad load{*this, out};
  return std::move(decode_primitives({&load, 1}, options).front());
}

Status CompressedPrimitive::decode_patch(uint32_t number, const PrimitiveBuffers& out,
                                         const LoadOptions& options) const {
  if (number >= patch_count()) return usage("there is no patch " + std::to_string(number));
  const PatchSizes sizes = patch(number);
  const Expected<MeshTarget> target = make_target(state_->attributes, out, sizes.point_count, sizes.face_count);
  if (!target) return target.status();
  const DecodeTask task{state_->container.streams[number], true, state_->attributes};
  return std::move(run({&task, 1}, {&*target, 1}, options).front()).at({.patch = number});
}

std::vector<Status> decode_primitives(std::span<const PrimitiveLoad> loads, const LoadOptions& options) {
  std::vector<Status> statuses(loads.size());
  std::vector<DecodeTask> tasks;
  std::vector<MeshTarget> targets;
  std::vector<size_t> places;  // of the tasks among `loads`
  for (size_t i = 0; i < loads.size(); ++i) {
    const CompressedPrimitive& primitive = loads[i].primitive;
    const CompressedPrimitive::State& state = *primitive.state_;
    Expected<MeshTarget> target =
        make_target(state.attributes, loads[i].out, primitive.point_count(), primitive.face_count());
    statuses[i] = target.status();
    if (!target) continue;
    tasks.push_back({state.bytes, state.compression == Compression::kDraco, state.attributes});
    targets.push_back(std::move(*target));
    places.push_back(i);
  }
  if (tasks.empty()) return statuses;
  std::vector<Status> decoded = run(tasks, targets, options);
  for (size_t n = 0; n < places.size(); ++n) statuses[places[n]] = std::move(decoded[n]);
  return statuses;
}

}  // namespace psplit
