// gltf-psplit batch: which files it reads and writes, and which outputs are up to date.
#include <array>
#include <fstream>
#include <map>

#include "system/io_error.h"
#include "tests/tools/batch/batch_files.h"
#include "tools/gltf_psplit/batch/batch_plan.h"
#include "tools/gltf_psplit/batch/batch_record.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class Batch : public BatchFiles {
 protected:
  // Runs a batch on everything in "in", and keeps the report in report_.
  int batch(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"batch",     path("in") + "/**/*", "--out-dir",
                                      path("out"), "--report",           path("report.json"),
                                      "-q",        "--patch-faces",      "200"};
    words.insert(words.end(), more.begin(), more.end());
    fs::remove(path("report.json"));
    const int code = run(words);
    report_ = fs::exists(path("report.json")) ? Json::parse(read_bytes(path("report.json"))) : Json();
    return code;
  }
  std::string status_of(const std::string& name) const {
    for (const Json& asset : report_["assets"])
      if (asset["output"] == path("out/" + name)) return asset["status"].get<std::string>();
    return "not in the report";
  }
  std::array<int, 3> counts() const {
    return {report_["encoded"].get<int>(), report_["up_to_date"].get<int>(), report_["failed"].get<int>()};
  }
  using Counts = std::array<int, 3>;

  Expected<std::vector<BatchItem>> plan(const std::vector<std::string>& words,
                                        const std::string& base = "") const {
    return plan_batch({words, folder_ / "out", base.empty() ? "" : path(base), ".glb"});
  }
  std::string names(const std::vector<std::string>& words, const std::string& base = "") const {
    const auto items = plan(words, base);
    if (!items) return items.status().message();
    std::string text;
    for (const BatchItem& item : *items) text += item.name + " ";
    return text;
  }

  Json report_;
};

TEST_F(Batch, PatternsListsAndFilesKeepTheirRelativePaths) {
  for (const char* name :
       {"in/a.glb", "in/x/b.gltf", "in/x/y/c.PLY", "in/x/y/c.bin", "in/.hidden/d.glb", "out/x/b.glb"})
    write(name, "");
  write("list", "# comment\n" + path("in/a.glb") + "\n\r\n#\r\n" + path("in/x") + "/*\r\n" + path("in/a.glb"));
  EXPECT_EQ(names({path("in/**/*")}), "a.glb x/b.glb x/y/c.glb ");
  EXPECT_EQ(names({path("in/*/*/c.???")}), "x/y/c.glb ");
  // A folder means all assets below it; its name is not a pattern.
  EXPECT_EQ(names({path("in")}), "a.glb x/b.glb x/y/c.glb ");
  write("in/x/[ab]/e.glb", "");
  EXPECT_EQ(names({path("in/x/[ab]"), path("in/a.glb")}), "a.glb x/[ab]/e.glb ");
  fs::remove_all(path("in/x/[ab]"));
  EXPECT_EQ(names({path("in/[a-b].glb")}), "a.glb ");
  EXPECT_EQ(names({"@" + path("list")}), "a.glb x/b.glb ");
  EXPECT_EQ(names({path("in/x/b.gltf")}), "b.glb ");
  EXPECT_EQ(names({path("in/x/b.gltf")}, "in"), "x/b.glb ");
  EXPECT_EQ(names({path("in/x/b.gltf"), path("in/missing.glb")}), "x/b.glb missing.glb ");
  // Outputs are not read as inputs.
  EXPECT_EQ(names({path("**/*.glb")}), "in/a.glb ");
}

TEST_F(Batch, RefusesWhatCannotGoWellBeforeAnyWork) {
  for (const char* name : {"in/a.glb", "in/a.gltf", "in/x/a.glb", "in/notes.txt"}) write(name, "");
  const auto refusal = [&](const std::vector<std::string>& words, const std::string& base = "") {
    const auto items = plan(words, base);
    EXPECT_EQ(items.status().code(), StatusCode::kUsage);
    return items.status().message();
  };
  EXPECT_TRUE(contains(refusal({path("in/*")}), "would both become"));
  EXPECT_TRUE(contains(refusal({path("in/*.stl")}), "no asset matches"));
  EXPECT_TRUE(contains(refusal({path("in/*.txt")}), "no asset matches"));
  EXPECT_TRUE(contains(refusal({path("in")}), "would both become"));
  fs::create_directory(path("in/empty"));
  EXPECT_TRUE(contains(refusal({path("in/empty")}), "no asset is in the folder"));
  EXPECT_TRUE(contains(refusal({path("in/a.glb")}, "in/x"), "is not below"));
  EXPECT_TRUE(contains(refusal({"-"}), "stdin"));
  const auto in_place = plan_batch({{path("in/a.glb")}, folder_ / "in", "", ".glb"});
  EXPECT_EQ(in_place.status().code(), StatusCode::kUsage);
  EXPECT_TRUE(contains(in_place.status().message(), "would replace"));
  const auto only_outputs = plan_batch({{path("in/*.glb")}, folder_ / "in", "", ".glb"});
  EXPECT_EQ(only_outputs.status().code(), StatusCode::kUsage);
  EXPECT_TRUE(contains(only_outputs.status().message(), "which is for the outputs"));
  EXPECT_EQ(plan({"@" + path("none")}).status().code(), StatusCode::kIo);
  EXPECT_EQ(batch(), 1);
  EXPECT_FALSE(fs::exists(path("out")));
}

TEST_F(Batch, NeverReplacesWhatItReadsByAnyName) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  generate("in/a.glb");
  const std::string before = read_bytes(path("in/a.glb"));
  fs::create_directory_symlink("in", path("link"));
  EXPECT_EQ(run({"batch", path("in/*.glb"), "--out-dir", path("link"), "-q"}), 1);
  EXPECT_EQ(run({"batch", path("in/*.glb"), "--out-dir", path("out"), "--report", path("link/a.glb"), "-q"}),
            1);
  EXPECT_EQ(run({"batch", path("in/*.glb"), "--out-dir", path("out"), "--report", path("out/./a.glb"), "-q"}),
            1);
  EXPECT_EQ(read_bytes(path("in/a.glb")), before);
}

// Files that no batch made are neither replaced nor removed, whatever their names.
TEST_F(Batch, TouchesNoFilesOfOthers) {
  generate("in/a.glb");
  generate("in/b.glb");
  const std::vector<std::string> theirs = {"out/a.glb", "out/b.glb.part", "out/b.glb.part123",
                                           "out/b.glb.psplit-0123456789abcdef.part"};
  for (const std::string& name : theirs) write(name, "theirs");
  EXPECT_EQ(batch(), 1);
  EXPECT_TRUE(contains(err_, "a.glb"));
  EXPECT_EQ(status_of("a.glb"), "failed");
  EXPECT_EQ(status_of("b.glb"), "encoded");
  for (const std::string& name : theirs) EXPECT_EQ(read_bytes(path(name)), "theirs") << name;
  fs::remove(path("out/a.glb"));
  EXPECT_EQ(batch(), 0) << err_;
}

TEST_F(Batch, WhatWasNotVerifiedIsNotUpToDateForOneWhoAsks) {
  generate("in/a.glb");
  ASSERT_EQ(batch({"--no-verify"}), 0) << err_;
  ASSERT_EQ(batch(), 0) << err_;
  EXPECT_EQ(status_of("a.glb"), "encoded");
  ASSERT_EQ(batch(), 0) << err_;
  EXPECT_EQ(status_of("a.glb"), "up to date");
}

TEST_F(Batch, NamesNeedNotBeUtf8) {
  if (!is_posix()) GTEST_SKIP() << "names are UTF-16";
  generate("in/\xff.glb");
  ASSERT_EQ(batch(), 0) << err_;
  EXPECT_EQ(report_["encoded"], 1);
  ASSERT_EQ(batch(), 0) << err_;
  EXPECT_EQ(report_["up_to_date"], 1);
}

TEST_F(Batch, EncodesOnlyWhatChanged) {
  generate("in/a.glb");
  generate("in/x/b.gltf");
  generate("in/x/\xC3\xBC \xE6\xA8\xA1.glb");
  ASSERT_EQ(batch(), 0) << err_;
  EXPECT_EQ(counts(), (Counts{3, 0, 0}));
  EXPECT_EQ(report_["total"]["input"]["faces"], 3 * report_["assets"][0]["total"]["input"]["faces"].get<int>());
  for (const char* name : {"a.glb", "x/b.glb", "x/\xC3\xBC \xE6\xA8\xA1.glb"})
    must_run({"validate", path("out/") + name, "-q"});
  // The output is what `encode` writes.
  must_run({"encode", path("in/a.glb"), path("alone.glb"), "--patch-faces", "200", "-q"});
  EXPECT_EQ(read_bytes(path("out/a.glb")), read_bytes(path("alone.glb")));

  // A rerun reports the same totals, which are in the record.
  const Json total = report_["total"], files = report_["files"];
  ASSERT_EQ(batch(), 0);
  EXPECT_EQ(counts(), (Counts{0, 3, 0}));
  for (const char* name : {"input", "patches", "bytes"}) EXPECT_EQ(report_["total"][name], total[name]) << name;
  EXPECT_EQ(report_["files"], files);
  // An input has changed.
  generate("in/a.glb", "500", "2");
  ASSERT_EQ(batch(), 0);
  EXPECT_EQ(counts(), (Counts{1, 2, 0}));
  EXPECT_EQ(status_of("a.glb"), "encoded");
  // A buffer of an input has changed.
  const Json gltf = Json::parse(read_bytes(path("in/x/b.gltf")));
  const std::string binary = path("in/x/" + gltf["buffers"][0]["uri"].get<std::string>());
  std::string bytes = read_bytes(binary);
  bytes[1] = static_cast<char>(bytes[1] ^ 1);
  std::ofstream(binary, std::ios::binary) << bytes;
  ASSERT_EQ(batch(), 0);
  EXPECT_EQ(counts(), (Counts{1, 2, 0}));
  EXPECT_EQ(status_of("x/b.glb"), "encoded");
  // An option has changed; then an option that does not affect the bytes.
  ASSERT_EQ(batch({"--lossless"}), 0);
  EXPECT_EQ(counts(), (Counts{3, 0, 0}));
  ASSERT_EQ(batch({"--lossless", "-j", "1"}), 0);
  EXPECT_EQ(counts(), (Counts{0, 3, 0}));
  // An output has changed, or is gone.
  fs::remove(path("out/a.glb"));
  std::string output = read_bytes(path("out/x/b.glb"));
  output.back() = static_cast<char>(output.back() ^ 1);
  std::ofstream(path("out/x/b.glb"), std::ios::binary) << output;
  ASSERT_EQ(batch({"--lossless"}), 0);
  EXPECT_EQ(counts(), (Counts{2, 1, 0}));
}

// Readers need not see all bytes of a file, but a file with other bytes is another file.
TEST_F(Batch, AnyOtherByteOfAnOutputIsAChange) {
  generate("in/a.glb");
  const auto binary = [&] {
    return path("out/" + Json::parse(read_bytes(path("out/a.gltf")))["buffers"][0]["uri"].get<std::string>());
  };
  enum class Change { kAppended, kCut, kFlipped };
  for (const std::string part : {"glb", "gltf", "bin"}) {
    const std::string form = part == "glb" ? "glb" : "gltf";
    ASSERT_EQ(batch({"--as", form}), 0) << err_;
    for (const Change change : {Change::kAppended, Change::kCut, Change::kFlipped}) {
      const std::string file = part == "bin" ? binary() : path("out/a." + part);
      std::string bytes = read_bytes(file);
      const auto time = fs::last_write_time(file);
      if (change == Change::kAppended) bytes += ' ';
      if (change == Change::kCut) bytes.pop_back();
      if (change == Change::kFlipped) bytes.back() = static_cast<char>(bytes.back() ^ 1);
      std::ofstream(file, std::ios::binary) << bytes;
      fs::last_write_time(file, time);
      ASSERT_EQ(batch({"--as", form}), 0) << err_;
      EXPECT_EQ(counts(), (Counts{1, 0, 0})) << file << static_cast<int>(change);
      ASSERT_EQ(batch({"--as", form}), 0) << err_;
      EXPECT_EQ(counts(), (Counts{0, 1, 0})) << file << static_cast<int>(change);
    }
  }
  // What has bytes of someone else's stays.
  generate("in/kept.glb", "500", "2");
  ASSERT_EQ(batch(), 0) << err_;
  std::ofstream(path("out/a.glb"), std::ios::binary | std::ios::app) << "theirs";
  fs::remove(path("in/a.glb"));
  ASSERT_EQ(run({"batch", path("in/*.glb"), "-o", path("out"), "--prune", "--force"}), 0) << err_;
  EXPECT_TRUE(fs::exists(path("out/a.glb")));
}

TEST_F(Batch, WritesGltfToo) {
  generate("in/a.glb");
  ASSERT_EQ(batch({"--as", "gltf"}), 0);
  ASSERT_EQ(batch({"--as", "gltf"}), 0);
  EXPECT_EQ(counts(), (Counts{0, 1, 0}));
  must_run({"validate", path("out/a.gltf"), "-q"});
}

TEST_F(Batch, GoesOnAfterFailuresAndSaysWhich) {
  generate("in/a.glb");
  generate("in/b.glb");
  write("in/bad.glb", "glTF");
  write("in/worse.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"none.bin"}]})");
  EXPECT_EQ(batch({"-j", "2"}), 3);
  EXPECT_EQ(counts(), (Counts{2, 0, 2}));
  EXPECT_EQ(status_of("a.glb"), "encoded");
  EXPECT_EQ(status_of("bad.glb"), "failed");
  EXPECT_FALSE(fs::exists(path("out/bad.glb")));
  std::map<std::string, Json> errors;
  for (const Json& asset : report_["assets"])
    if (asset.contains("error")) errors[asset["input"].get<std::string>()] = asset["error"];
  EXPECT_EQ(errors[path("in/bad.glb")]["code"], 3);
  EXPECT_EQ(errors[path("in/worse.gltf")]["code"], 2);
  EXPECT_TRUE(contains(errors[path("in/worse.gltf")]["message"].get<std::string>(), "worse.gltf: "));
  EXPECT_TRUE(contains(err_, "2 of 4 assets failed"));
  // Only what failed is tried again.
  generate("in/bad.glb");
  EXPECT_EQ(batch(), 2);
  EXPECT_EQ(counts(), (Counts{1, 2, 1}));
}

TEST_F(Batch, ALinkToNothingIsAFailedAsset) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  generate("in/a.glb");
  write("other.txt", "");
  fs::create_symlink("missing.glb", path("in/gone.glb"));
  fs::create_symlink("loop.glb", path("in/loop.glb"));
  fs::create_symlink("missing.txt", path("in/notes.txt"));
  fs::create_directory_symlink(path("in"), path("in/folder.glb"));
  EXPECT_EQ(names({path("in/*")}), "a.glb gone.glb loop.glb ");
  EXPECT_EQ(batch(), 2);
  EXPECT_EQ(counts(), (Counts{1, 0, 2}));
  EXPECT_TRUE(contains(err_, "gone.glb: "));
}

TEST_F(Batch, OneAtATime) {
  generate("in/a.glb");
  BatchRecord other;
  ASSERT_TRUE(other.open(folder_ / "out", {}).ok());
  EXPECT_EQ(batch(), 75);
  EXPECT_TRUE(contains(err_, "another batch is running"));
  EXPECT_FALSE(fs::exists(path("out/a.glb")));
}

TEST_F(Batch, ShardsOfOneCountShareAFolderAndOthersWait) {
  BatchRecord first, second, third;
  ASSERT_TRUE(first.open(folder_, {0, 2}).ok());
  ASSERT_TRUE(second.open(folder_, {1, 2}).ok());
  EXPECT_EQ(third.open(folder_, {0, 3}).code(), StatusCode::kMayPass);
  EXPECT_EQ(BatchRecord().open(folder_, {1, 2}).code(), StatusCode::kMayPass);
}

std::unique_ptr<BatchRecord> loaded_record(const fs::path& folder) {
  auto record = std::make_unique<BatchRecord>();
  EXPECT_TRUE(record->open(folder, {}).ok());
  EXPECT_TRUE(record->load(folder, {}).ok());
  return record;
}

TEST_F(Batch, ARecordThatWasCutShortCountsForNothing) {
  {
    BatchRecord record;
    ASSERT_TRUE(record.open(folder_, {}).ok());
    ASSERT_TRUE(record.add("a", {"1", "2"}).ok());
    ASSERT_TRUE(record.add("b", {"3", "4"}).ok());
    ASSERT_TRUE(record.add("a", {"5", "6"}).ok());
  }
  const fs::path file = record_folder(folder_) / "0-of-1.jsonl";
  fs::resize_file(file, fs::file_size(file) - 3);
  {
    const auto record = loaded_record(folder_);
    EXPECT_TRUE(record->has("a", {"1", "2"}));
    EXPECT_FALSE(record->has("a", {"5", "6"}));
    EXPECT_TRUE(record->has("b", {"3", "4"}));
    EXPECT_FALSE(record->knows("c"));
    ASSERT_TRUE(record->add("c", {"7", "8"}).ok());
  }
  const auto record = loaded_record(folder_);
  EXPECT_TRUE(record->has("c", {"7", "8"}));
}

// Every file is read, whatever count of shards wrote it.
TEST_F(Batch, RecordsOfAllShardsAreFactsTogether) {
  for (const Shard& shard : {Shard{0, 2}, Shard{1, 2}, Shard{4, 5}}) {
    BatchRecord record;
    ASSERT_TRUE(record.open(folder_, shard).ok());
    ASSERT_TRUE(record.add("of " + shard.file_name(), {"1", "2"}).ok());
    ASSERT_TRUE(record.add("x", {"made from", shard.file_name()}).ok());
  }
  for (const bool merges : {false, true}) {
    if (merges) {
      ASSERT_TRUE(merge_records(folder_).ok());
    }
    const auto record = loaded_record(folder_);
    for (const char* name : {"of 0-of-2", "of 1-of-2", "of 4-of-5"})
      EXPECT_TRUE(record->has(name, {"1", "2"})) << name;
    EXPECT_TRUE(record->is_newest("x", "made from"));
    EXPECT_TRUE(record->has("x", {"made from", "4-of-5"}));
    EXPECT_EQ(record->has("x", {"made from", "0-of-2"}), !merges);
  }
  EXPECT_TRUE(fs::exists(record_folder(folder_) / "merged.jsonl"));
  EXPECT_FALSE(fs::exists(record_folder(folder_) / "4-of-5.jsonl"));
}

}  // namespace
}  // namespace psplit
