#include "bindings/web/src/heap.h"

#include <cstdint>
#include <new>

#include "src/core/platform.h"

// The first byte after the static data. The linker defines its address.
extern "C" uint8_t __heap_base;

namespace psplit::web {
namespace {

// Blocks follow each other. Each begins with its size and the size of the block before it, so that a free block
// finds its neighbours. Free blocks of about one size are in a list. No two free blocks are neighbours.
struct Block {
  uint32_t bytes;         // with this header; a multiple of kUnit, and 1 more if the block is in use
  uint32_t bytes_before;  // of the block before it; 0 for the first
  // The content begins here. Free blocks have their neighbours in the list instead.
  Block* next;
  Block* previous;

  bool in_use() const { return (bytes & 1) != 0; }
  uint32_t size() const { return bytes & ~uint32_t{1}; }
};

constexpr uint32_t kUnit = 16, kHeader = 2 * sizeof(uint32_t), kPage = 65536;
constexpr uint32_t kLists = 32;
constexpr uint64_t kMost = uint64_t{1} << 32;

Block* lists[kLists];        // list n has the free blocks of 2^n to 2^(n + 1) - 1 bytes
uint32_t lists_with_blocks;  // a bit for each list
// The heap ends with a block of a header alone, which is in use.
Block* end;

Block* after(Block* block) {
  return reinterpret_cast<Block*>(reinterpret_cast<uint8_t*>(block) + block->size());
}
Block* before(Block* block) {
  return reinterpret_cast<Block*>(reinterpret_cast<uint8_t*>(block) - block->bytes_before);
}

void put(Block* block) {
  const uint32_t list = core::floor_log2(block->bytes);
  block->previous = nullptr;
  block->next = lists[list];
  if (block->next != nullptr) block->next->previous = block;
  lists[list] = block;
  lists_with_blocks |= 1u << list;
}
void take(Block* block) {
  const uint32_t list = core::floor_log2(block->bytes);
  (block->previous != nullptr ? block->previous->next : lists[list]) = block->next;
  if (block->next != nullptr) block->next->previous = block->previous;
  if (lists[list] == nullptr) lists_with_blocks &= ~(1u << list);
}

// Makes a free block, joined with free neighbours, and returns it. It is in no list.
Block* free_block(Block* block, uint32_t bytes) {
  block->bytes = bytes;
  if (Block* const behind = after(block); !behind->in_use()) {
    take(behind);
    block->bytes += behind->bytes;
  }
  if (block->bytes_before != 0 && !before(block)->in_use()) {
    Block* const front = before(block);
    take(front);
    front->bytes += block->bytes;
    block = front;
  }
  after(block)->bytes_before = block->bytes;
  return block;
}

// Returns a free block of at least `bytes` at the end, in no list; null if the memory cannot grow.
Block* grow(uint32_t bytes) {
  const uint64_t now = uint64_t{kPage} * __builtin_wasm_memory_size(0);
  if (end == nullptr) {
    // Blocks begin 8 bytes before a unit, so that their content begins with it.
    const uint32_t base =
        (reinterpret_cast<uint32_t>(&__heap_base) + kHeader + kUnit - 1) / kUnit * kUnit - kHeader;
    if (base + kUnit > now) return nullptr;  // the linker leaves more room than that
    end = reinterpret_cast<Block*>(base);
    *end = {kUnit | 1, 0, nullptr, nullptr};
  }
  if (end->bytes_before != 0 && !before(end)->in_use()) {
    Block* const last = before(end);
    if (last->bytes >= bytes) return take(last), last;
    bytes -= last->bytes;
  }
  const uint32_t start = reinterpret_cast<uint32_t>(end);
  const uint64_t wanted = uint64_t{start} + bytes + kUnit;
  uint64_t limit = now;
  if (wanted > now) {
    const uint64_t pages = (wanted - now + kPage - 1) / kPage;
    if (wanted > kMost - kPage || __builtin_wasm_memory_grow(0, static_cast<uint32_t>(pages)) == ~size_t{0})
      return nullptr;
    limit = now + pages * kPage;
  }
  Block* const block = end;
  const auto size = static_cast<uint32_t>((limit - start - kUnit) / kUnit * kUnit);
  const uint32_t bytes_before = block->bytes_before;
  end = reinterpret_cast<Block*>(start + size);
  end->bytes = kUnit | 1;
  block->bytes_before = bytes_before;
  return free_block(block, size);
}

// The bytes of a block with this content; 0 if there is no such block.
uint32_t block_bytes(size_t content_bytes) {
  if (content_bytes > kMost - kPage) return 0;
  const uint32_t wanted = static_cast<uint32_t>(content_bytes + kHeader + kUnit - 1) / kUnit * kUnit;
  return wanted < 2 * kUnit ? 2 * kUnit : wanted;
}

// Makes a block that is in no list a block of `bytes` that is in use. The rest of it is free.
void* use(Block* block, uint32_t bytes) {
  if (block == nullptr) return nullptr;
  const uint32_t rest_bytes = block->size() - bytes;
  if (rest_bytes >= 2 * kUnit) {
    block->bytes = bytes | 1;
    Block* const rest = after(block);
    rest->bytes_before = bytes;
    put(free_block(rest, rest_bytes));
  }
  block->bytes |= 1;
  return reinterpret_cast<uint8_t*>(block) + kHeader;
}
Block* block_of(void* memory) {
  auto* const block = reinterpret_cast<Block*>(static_cast<uint8_t*>(memory) - kHeader);
  if (!block->in_use()) __builtin_trap();  // released before
  return block;
}

}  // namespace

void* allocate(size_t bytes) {
  const uint32_t needed = block_bytes(bytes);
  if (needed == 0) return nullptr;
  // All blocks of a higher list are large enough. In the own list, the first block is looked at.
  const uint32_t list = core::floor_log2(needed);
  Block* block = lists[list] != nullptr && lists[list]->bytes >= needed ? lists[list] : nullptr;
  if (block == nullptr) {
    const uint32_t higher = lists_with_blocks & ~((2u << list) - 1);
    if (higher != 0) block = lists[core::trailing_zeros(higher)];
  }
  if (block != nullptr)
    take(block);
  else
    block = grow(needed);
  return use(block, needed);
}

void* allocate_last(size_t bytes) {
  const uint32_t needed = block_bytes(bytes);
  return needed == 0 ? nullptr : use(grow(needed), needed);
}

bool resize(void* memory, size_t bytes) {
  Block* const block = block_of(memory);
  const uint32_t needed = block_bytes(bytes), size = block->size();
  if (needed == 0) return false;
  if (needed > size) {
    Block* behind = after(block);
    const bool is_last = behind == end || (!behind->in_use() && after(behind) == end);
    if (is_last)
      behind = grow(needed - size);
    else if (behind->in_use() || behind->size() < needed - size)
      return false;
    else
      take(behind);
    if (behind == nullptr) return false;
    block->bytes += behind->bytes;
    after(block)->bytes_before = block->size();
  }
  use(block, needed);
  return true;
}

void release(void* memory) {
  if (memory == nullptr) return;
  Block* const block = block_of(memory);
  put(free_block(block, block->size()));
}

}  // namespace psplit::web

// Memory that is not there ends the instance: no code of psplit goes on without it.
void* operator new(size_t bytes) {
  void* const memory = psplit::web::allocate(bytes);
  if (memory == nullptr) __builtin_trap();
  return memory;
}
void* operator new[](size_t bytes) { return operator new(bytes); }
// libc++'s temporary buffers call these.
const std::nothrow_t std::nothrow{};
void* operator new(size_t bytes, const std::nothrow_t&) noexcept { return psplit::web::allocate(bytes); }
void operator delete(void* memory) noexcept { psplit::web::release(memory); }
void operator delete(void* memory, size_t) noexcept { psplit::web::release(memory); }
void operator delete[](void* memory) noexcept { psplit::web::release(memory); }
void operator delete[](void* memory, size_t) noexcept { psplit::web::release(memory); }

// For types with a larger alignment: the address of the block is just before the memory.
void* operator new(size_t bytes, std::align_val_t alignment) {
  const auto unit = static_cast<size_t>(alignment);
  const auto block = reinterpret_cast<uintptr_t>(operator new(bytes + unit + sizeof(uintptr_t)));
  const uintptr_t memory = (block + sizeof(uintptr_t) + unit - 1) / unit * unit;
  reinterpret_cast<uintptr_t*>(memory)[-1] = block;
  return reinterpret_cast<void*>(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  if (memory != nullptr) operator delete(reinterpret_cast<void*>(static_cast<uintptr_t*>(memory)[-1]));
}
