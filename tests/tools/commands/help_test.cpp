// Help, version, and options before or after the subcommand.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "gltf_ext/files/io_error.h"
#include "tests/support/test_folder.h"
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/exit_codes.h"

namespace psplit {
namespace {

const char* const kVerbs[] = {"encode",  "batch",    "decode",     "expand", "inspect", "validate",
                              "compare", "generate", "completion", "help",   "version"};

TEST(Help, FitsEightyColumns) {
  std::vector<std::vector<std::string>> commands = {{"--help"}};
  for (const char* verb : kVerbs) commands.push_back({verb, "--help"});
  for (const char* part : {"plan", "merge"}) commands.push_back({"batch", part, "--help"});
  for (const auto& words : commands) {
    const CommandOutcome outcome = run_command(words);
    EXPECT_EQ(outcome.code, 0);
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  }
}

// Only names of options, usage lines and examples of command lines may be longer.
TEST(Help, FitsNarrowTerminals) {
  for (const char* columns : {"40", "60"}) {
    setenv("COLUMNS", columns, 1);
    for (const char* verb : kVerbs) {
      const std::string help = run_command({verb, "--help"}).out;
      std::istringstream lines(help);
      for (std::string line; std::getline(lines, line);) {
        const bool is_name =
            line.starts_with("  -") || line.starts_with("Usage:") || line.starts_with("  gltf-psplit ");
        if (!is_name) {
          EXPECT_LE(line.size(), std::stoul(columns)) << line;
        }
        EXPECT_FALSE(line.ends_with(' ')) << line;
      }
      EXPECT_TRUE(contains(help, "Exit codes:") || verb == std::string("version")) << help;
    }
  }
  for (const char* columns : {"0", "-3", "wide", "1000"}) {
    setenv("COLUMNS", columns, 1);
    EXPECT_TRUE(contains(run_command({"encode", "--help"}).out, "\n  IN ...                      The input"));
  }
  unsetenv("COLUMNS");
}

TEST(Help, EndsWithExamplesAndExitCodes) {
  for (const char* verb : kVerbs) {
    if (verb == std::string("version")) continue;
    const std::string help = run_command({verb, "--help"}).out;
    EXPECT_TRUE(contains(help, "Examples:\n  gltf-psplit ")) << help;
    for (const ExitCode& exit : exit_codes()) EXPECT_TRUE(contains(help, exit.meaning)) << verb;
  }
}

TEST(Help, IsAVerbToo) {
  EXPECT_EQ(run_command({"help"}).out, run_command({"--help"}).out);
  EXPECT_EQ(run_command({"help", "encode"}).out, run_command({"encode", "--help"}).out);
  for (const char* verb : kVerbs) EXPECT_TRUE(contains(run_command({"help"}).out, verb)) << verb;
}

TEST(Help, VersionIsAVerbAndAFlag) {
  for (const char* word : {"version", "--version", "-V"}) {
    const CommandOutcome outcome = run_command({word});
    EXPECT_EQ(outcome.code, 0) << word;
    EXPECT_EQ(outcome.out, "gltf-psplit 1.2.3\n") << word;
    EXPECT_EQ(outcome.err, "") << word;
  }
}

TEST(Help, CommonOptionsStandBeforeTheVerbOrAfterIt) {
  const TestFolder folder;
  const std::string out = (folder / "a.glb").string();
  for (const std::vector<std::string>& words : {std::vector<std::string>{"-q", "generate", out},
                                                {"generate", "-q", out},
                                                {"generate", out, "--quiet"}}) {
    const CommandOutcome outcome = run_command(words);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
  }
  const CommandOutcome threads = run_command({"-j", "3", "encode", out, out, "--report", "-", "-q", "--force"});
  EXPECT_TRUE(contains(threads.out, "\"threads\": 3")) << threads.out;
  const CommandOutcome both = run_command({"-v", "generate", out, "-q"});
  EXPECT_EQ(both.code, 1);
  EXPECT_TRUE(contains(both.err, "--quiet excludes --verbose")) << both.err;
}

TEST(Help, OutputIsAWordOrAnOption) {
  const TestFolder folder;
  const std::string a = (folder / "a.glb").string(), b = (folder / "b.glb").string();
  EXPECT_EQ(run_command({"generate", "-o", a, "--faces", "1k", "-q"}).code, 0);
  EXPECT_EQ(run_command({"encode", "-o", b, a, "-q"}).code, 0);
  EXPECT_EQ(run_command({"encode", a, "--output", b, "-q"}).code, 0);
  EXPECT_EQ(run_command({"decode", b, "-o", a, "-q"}).code, 0);
  for (const char* verb : {"inspect", "validate"}) {
    const std::string text = (folder / verb).string();
    const CommandOutcome outcome = run_command({verb, b, "-o", text});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    std::ostringstream written;
    written << std::ifstream(text).rdbuf();
    EXPECT_EQ(written.str(), run_command({verb, b}).out);
  }
  // The output must be named once, not twice and not never.
  EXPECT_EQ(run_command({"encode", a, b, "-o", b}).code, 1);
  EXPECT_EQ(run_command({"encode", a}).code, 1);
}

TEST(Help, ExitCodesAreThoseOfStatusCodeAndOfTheReadme) {
  // All exit codes, in the order of the enum. kCancelled is not among them: only callers of functions get it.
  // kMayPass is not in the enum: only commands return it.
  std::vector<StatusCode> codes = {StatusCode::kOk,
                                   StatusCode::kUsage,
                                   StatusCode::kIo,
                                   StatusCode::kInvalidInput,
                                   StatusCode::kRuntimeFailure,
                                   StatusCode::kUnsupported,
                                   StatusCode::kDiffers,
                                   kMayPass};
  std::vector<StatusCode> listed;
  for (const ExitCode& exit : exit_codes()) listed.push_back(exit.code);
  EXPECT_EQ(listed, codes);
  // The numbers in the README's sentence "exit codes are 0 ok, 1 usage, ...".
  std::ostringstream readme;
  readme << std::ifstream(PSPLIT_README).rdbuf();
  const std::string text = readme.str();
  const size_t begin = text.find("exit codes are ");
  ASSERT_NE(begin, std::string::npos);
  std::vector<int> numbers;
  for (size_t at = text.find_first_of("0123456789", begin); at < text.find('.', begin);) {
    const size_t end = text.find_first_not_of("0123456789", at);
    numbers.push_back(std::stoi(text.substr(at, end - at)));
    at = text.find_first_of("0123456789", end);
  }
  std::vector<int> expected;
  for (const StatusCode code : codes) expected.push_back(static_cast<int>(code));
  EXPECT_EQ(numbers, expected);
}

}  // namespace
}  // namespace psplit
