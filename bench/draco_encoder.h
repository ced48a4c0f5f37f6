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
    draco::Encoder encoder = encoder_at(speed);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    draco::EncoderBuffer bytes;
    return size_of(encoder.EncodeMeshToBuffer(*mesh_, &bytes), bytes);
  }
  // Encodes its points as a point cloud, with the same bits.
  Expected<size_t> encode_points(int speed) const {
    draco::EncoderBuffer bytes;
    return size_of(encoder_at(speed).EncodePointCloudToBuffer(*mesh_, &bytes), bytes);
  }

 private:
  static draco::Encoder encoder_at(int speed) {
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 10);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
    return encoder;
  }
  static Expected<size_t> size_of(const draco::Status& status, const draco::EncoderBuffer& bytes) {
    if (!status.ok()) return unsupported(status.error_msg_string());
    return bytes.size();
  }

  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace psplit
