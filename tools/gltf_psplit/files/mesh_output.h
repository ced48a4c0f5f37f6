// The scene of a decoded asset as a mesh file: OBJ, PLY, STL or Draco.
#pragma once

#include <optional>
#include <string>

#include "gltf_ext/document/document.h"
#include "mesh_files/asset_format.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {

struct MeshOutputOptions {
  bool accept_loss = false;  // write what the format can hold, with a warning that names the rest
  std::optional<ImagePlacement> images{};
  EncodeDocumentOptions coding{};  // of a .drc file
};

// Writes every triangle primitive of the default scene where its nodes place it; an asset without a scene, each
// mesh once. Of an asset without triangles a PLY holds the points, and a .drc is a point cloud. An OBJ has an
// object for each mesh that the scene shows, and an MTL file and images beside it; these replace no other file.
// A PLY or an STL is one mesh. A .drc is one stock Draco stream. `document` holds plain primitives. Errors:
// as for writing; kUnsupported if the format cannot hold all of the asset, unless the loss is accepted, for a
// .drc of more than one primitive, and for positions that are not finite; kUsage for images that would be
// embedded. `lost` counts the faces and points that a .drc cannot hold.
Status write_mesh_output(const Document& document, const std::string& path, AssetFormat format,
                         const MeshOutputOptions& options, const Session& session, WriteReport& written,
                         EncodeStatistics& lost);

}  // namespace psplit
