// Editing primitives in place: accessors that only the edited primitives use are changed where they are, shared
// ones are left to their other users.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

// Primitives that say the same: one geometry, stored once.
struct PrimitiveGroup {
  std::vector<PrimitiveId> ids;
};
std::vector<PrimitiveGroup> group_equal_primitives(const Document& document,
                                                   const std::vector<PrimitiveId>& ids);

Json& primitive_json(Document& document, PrimitiveId id);

// How decoded geometry is described in JSON.
enum class GeometryData { kStoredElsewhere, kInBufferViews, kSparse };

class PrimitiveEditor {
 public:
  // Counts who uses each accessor before anything is changed.
  explicit PrimitiveEditor(Document& document);

  // Makes the primitives' accessors describe (and, in buffer views, hold) `mesh`. `morphs` follow its points,
  // and those that were sparse stay so where that is smaller; targets that shared an accessor still do. With
  // `only` not empty, attributes it does not name are left alone.
  void set_geometry(const PrimitiveGroup& group, const Mesh& mesh, const std::vector<MorphAttribute>& morphs,
                    GeometryData data, const std::vector<std::string>& only = {});

  // An accessor that something had which is gone; it goes too where nothing else uses it.
  void release(int64_t accessor) { freed_.push_back(accessor); }

  // Drops accessors and views that the edits left without users, and extensions that nothing uses any more.
  void finish();

 private:
  int64_t accessor_to_edit(const PrimitiveGroup& group, const std::string& role, const Json* current,
                           size_t uses = 1);
  void set_morphs(const PrimitiveGroup& group, const std::vector<MorphAttribute>& morphs);
  void fill(int64_t accessor, const AccessorData& data, int target, GeometryData how, bool with_bounds);

  Document& document_;
  std::map<int64_t, size_t> users_;
  std::map<int64_t, std::string> taken_;  // accessors edited for a role
  std::vector<int64_t> freed_;
};

}  // namespace psplit
