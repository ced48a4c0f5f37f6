// encode_gltf IN OUT [PATCH_FACES]: encodes every triangle mesh of a .gltf or .glb file, and writes the result
// as a .gltf or .glb file. This is where a pipeline in C++ starts: it reads documents, changes them, and writes
// them.
#include <psplit/document.h>
#include <psplit/gltf.h>

#include <cstdlib>
#include <iostream>
#include <psplit/psplit.hpp>

namespace {

int fail(const psplit::Status& status) {
  std::cerr << status.to_string() << "\n";
  return 3;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: encode_gltf IN OUT [PATCH_FACES]\n";
    return 1;
  }
  psplit::Expected<psplit::Document> document = psplit::read_document(argv[1]);
  if (!document) return fail(document.status());

  // The defaults are those of `gltf-psplit encode`: each primitive is split by its size.
  psplit::EncodeDocumentOptions options;
  if (argc > 3) options.patches.faces = std::strtoull(argv[3], nullptr, 10);
  const psplit::ThreadPool pool;  // all threads of the machine
  // Meshes that are compressed already are decoded with the backend.
  const auto reports = psplit::encode_document(*document, options, psplit::cpu_backend(), pool);
  if (!reports) return fail(reports.status());

  if (psplit::Status status = psplit::write_document(*document, argv[2]); !status.ok()) return fail(status);
  for (const psplit::PrimitiveReport& report : *reports) {
    std::cout << "mesh " << report.id.mesh << ", primitive " << report.id.primitive << ": ";
    if (report.skipped.empty())
      std::cout << report.statistics.patch_count << " patches, " << report.bytes << " bytes\n";
    else
      std::cout << "left as it is: " << report.skipped << "\n";
  }
}
