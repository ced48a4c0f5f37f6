#include "tests/support/default_codings.h"

#include "encoder/coding/quantization.h"

namespace psplit {

Coded default_codings(const Mesh& mesh, bool lossless) {
  Coded coded;
  for (const Attribute& attribute : mesh.attributes) {
    AttributeCoding coding;
    if (!lossless && attribute.component_type == ComponentType::kFloat32) {
      const Expected<AttributeCoding> grid = fit_grid(attribute, attribute.semantic == "POSITION" ? 14 : 12);
      if (attribute.semantic == "NORMAL") {
        coding.bits = 10;
        coding.octahedral = true;
      } else if (grid.ok()) {
        coding = *grid;
      }
    }
    coded.tolerances.push_back(coding.bits == 0    ? exact_tolerance()
                               : coding.octahedral ? octahedral_tolerance(coding.bits)
                                                   : grid_tolerance(coding.bits, coding.origin, coding.range));
    coded.codings.push_back(std::move(coding));
  }
  return coded;
}

}  // namespace psplit
