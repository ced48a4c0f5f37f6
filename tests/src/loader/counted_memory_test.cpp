// Replaces operator new in this program to count its memory. Each block has its size in front of it.
#include "tests/src/loader/counted_memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>

namespace {

constexpr size_t kFront = alignof(std::max_align_t);
std::atomic<size_t> now = 0, peak = 0;

void* take_or_null(size_t size) noexcept {
  auto* const block = static_cast<size_t*>(std::malloc(size + kFront));
  if (block == nullptr) return nullptr;
  *block = size;
  const size_t total = now += size;
  for (size_t most = peak; most < total && !peak.compare_exchange_weak(most, total);) {
  }
  return reinterpret_cast<std::byte*>(block) + kFront;
}

void* take(size_t size) {
  void* const memory = take_or_null(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void give_back(void* memory) {
  if (memory == nullptr) return;
  auto* const block = reinterpret_cast<size_t*>(static_cast<std::byte*>(memory) - kFront);
  now -= *block;
  std::free(block);
}

}  // namespace

void* operator new(size_t size) { return take(size); }
void* operator new[](size_t size) { return take(size); }
// Sanitizers replace these operators as well, and would not free with ours.
void* operator new(size_t size, const std::nothrow_t&) noexcept { return take_or_null(size); }
void* operator new[](size_t size, const std::nothrow_t&) noexcept { return take_or_null(size); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { give_back(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { give_back(memory); }
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete[](void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, size_t) noexcept { give_back(memory); }
void operator delete[](void* memory, size_t) noexcept { give_back(memory); }

namespace psplit {

CountedMemory::CountedMemory() : start_(now) { peak = start_; }
size_t CountedMemory::most() const { return peak - start_; }

namespace {

TEST(CountedMemory, CountsWhatIsTakenAndGivenBack) {
  const CountedMemory memory;
  auto first = std::make_unique<char[]>(1000);
  first.reset();
  const auto second = std::make_unique<char[]>(500);
  EXPECT_EQ(memory.most(), 1000u);
}

}  // namespace
}  // namespace psplit
