#include "system/files.h"

#include <string>

#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  std::string text(const std::string& name) const {
    const auto bytes = read_file(folder_ / name);
    return bytes ? std::string(bytes->begin(), bytes->end()) : bytes.status().message();
  }
  std::ptrdiff_t file_count() const { return std::distance(fs::directory_iterator(folder_), {}); }

  TestFolder folder_;
  const std::vector<uint8_t> abc_ = {'a', 'b', 'c'}, de_ = {'d', 'e'};
};

TEST_F(Files, AppearWholeAndReplaceWhatWasThere) {
  ASSERT_TRUE(write_file(folder_ / "a", {abc_, {}, de_}).ok());
  EXPECT_EQ(text("a"), "abcde");
  ASSERT_TRUE(write_file(folder_ / "a", {de_}).ok());
  EXPECT_EQ(text("a"), "de");
  EXPECT_EQ(file_count(), 1);
}

TEST_F(Files, ReadUpToALimit) {
  ASSERT_TRUE(write_file(folder_ / "a", {abc_}).ok());
  EXPECT_EQ(read_file(folder_ / "a", 2)->size(), 2u);
  EXPECT_EQ(read_file(folder_ / "a", 0)->size(), 0u);
  EXPECT_EQ(read_file(folder_, 2).status().code(), StatusCode::kIo);
  EXPECT_EQ(read_file(folder_ / "none").status().code(), StatusCode::kIo);
}

TEST_F(Files, FailWithoutATrace) {
  EXPECT_EQ(write_file(folder_ / "none" / "a", {abc_}).code(), StatusCode::kIo);
  fs::create_directory(folder_ / "taken");
  EXPECT_EQ(write_file(folder_ / "taken", {abc_}).code(), StatusCode::kIo);
  EXPECT_EQ(file_count(), 1);
}

TEST_F(Files, LinksAreWrittenThrough) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  ASSERT_TRUE(write_file(folder_ / "a", {abc_}).ok());
  fs::create_symlink("a", folder_ / "link");
  ASSERT_TRUE(write_file(folder_ / "link", {de_}).ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(text("a"), "de");
}

TEST_F(Files, LinksToNothingAreFollowed) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  fs::create_directories(folder_ / "b" / "c");
  fs::create_symlink("b/c", folder_ / "d");            // a link to a folder
  fs::create_symlink("../new", folder_ / "d" / "up");  // from there: b/new
  fs::create_symlink("d/up", folder_ / "link");
  ASSERT_TRUE(write_file(folder_ / "link", {abc_}).ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(text("b/new"), "abc");
  fs::create_symlink("circle", folder_ / "circle");
  EXPECT_EQ(write_file(folder_ / "circle", {abc_}).code(), StatusCode::kIo);
  EXPECT_TRUE(fs::is_symlink(folder_ / "circle"));
}

TEST_F(Files, KeepTheirPermissions) {
  if (!is_posix()) GTEST_SKIP() << "no permissions of POSIX";
  ASSERT_TRUE(write_file(folder_ / "a", {abc_}).ok());
  fs::permissions(folder_ / "a", fs::perms{0606});
  ASSERT_TRUE(write_file(folder_ / "a", {de_}).ok());
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::perms{0606});
  fs::permissions(folder_ / "a", fs::perms{0444});
  const Status refused = write_file(folder_ / "a", {abc_});
  EXPECT_EQ(refused.code(), StatusCode::kIo);
  EXPECT_TRUE(contains(refused.message(), "read-only"));
  EXPECT_EQ(text("a"), "de");
  ASSERT_TRUE(write_file(folder_ / "a", {abc_}, IfReadOnly::kReplace).ok());
  EXPECT_EQ(text("a"), "abc");
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::perms{0444});
}

TEST_F(Files, NamesMayBeAsLongAsNamesCanBe) {
  const std::string name(255, 'x');
  ASSERT_TRUE(write_file(folder_ / name, {abc_}).ok());
  EXPECT_EQ(text(name), "abc");
  EXPECT_EQ(write_file(folder_ / (name + "x"), {abc_}).code(), StatusCode::kIo);
  EXPECT_EQ(file_count(), 1);
}

// The test uses links in its own folder: a replaced device would be lost for all processes.
TEST_F(Files, DevicesAreWrittenToAndStayDevices) {
  for (const char* device : {"null", "full"}) {
    const fs::path path = fs::path("/dev") / device;
    if (!fs::is_character_file(path)) GTEST_SKIP() << "no " << path;
    fs::create_symlink(path, folder_ / device);
    EXPECT_EQ(write_file(folder_ / device, {abc_}).ok(), path == "/dev/null");
    EXPECT_TRUE(fs::is_character_file(path));
  }
}

}  // namespace
}  // namespace psplit
