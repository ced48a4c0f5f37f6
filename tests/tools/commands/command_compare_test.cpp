// gltf-psplit compare: its table, its JSON, and its defaults.
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class CompareCommand : public CommandOnSamples {};

TEST_F(CompareCommand, ComparesInOneTable) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  const std::string input = sample("gyroid", "4000");
  const auto json =
      json_of({"compare", "--patches", "2,8", input, "--repeat", "2", "-j", "3", "--format", "json"});
  EXPECT_GT(json.at("faces").get<int>(), 3000);
  EXPECT_GT(json.at("points").get<int>(), 1000);
  for (const char* key : {"bytes", "encode_ms", "decode_ms"})
    EXPECT_GT(json.at("stock").at(key).get<double>(), 0);
  for (const char* key : {"bytes", "decode_ms"}) EXPECT_GT(json.at("meshopt").at(key).get<double>(), 0);
  ASSERT_EQ(json.at("splits").size(), 2u);
  EXPECT_EQ(json.at("splits").at(0).at("patches"), 2);
  EXPECT_EQ(json.at("splits").at(1).at("patches"), 8);
  for (const auto& split : json.at("splits")) {
    for (const char* key :
         {"patch_faces", "bytes", "overhead", "replication", "balance", "partition_ms", "encode_ms"})
      EXPECT_TRUE(split.at(key).is_number()) << key;
    EXPECT_NEAR(split.at("overhead").get<double>(),
                split.at("bytes").get<double>() / json.at("stock").at("bytes").get<double>() - 1, 1e-9);
    // Every decoder, on one thread and on as many threads as -j states.
    ASSERT_EQ(split.at("decode").size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
      const auto& decode = split.at("decode").at(i);
      EXPECT_EQ(decode.at("backend"), i < 2 ? "cpu" : "draco");
      EXPECT_EQ(decode.at("threads"), i % 2 == 0 ? 1 : 3);
      EXPECT_LE(decode.at("min_ms").get<double>(), decode.at("median_ms").get<double>());
      EXPECT_LE(decode.at("median_ms").get<double>(), decode.at("max_ms").get<double>());
      EXPECT_NEAR(decode.at("speedup").get<double>() * decode.at("median_ms").get<double>(),
                  json.at("stock").at("decode_ms").get<double>(), 1e-6);
    }
  }
  ASSERT_EQ(json.at("stock_speeds").size(), 3u);
  EXPECT_EQ(json.at("stock_speeds").at(1), json.at("stock"));
  EXPECT_GT(json.at("meshopt_plain").at("bytes").get<int>(), json.at("meshopt").at("bytes").get<int>());
  EXPECT_EQ(json.at("meshopt_brotli").is_null(), json.at("environment").at("brotli").is_null());
  if (!json.at("meshopt_brotli").is_null()) {
    EXPECT_LT(json.at("meshopt_brotli").at("bytes").get<int>(),
              json.at("meshopt_plain").at("bytes").get<int>());
    EXPECT_EQ(json.at("meshopt_brotli").at("codec_version"), json.at("meshopt").at("codec_version"));
  }
  EXPECT_EQ(json.at("splits").at(0).at("stages").size(), 5u);
  const auto& environment = json.at("environment");
  for (const char* key : {"cpu", "psplit", "draco", "meshoptimizer", "zstd", "compiler", "date"})
    EXPECT_NE(environment.at(key).get<std::string>(), "") << key;
  EXPECT_EQ(environment.at("command_line"), "gltf-psplit compare --patches 2,8 " +
                                                std::filesystem::path(input).filename().string() +
                                                " --repeat 2 -j 3 --format json");

  must_run({"compare", input, "--repeat", "1", "--stock-speeds", "7", "-o", path("table.txt")});
  EXPECT_EQ(out_, "");
  const std::string table = read_bytes(path("table.txt"));
  for (const char* word : {"stock Draco, speed 5", "stock Draco, speed 7", "meshopt ", " + zstd", "psplit"})
    EXPECT_TRUE(contains(table, word));
  EXPECT_FALSE(contains(table, "speed 10"));
  EXPECT_EQ(run({"compare", input, "--repeat", "1", "-o", path("no/such/folder.txt")}), 2);
}

TEST_F(CompareCommand, QuotesItsCommandLineForAShell) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  const std::string input = path("it's a mesh.glb");
  std::filesystem::copy(sample("terrain", "300"), input);
  const auto json = json_of({"compare", input, "--repeat", "1", "--format", "json"});
  EXPECT_EQ(json.at("environment").at("command_line"),
            "gltf-psplit compare 'it'\\''s a mesh.glb' --repeat 1 --format json");
}

TEST_F(CompareCommand, ReportsStateTheGainAndNameNoFolder) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  const std::string input = sample("gyroid", "4000"),
                    folder = std::filesystem::path(input).parent_path().string();
  for (const std::string format : {"text", "json", "html"}) {
    const std::string report = path("report." + format);
    must_run({"compare", input, "--patches", "2,4", "--repeat", "1", "--format", format, "--output=" + report});
    const std::string text = read_bytes(report);
    EXPECT_FALSE(contains(text, folder)) << format;
    EXPECT_TRUE(contains(text, std::filesystem::path(input).filename().string())) << format;
    EXPECT_TRUE(contains(text, "stock Draco on")) << format;
    if (format != "json") continue;
    const auto json = nlohmann::json::parse(text);
    EXPECT_TRUE(json.at("headline").get<std::string>().starts_with("In ")) << json.at("headline");
    const auto& recommendation = json.at("recommendation");
    EXPECT_TRUE(recommendation.at("patches") == 2 || recommendation.at("patches") == 4);
    EXPECT_NE(recommendation.at("text").get<std::string>(), "");
    EXPECT_FALSE(json.at("noise").empty());  // one round is too few
    EXPECT_TRUE(json.at("environment").at("command_line").get<std::string>().ends_with("--output=report.json"));
    EXPECT_EQ(json.at("meshopt").at("version"), json.at("environment").at("meshoptimizer"));
    EXPECT_TRUE(json.at("meshopt").at("codec_version").is_number());
    const auto& asset = json.at("asset");
    EXPECT_EQ(asset.at("texture_bytes"), 0);
    EXPECT_NEAR(asset.at("bytes").get<double>(), static_cast<double>(std::filesystem::file_size(input)), 300);
    EXPECT_EQ(asset.at("bytes_with_stock").get<int>() - asset.at("other_bytes").get<int>(),
              json.at("stock").at("bytes"));
  }
}

TEST_F(CompareCommand, ComparesFromOnePatchAPrimitiveOnByDefault) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  const std::string input = sample("scene", "12000");
  const auto splits = json_of({"compare", input, "--repeat", "1", "--format", "json"}).at("splits");
  ASSERT_GE(splits.size(), 2u);
  EXPECT_EQ(splits.front().at("patches"), 6);  // the number of primitives
  EXPECT_EQ(splits.front().at("replication"), 0);
  for (size_t i = 1; i < splits.size(); ++i)
    EXPECT_GT(splits.at(i).at("patches"), splits.at(i - 1).at("patches"));
}

TEST_F(CompareCommand, ComparesLosslessAndWithoutRefinement) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  const std::string input = sample("gyroid", "4000");
  const auto compared = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"compare", input, "--patches", "9", "--repeat", "1", "--format", "json"});
    return json_of(options);
  };
  const auto plain = compared({}), lossless = compared({"--lossless"}), jagged = compared({"--no-refine"});
  // Every point takes at least three floats.
  EXPECT_GT(lossless.at("stock").at("bytes").get<int>(), 12 * lossless.at("points").get<int>());
  EXPECT_LT(plain.at("stock").at("bytes").get<int>(), 6 * plain.at("points").get<int>());
  EXPECT_GT(lossless.at("meshopt").at("bytes").get<int>(), plain.at("meshopt").at("bytes").get<int>());
  const auto replication = [](const auto& json) { return json.at("splits").at(0).at("replication"); };
  EXPECT_EQ(replication(lossless), replication(plain));
  EXPECT_GT(replication(jagged).template get<double>(), 1.1 * replication(plain).template get<double>());
  EXPECT_NE(replication(compared({"--distance", "dijkstra"})), replication(plain));
  const CommandOutcome text =
      run_command({"compare", input, "--repeat", "1", "--patches", "2", "--lossless", "--no-refine"});
  EXPECT_TRUE(contains(text.out, "lossless, borders not refined"));
}

TEST_F(CompareCommand, ComparesOnlyUncompressedAssets) { EXPECT_EQ(run({"compare", split_sample()}), 5); }

TEST_F(CompareCommand, MeasuresCondensedPatchesBesideTheOthers) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  const std::string input = sample("gyroid", "12000");
  const auto compare = [&](const std::string& format) {
    must_run({"compare", input, "--patches", "6", "--condense", "--repeat", "1", "--backend", "cpu", "--format",
              format, "-q"});
    return out_;
  };
  const auto splits = nlohmann::json::parse(compare("json")).at("splits");
  ASSERT_EQ(splits.size(), 2u);
  for (const bool condensed : {false, true}) {
    const auto& split = splits.at(condensed ? 1 : 0);
    EXPECT_EQ(split.at("condensed"), condensed);
    EXPECT_EQ(split.at("patches"), 6);
    EXPECT_EQ(split.at("head_bytes").get<int>() > 0, condensed);
    EXPECT_EQ(split.at("stages").size(), 5u);
  }
  EXPECT_LT(splits.at(1).at("bytes"), splits.at(0).at("bytes"));
  const std::string text = compare("text");
  EXPECT_TRUE(contains(text, "psplit, condensed"));
  EXPECT_TRUE(contains(text, "6 condensed patches (--patches 6 --condense)"));
  const std::string page = compare("html");
  for (const char* words : {">6 condensed patches<", "psplit condensed, cpu, 1 thread", "directory and head"})
    EXPECT_TRUE(contains(page, words)) << words;
}

}  // namespace
}  // namespace psplit
