// Reads any bytes as PLY, OBJ, STL or OFF, or as gzip of these. The first byte selects the name of the file,
// which decides the format if the content does not.
#include "gltf_ext/primitive/read_primitives.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const psplit::ThreadPool pool(1);
  static const psplit::DecodeBackend backend = psplit::cpu_backend();
  // The folder does not exist, so no material file is found.
  static constexpr const char* kNames[] = {"/nowhere/a.ply", "/nowhere/a.obj", "/nowhere/a.stl",
                                           "/nowhere/a.off"};
  if (size == 0) return 0;
  const psplit::Expected<psplit::Asset> asset = psplit::read_asset(
      psplit::memory_stream({data + 1, size - 1}), kNames[data[0] % 4], psplit::describe_stream);
  if (!asset) return 0;
  for (const psplit::PrimitiveId id : psplit::all_primitives(asset->document))
    if (!psplit::read_primitive(asset->document, id, backend, pool)) __builtin_trap();
  return 0;
}
