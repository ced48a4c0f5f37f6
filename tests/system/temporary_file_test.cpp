#include "system/temporary_file.h"

#include <fstream>
#include <string>

#include "system/files.h"
#include "system/operating_system.h"
#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/system/temporary_files.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class Temporaries : public TemporaryFilesTest {};

TEST_F(Temporaries, StayWhileTheyAreOpenAndCanBeRenamed) {
  ASSERT_TRUE(write_file(folder_ / "x.glb", {bytes_}).ok());
  TemporaryFile mine(folder_ / "x.glb");
  ASSERT_TRUE(mine.is_open());
  EXPECT_TRUE(is_temporary_name(mine.path()));
  remove_dead_temporaries(folder_);
  EXPECT_TRUE(fs::exists(mine.path()));
  EXPECT_TRUE(mine.rename_to(folder_ / "x.glb").ok());
  EXPECT_EQ(file_count(), 1);
  EXPECT_EQ(fs::file_size(folder_ / "x.glb"), 0u);
}

TEST_F(Temporaries, AFileThatIsOpenIsReplaced) {
  ASSERT_TRUE(write_file(folder_ / "x.glb", {bytes_}).ok());
  std::FILE* const reader = open_file(folder_ / "x.glb", "rb");
  ASSERT_NE(reader, nullptr);
  ASSERT_TRUE(write_file(folder_ / "x.glb", {{}}).ok());
  EXPECT_EQ(std::fgetc(reader), 7);
  std::fclose(reader);
  EXPECT_EQ(fs::file_size(folder_ / "x.glb"), 0u);
}

TEST_F(Temporaries, WithoutANameTheyKeepWhatIsWritten) {
  UnnamedFile file = must(UnnamedFile::create(folder_));
  ASSERT_TRUE(file.write(50000, bytes_).ok());
  std::vector<uint8_t> found(2);
  ASSERT_TRUE(file.read(49999, found).ok());
  EXPECT_EQ(found, (std::vector<uint8_t>{0, 7}));
  EXPECT_EQ(fs::file_size(file.path()), 150000u);
  file.close();
  EXPECT_EQ(file_count(), 0);
}

TEST_F(Temporaries, FilesOfOthersStay) {
  fs::path real;
  {
    const TemporaryFile file(folder_ / "x.glb");
    real = file.path();
  }
  std::string other_digit = real.string();
  char& digit = other_digit[other_digit.size() - 6];
  digit = digit == '0' ? '1' : '0';
  const std::string names[] = {"x.glb.part123",
                               "x.glb.part",
                               "x.glb.psplit-0123456789abcdef.part",
                               ".psplit-0123456789abcdef.part",
                               ".part",
                               fs::path(other_digit).filename().string(),
                               "other-" + real.filename().string()};
  for (const std::string& name : names) std::ofstream(folder_ / name) << "theirs";
  if (is_posix()) fs::create_symlink("x.glb.part", real);
  remove_dead_temporaries(folder_);
  EXPECT_EQ(file_count(), std::ssize(names) + (is_posix() ? 1 : 0));
}

TEST_F(Temporaries, NewFilesTakeNoNameThatIsTaken) {
  EXPECT_EQ(*write_new_file(folder_ / "a", bytes_), true);
  EXPECT_EQ(*write_new_file(folder_ / "a", bytes_), false);
  if (is_posix()) {
    fs::create_symlink("nowhere", folder_ / "link");
    EXPECT_EQ(*write_new_file(folder_ / "link", bytes_), false);
  }
  TemporaryFile late(folder_ / "a");
  EXPECT_EQ(late.rename_to_new(folder_ / "a"), std::errc::file_exists);
  EXPECT_EQ(write_new_file(folder_ / "none" / "a", bytes_).status().code(), StatusCode::kIo);
}

}  // namespace
}  // namespace psplit
