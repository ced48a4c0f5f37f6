// Encodes points without faces as one Draco point cloud: the bytes that libdraco's encoder writes.
//
//   sequential_stream.h  the values in the order of points
//   kd_tree_encoder.h    the values as coordinates of a tree, which has an order of its own
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stream/attribute_plan.h"
#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// Whether libdraco's encoder makes a kD-tree of such attributes if its caller leaves it the choice: at speeds
// below 10, of integers, and of floats that are on a grid of their components.
bool becomes_tree(const Mesh& cloud, std::span<const AttributeCoding> codings, int speed);

struct EncodedCloud {
  std::vector<uint8_t> bytes;
  std::vector<uint32_t> source_point;  // for each decoded point the point of the cloud
};

// Encodes all points, also equal ones. With labels (StreamTraits) the grids are the codings', otherwise
// libdraco's for these values. Errors: kInvalidInput for no points or no attributes, and for values that fit no
// grid; kInvalidInput for floats of a tree that are exact or directions. kUnsupported for more than 4 GB; for
// signed integers of a tree that are 2^31 and more apart; for integers above 2^31 - 1 of a sequential stream,
// and without labels for integers of a range that no decoder would give back. Thread-safe.
Expected<EncodedCloud> encode_cloud(const Mesh& cloud, std::span<const AttributeCoding> codings, bool is_tree,
                                    int speed, std::span<const DracoLabel> labels = {});

// Decodes a stream of the cloud. If the stream was encoded without labels, the attributes are the cloud's, in
// the same order. Errors: kRuntimeFailure.
Expected<Mesh> decode_cloud(const Mesh& cloud, std::span<const uint8_t> stream);

}  // namespace psplit
