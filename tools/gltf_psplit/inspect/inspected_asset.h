// What `inspect` finds in an asset: how each primitive is stored, and what that costs.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "encoder/fields/section_bytes.h"
#include "gltf_ext/convert/coarse_primitives.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"
#include "psplit/parallel.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/patch_summary.h"

namespace psplit {

struct InspectedPrimitive {
  PrimitiveId id;
  PrimitiveStorage storage = PrimitiveStorage::kPlain;
  PatchSummary summary;                // of a plain primitive only faces and points
  std::optional<StreamCoding> coding;  // of the first stream; nothing for a plain primitive
  std::vector<AttributeRequest> attributes;
  std::vector<int> bits;                        // one for each attribute; 0 if it is stored exactly
  SectionBytes sections;                        // of the condensed streams
  std::vector<std::string> section_attributes;  // the names of `sections.attributes`
  std::vector<PatchBox> boxes;                  // one for each stream; none if the container has none
  uint64_t boxes_bytes = 0;                     // of their section, in the head
  std::string broken_boxes;                     // why a section of boxes cannot be read
};

struct InspectedAsset {
  std::string file;
  AssetBytes bytes;
  std::vector<InspectedPrimitive> compressed, plain;
  CoarseCounts coarse;
  std::vector<std::string> warnings;

  PatchSummary sum() const {
    PatchSummary sum;
    for (const InspectedPrimitive& primitive : compressed) sum += primitive.summary;
    return sum;
  }
};

// Adds all primitives of the document to `asset`, and a warning for boxes that readers ignore. An error names
// the primitive.
Status inspect_primitives(const Document& document, const DescribeStream& describe, const ThreadPool& pool,
                          InspectedAsset& asset);

Json to_json(const InspectedAsset& asset);

// A table of the compressed primitives, then a line for each plain one. `wide`: all columns.
std::string to_text(const InspectedAsset& asset, bool wide);
// One line for each asset.
std::string to_text(std::span<const InspectedAsset> assets, bool wide);

// "dragon.glb: 1.18 MB, mesh data 1.15 MB in 1 primitive and 45 patches"
std::string summary_text(const InspectedAsset& asset);

}  // namespace psplit
