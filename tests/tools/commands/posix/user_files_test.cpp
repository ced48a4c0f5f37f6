// No command replaces or removes a file that it did not make. If one command refuses a broken asset, all do.
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "gltf_ext/json/json.h"
#include "tests/support/child.h"
#include "tests/tools/run_command.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using namespace std::string_literals;

const std::string kPng = "\x89PNG\r\n\x1a\n"s + "pixels";

class UserFiles : public CommandTest {
 protected:
  std::string text(const std::string& name) const { return read_bytes(path(name)); }
  Json json(const std::string& name) const { return Json::parse(text(name)); }

  // Makes a .gltf with an image in a folder of its own. Returns the name of its .bin.
  std::string sample(const std::string& folder = "in", const std::string& pixels = kPng) {
    fs::create_directories(folder_ / folder);
    must_run({"generate", path(folder + "/a.gltf"), "--faces", "800", "--texcoords", "-q"});
    Json asset = json(folder + "/a.gltf");
    asset["images"] = Json::array({{{"uri", "x.png"}}});
    write(folder + "/a.gltf", asset.dump());
    write(folder + "/x.png", pixels);
    return folder + "/" + asset["buffers"][0]["uri"].get<std::string>();
  }
};

TEST_F(UserFiles, ImagesOfTwoAssetsStandSideBySide) {
  sample("a");
  sample("b", kPng + " of another");
  fs::create_directories(folder_ / "out");
  for (const std::string name : {"a", "b"})
    must_run({"encode", path(name + "/a.gltf"), path("out/" + name + ".gltf")});
  EXPECT_TRUE(contains(err_, "x.png"));
  EXPECT_EQ(text("out/x.png"), kPng);
  EXPECT_EQ(text("out/" + json("out/b.gltf")["images"][0]["uri"].get<std::string>()), kPng + " of another");

  must_run({"encode", path("a/a.gltf"), path("out/c.glb"), "--report", path("r.json")});
  EXPECT_EQ(json("r.json")["images"]["embedded"], 1);
  EXPECT_TRUE(contains(text("out/c.glb"), kPng));
  must_run({"encode", path("a/a.gltf"), "-", "-q"});
  EXPECT_TRUE(contains(out_, kPng)) << "stdout is whole, too";
  must_run({"decode", path("out/c.glb"), path("out/d.gltf"), "--images", "reference", "-q"});
  EXPECT_EQ(run({"encode", path("a/a.gltf"), "-", "--images", "copy"}), 1);
  EXPECT_EQ(run({"encode", path("a/a.gltf"), path("e.glb"), "--images", "fold"}), 1);
}

TEST_F(UserFiles, WhatDanglesIsSaid) {
  sample();
  fs::remove(path("in/x.png"));
  must_run({"encode", path("in/a.gltf"), path("b.glb")});
  EXPECT_TRUE(contains(err_, "image 0"));
  for (const std::string file : {"b.glb", "in/a.gltf"}) {
    must_run({"validate", path(file)});
    EXPECT_TRUE(contains(out_, "warning [linked-file]"));
    EXPECT_TRUE(contains(out_, "x.png"));
    must_run({"inspect", path(file), "--format", "json"});
    EXPECT_EQ(Json::parse(out_)["warnings"].size(), 1u);
    EXPECT_TRUE(contains(err_, "x.png"));
  }
}

TEST_F(UserFiles, ReportsAndPicturesReplaceNoInput) {
  const std::string binary = sample();
  fs::create_directories(folder_ / "out");
  fs::create_symlink("in/x.png", folder_ / "link.png");
  fs::create_hard_link(path(binary), path("hard.json"));
  must_run({"encode", path("in/a.gltf"), path("out/b.gltf"), "-q"});
  const std::vector<std::string> files = {"in/a.gltf", binary, "in/x.png"};
  std::vector<std::string> before;
  for (const std::string& file : files) before.push_back(text(file));
  for (const std::string file : {"in/a.gltf", "in/x.png", "link.png", "hard.json", "out/../in/a.gltf"}) {
    fails(1, {"encode", path("in/a.gltf"), path("out/c.glb"), "--report", path(file)}, "--report");
    EXPECT_EQ(run({"decode", path("in/a.gltf"), path("out/c.glb"), "--report", path(file)}), 1) << file;
    for (const std::string command : {"validate", "inspect"}) {
      EXPECT_EQ(run({command, path("in/a.gltf"), "-o", path(file)}), 1) << command << file;
      EXPECT_EQ(run({command, path("out/b.gltf"), path("in/a.gltf"), "--format", "json", "-o", path(file)}), 1)
          << command << file;
    }
    EXPECT_EQ(run({"batch", path("in/a.gltf"), "--out-dir", path("out2"), "--report", path(file)}), 1) << file;
    EXPECT_TRUE(run({"compare", path("in/a.gltf"), "--repeat", "1", "-o", path(file)}) == 1 || lacks_library())
        << file;
    EXPECT_EQ(run({"diff", path("in/a.gltf"), path("out/b.gltf"), "-o", path(file)}), 1) << file;
    EXPECT_EQ(run({"diff", path("out/b.gltf"), path("in/a.gltf"), "-o", path(file)}), 1) << file;
  }
  for (const std::string file : {"out/../out/c.glb", "out/x.png"})
    EXPECT_EQ(run({"encode", path("in/a.gltf"), path("out/c.glb"), "--images", "copy", "--report", path(file)}),
              1);
  EXPECT_EQ(text("out/x.png"), kPng);
  for (const std::string file : {"in/x.png", "link.png"})
    EXPECT_EQ(run({"inspect", path("in/a.gltf"), "--preview", path(file), "--preview-size", "16"}), 1) << file;
  EXPECT_EQ(run({"encode", path("in/a.gltf"), path("out/c.glb"), "--report", path(binary)}), 1);
  for (size_t i = 0; i < files.size(); ++i) EXPECT_EQ(text(files[i]), before[i]) << files[i];
}

TEST_F(UserFiles, InPlaceKeepsTheInputsBinary) {
  for (const std::string output : {"a.gltf", "link.gltf", "hard.gltf"}) {
    fs::remove_all(folder_ / "in");
    const std::string binary = sample();
    const std::string before = text(binary);
    fs::create_symlink("a.gltf", folder_ / "in" / "link.gltf");
    fs::create_hard_link(path("in/a.gltf"), path("in/hard.gltf"));
    must_run({"encode", path("in/a.gltf"), path("in/" + output), "-q", "--force"});
    EXPECT_EQ(text(binary), before) << output;
    EXPECT_EQ(text("in/x.png"), kPng) << output;
    must_run({"decode", path("in/" + output), path("again.glb"), "-q"});
    must_run({"encode", path("in/hard.gltf"), path("again.glb"), "-q"});
  }
}

TEST_F(UserFiles, NoOutputReplacesItsInputUnlessThatIsMeant) {
  const std::string binary = sample();
  must_run({"encode", path("in/a.gltf"), path("a.glb"), "-q", "--condense", "--always-patches"});
  const std::string before = text("a.glb");
  fs::create_symlink("a.glb", folder_ / "link.glb");
  fs::create_hard_link(path(binary), path("hard.glb"));
  for (const std::string verb : {"encode", "decode", "expand"}) {
    for (const std::string output : {"a.glb", "link.glb", "in/../a.glb"}) {
      fails(1, {verb, path("a.glb"), path(output)}, "a.glb, a file of an asset; --force replaces it");
    }
    EXPECT_EQ(run({verb, path("in/a.gltf"), path("hard.glb")}), 1) << "it is the .bin of the input";
    EXPECT_EQ(text("a.glb"), before);
    must_run({verb, path("a.glb"), path("link.glb"), "--force", "-q"});
    write("a.glb", before);
  }
  EXPECT_EQ(run({"encode", path("a.glb"), path("link.glb"), "--memory", "1GB"}), 1);
}

TEST_F(UserFiles, ReadOnlyOutputsNeedForceAndAllKeepTheirMode) {
  sample();
  must_run({"encode", path("in/a.gltf"), path("in/b.glb"), "-q"});
  const std::vector<std::vector<std::string>> commands = {
      {"encode", path("in/a.gltf"), path("out.glb")},
      {"encode", path("in/a.gltf"), path("out.gltf")},
      {"encode", path("in/a.gltf"), path("other.glb"), "--report", path("out.json")},
      {"decode", path("in/b.glb"), path("out.glb")},
      {"expand", path("in/b.glb"), path("out.glb")},
      {"generate", path("out.glb"), "--faces", "200"},
      {"generate", path("out.ply"), "--faces", "200"},
      {"inspect", path("in/b.glb"), "-o", path("out.txt")},
      {"inspect", path("in/b.glb"), "--preview", path("out.png"), "--preview-size", "16"},
      {"validate", path("in/b.glb"), "-o", path("out.txt")},
      {"diff", path("in/a.gltf"), path("in/b.glb"), "-o", path("out.txt")},
      {"completion", "bash", "-o", path("out.txt")},
      {"batch", "plan", path("in/a.gltf"), "--out-dir", path("d"), "-o", path("out.jsonl")}};
  for (std::vector<std::string> words : commands) {
    std::string output;
    for (const std::string& word : words)
      if (word.find("/out.") != std::string::npos) output = word;
    words.push_back("-q");
    if (run(words) != 0 && lacks_library()) continue;
    std::ofstream(output) << "old";
    fs::permissions(output, fs::perms{0444});
    fails(2, words, "is read-only; --force replaces it");
    EXPECT_EQ(read_bytes(output), "old");
    fs::permissions(output, fs::perms{0640});
    must_run(words);
    EXPECT_EQ(fs::status(output).permissions(), fs::perms{0640}) << words[0];
    std::ofstream(output) << "old";
    fs::permissions(output, fs::perms{0400});
    words.push_back("--force");
    must_run(words);
    EXPECT_EQ(fs::status(output).permissions(), fs::perms{0400}) << words[0];
    EXPECT_NE(read_bytes(output), "old");
    fs::remove(output);
  }
}

TEST_F(UserFiles, NamesThatTerminalsWouldObeyAreEscaped) {
  fails(2, {"encode", path("a\x1b[2J\n.glb"), path("b.glb")}, "a\\x1B[2J\\x0A.glb");
  EXPECT_EQ(std::ranges::count(err_, '\n'), 1) << err_;
}

TEST_F(UserFiles, LinksToNothingAreFollowed) {
  sample();
  fs::create_directories(folder_ / "far");
  for (const std::string name : {"x.glb", "x.gltf"}) {
    fs::create_symlink("far/" + name, folder_ / name);
    must_run({"encode", path("in/a.gltf"), path(name), "-q"});
    EXPECT_TRUE(fs::is_symlink(folder_ / name));
    must_run({"validate", path("far/" + name), "-q"});
  }
  fs::create_symlink("none/x.glb", folder_ / "nowhere.glb");
  EXPECT_EQ(run({"encode", path("in/a.gltf"), path("nowhere.glb"), "-q"}), 2);
  EXPECT_TRUE(fs::is_symlink(folder_ / "nowhere.glb"));
}

TEST_F(UserFiles, OnlyBinariesOfOursGo) {
  sample();
  must_run({"encode", path("in/a.gltf"), path("b.gltf"), "-q"});
  const std::string first = json("b.gltf")["buffers"][0]["uri"];
  must_run({"encode", path("in/a.gltf"), path("b.gltf"), "-q", "--quantize-position", "9"});
  const std::string second = json("b.gltf")["buffers"][0]["uri"];
  EXPECT_NE(first, second);
  EXPECT_FALSE(fs::exists(path(first))) << "made for the .gltf that is no more";
  const std::string changed = text(second) + "and more of the user's own";
  write(second, changed);
  must_run({"encode", path("in/a.gltf"), path("b.gltf"), "-q"});
  EXPECT_EQ(text(second), changed) << "has not the content that its name says";
}

TEST_F(UserFiles, TheLimitOnAFilesSizeIsAnError) {
  sample();
  const auto encode_with_limit = [&] {
    const rlimit limit{1024, 1024};
    return setrlimit(RLIMIT_FSIZE, &limit) == 0 ? run({"encode", path("in/a.gltf"), path("b.glb"), "-q"}) : 99;
  };
  EXPECT_EQ(run_in_child(encode_with_limit), 2);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing is left";
}

TEST_F(UserFiles, AFallbackIsABinaryOfItsOwn) {
  sample();
  must_run({"encode", path("in/a.gltf"), path("b.gltf"), "-q", "--fallback", "uncompressed"});
  const Json asset = json("b.gltf");
  ASSERT_EQ(asset["buffers"].size(), 2u);
  const Json& primitive = asset["meshes"][0]["primitives"][0];
  const Json& patches = primitive["extensions"].front();
  EXPECT_EQ(asset["bufferViews"][patches["bufferView"].get<size_t>()]["buffer"], 0);
  for (const Json& index : primitive["attributes"]) {
    const size_t view = asset["accessors"][index.get<size_t>()]["bufferView"];
    EXPECT_EQ(asset["bufferViews"][view]["buffer"], 1);
  }
  EXPECT_LT(text(asset["buffers"][0]["uri"]).size(), text(asset["buffers"][1]["uri"]).size() / 2);
  must_run({"validate", path("b.gltf")});
  must_run({"decode", path("b.gltf"), path("c.gltf"), "-q"});
  EXPECT_EQ(json("c.gltf")["buffers"].size(), 1u);
  must_run({"encode", path("in/a.gltf"), path("b.glb"), "-q", "--fallback", "uncompressed"});
  must_run({"diff", path("b.glb"), path("b.gltf"), "--tolerance", "0", "-q"});
}

void collect_places(const Json& tree, const Json::json_pointer& at, std::vector<Json::json_pointer>& places) {
  if (!at.empty()) places.push_back(at);
  if (tree.is_object())
    for (const auto& [name, value] : tree.items()) collect_places(value, at / name, places);
  if (tree.is_array())
    for (size_t i = 0; i < tree.size(); ++i) collect_places(tree[i], at / i, places);
}

// Each value of the JSON is removed, and replaced by other values, most of them of another type.
std::vector<Json> mutants(const Json& tree) {
  const Json others[] = {nullptr, -1, 1, 1e300, "x", Json::array({0, "1"}), Json::object()};
  std::vector<Json::json_pointer> places;
  collect_places(tree, Json::json_pointer(), places);
  std::vector<Json> all;
  for (const Json::json_pointer& place : places) {
    for (const Json& other : others) {
      all.push_back(tree);
      all.back()[place] = other;
    }
    if (!tree[place.parent_pointer()].is_object()) continue;
    all.push_back(tree);
    all.back()[place.parent_pointer()].erase(place.back());
  }
  return all;
}

// Each value has seven mutants or eight. Every third is tried, so that each value changes twice.
TEST_F(UserFiles, AllCommandsRefuseTheSameMutants) {
  constexpr size_t kStep = 3;
  fs::create_directories(folder_ / "plain");
  must_run({"generate", path("plain/a.gltf"), "--faces", "60", "-q"});
  must_run({"encode", path("plain/a.gltf"), path("a.gltf"), "-q", "--patches", "2", "--always-patches"});
  for (const std::string name : {"plain/a.gltf", "a.gltf"}) {
    const std::string folder = name == "a.gltf" ? "" : "plain/";
    const std::vector<Json> all = mutants(json(name));
    for (size_t i = 0; i < all.size(); i += kStep) {
      const Json& mutant = all[i];
      write(folder + "mutant.gltf", mutant.dump());
      const auto code_of = [&](std::vector<std::string> words) {
        words.insert(words.begin() + 1, path(folder + "mutant.gltf"));
        words.push_back("-q");
        return run(words);
      };
      const int validated = code_of({"validate"});
      EXPECT_TRUE(validated == 0 || validated == 2 || validated == 3 || validated == 5) << validated << mutant;
      EXPECT_EQ(code_of({"encode", path("out.glb"), "-j", "1"}), validated) << err_ << out_ << mutant;
      EXPECT_EQ(code_of({"decode", path("out.glb"), "-j", "1"}), validated) << err_ << out_ << mutant;
      const int inspected = code_of({"inspect"});
      EXPECT_TRUE(inspected == 0 || inspected == validated) << inspected << " " << validated << mutant;
    }
  }
}

TEST_F(UserFiles, ZerosThatNothingStandsForAreRefused) {
  const char* const claims[] = {
      R"({"asset":{"version":"2.0"},"accessors":[{"componentType":5126,"type":"VEC3","count":30000000}],
          "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})",
      R"({"asset":{"version":"2.0"},"accessors":[{"componentType":5126,"type":"VEC3","count":3},
          {"componentType":5125,"type":"SCALAR","count":30000000}],
          "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]})",
  };
  for (const char* const claim : claims) {
    write("claim.gltf", claim);
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"encode", path("claim.gltf"), path("out.glb")},
          {"decode", path("claim.gltf"), path("out.glb")},
          {"validate", path("claim.gltf")},
          {"inspect", path("claim.gltf")}}) {
      EXPECT_EQ(run(words), 3) << words.front();
      EXPECT_TRUE(contains(out_ + err_, "claim.gltf"));
    }
  }
}

}  // namespace
}  // namespace psplit
