// gltf-psplit encode --memory: the peak, the disk, and kills.
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "tests/support/sanitizers.h"
#include "tests/tools/commands/sample_assets.h"

extern char** environ;

namespace psplit {
namespace {

struct Child {
  pid_t id = 0;
  explicit Child(std::vector<std::string> words) {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    EXPECT_EQ(posix_spawnp(&id, argv[0], nullptr, nullptr, argv.data(), environ), 0);
  }
  // Its exit code, or -1 for a signal; and its peak memory in bytes. That of wait4 would count this process,
  // too, from before the child became another program.
  int wait(uint64_t* peak = nullptr) const {
    int status = 0;
    while (peak != nullptr && waitpid(id, &status, WNOHANG) == 0) {
      std::ifstream file("/proc/" + std::to_string(id) + "/status");
      for (std::string line; std::getline(file, line);)
        if (line.starts_with("VmHWM:")) *peak = std::max<uint64_t>(*peak, std::stoull(line.substr(6)) * 1024);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    if (peak == nullptr) {
      EXPECT_EQ(waitpid(id, &status, 0), id);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

class EncodeMemory : public CommandTest {
 protected:
  std::string ply(const std::string& faces) {
    EXPECT_EQ(run({"generate", path("scan.ply"), "--shape", "blob", "--normals", "--faces", faces, "-q"}), 0)
        << err_;
    return path("scan.ply");
  }
};

TEST_F(EncodeMemory, StaysBelowTheSizeAndEncodesTheSameMesh) {
  const std::string scan = ply("600k");
  ASSERT_EQ(run({"encode", scan, path("whole.glb"), "--always-patches", "-q"}), 0) << err_;
  uint64_t peak = 0;
  const Child child({PSPLIT_COMMAND, "encode", scan, path("out.gltf"), "--memory", "128MiB", "-q", "-j", "2",
                     "--report", path("report.json")});
  ASSERT_EQ(child.wait(&peak), 0);
#if !defined(PSPLIT_ASAN) && !defined(PSPLIT_TSAN)
  EXPECT_GT(peak, uint64_t{10} << 20);
  EXPECT_LT(peak, uint64_t{128} << 20);
#endif
  EXPECT_EQ(run({"compare", path("whole.glb"), path("out.gltf")}), 0) << out_ << err_;
  EXPECT_EQ(run({"validate", path("out.gltf"), "-q"}), 0) << out_ << err_;
  const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
  EXPECT_TRUE(report.at("verified").get<bool>());
  EXPECT_EQ(report.at("primitives").size(), 1u);
  EXPECT_EQ(report.at("primitives").at(0).at("input").at("faces"), report.at("primitives").at(0).at("faces"));
}

// A file that fits is encoded as without the option.
TEST_F(EncodeMemory, SmallFilesAreEncodedAsAlways) {
  const std::string scan = ply("30k");
  ASSERT_EQ(run({"encode", scan, path("a.glb"), "-q"}), 0) << err_;
  ASSERT_EQ(run({"encode", scan, path("b.glb"), "--memory", "1GB", "-q"}), 0) << err_;
  EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
}

TEST_F(EncodeMemory, SaysTheTemporarySpaceAndReadsStdin) {
  const std::string scan = ply("30k");
  const CommandOutcome outcome =
      run_command_on(scan, {"encode", "-", path("b.glb"), "--memory", "1GB", "--temporary", path("")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "of temporary space in " + path(""))) << outcome.err;
  ASSERT_EQ(run({"encode", scan, path("a.glb"), "-q"}), 0) << err_;
  EXPECT_EQ(run({"compare", path("a.glb"), path("b.glb")}), 0) << out_ << err_;
}

TEST_F(EncodeMemory, RefusesWhatCannotWork) {
  const std::string scan = ply("2k");
  EXPECT_EQ(run({"encode", scan, path("a.glb"), "--memory", "1MB"}), 1);
  EXPECT_TRUE(contains(err_, "must be at least")) << err_;
  EXPECT_EQ(run({"encode", scan, path("a.glb"), "--memory", "1GB", "--keep-unused"}), 1);
  EXPECT_TRUE(contains(err_, "--keep-unused does not work with --memory")) << err_;
  EXPECT_EQ(run({"encode", scan, path("a.glb"), "--temporary", path("")}), 1);
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(EncodeMemory, AFullDiskMayPassAndKeepsTheOldOutput) {
  const std::string scan = ply("600k");
  write("out.gltf", "old");
  const Child child({"sh", "-c", "ulimit -f 4000; exec \"$0\" \"$@\" 2>/dev/null", PSPLIT_COMMAND, "encode",
                     scan, path("out.gltf"), "--memory", "128MiB"});
  EXPECT_EQ(child.wait(), 75);
  EXPECT_EQ(read_bytes(path("out.gltf")), "old");
  EXPECT_EQ(file_count(), 2u);
}

TEST_F(EncodeMemory, SurvivesKills) {
  const std::string scan = ply("600k");
  write("out.gltf", "old");
  int killed = 0;
  for (const int wait_ms : {10, 100, 300, 600, 1000}) {
    const Child child({PSPLIT_COMMAND, "encode", scan, path("out.gltf"), "--memory", "128MiB", "-q"});
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    kill(child.id, SIGKILL);
    if (child.wait() != -1) break;
    ++killed;
    EXPECT_EQ(read_bytes(path("out.gltf")), "old");
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      // Only the last step writes a file with a name. Its writer's next run removes it.
      EXPECT_TRUE(name == "scan.ply" || name == "out.gltf" || name.ends_with(".part")) << name;
    }
  }
  EXPECT_GE(killed, 2);
  ASSERT_EQ(run({"encode", scan, path("out.gltf"), "--memory", "128MiB", "-q"}), 0) << err_;
  EXPECT_EQ(file_count(), 3u);  // and the .bin
}

}  // namespace
}  // namespace psplit
