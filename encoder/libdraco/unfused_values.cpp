#include "encoder/libdraco/unfused_values.h"

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/attributes/attribute_quantization_transform.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "encoder/libdraco/patch_stream.h"

namespace psplit {
namespace {

// The unit vector of a place on an octahedron that is unfolded to a square.
void unit_vector(const int32_t* place, int bits, float* out) {
  const float scale = 2.0f / static_cast<float>((1 << bits) - 2);
  float y = static_cast<float>(place[0]) * scale - 1.0f, z = static_cast<float>(place[1]) * scale - 1.0f;
  const float x = 1.0f - std::fabs(y) - std::fabs(z), fold = std::max(-x, 0.0f);
  y += y < 0 ? fold : -fold;
  z += z < 0 ? fold : -fold;
  const float square = x * x + y * y + z * z;
  const bool is_short = static_cast<double>(square) < 1e-6;
  const float inverse = is_short ? 0 : 1.0f / std::sqrt(square);
  const float vector[3] = {x, y, z};
  for (int k = 0; k < 3; ++k) out[k] = is_short ? 0 : vector[k] * inverse;
}

// Calls set(index, floats) for each value of an attribute that a transform codes.
template <typename Set>
void for_each_value(const draco::PointAttribute& coded, Set set) {
  const draco::AttributeTransformData* data = coded.GetAttributeTransformData();
  if (data == nullptr) return;
  std::vector<int32_t> in(static_cast<size_t>(coded.num_components()));
  std::vector<float> out(std::max<size_t>(in.size(), 3));
  const auto visit = [&](auto calculate) {
    for (uint32_t i = 0; i < coded.size(); ++i) {
      coded.GetValue(draco::AttributeValueIndex(i), in.data());
      calculate();
      set(draco::AttributeValueIndex(i), out.data());
    }
  };
  draco::AttributeQuantizationTransform grid;
  draco::AttributeOctahedronTransform octahedron;
  if (data->transform_type() == draco::ATTRIBUTE_OCTAHEDRON_TRANSFORM && octahedron.InitFromAttribute(coded))
    visit([&] { unit_vector(in.data(), octahedron.quantization_bits(), out.data()); });
  if (data->transform_type() == draco::ATTRIBUTE_QUANTIZATION_TRANSFORM && grid.InitFromAttribute(coded)) {
    const float step = grid.range() / static_cast<float>((1u << grid.quantization_bits()) - 1);
    visit([&] {
      for (size_t k = 0; k < in.size(); ++k)
        out[k] = static_cast<float>(in[k]) * step + grid.min_value(static_cast<int>(k));
    });
  }
}

}  // namespace

void keep_integers(draco::Decoder& decoder) {
  for (int type = 0; type < draco::GeometryAttribute::NAMED_ATTRIBUTES_COUNT; ++type)
    decoder.SetSkipAttributeTransform(static_cast<draco::GeometryAttribute::Type>(type));
}

draco::StatusOr<std::unique_ptr<draco::Mesh>> decode_unfused(std::span<const uint8_t> stream,
                                                             bool keep_quantized) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  if (keep_quantized) keep_integers(decoder);
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!kLibdracoFuses || keep_quantized || !decoded.ok()) return decoded;
  const auto coded = decode_unfused(stream, /*keep_quantized=*/true);
  if (!coded.ok()) return coded.status();
  set_unfused_values(*coded.value(), *decoded.value());
  return decoded;
}

void set_unfused_values(const draco::PointCloud& coded, draco::PointCloud& decoded) {
  for (int32_t i = 0; i < coded.num_attributes(); ++i) {
    draco::PointAttribute& attribute = *decoded.attribute(i);
    for_each_value(*coded.attribute(i), [&](draco::AttributeValueIndex index, const float* value) {
      if (index.value() < attribute.size()) attribute.SetAttributeValue(index, value);
    });
  }
}

}  // namespace psplit
