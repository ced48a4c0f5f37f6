// Images of an asset that is written to another place: none is lost, and no file is replaced.

#include <fstream>
#include <string>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/json/json.h"
#include "psplit/document.h"
#include "system/files.h"
#include "system/image_type.h"
#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;

const std::string kPng = "\x89PNG\r\n\x1a\n"s + "the pixels of one",
                  kOtherPng = "\x89PNG\r\n\x1a\n"s + "another", kJpeg = "\xff\xd8\xff\xe0 a photograph"s;

class Images : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& bytes) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  std::string text(const std::string& name) const {
    const auto bytes = read_file(folder_ / name);
    return bytes ? std::string(bytes->begin(), bytes->end()) : "";
  }
  // Writes in/NAME with these members of the JSON and reads it.
  Document asset(const std::string& members, const std::string& name = "in/asset.gltf") const {
    write(name, R"({"asset":{"version":"2.0"},)" + members + "}");
    return must(read_document(folder_ / name));
  }
  Document images(const std::vector<std::string>& uris, const std::string& name = "in/asset.gltf") const {
    Json list = Json::array();
    for (const std::string& uri : uris) list.push_back({{"uri", uri}});
    return asset("\"images\":" + list.dump(), name);
  }
  WriteReport convert(const Document& document, const std::string& output,
                      const WriteOptions& options = {}) const {
    fs::create_directories((folder_ / output).parent_path());
    WriteReport report;
    must(write_document(document, folder_ / output, options, &report));
    return report;
  }
  Json json(const std::string& output) const { return read_document(folder_ / output)->json(); }
  std::string uri(const std::string& output, size_t image = 0) const {
    const Json images = json(output)["images"];
    return images[image].value("uri", "");
  }
  // The content of an image of an output, embedded or in the file of its URI.
  std::string pixels(const std::string& output, size_t image = 0) const {
    const auto document = read_document(folder_ / output);
    const Json& object = document->json()["images"][image];
    if (object.contains("bufferView")) {
      const auto bytes = buffer_view_bytes(*document, object["bufferView"].get<int64_t>());
      return std::string(bytes->begin(), bytes->end());
    }
    for (const LinkedFile& link : linked_files(*document))
      if (link.image == static_cast<int64_t>(image) && link.state == LinkState::kFound) {
        const auto bytes = read_file(link.path);
        return std::string(bytes->begin(), bytes->end());
      }
    return "";
  }
  std::ptrdiff_t file_count(const std::string& name) const {
    return std::distance(fs::directory_iterator(folder_ / name), {});
  }

  TestFolder folder_;
};

constexpr WriteOptions kEmbed{ImagePlacement::kEmbed}, kCopy{ImagePlacement::kCopy},
    kReference{ImagePlacement::kReference};

TEST(ImageType, IsToldByContent) {
  const auto mime = [](const std::string& bytes) -> std::string {
    const auto type = image_type({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    return type ? type->mime_type : "";
  };
  EXPECT_EQ(mime(kPng), "image/png");
  EXPECT_EQ(mime(kJpeg), "image/jpeg");
  EXPECT_EQ(mime("RIFF\x24\0\0\0WEBPVP8 "s), "image/webp");
  EXPECT_EQ(mime("\xabKTX 20\xbb\r\n\x1a\n\0\0\0\0"s), "image/ktx2");
  EXPECT_EQ(mime("\xabKTX 11\xbb\r\n\x1a\n\0\0\0\0"s), "image/ktx");
  EXPECT_EQ(mime("sB\x13\0\x4d\0rest"s), "image/basis");
  EXPECT_EQ(mime("DDS \x7c\0\0\0rest"s), "image/vnd-ms.dds");
  EXPECT_EQ(mime("\0\0\0\x1c"
                 "ftypavif\0\0\0\0avifmif1miaf"s),
            "image/avif");
  EXPECT_EQ(mime("\0\0\0\x18"
                 "ftypmif1\0\0\0\0mif1avif"s),
            "image/avif");
  EXPECT_EQ(mime("GIF89a"), "image/gif");
  EXPECT_EQ(mime("BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0"s), "image/bmp");
  for (const std::string& other : {""s, "#!/bin/sh"s, "BMW"s, "sBasis"s, "RIFF\x24\0\0\0WAVEfmt "s, "{}"s,
                                   "\0\0\0\x18"
                                   "ftypisom\0\0\0\0"s,
                                   "\x89PN"s})
    EXPECT_EQ(mime(other), "") << other;
}

TEST_F(Images, AGlbEmbedsThem) {
  write("in/tex/\xc3\xbc a b.jpg", kPng);  // its name is wrong
  write("in/photo.jpg", kJpeg);
  const Document document = images({"tex/%C3%BC%20a%20b.jpg", "photo.jpg", "tex/\xc3\xbc a b.jpg"});
  const WriteReport report = convert(document, "out/asset.glb");
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_EQ(report.embedded_images, 3u);
  EXPECT_EQ(report.image_bytes, kPng.size() + kJpeg.size());
  EXPECT_EQ(pixels("out/asset.glb", 0), kPng);
  EXPECT_EQ(pixels("out/asset.glb", 1), kJpeg);
  const Json written = json("out/asset.glb");
  EXPECT_EQ(written["images"][0],
            Json::parse("{\"bufferView\":0,\"mimeType\":\"image/png\",\"name\":\"\xc3\xbc a b\"}"));
  EXPECT_EQ(written["images"][1]["mimeType"], "image/jpeg");
  EXPECT_EQ(written["images"][2], written["images"][0]) << "the same file, embedded once";
  EXPECT_EQ(written["bufferViews"].size(), 2u);
  EXPECT_EQ(file_count("out"), 1);
}

TEST_F(Images, EmbeddingKeepsNamesAndWhatIsEmbeddedAlready) {
  write("in/a.png", kPng);
  const Document document = asset(
      R"("buffers":[{"byteLength":4,"uri":"data:;base64,AAAAAA=="}],"bufferViews":[{"buffer":0,"byteLength":4}],
         "images":[{"uri":"a.png","name":"mine","mimeType":"image/jpeg","extras":7},
                   {"uri":"data:image/png;base64,iVBORw0KGgo="},
                   {"bufferView":0,"mimeType":"image/png"},
                   {"bufferView":0,"mimeType":"image/png","uri":"a.png"},
                   {"uri":"https://example.com/a.png"}])");
  const WriteReport report = convert(document, "out/asset.glb");
  EXPECT_EQ(report.warnings, std::vector<std::string>());
  const Json before = document.json()["images"], after = json("out/asset.glb")["images"];
  EXPECT_EQ(after[0], Json::parse(R"({"name":"mine","mimeType":"image/png","extras":7,"bufferView":1})"));
  for (size_t i = 1; i < 5; ++i) EXPECT_EQ(after[i], before[i]) << i;
}

TEST_F(Images, AGltfCopiesThem) {
  write("in/tex/a b.png", kPng);
  const WriteReport report = convert(images({"tex/a%20b.png", "tex/a b.png"}), "out/asset.gltf");
  EXPECT_TRUE(report.warnings.empty() && report.notes.empty());
  EXPECT_EQ(text("out/tex/a b.png"), kPng);
  EXPECT_EQ(uri("out/asset.gltf"), "tex/a%20b.png") << "as it was";
  EXPECT_EQ(report.copied_images, 2u);
  convert(images({"tex/a%20b.png"}), "in/other.gltf");
  EXPECT_EQ(file_count("in/tex"), 1) << "nothing to copy in the same folder";
}

// Two assets have images with the same name, and the user has a file with that name.
TEST_F(Images, ACopyReplacesNothing) {
  write("a/x.png", kPng);
  write("b/x.png", kOtherPng);
  write("out/y.png", "the user's own");
  write("a/y.png", kPng);
  convert(images({"x.png", "y.png"}, "a/asset.gltf"), "out/a.gltf");
  const WriteReport report = convert(images({"x.png"}, "b/asset.gltf"), "out/b.gltf");
  EXPECT_EQ(report.notes.size(), 1u);
  EXPECT_EQ(text("out/x.png"), kPng);
  EXPECT_EQ(text("out/y.png"), "the user's own");
  EXPECT_EQ(pixels("out/a.gltf", 0), kPng);
  EXPECT_EQ(pixels("out/a.gltf", 1), kPng);
  EXPECT_EQ(pixels("out/b.gltf"), kOtherPng);
  EXPECT_NE(uri("out/b.gltf"), "x.png");

  const std::string before = uri("out/b.gltf");
  const auto files = file_count("out");
  convert(images({"x.png"}, "b/asset.gltf"), "out/b.gltf");
  convert(images({"x.png", "y.png"}, "a/asset.gltf"), "out/a.gltf");
  EXPECT_EQ(uri("out/b.gltf"), before) << "once more is the same";
  EXPECT_EQ(file_count("out"), files);
}

TEST_F(Images, ATakenNameByContentIsAnError) {
  write("in/x.png", kPng);
  write("out/x.png", "the user's own");
  convert(images({"x.png"}), "out/asset.gltf");
  write("out/" + uri("out/asset.gltf"), "tampered with");
  const Status status = write_document(images({"x.png"}), folder_ / "out" / "asset.gltf");
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_TRUE(contains(status.message(), "x.png"));
}

TEST_F(Images, LinksAndFoldersOfAnImagesNameStay) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  write("in/x.png", kPng);
  write("in/y.png", kPng);
  write("elsewhere.png", "the user's own");
  fs::create_directories(folder_ / "out" / "y.png");
  fs::create_symlink("../elsewhere.png", folder_ / "out" / "x.png");
  convert(images({"x.png", "y.png"}), "out/asset.gltf");
  EXPECT_EQ(text("elsewhere.png"), "the user's own");
  EXPECT_TRUE(fs::is_directory(folder_ / "out" / "y.png"));
  EXPECT_EQ(pixels("out/asset.gltf", 0), kPng);
  EXPECT_EQ(pixels("out/asset.gltf", 1), kPng);
}

TEST_F(Images, OfOtherFoldersComeAlong) {
  write("textures/x.png", kPng);
  const Document document = images({"../textures/x.png"}, "assets/a.gltf");
  convert(document, "deep/er/asset.glb");
  EXPECT_EQ(pixels("deep/er/asset.glb"), kPng);
  convert(document, "deep/er/asset.gltf");
  EXPECT_EQ(uri("deep/er/asset.gltf"), "x.png") << "below the output's folder, not beside it";
  EXPECT_EQ(text("deep/er/x.png"), kPng);
  convert(document, "assets/b.gltf");
  EXPECT_EQ(uri("assets/b.gltf"), "../textures/x.png") << "leads there still";
  EXPECT_EQ(pixels("assets/b.gltf"), kPng);
}

// An asset must not make psplit copy or embed files that are not images.
TEST_F(Images, WhatIsNoImageStaysWhereItIs) {
  write("secret", "key");
  write("secret.png", "key");
  write("in/script.sh", "#!/bin/sh");
  write("in/broken.png", "no pixels");
  const Document document = images({"../secret", "../secret.png", "script.sh", "broken.png"});
  const WriteReport gltf = convert(document, "out/asset.gltf");
  EXPECT_EQ(gltf.warnings.size(), 3u);
  EXPECT_EQ(json("out/asset.gltf")["images"], document.json()["images"]);
  EXPECT_EQ(file_count("out"), 2) << "the .gltf and broken.png, whose name says that it is an image";
  const WriteReport glb = convert(document, "other/asset.glb");
  EXPECT_EQ(glb.warnings.size(), 4u);
  EXPECT_EQ(glb.embedded_images, 0u);
  EXPECT_EQ(text("other/broken.png"), "no pixels");
  EXPECT_EQ(file_count("other"), 2);
}

TEST_F(Images, ACopyIsNamedLikeAnImage) {
  write("in/.bashrc", kPng);
  write("in/asset.glb", kPng);
  const WriteReport report = convert(images({".bashrc", "asset.glb"}), "out/asset.gltf");
  EXPECT_FALSE(fs::exists(folder_ / "out" / ".bashrc"));
  EXPECT_FALSE(fs::exists(folder_ / "out" / "asset.glb"));
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(pixels("out/asset.gltf", i), kPng);
    EXPECT_TRUE(uri("out/asset.gltf", i).ends_with(".png"));
  }
  EXPECT_EQ(report.notes.size(), 2u);
}

TEST_F(Images, ReferencesLeadToTheInput) {
  write("in/tex/\xc3\xa4 b.png", kPng);
  write("x.png", kOtherPng);
  const Document document = images({"tex/%C3%A4%20b.png", "../x.png"});
  for (const std::string output : {"out/deep/asset.gltf", "out/asset.glb", "asset.gltf"}) {
    const WriteReport report = convert(document, output, kReference);
    EXPECT_TRUE(report.warnings.empty()) << output;
    EXPECT_EQ(pixels(output, 0), kPng) << output;
    EXPECT_EQ(pixels(output, 1), kOtherPng) << output;
  }
  EXPECT_EQ(uri("out/deep/asset.gltf"), "../../in/tex/%C3%A4%20b.png");
  EXPECT_EQ(uri("asset.gltf"), "in/tex/%C3%A4%20b.png");
}

TEST_F(Images, OptionsTakeTheOtherWay) {
  write("in/x.png", kPng);
  convert(images({"x.png"}), "copied/asset.glb", kCopy);
  EXPECT_EQ(uri("copied/asset.glb"), "x.png");
  EXPECT_EQ(text("copied/x.png"), kPng);
  convert(images({"x.png"}), "embedded/asset.gltf", kEmbed);
  EXPECT_EQ(pixels("embedded/asset.gltf"), kPng);
  EXPECT_FALSE(fs::exists(folder_ / "embedded" / "x.png"));
  EXPECT_EQ(write_document(images({"x.png"}), "-", kCopy).code(), StatusCode::kUsage);
}

TEST_F(Images, WhatDanglesIsAWarning) {
  const Document document = asset(
      R"("images":[{"uri":"none.png"},{"uri":"/abs/x.png"},{"uri":"file:///x.png"},{"uri":"C:\\x.png"},
                   {"uri":"http://example.com/x.png"},{"uri":"blob:x"}],
         "extensions":{"MSFT_audio_emitter":{"clips":[{"uri":"song.mp3"},{"uri":"HTTPS://example.com/a.mp3"}]}},
         "extras":{"uri":"whatever"})");
  write("in/song.mp3", "ID3");
  for (const std::string output : {"out/asset.glb", "out/asset.gltf"}) {
    const WriteReport report = convert(document, output);
    ASSERT_EQ(report.warnings.size(), 6u) << output;
    EXPECT_TRUE(contains(report.warnings[0], "image 0"));
    EXPECT_TRUE(contains(report.warnings[0], "none.png"));
    EXPECT_TRUE(contains(report.warnings[4], "blob:x"));
    EXPECT_TRUE(contains(report.warnings[5], "song.mp3"));
    EXPECT_TRUE(contains(report.warnings[5], "extensions.MSFT_audio_emitter.clips[0]"));
    EXPECT_EQ(json(output)["images"], document.json()["images"]);
  }
  EXPECT_EQ(convert(document, "in/asset.glb").warnings.size(), 5u) << "where the song is";
}

// The copy of an image gets a URI that every reader understands.
TEST_F(Images, UrisOfCopiesAreEscaped) {
  for (const auto& [name, uri, copied] : {std::array{"a%20b.png", "a%20b.png", "a%2520b.png"},
                                          {"c#1.png", "c#1.png", "c%231.png"},
                                          {"d/e.png", "d\\e.png", "d/e.png"},
                                          {"f.png", "f.png?v=2", "f.png"},
                                          {"g h.png", "g h.png", "g h.png"}}) {
    write(std::string("in/") + name, kPng);
    convert(images({uri}), "out/asset.gltf");
    EXPECT_EQ(this->uri("out/asset.gltf"), copied);
    EXPECT_EQ(text(std::string("out/") + name), kPng);
  }
}

}  // namespace
}  // namespace psplit
