#include "system/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <mutex>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include "system/io_error.h"
#include "system/pipe_lines.h"

extern char** environ;

namespace psplit {
namespace {

// The handler writes into this pipe, so that `poll` wakes up. Set while a StopSignals exists.
std::atomic<int> stop_descriptor = -1;
std::array<int, 2> stop_pipe = {-1, -1};
std::atomic<bool> stop_seen = false;
struct sigaction before_term, before_int;

void note_stop(int) {
  const int saved = errno;
  stop_seen = true;
  if (const int descriptor = stop_descriptor; descriptor >= 0) {
    const ssize_t ignored = ::write(descriptor, "x", 1);
    static_cast<void>(ignored);
  }
  errno = saved;
}

void set_handler(int signal, void (*handler)(int), struct sigaction* before = nullptr) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  ::sigaction(signal, &action, before);
}

// A pipe whose ends commands do not inherit.
bool make_pipe(std::array<int, 2>& ends) {
  if (::pipe(ends.data()) != 0) return false;
  for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  return true;
}

bool write_whole(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) text.remove_prefix(static_cast<size_t>(written));
  }
  return true;
}

// The process gets the signal if the thread that started it ends, also by a signal.
void signal_at_end_of(pid_t parent, int signal) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, signal);
  if (::getppid() != parent) ::_exit(1);  // the parent has ended already
#else
  static_cast<void>(parent);
  static_cast<void>(signal);
#endif
}

// Kills this process group once all writers of the pipe are closed. It is a shell, so that a kill of all
// processes of this name leaves it.
void start_watcher(const std::array<int, 2>& lifeline) {
  if (::fork() != 0) return;
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) set_handler(signal, SIG_IGN);
  ::dup2(lifeline[0], STDIN_FILENO);
  ::execl("/bin/sh", "sh", "-c", "read -r _; kill -9 0", nullptr);
  ::_exit(127);
}

// Process 1 of a container becomes the parent of all processes whose parents have ended. It has to wait for
// them, or they would stay as zombies.
void reap_orphans(pid_t child) {
  while (::getpid() == 1) {
    siginfo_t info{};
    if (::waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) != 0) return;
    if (info.si_pid == 0 || info.si_pid == child) return;
    ::waitpid(info.si_pid, nullptr, 0);
  }
}

ProcessEnd wait_for(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFSIGNALED(status) ? ProcessEnd{true, WTERMSIG(status)} : ProcessEnd{false, WEXITSTATUS(status)};
}

// Reads once. False at the end, or after an error.
bool read_some(int descriptor, PipeLines& lines) {
  std::array<char, 1 << 16> block;
  ssize_t got = 0;
  while ((got = ::read(descriptor, block.data(), block.size())) < 0 && errno == EINTR) {
  }
  if (got > 0) lines.add({block.data(), static_cast<size_t>(got)});
  return got > 0;
}

// Passes what a command prints on to stderr until it ends. A process that it left in the background may hold
// the pipe for longer, and print on.
ProcessEnd pass_on(int output, pid_t process, LastLines& last_lines) {
  constexpr int kPatienceMs = 100, kBlocksOfPipe = 16;
  ::fcntl(output, F_SETFL, O_NONBLOCK);
  bool has_ended = false;
  for (int blocks_after_end = 0; blocks_after_end < kBlocksOfPipe; blocks_after_end += has_ended ? 1 : 0) {
    std::array<char, 1 << 12> block;
    const ssize_t got = ::read(output, block.data(), block.size());
    if (got > 0) {
      const std::string_view text(block.data(), static_cast<size_t>(got));
      write_whole(STDERR_FILENO, text);
      last_lines.add(text);
      continue;
    }
    const bool is_empty = got < 0 && (errno == EAGAIN || errno == EINTR);
    if (!is_empty || has_ended) break;
    pollfd source{output, POLLIN, 0};
    ::poll(&source, 1, kPatienceMs);
    siginfo_t info{};
    const auto id = static_cast<id_t>(process);
    has_ended = ::waitid(P_PID, id, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
  }
  return wait_for(process);
}

class PipeToParent : public ParentLink {
 public:
  PipeToParent(int requests, int answers) : requests_(requests), answers_(answers) {}
  std::optional<std::string> receive() override {
    const std::lock_guard lock(receiving_);
    for (;;) {
      if (std::optional<std::string> line = lines_.next()) return line;
      if (!read_some(requests_, lines_)) return std::nullopt;
    }
  }
  void send(const std::string& line) override {
    const std::lock_guard lock(sending_);
    if (!write_whole(answers_, line + "\n")) ::_exit(1);
  }

 private:
  const int requests_, answers_;
  std::mutex receiving_, sending_;
  PipeLines lines_;
};

class ForkedChild : public ChildProcess {
 public:
  ForkedChild(pid_t process, int requests, int answers, int lifeline)
      : process_(process), requests_(requests), answers_(answers), lifeline_(lifeline) {}
  ~ForkedChild() override {
    if (process_ > 0) ForkedChild::kill();
    ForkedChild::close();
    ::close(answers_);
    ::close(lifeline_);
  }

  bool send(const std::string& line) override { return requests_ >= 0 && write_whole(requests_, line + "\n"); }

  void close() override {
    if (requests_ >= 0) ::close(requests_);
    requests_ = -1;
  }

  Received receive(Deadline deadline) override {
    Received received;
    std::array<pollfd, 2> sources{{{answers_, POLLIN, 0}, {stop_pipe[0], POLLIN, 0}}};
    int wait_ms = -1;
    if (deadline) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(*deadline - std::chrono::steady_clock::now());
      constexpr int64_t kLongest = 1 << 30;
      wait_ms = static_cast<int>(std::clamp<int64_t>(left.count(), 0, kLongest));
    }
    if (::poll(sources.data(), sources.size(), wait_ms) <= 0) return received;
    reap_orphans(process_);
    if (sources[1].revents != 0) {
      char noted = 0;
      const ssize_t ignored = ::read(stop_pipe[0], &noted, 1);
      static_cast<void>(ignored);
    }
    if (sources[0].revents != 0 && !read_some(answers_, lines_)) received.ended = true;
    while (std::optional<std::string> line = lines_.next()) received.lines.push_back(std::move(*line));
    return received;
  }

  ProcessEnd kill() override {
    if (process_ <= 0) return end_;
    ::kill(-process_, SIGKILL);
    return wait();
  }

  ProcessEnd wait() override {
    if (process_ <= 0) return end_;
    siginfo_t info;
    while (::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOWAIT) < 0 && errno == EINTR) {
    }
    ::kill(-process_, SIGKILL);  // its commands; until it is reaped, no other group has its number
    end_ = wait_for(process_);
    process_ = -1;
    return end_;
  }

 private:
  pid_t process_;
  int requests_, answers_;
  int lifeline_;  // closed when this process ends in any way
  PipeLines lines_;
  ProcessEnd end_;
};

}  // namespace

StopSignals::StopSignals() {
  stop_seen = false;
  if (make_pipe(stop_pipe)) {
    ::fcntl(stop_pipe[1], F_SETFL, O_NONBLOCK);
    stop_descriptor = stop_pipe[1];
  }
  set_handler(SIGTERM, note_stop, &before_term);
  set_handler(SIGINT, note_stop, &before_int);
}

StopSignals::~StopSignals() {
  ::sigaction(SIGTERM, &before_term, nullptr);
  ::sigaction(SIGINT, &before_int, nullptr);
  stop_descriptor = -1;
  for (int& end : stop_pipe) {
    if (end >= 0) ::close(end);
    end = -1;
  }
}

bool StopSignals::seen() const { return stop_seen; }

std::string place_of_argument(int number) { return "$" + std::to_string(number); }

// A copy by fork needs none of these.
std::unique_ptr<ParentLink> take_parent_link() { return nullptr; }
void set_child_program(const std::filesystem::path&) {}
void set_child_words(std::vector<std::string>) {}

Expected<std::unique_ptr<ChildProcess>> ChildProcess::start(const std::function<int(ParentLink&)>& work,
                                                            const std::string&) {
  std::array<int, 2> requests{-1, -1}, answers{-1, -1}, lifeline{-1, -1};
  if (!make_pipe(requests) || !make_pipe(answers) || !make_pipe(lifeline))
    return io_error("cannot make a pipe", errno);
  set_handler(SIGPIPE, SIG_IGN);  // `send` notices that the child has ended
  std::fflush(nullptr);           // or the child would write the same text again
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) return io_error("cannot start a process", errno);
  if (process == 0) {
    ::setpgid(0, 0);
    signal_at_end_of(parent, SIGKILL);
    ::close(lifeline[1]);
    start_watcher(lifeline);
    ::close(lifeline[0]);
    stop_descriptor = -1;
    set_handler(SIGTERM, SIG_IGN);  // the parent decides when this process ends
    set_handler(SIGINT, SIG_IGN);
    ::close(requests[1]);
    ::close(answers[0]);
    PipeToParent link(requests[0], answers[1]);
    const int code = work(link);
    std::fflush(nullptr);
    ::_exit(code);
  }
  ::setpgid(process, process);  // both processes do this, because either may be first
  ::close(requests[0]);
  ::close(answers[1]);
  ::close(lifeline[0]);
  return std::unique_ptr<ChildProcess>(new ForkedChild(process, requests[1], answers[0], lifeline[1]));
}

Expected<CommandEnd> run_shell(const std::string& command, const std::vector<std::string>& arguments,
                               const std::vector<std::pair<std::string, std::string>>& variables) {
  // Between fork and exec a process with threads may not allocate: everything is prepared here.
  std::vector<std::string> words{"/bin/sh", "-c", command, "sh"}, settings;
  words.insert(words.end(), arguments.begin(), arguments.end());
  for (const auto& [name, value] : variables) settings.push_back(name + "=" + value);
  for (char** setting = environ; *setting != nullptr; ++setting) settings.emplace_back(*setting);
  std::vector<char*> argv, envp;
  for (std::string& word : words) argv.push_back(word.data());
  for (std::string& setting : settings) envp.push_back(setting.data());
  argv.push_back(nullptr);
  envp.push_back(nullptr);
  std::array<int, 2> output{-1, -1};
  if (!make_pipe(output)) return io_error("cannot make a pipe", errno);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) {
    const int error = errno;
    for (const int descriptor : output) ::close(descriptor);
    return io_error("cannot start a process", error);
  }
  if (process == 0) {
    signal_at_end_of(parent, SIGKILL);
    for (const int signal : {SIGTERM, SIGINT, SIGPIPE, SIGXFSZ}) set_handler(signal, SIG_DFL);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(output[1], descriptor);
    ::execve("/bin/sh", argv.data(), envp.data());
    ::_exit(127);
  }
  ::close(output[1]);
  LastLines last_lines;
  const ProcessEnd end = pass_on(output[0], process, last_lines);
  ::close(output[0]);
  return CommandEnd{end, last_lines.joined()};
}

uint64_t peak_memory() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
  constexpr uint64_t kUnit = 1;
#else
  constexpr uint64_t kUnit = 1024;
#endif
  return static_cast<uint64_t>(usage.ru_maxrss) * kUnit;
}

uint64_t machine_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), bytes = ::sysconf(_SC_PAGESIZE);
  return pages > 0 && bytes > 0 ? static_cast<uint64_t>(pages) * static_cast<uint64_t>(bytes) : 0;
}

}  // namespace psplit
