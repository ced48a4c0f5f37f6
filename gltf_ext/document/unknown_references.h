// Accessors, buffer views and buffers that data may name which psplit does not know: extras, unknown extensions
// and unknown members. What may be named keeps its number and its data.
//
// The name of a member decides. An integer in a member called "accessor", "indices" or "attributes", or in an
// object or an array there, may be the index of an accessor; in "bufferView" or "view" of a view; in "buffer"
// of a buffer. Names are compared word by word ("myBufferViews", "buffer_view"). In unknown extensions a single
// integer in a member called after values ("values", "positions", "offsets", "input" ...) may be any index.
// Other integers are no indices: {"mesh": 0} and {"id": 3} name no data.
#pragma once

#include <map>
#include <set>

#include "gltf_ext/document/document.h"

namespace psplit {

struct UnknownReferences {
  // Indices, of which some may not exist.
  std::set<int64_t> accessors{}, views{}, buffers{};
  // Whether there is an extension whose references are not all known. What it names in ways that no rule
  // foresees keeps its number, but not its data.
  bool has_unknown_extensions = false;
};

UnknownReferences find_unknown_references(const Json& json);

// How many places of the JSON name each accessor and each buffer view, by index. Unknown data that may name one
// counts as one place.
struct DataUsers {
  using Counts = std::map<int64_t, size_t>;
  Counts accessors, views;

  explicit DataUsers(const Json& json);
  static bool has(const Counts& counts, int64_t index, size_t count) {
    const auto found = counts.find(index);
    return found != counts.end() && found->second == count;
  }
};

// The name of an extension of a primitive or a mesh that is unknown and may name accessors; null if it has
// none.
const char* unknown_extension_with_accessors(const Json& object);

}  // namespace psplit
