#include "system/mapped_file.h"

#include <numeric>
#include <string>
#include <vector>

#include "system/files.h"
#include "system/operating_system.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class MappedFiles : public testing::Test {
 protected:
  MappedFiles() {
    std::iota(bytes_.begin(), bytes_.end(), uint8_t{0});
    EXPECT_TRUE(write_file(path_, {bytes_}).ok());
  }
  bool is_same(std::span<const uint8_t> found) const { return std::ranges::equal(found, bytes_); }

  TestFolder folder_;
  const fs::path path_ = folder_ / "x.bin";
  std::vector<uint8_t> bytes_ = std::vector<uint8_t>(200000);
};

TEST_F(MappedFiles, HaveTheBytesOfTheFile) {
  const MappedFile file = must(MappedFile::open(path_));
  EXPECT_TRUE(is_same(file.bytes()));
  const MappedFile part = file.range(5000, 77);
  EXPECT_TRUE(std::ranges::equal(part.bytes(), std::span(bytes_).subspan(5000, 77)));
  EXPECT_EQ(MappedFile::open(path_, 333)->bytes().size(), 333u);
}

TEST_F(MappedFiles, OutliveTheirFirstOwnerAndTheirName) {
  MappedFile part;
  {
    const Expected<MappedFile> file = MappedFile::open(path_);
    part = file->range(100000, 100000);
  }
  fs::remove(path_);
  EXPECT_TRUE(std::ranges::equal(part.bytes(), std::span(bytes_).subspan(100000)));
}

TEST_F(MappedFiles, KeepTheirContentWhenTheFileIsReplaced) {
  const Expected<MappedFile> file = MappedFile::open(path_);
  const std::vector<uint8_t> other(1000, 1);
  ASSERT_TRUE(write_file(path_, {other}).ok());
  release_mapped(file->bytes());
  EXPECT_TRUE(is_same(file->bytes()));
  EXPECT_EQ(fs::file_size(path_), 1000u);
}

TEST_F(MappedFiles, CanBeReadAgainAfterARelease) {
  const Expected<MappedFile> file = MappedFile::open(path_);
  ASSERT_TRUE(is_same(file->bytes()));
  release_mapped(file->bytes().subspan(1, 100000));
  release_mapped(file->bytes().subspan(199999, 1));
  EXPECT_TRUE(is_same(file->bytes()));
  size_t visited = 0;
  EXPECT_TRUE(visit_and_release(file->bytes(), [&](std::span<const uint8_t> step) {
    visited += step.size();
    return true;
  }));
  EXPECT_EQ(visited, bytes_.size());
  EXPECT_TRUE(is_same(file->bytes()));
  EXPECT_FALSE(visit_and_release(file->bytes(), [](std::span<const uint8_t>) { return false; }));
}

TEST_F(MappedFiles, ReleasingOtherMemoryDoesNothing) {
  release_mapped(bytes_);
  EXPECT_EQ(bytes_[150001], static_cast<uint8_t>(150001));
}

TEST_F(MappedFiles, AFileThatCannotBeMappedIsRead) {
  ASSERT_TRUE(write_file(folder_ / "empty", {}).ok());
  const MappedFile empty = must(MappedFile::open(folder_ / "empty"));
  EXPECT_TRUE(empty.bytes().empty());
  EXPECT_EQ(MappedFile::open(folder_ / "missing").status().code(), StatusCode::kIo);
  EXPECT_EQ(MappedFile::open(folder_.path()).status().code(), StatusCode::kIo);
  // More files than can be mapped at once.
  std::vector<MappedFile> files;
  for (int i = 0; i < 300; ++i) files.push_back(*MappedFile::open(path_));
  for (const MappedFile& file : files) EXPECT_TRUE(is_same(file.bytes()));
}

}  // namespace
}  // namespace psplit
