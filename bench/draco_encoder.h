// libdraco's encoder, for a mesh that it decoded.
#pragma once

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>

#include <memory>
#include <span>

#include "psplit/base.h"

namespace psplit {

class DracoEncoder {
 public:
  // Decodes the mesh.
  static Expected<DracoEncoder> of(std::span<const uint8_t> stream) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return unsupported(decoded.status().error_msg_string());
    DracoEncoder encoder;
    encoder.mesh_ = std::move(decoded).value();
    return encoder;
  }

  // Encodes it as an Edgebreaker stream with the bits of bench_codings(). Returns its bytes.
  Expected<size_t> encode(int speed) const {
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 10);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
    draco::EncoderBuffer bytes;
    const draco::Status status = encoder.EncodeMeshToBuffer(*mesh_, &bytes);
    if (!status.ok()) return unsupported(status.error_msg_string());
    return bytes.size();
  }

 private:
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace psplit
