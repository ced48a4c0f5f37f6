// gltf-psplit batch as a job: shards, failures that may pass, signals, time-outs, memory, and object storage.
// Each test runs the command as a process of its own.
#include "tests/tools/batch/posix/batch_jobs.h"

#include <signal.h>
#include <sys/stat.h>

#include <algorithm>

#include "tools/gltf_psplit/batch/batch_record.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

TEST_F(BatchJobs, ShardsTogetherWriteWhatOneRunWrites) {
  generate_many(9);
  ASSERT_EQ(shell("$P batch 'in/*.glb' -o one --patch-faces 200 --report one.json -q"), 0) << err_;
  ASSERT_EQ(shell("$P batch plan 'in/*.glb' --out-dir many -o plan.jsonl --patch-faces 200 -q"), 0) << err_;
  size_t done = 0;
  for (const char* shard : {"0/3", "1/3", "2/3"}) {
    ASSERT_EQ(shell(std::string("$P batch --manifest plan.jsonl -o many --progress json -q --shard ") + shard),
              0);
    done += progress().size();
  }
  EXPECT_EQ(done, 9u);
  EXPECT_EQ(files("many"), files("one"));
  // Another number of shards finds everything done, before and after a merge.
  for (const bool merges : {false, true}) {
    for (const char* shard : {"0/2", "1/2", "0/1"}) {
      ASSERT_EQ(
          shell(std::string("$P batch --manifest plan.jsonl -o many --progress json -q --shard ") + shard), 0);
      EXPECT_EQ(count(progress(), "up to date"), progress().size()) << shard << merges;
    }
    if (merges) continue;
    ASSERT_EQ(shell("$P batch merge many --report merged.json -q"), 0) << err_;
  }
  const Json report = Json::parse(read_bytes(path("merged.json")));
  EXPECT_EQ(report["assets"].size(), 9u);
  EXPECT_EQ(report["up_to_date"], 9);
  const Json one = Json::parse(read_bytes(path("one.json")));
  EXPECT_EQ(report["files"], one["files"]);
  for (const char* name : {"input", "patches", "bytes"})
    EXPECT_EQ(report["total"][name], one["total"][name]) << name;
  EXPECT_EQ(report["shards"]["unfinished"].size(), 0u);
}

TEST_F(BatchJobs, MergeSaysWhichShardsHaveNotFinished) {
  generate_many(4);
  ASSERT_EQ(shell("$P batch 'in/*' -o out --shard 1/3 -q"), 0) << err_;
  ASSERT_EQ(shell("$P batch merge out --report merged.json -q"), 75);
  EXPECT_TRUE(contains(err_, "of 3 shards, these have not finished: 0, 2"));
  EXPECT_EQ(shell("$P batch merge nowhere"), 2);
}

// While an array runs, merge tells how far it is, and changes nothing.
TEST_F(BatchJobs, MergeTellsTheStateOfARunningArray) {
  generate_many(8);
  write("in/bad.glb", "glTF");
  uint32_t bad = 0;
  while (!Shard{bad, 4}.owns("bad.glb")) ++bad;
  const uint32_t good = (bad + 1) % 4, running = (bad + 2) % 4, missing = (bad + 3) % 4;
  for (const uint32_t shard : {bad, good})
    EXPECT_EQ(shell("$P batch 'in/*' -o out -q --shard " + std::to_string(shard) + "/4"), shard == bad ? 3 : 0);
  BatchRecord record;
  ASSERT_TRUE(record.open(folder_ / "out", {running, 4}).ok());
  EXPECT_EQ(shell("$P batch merge out --report merged.json"), 75);
  EXPECT_TRUE(contains(err_, "4 shards: 2 finished; 1 of them has failed assets: " + std::to_string(bad) +
                                 "; 1 runs: " + std::to_string(running) +
                                 "; 1 has not begun or was stopped: " + std::to_string(missing) + "\n"));
  const Json report = Json::parse(read_bytes(path("merged.json")));
  EXPECT_EQ(report["failed"], 1);
  const Json expected{{"count", 4},
                      {"unfinished", {std::min(running, missing), std::max(running, missing)}},
                      {"running", Json::array({running})},
                      {"failed", Json::array({bad})}};
  EXPECT_EQ(report["shards"], expected);
  EXPECT_TRUE(fs::exists(record_folder(folder_ / "out") / Shard{good, 4}.file_name().append(".jsonl")));
  EXPECT_FALSE(fs::exists(record_folder(folder_ / "out") / "merged.jsonl"));
}

// One line, for the logs of array jobs.
TEST_F(BatchJobs, ASummaryIsOneLine) {
  generate_many(2);
  ASSERT_EQ(shell("$P batch 'in/*' -o out -q --summary --shard 0/1"), 0);
  EXPECT_TRUE(err_.starts_with("gltf-psplit: shard 0/1 of out: 2 assets, 2 encoded, 0 up to date, 0 failed; "))
      << err_;
  EXPECT_EQ(err_.find('\n'), err_.size() - 1) << err_;
  write("in/bad.glb", "glTF");
  ASSERT_EQ(shell("$P batch 'in/*' -o out --summary"), 3);
  EXPECT_TRUE(contains(err_, "\ngltf-psplit: out: 3 assets, 0 encoded, 2 up to date, 1 failed; "));
  EXPECT_FALSE(contains(err_, "\nfailed: "));
}

TEST_F(BatchJobs, PruneRemovesOnlyWhatABatchMadeFromInputsThatAreGone) {
  for (const char* name : {"in/a.glb", "in/b.glb", "in/changed.glb", "in/x/c.glb", "other/d.glb"})
    generate(name);
  generate("in/kept.glb", "500", "2");
  ASSERT_EQ(shell("$P batch 'in/**/*.glb' -o out -q && $P batch 'other/*.glb' -o out -q && "
                  "$P batch 'in/**/a.glb' --base in -o out --as gltf -q"),
            0)
      << err_;
  for (const char* name : {"in/a.glb", "in/changed.glb", "in/x/c.glb", "other/d.glb"}) fs::remove(path(name));
  write("out/theirs.glb", "theirs");
  fs::copy_file(path("out/kept.glb"), path("out/changed.glb"), fs::copy_options::overwrite_existing);
  const auto before = files("out");
  // A pattern that leaves out b.glb does not make its output one whose input is gone.
  const std::string prune = "$P batch 'in/**/kept.glb' -o out --prune";
  ASSERT_EQ(shell(prune + " --force --dry-run"), 0) << err_;
  const std::string listed = out_;
  for (const char* name : {"out/a.glb\n", "out/a.gltf\n", "out/x/c.glb\n"}) EXPECT_TRUE(contains(out_, name));
  EXPECT_EQ(std::ranges::count(out_, '\n'), 3) << out_;
  EXPECT_TRUE(contains(err_, "out/changed.glb stays"));
  EXPECT_TRUE(contains(err_, "out: 3 outputs whose inputs are gone; --force removes them"));
  EXPECT_TRUE(files("out") == before);
  ASSERT_EQ(shell(prune + " -q"), 0) << err_;
  EXPECT_EQ(out_, listed);
  ASSERT_EQ(shell(prune + " --force -q"), 0) << err_;
  EXPECT_EQ(out_, listed);
  auto left = before;
  std::erase_if(left, [](const auto& file) { return file.first.starts_with("a.") || file.first == "x/c.glb"; });
  EXPECT_TRUE(files("out") == left);
  // The record forgets removed outputs: a file that somebody puts there later is kept, also after a merge.
  ASSERT_EQ(shell(prune), 0) << err_;
  EXPECT_EQ(out_, "");
  generate("in/a.glb");
  write("out/a.glb", "theirs");
  EXPECT_EQ(shell("$P batch 'in/**/*.glb' -o out -q"), 1);
  ASSERT_EQ(shell("$P batch merge out -q --report report.json"), 1);
  EXPECT_EQ(shell("$P batch 'in/**/*.glb' -o out -q"), 1);
  EXPECT_EQ(read_bytes(path("out/a.glb")), "theirs");
  write("plan.jsonl", "");
  EXPECT_EQ(shell("$P batch --manifest plan.jsonl -o out --prune"), 1);
  EXPECT_EQ(shell("$P batch 'in/**/*.glb' -o nowhere --prune"), 2);
  EXPECT_FALSE(fs::exists(path("nowhere")));
}

TEST_F(BatchJobs, EveryCopyOfAPlanIsCheckedBeforeTheWork) {
  generate_many(3);
  ASSERT_EQ(shell("$P batch plan 'in/*' --out-dir out -o plan.jsonl --lossless --hash -q"), 0) << err_;
  EXPECT_EQ(shell("$P batch --manifest plan.jsonl -o out --no-verify -q"), 1);
  EXPECT_TRUE(contains(err_, "--no-verify must be given to `batch plan`"));
  EXPECT_EQ(shell("sed s/0[.]1[.]0/0.0.9/ plan.jsonl >other.jsonl; $P batch --manifest other.jsonl -o out -q"),
            1);
  EXPECT_TRUE(contains(err_, "was planned by gltf-psplit 0.0.9"));
  EXPECT_EQ(shell("head -n 3 plan.jsonl >short.jsonl; $P batch --manifest short.jsonl -o out -q"), 3);
  EXPECT_TRUE(contains(err_, "the plan has 2 assets instead of 3"));
  EXPECT_EQ(shell("echo '{\"input\":\"in/0.glb\",\"name\":\"../x.glb\"}' >bad.jsonl; $P batch --manifest "
                  "bad.jsonl -o out"),
            3);
  EXPECT_TRUE(contains(err_, "line 1"));
  EXPECT_FALSE(fs::exists(path("x.glb")));
  // The options of the plan decide the outputs.
  ASSERT_EQ(shell("$P batch --manifest plan.jsonl -o out -q && $P encode in/0.glb alone.glb --lossless -q"), 0);
  EXPECT_EQ(read_bytes(path("out/0.glb")), read_bytes(path("alone.glb")));
  EXPECT_EQ(shell("$P batch plan 'in/*' --out-dir out -o in/0.glb"), 1);
}

// Nothing that outputs depend on is taken from the machine.
TEST_F(BatchJobs, ThreadsAndProfilesDoNotChangeBytes) {
  generate("in/a.glb", "30000");
  for (const char* profile : {"size", "speed", "speed --gpu H100"}) {
    const std::string options = std::string("$P batch in/a.glb --profile ") + profile;
    ASSERT_EQ(shell(options + " -o one -j 1 -q && " + options + " -o many -j 5 -q"), 0) << err_;
    EXPECT_EQ(files("one"), files("many")) << profile;
  }
}

TEST_F(BatchJobs, DryRunsWriteNothingAndForceRepeats) {
  generate_many(2);
  ASSERT_EQ(shell("$P batch 'in/*' -o out --dry-run --progress json -q"), 0) << err_;
  EXPECT_EQ(count(progress(), "planned"), 2u);
  EXPECT_FALSE(fs::exists(path("out")));
  ASSERT_EQ(shell("$P batch 'in/*' -o out -q"), 0);
  generate("in/1.glb", "500", "7");
  ASSERT_EQ(shell("$P batch 'in/*' -o out --dry-run --progress json -q"), 0) << err_;
  EXPECT_EQ(progress()["in/0.glb"], "up to date");
  EXPECT_EQ(progress()["in/1.glb"], "planned");
  ASSERT_EQ(shell("$P batch 'in/*' -o out --force --progress json -q"), 0) << err_;
  EXPECT_EQ(count(progress(), "encoded"), 2u);
  // --force does not replace files of others.
  write("out2/0.glb", "theirs");
  EXPECT_EQ(shell("$P batch 'in/*' -o out2 --force -q"), 1);
  EXPECT_EQ(read_bytes(path("out2/0.glb")), "theirs");
}

TEST_F(BatchJobs, ValidatesDecodesAndCompares) {
  generate_many(3);
  ASSERT_EQ(shell("$P batch 'in/*' -o out -q"), 0) << err_;
  for (const char* expected : {"compared", "up to date"}) {
    ASSERT_EQ(shell("$P batch 'in/*' -o out --command diff --progress json -q"), 0) << err_;
    EXPECT_EQ(count(progress(), expected), 3u) << out_;
  }
  for (const char* expected : {"validated", "up to date"}) {
    ASSERT_EQ(shell("$P batch 'out/*' -o checks --command validate --progress json -q"), 0) << err_;
    EXPECT_EQ(count(progress(), expected), 3u) << out_;
  }
  EXPECT_TRUE(files("checks").empty());
  ASSERT_EQ(shell("$P batch 'out/*' -o plain --command decode -q && $P decode out/0.glb alone.glb -q"), 0)
      << err_;
  EXPECT_EQ(read_bytes(path("plain/0.glb")), read_bytes(path("alone.glb")));
  // An output that holds another mesh.
  generate("in/1.glb", "500", "9");
  EXPECT_EQ(shell("$P batch 'in/*' -o out --command diff --progress json -q"), 7);
  EXPECT_EQ(progress()["in/1.glb"], "failed");
  EXPECT_EQ(count(progress(), "up to date"), 2u);
}

TEST_F(BatchJobs, SomeBadAssetsMayFail) {
  generate_many(2);
  write("in/bad.glb", "glTF");
  EXPECT_EQ(shell("$P batch 'in/*' -o out -q"), 3);
  EXPECT_EQ(shell("$P batch 'in/*' -o out -q --max-failures 1"), 0) << err_;
  write("in/worse.glb", "glTF");
  EXPECT_EQ(shell("$P batch 'in/*' -o out -q --max-failures 1"), 3);
}

// A pipe that nobody writes to: an asset that hangs.
TEST_F(BatchJobs, AnAssetThatHangsTimesOutAlone) {
  generate_many(6);
  ASSERT_EQ(mkfifo(path("hang.glb").c_str(), 0600), 0);
  EXPECT_EQ(shell("$P batch hang.glb 'in/*' -o out --timeout 3 --progress json -q -j 2"), 75);
  EXPECT_EQ(progress()["hang.glb"], "failed");
  EXPECT_EQ(count(progress(), "encoded"), 6u) << out_ << err_;
  EXPECT_TRUE(contains(err_, "hang.glb: took longer than the 3.0 s of --timeout"));
  expect_clean("out");
}

TEST_F(BatchJobs, OnlyTheAssetThatRunsOutOfMemoryFails) {
  if (!kMeasuresMemory) GTEST_SKIP() << "a sanitizer takes memory, too";
  generate_many(6);
  const std::string limited = "ulimit -v 70000; exec $P batch 'in/*' -o out --progress json -q -j 1";
  must_run({"generate", path("in/huge.glb"), "--faces", "800k", "-q"});
  EXPECT_EQ(shell(limited), 75);
  EXPECT_EQ(progress()["in/huge.glb"], "failed");
  EXPECT_EQ(count(progress(), "encoded"), 6u) << out_ << err_;
  expect_clean("out");
}

// An estimate may be too high: what does not fit runs alone.
TEST_F(BatchJobs, AnAssetThatDoesNotFitRunsAlone) {
  generate_many(3);
  generate("in/large.glb", "200k");
  EXPECT_EQ(shell("$P batch 'in/*' -o out --memory 30MB --progress json -q -j 3"), 0) << err_;
  EXPECT_EQ(count(progress(), "encoded"), 4u);
}

TEST_F(BatchJobs, MergeDoesNotTakeReportsOfAnotherPlan) {
  generate_many(4);
  for (const char* shard : {"0/2", "1/2"})
    ASSERT_EQ(shell(std::string("$P batch 'in/*' -o out -q --shard ") + shard), 0);
  ASSERT_EQ(shell("$P batch merge out -q --report merged.json"), 0) << err_;
  generate("in/more.glb");
  ASSERT_EQ(shell("$P batch 'in/*' -o out -q --shard 0/2"), 0);
  EXPECT_EQ(shell("$P batch merge out -q --report merged.json"), 75);
  EXPECT_TRUE(contains(err_, "have not finished: 1"));
}

TEST_F(BatchJobs, TwoAssetsOfAManifestCannotHaveOneName) {
  generate_many(2);
  const auto line = [](const char* input) { return Json{{"input", input}, {"name", "x.glb"}}.dump() + "\n"; };
  write("list.jsonl", line("in/0.glb") + line("in/1.glb"));
  EXPECT_EQ(shell("$P batch --manifest list.jsonl -o out -q --progress json"), 1);
  EXPECT_EQ(progress()["in/1.glb"], "failed");
  EXPECT_TRUE(contains(err_, "has the same name"));
}

// A line that is not an asset fails alone, in one of the shards.
TEST_F(BatchJobs, ABadLineOfAManifestFailsAlone) {
  generate_many(3);
  const auto line = [](const std::string& input, const std::string& name) {
    return Json{{"input", input}, {"name", name}}.dump() + "\n";
  };
  write("list.jsonl",
        line("in/0.glb", "0.glb") + "{broken\n" + line("in/1.glb", "/1.glb") + line("in/2.glb", "2.glb"));
  size_t failed = 0, encoded = 0;
  for (const char* shard : {"0/2", "1/2"}) {
    const int code =
        shell(std::string("$P batch --manifest list.jsonl -o out -q --progress json --shard ") + shard);
    EXPECT_EQ(code, count(progress(), "failed") == 0 ? 0 : 3) << err_;
    failed += count(progress(), "failed");
    encoded += count(progress(), "encoded");
  }
  EXPECT_EQ(failed, 2u);
  EXPECT_EQ(encoded, 2u);
  EXPECT_EQ(shell("$P batch --manifest list.jsonl -o out -q --max-failures 2 --progress json"), 0) << err_;
  EXPECT_EQ(progress()["line 2 of the manifest"], "failed");
  EXPECT_TRUE(contains(err_, "list.jsonl: line 2: ") && contains(err_, "list.jsonl: line 3: \"name\"")) << err_;
  // The first line decides what the file is.
  write("list.jsonl", "{\"gltf_psplit_plan\": 1, \n" + line("in/0.glb", "0.glb"));
  EXPECT_EQ(shell("$P batch --manifest list.jsonl -o out -q --max-failures 2"), 3);
}

// A link that someone put at the place of an output, and a file at the place of one that could not be written.
TEST_F(BatchJobs, WhatOthersPutAtAnOutputsPlaceStays) {
  generate("in/d/a.glb");
  generate("in/b.glb");
  write("out/d", "a file where a folder should be");
  EXPECT_EQ(shell("$P batch 'in/**/*.glb' -o out -q"), 2);
  fs::remove(path("out/d"));
  write("out/d/a.glb", "theirs");
  write("precious.glb", "theirs");
  fs::remove(path("out/b.glb"));
  fs::create_symlink(path("precious.glb"), path("out/b.glb"));
  EXPECT_EQ(shell("$P batch 'in/**/*.glb' -o out -q --force"), 1);
  EXPECT_EQ(read_bytes(path("out/d/a.glb")), "theirs");
  EXPECT_EQ(read_bytes(path("precious.glb")), "theirs");
}

// A folder of 40 kB takes some outputs. After a remount it takes all.
TEST_F(BatchJobs, AFullOutputFolderMayPass) {
  if (geteuid() != 0 || shell("unshare -m true") != 0) GTEST_SKIP() << "only root mounts a small folder";
  generate_many(30);
  const std::string batch = "$P batch 'in/*' -o out -q --progress json -j 2";
  ASSERT_EQ(shell("mkdir out; unshare -m sh -c \"mount -t tmpfs -o size=40k none out; " + batch +
                  " >first.txt; echo \\$? >code.txt; for i in out/*.glb; do $P validate -q \\$i >/dev/null || "
                  "exit 90; done; "
                  "ls -A out | grep -c part; mount -o remount,size=9m out; " +
                  batch + " >second.txt || exit 91; cp -r out kept\""),
            0)
      << err_;
  EXPECT_EQ(read_bytes(path("code.txt")), "75\n");
  EXPECT_EQ(out_, "0\n");
  EXPECT_TRUE(contains(err_, "No space left on device"));
  EXPECT_EQ(files("kept").size(), 30u);
}

TEST_F(BatchJobs, AFullDiskMayPass) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  generate_many(1);
  EXPECT_EQ(shell("$P batch 'in/*' -o out --report - -q >/dev/full; echo $?"), 0);
  EXPECT_EQ(out_, "75\n") << err_;
}

// Folders that play the part of a bucket: every file is brought and taken by a command.
TEST_F(BatchJobs, CommandsFetchAndStore) {
  generate_many(4);
  fs::rename(path("in"), path("bucket"));
  write("list.jsonl", [&] {
    std::string lines;
    for (int i = 0; i < 4; ++i) {
      const std::string name = std::to_string(i) + ".glb";
      lines += Json{{"input", "s3://bucket/" + name},
                    {"name", "x/" + name},
                    {"bytes", fs::file_size(path("bucket/" + name))},
                    {"version", "etag" + name}}
                   .dump() +
               "\n";
    }
    return lines;
  }());
  const std::string batch =
      "echo > fetched; $P batch --manifest list.jsonl -o out -q --progress json "
      "--fetch 'echo \"$1\" >> fetched; cp \"bucket/${1#s3://bucket/}\" \"$2\"' "
      // As in an object storage, there is no rename, and a new object must not exist.
      "--store 'mkdir -p stored/x; [ $PSPLIT_REPLACE = 1 ] || [ ! -e \"stored/$2\" ] || exit 1; "
      "cat \"$1\" > \"stored/$2\"; [ $(wc -c < \"stored/$2\") = $PSPLIT_BYTES ]' ";
  ASSERT_EQ(shell(batch), 0) << err_;
  EXPECT_EQ(count(progress(), "encoded"), 4u);
  EXPECT_TRUE(files("out").empty());
  ASSERT_EQ(shell("$P batch 'bucket/*' -o local -q"), 0);
  for (const auto& [name, bytes] : files("local")) EXPECT_EQ(read_bytes(path("stored/x/" + name)), bytes);
  expect_clean("out");
  // The versions tell that nothing changed: nothing is fetched.
  ASSERT_EQ(shell(batch), 0) << err_;
  EXPECT_EQ(count(progress(), "up to date"), 4u);
  EXPECT_EQ(read_bytes(path("fetched")), "\n");
  // An output that is lost or damaged is noticed with --fetch-output, and made again.
  fs::remove(path("stored/x/0.glb"));
  write("stored/x/1.glb", "damaged");
  ASSERT_EQ(shell(batch + "--fetch-output 'cat \"stored/$1\" > \"$2\"'"), 0) << err_;
  EXPECT_EQ(count(progress(), "up to date"), 2u);
  for (const auto& [name, bytes] : files("local")) EXPECT_EQ(read_bytes(path("stored/x/" + name)), bytes);
  expect_clean("out");
}

// An OBJ comes with its materials and textures, and a .gltf with its buffers. What a plan says about the
// content of the first file does not hide that another has changed.
TEST_F(BatchJobs, FetchBringsTheFilesThatAnAssetRefersTo) {
  const std::string png = "\x89PNG\r\n\x1a\n";
  write("bucket/x/a.obj", "mtllib sub/the colours.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
  write("bucket/x/sub/the colours.mtl", "newmtl m\nKd 1 0 0\nmap_Kd tex/t 1.png\n");
  write("bucket/x/tex/t 1.png", png + "one");
  generate("bucket/y/b.gltf");
  write("bucket/z/c.obj", "mtllib other.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
  write("bucket/z/other.mtl", "newmtl m\nmap_Kd ../../secret.png\n");
  write("list.jsonl", [] {
    std::string lines;
    for (const std::string name : {"x/a.obj", "y/b.gltf", "z/c.obj"})
      lines +=
          Json{{"input", "s3://b/" + name}, {"name", name.substr(0, 1) + ".glb"}, {"version", "1"}}.dump() +
          "\n";
    return lines;
  }());
  const std::string batch =
      "echo >fetched; $P batch --manifest list.jsonl -o out -q --progress json --max-failures 1 "
      "--fetch 'echo \"$1\" >>fetched; from=\"bucket/${1#s3://b/}\"; [ -e \"$from\" ] || exit 66; cp \"$from\" "
      "\"$2\"' "
      "--store 'mkdir -p stored; cp \"$1\" stored/\"$2\"'";
  ASSERT_EQ(shell(batch), 0) << err_;
  EXPECT_EQ(count(progress(), "encoded"), 2u) << out_;
  EXPECT_TRUE(contains(err_, "image 0 names ../../secret.png, and --fetch brings only files below"));
  EXPECT_FALSE(contains(read_bytes(path("fetched")), "secret"));
  ASSERT_EQ(shell("$P batch bucket/x/a.obj bucket/y/b.gltf --base bucket -o local -q"), 0) << err_;
  EXPECT_EQ(read_bytes(path("stored/x.glb")), read_bytes(path("local/x/a.glb")));
  EXPECT_EQ(read_bytes(path("stored/y.glb")), read_bytes(path("local/y/b.glb")));
  EXPECT_TRUE(contains(read_bytes(path("stored/x.glb")), png + "one"));
  ASSERT_EQ(shell(batch), 0) << err_;
  EXPECT_EQ(count(progress(), "up to date"), 2u) << out_;
  write("bucket/x/tex/t 1.png", png + "two");
  ASSERT_EQ(shell(batch), 0) << err_;
  EXPECT_EQ(progress()["s3://b/x/a.obj"], "encoded");
  EXPECT_EQ(progress()["s3://b/y/b.gltf"], "up to date");
  EXPECT_TRUE(contains(read_bytes(path("stored/x.glb")), png + "two"));
  // A material that the storage does not have is a loss, as it is in a folder.
  fs::remove(path("bucket/x/sub/the colours.mtl"));
  ASSERT_EQ(shell(batch), 0) << err_;
  EXPECT_EQ(progress()["s3://b/x/a.obj"], "encoded");
  expect_clean("out");
}

// Shards number what they record about an output, so that clocks do not matter.
TEST_F(BatchJobs, TheNewestRecordIsTheOneThatWasWrittenLast) {
  generate_many(4);
  const std::string batch =
      "$P batch 'in/*' -o out -q --progress json --store 'mkdir -p stored; cp \"$1\" stored/' ";
  const std::vector<std::pair<std::string, std::vector<std::string>>> runs{
      {"--patch-faces 200", {"0/1"}}, {"--patch-faces 100", {"0/2", "1/2"}}, {"--patch-faces 200", {"0/1"}}};
  for (const auto& [options, shards] : runs)
    for (const std::string& shard : shards) {
      ASSERT_EQ(shell(batch + options + " --shard " + shard), 0) << err_;
      EXPECT_EQ(count(progress(), "encoded"), progress().size()) << options << shard;
    }
  for (const bool merges : {false, true}) {
    if (merges) {
      ASSERT_EQ(shell("$P batch merge out -q --report merged.json"), 0) << err_;
    }
    ASSERT_EQ(shell(batch + "--patch-faces 200"), 0) << err_;
    EXPECT_EQ(count(progress(), "up to date"), 4u);
    ASSERT_EQ(shell(batch + "--patch-faces 100 --dry-run"), 0) << err_;
    EXPECT_EQ(count(progress(), "planned"), 4u);
  }
}

TEST_F(BatchJobs, TransfersThatFailMayPassAndMissingInputsMayNot) {
  generate_many(1);
  const std::string line = Json{{"input", "0.glb"}, {"name", "0.glb"}, {"bytes", 7}}.dump();
  write("list.jsonl", line + "\n");
  const std::string batch = "$P batch --manifest list.jsonl -o out -q --fetch ";
  EXPECT_EQ(shell(batch + "'cp in/$1 $2'"), 75);
  EXPECT_TRUE(contains(err_, "bytes instead of 7"));
  EXPECT_EQ(shell(batch + "'exit 1'"), 75);
  EXPECT_EQ(shell(batch + "'exit 66'"), 2);
  // The error shows what the command printed last, also if a process that it left keeps its output open.
  EXPECT_EQ(shell(batch + "'echo one; printf \"two\\r\\nthree \\033\" >&2; echo four; sleep 9 & exit 77' "
                          "--report report.json"),
            2);
  const Json report = Json::parse(read_bytes(path("report.json")));
  EXPECT_EQ(report["assets"][0]["error"]["message"],
            "0.glb: --fetch failed: exit code 77: one | two | three  four");
  EXPECT_TRUE(contains(err_, "one\ntwo"));
  EXPECT_EQ(shell(batch + "'exit 77'"), 2);
  EXPECT_EQ(shell(batch + "no-such-command"), 1);
  EXPECT_EQ(shell(batch + "true"), 75);
  EXPECT_TRUE(contains(err_, "--fetch made no file"));
  write("list.jsonl",
        Json{{"input", "0.glb"}, {"name", "0.glb"}, {"xxh128", std::string(32, '0')}}.dump() + "\n");
  EXPECT_EQ(shell(batch + "'cp in/$1 $2'"), 75);
  EXPECT_TRUE(contains(err_, "made a file with the hash"));
  // What a plan says about content is true.
  ASSERT_EQ(shell("cd in && $P batch plan 0.glb --out-dir ../out --hash -o ../list.jsonl -q"), 0) << err_;
  EXPECT_EQ(shell(batch + "'cp in/$1 $2'"), 0) << err_;
  // A command that hangs ends with its asset.
  fs::remove_all(path("out"));
  EXPECT_EQ(shell(batch + "'exec sleep 1234' --timeout 0.5"), 75);
  EXPECT_TRUE(contains(err_, "took longer"));
  expect_clean("out");
}

TEST_F(BatchJobs, StorageNeedsWholeFiles) {
  generate_many(1);
  EXPECT_EQ(shell("$P batch 'in/*' -o out --as gltf --store 'cp $1 $2' -q"), 1);
  EXPECT_TRUE(contains(err_, "--store takes one file for each asset"));
  EXPECT_EQ(shell("$P batch 'in/*' -o out --images copy --store 'cp $1 $2' -q"), 1);
  EXPECT_EQ(shell("$P batch 'in/*' -o out --fetch 'cp $1 $2' -q"), 1);
}

}  // namespace
}  // namespace psplit
