// Files that others have open, names of files, and devices.
#include <windows.h>

#include <chrono>
#include <memory>
#include <thread>

#include "system/files.h"
#include "system/mapped_file.h"
#include "system/operating_system.h"
#include "system/temporary_file.h"
#include "tests/support/expect.h"
#include "tests/system/temporary_files.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

struct Close {
  void operator()(HANDLE handle) const { CloseHandle(handle); }
};
using OpenHandle = std::unique_ptr<void, Close>;

class FilesInUse : public TemporaryFilesTest {
 protected:
  // As a scanner has it, which lets nobody rename it.
  static OpenHandle hold(const fs::path& path) {
    return OpenHandle(CreateFileW(path.c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_WRITE, nullptr,
                                  OPEN_EXISTING, 0, nullptr));
  }
  size_t size_of(const fs::path& path) const { return read_file(path)->size(); }
  const fs::path file_ = folder_ / "x.glb";
};

TEST_F(FilesInUse, AreReplacedOnceTheyAreFree) {
  ASSERT_TRUE(write_file(file_, {bytes_}).ok());
  OpenHandle scanner = hold(file_);
  std::thread end([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    scanner.reset();
  });
  const Status status = write_file(file_, {{}});
  end.join();
  EXPECT_TRUE(status.ok()) << status.to_string();
  EXPECT_EQ(size_of(file_), 0u);
  EXPECT_EQ(file_count(), 1);
}

TEST_F(FilesInUse, StayAndMayBeReplacedLater) {
  ASSERT_TRUE(write_file(file_, {bytes_}).ok());
  const OpenHandle scanner = hold(file_);
  const Status status = write_file(file_, {{}});
  EXPECT_EQ(status.code(), StatusCode::kMayPass) << status.to_string();
  EXPECT_EQ(size_of(file_), bytes_.size());
  EXPECT_EQ(file_count(), 1);
}

TEST_F(FilesInUse, StayIfTheNewOneCannotBeRenamed) {
  ASSERT_TRUE(write_file(file_, {bytes_}).ok());
  const MappedFile mapped = must(MappedFile::open(file_));
  TemporaryFile temporary(file_);
  const OpenHandle scanner = hold(temporary.path());
  EXPECT_EQ(temporary.rename_to(file_).code(), StatusCode::kMayPass);
  EXPECT_EQ(size_of(file_), bytes_.size());
}

TEST_F(FilesInUse, AreReplacedWhileTheyAreMapped) {
  ASSERT_TRUE(write_file(file_, {bytes_}).ok());
  {
    const MappedFile mapped = must(MappedFile::open(file_));
    ASSERT_TRUE(write_file(file_, {{}}).ok());
    EXPECT_EQ(mapped.bytes()[0], 7);
    EXPECT_EQ(size_of(file_), 0u);
  }
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_TRUE(entry.path() == file_ || is_temporary_name(entry.path())) << entry.path();
}

TEST_F(FilesInUse, WithoutANameHaveOneThatIsRemoved) {
  UnnamedFile file = must(UnnamedFile::create(folder_));
  EXPECT_TRUE(is_temporary_name(file.path())) << file.path();
  remove_dead_temporaries(folder_);
  EXPECT_EQ(file_count(), 1) << "it is locked";
}

TEST_F(FilesInUse, DevicesAreNoFiles) {
  for (const char* name : {"NUL", "CON", "com1", "AUX.bin"}) {
    EXPECT_FALSE(is_disk_file(name)) << name;
    EXPECT_EQ(file_type_at(name), fs::file_type::character) << name;
  }
  EXPECT_TRUE(write_file("NUL", {bytes_}).ok());
  ASSERT_TRUE(write_file(file_, {bytes_}).ok());
  EXPECT_TRUE(is_disk_file(file_));
  EXPECT_EQ(file_type_at(folder_), fs::file_type::directory);
  EXPECT_EQ(file_type_at(folder_ / "none"), fs::file_type::not_found);
}

TEST_F(FilesInUse, NamesOfOneFileAreTheSame) {
  EXPECT_EQ(name_to_compare("a/B. .glb"), name_to_compare("A\\b. .GLB"));
  EXPECT_EQ(name_to_compare("x. /gr\xC3\xBC.glb."), name_to_compare("X/GR\xC3\x9C.glb"));
  EXPECT_EQ(name_to_compare("../A"), "../A");
  EXPECT_NE(name_to_compare("a.glb"), name_to_compare("b.glb"));
  EXPECT_TRUE(matches_pattern("a.GLB", "*.glb"));
  EXPECT_TRUE(matches_pattern("B.glb", "[a-c].*"));
}

TEST_F(FilesInUse, SystemFoldersAreNotSearched) {
  const fs::path folder = folder_ / "bin";
  fs::create_directory(folder);
  EXPECT_TRUE(is_searched_folder(folder));
  EXPECT_FALSE(is_searched_folder(folder_ / "none"));
  SetFileAttributesW(folder.c_str(), FILE_ATTRIBUTE_HIDDEN | FILE_ATTRIBUTE_SYSTEM);
  if ((GetFileAttributesW(folder.c_str()) & FILE_ATTRIBUTE_SYSTEM) == 0) GTEST_SKIP() << "no such attribute";
  EXPECT_FALSE(is_searched_folder(folder));
}

TEST_F(FilesInUse, FoldersOfNoDriveAreNotMade) {
  const Status status = make_folders("Q:\\a\\b");
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_TRUE(contains(status.message(), "No such file")) << status.message();
}

}  // namespace
}  // namespace psplit
