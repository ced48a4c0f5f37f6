// gltf-psplit batch when it, its worker or its commands are stopped or killed.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "system/temporary_file.h"
#include "tests/support/child.h"
#include "tests/tools/batch/posix/batch_jobs.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class BatchKills : public BatchJobs {
 protected:
  // Waits up to half a minute.
  template <typename Holds>
  static bool soon(const Holds& holds) {
    for (int i = 0; i < 3000; ++i) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  // The number of processes with these words on their command line.
  static int processes(const std::string& words) {
    int found = 0;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator("/proc", error)) {
      std::string line = read_bytes(entry.path() / "cmdline");
      std::replace(line.begin(), line.end(), '\0', ' ');
      found += line.starts_with(words) ? 1 : 0;
    }
    return found;
  }
  // The worker is the only child of the command. 0 if there is none.
  static pid_t worker_of(pid_t batch) {
    const std::string number = std::to_string(batch);
    const std::string children = read_bytes("/proc/" + number + "/task/" + number + "/children");
    return children.empty() ? 0 : std::stoi(children);
  }
  std::vector<fs::path> staged_folders(const std::string& place) const {
    std::vector<fs::path> found;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(path(place), error))
      if (entry.is_directory() && contains(entry.path().filename().string(), "-staged-"))
        found.push_back(entry.path());
    return found;
  }
  // A manifest whose inputs a command has to fetch.
  void write_list(int count) const {
    std::string lines;
    for (int i = 0; i < count; ++i) {
      const std::string name = std::to_string(i) + ".glb";
      lines += Json{{"input", name}, {"name", name}}.dump() + "\n";
    }
    write("list.jsonl", lines);
  }
};

// The worker has begun when the first asset has a line in the record.
TEST_F(BatchKills, AWorkerThatIsKilledIsReplaced) {
  constexpr int kAssets = 30;
  generate_many(kAssets, "8000");
  const pid_t child = start("exec $P batch 'in/*' -o out --progress json -q -j 2");
  int kills = 0;
  for (int i = 0; i < 500 && kills < 3; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const pid_t worker = worker_of(child);
    if (worker > 0 && !read_bytes(path("out.txt")).empty()) kills += kill(worker, SIGKILL) == 0;
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

TEST_F(BatchKills, SignalsStopItWithinSecondsAndTheNextRunGoesOn) {
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
    EXPECT_TRUE(soon([&] { return !read_bytes(path("out.txt")).empty(); }));
    const auto begin = std::chrono::steady_clock::now();
    kill(child, signal);
    EXPECT_EQ(wait_for(child), 75) << err_;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
    EXPECT_TRUE(contains(err_, "stopped by a signal"));
    expect_clean("out");
    const size_t done = progress().size();
    EXPECT_EQ(shell("$P batch 'in/*' -o out --progress json -q -j 2"), 0) << err_;
    EXPECT_EQ(count(progress(), "up to date"), done);
    EXPECT_EQ(progress().size(), static_cast<size_t>(kAssets));
  }
}

// No moment of a kill loses a record or leaves half an output.
TEST_F(BatchKills, KillsLoseNothing) {
  constexpr int kAssets = 12;
  generate_many(kAssets, "8000");
  ASSERT_EQ(shell("$P batch plan 'in/*' --out-dir out -o plan.jsonl --as gltf -q"), 0);
  const std::string work = "exec $P batch --manifest plan.jsonl -o out -q -j 1 --shard ";
  for (const int wait_ms : {15, 40, 80, 160, 320}) {
    for (const std::vector<std::string>& shards : {std::vector<std::string>{"0/1"}, {"0/2", "1/2"}}) {
      std::vector<pid_t> children;
      for (const std::string& shard : shards) children.push_back(start(work + shard));
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
      for (const pid_t child : children) kill(child, SIGKILL);
      for (const pid_t child : children) wait_for(child);
    }
    if (!fs::exists(path("out"))) continue;
    for (const auto& [name, bytes] : files("out"))
      if (name.ends_with(".gltf")) {
        must_run({"validate", path("out/" + name), "-q"});
      }
  }
  // One record of each output at least: what was written before is replaced without a complaint.
  for (const char* shard : {"0/3", "1/3", "2/3"})
    ASSERT_EQ(shell(std::string("$P batch --manifest plan.jsonl -o out -q --shard ") + shard), 0) << err_;
  EXPECT_EQ(files("out").size(), static_cast<size_t>(2 * kAssets));  // each has a .bin
  expect_clean("out");
  ASSERT_EQ(shell("$P batch --manifest plan.jsonl -o out --progress json -q"), 0);
  EXPECT_EQ(count(progress(), "up to date"), static_cast<size_t>(kAssets));
}

// The sleep is a child of a shell of the worker.
TEST_F(BatchKills, NoCommandOutlivesABatchThatIsKilled) {
  generate_many(1);
  write_list(1);
  const std::string sleep = "sleep " + std::to_string(100000 + getpid() % 1000);
  for (const bool kills_worker : {false, true}) {
    const pid_t child =
        start("exec $P batch --manifest list.jsonl -o out -q --fetch '" + sleep + "; cp \"in/$1\" \"$2\"'");
    ASSERT_TRUE(soon([&] { return processes(sleep) == 1; }));
    const pid_t worker = worker_of(child);
    ASSERT_GT(worker, 0);
    if (kills_worker) kill(worker, SIGSTOP);  // it does not see that the batch ends
    kill(child, SIGKILL);
    if (kills_worker) kill(worker, SIGKILL);
    wait_for(child);
    EXPECT_TRUE(soon([&] { return processes(sleep) == 0; })) << kills_worker;
  }
}

// The next run removes the folder whatever its count of shards, but not that of a process that lives.
TEST_F(BatchKills, StagedFoldersOfKilledShardsAreRemoved) {
  generate_many(8);
  write_list(8);
  for (const std::string stage : {"", "stage"}) {
    const std::string place = stage.empty() ? "out/.gltf-psplit-batch" : stage;
    const std::string batch = "exec $P batch --manifest list.jsonl -o out -q " +
                              (stage.empty() ? stage : "--stage " + stage) +
                              " --force --fetch 'cp \"in/$1\" \"$2\"";
    const auto start_hanging = [&](const std::string& shard, size_t folders) {
      const pid_t child = start(batch + "; exec sleep 100' --shard " + shard);
      EXPECT_TRUE(soon([&] { return staged_folders(place).size() == folders; }));
      return child;
    };
    const pid_t killed = start_hanging("0/2", 1);
    const pid_t living = start_hanging("1/2", 2);
    kill(killed, SIGKILL);
    wait_for(killed);
    EXPECT_EQ(shell(batch + "' --shard 0/2"), 0) << err_;
    EXPECT_EQ(staged_folders(place).size(), 1u);
    kill(living, SIGKILL);
    wait_for(living);
    EXPECT_EQ(staged_folders(place).size(), 1u);
    EXPECT_EQ(shell(batch + "' --shard 0/3"), 0) << err_;
    EXPECT_EQ(staged_folders(place).size(), 0u);
    expect_clean("out");
  }
}

// A killed process left half an output of an asset that is no longer planned.
TEST_F(BatchKills, TemporaryFilesOfKilledShardsAreRemoved) {
  generate_many(2);
  fs::create_directories(path("out/d"));
  const auto leave_half_an_output = [&] {
    const TemporaryFile left(path("out/d/gone.glb"));
    _exit(left.is_open() ? 0 : 1);
    return 1;
  };
  ASSERT_EQ(run_in_child(leave_half_an_output), 0);
  ASSERT_EQ(files("out").size(), 1u);
  write("out/.gltf-psplit-batch/2-of-5.jsonl",
        Json{{"name", "d%2Fgone.glb"}, {"made_from", ""}, {"output", ""}, {"number", 1}}.dump() + "\n");
  ASSERT_EQ(shell("$P batch 'in/*' -o out -q"), 0) << err_;
  EXPECT_EQ(files("out").size(), 2u);
  expect_clean("out");
}

// As process 1 of a container, a batch becomes the parent of what its commands leave.
TEST_F(BatchKills, OrphansAreNoZombiesInAContainer) {
  if (geteuid() != 0 || shell("unshare --pid --fork --mount-proc true") != 0)
    GTEST_SKIP() << "only root makes a container";
  generate_many(6);
  write_list(6);
  ASSERT_EQ(
      shell(
          "unshare --pid --fork --mount-proc $P batch --manifest list.jsonl -o out -q -j 1 --fetch '(true &); "
          "sleep 0.1; cat /proc/[0-9]*/stat | grep -c \") Z \" >>zombies; cp \"in/$1\" \"$2\"'"),
      0)
      << err_;
  std::istringstream counts(read_bytes(path("zombies")));
  int runs = 0;
  for (int zombies = 0; counts >> zombies; ++runs) EXPECT_LE(zombies, 1);  // that of this command
  EXPECT_EQ(runs, 6);
}

}  // namespace
}  // namespace psplit
