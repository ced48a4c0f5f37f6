#include "tests/support/fibre.h"

#include <windows.h>

#include <cstdio>
#include <cstdlib>

namespace psplit {

struct Fibre::State {
  void (*body)(void*) = nullptr;
  void* argument = nullptr;
  void* fiber = nullptr;  // of the system
};

namespace {

// The last switch on this thread.
thread_local Fibre* switched_to = nullptr;

}  // namespace

Fibre::Fibre() : state_(new State) {
  state_->fiber = IsThreadAFiber() ? GetCurrentFiber() : ConvertThreadToFiber(nullptr);
}

// The system places the stack.
Fibre::Fibre(void (*body)(void*), void* argument, size_t stack_bytes, size_t)
    : state_(new State{body, argument}) {
  const auto start = [](void*) { Fibre::enter(); };
  state_->fiber = CreateFiber(stack_bytes, start, nullptr);
  if (state_->fiber != nullptr) return;
  std::fprintf(stderr, "a fibre's stack: error %lu\n", GetLastError());
  std::abort();
}

Fibre::~Fibre() {
  if (state_->body != nullptr) DeleteFiber(state_->fiber);
  delete state_;
}

void Fibre::switch_from(Fibre& from) {
  if (&from == this) return;
  switched_to = this;
  SwitchToFiber(state_->fiber);
}

void Fibre::arrive(Fibre&) {}

void Fibre::enter() {
  const State& state = *switched_to->state_;
  state.body(state.argument);
  std::abort();
}

}  // namespace psplit
