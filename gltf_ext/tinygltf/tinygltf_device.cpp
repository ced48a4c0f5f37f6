// A model's primitives in memory of a CUDA device.
#include "gltf_ext/tinygltf/model_geometry.h"

namespace psplit {
namespace {

// A device reads fastest from such addresses.
constexpr size_t kAlignment = 256;

uint64_t rounded(uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

}  // namespace

Expected<DeviceModel> decode_model_to_device(const tinygltf::Model& model, const ModelOptions& options,
                                             CUstream_st* stream) {
  ModelOptions on_device = options;
  on_device.older = nullptr;
  const Expected<std::vector<ModelGeometry>> geometries = find_geometries(model, on_device);
  if (!geometries) return geometries.status();
  if (options.stop != nullptr && *options.stop) return cancelled();
  Expected<CudaDecoder> decoder = CudaDecoder::create(stream);
  if (!decoder) return decoder.status();

  uint64_t bytes = 0;
  for (const ModelGeometry& geometry : *geometries) {
    bytes += rounded(uint64_t{3} * geometry.stored.face_count() * geometry.index_bytes);
    for (size_t k = 0; k < geometry.accessors.size(); ++k) bytes += rounded(geometry.stored.value_bytes(k));
  }
  Expected<CudaMemory> memory = CudaMemory::allocate(static_cast<size_t>(bytes));
  if (!memory) return memory.status();

  DeviceModel result{std::move(*memory), {}};
  std::vector<CudaPrimitive> batch;
  std::byte* next = result.memory.data();
  const auto take = [&](uint64_t size) { return std::exchange(next, next + rounded(size)); };
  for (const ModelGeometry& geometry : *geometries) {
    const CompressedPrimitive& stored = geometry.stored;
    CudaPrimitive& task = batch.emplace_back();
    task.container = &stored.container();
    task.index_bytes = geometry.index_bytes;
    task.indices = take(uint64_t{3} * stored.face_count() * geometry.index_bytes);
    DevicePrimitive primitive{0, 0, stored.point_count(), stored.face_count(), task.indices, task.index_bytes,
                              {}};
    for (size_t k = 0; k < stored.attributes().size(); ++k) {
      const AttributeRequest& request = stored.attributes()[k];
      std::byte* const values = take(stored.value_bytes(k));
      task.attributes.push_back({request.unique_id, request.component_type, request.component_count, values,
                                 static_cast<uint32_t>(request.value_bytes())});
      primitive.attributes.push_back({request, values});
    }
    for (const PrimitivePlace& user : geometry.users) {
      primitive.mesh = user.mesh;
      primitive.primitive = user.primitive;
      result.primitives.push_back(primitive);
    }
  }
  if (Status status = decoder->start(batch); !status.ok()) return status;
  (void)decoder->finish();
  for (size_t g = 0; g < geometries->size(); ++g) {
    Status status = decoder->status(g);
    const CompressedPrimitive& stored = (*geometries)[g].stored;
    if (status.ok() && stored.compression() == Compression::kDraco &&
        decoder->point_count(g) != stored.point_count())
      status = invalid_input("the stream has " + std::to_string(decoder->point_count(g)) +
                             " points, the accessors have " + std::to_string(stored.point_count()));
    if (status.ok()) continue;
    Place place = (*geometries)[g].users.front().place();
    place.patch = status.place().patch;
    return Status(status.code(), status.message(), place);
  }
  return result;
}

}  // namespace psplit
