// The functions of the C and C++ libraries that the module needs. The libraries themselves would bring in
// files, and with them imports.
#include <charconv>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <unordered_map>

// The compiler must not turn these loops into calls of themselves.
#define PSPLIT_NO_BUILTIN [[clang::no_builtin]]

extern "C" {

// These become instructions of WebAssembly.
void* memcpy(void* to, const void* from, size_t count) { return __builtin_memcpy(to, from, count); }
void* memmove(void* to, const void* from, size_t count) { return __builtin_memmove(to, from, count); }
void* memset(void* to, int value, size_t count) { return __builtin_memset(to, value, count); }

PSPLIT_NO_BUILTIN int memcmp(const void* a, const void* b, size_t count) {
  const auto* left = static_cast<const uint8_t*>(a);
  const auto* right = static_cast<const uint8_t*>(b);
  for (size_t i = 0; i < count; ++i)
    if (left[i] != right[i]) return left[i] - right[i];
  return 0;
}
PSPLIT_NO_BUILTIN size_t strlen(const char* text) {
  size_t length = 0;
  while (text[length] != 0) ++length;
  return length;
}
_Noreturn void abort() { __builtin_trap(); }

// Static objects live as long as the instance.
int __cxa_atexit(void (*)(void*), void*, void*) { return 0; }

}  // extern "C"

// The functions of shared_ptr that libc++ 14 compiles into its library, which is not linked here.
std::__shared_count::~__shared_count() = default;
std::__shared_weak_count::~__shared_weak_count() = default;
void std::__shared_weak_count::__release_weak() noexcept {
  if (__shared_weak_owners_-- == 0) __on_zero_shared_weak();
}
const void* std::__shared_weak_count::__get_deleter(const std::type_info&) const noexcept { return nullptr; }

std::string std::to_string(unsigned value) {
  char digits[10];
  char* at = digits + sizeof digits;
  do *--at = static_cast<char>('0' + value % 10);
  while ((value /= 10) != 0);
  return {at, digits + sizeof digits};
}
std::string std::to_string(unsigned long value) { return to_string(static_cast<unsigned>(value)); }
// Of counts, which have no more than 32 bits here.
std::string std::to_string(unsigned long long value) { return to_string(static_cast<unsigned>(value)); }
std::string std::to_string(int value) {
  return value < 0 ? "-" + std::to_string(0u - static_cast<unsigned>(value))
                   : std::to_string(static_cast<unsigned>(value));
}
std::string std::to_string(long long value) { return to_string(static_cast<int>(value)); }

// A module has no clock: its caller measures.
std::chrono::steady_clock::time_point std::chrono::steady_clock::now() noexcept { return {}; }

// The number of buckets of a hash table: a prime, and at least `least`.
size_t std::__next_prime(size_t least) {
  const auto is_prime = [](size_t number) {
    for (size_t divisor = 2; divisor <= number / divisor; ++divisor)
      if (number % divisor == 0) return false;
    return number > 1;
  };
  while (!is_prime(least)) ++least;
  return least;
}

// Messages need only positive numbers with up to 9 digits, without an exponent above 1e-5 and below 1e9.
std::to_chars_result std::to_chars(char* first, char*, double value, std::chars_format, int precision) {
  const auto put = [&](const char* text) {
    while (*text != 0) *first++ = *text++;
  };
  if (!(value > 0 && value < 1e300))
    return put(value == 0 ? "0" : "not a number"), std::to_chars_result{first, {}};
  int exponent = 0;
  for (; value >= 10; value /= 10) ++exponent;
  for (; value < 1; value *= 10) --exponent;
  unsigned unit = 1;
  for (int i = 1; i < precision; ++i) unit *= 10;
  auto digits = static_cast<unsigned>(value * unit + 0.5);
  if (digits >= 10 * unit) digits /= 10, ++exponent;
  while (digits % 10 == 0 && unit > 1) digits /= 10, unit /= 10;
  const bool is_plain = exponent > -5 && exponent < 9;
  if (is_plain && exponent < 0) {
    put("0.");
    for (int i = exponent + 1; i < 0; ++i) put("0");
  }
  for (int place = is_plain ? exponent : 0; unit > 0 || (is_plain && place >= 0); --place) {
    if (place == -1 && !(is_plain && exponent < 0)) put(".");
    *first++ = static_cast<char>('0' + (unit > 0 ? digits / unit % 10 : 0));
    unit /= 10;
  }
  if (!is_plain) {
    put(exponent < 0 ? "e-" : "e");
    put(std::to_string(exponent < 0 ? -exponent : exponent).c_str());
  }
  return {first, {}};
}
