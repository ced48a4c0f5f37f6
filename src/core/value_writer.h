// From integers to values of the attribute's own type, to the bit what libdraco computes: no multiply-add may
// be fused.
#pragma once

#include "src/core/attributes.h"
#include "src/core/lanes.h"
#include "src/core/octahedral.h"

namespace psplit::core {

// The origin of the grid, from its bytes in the stream. A compiler keeps it in registers: it does not lie in
// memory that writing a value could change. kComponents is 0 if their number is known only at run time.
template <uint32_t kComponents>
class GridOrigin {
 public:
  PSPLIT_HD explicit GridOrigin(const uint8_t* bytes) { copy_bytes(at_, bytes, sizeof at_); }
  PSPLIT_HD float operator[](uint32_t k) const { return at_[k]; }

 private:
  float at_[kComponents];
};
template <>
class GridOrigin<0> {
 public:
  PSPLIT_HD explicit GridOrigin(const uint8_t* bytes) : bytes_(bytes) {}
  PSPLIT_HD float operator[](uint32_t k) const {
    float at;
    copy_bytes(&at, bytes_ + 4 * k, sizeof at);
    return at;
  }

 private:
  const uint8_t* bytes_;
};

template <typename Index>
class ValueWriter {
 public:
  // `type` is the attribute's own. For a quantized attribute it may also be an integer type that is wide
  // enough: then the places on its grid are written.
  PSPLIT_HD ValueWriter(const Attribute<Index>& attribute, DataType type)
      : attribute_(attribute), type_(type), coding_(attribute.coding) {
    if (coding_ == Coding::kQuantized && type != attribute.type) coding_ = Coding::kInteger;
    if (coding_ == Coding::kQuantized) step_ = attribute.step();
    if (attribute.coding == Coding::kNormal) grid_ = OctahedralGrid(attribute.bits);
  }

  // Writes the values of points [0, count). value_of(point) is a vertex of the table, for kRaw a place in the
  // sequence. place_of(point) is where the point's value goes, or null if it is not wanted. With kAligned all
  // places are aligned for the components' type, and a component is one store on every machine.
  template <bool kAligned, Lanes L, typename ValueOf, typename PlaceOf>
  PSPLIT_HD void write(L lanes, uint32_t count, ValueOf value_of, PlaceOf place_of) const {
    const auto each = [&](auto write_one) {
      for_each_lane_item(lanes, count, [&](uint32_t point) {
        if (uint8_t* place = place_of(point); place != nullptr) write_one(value_of(point), place);
      });
    };
    switch (coding_) {
      case Coding::kRaw: return each([&](uint32_t value, uint8_t* out) { write_raw(value, out); });
      case Coding::kInteger:
        switch (data_type_bytes(type_)) {
          case 1: return with_integer_writer<kAligned, uint8_t>(each);
          case 2: return with_integer_writer<kAligned, uint16_t>(each);
          default: return each(integer_writer<kAligned, uint32_t, 0>());
        }
      case Coding::kQuantized:
        switch (attribute_.components) {
          case 2: return each(dequantizer<kAligned, 2>());
          case 3: return each(dequantizer<kAligned, 3>());
#if defined(PSPLIT_HAS_VECTORS)
          case 4: return each(dequantizer<kAligned, 4>());
#endif
          default: return each(dequantizer<kAligned, 0>());
        }
      case Coding::kNormal:
#if defined(PSPLIT_HAS_VECTORS)
        if constexpr (L::size() == 1) return write_normals(count, value_of, place_of);
#endif
        return each([&](uint32_t value, uint8_t* out) { write_normal<kAligned>(value, out); });
    }
  }

  // Writes the values one after another, the first one at `out`.
  template <typename ValueOf>
  PSPLIT_HD void write_all(uint32_t count, ValueOf value_of, uint8_t* out) const {
    const uint32_t stride = data_type_bytes(type_) * attribute_.components;
#if defined(PSPLIT_HAS_VECTORS)
    // The fourth number of a value is written as well, and then the next value in its place.
    if (coding_ == Coding::kQuantized && attribute_.components == 3 && count > 0) {
      const auto dequantize = dequantizer<false, 3, 4>();
      for (uint32_t point = 0; point + 1 < count; ++point, out += 3 * sizeof(float))
        dequantize(value_of(point), out);
      return dequantizer<false, 3>()(value_of(count - 1), out);
    }
    if (coding_ == Coding::kNormal)
      return for_normals(count, value_of, [out, count](uint32_t point, const OctahedralGrid::Floats& vector) {
        uint8_t* const place = out + size_t{point} * 3 * sizeof(float);
        if (PSPLIT_LIKELY(point + 1 < count))
          copy_bytes(place, &vector, sizeof vector);
        else
          copy_bytes(place, &vector, 3 * sizeof(float));
      });
#endif
    write<false>(SerialLanes(), count, value_of,
                 [out, stride](uint32_t point) { return out + size_t{point} * stride; });
  }

 private:
  template <bool kAligned, typename T>
  PSPLIT_HD static void store(uint8_t* out, const T& value) {
    if constexpr (kAligned) out = static_cast<uint8_t*>(PSPLIT_ASSUME_ALIGNED(out, alignof(T)));
    copy_bytes(out, &value, sizeof(T));
  }

  PSPLIT_HD void write_raw(uint32_t value, uint8_t* out) const {
    const uint32_t stride = attribute_.stride();
    for (uint32_t i = 0; i < stride; ++i) out[i] = attribute_.raw[size_t{value} * stride + i];
  }

  // Joints, weights and colours have four components. A device has one way for all numbers of components.
  template <bool kAligned, typename T, typename Each>
  PSPLIT_HD void with_integer_writer(Each each) const {
    if constexpr (!PSPLIT_MOVES_ROWS && !PSPLIT_IS_SMALL_CODE)
      if (attribute_.components == 4) return each(integer_writer<kAligned, T, 4>());
    each(integer_writer<kAligned, T, 0>());
  }
  template <bool kAligned, typename T, uint32_t kComponents>
  PSPLIT_HD auto integer_writer() const {
    return [components = kComponents != 0 ? kComponents : attribute_.components, values = attribute_.values](
               uint32_t value, uint8_t* out) {
      const int32_t* in = &values[size_t{value} * value_stride(components)];
      if constexpr (kComponents == 4) {
        struct Four {
          T at[4];
        } four;
        for (uint32_t k = 0; k < 4; ++k) four.at[k] = static_cast<T>(in[k]);
        return store<kAligned>(out, four);
      }
      for (uint32_t k = 0; k < components; ++k) store<kAligned>(out + k * sizeof(T), static_cast<T>(in[k]));
    };
  }

  // kWritten: how many numbers are written of a vector; the fourth means nothing.
  template <bool kAligned, uint32_t kComponents, uint32_t kWritten = kComponents>
  PSPLIT_HD auto dequantizer() const {
    return [components = kComponents != 0 ? kComponents : attribute_.components, step = step_,
            origin = GridOrigin<kComponents>(attribute_.origin),
            values = attribute_.values](uint32_t value, uint8_t* out) {
      const int32_t* in = &values[size_t{value} * value_stride(components)];
#if defined(PSPLIT_HAS_VECTORS)
      if constexpr (kComponents == 3 || kComponents == 4) {
        using Ints = int32_t __attribute__((vector_size(16)));
        using Floats = float __attribute__((vector_size(16)));
        Ints places;
        copy_bytes(&places, in, sizeof places);
        const Floats dequantized =
            __builtin_convertvector(places, Floats) * Floats{step, step, step, step} +
            Floats{origin[0], origin[1], origin[2], kComponents > 3 ? origin[kComponents - 1] : 0};
        copy_bytes(out, &dequantized, kWritten * sizeof(float));
        return;
      }
#endif
      for (uint32_t k = 0; k < components; ++k) {
        const float dequantized = static_cast<float>(in[k]) * step + origin[k];
        store<kAligned>(out + 4 * k, dequantized);
      }
    };
  }

  template <bool kAligned>
  PSPLIT_HD void write_normal(uint32_t value, uint8_t* out) const {
    const int32_t* in = &attribute_.values[size_t{value} * 2];
    float vector[3];
    grid_.unit_vector({in[0], in[1]}, vector);
    store<kAligned>(out, vector);
  }

#if defined(PSPLIT_HAS_VECTORS)
  // Calls put(point, vector) for each point; the vector's fourth number means nothing.
  template <typename ValueOf, typename Put>
  void for_normals(uint32_t count, ValueOf value_of, Put put) const {
    constexpr uint32_t kAtOnce = OctahedralGrid::kAtOnce;
    const int32_t* const values = attribute_.values.data();
    const OctahedralGrid grid = grid_;
    const int32_t* at[kAtOnce] = {values, values, values, values};
    for (uint32_t first = 0; first < count; first += kAtOnce) {
      OctahedralGrid::Floats vectors[kAtOnce];
      // The last group may have places of the group before it.
      const uint32_t some = count - first < kAtOnce ? count - first : kAtOnce;
      for (uint32_t k = 0; k < some; ++k) at[k] = values + size_t{value_of(first + k)} * 2;
      grid.unit_vectors(at, vectors);
      for (uint32_t k = 0; k < some; ++k) put(first + k, vectors[k]);
    }
  }
  template <typename ValueOf, typename PlaceOf>
  void write_normals(uint32_t count, ValueOf value_of, PlaceOf place_of) const {
    for_normals(count, value_of, [place_of](uint32_t point, const OctahedralGrid::Floats& vector) {
      if (uint8_t* place = place_of(point); place != nullptr) copy_bytes(place, &vector, 3 * sizeof(float));
    });
  }
#endif

  const Attribute<Index>& attribute_;
  DataType type_;
  Coding coding_;
  float step_ = 0;
  OctahedralGrid grid_;
};

}  // namespace psplit::core
