#include <array>
#include <cstring>

#include "psplit/decode.h"
#include "src/container/stored_type.h"
#include "src/cpu/decode_in_scratch.h"

namespace psplit {
namespace {

// The header of a point cloud. Nothing if the stream is of another kind.
Expected<std::optional<core::CloudHeader>> read_cloud_header(std::span<const uint8_t> stream) {
  core::CloudHeader header;
  const core::Fault fault = core::read_cloud_header(stream.data(), stream.size(), header);
  if (fault == core::Fault::kNotDraco) return std::optional<core::CloudHeader>();
  if (fault == core::Fault::kVersion) {
    constexpr size_t kMajor = 5, kMinor = 6;  // after "DRACO"
    return unsupported("Draco stream: a point cloud of bitstream " + std::to_string(stream[kMajor]) + "." +
                       std::to_string(stream[kMinor]) + ", and only 2.2 and 2.3 are decoded");
  }
  if (fault != core::Fault::kNone) return status_of(fault);
  return std::optional(header);
}

// Decodes a patch whose attributes are not known, and calls use(header, patch).
template <typename Decode = DecodeAll, typename Use>
Status with_any_patch(const PatchContainer& container, const BorderValues& borders, uint32_t number, Use use) {
  if (!container.refusal.ok()) return container.refusal;
  const ScratchPool::Lease lease(scratch_pool());
  // The first try has memory for as many attributes as most streams have.
  const std::array<AttributeRequest, 4> likely;
  return with_decoded<Decode>(container, borders, number, likely, *lease, [&](const auto& patch, core::Arena&) {
    return use(container.headers[number], patch);
  });
}

// As above, for a stream.
template <typename Decode = DecodeAll, typename Use>
Status with_any_stream(std::span<const uint8_t> stream, Use use) {
  const Expected<std::optional<core::CloudHeader>> cloud = read_cloud_header(stream);
  if (!cloud) return cloud.status();
  if (!*cloud) return with_any_patch<Decode>(open_stream(stream), BorderValues(), 0, use);
  const ScratchPool::Lease lease(scratch_pool());
  return with_decoded_cloud<Decode>(**cloud, stream.size(), *lease,
                                    [&](const auto& patch) { return use(**cloud, patch); });
}

StreamCoding coding_of(const core::CloudHeader& header) {
  return header.is_kd_tree ? StreamCoding::kCloudKdTree : StreamCoding::kCloudSequential;
}
StreamCoding coding_of(const core::StreamHeader& header) {
  return !header.edgebreaker ? StreamCoding::kSequential
         : header.valence    ? StreamCoding::kEdgebreakerValence
                             : StreamCoding::kEdgebreaker;
}

template <typename Header, typename Index>
StreamDescription description_of(const Header& header, const core::Patch<Index>& patch) {
  StreamDescription description;
  description.coding = coding_of(header);
  description.face_count = patch.face_count;
  description.point_count = patch.point_count;
  for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
    const core::Attribute<Index>& attribute = patch.attributes[i];
    description.attributes.push_back({attribute.unique_id, static_cast<DracoSemantic>(attribute.semantic),
                                      attribute.type, attribute.components, attribute.normalized,
                                      attribute.bits});
    if (attribute.origin == nullptr) continue;
    StreamAttribute& described = description.attributes.back();
    described.range = attribute.range;
    described.origin.resize(attribute.components);
    std::memcpy(described.origin.data(), attribute.origin, described.origin.size() * sizeof(float));
  }
  return description;
}

bool has_order(const core::CloudHeader&) { return false; }
bool has_order(const core::StreamHeader& header) { return header.edgebreaker; }

// Which value of an attribute a point has.
template <typename Index>
class ValueOfPoint {
 public:
  ValueOfPoint(const core::Patch<Index>& patch, const core::Attribute<Index>& attribute, bool has_order)
      : corner_of_point_(patch.corner_of_point),
        vertex_(patch.groups[attribute.group].table.table.vertex),
        rank_(patch.groups[attribute.group].sequence.rank),
        has_order_(has_order) {}

  uint32_t vertex(uint32_t point) const {
    return corner_of_point_.empty() ? point : vertex_[corner_of_point_[point]];
  }
  uint32_t operator()(uint32_t point) const { return has_order_ ? rank_[vertex(point)] : point; }

 private:
  core::View<const Index> corner_of_point_, vertex_, rank_;
  bool has_order_;
};

template <typename Index, typename PlaceOf>
void write_integers(const core::Patch<Index>& patch, const core::Attribute<Index>& attribute,
                    const ValueOfPoint<Index>& value_of, PlaceOf place_of) {
  const uint32_t components = attribute.value_components(), stride = core::value_stride(components);
  for (uint32_t point = 0; point < patch.point_count; ++point)
    std::memcpy(place_of(point), &attribute.values[size_t{value_of.vertex(point)} * stride],
                components * sizeof(int32_t));
}

template <typename Header, typename Index>
std::vector<StoredValues> stored_values(const Header& header, const core::Patch<Index>& patch) {
  std::vector<StoredValues> stored(patch.attributes.size());
  for (uint32_t i = 0; i < stored.size(); ++i) {
    const core::Attribute<Index>& attribute = patch.attributes[i];
    const bool in_order = has_order(header);
    stored[i] = {in_order ? patch.groups[attribute.group].sequence.count : patch.point_count, !in_order,
                 attribute.coding != core::Coding::kRaw};
  }
  return stored;
}

template <typename Index>
void write_places(const core::Patch<Index>& patch, const core::Attribute<Index>& attribute, bool has_order,
                  const AttributePlaces& to) {
  const ValueOfPoint<Index> value_of(patch, attribute, has_order);
  const size_t size = to.integers ? attribute.value_components() * sizeof(int32_t) : attribute.stride();
  const size_t stride = to.stride == 0 ? size : to.stride;
  auto* const values = reinterpret_cast<uint8_t*>(to.values);
  const auto write = [&](auto place_of) {
    if (to.integers)
      write_integers(patch, attribute, value_of, place_of);
    else
      patch.write_values(attribute, place_of);
  };
  if (to.value_of_point == nullptr) return write([=](uint32_t point) { return values + point * stride; });
  write([=](uint32_t point) {
    const uint32_t value = to.value_of_point[point] = value_of(point);
    return values + value * stride;
  });
}

// Converts the values of all points to the requested type. Returns false if one does not fit.
bool convert_to(const AttributeRequest& request, const StreamAttribute& stored, size_t point_count,
                Array<std::byte>& values) {
  const DataType type = stored_type(request.component_type);
  if (type == stored.type) return true;
  Array<std::byte> converted(point_count * request.value_bytes());
  const bool fits =
      convert_components(reinterpret_cast<const uint8_t*>(values.data()), stored.type, stored.normalized,
                         point_count * stored.components, type, reinterpret_cast<uint8_t*>(converted.data()));
  values = std::move(converted);
  return fits;
}

}  // namespace

Expected<StreamDescription> describe_stream(Span<const uint8_t> stream) {
  StreamDescription description;
  Status status = with_any_stream(stream, [&](const auto& header, const auto& patch) -> Status {
    description = description_of(header, patch);
    return {};
  });
  if (!status.ok()) return status;
  return description;
}

Expected<StreamDescription> describe_patch(const PatchContainer& container, uint32_t number) {
  const Expected<BorderValues> borders = BorderValues::decode(container, number);
  if (!borders) return borders.status();
  StreamDescription description;
  Status status =
      with_any_patch(container, *borders, number, [&](const auto& header, const auto& patch) -> Status {
        description = description_of(header, patch);
        const StreamEntry& entry = container.entries[number];
        const bool is_row_right = !entry.is_condensed || patch.point_count == entry.point_count;
        return is_row_right ? Status() : status_of(core::Fault::kCounts);
      });
  if (!status.ok()) return container.is_stock ? status : std::move(status).at({.patch = number});
  return description;
}

Expected<StreamOutline> outline_stream(Span<const uint8_t> stream) {
  StreamOutline outline;
  Status status = with_any_stream<DecodeOutline>(stream, [&](const auto& header, const auto& patch) -> Status {
    outline = {description_of(header, patch), stored_values(header, patch)};
    return {};
  });
  if (!status.ok()) return status;
  return outline;
}

size_t GeometryAttribute::stride() const { return component_count() * core::data_type_bytes(type()); }

Status decode_geometry(Span<const uint8_t> stream, const PlacesFor& places_for) {
  return with_any_stream(stream, [&](const auto& header, const auto& patch) -> Status {
    const Expected<GeometryPlaces> places =
        places_for(description_of(header, patch), stored_values(header, patch));
    if (!places) return places.status();
    write_stream_faces(patch, patch.face_count, places->faces, places->index_bytes);
    for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
      const AttributePlaces& to = places->attributes[i];
      if (to.values != nullptr) write_places(patch, patch.attributes[i], has_order(header), to);
      if (places->written) places->written(i);
    }
    return {};
  });
}

Expected<GeometryPlaces> allocate_geometry(const StreamDescription& description,
                                           Span<const StoredValues> stored, bool integers,
                                           uint64_t stored_bytes, DracoGeometry& geometry) {
  geometry = {description.coding, description.point_count, {}, {}};
  uint64_t point_bytes = 0;
  for (size_t i = 0; i < stored.size(); ++i) {
    geometry.attributes.push_back({description.attributes[i], {}, integers && stored[i].has_integers});
    point_bytes += geometry.attributes.back().stride();
  }
  Status claims = check_results(description.point_count, description.face_count, point_bytes, stored_bytes);
  if (!claims.ok()) return claims;
  geometry.faces.resize(description.face_count);
  GeometryPlaces places;
  places.faces = geometry.faces.data();
  for (GeometryAttribute& attribute : geometry.attributes) {
    attribute.values.resize(description.point_count * attribute.stride());
    places.attributes.push_back({attribute.values.data(), nullptr, attribute.are_integers});
  }
  return places;
}

Expected<DracoGeometry> decode_geometry(Span<const uint8_t> stream, bool integers) {
  DracoGeometry geometry;
  Status status =
      decode_geometry(stream, [&](const StreamDescription& description, std::span<const StoredValues> stored) {
        return allocate_geometry(description, stored, integers, stream.size(), geometry);
      });
  if (!status.ok()) return status;
  return geometry;
}

Expected<Mesh> decode_draco(Span<const uint8_t> stream, StreamDescription* description) {
  Expected<DracoGeometry> geometry = decode_geometry(stream);
  if (!geometry) return geometry.status();
  StreamDescription described{
      geometry->coding, static_cast<uint32_t>(geometry->faces.size()), geometry->point_count, {}};
  for (GeometryAttribute& attribute : geometry->attributes)
    described.attributes.push_back(std::move(attribute.description));
  Expected<std::vector<AttributeRequest>> requests = gltf_attributes(described.attributes);
  if (!requests) return requests.status();
  Mesh mesh{geometry->point_count, std::move(geometry->faces), {}};
  for (size_t i = 0; i < requests->size(); ++i) {
    AttributeRequest& request = (*requests)[i];
    Array<std::byte> values = std::move(geometry->attributes[i].values);
    if (!convert_to(request, described.attributes[i], mesh.point_count, values)) return does_not_fit(request);
    mesh.attributes.push_back({std::move(request.semantic), request.component_type, request.component_count,
                               request.normalized, std::move(values)});
  }
  if (description != nullptr) *description = std::move(described);
  return mesh;
}

}  // namespace psplit
