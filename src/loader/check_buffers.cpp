#include "src/loader/check_buffers.h"

namespace psplit {

Expected<PrimitiveBuffers> check_buffers(std::span<const NamedSize> attributes, const PrimitiveBuffers& out,
                                         uint32_t point_count, uint32_t face_count) {
  if (out.index_bytes != 2 && out.index_bytes != 4)
    return wrong_usage("indices of " + std::to_string(out.index_bytes) + " bytes");
  if (out.index_bytes == 2 && point_count > kMost16BitPoints)
    return wrong_usage(std::to_string(point_count) + " points are too many for indices of 2 bytes");
  if (out.indices.size() / out.index_bytes / 3 < face_count)
    return wrong_usage("the buffer of indices has no room for " + std::to_string(face_count) + " faces");
  if (reinterpret_cast<uintptr_t>(out.indices.data()) % out.index_bytes != 0)
    return wrong_usage("the buffer of indices is not aligned");
  if (out.attributes.size() != attributes.size())
    return wrong_usage(std::to_string(out.attributes.size()) + " buffers for " +
                       std::to_string(attributes.size()) + " attributes");
  PrimitiveBuffers checked = out;
  for (size_t k = 0; k < attributes.size(); ++k) {
    const auto& [name, size] = attributes[k];
    auto& [bytes, stride] = checked.attributes[k];
    const size_t given = bytes.size();
    if (stride == 0) stride = size;
    if (stride < size) return wrong_usage("the stride of " + name + " is less than its size");
    if (point_count > 0 && (given < size || (given - size) / stride < point_count - 1))
      return wrong_usage("the buffer of " + name + " has no room for " + std::to_string(point_count) +
                         " points");
  }
  return checked;
}

}  // namespace psplit
