// gltf-psplit completion: bash completes, and all verbs and options are in the script of each shell.
#include <array>
#include <regex>
#include <set>

#include "tests/tools/run_command.h"

namespace psplit {
namespace {

using Words = std::set<std::string>;

std::string output_of(const std::string& command) {
  std::FILE* const pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> block;
  for (size_t got = 1; got > 0;)
    text.append(block.data(), got = std::fread(block.data(), 1, block.size(), pipe));
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

Words words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

class Completion : public CommandTest {
 protected:
  std::string script(const std::string& shell) {
    EXPECT_EQ(run({"completion", shell, "-o", path(shell)}), 0) << err_;
    return read_bytes(path(shell));
  }
  // What bash offers for the last word of a command line.
  Words offered(const std::string& line) {
    const auto count = static_cast<size_t>(std::count(line.begin(), line.end(), ' '));
    return words_of(output_of("bash -c 'source " + path("bash") + "; COMP_WORDS=(gltf-psplit " + line +
                              "); COMP_CWORD=" + std::to_string(count + 1) +
                              "; _gltf_psplit; echo \"${COMPREPLY[@]}\"'"));
  }
  // The names at the beginning of the lines of a help.
  Words in_help(std::vector<std::string> verb, const std::regex& name) {
    verb.emplace_back("--help");
    EXPECT_EQ(run(verb), 0);
    Words found;
    for (std::sregex_iterator at(out_.begin(), out_.end(), name), end; at != end; ++at) found.insert((*at)[1]);
    return found;
  }
  const std::regex verb_{"\n  ([a-z]+)  +[A-Z]"}, option_{"\n  (?:-[a-zA-Z],)?(--[a-z-]+)"};
};

TEST_F(Completion, BashOffersVerbsOptionsAndValues) {
  if (!is_posix()) GTEST_SKIP() << "no bash";
  script("bash");
  EXPECT_EQ(offered("\"\""), in_help({}, verb_));
  EXPECT_EQ(offered("enc"), Words{"encode"});
  EXPECT_EQ(offered("batch \"\""), (Words{"plan", "merge"}));
  EXPECT_EQ(offered("-q encode --prof"), Words{"--profile"});
  EXPECT_EQ(offered("encode a.glb --profile \"\""), (Words{"balanced", "size", "speed"}));
  EXPECT_EQ(offered("encode --profile = s"), (Words{"size", "speed"}));
  EXPECT_EQ(offered("encode --lossless --prof"), Words{"--profile"});
  EXPECT_EQ(offered("batch plan --has"), Words{"--hash"});
  EXPECT_EQ(offered("completion z"), Words{"zsh"});
  // Files, which bash itself offers.
  EXPECT_EQ(offered("encode \"\""), Words());
  EXPECT_EQ(offered("encode --report \"\""), Words());
}

TEST_F(Completion, AllVerbsAndOptionsAreInEachScript) {
  if (!is_posix()) GTEST_SKIP() << "no bash";
  const std::string bash = script("bash"), zsh = script("zsh"), fish = script("fish");
  const Words verbs = in_help({}, verb_);
  EXPECT_GT(verbs.size(), 10u);
  std::vector<std::vector<std::string>> commands = {{}, {"batch", "plan"}, {"batch", "merge"}};
  for (const std::string& verb : verbs) {
    EXPECT_TRUE(contains(fish, "-f -a " + verb + " -d '")) << verb;
    EXPECT_TRUE(contains(zsh, " '" + verb + ":")) << verb;
    commands.push_back({verb});
  }
  for (const std::vector<std::string>& command : commands) {
    std::string name;
    for (const std::string& word : command) name += (name.empty() ? "" : " ") + word;
    const Words options = in_help(command, option_);
    Words long_ones;
    for (const std::string& word : offered(name + (name.empty() ? "" : " ") + "--")) long_ones.insert(word);
    EXPECT_EQ(long_ones, options) << name;
    const size_t at = zsh.find("'" + name + ":-'*)");
    ASSERT_NE(at, std::string::npos) << name;
    const std::string line = zsh.substr(at, zsh.find(";;\n", at) - at);
    for (const std::string& option : options) {
      EXPECT_TRUE(contains(line, "'" + option + ":")) << name << option;
      EXPECT_TRUE(contains(fish, " -l " + option.substr(2) + " ")) << name << option;
    }
  }
}

TEST_F(Completion, ScriptsHaveTheSyntaxOfTheirShells) {
  if (!is_posix()) GTEST_SKIP() << "no bash";
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    script(shell);
    if (std::system(("command -v " + shell + " >/dev/null").c_str()) != 0) continue;
    EXPECT_EQ(std::system((shell + " -n " + path(shell)).c_str()), 0) << shell;
  }
  EXPECT_EQ(run({"completion", "cmd"}), 1);
  must_run({"completion", "bash"});
  EXPECT_EQ(out_, read_bytes(path("bash")));
}

}  // namespace
}  // namespace psplit
