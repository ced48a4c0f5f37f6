// Help, version, and options before or after the subcommand.
#include <cstdlib>

#include "system/io_error.h"
#include "tests/support/environment.h"
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/exit_codes.h"

namespace psplit {
namespace {

const char* const kVerbs[] = {"encode",  "batch", "decode",   "expand",     "inspect", "validate",
                              "compare", "diff",  "generate", "completion", "help",    "version"};

class Help : public CommandTest {};

TEST_F(Help, FitsEightyColumns) {
  std::vector<std::vector<std::string>> commands = {{"--help"}};
  for (const char* verb : kVerbs) commands.push_back({verb, "--help"});
  for (const char* part : {"plan", "merge"}) commands.push_back({"batch", part, "--help"});
  for (const auto& words : commands) {
    std::istringstream lines(must_run(words));
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
    EXPECT_EQ(err_, "");
  }
}

// Only names of options, usage lines and examples of command lines may be longer.
TEST_F(Help, FitsNarrowTerminals) {
  for (const char* columns : {"40", "60"}) {
    set_variable("COLUMNS", columns);
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
    set_variable("COLUMNS", columns);
    EXPECT_TRUE(contains(run_command({"encode", "--help"}).out, "\n  IN ...                      The input"));
  }
  set_variable("COLUMNS", nullptr);
}

TEST_F(Help, EndsWithExamplesAndExitCodes) {
  for (const char* verb : kVerbs) {
    if (verb == std::string("version")) continue;
    must_run({verb, "--help"});
    EXPECT_TRUE(contains(out_, "Examples:\n  gltf-psplit "));
    for (const ExitCode& exit : exit_codes()) EXPECT_TRUE(contains(out_, exit.meaning));
    if (verb == std::string("help") || verb == std::string("completion")) continue;
    for (const char* option : {"--help", "--quiet", "--verbose", "--threads"})
      EXPECT_TRUE(contains(out_, option)) << verb;
  }
}

TEST_F(Help, IsAVerbToo) {
  EXPECT_EQ(must_run({"help", "encode"}), must_run({"encode", "--help"}));
  EXPECT_EQ(must_run({"help"}), must_run({"--help"}));
  for (const char* verb : kVerbs) EXPECT_TRUE(contains(out_, verb));
  for (const ExitCode& exit : exit_codes()) EXPECT_TRUE(contains(out_, exit.meaning));
}

TEST_F(Help, VersionIsAVerbAndAFlag) {
  for (const char* word : {"version", "--version", "-V"}) {
    EXPECT_EQ(must_run({word}), "gltf-psplit 1.2.3\n");
    EXPECT_EQ(err_, "") << word;
  }
}

TEST_F(Help, CommonOptionsStandBeforeTheVerbOrAfterIt) {
  const std::string out = path("a.glb");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"-q", "generate", out},
                                                {"generate", "-q", out},
                                                {"generate", out, "--quiet"}}) {
    must_run(words);
    EXPECT_EQ(err_, "");
  }
  EXPECT_EQ(json_of({"-j", "3", "encode", out, out, "--report", "-", "-q", "--force"}).at("threads"), 3);
  fails(1, {"-v", "generate", out, "-q"}, "--quiet excludes --verbose");
}

TEST_F(Help, OutputIsAWordOrAnOption) {
  const std::string a = path("a.glb"), b = path("b.glb");
  must_run({"generate", "-o", a, "--faces", "1k", "-q"});
  must_run({"encode", "-o", b, a, "-q"});
  must_run({"encode", a, "--output", b, "-q"});
  must_run({"decode", b, "-o", a, "-q"});
  for (const char* verb : {"inspect", "validate"}) {
    EXPECT_EQ(must_run({verb, b, "-o", path(verb)}), "");
    EXPECT_EQ(read_bytes(path(verb)), must_run({verb, b}));
  }
  // The output must be named once, not twice and not never.
  EXPECT_EQ(run({"encode", a, b, "-o", b}), 1);
  EXPECT_EQ(run({"encode", a}), 1);
}

TEST_F(Help, ExitCodesAreThoseOfTheManual) {
  // All in the order of the enum. kCancelled is not among them: only callers of functions get it.
  std::vector<StatusCode> codes = {
      StatusCode::kOk,           StatusCode::kUsage,          StatusCode::kIo,
      StatusCode::kInvalidInput, StatusCode::kRuntimeFailure, StatusCode::kUnsupported,
      StatusCode::kDiffers,      StatusCode::kOutOfMemory,    StatusCode::kMayPass};
  std::vector<StatusCode> listed;
  std::vector<int> expected;
  for (const ExitCode& exit : exit_codes()) {
    listed.push_back(exit.code);
    expected.push_back(exit.number);
    EXPECT_EQ(exit_code(exit.code), exit.number);
    EXPECT_EQ(status_code(exit.number), exit.code);
  }
  EXPECT_EQ(listed, codes);
  EXPECT_EQ(status_code(6), StatusCode::kRuntimeFailure);
  // The numbers in the sentence of docs/manual.md: "exit codes are 0 ok, 1 usage, ...".
  const std::string text = read_bytes(PSPLIT_MANUAL);
  const size_t begin = text.find("exit codes are ");
  ASSERT_NE(begin, std::string::npos);
  std::vector<int> numbers;
  for (size_t at = text.find_first_of("0123456789", begin); at < text.find('.', begin);) {
    const size_t end = text.find_first_not_of("0123456789", at);
    numbers.push_back(std::stoi(text.substr(at, end - at)));
    at = text.find_first_of("0123456789", end);
  }
  EXPECT_EQ(numbers, expected);
}

}  // namespace
}  // namespace psplit
