// gltf-psplit encode --memory: the peak, the disk, and kills.
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "tests/support/mesh_file_seeds.h"
#include "tests/support/sanitizers.h"
#include "tests/tools/command_file.h"
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

// A mesh of 600,000 faces does not fit into the memory that these tests give. It is made once.
class EncodeLargeMemory : public EncodeMemory {
 protected:
  static void SetUpTestSuite() {
    large_ = std::make_unique<TestFolder>();
    for (const std::string file : {"scan.ply", "scan.glb"})
      ASSERT_EQ(Child({command_file(), "generate", large(file), "--shape", "blob", "--normals", "--faces",
                       "600k", "-q"})
                    .wait(),
                0);
  }
  static void TearDownTestSuite() { large_.reset(); }
  static std::string large(const std::string& name) { return (*large_ / name).string(); }
  static void expect_small([[maybe_unused]] uint64_t peak) {
#if !defined(PSPLIT_ASAN) && !defined(PSPLIT_TSAN)
    EXPECT_GT(peak, uint64_t{10} << 20);
    EXPECT_LT(peak, uint64_t{128} << 20);
#endif
  }

 private:
  static inline std::unique_ptr<TestFolder> large_;
};

TEST_F(EncodeLargeMemory, StaysBelowTheSizeAndEncodesTheSameMesh) {
  const std::string scan = large("scan.ply");
  must_run({"encode", scan, path("whole.glb"), "--always-patches", "-q"});
  uint64_t peak = 0;
  const Child child({command_file(), "encode", scan, path("out.gltf"), "--memory", "128MiB", "-q", "-j", "2",
                     "--report", path("report.json")});
  ASSERT_EQ(child.wait(&peak), 0);
  expect_small(peak);
  must_run({"diff", path("whole.glb"), path("out.gltf")});
  must_run({"validate", path("out.gltf"), "-q"});
  const auto report = read_json("report.json");
  EXPECT_TRUE(report.at("verified").get<bool>());
  EXPECT_EQ(report.at("primitives").size(), 1u);
  EXPECT_EQ(report.at("primitives").at(0).at("input").at("faces"), report.at("primitives").at(0).at("faces"));
}

// A file that fits is encoded as without the option.
TEST_F(EncodeMemory, SmallFilesAreEncodedAsAlways) {
  const std::string scan = ply("30k");
  must_run({"encode", scan, path("a.glb"), "-q"});
  must_run({"encode", scan, path("b.glb"), "--memory", "1GB", "-q"});
  EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
}

TEST_F(EncodeMemory, SaysTheTemporarySpaceAndReadsStdin) {
  const std::string scan = ply("30k");
  const CommandOutcome outcome =
      run_command_on(scan, {"encode", "-", path("b.glb"), "--memory", "1GB", "--temporary", path("")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "of temporary space in " + path("")));
  must_run({"encode", scan, path("a.glb"), "-q"});
  must_run({"diff", path("a.glb"), path("b.glb")});
}

// A pipe gives the same output as a file.
TEST_F(EncodeMemory, ReadsAllFormatsFromStdin) {
  must_run({"generate", path("a.glb"), "--shape", "blob", "--normals", "--faces", "20k", "-q"});
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n");
  write("a.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n3 0 3 1\n3 1 3 2\n");
  std::vector<StlFacet> facets;
  for (const float i : {0.0f, 1.0f, 2.0f, 3.0f}) facets.push_back({0, 0, 0, 0, 0, 0, 1, i, 0, 0, 1, i});
  write("a.stl", binary_stl(facets));
  const size_t files = file_count();
  for (const std::string name : {"a.glb", "a.obj", "a.off", "a.stl"}) {
    for (const std::string out : {"whole.glb", "piped.glb"}) std::filesystem::remove(path(out));
    must_run({"encode", path(name), path("whole.glb"), "--always-patches", "-q"});
    const CommandOutcome piped = run_command_on(
        path(name), {"encode", "-", path("piped.glb"), "--always-patches", "--memory", "1GB", "-q"});
    ASSERT_EQ(piped.code, 0) << name << piped.err;
    must_run({"diff", path("whole.glb"), path("piped.glb")});
    EXPECT_EQ(file_count(), files + 2);
  }
}

TEST_F(EncodeMemory, RefusesOtherFormatsThatDoNotFit) {
  std::string off = "OFF\n300000 595998 0\n", obj = "usemtl a\n";
  for (int i = 0; i < 300000; ++i) {
    const std::string place = std::to_string(i % 1000) + " " + std::to_string(i / 1000) + " 0\n";
    off += place;
    obj += "v " + place;
  }
  for (int i = 1; i < 298000; ++i) {
    const auto add = [&](int a, int b, int c) {
      off += "3 " + std::to_string(a - 1) + " " + std::to_string(b - 1) + " " + std::to_string(c - 1) + "\n";
      obj += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    };
    add(i, i + 1, i + 1000);
    add(i + 1, i + 1001, i + 1000);
    if (i == 9) obj += "usemtl b\n";
  }
  write("a.off", off);
  write("a.obj", obj);
  for (const auto& [name, reason] :
       {std::pair("a.off", "more than --memory allows. Of mesh files, only PLY, OBJ and STL"),
        std::pair("a.obj", "faces of several objects or materials are not read part by part")}) {
    const CommandOutcome piped =
        run_command_on(path(name), {"encode", "-", path("b.glb"), "--memory", "128MiB", "-q"});
    EXPECT_EQ(run({"encode", path(name), path("b.glb"), "--memory", "128MiB", "-q"}), 5);
    EXPECT_EQ(piped.code, 5);
    for (const std::string& message : {err_, piped.err}) EXPECT_TRUE(contains(message, reason)) << message;
  }
  EXPECT_EQ(file_count(), 2u);
}

// A GLB that comes through a pipe stays in a temporary file.
TEST_F(EncodeLargeMemory, StayingBelowTheSizeForAPipedGlbTakesLong) {
  must_run({"encode", large("scan.glb"), path("whole.glb"), "--always-patches", "-q"});
  uint64_t peak = 0;
  const Child child({"sh", "-c", "cat \"$1\" | exec \"$0\" encode - \"$2\" --memory 128MiB -q -j 2",
                     command_file(), large("scan.glb"), path("out.glb")});
  ASSERT_EQ(child.wait(), 0);
  must_run({"diff", path("whole.glb"), path("out.glb")});
  const Child direct({"sh", "-c", "exec \"$0\" encode - \"$2\" --memory 128MiB -q -j 2 < \"$1\"",
                      command_file(), large("scan.glb"), path("out.glb")});
  ASSERT_EQ(direct.wait(&peak), 0);
  expect_small(peak);
}

TEST_F(EncodeMemory, OtherCommandsPutPipesIntoTemporaryFilesToo) {
  must_run({"generate", path("a.glb"), "--shape", "blob", "--normals", "--faces", "20k", "-q"});
  must_run({"encode", path("a.glb"), path("b.glb"), "--always-patches", "-q"});
  must_run({"decode", path("b.glb"), path("c.glb"), "-q"});
  const auto on_stdin = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--memory", "1kB", "--temporary", path("")});
    const CommandOutcome outcome = run_command_on(path("b.glb"), std::move(words));
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  };
  on_stdin({"decode", "-", path("d.glb"), "-q"});
  EXPECT_EQ(read_bytes(path("c.glb")), read_bytes(path("d.glb")));
  on_stdin({"validate", "-"});
  on_stdin({"diff", "-", path("a.glb")});
  EXPECT_EQ(file_count(), 4u);
  write("broken", "glTF");
  EXPECT_EQ(run_command_on(path("broken"), {"validate", "-", "--memory", "1kB"}).code, 3);
  EXPECT_EQ(run_command_on(path("broken"), {"decode", "-", path("e.glb"), "--memory", "1kB"}).code, 3);
}

// Streams of stock Draco are decoded one after the other, into a temporary file.
TEST_F(EncodeLargeMemory, DecodeKeepsOnePrimitiveOfStockDracoInMemory) {
  must_run({"encode", large("scan.ply"), path("khr.glb"), "--compat", "khr", "--patches", "8", "-q"});
  uint64_t whole = 0, bounded = 0;
  const Child in_memory({command_file(), "decode", path("khr.glb"), path("a.glb"), "-q", "-j", "1"});
  ASSERT_EQ(in_memory.wait(&whole), 0);
  const Child to_file(
      {command_file(), "decode", path("khr.glb"), path("b.glb"), "--memory", "16MB", "-q", "-j", "1"});
  ASSERT_EQ(to_file.wait(&bounded), 0);
  EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
#if !defined(PSPLIT_ASAN) && !defined(PSPLIT_TSAN)
  EXPECT_LT(bounded, whole / 5 * 4) << whole;
#endif
}

TEST_F(EncodeMemory, RefusesWhatCannotWork) {
  const std::string scan = ply("2k");
  fails(1, {"encode", scan, path("a.glb"), "--memory", "1MB"}, "must be at least");
  EXPECT_EQ(run({"encode", scan, path("a.glb"), "--temporary", path("")}), 1);
  EXPECT_EQ(file_count(), 1u);
}

// What a part needs, not what the mesh needs, is in memory.
TEST_F(EncodeLargeMemory, EveryOptionOnAMeshThatDoesNotFitTakesLong) {
  const std::string scan = large("scan.ply");
  for (const std::vector<std::string>& options :
       std::vector<std::vector<std::string>>{{"--keep-degenerate", "--keep-unused", "--keep-duplicates"},
                                             {"--fallback", "uncompressed"},
                                             {"--compat", "khr"},
                                             {"--boxes"},
                                             {"--condense", "--boxes"}}) {
    std::vector<std::string> words{command_file(), "encode", scan, path("a.gltf"), "--memory", "128MiB",
                                   "-q",           "-j",     "2",  "--force"};
    words.insert(words.end(), options.begin(), options.end());
    uint64_t peak = 0;
    const Child child(words);
    ASSERT_EQ(child.wait(&peak), 0) << options[0];
    expect_small(peak);
    must_run({"diff", scan, path("a.gltf"), "-q"});
    must_run({"validate", path("a.gltf"), "-q"});
  }
}

TEST_F(EncodeLargeMemory, AFullDiskMayPassAndKeepsTheOldOutput) {
  const std::string scan = large("scan.ply");
  write("out.gltf", "old");
  const Child child({"sh", "-c", "ulimit -f 4000; exec \"$0\" \"$@\" 2>/dev/null", command_file(), "encode",
                     scan, path("out.gltf"), "--memory", "128MiB"});
  EXPECT_EQ(child.wait(), 75);
  EXPECT_EQ(read_bytes(path("out.gltf")), "old");
  EXPECT_EQ(file_count(), 1u);
}

// A mesh that is decoded into a file says nothing about the asset if the file has no room.
TEST_F(EncodeMemory, AFullDiskIsNoVerdict) {
  must_run({"encode", ply("2k"), path("a.glb"), "--patches", "2", "-q"});
  const std::vector<std::string> validate{command_file(), "validate", path("a.glb"), "--memory", "1kB", "-q"};
  EXPECT_EQ(Child(validate).wait(), 0);
  std::vector<std::string> limited{"sh", "-c", "ulimit -f 1; exec \"$0\" \"$@\" >/dev/null 2>&1"};
  limited.insert(limited.end(), validate.begin(), validate.end());
  EXPECT_EQ(Child(limited).wait(), 75);
}

TEST_F(EncodeLargeMemory, SurvivingKillsTakesLong) {
  const std::string scan = large("scan.ply");
  write("out.gltf", "old");
  int killed = 0;
  for (const int wait_ms : {10, 100, 300, 600, 1000}) {
    const Child child({command_file(), "encode", scan, path("out.gltf"), "--memory", "128MiB", "-q"});
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    kill(child.id, SIGKILL);
    if (child.wait() != -1) break;
    ++killed;
    EXPECT_EQ(read_bytes(path("out.gltf")), "old");
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      // Only the last step writes a file with a name. Its writer's next run removes it.
      EXPECT_TRUE(name == "out.gltf" || name.ends_with(".part")) << name;
    }
  }
  EXPECT_GE(killed, 2);
  must_run({"encode", scan, path("out.gltf"), "--memory", "128MiB", "-q"});
  EXPECT_EQ(file_count(), 2u);  // and the .bin
}

}  // namespace
}  // namespace psplit
