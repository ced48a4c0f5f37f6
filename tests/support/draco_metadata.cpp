#include "tests/support/draco_metadata.h"

#include <draco/metadata/geometry_metadata.h>
#include <draco/metadata/metadata_decoder.h>

#include <algorithm>

namespace psplit {
namespace {

Metadata metadata_of(const draco::Metadata& source) {
  Metadata metadata;
  for (const auto& [name, value] : source.entries()) metadata.entries[name] = value.data();
  for (const auto& [name, part] : source.sub_metadatas()) {
    metadata.parts.push_back(metadata_of(*part));
    metadata.parts.back().name = name;
  }
  return metadata;
}

void sort_parts(Metadata& metadata) {
  std::ranges::sort(metadata.parts, {}, &Metadata::name);
  for (Metadata& part : metadata.parts) sort_parts(part);
}

}  // namespace

std::optional<StreamMetadata> read_metadata_with_libdraco(std::span<const uint8_t> stream) {
  constexpr size_t kFront = 11;
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()) + kFront, stream.size() - kFront);
  buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
  draco::GeometryMetadata source;
  if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &source)) return std::nullopt;
  StreamMetadata metadata;
  metadata.geometry = metadata_of(source);
  for (const auto& attribute : source.attribute_metadatas())
    metadata.attributes.push_back({attribute->att_unique_id(), metadata_of(*attribute)});
  sort_parts(metadata);
  return metadata;
}

void sort_parts(StreamMetadata& metadata) {
  sort_parts(metadata.geometry);
  for (AttributeMetadata& attribute : metadata.attributes) sort_parts(attribute.metadata);
}

}  // namespace psplit
