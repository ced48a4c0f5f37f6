// Small files of every format with bytes changed, removed, doubled and swapped. Each is read as a consistent
// mesh or refused. None may crash (sanitizers check this) or take more memory than its bytes justify.
#include <filesystem>
#include <fstream>

#include "tests/mesh_files/mesh_text.h"
#include "tests/support/corpus_folder.h"
#include "tests/support/mesh_file_seeds.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

// The small files of the corpus, if it exists.
std::vector<std::string> corpus_seeds() {
  namespace fs = std::filesystem;
  std::vector<std::string> seeds;
  std::vector<fs::path> files;
  std::error_code error;
  for (const char* folder : {"mesh", "malformed"})
    for (fs::recursive_directory_iterator entry(corpus_folder() / folder, error), end; !error && entry != end;
         entry.increment(error))
      if (entry->is_regular_file() && entry->file_size() < 1000) files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  for (const fs::path& path : files) {
    const std::string extension = path.extension().string();
    if (extension != ".ply" && extension != ".obj" && extension != ".stl" && extension != ".off") continue;
    std::ifstream file(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return seeds;
}

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15 + 1) {}
  size_t below(size_t bound) {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<size_t>(state_ % std::max<size_t>(bound, 1));
  }

 private:
  uint64_t state_;
};

std::string mutant_of(const std::vector<std::string>& seeds, Random& random) {
  static const std::vector<std::string> kWords = {
      "-1",  "0",   "4294967295", "99999999999", "nan", "inf",  "1e38",  "-",    "\n", " ", "f ",   "v ",
      "ply", "OFF", "1e99",       "2147483647",  "int", "list", "solid", "\r\n", "#",  "/", "\\\n", "double"};
  std::string text = seeds[random.below(seeds.size())];
  for (size_t change = 0, changes = 1 + random.below(4); change < changes; ++change) {
    const size_t at = random.below(text.size()), length = random.below(12);
    switch (random.below(7)) {
      case 0: text[at < text.size() ? at : 0] = static_cast<char>(random.below(256)); break;
      case 1: text.erase(std::min(at, text.size()), length); break;
      case 2: text.insert(std::min(at, text.size()), kWords[random.below(kWords.size())]); break;
      case 3: text.insert(std::min(at, text.size()), text.substr(random.below(text.size()), length)); break;
      case 4: text.resize(at); break;
      case 5: text.replace(std::min(at, text.size()), length, kWords[random.below(kWords.size())]); break;
      default: {
        const std::string& other = seeds[random.below(seeds.size())];
        text += other.substr(std::min(random.below(other.size()), other.size()));
      }
    }
    if (text.empty()) text = " ";
  }
  return text;
}

void expect_whole(const Expected<Asset>& asset, const std::string& text) {
  const StatusCode code = asset.status().code();
  ASSERT_TRUE(code == StatusCode::kOk || code == StatusCode::kInvalidInput || code == StatusCode::kUnsupported)
      << asset.status().to_string() << "\n"
      << text;
  if (!asset) {
    ASSERT_FALSE(asset.status().message().empty()) << text;
    return;
  }
  // The size of the document is bounded by that of the file.
  ASSERT_LT(asset->document.buffers.at(0).size(), 4096 + 200 * text.size()) << text;
  for (const PrimitiveId id : all_primitives(asset->document)) {
    const auto mesh = must(read_primitive(asset->document, id, cpu_backend(), ThreadPool(1)));
    ASSERT_FALSE(mesh.faces.empty()) << text;
    for (const auto& face : mesh.faces)
      for (const uint32_t point : face) ASSERT_LT(point, mesh.point_count) << text;
    for (const char* semantic : {"POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"})
      for (const float value : floats_of(mesh, semantic)) ASSERT_TRUE(std::isfinite(value)) << text;
  }
}

TEST(MeshFileMutants, AreReadWholeOrRefused) {
  std::vector<std::string> seeds = mesh_file_seeds();
  const size_t made_here = seeds.size();
  for (const std::string& seed : seeds) {
    const auto asset = must(read_text(seed));
  }
  for (std::string& seed : corpus_seeds()) seeds.push_back(std::move(seed));
  constexpr size_t kMutants = fewer_with_sanitizers(100'000);
  constexpr const char* kNames[] = {"a.ply", "a.obj", "a.stl", "a.off"};
  size_t read = 0;
  for (size_t i = 0; i < kMutants; ++i) {
    Random random(i);
    const std::string text = mutant_of(seeds, random);
    const Expected<Asset> asset = read_text(text, kNames[i % 4]);
    expect_whole(asset, text);
    if (HasFatalFailure()) return;
    read += asset.ok();
  }
  // Some are read and some are refused: otherwise the mutants would test nothing.
  EXPECT_GT(read, kMutants / 20) << made_here;
  EXPECT_LT(read, kMutants);
}

}  // namespace
}  // namespace psplit
