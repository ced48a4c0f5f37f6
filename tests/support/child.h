// Code of a test in a process of its own.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

namespace psplit {

// The exit code of a child, once it has ended; -1 if a signal ended it.
inline int exit_code_of(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Starts a process that calls act() and ends with what it returns.
template <typename Act>
pid_t start_child(const Act& act) {
  const pid_t child = fork();
  if (child == 0) _exit(act());
  return child;
}

template <typename Act>
int run_in_child(const Act& act) {
  return exit_code_of(start_child(act));
}

}  // namespace psplit
