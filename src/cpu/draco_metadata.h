// What a Draco stream says beside its geometry: names and values that its writer chose.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "src/export.h"
#include "src/span.h"
#include "src/status.h"

namespace psplit {

// A part of a tree of entries. The type of a value is not stored: who wrote it knows it.
struct Metadata {
  std::string name;                                     // unique among the parts of one; "" for the root
  std::map<std::string, std::vector<uint8_t>> entries;  // the bytes of each value, not empty
  std::vector<Metadata> parts;                          // in the order of the stream

  // Null if there is no such entry or part.
  const std::vector<uint8_t>* find_entry(const std::string& entry) const {
    const auto found = entries.find(entry);
    return found == entries.end() ? nullptr : &found->second;
  }
  const Metadata* find_part(const std::string& part) const {
    for (const Metadata& candidate : parts)
      if (candidate.name == part) return &candidate;
    return nullptr;
  }
  friend bool operator==(const Metadata& a, const Metadata& b) {
    return a.name == b.name && a.entries == b.entries && a.parts == b.parts;
  }
};

struct AttributeMetadata {
  uint32_t unique_id = 0;  // of the attribute. The stream may have none with that id
  Metadata metadata;

  friend bool operator==(const AttributeMetadata& a, const AttributeMetadata& b) {
    return a.unique_id == b.unique_id && a.metadata == b.metadata;
  }
};

struct StreamMetadata {
  Metadata geometry;
  std::vector<AttributeMetadata> attributes;  // in the order of the stream; not all attributes have some

  friend bool operator==(const StreamMetadata& a, const StreamMetadata& b) {
    return a.geometry == b.geometry && a.attributes == b.attributes;
  }
};

// Reads the metadata of a Draco mesh or point cloud, bitstreams 1.3 to 2.3. The geometry is not decoded.
// Returns empty metadata if the stream has none. Any bytes may be given. Takes some hundred bytes for each byte
// of metadata at most. Errors: kUnsupported (another bitstream), kInvalidInput (no Draco stream, or metadata
// that end early, contradict themselves, have an empty value, repeat the name of a part, or nest more than a
// thousand times).
// Thread-safe.
PSPLIT_EXPORT Expected<StreamMetadata> read_metadata(Span<const uint8_t> stream);

}  // namespace psplit
