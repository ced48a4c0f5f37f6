// libdraco's meshes and point clouds, decoded by psplit. Programs that call draco::Decoder change one line, and
// link psplit::decoder beside libdraco:
//
//   #include <psplit/draco_decoder.h>
//   psplit::DracoDecoder decoder;  // was: draco::Decoder decoder;
//   auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
//
// The resulting geometry equals libdraco's to the bit: faces, points, attributes with the order of their values
// and each point's value, ids, skipped transforms, metadata. libdraco itself decodes what psplit does not
// support (bitstreams before 2.2, geometries that are not empty) and invalid bytes, so that statuses are its
// own. One difference: a DecoderBuffer is at its end afterwards, even if bytes follow the stream.
//
// This header is compiled with the program's libdraco, 1.5 or newer. A program whose libdraco is a shared
// library need not be compiled again: libpsplit_draco.so can be loaded before it.
//
// A decoder decodes on the calling thread. Several decoders may be used by several threads at once.
#pragma once

#include <draco/compression/decode.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstring>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"

namespace psplit {

// Fills an empty draco::Mesh or draco::PointCloud.
class DracoGeometryFiller {
 public:
  // `mesh` is null for a point cloud, otherwise the same object as `cloud`. They and `options` must outlive it.
  DracoGeometryFiller(draco::PointCloud& cloud, draco::Mesh* mesh, const draco::DecoderOptions& options)
      : cloud_(cloud), mesh_(mesh), options_(options) {}

  // Returns false, with the geometry unchanged, if libdraco must decode the buffer.
  bool fill(draco::DecoderBuffer& buffer) {
    if (cloud_.num_attributes() > 0 || (mesh_ != nullptr && mesh_->num_faces() > 0)) return false;
    const Span stream(reinterpret_cast<const uint8_t*>(buffer.data_head()),
                      static_cast<size_t>(buffer.remaining_size()));
    try {
      if (!fill_with(stream)) return false;
    } catch (const std::bad_alloc&) {
      if (mesh_ != nullptr) mesh_->SetNumFaces(0);
      return false;
    }
    buffer.Advance(buffer.remaining_size());
    return true;
  }

 private:
  bool fill_with(Span<const uint8_t> stream) {
    std::unique_ptr<draco::GeometryMetadata> metadata;
    if (!read_metadata(stream, metadata)) return false;
    Status status =
        decode_geometry(stream, [this](const StreamDescription& description, Span<const StoredValues> stored) {
          return prepare(description, stored);
        });
    if (!status.ok()) return false;
    cloud_.set_num_points(point_count_);
    for (size_t i = 0; i < attributes_.size(); ++i) {
      const int id = cloud_.AddAttribute(std::move(attributes_[i]));
      cloud_.attribute(id)->set_unique_id(unique_ids_[i]);
    }
    if (metadata != nullptr) cloud_.AddMetadata(std::move(metadata));
    return true;
  }

  // Reads metadata with libdraco, which has them before the geometry. Returns false if they are invalid.
  static bool read_metadata(Span<const uint8_t> stream, std::unique_ptr<draco::GeometryMetadata>& metadata) {
    constexpr size_t kFlags = 9, kHeader = 11;
    constexpr uint8_t kHasMetadata = 0x80;  // of the second byte of the flags
    constexpr uint16_t kVersion = 0x0202;
    if (stream.size() < kHeader || (stream[kFlags + 1] & kHasMetadata) == 0) return true;
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()) + kHeader, stream.size() - kHeader, kVersion);
    metadata = std::make_unique<draco::GeometryMetadata>();
    return draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, metadata.get());
  }

  // Called after decoding, so that the only possible failure is a lack of memory.
  Expected<GeometryPlaces> prepare(const StreamDescription& description, Span<const StoredValues> stored) {
    if (is_cloud(description.coding) != (mesh_ == nullptr)) return invalid_input("another kind of geometry");
    for (const StreamAttribute& attribute : description.attributes)
      if (description.coding == StreamCoding::kCloudKdTree && is_skipped(attribute))
        return unsupported("the integers of a kD-tree");
    attributes_.clear();
    unique_ids_.clear();
    GeometryPlaces places;
    for (size_t i = 0; i < stored.size(); ++i) {
      const StreamAttribute& attribute = description.attributes[i];
      const bool integers = stored[i].has_integers && is_skipped(attribute);
      unique_ids_.push_back(attribute.unique_id);
      attributes_.push_back(make_attribute(attribute, integers));
      draco::PointAttribute& made = *attributes_.back();
      if (!made.Reset(stored[i].value_count)) return runtime_failure("no memory");
      AttributePlaces at{reinterpret_cast<std::byte*>(made.buffer()->data()), nullptr, integers};
      if (!stored[i].one_a_point) {
        made.SetExplicitMapping(description.point_count);
        value_of_point_.resize(description.point_count);
        at.value_of_point = value_of_point_.data();
      }
      places.attributes.push_back(at);
    }
    places.written = [this](size_t attribute) { map_points(*attributes_[attribute]); };
    point_count_ = description.point_count;
    if (mesh_ == nullptr || description.face_count == 0) return places;
    mesh_->SetNumFaces(description.face_count);
    // libdraco's users also rely on faces being plain arrays of numbers.
    places.faces =
        reinterpret_cast<uint32_t*>(const_cast<draco::Mesh::Face*>(&mesh_->face(draco::FaceIndex(0))));
    return places;
  }

  bool is_skipped(const StreamAttribute& attribute) const {
    return options_.GetAttributeBool(static_cast<draco::GeometryAttribute::Type>(attribute.semantic),
                                     "skip_attribute_transform", false);
  }

  // libdraco makes integers whose transform is skipped an attribute of its own kind, which is never normalized.
  static std::unique_ptr<draco::PointAttribute> make_attribute(const StreamAttribute& from, bool integers) {
    const auto type = integers ? draco::DT_INT32 : static_cast<draco::DataType>(from.type);
    const auto components = static_cast<uint8_t>(integers && from.is_octahedral() ? 2 : from.components);
    draco::GeometryAttribute description;
    description.Init(static_cast<draco::GeometryAttribute::Type>(from.semantic), nullptr, components, type,
                     !integers && from.normalized, draco::DataTypeLength(type) * components, 0);
    auto made = std::make_unique<draco::PointAttribute>(description);
    made->SetIdentityMapping();
    if (integers && from.bits > 0) made->SetAttributeTransformData(transform_of(from));
    return made;
  }

  static std::unique_ptr<draco::AttributeTransformData> transform_of(const StreamAttribute& from) {
    auto transform = std::make_unique<draco::AttributeTransformData>();
    transform->set_transform_type(from.is_octahedral() ? draco::ATTRIBUTE_OCTAHEDRON_TRANSFORM
                                                       : draco::ATTRIBUTE_QUANTIZATION_TRANSFORM);
    transform->AppendParameterValue(int32_t{from.bits});
    if (from.is_octahedral()) return transform;
    for (const float origin : from.origin) transform->AppendParameterValue(origin);
    transform->AppendParameterValue(from.range);
    return transform;
  }

  void map_points(draco::PointAttribute& attribute) const {
    if (attribute.is_mapping_identity()) return;
    for (uint32_t point = 0; point < point_count_; ++point)
      attribute.SetPointMapEntry(draco::PointIndex(point), draco::AttributeValueIndex(value_of_point_[point]));
  }

  draco::PointCloud& cloud_;
  draco::Mesh* const mesh_;
  const draco::DecoderOptions& options_;
  uint32_t point_count_ = 0;
  std::vector<std::unique_ptr<draco::PointAttribute>> attributes_;
  std::vector<uint32_t> unique_ids_, value_of_point_;
};

// Decodes the rest of `buffer` into an empty mesh. Returns false, with nothing changed, if libdraco must decode
// it.
inline bool decode_into(draco::Mesh& mesh, draco::DecoderBuffer& buffer,
                        const draco::DecoderOptions& options = draco::DecoderOptions()) {
  return DracoGeometryFiller(mesh, &mesh, options).fill(buffer);
}
// Decodes the rest of `buffer` into an empty point cloud, as above.
inline bool decode_into(draco::PointCloud& cloud, draco::DecoderBuffer& buffer,
                        const draco::DecoderOptions& options = draco::DecoderOptions()) {
  return DracoGeometryFiller(cloud, nullptr, options).fill(buffer);
}

// A drop-in replacement for draco::Decoder.
class DracoDecoder : public draco::Decoder {
 public:
  draco::Status DecodeBufferToGeometry(draco::DecoderBuffer* buffer, draco::Mesh* mesh) {
    if (decode_into(*mesh, *buffer, *options())) return draco::OkStatus();
    return draco::Decoder::DecodeBufferToGeometry(buffer, mesh);
  }
  draco::Status DecodeBufferToGeometry(draco::DecoderBuffer* buffer, draco::PointCloud* cloud) {
    if (decode_into(*cloud, *buffer, *options())) return draco::OkStatus();
    return draco::Decoder::DecodeBufferToGeometry(buffer, cloud);
  }
  draco::StatusOr<std::unique_ptr<draco::Mesh>> DecodeMeshFromBuffer(draco::DecoderBuffer* buffer) {
    return decode_new<draco::Mesh>(buffer);
  }
  // Returns a draco::Mesh if the buffer has one.
  draco::StatusOr<std::unique_ptr<draco::PointCloud>> DecodePointCloudFromBuffer(draco::DecoderBuffer* buffer) {
    const draco::StatusOr<draco::EncodedGeometryType> type = GetEncodedGeometryType(buffer);
    if (!type.ok() || type.value() != draco::TRIANGULAR_MESH) return decode_new<draco::PointCloud>(buffer);
    draco::StatusOr<std::unique_ptr<draco::Mesh>> mesh = decode_new<draco::Mesh>(buffer);
    if (!mesh.ok()) return mesh.status();
    return std::unique_ptr<draco::PointCloud>(std::move(mesh).value());
  }

 private:
  template <typename Geometry>
  draco::StatusOr<std::unique_ptr<Geometry>> decode_new(draco::DecoderBuffer* buffer) {
    auto geometry = std::make_unique<Geometry>();
    const draco::Status status = DecodeBufferToGeometry(buffer, geometry.get());
    if (!status.ok()) return status;
    return geometry;
  }
};

}  // namespace psplit
