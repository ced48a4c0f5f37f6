#include "gltf_ext/mesh_files/draco_file.h"

#include <algorithm>
#include <string_view>

#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/primitive_edit.h"

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

Expected<Document> document_from_points(std::span<const uint8_t> stream, const DecodePoints& decode) {
  StoredCloud cloud;
  cloud.stream_bytes = stream.size();
  const Expected<Mesh> points = decode(stream, cloud.stream);
  if (!points) return points.status();
  if (points->point_count == 0) return unsupported("a point cloud without points, which glTF cannot hold");
  Document document = new_document();
  Json attributes = Json::object();
  for (const Attribute& attribute : points->attributes) {
    const AccessorData data{attribute.component_type, attribute.component_count, attribute.normalized,
                            points->point_count, attribute.values};
    attributes[attribute.semantic] =
        append_accessor(document, data, kArrayBuffer, attribute.semantic == "POSITION");
  }
  constexpr int kPoints = 0;
  primitive_json(document, {0, 0}) = {{"attributes", std::move(attributes)}, {"mode", kPoints}};
  document.from_draco = true;
  document.cloud = std::move(cloud);
  return document;
}

}  // namespace

bool is_draco(std::span<const uint8_t> bytes) {
  constexpr std::string_view kMagic = "DRACO";
  return bytes.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

Expected<Document> document_from_draco(std::span<const uint8_t> stream, const DescribeStream& describe,
                                       const DecodePoints& decode_points) {
  const Status point_cloud = unsupported("a point cloud: only triangles can be split");
  if (is_point_cloud_stream(stream))
    return decode_points ? document_from_points(stream, decode_points) : point_cloud;
  const Expected<StreamDescription> description = describe(stream);
  if (!description) return description.status();
  if (description->face_count == 0) return point_cloud;
  const Expected<std::vector<AttributeRequest>> requests = gltf_attributes(description->attributes);
  if (!requests) return requests.status();

  Document document = new_document();
  document.from_draco = true;
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
  return document;
}

}  // namespace psplit
