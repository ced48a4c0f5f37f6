// Files may have any name: what a document is written as can be read again, with its buffers and images.

#include <fstream>
#include <string>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/image_bytes.h"
#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/primitive/accessors.h"
#include "psplit/document.h"
#include "system/files.h"
#include "system/uri.h"
#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// Every character that a name may have, in front and inside; names of Japanese, of bytes that are no UTF-8, and
// of what has a meaning in URIs and paths.
std::vector<std::string> odd_names() {
  std::vector<std::string> names = {"\xE6\xBC\xA2\xE5\xAD\x97 \xF0\x9F\x90\x89",
                                    "\xff\xc2\x80",
                                    "C:\\x",
                                    "http:x",
                                    "..\\..\\x",
                                    "%5C",
                                    "%2e%2e%2Fx",
                                    "data:,x"};
  for (int c = 1; c < 128; ++c)
    if (c != '/') names.push_back(std::string(1, static_cast<char>(c)) + "x" + static_cast<char>(c));
  // Windows has no names of these characters; a colon would name a stream of the file.
  const auto is_refused = [](const std::string& name) {
    return name.find_first_of("\\:*?\"<>|\xff") != std::string::npos || name.front() < ' ';
  };
  if (!is_posix()) std::erase_if(names, is_refused);
  return names;
}

Document with_bytes() {
  Document document = new_document();
  append_buffer_view(document, std::vector<uint8_t>{1, 2, 3});
  return document;
}

TEST(Names, OfEveryCharacterAreReadAgain) {
  const TestFolder folder;
  const std::string png = "\x89PNG\r\n\x1a\n";
  fs::create_directories(folder / "in");
  fs::create_directories(folder / "out");
  for (const std::string& name : odd_names()) {
    const fs::path image = uri_of_path(name + ".png");
    EXPECT_EQ(kind_of_uri(image.string()), UriKind::kRelative) << name;
    EXPECT_EQ(path_of_uri(image.string(), folder / "in"), fs::path(name + ".png"));
    std::ofstream(folder / "in" / (name + ".png")) << png;
    Document document = with_bytes();
    document.source = folder / "in" / "x.gltf";
    document.json()["images"] = Json::array({{{"uri", image.string()}}});
    const fs::path output = folder / "out" / (name + ".gltf");
    ASSERT_TRUE(write_document(document, output).ok()) << name;
    const auto written = must(read_document(output));
    ASSERT_EQ(written.buffers.size(), 1u);
    EXPECT_EQ(written.buffers[0].bytes()[2], 3);
    ASSERT_EQ(linked_files(written).size(), 1u);
    EXPECT_EQ(linked_files(written)[0].state, LinkState::kFound) << name;
    EXPECT_EQ(image_bytes(written.json(), folder / "out").in_files, png.size()) << name;
    // Its binary is known as its own.
    ASSERT_TRUE(write_document(written, folder / "out" / "copy.glb").ok());
    Document other = with_bytes();
    append_buffer_view(other, std::vector<uint8_t>{9});
    ASSERT_TRUE(write_document(other, output).ok());
    EXPECT_FALSE(fs::exists(written.files.back())) << written.files.back();
    fs::remove_all(folder / "out");
    fs::create_directories(folder / "out");
  }
}

TEST(Names, MayBeAsLongAsNamesCanBe) {
  const TestFolder folder;
  std::string kanji;
  while (kanji.size() + 3 <= 250) kanji += "\xE6\xBC\xA2";
  for (const std::string& name : {std::string(250, 'x'), kanji}) {
    const fs::path output = folder / (name + ".gltf");
    for (const uint8_t byte : {uint8_t{1}, uint8_t{2}}) {
      Document document = with_bytes();
      append_buffer_view(document, std::vector<uint8_t>{byte});
      must(write_document(document, output));
      ASSERT_TRUE(read_document(output));
      EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2) << "the earlier binary is gone";
    }
    const fs::path binary = read_document(output)->files.back().filename();
    EXPECT_LE(binary.string().size(), 255u);
    EXPECT_FALSE(contains(binary.string(), ".."));
    fs::remove_all(folder / binary);
    fs::remove(output);
  }
}

TEST(Names, BackslashesStandBetweenFoldersUnlessTheyAreEscaped) {
  const TestFolder folder;
  fs::create_directories(folder / "a");
  std::ofstream(folder / "a" / "b") << "x";
  EXPECT_EQ(path_of_uri("a\\b", folder / ""), fs::path("a/b"));
  EXPECT_EQ(path_of_uri("a%5Cb", folder / ""), fs::path("a/b")) << "no other file is there";
  std::ofstream(folder / "a\\b") << "x";
  EXPECT_EQ(path_of_uri("a%5Cb", folder / ""), fs::path("a\\b"));
  EXPECT_EQ(path_of_uri("a\\b", folder / ""), fs::path("a/b"));
  for (const char* uri :
       {"..\\x", "a\\..\\..\\x", "%2e%2e/x", "/x", "\\x", "%2Fx", "C:x", "file:x", "..", "", "%00"})
    EXPECT_FALSE(relative_path_of_uri(uri, folder / "a").ok()) << uri;
  EXPECT_EQ(kind_of_uri("%2Fx"), UriKind::kAbsolute);
  EXPECT_EQ(path_of_uri("%5Ctmp", folder / ""), fs::path("\\tmp")) << "never the root's";
}

}  // namespace
}  // namespace psplit
