// Reads any bytes as a .glb or a .gltf, and validates, sweeps and decodes the document.
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"
#include "psplit/gltf.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const psplit::ThreadPool pool(1);
  static const psplit::DecodeBackend backend = psplit::cpu_backend();
  // The folder does not exist, so no URI of a file resolves.
  psplit::Expected<psplit::Document> document =
      psplit::parse_document({data, size}, "/nowhere/at/all/asset.gltf");
  if (!document) return 0;
  for (const psplit::PrimitiveId id : psplit::all_primitives(*document)) {
    (void)read_primitive(*document, id, backend, pool);
    (void)read_morph_targets(*document, id);
  }
  (void)validate_document(*document, backend, pool);
  drop_unused(*document, {0});
  (void)decode_document(*document, backend, pool);
  return 0;
}
