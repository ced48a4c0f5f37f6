// Why a stream does not decode. The core reports errors in no other way: it has no exceptions, and no text on
// the device.
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

enum class Fault : uint8_t {
  kNone,
  kWorkspace,     // the memory is too small; with more it may decode
  kTruncated,     // the stream ends early
  kNotDraco,      // no "DRACO" at its start, or not a mesh
  kVersion,       // not bitstream 2.2
  kMethod,        // an unknown coding, or one that bitstream 2.2 no longer has
  kCounts,        // counts that contradict each other
  kConnectivity,  // symbols that do not form a mesh
  kSplitEvent,    // a topology split event without a fitting symbol
  kSeams,         // attribute seams that tear a vertex
  kEntropy,       // an invalid probability table or rANS state
  kAttribute,     // an attribute's type, component count or transform
  kPrediction,    // prediction data that contradicts the mesh
  kIndex,         // a face with a point that does not exist
  kTree,          // a kD-tree that splits more points than it has, or along an axis that does not exist
  kSection,       // a condensed section that does not end where its data ends
  kRow,           // counts that differ from the directory's row
  kRequest,       // a requested attribute is missing or has another type
  kStitchMap,     // a stitch map that ends early, or whose number of references differs from its row
  kStitchRun,     // a run that leaves the border of its patch
  kStitchPair,    // a point that does not exist, or that has two references
  kStitchOwner,   // a reference to a point that its owner does not own
};

// A phrase that follows "patch 7: ".
constexpr const char* fault_text(Fault fault) {
  switch (fault) {
    case Fault::kNone: return "no fault";
    case Fault::kWorkspace: return "the stream needs more memory than its size justifies";
    case Fault::kTruncated: return "the stream ends early";
    case Fault::kNotDraco: return "not a Draco mesh";
    case Fault::kVersion: return "not Draco bitstream 2.2";
    case Fault::kMethod: return "a coding method that does not exist";
    case Fault::kCounts: return "counts that contradict each other";
    case Fault::kConnectivity: return "connectivity symbols that do not form a mesh";
    case Fault::kSplitEvent: return "a topology split event without a fitting symbol";
    case Fault::kSeams: return "attribute seams that tear a vertex";
    case Fault::kEntropy: return "an invalid probability table or rANS state";
    case Fault::kAttribute: return "an attribute whose description contradicts itself";
    case Fault::kPrediction: return "prediction data that contradicts the mesh";
    case Fault::kIndex: return "a face with a point that does not exist";
    case Fault::kTree: return "a kD-tree that contradicts itself";
    case Fault::kSection: return "a condensed section that does not end where its data ends";
    case Fault::kRow: return "counts other than the directory's";
    case Fault::kRequest: return "a requested attribute is missing or has another type";
    case Fault::kStitchMap:
      return "stitch map: it ends early, or its number of references is not the directory's";
    case Fault::kStitchRun: return "stitch map: a run leaves the border of its patch";
    case Fault::kStitchPair: return "stitch map: a point that does not exist, or that has two references";
    case Fault::kStitchOwner: return "stitch map: a reference to a point that its owner does not own";
  }
  return "unknown fault";
}

}  // namespace psplit::core
