// Encodes a mesh file of any size in bounded memory.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/mesh_files/asset_format.h"
#include "src/container/decode_backend.h"
#include "src/parallel.h"
#include "src/status.h"

namespace psplit {

struct OutOfCoreResult {
  Document document;  // one mesh; the containers are in mapped temporary files
  PrimitiveReport report;
  std::vector<std::string> warnings;  // data that was left out or changed
};

// Reads a mesh file once, into temporary files; cuts the mesh into parts that fit into memory; and encodes one
// part after the other into containers of PSPLIT_mesh_draco_patches. There is one primitive, or several on one
// grid if a container cannot hold all points. The values are those that read_asset and encode_document give;
// patches are cut part by part, so their order differs. Solids of a text STL share a mesh. A mesh whose
// triangles are all degenerate stays as it is. Errors: kUsage, those of read_spool and of encode_parts,
// kMayPass if there is too little temporary space, kUnsupported for meshes that cannot be divided.
Expected<OutOfCoreResult> encode_out_of_core(Scanner& scanner, AssetFormat format,
                                             const std::filesystem::path& source,
                                             const EncodeDocumentOptions& options,
                                             const OutOfCoreOptions& limits, const ThreadPool& pool,
                                             const Progress& progress = {});

}  // namespace psplit
