// A view of consecutive elements, like std::span. Public headers have it, because they are C++17, and because
// std::span would be a part of the names that a library exports. std::span converts to it, and it to std::span.
#pragma once

#include <cstddef>
#include <iterator>
#include <type_traits>

#if __cplusplus > 201703L && __has_include(<ranges>)
#include <ranges>
#endif

namespace psplit {

// Owns nothing: the elements must outlive it. Cheap to copy.
template <typename T>
class Span {
 public:
  using element_type = T;
  using value_type = std::remove_cv_t<T>;
  using iterator = T*;

  constexpr Span() = default;
  constexpr Span(T* data, size_t size) : data_(data), size_(size) {}
  // From an array, or from anything else that has data() and size().
  template <
      typename Values, typename Element = std::remove_pointer_t<decltype(std::data(std::declval<Values&>()))>,
      typename = std::enable_if_t<std::is_convertible_v<Element (*)[], T (*)[]> &&
                                  !std::is_same_v<std::remove_cv_t<std::remove_reference_t<Values>>, Span>>>
  constexpr Span(Values&& values)  // NOLINT: implicit
      : data_(std::data(values)), size_(std::size(values)) {}

  constexpr T* data() const { return data_; }
  constexpr size_t size() const { return size_; }
  constexpr size_t size_bytes() const { return size_ * sizeof(T); }
  constexpr bool empty() const { return size_ == 0; }
  constexpr T* begin() const { return data_; }
  constexpr T* end() const { return data_ + size_; }
  constexpr T& operator[](size_t i) const { return data_[i]; }
  constexpr T& front() const { return data_[0]; }
  constexpr T& back() const { return data_[size_ - 1]; }
  // `count` and `offset` are at most size().
  constexpr Span first(size_t count) const { return {data_, count}; }
  constexpr Span last(size_t count) const { return {data_ + (size_ - count), count}; }
  constexpr Span subspan(size_t offset) const { return {data_ + offset, size_ - offset}; }
  constexpr Span subspan(size_t offset, size_t count) const { return {data_ + offset, count}; }

 private:
  T* data_ = nullptr;
  size_t size_ = 0;
};
template <typename Values>
Span(Values&&) -> Span<std::remove_pointer_t<decltype(std::data(std::declval<Values&>()))>>;
template <typename T>
Span(T*, size_t) -> Span<T>;

}  // namespace psplit

#if defined(__cpp_lib_ranges)
template <typename T>
inline constexpr bool std::ranges::enable_borrowed_range<psplit::Span<T>> = true;
template <typename T>
inline constexpr bool std::ranges::enable_view<psplit::Span<T>> = true;
#endif
