// The command as a process of Windows: words and names in UTF-8, streams of bytes, Ctrl-Break, files in use,
// and the processes of a batch.
#include <windows.h>

#include <chrono>
#include <thread>

#include "gltf_ext/document/document.h"
#include "gltf_ext/json/json.h"
#include "system/io_error.h"
#include "system/operating_system.h"
#include "system/uri.h"
#include "tests/tools/command_file.h"
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/batch/memory_estimate.h"
#include "tools/gltf_psplit/report/exit_codes.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

std::wstring wide(const std::string& text) { return fs::path(text).wstring(); }

class CommandProcess : public CommandTest {
 protected:
  // A running command. The destructor kills it.
  struct Process {
    PROCESS_INFORMATION info{};
    Process() = default;
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process() {
      TerminateProcess(info.hProcess, 1);
      CloseHandle(info.hProcess);
      CloseHandle(info.hThread);
    }
    int wait() const {
      WaitForSingleObject(info.hProcess, INFINITE);
      DWORD code = 0;
      GetExitCodeProcess(info.hProcess, &code);
      return static_cast<int>(code);
    }
  };

  static HANDLE open(const std::string& file, bool writes) {
    SECURITY_ATTRIBUTES inherited{sizeof(inherited), nullptr, TRUE};
    return CreateFileW(wide(file).c_str(), writes ? GENERIC_WRITE : GENERIC_READ,
                       FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, &inherited,
                       writes ? CREATE_ALWAYS : OPEN_EXISTING, 0, nullptr);
  }

  // Words have no quotes. stdout and stderr go to the files "out" and "err".
  void start(Process& process, const std::vector<std::string>& words, HANDLE input = nullptr) {
    std::wstring line = L"gltf-psplit";
    for (const std::string& word : words) line += L" \"" + wide(word) + L"\"";
    STARTUPINFOW start{};
    start.cb = sizeof(start);
    start.dwFlags = STARTF_USESTDHANDLES;
    const HANDLE out = open(path("out"), true), err = open(path("err"), true);
    start.hStdInput = input == nullptr ? open("NUL", false) : input;
    start.hStdOutput = out;
    start.hStdError = err;
    ASSERT_TRUE(CreateProcessW(fs::absolute(command_file()).c_str(), line.data(), nullptr, nullptr, TRUE,
                               CREATE_NEW_PROCESS_GROUP, nullptr, nullptr, &start, &process.info))
        << GetLastError();
    CloseHandle(start.hStdInput);
    CloseHandle(out);
    CloseHandle(err);
  }
  int run_process(const std::vector<std::string>& words, HANDLE input = nullptr) {
    Process process;
    start(process, words, input);
    const int code = process.wait();
    err_ = read_bytes(path("err"));
    return code;
  }
  // Waits until something is true.
  template <typename Done>
  static bool comes_true(const Done& done) {
    for (int i = 0; i < 3000 && !done(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return done();
  }
};

TEST_F(CommandProcess, WordsAndNamesAreUtf8) {
  const std::string plain = path(
      "gr\xC3\xBC\xC3\x9F"
      "e \xE6\xA8\xA1\xF0\x9F\x90\x89.glb");
  ASSERT_EQ(run_process({"generate", plain, "--faces", "800"}), 0) << err_;
  EXPECT_TRUE(contains(err_, "\xF0\x9F\x90\x89.glb"));
  EXPECT_EQ(run_process({"encode", plain, path("a.glb"), "--report", path("r.json")}), 0) << err_;
  EXPECT_TRUE(contains(read_bytes(path("r.json")), "\xE6\xA8\xA1\xF0\x9F\x90\x89.glb"));
  EXPECT_EQ(run_process({"validate", path("a.glb")}), 0) << err_;
}

TEST_F(CommandProcess, StreamsCarryBytes) {
  ASSERT_EQ(run_process({"generate", path("in.glb"), "--faces", "3000"}), 0) << err_;
  ASSERT_EQ(run_process({"encode", path("in.glb"), path("a.glb")}), 0) << err_;
  ASSERT_EQ(run_process({"encode", "-", "-", "-q"}, open(path("in.glb"), false)), 0) << err_;
  EXPECT_EQ(read_bytes(path("out")), read_bytes(path("a.glb")));
  EXPECT_EQ(run_process({"version"}), 0);
  EXPECT_EQ(read_bytes(path("out")).find('\r'), std::string::npos);
}

TEST_F(CommandProcess, PathsMayBeLong) {
  fs::path folder = folder_.path();
  while (folder.native().size() < 400) folder /= "a folder with a name of forty characters";
  fs::create_directories(folder);
  const std::string plain = (folder / "a.glb").string();
  ASSERT_EQ(run_process({"generate", plain, "--faces", "800"}), 0) << err_;
  EXPECT_EQ(run_process({"encode", plain, (folder / "b.glb").string(), "--memory", "1GB"}), 0) << err_;
  EXPECT_EQ(run_process({"batch", plain, "-o", (folder / "c").string()}), 0) << err_;
}

TEST_F(CommandProcess, AnInputThatIsMappedIsReplaced) {
  ASSERT_EQ(run_process({"generate", path("a.glb"), "--faces", "300000"}), 0) << err_;
  ASSERT_GE(fs::file_size(path("a.glb")), kMappedBytes);
  ASSERT_EQ(run_process({"encode", path("a.glb"), path("b.glb")}), 0) << err_;
  ASSERT_EQ(run_process({"encode", path("a.glb"), path("a.glb"), "--force"}), 0) << err_;
  EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
  SetFileAttributesW(wide(path("a.glb")).c_str(), FILE_ATTRIBUTE_READONLY);
  EXPECT_EQ(run_process({"generate", path("a.glb"), "--faces", "800"}), 2);
  EXPECT_TRUE(contains(err_, "read-only"));
  EXPECT_EQ(run_process({"generate", path("a.glb"), "--faces", "800", "--force"}), 0) << err_;
  EXPECT_NE(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
  EXPECT_NE(GetFileAttributesW(wide(path("a.glb")).c_str()) & FILE_ATTRIBUTE_READONLY, 0u);
  SetFileAttributesW(wide(path("a.glb")).c_str(), FILE_ATTRIBUTE_NORMAL);
  EXPECT_EQ(file_count(), 4u) << "two assets, out and err";
}

TEST_F(CommandProcess, CtrlBreakEndsItWithTheCodeOfWhatMayPass) {
  if (GetConsoleWindow() == nullptr) AllocConsole();
  HANDLE input = nullptr, writer = nullptr;
  SECURITY_ATTRIBUTES inherited{sizeof(inherited), nullptr, TRUE};
  ASSERT_TRUE(CreatePipe(&input, &writer, &inherited, 0));
  SetHandleInformation(writer, HANDLE_FLAG_INHERIT, 0);
  Process process;
  start(process, {"encode", "-", path("a.glb")}, input);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  if (GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, process.info.dwProcessId) == 0)
    GTEST_SKIP() << "no console, error " << GetLastError();
  EXPECT_EQ(process.wait(), exit_code(StatusCode::kMayPass));
  EXPECT_EQ(read_bytes(path("err")), "gltf-psplit: error: stopped by a signal\n");
  EXPECT_EQ(file_count(), 2u) << "out and err";
  CloseHandle(writer);
}

TEST_F(CommandProcess, DevicesAreNoBuffers) {
  for (const char* name : {"CON", "AUX", "COM1", "com1.bin", "NUL"}) {
    write("a.gltf", std::string(R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": ")") +
                        name + "\"}]}");
    EXPECT_EQ(run_process({"encode", path("a.gltf"), path("b.glb")}), exit_code(StatusCode::kIo)) << name;
    EXPECT_TRUE(contains(err_, "no file")) << err_;
  }
}

TEST_F(CommandProcess, TheMemoryOfAPipeIsEstimated) {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += "v " + std::to_string(i) + " 0 1\n";
  for (int i = 1; i < 2999; ++i) text += "f 1 " + std::to_string(i + 1) + " " + std::to_string(i + 2) + "\n";
  write("a.obj", text);
  UnnamedFile file = must(UnnamedFile::create(folder_.path()));
  must(file.write(0, {reinterpret_cast<const uint8_t*>(text.data()), text.size()}));
  const auto estimate = [](const std::string& name, uint64_t bytes) {
    return estimate_memory(name, BatchVerb::kEncode, "a.obj", false, bytes);
  };
  EXPECT_EQ(estimate(file.path().string(), text.size()), estimate(path("a.obj"), 0));
  EXPECT_GT(estimate(path("a.obj"), 0), estimate(path("none.obj"), 0));
}

class BatchProcess : public CommandProcess {
 protected:
  // Assets that take a while.
  void generate(int count) {
    for (int i = 0; i < count; ++i)
      must_run({"generate", path("in/" + std::to_string(i) + ".glb"), "--shape", "terrain", "--faces", "60000",
                "--seed", std::to_string(i), "-q"});
  }
  bool is_running() const { return is_owned(path("done/.gltf-psplit-batch/0-of-1.jsonl")); }
  void SetUp() override { fs::create_directories(path("in")); }
  std::vector<std::string> words() const {
    return {"batch", path("in"), "-o", path("done"), "-q", "--report", path("report.json")};
  }
};

TEST_F(BatchProcess, EndsWithItsParent) {
  generate(6);
  {
    Process process;
    start(process, words());
    ASSERT_TRUE(comes_true([&] { return fs::exists(path("done/0.glb")); }));
  }  // killed
  EXPECT_TRUE(comes_true([&] { return !is_running(); }));
  ASSERT_EQ(run_process(words()), 0) << err_;
  const Json report = Json::parse(read_bytes(path("report.json")));
  EXPECT_EQ(report["failed"], 0);
  EXPECT_EQ(report["encoded"].get<int>() + report["up_to_date"].get<int>(), 6);
  EXPECT_GE(report["up_to_date"].get<int>(), 1);
  for (const auto& entry : fs::recursive_directory_iterator(path("done")))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
}

TEST_F(BatchProcess, StopsAtCtrlBreakAndGoesOn) {
  if (GetConsoleWindow() == nullptr) AllocConsole();
  generate(6);
  {
    Process process;
    start(process, words());
    ASSERT_TRUE(comes_true([&] { return fs::exists(path("done/0.glb")); }));
    if (GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, process.info.dwProcessId) == 0)
      GTEST_SKIP() << "no console, error " << GetLastError();
    EXPECT_EQ(process.wait(), exit_code(StatusCode::kMayPass));
  }
  EXPECT_TRUE(contains(read_bytes(path("err")), "stopped by a signal after"));
  EXPECT_EQ(run_process(words()), 0) << err_;
}

TEST_F(BatchProcess, NamesThatDifferInCaseAreTheSame) {
  for (const char* name : {"in/a.glb", "in/A.ply"}) write(name, "");
  const auto refuses = [&](const std::vector<std::string>& more, const std::string& what) {
    std::vector<std::string> given = {"batch"};
    given.insert(given.end(), more.begin(), more.end());
    fails(exit_code(StatusCode::kUsage), given, what);
  };
  refuses({path("in"), "-o", path("out")}, "would both become");
  refuses({path("in/*.GLB"), "-o", path("IN")}, "which is for the outputs");
  refuses({path("in/a.glb"), path("in/A.ply"), "-o", path("Out")}, "would both become");
  refuses({path("in/*.Glb"), "-o", path("out"), "--report", path("OUT/A.glb")}, "--report would replace");
  write("plan.jsonl", R"({"input": "in/a.glb", "name": "x.glb"})"
                      "\n"
                      R"({"input": "in/A.ply", "name": "X.glb"})"
                      "\n");
  fails(exit_code(StatusCode::kUsage), {"batch", "--manifest", path("plan.jsonl"), "-o", path("out"), "-q"},
        "another asset of the manifest has the same name");
}

TEST_F(BatchProcess, InputsOfTwoDrivesHaveNoCommonFolder) {
  fails(exit_code(StatusCode::kUsage), {"batch", "C:\\a.glb", "Z:\\b.glb", "-o", path("out")},
        "no folder in common");
}

TEST_F(BatchProcess, AnAssetThatIsLateIsGivenUp) {
  generate(1);
  std::vector<std::string> hasty = words();
  hasty.insert(hasty.end(), {"--timeout", "0.001"});
  EXPECT_EQ(run_process(hasty), exit_code(StatusCode::kMayPass));
  EXPECT_TRUE(contains(err_, "took longer than")) << err_;
}

TEST_F(BatchProcess, CommandsBringAndTakeFiles) {
  generate(1);
  fs::create_directories(path("far"));
  write("plan.jsonl", R"({"input": "in\\0.glb", "name": "x & y.glb"})"
                      "\n");
  const fs::path before = fs::current_path();
  fs::current_path(folder_.path());
  const auto bring_by = [&](const std::string& fetch) {
    return run_process({"batch", "--manifest", "plan.jsonl", "-o", "done", "-q", "--fetch", fetch, "--store",
                        "copy /b %1 far"});
  };
  const int without_input = bring_by("exit /b 66");
  const std::string reason = err_;
  // Read-only files are removed at the end, too.
  const int code = bring_by("copy /b \"%1\" \"%2\" && attrib +r \"%2\"");
  fs::current_path(before);
  EXPECT_EQ(without_input, exit_code(StatusCode::kIo)) << reason;
  EXPECT_TRUE(contains(reason, "--fetch failed: exit code 66"));
  EXPECT_EQ(code, 0) << err_;
  EXPECT_EQ(run_process({"validate", path("far/x & y.glb")}), 0) << err_;
  for (const auto& entry : fs::directory_iterator(path("done/.gltf-psplit-batch")))
    EXPECT_FALSE(contains(entry.path().string(), "staged")) << entry.path();
}

TEST_F(BatchProcess, InputsMayHaveNamesThatOutputsMayNot) {
  generate(1);
  write("plan.jsonl", R"({"input": "https://far/x.glb?part=1:2", "name": "x.glb"})"
                      "\n");
  EXPECT_EQ(run_process({"batch", "--manifest", path("plan.jsonl"), "-o", path("done"), "-q", "--fetch",
                         "copy /b " + path("in/0.glb") + " %2"}),
            0)
      << err_;
  EXPECT_EQ(run_process({"validate", path("done/x.glb")}), 0) << err_;
  write("plan.jsonl",
        R"({"input_uri": ")" + percent_encode(path("in/0.glb")) + R"(", "name": "Aux.glb"})" + "\n");
  EXPECT_EQ(run_process({"batch", "--manifest", path("plan.jsonl"), "-o", path("done"), "-q"}),
            exit_code(StatusCode::kUsage));
  EXPECT_TRUE(contains(err_, "has the name of a device"));
}

TEST_F(BatchProcess, FilesBesideAnInputAreFetchedFromItsFolder) {
  write("far/x/a.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "b/a.bin"}]})");
  write("far/x/b/a.bin", "abcd");
  write("plan.jsonl", R"({"input": "far\\x\\a.gltf", "name": "a.glb"})"
                      "\n");
  const fs::path before = fs::current_path();
  fs::current_path(folder_.path());
  const int code =
      run_process({"batch", "--manifest", "plan.jsonl", "-o", "done", "-q", "--fetch", "copy /b %1 %2"});
  fs::current_path(before);
  EXPECT_EQ(code, 0) << err_;
}

}  // namespace
}  // namespace psplit
