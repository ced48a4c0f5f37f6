#include "system/text_lines.h"

#include <cerrno>
#include <fstream>
#include <vector>

#include "system/io_error.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

class LinesOfAFile : public testing::Test {
 protected:
  std::vector<std::string> lines(const std::string& text) {
    std::ofstream(folder_ / "text", std::ios::binary) << text;
    Expected<TextLines> opened = TextLines::open(folder_ / "text");
    std::vector<std::string> found;
    for (std::string_view line; opened->next(line);) {
      found.emplace_back(line);
      EXPECT_EQ(opened->number(), found.size());
      is_whole_ = opened->is_whole();
    }
    EXPECT_TRUE(opened->status().ok());
    return found;
  }
  TestFolder folder_;
  bool is_whole_ = true;
};

using Texts = std::vector<std::string>;

TEST_F(LinesOfAFile, EndAtLineFeedsAndAtTheEnd) {
  EXPECT_EQ(lines(""), Texts());
  EXPECT_EQ(lines("a\n\nb\n"), (Texts{"a", "", "b"}));
  EXPECT_TRUE(is_whole_);
  EXPECT_EQ(lines("a\nb"), (Texts{"a", "b"}));
  EXPECT_FALSE(is_whole_);
}

// Longer than the blocks in which the file is read.
TEST_F(LinesOfAFile, MayBeLong) {
  const std::string large(1000000, 'x'), small(100000, 'y');
  EXPECT_EQ(lines(small + "\n" + large + "\n" + small + "\n" + small), (Texts{small, large, small, small}));
}

TEST_F(LinesOfAFile, AreNotThoseOfFoldersOrMissingFiles) {
  EXPECT_EQ(TextLines::open(folder_ / "none").status().code(), StatusCode::kIo);
  // Some systems open a folder as a file, and fail to read it.
  Expected<TextLines> folder = TextLines::open(folder_.path());
  std::string_view line;
  EXPECT_FALSE(folder && folder->next(line));
  EXPECT_EQ((folder ? folder->status() : folder.status()).code(), StatusCode::kIo);
}

TEST(IoError, TellsWhatMayPass) {
  EXPECT_EQ(io_error("cannot write", ENOSPC, {.file = "x"}).to_string(),
            "x: cannot write: No space left on device");
  EXPECT_EQ(io_error("cannot write", ENOSPC).code(), StatusCode::kMayPass);
  EXPECT_EQ(io_error("cannot map", ENOMEM).code(), StatusCode::kOutOfMemory);
  EXPECT_EQ(io_error("cannot open", ENOENT).code(), StatusCode::kIo);
  EXPECT_EQ(io_error("cannot open", EACCES).code(), StatusCode::kIo);
}

}  // namespace
}  // namespace psplit
