#include "web/src/decoded_container.h"

#include "src/cpu/container_decoder.h"

namespace psplit::web {

Expected<std::unique_ptr<DecodedContainer>> DecodedContainer::open(std::unique_ptr<uint8_t[]> bytes,
                                                                   size_t size) {
  Expected<PatchContainer> container = open_container({bytes.get(), size});
  if (!container) return container.status();
  std::unique_ptr<DecodedContainer> opened(new DecodedContainer());
  opened->bytes_ = std::move(bytes);
  opened->container_ = std::move(*container);
  return opened;
}

Status DecodedContainer::decode_all() {
  const Expected<PrimitiveBuffers> buffers = allocate_mesh(container_.point_count(), container_.face_count(),
                                                           requests_, container_.bytes.size(), mesh_);
  if (!buffers) return buffers.status();
  const ThreadPool pool;
  const Watch watch;
  Steps steps(watch, container_.entries.size());
  return ContainerDecoder({&container_, requests_}, *buffers, pool, steps).decode();
}

}  // namespace psplit::web
