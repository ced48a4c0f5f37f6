// One geometry on its way through the encoder, in memory or in parts.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"

namespace psplit {

// The reports of all primitives of a document while it is encoded.
using EncodeReports = std::map<PrimitiveId, PrimitiveReport>;

// Meshes of one group share grids.
struct GridGroups {
  QuantizationVolume volume = QuantizationVolume::kMesh;
  std::map<size_t, size_t> joined{};  // the group of meshes that share a geometry with others

  // Nothing if each primitive has grids of its own.
  std::optional<size_t> of_mesh(size_t mesh) const {
    if (volume == QuantizationVolume::kPrimitive) return std::nullopt;
    const auto found = joined.find(mesh);
    return volume == QuantizationVolume::kScene ? 0 : found == joined.end() ? mesh : found->second;
  }
};

struct EncodeJob {
  PrimitiveGroup group;  // the primitives that have this geometry
  MeshToEncode source;   // without arrays once it is encoded; in parts it never has any
  std::vector<MorphAttribute> morphs;
  // Morph targets that are equal to an attribute of `source`, which is stored for both: their names, and its.
  std::vector<std::pair<std::string, std::string>> equal_targets{};
  Array<std::byte> numbers;      // of points in the file that they come from, if these keep points apart
  uint64_t face_count = 0;       // of the input
  uint64_t points_in_parts = 0;  // of the input; in memory, `source` has their number
  EncodedMesh encoded;
  bool drops_attributes = false;  // which its stock Draco stream would keep
  StoredAs stored_as = StoredAs::kAsItWas;
  uint64_t stored_bytes = 0;          // of the container or the streams
  std::vector<std::string> warnings;  // what it loses
  Status status;

  bool is_in_parts() const { return points_in_parts > 0; }  // with its bytes in temporary files
  uint64_t point_count() const { return is_in_parts() ? points_in_parts : source.mesh.point_count; }
  // Containers and lone streams: each becomes a primitive.
  size_t piece_count() const { return encoded.pieces.size(); }

  // How POSITION is quantized; null if it is stored exactly.
  AttributeCoding* position_coding() {
    for (size_t i = 0; i < source.codings.size(); ++i)
      if (source.mesh.attributes[i].semantic == "POSITION" && source.codings[i].bits > 0)
        return &source.codings[i];
    return nullptr;
  }

  // Gives what was encoded the targets that are equal to others.
  void add_equal_targets();
  // Fills in stored_as and stored_bytes.
  void note_storage();
  // Fills in the report's fields about the output.
  void report(PrimitiveReport& report);

  Place place(const Document& document) const { return place_of(document, group.ids.front()); }
};

// Morph targets in the order of the stored points: point i is source_point[i] of the input.
std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point);

}  // namespace psplit
