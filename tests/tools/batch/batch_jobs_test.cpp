// gltf-psplit batch as a job: shards, failures that may pass, signals, time-outs, memory, and object storage.
// Each test runs the command as a process of its own.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "gltf_ext/json/json.h"
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/batch/memory_budget.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// Sanitizers take memory and addresses of their own.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PSPLIT_SANITIZES_ADDRESSES
#endif
#endif
#ifdef PSPLIT_SANITIZES_ADDRESSES
constexpr bool kMeasuresMemory = false;
#else
constexpr bool kMeasuresMemory = true;
#endif

class BatchJobs : public CommandTest {
 protected:
  void generate(const std::string& name, const std::string& faces = "500", const std::string& seed = "1") {
    fs::create_directories((folder_ / name).parent_path());
    ASSERT_EQ(run({"generate", path(name), "--shape", "terrain", "--faces", faces, "--seed", seed, "-q"}), 0);
  }
  void generate_many(int count) {
    for (int i = 0; i < count; ++i) generate("in/" + std::to_string(i) + ".glb", "500", std::to_string(i));
  }

  // Starts a shell in the test's folder. It knows the command as $P.
  pid_t start(const std::string& words) const {
    const pid_t child = fork();
    if (child != 0) return child;
    if (chdir(folder_.path().c_str()) != 0) _exit(98);
    setenv("P", PSPLIT_COMMAND, 1);
    const std::string script = words + " >out.txt 2>err.txt";
    execl("/bin/sh", "sh", "-c", script.c_str(), static_cast<char*>(nullptr));
    _exit(99);
  }
  int wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    out_ = read_bytes(path("out.txt"));
    err_ = read_bytes(path("err.txt"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  int shell(const std::string& words) { return wait_for(start(words)); }

  // The status of each asset in the lines of --progress json, by input.
  std::map<std::string, std::string> progress() const {
    std::map<std::string, std::string> statuses;
    std::istringstream lines(out_);
    for (std::string line; std::getline(lines, line);) {
      const Json row = Json::parse(line);
      EXPECT_TRUE(statuses.emplace(row["input"].get<std::string>(), row["status"].get<std::string>()).second);
    }
    return statuses;
  }
  static size_t count(const std::map<std::string, std::string>& statuses, const std::string& status) {
    size_t found = 0;
    for (const auto& [input, its] : statuses) found += its == status ? 1 : 0;
    return found;
  }

  // All files below a folder, except those of the batch itself, with their bytes.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(path(name)))
      if (entry.is_regular_file() && entry.path().string().find(".gltf-psplit-batch") == std::string::npos)
        found[fs::relative(entry.path(), path(name)).string()] = read_bytes(entry.path());
    return found;
  }
  // No temporary file and no staged file remains.
  void expect_clean(const std::string& name) const {
    for (const auto& entry : fs::recursive_directory_iterator(path(name))) {
      const std::string file = entry.path().filename().string();
      EXPECT_FALSE(file.ends_with(".part") || file.starts_with("staged-")) << entry.path();
    }
  }
};

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
  EXPECT_EQ(report["shards"]["unfinished"].size(), 0u);
}

TEST_F(BatchJobs, MergeSaysWhichShardsHaveNotFinished) {
  generate_many(4);
  ASSERT_EQ(shell("$P batch 'in/*' -o out --shard 1/3 -q"), 0) << err_;
  ASSERT_EQ(shell("$P batch merge out --report merged.json -q"), 75);
  EXPECT_TRUE(contains(err_, "of 3 shards, these have not finished: 0, 2")) << err_;
  EXPECT_EQ(shell("$P batch merge nowhere"), 2);
}

TEST_F(BatchJobs, EveryCopyOfAPlanIsCheckedBeforeTheWork) {
  generate_many(3);
  ASSERT_EQ(shell("$P batch plan 'in/*' --out-dir out -o plan.jsonl --lossless --hash -q"), 0) << err_;
  EXPECT_EQ(shell("$P batch --manifest plan.jsonl -o out --no-verify -q"), 1);
  EXPECT_TRUE(contains(err_, "--no-verify must be given to `batch plan`")) << err_;
  EXPECT_EQ(shell("sed s/0[.]1[.]0/0.0.9/ plan.jsonl >other.jsonl; $P batch --manifest other.jsonl -o out -q"),
            1);
  EXPECT_TRUE(contains(err_, "was planned by gltf-psplit 0.0.9")) << err_;
  EXPECT_EQ(shell("head -n 3 plan.jsonl >short.jsonl; $P batch --manifest short.jsonl -o out -q"), 3);
  EXPECT_TRUE(contains(err_, "the plan has 2 assets instead of 3")) << err_;
  EXPECT_EQ(shell("echo '{\"input\":\"in/0.glb\",\"name\":\"../x.glb\"}' >bad.jsonl; $P batch --manifest "
                  "bad.jsonl -o out"),
            3);
  EXPECT_TRUE(contains(err_, "line 1")) << err_;
  EXPECT_FALSE(fs::exists(path("x.glb")));
  // The options of the plan are those of the outputs.
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
    ASSERT_EQ(shell("$P batch 'in/*' -o out --command compare --progress json -q"), 0) << err_;
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
  EXPECT_EQ(shell("$P batch 'in/*' -o out --command compare --progress json -q"), 7);
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
  EXPECT_TRUE(contains(err_, "hang.glb: took longer than the 3.0 s of --timeout")) << err_;
  expect_clean("out");
}

TEST_F(BatchJobs, OnlyTheAssetThatRunsOutOfMemoryFails) {
  if (!kMeasuresMemory) GTEST_SKIP() << "a sanitizer takes memory, too";
  generate_many(6);
  const std::string limited = "ulimit -v 70000; exec $P batch 'in/*' -o out --progress json -q -j 1";
  ASSERT_EQ(run({"generate", path("in/huge.glb"), "--faces", "400k", "-q"}), 0);
  EXPECT_EQ(shell(limited), 75);
  EXPECT_EQ(progress()["in/huge.glb"], "failed");
  EXPECT_EQ(count(progress(), "encoded"), 6u) << out_ << err_;
  expect_clean("out");
}

// The worker is the only child of the command. It has begun when the first asset has a line in the record.
TEST_F(BatchJobs, AWorkerThatIsKilledIsReplaced) {
  constexpr int kAssets = 30;
  for (int i = 0; i < kAssets; ++i) generate("in/" + std::to_string(i) + ".glb", "8000", std::to_string(i));
  const pid_t child = start("exec $P batch 'in/*' -o out --progress json -q -j 2");
  const std::string list = "/proc/" + std::to_string(child) + "/task/" + std::to_string(child) + "/children";
  int kills = 0;
  for (int i = 0; i < 500 && kills < 3 && fs::exists(list); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::string worker = read_bytes(list);
    if (!worker.empty() && !read_bytes(path("out.txt")).empty()) kills += kill(std::stoi(worker), SIGKILL) == 0;
  }
  EXPECT_GT(kills, 0);
  const int code = wait_for(child);
  // An asset fails only if it was alone when the worker was killed; then it may succeed later.
  EXPECT_EQ(code, count(progress(), "failed") == 0 ? 0 : 75) << err_;
  EXPECT_EQ(progress().size(), static_cast<size_t>(kAssets));
  EXPECT_LE(count(progress(), "failed"), 3u);
  expect_clean("out");
  EXPECT_EQ(shell("$P batch 'in/*' -o out -q --report report.json"), 0) << err_;
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
  EXPECT_TRUE(contains(err_, "have not finished: 1")) << err_;
}

TEST_F(BatchJobs, TwoAssetsOfAManifestCannotHaveOneName) {
  generate_many(2);
  const auto line = [](const char* input) { return Json{{"input", input}, {"name", "x.glb"}}.dump() + "\n"; };
  write("list.jsonl", line("in/0.glb") + line("in/1.glb"));
  EXPECT_EQ(shell("$P batch --manifest list.jsonl -o out -q --progress json"), 1);
  EXPECT_EQ(progress()["in/1.glb"], "failed");
  EXPECT_TRUE(contains(err_, "has the same name")) << err_;
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

TEST_F(BatchJobs, AFullDiskMayPass) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  generate_many(1);
  EXPECT_EQ(shell("$P batch 'in/*' -o out --report - -q >/dev/full; echo $?"), 0);
  EXPECT_EQ(out_, "75\n") << err_;
}

TEST_F(BatchJobs, SignalsStopItWithinSecondsAndTheNextRunGoesOn) {
  constexpr int kAssets = 200;
  generate_many(20);
  for (int i = 20; i < kAssets; ++i)
    fs::copy_file(path("in/" + std::to_string(i % 20) + ".glb"), path("in/" + std::to_string(i) + ".glb"));
  ASSERT_EQ(mkfifo(path("in/hang.glb").c_str(), 0600), 0);
  for (const int signal : {SIGTERM, SIGINT}) {
    fs::remove_all(path("out"));
    fs::remove(path("out.txt"));
    const pid_t child = start("exec $P batch in/hang.glb 'in/*' -o out --progress json -q -j 2");
    // A signal that comes before the first asset would just end the process.
    for (int i = 0; i < 3000 && read_bytes(path("out.txt")).empty(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const auto begin = std::chrono::steady_clock::now();
    kill(child, signal);
    EXPECT_EQ(wait_for(child), 75) << err_;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
    EXPECT_TRUE(contains(err_, "stopped by a signal")) << err_;
    expect_clean("out");
    const size_t done = progress().size();
    EXPECT_EQ(shell("$P batch 'in/*' -o out --progress json -q -j 2"), 0) << err_;
    EXPECT_EQ(count(progress(), "up to date"), done);
    EXPECT_EQ(progress().size(), static_cast<size_t>(kAssets));
  }
}

// No moment of a kill loses a record or leaves half an output, and no process stays behind.
TEST_F(BatchJobs, KillsOfShardsLoseNothing) {
  constexpr int kAssets = 12;
  for (int i = 0; i < kAssets; ++i) generate("in/" + std::to_string(i) + ".glb", "8000", std::to_string(i));
  ASSERT_EQ(shell("$P batch plan 'in/*' --out-dir out -o plan.jsonl -q"), 0);
  std::set<std::string> seen;
  for (const int wait_ms : {15, 40, 80, 160, 320}) {
    const pid_t a = start("exec $P batch --manifest plan.jsonl -o out --shard 0/2 -q -j 1");
    const pid_t b = start("exec $P batch --manifest plan.jsonl -o out --shard 1/2 -q -j 1");
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    kill(a, SIGKILL);
    kill(b, SIGKILL);
    wait_for(a);
    wait_for(b);
    if (!fs::exists(path("out"))) continue;
    for (const auto& [name, bytes] : files("out")) {
      if (name.ends_with(".part")) continue;
      seen.insert(name);
      EXPECT_EQ(run({"validate", path("out/" + name), "-q"}), 0) << name;
    }
  }
  // One record of each output at least: what was written before is replaced without a complaint.
  for (const char* shard : {"0/3", "1/3", "2/3"})
    ASSERT_EQ(shell(std::string("$P batch --manifest plan.jsonl -o out -q --shard ") + shard), 0) << err_;
  EXPECT_EQ(files("out").size(), static_cast<size_t>(kAssets));
  expect_clean("out");
  ASSERT_EQ(shell("$P batch --manifest plan.jsonl -o out --progress json -q"), 0);
  EXPECT_EQ(count(progress(), "up to date"), static_cast<size_t>(kAssets));
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

TEST_F(BatchJobs, TransfersThatFailMayPassAndMissingInputsMayNot) {
  generate_many(1);
  const std::string line = Json{{"input", "0.glb"}, {"name", "0.glb"}, {"bytes", 7}}.dump();
  write("list.jsonl", line + "\n");
  const std::string batch = "$P batch --manifest list.jsonl -o out -q --fetch ";
  EXPECT_EQ(shell(batch + "'cp in/$1 $2'"), 75);
  EXPECT_TRUE(contains(err_, "bytes instead of 7")) << err_;
  EXPECT_EQ(shell(batch + "'exit 1'"), 75);
  EXPECT_EQ(shell(batch + "'exit 66'"), 2);
  EXPECT_EQ(shell(batch + "no-such-command"), 1);
  EXPECT_EQ(shell(batch + "true"), 75);
  EXPECT_TRUE(contains(err_, "--fetch made no file")) << err_;
  write("list.jsonl",
        Json{{"input", "0.glb"}, {"name", "0.glb"}, {"xxh128", std::string(32, '0')}}.dump() + "\n");
  EXPECT_EQ(shell(batch + "'cp in/$1 $2'"), 75);
  EXPECT_TRUE(contains(err_, "made a file with the hash")) << err_;
  // What a plan says about content is true.
  ASSERT_EQ(shell("cd in && $P batch plan 0.glb --out-dir ../out --hash -o ../list.jsonl -q"), 0) << err_;
  EXPECT_EQ(shell(batch + "'cp in/$1 $2'"), 0) << err_;
  // A command that hangs ends with its asset.
  fs::remove_all(path("out"));
  EXPECT_EQ(shell(batch + "'exec sleep 1234' --timeout 0.5"), 75);
  EXPECT_TRUE(contains(err_, "took longer")) << err_;
  expect_clean("out");
}

TEST_F(BatchJobs, StorageNeedsWholeFiles) {
  generate_many(1);
  EXPECT_EQ(shell("$P batch 'in/*' -o out --as gltf --store 'cp $1 $2' -q"), 1);
  EXPECT_TRUE(contains(err_, "--store takes one file for each asset")) << err_;
  EXPECT_EQ(shell("$P batch 'in/*' -o out --images copy --store 'cp $1 $2' -q"), 1);
  EXPECT_EQ(shell("$P batch 'in/*' -o out --fetch 'cp $1 $2' -q"), 1);
}

// The estimates bound the measured peaks, and not by more than some factor.
TEST_F(BatchJobs, EstimatesOfMemoryBoundMeasuredPeaks) {
  if (!kMeasuresMemory) GTEST_SKIP() << "a sanitizer takes memory, too";
  for (const auto& [name, options] :
       std::map<std::string, std::string>{{"terrain", "--shape terrain --faces 150k"},
                                          {"gyroid", "--shape gyroid --faces 80k --normals --texcoords"},
                                          {"scene", "--shape scene --faces 100k --normals"}})
    ASSERT_EQ(shell("$P generate " + name + ".glb -q " + options), 0) << err_;
  for (const std::string name : {"terrain.glb", "gyroid.glb", "scene.glb"})
    for (const std::string verb : {"encode", "decode", "validate", "compare"}) {
      const bool of_output = verb == "decode" || verb == "validate";
      const std::string input = (of_output ? "out/" : "") + name;
      ASSERT_EQ(shell("$P batch " + input + " -o " + (of_output ? "out2" : "out") +
                      " -q -j 2 --progress json --command " + verb),
                0)
          << err_;
      // The worker is a process of its own, and works on this asset only.
      const Json memory = Json::parse(out_)["memory"];
      const auto bound = memory["estimate"].get<double>() + static_cast<double>(kProcessMemory);
      const auto peak = memory["peak_of_process"].get<double>();
      EXPECT_GE(bound, peak) << verb << " " << name;
      EXPECT_LE(bound, 3 * peak) << verb << " " << name;
    }
}

}  // namespace
}  // namespace psplit
