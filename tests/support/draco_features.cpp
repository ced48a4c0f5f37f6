#include "tests/support/draco_features.h"

#include <draco/compression/bit_coders/rans_bit_decoder.h>
#include <draco/compression/config/compression_shared.h>
#include <draco/compression/decode.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>
#include <draco/metadata/metadata_decoder.h>

#include <array>

namespace psplit {
namespace {

// Reads fields in the order of the stream. After a missing field, `ok` stays false.
class Walker {
 public:
  explicit Walker(std::span<const uint8_t> stream) {
    buffer_.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    buffer_.set_bitstream_version(draco::kDracoMeshBitstreamVersion);
  }

  template <typename T>
  T field() {
    T value{};
    ok = ok && buffer_.Decode(&value);
    return value;
  }
  template <typename T = uint32_t>
  T varint() {
    T value{};
    ok = ok && draco::DecodeVarint(&value, &buffer_);
    return value;
  }
  void skip(uint64_t bytes) {
    ok = ok && bytes <= static_cast<uint64_t>(buffer_.remaining_size());
    if (ok) buffer_.Advance(static_cast<int64_t>(bytes));
  }
  void skip_bits() {
    draco::RAnsBitDecoder bits;
    ok = ok && bits.StartDecoding(&buffer_);
  }
  struct SymbolCoding {
    int method = -1, bits = -1;
  };
  SymbolCoding skip_symbols(uint32_t count, int component_count) {
    if (count == 0) return {};
    std::array<uint8_t, 2> head{};
    std::vector<uint32_t> symbols(count);
    ok = ok && buffer_.Peek(&head) && draco::DecodeSymbols(count, component_count, &buffer_, symbols.data());
    return {head[0], head[0] == draco::SYMBOL_CODING_RAW ? head[1] : -1};
  }
  void skip_metadata() {
    draco::GeometryMetadata metadata;
    ok = ok && draco::MetadataDecoder().DecodeGeometryMetadata(&buffer_, &metadata);
  }
  bool at_end() const { return ok && buffer_.remaining_size() == 0; }

  bool ok = true;

 private:
  draco::DecoderBuffer buffer_;
};

void walk_edgebreaker(Walker& walker, StreamFeatures& features) {
  features.connectivity = walker.field<uint8_t>();
  walker.varint();  // vertices
  features.face_count = walker.varint();
  features.attribute_data_count = walker.field<uint8_t>();
  walker.varint();  // symbols
  features.split_symbol_count = walker.varint();
  features.split_event_count = walker.varint();
  for (uint32_t i = 0; i < 2 * features.split_event_count && walker.ok; ++i) walker.varint();
  walker.skip((uint64_t{features.split_event_count} + 7) / 8);
  if (features.connectivity == draco::MESH_EDGEBREAKER_STANDARD_ENCODING)
    walker.skip(walker.varint<uint64_t>());
  walker.skip_bits();  // start faces
  for (int i = 0; i < features.attribute_data_count; ++i) walker.skip_bits();
  if (features.connectivity == draco::MESH_EDGEBREAKER_VALENCE_ENCODING)
    for (int& method : features.context_symbols) method = walker.skip_symbols(walker.varint(), 1).method;
}

void walk_indices(Walker& walker, StreamFeatures& features) {
  features.face_count = walker.varint();
  const uint32_t point_count = walker.varint();
  features.index_coding = walker.field<uint8_t>();
  if (features.index_coding == 0) {
    features.index_symbols = walker.skip_symbols(3 * features.face_count, 1).method;
    return;
  }
  features.index_bytes = point_count < 1u << 8    ? 1
                         : point_count < 1u << 16 ? 2
                         : point_count < 1u << 21 ? 0
                                                  : 4;
  if (features.index_bytes > 0) walker.skip(uint64_t{3} * features.face_count * uint32_t(features.index_bytes));
  for (uint32_t i = 0; features.index_bytes == 0 && i < 3 * features.face_count; ++i) walker.varint();
}

void walk_prediction_data(Walker& walker, const AttributeFeatures& attribute) {
  constexpr uint64_t kTransformBytes = 8;  // two bounds, or the grid of normals and its centre
  switch (attribute.scheme) {
    case draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM:
      for (int parallelograms = 1; parallelograms <= 4; ++parallelograms)
        if (walker.varint() > 0) walker.skip_bits();
      break;
    case draco::MESH_PREDICTION_TEX_COORDS_PORTABLE:
      walker.field<int32_t>();
      walker.skip_bits();
      break;
    default: break;
  }
  if (attribute.scheme != draco::PREDICTION_NONE) walker.skip(kTransformBytes);
  if (attribute.scheme == draco::MESH_PREDICTION_GEOMETRIC_NORMAL) walker.skip_bits();
}

void walk_values(Walker& walker, AttributeFeatures& attribute, const draco::PointAttribute& decoded) {
  const auto value_count = static_cast<uint32_t>(decoded.size());
  if (attribute.coder == draco::SEQUENTIAL_ATTRIBUTE_ENCODER_GENERIC) {
    walker.skip(uint64_t{value_count} * static_cast<uint64_t>(decoded.byte_stride()));
    return;
  }
  attribute.scheme = walker.field<int8_t>();
  if (attribute.scheme != draco::PREDICTION_NONE) attribute.transform = walker.field<int8_t>();
  const bool octahedral = attribute.coder == draco::SEQUENTIAL_ATTRIBUTE_ENCODER_NORMALS;
  const int component_count = octahedral ? 2 : attribute.component_count;
  const uint32_t symbol_count = value_count * static_cast<uint32_t>(component_count);
  if (walker.field<uint8_t>() != 0) {
    const auto [method, bits] = walker.skip_symbols(symbol_count, component_count);
    attribute.symbols = method;
    attribute.symbol_bits = bits;
  } else {
    attribute.stored_bytes = walker.field<uint8_t>();
    walker.skip(uint64_t{symbol_count} * static_cast<uint64_t>(attribute.stored_bytes));
  }
  walk_prediction_data(walker, attribute);
}

void walk_quantization(Walker& walker, AttributeFeatures& attribute) {
  const bool on_grid = attribute.coder == draco::SEQUENTIAL_ATTRIBUTE_ENCODER_QUANTIZATION;
  const bool octahedral = attribute.coder == draco::SEQUENTIAL_ATTRIBUTE_ENCODER_NORMALS;
  if (on_grid) walker.skip((static_cast<uint64_t>(attribute.component_count) + 1) * sizeof(float));
  if (on_grid || octahedral) attribute.bits = walker.field<uint8_t>();
}

void walk_attributes(Walker& walker, StreamFeatures& features, const draco::Mesh& decoded) {
  const int group_count = walker.field<uint8_t>();
  std::vector<AttributeFeatures> groups(static_cast<size_t>(group_count));
  if (features.edgebreaker)
    for (AttributeFeatures& group : groups) {
      group.data_id = walker.field<int8_t>();
      group.element = walker.field<uint8_t>();
      group.traversal = walker.field<uint8_t>();
    }
  std::vector<size_t> group_ends;
  for (const AttributeFeatures& group : groups) {
    const size_t begin = features.attributes.size();
    const uint32_t count = walker.varint();
    for (uint32_t i = 0; i < count && walker.ok; ++i) {
      AttributeFeatures attribute = group;
      attribute.type = walker.field<uint8_t>();
      attribute.data_type = walker.field<uint8_t>();
      attribute.component_count = walker.field<uint8_t>();
      walker.field<uint8_t>();  // normalized
      attribute.unique_id = walker.varint();
      features.attributes.push_back(attribute);
    }
    group_ends.push_back(features.attributes.size());
    for (size_t i = begin; i < group_ends.back(); ++i) features.attributes[i].coder = walker.field<uint8_t>();
  }
  walker.ok = walker.ok && features.attributes.size() == static_cast<size_t>(decoded.num_attributes());
  size_t begin = 0;
  for (const size_t end : group_ends) {
    for (size_t i = begin; i < end && walker.ok; ++i)
      walk_values(walker, features.attributes[i], *decoded.attribute(static_cast<int>(i)));
    for (size_t i = begin; i < end && walker.ok; ++i) walk_quantization(walker, features.attributes[i]);
    begin = end;
  }
}

}  // namespace

std::optional<StreamFeatures> read_features(std::span<const uint8_t> stream) {
  // The number of values of an attribute with seams is known only after decoding.
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return std::nullopt;

  Walker walker(stream);
  StreamFeatures features;
  walker.skip(5 + 1 + 1 + 1);  // magic, version, geometry type
  features.edgebreaker = walker.field<uint8_t>() == draco::MESH_EDGEBREAKER_ENCODING;
  features.metadata = (walker.field<uint16_t>() & METADATA_FLAG_MASK) != 0;
  if (features.metadata) walker.skip_metadata();
  if (features.edgebreaker)
    walk_edgebreaker(walker, features);
  else
    walk_indices(walker, features);
  walk_attributes(walker, features, *decoded.value());
  if (!walker.at_end()) return std::nullopt;
  return features;
}

}  // namespace psplit
