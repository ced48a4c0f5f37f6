#include "tests/support/sample_containers.h"

#include <cstdlib>
#include <fstream>
#include <iterator>

namespace psplit {
namespace {

// The only buffer view of a GLB, whose buffer follows the JSON.
std::vector<uint8_t> only_view(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string file((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const std::string key = "\"byteLength\":";
  const size_t length = file.find(key, file.find("\"bufferViews\":"));
  const size_t begin = file.find("PSPL", file.find("BIN", length));
  if (begin == std::string::npos) return {};
  const std::string bytes = file.substr(begin, std::strtoul(&file[length + key.size()], nullptr, 10));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<SampleContainer> sample_containers() {
  std::vector<SampleContainer> containers;
  for (const std::string name : {"patches", "seams", "residue"}) {
    SampleContainer& sample = containers.emplace_back();
    sample.name = name;
    sample.bytes = only_view(PSPLIT_SAMPLES "/" + name + ".glb");
    sample.requests = {{.semantic = "POSITION"}};
    if (name == "seams")
      sample.requests.push_back({.semantic = "TEXCOORD_0", .unique_id = 2, .component_count = 2});
  }
  return containers;
}

}  // namespace psplit
