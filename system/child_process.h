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

#include "psplit/base.h"

namespace psplit {

using Deadline = std::optional<std::chrono::steady_clock::time_point>;

// How a process ended: by itself with a code, or by a signal.
struct ProcessEnd {
  bool by_signal = false;
  int number = 0;  // the exit code or the signal
};

// While it exists, SIGTERM and SIGINT (on Windows: Ctrl-C, Ctrl-Break) do not end this process; they are only
// noted. One at a time.
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

// The link of a process that ChildProcess::start made where there is no fork, or null. Its work is to be
// called, whatever the command line says. Call it once.
std::unique_ptr<ParentLink> take_parent_link();

// The program and the words that such a process is started with. Without a program, it is that of this process.
void set_child_program(const std::filesystem::path& program);
void set_child_words(std::vector<std::string> words);

// A copy of this process, for work that may have to be killed. It and all commands that it runs form a
// process group, which `kill` and `wait` end. The group also ends if the parent is killed, or the parent and
// the copy at the same moment. With fork, the copy has no threads of the parent: do not start any before. On
// Windows, the copy is the same command once more, and its processes are a job.
class ChildProcess {
 public:
  // The child runs `work` and exits with the code that it returns; no destructors of the parent's objects run.
  // A child that take_parent_link tells of its parent, because it shares no memory, first receives `greeting`.
  static Expected<std::unique_ptr<ChildProcess>> start(const std::function<int(ParentLink&)>& work,
                                                       const std::string& greeting);
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

// Runs `/bin/sh -c command sh arguments...`: the command knows its arguments as $1, $2 ... On Windows cmd.exe
// runs it, which knows up to nine: the command writes %1 or "%1", and gets the argument in one pair of quotes;
// %% is a percent sign. There an argument with a quote or a line break is kInvalidInput. Its stdin is empty,
// and what it prints appears on this process's stderr. `variables` are added to its environment. The command is
// killed if the calling thread ends.
Expected<CommandEnd> run_shell(const std::string& command, const std::vector<std::string>& arguments,
                               const std::vector<std::pair<std::string, std::string>>& variables = {});

// "$1" or "%1": how such a command names its first argument.
std::string place_of_argument(int number);

// The most memory in bytes that this process has held so far.
uint64_t peak_memory();
// The memory of the machine in bytes; 0 if it is unknown.
uint64_t machine_memory();

}  // namespace psplit
