// Checks that a container holds the mesh that it was made from: the meaning of
// tools/gltf_psplit/diff/compare_assets.h, by the same bounds and distances (encoder/coding/quantization.h),
// for a mesh whose points have known partners.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

// `decoded` is the decoded container, and `source_point` names the input point of each of its points. Checks
// that `source_point` is a bijection onto the points of `mesh`; that the faces are the same under it, with the
// same orientation; that exact attributes have the same bits; and that quantized ones differ by at most half a
// step of their grid. The last `foreign_count` points of `source_point` are points without values: faces of
// `decoded` name them, but another part of the container has them. With `has_copies`, several points of
// `decoded` may be the same point of `mesh`.
//
// Raises `position_error` to the largest distance between a position of `mesh` and the decoded position, if
// positions are three floats, and otherwise to 0. Errors: kRuntimeFailure.
Status verify_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings, const Mesh& decoded,
                   std::span<const uint32_t> source_point, uint32_t foreign_count, bool has_copies,
                   const ThreadPool& pool, std::optional<double>& position_error);

// Checks that a container of condensed streams decodes to `decoded`, bit for bit. Errors: kRuntimeFailure.
Status verify_condensed(std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
                        const Mesh& decoded, const ThreadPool& pool);

}  // namespace psplit
