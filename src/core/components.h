// The components of one value, for arithmetic on all of them at once. Sums wrap around.
#pragma once

#include "src/core/integer_vectors.h"

namespace psplit::core {

// The distance from one value to the next in an array. Three components take four places, so that one vector
// register loads and stores a value: a load that spans two earlier stores would wait for both.
PSPLIT_HD constexpr uint32_t value_stride(uint32_t components) { return components == 3 ? 4 : components; }

// The signed number that a symbol stands for: 0, -1, 1, -2, 2 ... for 0, 1, 2, 3, 4 ...
PSPLIT_HD constexpr uint32_t signed_of_symbol(uint32_t symbol) { return symbol >> 1 ^ (0 - (symbol & 1)); }

template <uint32_t kCount>
class Components {
 public:
  Components() = default;
  PSPLIT_HD explicit Components(int32_t all) {
    for (int32_t& value : values_) value = all;
  }
  PSPLIT_HD Components(uint32_t x, uint32_t y, uint32_t z, uint32_t w) requires(kCount == 4)
      : values_{static_cast<int32_t>(x), static_cast<int32_t>(y), static_cast<int32_t>(z),
                static_cast<int32_t>(w)} {}
  PSPLIT_HD explicit Components(const int32_t* from) {
    for (uint32_t k = 0; k < kCount; ++k) values_[k] = from[k];
  }
  PSPLIT_HD void store(int32_t* to) const {
    for (uint32_t k = 0; k < kCount; ++k) to[k] = values_[k];
  }

  PSPLIT_HD friend Components operator+(Components a, Components b) {
    for (uint32_t k = 0; k < kCount; ++k) a.values_[k] = wrapping_add(a.values_[k], b.values_[k]);
    return a;
  }
  PSPLIT_HD friend Components operator-(Components a, Components b) {
    for (uint32_t k = 0; k < kCount; ++k) a.values_[k] = wrapping_sub(a.values_[k], b.values_[k]);
    return a;
  }
  // Rounds toward zero. `count` is positive.
  PSPLIT_HD friend Components operator/(Components sum, int32_t count) {
    for (int32_t& value : sum.values_) value /= count;
    return sum;
  }

  PSPLIT_HD Components times(int32_t factor) const {
    Components out;
    for (uint32_t k = 0; k < kCount; ++k)
      out.values_[k] = static_cast<int32_t>(static_cast<uint32_t>(values_[k]) * static_cast<uint32_t>(factor));
    return out;
  }

  // Each component divided by 1 << bits, rounded down.
  PSPLIT_HD Components shifted(uint32_t bits) const {
    Components out;
    for (uint32_t k = 0; k < kCount; ++k) out.values_[k] = values_[k] >> bits;
    return out;
  }
  // The signed numbers that symbols stand for (signed_of_symbol).
  PSPLIT_HD Components signed_of_symbols() const {
    Components out;
    for (uint32_t k = 0; k < kCount; ++k) {
      const auto symbol = static_cast<uint32_t>(values_[k]);
      out.values_[k] = static_cast<int32_t>(symbol >> 1 ^ (0 - (symbol & 1)));
    }
    return out;
  }

  PSPLIT_HD int32_t& operator[](uint32_t k) { return values_[k]; }

 private:
  int32_t values_[kCount];
};

// Three or four components in one vector register, if the compiler has vectors. Of three, the fourth number
// means nothing. PSPLIT_WITHOUT_VECTORS: as for a compiler that has none, but GCC's functions.
#if defined(PSPLIT_HAS_BUILTINS) && !PSPLIT_MOVES_ROWS && !defined(PSPLIT_WITHOUT_VECTORS)
#define PSPLIT_HAS_VECTORS 1
template <uint32_t kCount>
requires(kCount == 3 || kCount == 4) class Components<kCount> {
  using Lanes = uint32_t __attribute__((vector_size(16)));
  using Signed = int32_t __attribute__((vector_size(16)));
  using Half = int32_t __attribute__((vector_size(8)));
  using Doubles = double __attribute__((vector_size(16)));

 public:
  Components() = default;
  explicit Components(int32_t all) : Components(spread(static_cast<uint32_t>(all))) {}
  Components(uint32_t x, uint32_t y, uint32_t z, uint32_t w) : lanes_{x, y, z, w} {}
  explicit Components(const int32_t* from) { copy_bytes(&lanes_, from, sizeof lanes_); }
  void store(int32_t* to) const { copy_bytes(to, &lanes_, sizeof lanes_); }

  friend Components operator+(Components a, Components b) { return Components(a.lanes_ + b.lanes_); }
  friend Components operator-(Components a, Components b) { return Components(a.lanes_ - b.lanes_); }
  friend Components operator/(Components sum, int32_t count) {
    return Components(reinterpret_cast<Lanes>(reinterpret_cast<Signed>(sum.lanes_) / count));
  }
  Components times(int32_t factor) const { return Components(lanes_ * spread(static_cast<uint32_t>(factor))); }
  Components shifted(uint32_t bits) const {
    return Components(reinterpret_cast<Lanes>(reinterpret_cast<Signed>(lanes_) >> static_cast<int32_t>(bits)));
  }
  Components signed_of_symbols() const { return Components((lanes_ >> 1) ^ (0 - (lanes_ & 1))); }
  friend Components operator&(Components a, Components b) { return Components(a.lanes_ & b.lanes_); }
  // All ones in each component in which a > b.
  friend Components above(Components a, Components b) {
    return Components(
        reinterpret_cast<Lanes>(reinterpret_cast<Signed>(a.lanes_) > reinterpret_cast<Signed>(b.lanes_)));
  }
  friend Components choose(Components mask, Components a, Components b) {
    return Components((a.lanes_ & mask.lanes_) | (b.lanes_ & ~mask.lanes_));
  }
  // Equals *this / count for a count from 1 to 4, but without divisions. The half that is added before the
  // product never reaches the next integer, and is far more than what a double rounds off.
  Components mean_of(uint32_t count) const {
    constexpr double kReciprocal[] = {0, 1, 1.0 / 2, 1.0 / 3, 1.0 / 4};
    const auto value = reinterpret_cast<Signed>(lanes_);
    const Half low = rounded(__builtin_shufflevector(value, value, 0, 1), kReciprocal[count]),
               high = rounded(__builtin_shufflevector(value, value, 2, 3), kReciprocal[count]);
    return Components(reinterpret_cast<Lanes>(__builtin_shufflevector(low, high, 0, 1, 2, 3)));
  }

 private:
  explicit Components(Lanes lanes) : lanes_(lanes) {}
  static Lanes spread(uint32_t x) { return Lanes{x, x, x, x}; }
  static Half rounded(Half sum, double reciprocal) {
    const auto value = __builtin_convertvector(sum, Doubles);
    const Doubles half{__builtin_copysign(0.5, value[0]), __builtin_copysign(0.5, value[1])};
    return __builtin_convertvector((value + half) * reciprocal, Half);
  }
  Lanes lanes_{};
};
#endif

}  // namespace psplit::core
