#include "tests/support/fibre.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/support/sanitizers.h"

#if defined(PSPLIT_ASAN)
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#endif
#if defined(PSPLIT_TSAN)
#include <sanitizer/tsan_interface.h>
#endif

// swapcontext asks the kernel for the signal mask at every switch, which takes nearly all of its time. The
// lanes of an emulated warp meet in 7 us with it, and in 0.3 us without it. So the usual machines have their
// own switch. PSPLIT_UCONTEXT_FIBRES disables it.
#if (defined(__x86_64__) || defined(__aarch64__)) && !defined(PSPLIT_UCONTEXT_FIBRES)
#define PSPLIT_SWITCH_STACK
// Pushes the registers that a callee must preserve, changes stacks, and pops them there.
extern "C" void psplit_switch_stack(void** from, void* to) asm("psplit_switch_stack");
#if defined(__ELF__)
#define PSPLIT_BEGIN ".pushsection .text\n.hidden psplit_switch_stack\n.type psplit_switch_stack, %function\n"
#define PSPLIT_END ".size psplit_switch_stack, . - psplit_switch_stack\n.popsection\n"
#else
#define PSPLIT_BEGIN ".text\n.private_extern psplit_switch_stack\n"
#define PSPLIT_END ""
#endif
asm(PSPLIT_BEGIN R"(
.globl psplit_switch_stack
.p2align 4
psplit_switch_stack:
)"
#if defined(__x86_64__)
                 R"(
  pushq %rbp
  pushq %rbx
  pushq %r12
  pushq %r13
  pushq %r14
  pushq %r15
  movq %rsp, (%rdi)
  movq %rsi, %rsp
  popq %r15
  popq %r14
  popq %r13
  popq %r12
  popq %rbx
  popq %rbp
  ret
)"
#else
                 R"(
  stp x19, x20, [sp, #-160]!
  stp x21, x22, [sp, #16]
  stp x23, x24, [sp, #32]
  stp x25, x26, [sp, #48]
  stp x27, x28, [sp, #64]
  stp x29, x30, [sp, #80]
  stp d8, d9, [sp, #96]
  stp d10, d11, [sp, #112]
  stp d12, d13, [sp, #128]
  stp d14, d15, [sp, #144]
  mov x9, sp
  str x9, [x0]
  mov sp, x1
  ldp d14, d15, [sp, #144]
  ldp d12, d13, [sp, #128]
  ldp d10, d11, [sp, #112]
  ldp d8, d9, [sp, #96]
  ldp x29, x30, [sp, #80]
  ldp x27, x28, [sp, #64]
  ldp x25, x26, [sp, #48]
  ldp x23, x24, [sp, #32]
  ldp x21, x22, [sp, #16]
  ldp x19, x20, [sp], #160
  ret
)"
#endif
    PSPLIT_END);
#else
#include <ucontext.h>
#endif

namespace psplit {

struct Fibre::State {
  void (*body)(void*) = nullptr;
  void* argument = nullptr;
  uint8_t* memory = nullptr;  // the guard page, then the stack
  size_t memory_bytes = 0;
  // The stack. For a thread, the fibre that is switched to finds it.
  const void* stack = nullptr;
  size_t stack_bytes = 0;
#if defined(PSPLIT_SWITCH_STACK)
  void* stack_pointer = nullptr;
#else
  ucontext_t context;
#endif
#if defined(PSPLIT_ASAN)
  void* fake_stack = nullptr;
#endif
#if defined(PSPLIT_TSAN)
  void* tsan_fiber = nullptr;
#endif
};

namespace {

// The last switch on this thread.
thread_local Fibre* switched_from = nullptr;
thread_local Fibre* switched_to = nullptr;

// The words on a stack that does not run, and the one with the address that psplit_switch_stack returns to.
#if defined(__x86_64__)
// The last word is the return address of enter(), which does not return. It aligns the stack as at a call.
constexpr size_t kSavedWords = 8, kReturnWord = 6;
#else
constexpr size_t kSavedWords = 20, kReturnWord = 11;
#endif

}  // namespace

Fibre::Fibre() : state_(new State) {}

Fibre::Fibre(void (*body)(void*), void* argument, size_t stack_bytes, size_t offset_bytes) : state_(new State) {
  state_->body = body;
  state_->argument = argument;
  const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  state_->stack_bytes = (stack_bytes + offset_bytes + page - 1) / page * page;
  state_->memory_bytes = page + state_->stack_bytes;
  void* memory =
      mmap(nullptr, state_->memory_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED || mprotect(memory, page, PROT_NONE) != 0) {
    std::perror("a fibre's stack");
    std::abort();
  }
  state_->memory = static_cast<uint8_t*>(memory);
  state_->stack = state_->memory + page;
#if defined(PSPLIT_SWITCH_STACK)
  auto* const end = reinterpret_cast<void**>(state_->memory + state_->memory_bytes - offset_bytes);
  auto* const top = end - kSavedWords;
  std::fill(top, end, nullptr);
  top[kReturnWord] = reinterpret_cast<void*>(&Fibre::enter);
  state_->stack_pointer = top;
#else
  if (getcontext(&state_->context) != 0) std::abort();
  state_->context.uc_stack.ss_sp = state_->memory + page;
  state_->context.uc_stack.ss_size = state_->stack_bytes - offset_bytes;
  state_->context.uc_link = nullptr;
  makecontext(&state_->context, &Fibre::enter, 0);
  // If the address sanitizer found the bounds of the stack here, it would remove all its marks.
  state_->context.uc_stack.ss_size = 0;
#endif
#if defined(PSPLIT_TSAN)
  state_->tsan_fiber = __tsan_create_fiber(0);
#endif
}

Fibre::~Fibre() {
  if (state_->memory != nullptr) {
#if defined(PSPLIT_ASAN)
    ASAN_UNPOISON_MEMORY_REGION(state_->stack, state_->stack_bytes);
#endif
#if defined(PSPLIT_TSAN)
    __tsan_destroy_fiber(state_->tsan_fiber);
#endif
    munmap(state_->memory, state_->memory_bytes);
  }
  delete state_;
}

// The thread sanitizer would report races of the fibres for these variables.
[[gnu::no_sanitize_thread]] void Fibre::switch_from(Fibre& from) {
  if (&from == this) return;
  switched_from = &from;
  switched_to = this;
#if defined(PSPLIT_ASAN)
  __sanitizer_start_switch_fiber(&from.state_->fake_stack, state_->stack, state_->stack_bytes);
#endif
#if defined(PSPLIT_TSAN)
  if (from.state_->body == nullptr) from.state_->tsan_fiber = __tsan_get_current_fiber();
  __tsan_switch_to_fiber(state_->tsan_fiber, __tsan_switch_to_fiber_no_sync);
#endif
#if defined(PSPLIT_SWITCH_STACK)
  psplit_switch_stack(&from.state_->stack_pointer, state_->stack_pointer);
#else
  swapcontext(&from.state_->context, &state_->context);
#endif
  arrive(from);
}

void Fibre::arrive([[maybe_unused]] Fibre& fibre) {
#if defined(PSPLIT_ASAN)
  __sanitizer_finish_switch_fiber(fibre.state_->fake_stack, &switched_from->state_->stack,
                                  &switched_from->state_->stack_bytes);
#endif
}

void Fibre::enter() {
  Fibre& fibre = *switched_to;
  arrive(fibre);
  fibre.state_->body(fibre.state_->argument);
  std::abort();
}

}  // namespace psplit
