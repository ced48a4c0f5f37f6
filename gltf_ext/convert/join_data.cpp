#include "gltf_ext/convert/join_data.h"

#include <map>

#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"

namespace psplit {

JoinedBlocks::Place JoinedBlocks::add(std::span<const uint8_t> block, size_t alignment) {
  const auto [found, is_new] = begins_.try_emplace(std::string(block.begin(), block.end()), 0);
  if (is_new) {
    pad(alignment);
    found->second = bytes_.size();
    bytes_.insert(bytes_.end(), block.begin(), block.end());
  }
  return {found->second, is_new};
}

std::vector<int64_t> share_accessors(Document& document, std::span<const int64_t> accessors) {
  Json& json = document.json();
  std::unordered_map<std::string, int64_t> firsts;
  std::map<int64_t, int64_t> first_of;
  std::vector<int64_t> freed;
  for (const int64_t index : accessors) {
    Json& accessor = json["accessors"][static_cast<size_t>(index)];
    const auto [found, is_new] = firsts.try_emplace(json_line(accessor), index);
    if (is_new) continue;
    first_of[index] = found->second;
    freed.push_back(index);
    for (const char* name : {"bufferView", "byteOffset", "sparse"}) accessor.erase(name);
  }
  for_each_accessor_reference(json, [&](Json& index) {
    const auto found = first_of.find(integer_value(index).value_or(-1));
    if (found != first_of.end()) index = found->second;
  });
  return freed;
}

}  // namespace psplit
