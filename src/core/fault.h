// Why a stream does not decode. The core's only error channel: no exceptions, no text on the device.
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

enum class Fault : uint8_t {
  kNone,
  kWorkspace,     // the memory given is too small; more would do
  kTruncated,     // the stream ends early
  kNotDraco,      // no "DRACO" at its start, or not a mesh
  kVersion,       // not bitstream 2.2
  kMethod,        // a coding that does not exist, or that 2.2 no longer has
  kCounts,        // counts that contradict each other
  kConnectivity,  // symbols that make no mesh
  kSplitEvent,    // a topology split event that fits no symbol
  kSeams,         // attribute seams that tear a vertex
  kEntropy,       // a probability table or rANS state that cannot be
  kAttribute,     // an attribute's type, component count or transform
  kPrediction,    // a prediction that its data contradicts
  kIndex,         // a face with a point that is not there
  kRow,           // other counts than the directory's row
  kRequest,       // an attribute that is asked for is not there, or has another type
  kStitchMap,     // a stitch map that ends early, or has other references than its row counts
  kStitchRun,     // a run that leaves the border of its patch
  kStitchPair,    // a point that is not there, or that has two references
  kStitchOwner,   // a reference to a point that its owner does not own
};

// A phrase to follow "patch 7: ".
constexpr const char* fault_text(Fault fault) {
  switch (fault) {
    case Fault::kNone: return "no fault";
    case Fault::kWorkspace: return "the stream needs more memory than its size justifies";
    case Fault::kTruncated: return "the stream ends early";
    case Fault::kNotDraco: return "not a Draco mesh";
    case Fault::kVersion: return "not Draco bitstream 2.2";
    case Fault::kMethod: return "a coding method that does not exist";
    case Fault::kCounts: return "counts that contradict each other";
    case Fault::kConnectivity: return "connectivity symbols that make no mesh";
    case Fault::kSplitEvent: return "a topology split event that fits no symbol";
    case Fault::kSeams: return "attribute seams that tear a vertex";
    case Fault::kEntropy: return "a broken probability table or rANS state";
    case Fault::kAttribute: return "an attribute whose description contradicts itself";
    case Fault::kPrediction: return "prediction data that contradicts the mesh";
    case Fault::kIndex: return "a face with a point that is not there";
    case Fault::kRow: return "other counts than the directory's";
    case Fault::kRequest: return "an attribute that is asked for is missing or has another type";
    case Fault::kStitchMap:
      return "stitch map: it ends early, or has other references than the directory counts";
    case Fault::kStitchRun: return "stitch map: a run leaves the border of its patch";
    case Fault::kStitchPair: return "stitch map: a point that is not there, or that has two references";
    case Fault::kStitchOwner: return "stitch map: a reference to a point that its owner does not own";
  }
  return "unknown fault";
}

}  // namespace psplit::core
