#include "system/child_process.h"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <span>
#include <thread>

#include "system/io_error.h"
#include "system/pipe_lines.h"
#include "system/windows/system_calls.h"

namespace psplit {
namespace {

// A child finds here the handles of its pipes: "requests,answers".
constexpr const wchar_t* kLinkVariable = L"PSPLIT_PARENT_LINK";

// Wakes up who waits for a child: it has sent something, or a stop is to be noted.
std::mutex wake_mutex;
std::condition_variable wake;
bool stop_seen = false, stop_is_new = false;

// When the handler of the end of a console or of a session returns, the system ends the process. Until then it
// waits for some seconds.
BOOL handled(DWORD event) {
  if (event != CTRL_C_EVENT && event != CTRL_BREAK_EVENT) ::Sleep(INFINITE);
  return TRUE;
}

// The system calls it in a thread of its own.
BOOL WINAPI note_stop(DWORD event) {
  {
    const std::lock_guard lock(wake_mutex);
    stop_seen = stop_is_new = true;
    wake.notify_all();
  }
  return handled(event);
}
BOOL WINAPI ignore_stop(DWORD event) { return handled(event); }

std::filesystem::path child_program;
std::vector<std::string> child_words;

struct Pipe {
  SystemHandle out, in;  // to read from, and to write into
};

// Nothing after an error. Children inherit only the handles that are named to them.
std::optional<Pipe> make_pipe() {
  HANDLE out = nullptr, in = nullptr;
  if (::CreatePipe(&out, &in, nullptr, 1 << 16) == 0) return std::nullopt;
  return Pipe{own(out), own(in)};
}

bool write_whole(HANDLE to, std::string_view text) {
  while (!text.empty()) {
    DWORD written = 0;
    if (::WriteFile(to, text.data(), static_cast<DWORD>(text.size()), &written, nullptr) == 0) return false;
    text.remove_prefix(written);
  }
  return true;
}

// Reads once, and waits for it. Empty at the end, or after an error.
std::string_view read_some(HANDLE from, std::span<char> block) {
  DWORD got = 0;
  if (::ReadFile(from, block.data(), static_cast<DWORD>(block.size()), &got, nullptr) == 0) got = 0;
  return {block.data(), got};
}

// As CommandLineToArgvW reads it.
std::wstring quoted(const std::string& word) {
  std::wstring text = L"\"";
  size_t backslashes = 0;
  for (const wchar_t c : wide(word)) {
    if (c == L'"') text.append(backslashes + 1, L'\\');
    backslashes = c == L'\\' ? backslashes + 1 : 0;
    text += c;
  }
  return text.append(backslashes, L'\\') + L"\"";
}

// The environment of this process and some variables more, as CreateProcess takes it.
std::wstring environment_with(const std::vector<std::pair<std::string, std::string>>& variables) {
  std::wstring text;
  for (const auto& [name, value] : variables) text += wide(name + "=" + value) + L'\0';
  wchar_t* const block = ::GetEnvironmentStringsW();
  for (const wchar_t* entry = block; entry != nullptr && *entry != L'\0'; entry += std::wcslen(entry) + 1)
    text += std::wstring(entry) + L'\0';
  if (block != nullptr) ::FreeEnvironmentStringsW(block);
  return text + L'\0';
}

// A process, and the job of it and of all processes that it starts. They end with the last handle of the job,
// also if this process is killed.
struct Started {
  SystemHandle process, job;
};

// Null after an error.
SystemHandle make_job() {
  SystemHandle job = own(::CreateJobObjectW(nullptr, nullptr));
  JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
  limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
  if (job == nullptr ||
      ::SetInformationJobObject(job.get(), JobObjectExtendedLimitInformation, &limits, sizeof(limits)) == 0)
    return nullptr;
  return job;
}

// A handle that a child may inherit, for as long as the object exists. Null if there is none.
class Inherited {
 public:
  explicit Inherited(HANDLE handle) {
    HANDLE copy = nullptr;
    if (handle == nullptr || handle == INVALID_HANDLE_VALUE) return;
    ::DuplicateHandle(::GetCurrentProcess(), handle, ::GetCurrentProcess(), &copy, 0, TRUE,
                      DUPLICATE_SAME_ACCESS);
    handle_ = own(copy);
  }
  HANDLE get() const { return handle_.get(); }

 private:
  SystemHandle handle_;
};

// What CreateProcess takes beside the words. It inherits the handles, and no others.
struct Start {
  std::wstring program, line, environment;
  HANDLE in = nullptr, out = nullptr, err = nullptr;
  std::vector<HANDLE> handles{};
};

Expected<Started> start_process(Start start) {
  for (const HANDLE handle : {start.in, start.out, start.err})
    if (handle != nullptr) start.handles.push_back(handle);
  std::sort(start.handles.begin(), start.handles.end());
  start.handles.erase(std::unique(start.handles.begin(), start.handles.end()), start.handles.end());
  SIZE_T bytes = 0;
  ::InitializeProcThreadAttributeList(nullptr, 1, 0, &bytes);
  std::vector<std::byte> memory(bytes);
  STARTUPINFOEXW info{};
  info.lpAttributeList = reinterpret_cast<LPPROC_THREAD_ATTRIBUTE_LIST>(memory.data());
  info.StartupInfo.cb = sizeof(info);
  info.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
  info.StartupInfo.hStdInput = start.in;
  info.StartupInfo.hStdOutput = start.out;
  info.StartupInfo.hStdError = start.err;
  if (::InitializeProcThreadAttributeList(info.lpAttributeList, 1, 0, &bytes) == 0)
    return io_error("cannot start a process", errno_of_last_error());
  PROCESS_INFORMATION made{};
  // The child starts suspended, so that it starts no process before it is in the job, and in a group of its
  // own, so that Ctrl-C reaches this process alone.
  constexpr DWORD kFlags =
      CREATE_SUSPENDED | CREATE_UNICODE_ENVIRONMENT | EXTENDED_STARTUPINFO_PRESENT | CREATE_NEW_PROCESS_GROUP;
  const bool is_made =
      ::UpdateProcThreadAttribute(info.lpAttributeList, 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST,
                                  start.handles.data(), start.handles.size() * sizeof(HANDLE), nullptr,
                                  nullptr) != 0 &&
      ::CreateProcessW(start.program.c_str(), start.line.data(), nullptr, nullptr, TRUE, kFlags,
                       start.environment.data(), nullptr, &info.StartupInfo, &made) != 0;
  const int error = is_made ? 0 : errno_of_last_error();
  ::DeleteProcThreadAttributeList(info.lpAttributeList);
  if (!is_made) return io_error("cannot start a process", error);
  const SystemHandle thread = own(made.hThread);
  Started started{own(made.hProcess), make_job()};
  if (started.job == nullptr || ::AssignProcessToJobObject(started.job.get(), made.hProcess) == 0 ||
      ::ResumeThread(made.hThread) == static_cast<DWORD>(-1)) {
    const int job_error = errno_of_last_error();
    ::TerminateProcess(made.hProcess, 1);
    return io_error("cannot start a process in a job", job_error);
  }
  return started;
}

// What ended the process, as a signal of other systems if it was a crash.
ProcessEnd wait_for(HANDLE process) {
  ::WaitForSingleObject(process, INFINITE);
  DWORD code = 0;
  ::GetExitCodeProcess(process, &code);
  constexpr int kKill = 9, kIllegal = 4;
  switch (code) {
    case EXCEPTION_ACCESS_VIOLATION:
    case EXCEPTION_STACK_OVERFLOW: return {true, SIGSEGV};
    case EXCEPTION_ILLEGAL_INSTRUCTION: return {true, kIllegal};
    case EXCEPTION_INT_DIVIDE_BY_ZERO: return {true, SIGFPE};
    case static_cast<DWORD>(STATUS_NO_MEMORY): return {true, kKill};
    case static_cast<DWORD>(STATUS_CONTROL_C_EXIT): return {true, SIGINT};
    default: break;
  }
  // The errors of the system; -1 is a code as programs choose it.
  constexpr DWORD kFirstError = 0xC0000000, kLastError = 0xCFFFFFFF;
  const bool is_crash = kFirstError <= code && code <= kLastError;
  return is_crash ? ProcessEnd{true, SIGABRT} : ProcessEnd{false, static_cast<int>(code)};
}

class PipeToParent : public ParentLink {
 public:
  PipeToParent(HANDLE requests, HANDLE answers) : requests_(requests), answers_(answers) {}
  std::optional<std::string> receive() override {
    const std::lock_guard lock(receiving_);
    std::array<char, 1 << 16> block;
    for (;;) {
      if (std::optional<std::string> line = lines_.next()) return line;
      const std::string_view text = read_some(requests_, block);
      if (text.empty()) return std::nullopt;
      lines_.add(text);
    }
  }
  void send(const std::string& line) override {
    const std::lock_guard lock(sending_);
    if (!write_whole(answers_, line + "\n")) ::TerminateProcess(::GetCurrentProcess(), 1);
  }

 private:
  const HANDLE requests_, answers_;
  std::mutex receiving_, sending_;
  PipeLines lines_;
};

class ChildInJob : public ChildProcess {
 public:
  ChildInJob(Started started, SystemHandle requests, SystemHandle answers)
      : started_(std::move(started)), requests_(std::move(requests)), answers_(std::move(answers)) {
    reader_ = std::thread([this] { read_answers(); });
  }
  ~ChildInJob() override {
    ChildInJob::kill();
    ChildInJob::close();
    reader_.join();  // all that held the other end of the pipe have ended
  }

  bool send(const std::string& line) override {
    return requests_ != nullptr && write_whole(requests_.get(), line + "\n");
  }
  void close() override { requests_.reset(); }

  Received receive(Deadline deadline) override {
    std::unique_lock lock(wake_mutex);
    const auto is_due = [&] { return !lines_.empty() || has_ended_ || stop_is_new; };
    if (deadline)
      wake.wait_until(lock, *deadline, is_due);
    else
      wake.wait(lock, is_due);
    stop_is_new = false;
    const bool ended = lines_.empty() && has_ended_;
    return {std::exchange(lines_, {}), ended};
  }

  ProcessEnd kill() override {
    if (has_end_) return end_;
    if (::TerminateJobObject(started_.job.get(), 1) == 0) ::TerminateProcess(started_.process.get(), 1);
    wait();
    constexpr int kKill = 9;
    return end_ = {true, kKill};
  }

  ProcessEnd wait() override {
    if (has_end_) return end_;
    end_ = wait_for(started_.process.get());
    has_end_ = true;
    ::TerminateJobObject(started_.job.get(), 1);  // its commands
    return end_;
  }

 private:
  void read_answers() {
    std::array<char, 1 << 16> block;
    PipeLines lines;
    for (;;) {
      const std::string_view text = read_some(answers_.get(), block);
      lines.add(text);
      const std::lock_guard lock(wake_mutex);
      while (std::optional<std::string> line = lines.next()) lines_.push_back(std::move(*line));
      has_ended_ = text.empty();
      wake.notify_all();
      if (has_ended_) return;
    }
  }

  Started started_;
  SystemHandle requests_, answers_;
  std::thread reader_;
  std::vector<std::string> lines_;  // with has_ended_: under wake_mutex
  bool has_ended_ = false, has_end_ = false;
  ProcessEnd end_;
};

// Passes what a command prints on to stderr until it ends. A process that it left in the background may hold
// the pipe for longer, and print on.
ProcessEnd pass_on(HANDLE output, HANDLE process, LastLines& last_lines) {
  constexpr DWORD kPatienceMs = 10;
  for (bool has_ended = false;;) {
    DWORD waiting = 0;
    if (::PeekNamedPipe(output, nullptr, 0, nullptr, &waiting, nullptr) == 0) break;
    if (waiting > 0) {
      std::array<char, 1 << 12> block;
      const std::string_view text = read_some(output, block);
      write_whole(::GetStdHandle(STD_ERROR_HANDLE), text);
      last_lines.add(text);
      continue;
    }
    if (has_ended) break;
    has_ended = ::WaitForSingleObject(process, kPatienceMs) == WAIT_OBJECT_0;
  }
  return wait_for(process);
}

std::wstring variable(const wchar_t* name) {
  std::wstring value(32768, L'\0');
  value.resize(::GetEnvironmentVariableW(name, value.data(), static_cast<DWORD>(value.size())));
  return value;
}

// The places %1, %2 ... of a command become the variables of that name and number. The shell does not look into
// the value of a variable, except for a quote. So each variable is put in quotes, unless the command has quotes
// around it. %% is %.
std::string with_arguments(std::string_view command, const std::string& name, size_t count) {
  std::string text;
  bool is_quoted = false;
  for (size_t i = 0; i < command.size(); ++i) {
    const char c = command[i], next = i + 1 < command.size() ? command[i + 1] : '\0';
    const bool is_place = c == '%' && next >= '1' && next <= '9' && static_cast<size_t>(next - '0') <= count;
    const bool is_escaped = (c == '^' && !is_quoted && next != '\0') || (c == '%' && next == '%');
    if (is_place) {
      const std::string value = "%" + name + next + "%";
      text += is_quoted ? value : "\"" + value + "\"";
    } else {
      if (c == '"') is_quoted = !is_quoted;
      text += c;
      if (c == '^' && is_escaped) text += next;
    }
    if (is_place || is_escaped) ++i;
  }
  return text;
}

std::wstring own_program() {
  std::wstring name(32768, L'\0');
  name.resize(::GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size())));
  return name;
}

}  // namespace

StopSignals::StopSignals() {
  const std::lock_guard lock(wake_mutex);
  stop_seen = stop_is_new = false;
  ::SetConsoleCtrlHandler(note_stop, TRUE);
}
StopSignals::~StopSignals() { ::SetConsoleCtrlHandler(note_stop, FALSE); }

bool StopSignals::seen() const {
  const std::lock_guard lock(wake_mutex);
  return stop_seen;
}

std::string place_of_argument(int number) { return "%" + std::to_string(number); }

std::unique_ptr<ParentLink> take_parent_link() {
  const std::wstring text = variable(kLinkVariable);
  if (text.empty()) return nullptr;
  ::SetEnvironmentVariableW(kLinkVariable, nullptr);  // commands of the child have no such link
  ::SetConsoleCtrlHandler(ignore_stop, TRUE);         // the parent decides when this process ends
  wchar_t* end = nullptr;
  const auto requests = std::wcstoull(text.c_str(), &end, 10);
  const auto answers = std::wcstoull(*end == L',' ? end + 1 : end, nullptr, 10);
  const auto handle = [](unsigned long long number) {
    return reinterpret_cast<HANDLE>(static_cast<uintptr_t>(number));
  };
  for (const auto number : {requests, answers}) ::SetHandleInformation(handle(number), HANDLE_FLAG_INHERIT, 0);
  return std::make_unique<PipeToParent>(handle(requests), handle(answers));
}

void set_child_program(const std::filesystem::path& program) { child_program = program; }
void set_child_words(std::vector<std::string> words) { child_words = std::move(words); }

Expected<std::unique_ptr<ChildProcess>> ChildProcess::start(const std::function<int(ParentLink&)>&,
                                                            const std::string& greeting) {
  std::optional<Pipe> requests = make_pipe(), answers = make_pipe();
  if (!requests || !answers) return io_error("cannot make a pipe", errno_of_last_error());
  std::fflush(nullptr);
  Start start;
  start.program = child_program.empty() ? own_program() : child_program.wstring();
  for (const std::string& word : child_words) start.line += (start.line.empty() ? L"" : L" ") + quoted(word);
  const Inherited in(requests->out.get()), out(answers->in.get());
  if (in.get() == nullptr || out.get() == nullptr) return io_error("cannot make a pipe", errno_of_last_error());
  const Inherited standard[] = {Inherited(::GetStdHandle(STD_INPUT_HANDLE)),
                                Inherited(::GetStdHandle(STD_OUTPUT_HANDLE)),
                                Inherited(::GetStdHandle(STD_ERROR_HANDLE))};
  start.in = standard[0].get();
  start.out = standard[1].get();
  start.err = standard[2].get();
  start.handles = {in.get(), out.get()};
  const auto number = [](HANDLE handle) { return std::to_string(reinterpret_cast<uintptr_t>(handle)); };
  start.environment = environment_with({{utf8(kLinkVariable), number(in.get()) + "," + number(out.get())}});
  Expected<Started> started = start_process(std::move(start));
  if (!started) return started.status();
  auto child =
      std::make_unique<ChildInJob>(std::move(*started), std::move(requests->in), std::move(answers->out));
  child->send(greeting);
  return std::unique_ptr<ChildProcess>(std::move(child));
}

Expected<CommandEnd> run_shell(const std::string& command, const std::vector<std::string>& arguments,
                               const std::vector<std::pair<std::string, std::string>>& variables) {
  const std::string name = "PSPLIT_ARGUMENT_";
  std::vector<std::pair<std::string, std::string>> settings = variables;
  for (size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].find_first_of("\"\n\r") != std::string::npos)
      return invalid_input("the name " + arguments[i] +
                           " has a quote or a line break, which cmd.exe cannot pass on");
    settings.emplace_back(name + std::to_string(i + 1), arguments[i]);
  }
  const std::string text = with_arguments(command, name, arguments.size());
  std::optional<Pipe> output = make_pipe();
  if (!output) return io_error("cannot make a pipe", errno_of_last_error());
  Start start;
  const std::wstring shell = variable(L"ComSpec");
  start.program = shell.empty() ? L"C:\\Windows\\System32\\cmd.exe" : shell;
  start.line = L"cmd.exe /d /v:off /s /c \"" + wide(text) + L"\"";
  start.environment = environment_with(settings);
  const SystemHandle nothing = own(::CreateFileW(L"NUL", GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_WRITE,
                                                 nullptr, OPEN_EXISTING, 0, nullptr));
  const Inherited in(nothing.get()), out(output->in.get());
  if (out.get() == nullptr) return io_error("cannot make a pipe", errno_of_last_error());
  start.in = in.get();
  start.out = start.err = out.get();
  {
    const Expected<Started> started = start_process(std::move(start));
    if (!started) return started.status();
    output->in.reset();
    LastLines last_lines;
    ProcessEnd end = pass_on(output->out.get(), started->process.get(), last_lines);
    constexpr int kNoSuchCommand = 9009;  // of scripts of cmd.exe; 127 of other shells
    if (!end.by_signal && end.number == kNoSuchCommand) end.number = 127;
    return CommandEnd{end, last_lines.joined()};
  }
}

uint64_t peak_memory() {
  PROCESS_MEMORY_COUNTERS counters{};
  return ::GetProcessMemoryInfo(::GetCurrentProcess(), &counters, sizeof(counters)) != 0
             ? counters.PeakWorkingSetSize
             : 0;
}

uint64_t machine_memory() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof(status);
  return ::GlobalMemoryStatusEx(&status) != 0 ? status.ullTotalPhys : 0;
}

}  // namespace psplit
