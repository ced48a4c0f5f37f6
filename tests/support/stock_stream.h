// One Draco stream of a whole mesh, by the stages of the encoder alone: nothing is checked, merged or dropped
// before.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

struct StockStream {
  std::vector<uint8_t> bytes;
  std::vector<AttributeRequest> requests;
  Mesh decoded;
  std::vector<uint32_t> source_point;
};

// A mesh that Edgebreaker cannot encode becomes a sequential stream.
Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings, int speed,
                                          bool by_libdraco = false, bool choose_by_bytes = false);
Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int speed);

}  // namespace psplit
