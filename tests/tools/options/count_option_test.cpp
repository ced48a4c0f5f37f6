#include "tools/gltf_psplit/options/count_option.h"

#include "tests/tools/run_command.h"

namespace psplit {
namespace {

class CountOption : public CommandTest {};

TEST_F(CountOption, ReadsCountsAsPeopleWriteThem) {
  EXPECT_EQ(parse_count("0"), 0u);
  EXPECT_EQ(parse_count("1000000"), 1000000u);
  EXPECT_EQ(parse_count("1_000_000"), 1000000u);
  EXPECT_EQ(parse_count("1,000,000"), 1000000u);
  EXPECT_EQ(parse_count("1e6"), 1000000u);
  EXPECT_EQ(parse_count("1E6"), 1000000u);
  EXPECT_EQ(parse_count("2.5e5"), 250000u);
  EXPECT_EQ(parse_count("1M"), 1000000u);
  EXPECT_EQ(parse_count("1m"), 1000000u);
  EXPECT_EQ(parse_count("250k"), 250000u);
  EXPECT_EQ(parse_count("1.1M"), 1100000u);
  EXPECT_EQ(parse_count("2G"), 2000000000u);
  EXPECT_EQ(parse_count("18446744073709551615"), UINT64_MAX);
}

TEST_F(CountOption, RefusesWhatIsNoCount) {
  for (const char* text : {"",     "k",    "-1",   "-1k",  "+1",  "1.5",   "1e-3",
                           "1e6x", "1kk",  "many", "inf",  "nan", "1e300", "_1",
                           "1_",   "1__0", "1,",   "0x10", " 1",  "1 ",    "18446744073709551616",
                           "1e",   "1.2.3"})
    EXPECT_EQ(parse_count(text), std::nullopt) << text;
}

TEST_F(CountOption, ReadsSizesAsPeopleWriteThem) {
  constexpr uint64_t kGigabyte = uint64_t{1} << 30;
  for (const char* text :
       {"1GB", "1gb", "1G", "1GiB", "1 GB", "1024MB", "1048576k", "1073741824", "1073741824B"})
    EXPECT_EQ(parse_size(text), kGigabyte) << text;
  EXPECT_EQ(parse_size("1.5GB"), kGigabyte / 2 * 3);
  EXPECT_EQ(parse_size("0.5kB"), 512u);
  EXPECT_EQ(parse_size("2TB"), 2048 * kGigabyte);
  EXPECT_EQ(parse_size("0"), 0u);
}

TEST_F(CountOption, RefusesWhatIsNoSize) {
  for (const char* text : {"", "-1", "-1GB", "+1", "99999999999999999999", "9223372036854775808", "1e400", "GB",
                           "1XB", "1BB", "1kkB", "1.2.3", "1G B", "inf", "nan", "0x10", "many", "9999999TB"})
    EXPECT_EQ(parse_size(text), std::nullopt) << text;
  for (const char* text : {"99999999999999999999", "-1", "1.5XB"})
    for (const std::vector<std::string>& command : {std::vector<std::string>{"encode", "a.ply", "a.glb"},
                                                    {"decode", "a.glb", "b.glb"},
                                                    {"validate", "a.glb"},
                                                    {"diff", "a.glb", "b.glb"},
                                                    {"batch", "a.glb", "--out-dir", "out"}}) {
      std::vector<std::string> words = command;
      words.push_back("--memory=" + std::string(text));
      fails(1, words,
            std::string("--memory: ") + text + " is not a size below 2^63 bytes, such as 512MB or 1.5GB");
    }
}

TEST_F(CountOption, StandsInTheCommand) {
  const std::string mesh = path("a.glb");
  must_run({"generate", mesh, "--faces", "3e3", "-q"});
  const auto patches = [&](const std::string& option, const std::string& count) {
    const auto report = json_of({"encode", mesh, path("b.glb"), option, count, "--report", "-", "-q"});
    return report.at("total").at("patches").get<int>();
  };
  EXPECT_EQ(patches("--patch-faces", "1k"), 3);
  EXPECT_EQ(patches("--patches", "0.5e1"), 5);
  fails(1, {"generate", mesh, "--faces", "lots"},
        "--faces: lots is not a count from 1 to 4294967295, such as 250000, 250k or 2.5e5");
}

}  // namespace
}  // namespace psplit
