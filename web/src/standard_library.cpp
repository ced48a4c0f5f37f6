// The functions of the C and C++ libraries that the module needs. The libraries themselves would bring in
// files, and with them imports.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

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

// What libc++ 14 keeps in its library of shared_ptr.
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
