// What a stream decodes to.
#pragma once

#include "src/core/value_writer.h"

namespace psplit::core {

// Its arrays are in the arena that it was decoded with, and in the bytes of the stream: both must outlive it.
template <typename Index>
struct Patch {
  uint32_t face_count = 0, point_count = 0;
  // The point at corner 4 * face + k. If no attribute has seams, the points are the vertices.
  View<Index> point_at;
  View<Index> corner_of_point;  // one of the point's corners; empty if points are vertices
  View<Group<Index>> groups;
  View<Attribute<Index>> attributes;
  Connectivity<Index> mesh;  // of an Edgebreaker stream, otherwise empty
  View<bool> on_seam;        // by vertex: whether a seam of any attribute ends there; empty without seams
  // The points of the border in walking order, if decoding the patch needed them.
  View<Index> walk;
  bool is_walked = false;

  // The first attribute of positions, if it comes before this attribute.
  PSPLIT_HD const Attribute<Index>* position_before(uint32_t attribute) const {
    for (uint32_t i = 0; i < attribute; ++i)
      if (attributes[i].semantic == Attribute<Index>::kPosition) return &attributes[i];
    return nullptr;
  }

  // Writes an attribute's values by point. ValueWriter describes `type`, kAligned and `place_of`. Not
  // collective: each lane writes its points.
  template <bool kAligned = false, Lanes L, typename PlaceOf>
  PSPLIT_HD void write_values(L lanes, const Attribute<Index>& attribute, DataType type,
                              PlaceOf place_of) const {
    const ValueWriter<Index> writer(attribute, type);
    const Group<Index>& group = groups[attribute.group];
    const bool is_raw = attribute.coding == Coding::kRaw;
    if (!PSPLIT_IS_SMALL_CODE && corner_of_point.empty() && !is_raw)
      return writer.template write<kAligned>(
          lanes, point_count, [](uint32_t point) { return point; }, place_of);
    writer.template write<kAligned>(
        lanes, point_count,
        [&](uint32_t point) -> uint32_t {
          const uint32_t vertex =
              corner_of_point.empty() ? point : group.table.table.vertex[corner_of_point[point]];
          return is_raw ? group.sequence.rank[vertex] : vertex;
        },
        place_of);
  }
  template <typename PlaceOf>
  PSPLIT_HD void write_values(const Attribute<Index>& attribute, PlaceOf place_of) const {
    write_values(SerialLanes(), attribute, attribute.type, place_of);
  }
  // Like write_values, for an attribute that is not kRaw. vertices[point] is the point's vertex in the
  // attribute's table: several attributes of a group are written faster if these are found once.
  template <typename PlaceOf>
  PSPLIT_HD void write_values_of(View<const Index> vertices, const Attribute<Index>& attribute,
                                 PlaceOf place_of) const {
    ValueWriter<Index>(attribute, attribute.type)
        .template write<false>(
            SerialLanes(), point_count, [vertices](uint32_t point) { return vertices[point]; }, place_of);
  }
  // One value after another, the first one at `out`.
  PSPLIT_HD void write_all_values_of(View<const Index> vertices, const Attribute<Index>& attribute,
                                     uint8_t* out) const {
    ValueWriter<Index>(attribute, attribute.type)
        .write_all(
            point_count, [vertices](uint32_t point) { return vertices[point]; }, out);
  }
};

}  // namespace psplit::core
