// libdraco's Edgebreaker decoder with times for connectivity and for attributes.
#pragma once

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>

#include <cstdint>
#include <span>

#include "src/stopwatch.h"

namespace psplit {

struct DracoTimes {
  double connectivity_ms = 0;  // including seams and points
  double attributes_ms = 0;    // traversal to values
};

class DracoStages : public draco::MeshEdgebreakerDecoder {
 public:
  explicit DracoStages(DracoTimes& times) : times_(times) {}

  // Returns false if libdraco fails.
  bool decode(std::span<const uint8_t> stream, draco::Mesh& mesh) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
    return Decode(draco::DecoderOptions(), &buffer, &mesh).ok();
  }

 protected:
  bool DecodeConnectivity() override {
    const ScopedStopwatch watch(times_.connectivity_ms);
    return MeshEdgebreakerDecoder::DecodeConnectivity();
  }
  bool DecodePointAttributes() override {
    const ScopedStopwatch watch(times_.attributes_ms);
    return MeshEdgebreakerDecoder::DecodePointAttributes();
  }

 private:
  DracoTimes& times_;
};

}  // namespace psplit
