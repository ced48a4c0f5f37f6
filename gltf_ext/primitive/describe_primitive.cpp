#include "gltf_ext/primitive/describe_primitive.h"

#include <utility>

#include "psplit/decode.h"
#include "src/container/patch_container.h"

namespace psplit {

Expected<DescribedPrimitive> describe_primitive(const Document& document, PrimitiveId id,
                                                const DescribeStream& describe, const ThreadPool& pool) {
  const bool patched = document.records().primitive(id).storage() == PrimitiveStorage::kPatches;
  auto stored = stored_primitive(document, id);
  if (!stored) return stored.status();
  Expected<PatchContainer> container = PatchContainer();
  if (patched) {
    container = open_container(stored->bytes);
    if (!container) return container.status();
  }
  const size_t stream_count = patched ? container->streams.size() : 1;
  std::vector<Expected<StreamDescription>> descriptions(stream_count, StreamDescription{});
  pool.for_each(stream_count, [&](size_t i) {
    descriptions[i] = patched ? describe_patch(*container, static_cast<uint32_t>(i)) : describe(stored->bytes);
  });
  DescribedPrimitive described{std::move(stored->requests), {}};
  for (Expected<StreamDescription>& description : descriptions) {
    if (!description) return description.status();
    described.streams.push_back(std::move(*description));
  }
  return described;
}

}  // namespace psplit
