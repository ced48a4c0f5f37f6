#include "tests/support/version_1.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace psplit {

std::vector<Version1Container> version_1_containers() {
  std::vector<Version1Container> containers;
  for (const auto& file : std::filesystem::directory_iterator(PSPLIT_VERSION_1_FOLDER)) {
    std::ifstream stream(file.path(), std::ios::binary);
    Version1Container& old = containers.emplace_back();
    old.name = file.path().stem().string();
    old.bytes.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    old.requests = {{.semantic = "POSITION"}};
    if (old.name == "book_with_seams" || old.name == "faces_without_area")
      old.requests.push_back({.semantic = "TEXCOORD_0", .unique_id = 1, .component_count = 2});
  }
  std::sort(containers.begin(), containers.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return containers;
}

std::vector<uint8_t> write_stitch_map_1(const StitchMap& map, uint32_t patch) {
  std::vector<uint8_t> bytes;
  const auto varint = [&](uint32_t value) {
    for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<uint8_t>(value | 0x80));
    bytes.push_back(static_cast<uint8_t>(value));
  };
  if (map.runs.empty() && map.pairs.empty()) return bytes;
  varint(static_cast<uint32_t>(map.runs.size()));
  uint32_t next = 0;
  for (const StitchRun& run : map.runs) {
    varint(run.begin - next);
    varint((run.length - 1) << 1 | (run.forward ? 1u : 0u));
    varint(patch - run.owner);
    varint(run.start);
    next = run.begin + run.length;
  }
  next = 0;
  for (const StitchPair& pair : map.pairs) {
    varint(pair.point - next);
    varint(patch - pair.owner);
    varint(pair.rank);
    next = pair.point + 1;
  }
  return bytes;
}

}  // namespace psplit
