// Which features of the bitstream a Draco mesh stream uses. Found by a walk over its sections with parts of
// libdraco.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace psplit {

// The numbers come from the bitstream (draco/compression/config/compression_shared.h), or are -1 if the stream
// does not have the field.
struct AttributeFeatures {
  uint32_t unique_id = 0;
  int type = -1;
  int data_type = -1;
  int component_count = 0;
  int data_id = -1;    // its attribute connectivity; -1: that of positions
  int element = -1;    // 0: per vertex; 1: per corner, so that its connectivity has seams
  int traversal = -1;  // 0 depth first, 1 by prediction degree
  int coder = -1;      // 0 raw bytes, 1 integers, 2 quantized, 3 octahedral normals
  int scheme = -1;     // -2 if values are not predicted
  int transform = -1;
  int symbols = -1;       // 0 tagged, 1 raw
  int symbol_bits = -1;   // for raw symbols; determines the precision of their probabilities
  int stored_bytes = -1;  // bytes of each value that is not entropy coded
  int bits = -1;          // quantization bits
};

struct StreamFeatures {
  bool metadata = false;
  bool edgebreaker = false;
  uint32_t face_count = 0;
  // Edgebreaker.
  int connectivity = -1;  // 0 standard, 2 valence
  uint32_t split_symbol_count = 0, split_event_count = 0;
  int attribute_data_count = -1;
  std::array<int, 6> context_symbols = {-1, -1, -1, -1, -1, -1};  // for valences 2 to 7: 0 tagged, 1 raw
  // Sequential.
  int index_coding = -1;   // 0 compressed, 1 raw
  int index_symbols = -1;  // for compressed indices: 0 tagged, 1 raw
  int index_bytes = -1;    // for raw indices; 0: varints
  std::vector<AttributeFeatures> attributes;
};

// Nothing if libdraco cannot decode the stream, or if the walk does not end at its last byte.
std::optional<StreamFeatures> read_features(std::span<const uint8_t> stream);

}  // namespace psplit
