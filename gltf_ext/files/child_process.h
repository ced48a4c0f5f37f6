// Processes: a copy of this one that works for it, commands of a shell, and the signals that ask for an end.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/status.h"

namespace psplit {

using Deadline = std::optional<std::chrono::steady_clock::time_point>;

// How a process ended: by itself with a code, or by a signal.
struct ProcessEnd {
  bool by_signal = false;
  int number = 0;  // the exit code or the signal
};

// While it exists, SIGTERM and SIGINT do not end this process; they are only noted. One at a time.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  bool seen() const;
};

// The child's side of the pipes between a process and its child. Thread-safe.
class ParentLink {
 public:
  virtual ~ParentLink() = default;
  // Waits for the parent's next line. Nothing once the parent sends no more.
  virtual std::optional<std::string> receive() = 0;
  // Sends a line, which contains no line feed. Ends the process if the parent is gone.
  virtual void send(const std::string& line) = 0;
};

// A copy of this process (fork), for work that may have to be killed. It and all commands that it runs form a
// process group, which `kill` and `wait` end. The group also ends if the parent is killed, or the parent and
// the copy at the same moment. The copy has no threads of the parent: do not start any before.
class ChildProcess {
 public:
  // The child runs `work` and exits with the code that it returns; no destructors of the parent's objects run.
  static Expected<std::unique_ptr<ChildProcess>> start(const std::function<int(ParentLink&)>& work);
  virtual ~ChildProcess() = default;  // kills the child and its commands

  // False if the child has ended.
  virtual bool send(const std::string& line) = 0;
  // The child receives no more lines.
  virtual void close() = 0;
  // The lines that the child has sent. Waits until there is one, until the child has ended (then `ended` is
  // true once all its lines were returned), until a stop signal is noted, or until the deadline.
  struct Received {
    std::vector<std::string> lines;
    bool ended = false;
  };
  virtual Received receive(Deadline deadline) = 0;
  // Kills the child if it still runs, and waits for its end.
  virtual ProcessEnd kill() = 0;
  // Waits for the end of a child that ends by itself.
  virtual ProcessEnd wait() = 0;
};

// How a command of a shell ended, and the last lines that it printed, "a | b"; empty if it printed none.
struct CommandEnd : ProcessEnd {
  std::string last_lines;
};

// Runs `/bin/sh -c command sh arguments...`: the command knows its arguments as $1, $2 ... Its stdin is empty,
// and what it prints appears on this process's stderr. `variables` are added to its environment. The command is
// killed if the calling thread ends.
Expected<CommandEnd> run_shell(const std::string& command, const std::vector<std::string>& arguments,
                               const std::vector<std::pair<std::string, std::string>>& variables = {});

// The most memory in bytes that this process has held so far.
uint64_t peak_memory();
// The memory of the machine in bytes; 0 if it is unknown.
uint64_t machine_memory();

}  // namespace psplit
