#include "gltf_ext/primitive/describe_primitive.h"

#include <utility>

#include "src/container/patch_container.h"
#include "src/fields/expand_container.h"

namespace psplit {

Expected<DescribedPrimitive> describe_primitive(const Document& document, PrimitiveId id,
                                                const DescribeStream& describe, const ThreadPool& pool) {
  const bool patched = document.records().primitive(id).storage() == PrimitiveStorage::kPatches;
  auto stored = stored_primitive(document, id);
  if (!stored) return stored.status();
  std::vector<std::span<const uint8_t>> streams{stored->bytes};
  Expected<PatchContainer> container = PatchContainer();
  if (patched) {
    container = open_container(stored->bytes);
    if (!container) return container.status();
    streams = container->streams;
  }
  std::vector<Expected<StreamDescription>> descriptions(streams.size(), StreamDescription{});
  pool.for_each(streams.size(), [&](size_t i) {
    if (!patched || !container->entries[i].is_condensed) {
      descriptions[i] = describe(streams[i]);
      return;
    }
    const auto expanded = expand_patch(*container, static_cast<uint32_t>(i));
    descriptions[i] = expanded ? describe(*expanded) : expanded.status();
  });
  DescribedPrimitive described{std::move(stored->requests), {}};
  for (size_t i = 0; i < streams.size(); ++i) {
    if (!descriptions[i]) return descriptions[i].status().at({.patch = patched ? static_cast<int64_t>(i) : -1});
    described.streams.push_back(std::move(*descriptions[i]));
  }
  return described;
}

}  // namespace psplit
