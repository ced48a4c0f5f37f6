
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/options/help_text.h"

namespace psplit {
namespace {

class Suggestions : public CommandTest {};

TEST_F(Suggestions, DistanceCountsLettersAndSwaps) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("encode", "encode"), 0u);
  EXPECT_EQ(edit_distance("encde", "encode"), 1u);
  EXPECT_EQ(edit_distance("encodee", "encode"), 1u);
  EXPECT_EQ(edit_distance("enkode", "encode"), 1u);
  EXPECT_EQ(edit_distance("ecnode", "encode"), 1u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST_F(Suggestions, OnlyWhatIsNearIsSuggested) {
  const std::vector<std::string> words = {"encode", "decode", "validate", "version"};
  EXPECT_EQ(nearest_word("encod", words), "encode");
  EXPECT_EQ(nearest_word("deocde", words), "decode");
  EXPECT_EQ(nearest_word("valid", words), "validate");  // a beginning of the word
  EXPECT_EQ(nearest_word("teapot", words), "");
  EXPECT_EQ(nearest_word("x", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(suggestion("encoed", words), "; did you mean encode?");
  EXPECT_EQ(suggestion("teapot", words), "");
}

TEST_F(Suggestions, ComeWithUnknownVerbsAndOptions) {
  const auto says = [&](const std::vector<std::string>& words, const std::string& what) {
    fails(1, words, what);
    EXPECT_EQ(out_, "");
  };
  says({"encod", "a.glb", "b.glb"}, "unknown subcommand: encod; did you mean encode?");
  says({"teapot"}, "unknown subcommand: teapot\n");
  says({"encode", "a.glb", "b.glb", "--patchs", "3"}, "unknown option: --patchs; did you mean --patches?");
  says({"encode", "--patchs=3", "a.glb", "b.glb"}, "unknown option: --patchs; did you mean --patches?");
  // The word after an unknown option counts as a file. The message must name the option, not that file.
  says({"encode", "--losless", "a.glb"}, "unknown option: --losless; did you mean --lossless?");
  says({"generate", "a.glb", "--teapots"}, "unknown option: --teapots\n");
  says({"help", "encod"}, "unknown subcommand: encod; did you mean encode?");
  says({"--verson"}, "unknown option: --verson; did you mean --version?");
  // A note says where to look for more.
  says({"encode", "a.glb", "b.glb", "--patchs", "3"}, "`gltf-psplit encode --help`");
}

}  // namespace
}  // namespace psplit
