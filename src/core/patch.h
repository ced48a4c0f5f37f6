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
    with_value_of(attribute, [&](auto value_of) {
      writer.template write<kAligned>(lanes, point_count, value_of, place_of);
    });
  }
  template <typename PlaceOf>
  PSPLIT_HD void write_values(const Attribute<Index>& attribute, PlaceOf place_of) const {
    write_values(SerialLanes(), attribute, attribute.type, place_of);
  }
  // One value after another, the first one at `out`.
  PSPLIT_HD void write_all_values(const Attribute<Index>& attribute, uint8_t* out) const {
    const ValueWriter<Index> writer(attribute, attribute.type);
    with_value_of(attribute, [&](auto value_of) { writer.write_all(point_count, value_of, out); });
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
  PSPLIT_HD void write_all_values_of(View<const Index> vertices, const Attribute<Index>& attribute,
                                     uint8_t* out) const {
    ValueWriter<Index>(attribute, attribute.type)
        .write_all(
            point_count, [vertices](uint32_t point) { return vertices[point]; }, out);
  }

 private:
  // Calls write(value_of), where value_of(point) is what ValueWriter asks for.
  template <typename Write>
  PSPLIT_HD void with_value_of(const Attribute<Index>& attribute, Write write) const {
    const Group<Index>& group = groups[attribute.group];
    const View<const Index> corner = corner_of_point, vertex = group.table.table.vertex,
                            rank = group.sequence.rank;
    const bool is_raw = attribute.coding == Coding::kRaw;
    if (!PSPLIT_IS_SMALL_CODE && !is_raw && corner.empty())
      return write([](uint32_t point) -> uint32_t { return point; });
    if (!PSPLIT_IS_SMALL_CODE && !PSPLIT_MOVES_ROWS && !is_raw)
      return write([=](uint32_t point) -> uint32_t { return vertex[corner[point]]; });
    write([=](uint32_t point) -> uint32_t {
      const uint32_t of_point = corner.empty() ? point : vertex[corner[point]];
      return is_raw ? rank[of_point] : of_point;
    });
  }
};

}  // namespace psplit::core
