#include "mesh_files/draco_file.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/json/extension_names.h"
#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "mesh_files/draco_metadata_json.h"
#include "mesh_files/rounded_numbers.h"
#include "psplit/decode.h"
#include "src/container/stored_type.h"

namespace psplit {
namespace {

// The kind follows the magic and two bytes of version.
bool is_point_cloud_stream(std::span<const uint8_t> stream) {
  constexpr size_t kKind = 7;
  constexpr uint8_t kPointCloud = 0;
  return is_draco(stream) && stream.size() > kKind && stream[kKind] == kPointCloud;
}

size_t append_stored_accessor(Document& document, const AccessorData& data) {
  Json accessor = describe_stored(data);
  Json& accessors = document.json()["accessors"];
  accessors.push_back(std::move(accessor));
  return accessors.size() - 1;
}

template <typename T>
uint64_t count_rounded(const GeometryAttribute& attribute) {
  uint64_t count = 0;
  for (size_t at = 0; at + sizeof(T) <= attribute.values.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, attribute.values.data() + at, sizeof(T));
    constexpr T kMost = std::numeric_limits<T>::max();
    const bool is_fraction = std::is_integral_v<T> && attribute.description.normalized;
    count +=
        is_fraction ? !has_float(static_cast<double>(value) / static_cast<double>(kMost)) : !has_float(value);
  }
  return count;
}

// The number of values that no float is equal to.
uint64_t count_rounded_values(const GeometryAttribute& attribute) {
  switch (attribute.type()) {
    case DataType::kInt32: return count_rounded<int32_t>(attribute);
    case DataType::kUint32: return count_rounded<uint32_t>(attribute);
    case DataType::kInt64: return count_rounded<int64_t>(attribute);
    case DataType::kUint64: return count_rounded<uint64_t>(attribute);
    case DataType::kFloat64: return count_rounded<double>(attribute);
    default: return 0;
  }
}

// Whether the values become floats.
bool may_be_rounded(const StreamAttribute& attribute, const AttributeRequest& request) {
  return attribute.type != DataType::kFloat32 && request.component_type == ComponentType::kFloat32;
}

const char* kind_of(const StreamAttribute& attribute) {
  if (attribute.type == DataType::kFloat64) return "double";
  return attribute.normalized ? "fraction" : "whole number";
}

void say_rounded(std::span<const uint8_t> stream, const StreamDescription& description,
                 const std::vector<AttributeRequest>& requests, Losses& losses) {
  std::optional<Expected<DracoGeometry>> geometry;
  for (size_t i = 0; i < requests.size(); ++i) {
    const StreamAttribute& attribute = description.attributes[i];
    if (!may_be_rounded(attribute, requests[i])) continue;
    if (!geometry) geometry = decode_geometry(stream);
    if (!*geometry)  // of a bitstream that only libdraco decodes
      losses.say("numbers of " + requests[i].semantic + " become floats, which may round them");
    else
      say_rounded(kind_of(attribute), requests[i].semantic, count_rounded_values((*geometry)->attributes[i]),
                  losses);
  }
}

bool is_retyped(const StreamDescription& description, const std::vector<AttributeRequest>& requests) {
  for (size_t i = 0; i < requests.size(); ++i)
    if (description.attributes[i].type != stored_type(requests[i].component_type)) return true;
  return false;
}

StreamMetadata metadata_in(std::span<const uint8_t> stream, Losses& losses) {
  Expected<StreamMetadata> metadata = read_metadata(stream);
  if (metadata) return std::move(*metadata);
  // Streams of other versions have none that is known.
  if (metadata.status().code() == StatusCode::kInvalidInput)
    losses.say("metadata are left out: " + metadata.status().message());
  return {};
}

// The geometry's metadata become extras of the mesh, and an attribute's metadata extras of its accessor.
void add_extras(Document& document, const StreamMetadata& metadata,
                const std::vector<const Metadata*>& of_attributes,
                const std::vector<AttributeRequest>& requests, Losses& losses) {
  const auto add = [&](const Metadata& tree, const std::string& of, Json& object) {
    if (Json extras = json_of_metadata(tree, of, losses); !extras.is_null())
      object["extras"] = std::move(extras);
  };
  Json& json = document.json();
  add(metadata.geometry, "the geometry", json["meshes"][0]);
  const Json& attributes = json["meshes"][0]["primitives"][0]["attributes"];
  for (size_t i = 0; i < requests.size(); ++i)
    if (of_attributes[i] != nullptr)
      add(*of_attributes[i], requests[i].semantic,
          json["accessors"][attributes[requests[i].semantic].get<size_t>()]);
}

void list_quantization(Document& document, const std::vector<AttributeRequest>& requests) {
  const bool is_needed = std::ranges::any_of(requests, [](const AttributeRequest& request) {
    return needs_mesh_quantization(request.semantic, request.component_type, request.normalized);
  });
  if (is_needed) list_extension(document, kQuantizationExtensionName, true);
}

Expected<Document> document_from_points(std::span<const uint8_t> stream, const DecodePoints& decode,
                                        Losses& losses) {
  StoredCloud cloud;
  cloud.stream_bytes = stream.size();
  const Expected<Mesh> points = decode(stream, cloud.stream);
  if (!points) return points.status();
  if (points->point_count == 0) return unsupported("a point cloud without points, which glTF cannot hold");
  Expected<std::vector<AttributeRequest>> requests = gltf_attributes(cloud.stream.attributes);
  if (!requests) return requests.status();
  const StreamMetadata metadata = metadata_in(stream, losses);
  const std::vector<const Metadata*> of_attributes = metadata_of_attributes(metadata, *requests, losses);
  take_names(of_attributes, *requests);
  Document document = new_document();
  Json attributes = Json::object();
  for (size_t i = 0; i < requests->size(); ++i) {
    const Attribute& attribute = points->attributes[i];
    const AccessorData data{attribute.component_type, attribute.component_count, attribute.normalized,
                            points->point_count, attribute.values};
    attributes[(*requests)[i].semantic] =
        append_accessor(document, data, kArrayBuffer, attribute.semantic == "POSITION");
  }
  primitive_json(document, {0, 0}) = {{"attributes", std::move(attributes)}, {"mode", kPointsMode}};
  document.from_draco = true;
  add_extras(document, metadata, of_attributes, *requests, losses);
  list_quantization(document, *requests);
  say_rounded(stream, cloud.stream, *requests, losses);
  document.cloud = std::move(cloud);
  return document;
}

}  // namespace

bool is_draco(std::span<const uint8_t> bytes) {
  constexpr std::string_view kMagic = "DRACO";
  return bytes.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

Expected<Document> document_from_draco(std::span<const uint8_t> stream, const DescribeStream& describe,
                                       const DecodePoints& decode_points, Losses* losses) {
  Losses unheard;
  if (losses == nullptr) losses = &unheard;
  const Status point_cloud = unsupported("a point cloud: only triangles can be split");
  if (is_point_cloud_stream(stream))
    return decode_points ? document_from_points(stream, decode_points, *losses) : point_cloud;
  const Expected<StreamDescription> description = describe(stream);
  if (!description) return description.status();
  if (description->face_count == 0) return point_cloud;
  Expected<std::vector<AttributeRequest>> requests = gltf_attributes(description->attributes);
  if (!requests) return requests.status();
  const StreamMetadata metadata = metadata_in(stream, *losses);
  const std::vector<const Metadata*> of_attributes = metadata_of_attributes(metadata, *requests, *losses);
  take_names(of_attributes, *requests);

  Document document = new_document();
  document.from_draco = true;
  document.is_retyped = is_retyped(*description, *requests);
  Json attributes = Json::object(), unique_ids = Json::object();
  for (const AttributeRequest& request : *requests) {
    attributes[request.semantic] = append_stored_accessor(
        document,
        {request.component_type, request.component_count, request.normalized, description->point_count, {}});
    unique_ids[request.semantic] = request.unique_id;
  }
  const size_t indices =
      append_stored_accessor(document, {ComponentType::kUint32, 1, false, 3 * description->face_count, {}});
  const Json extension{{"bufferView", append_buffer_view(document, stream)}, {"attributes", unique_ids}};
  primitive_json(document, {0, 0}) = {{"attributes", std::move(attributes)},
                                      {"indices", indices},
                                      {"extensions", {{kStockExtensionName, extension}}}};
  list_extension(document, kStockExtensionName, true);
  list_quantization(document, *requests);
  add_extras(document, metadata, of_attributes, *requests, *losses);
  say_rounded(stream, *description, *requests, *losses);
  return document;
}

}  // namespace psplit
