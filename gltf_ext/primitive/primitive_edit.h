// Editing primitives in place. An accessor that only the edited primitives use is changed; an accessor with
// other users is copied first.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/meshopt_views.h"
#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

// Primitives with the same geometry, which is stored once.
struct PrimitiveGroup {
  std::vector<PrimitiveId> ids;
};
std::vector<PrimitiveGroup> group_equal_primitives(const Document& document,
                                                   const std::vector<PrimitiveId>& ids);

Json& primitive_json(Document& document, PrimitiveId id);
const Json& primitive_json(const Document& document, PrimitiveId id);

// Whether a loader without the Draco extensions of each of the primitives finds something else: its data in
// buffer views, or coarse primitives of the mesh.
bool all_have_fallbacks(const Document& document, std::span<const PrimitiveId> ids);

// A primitive's extension, which names the attributes and the morph targets that a container or a stream
// stores. target_count: the primitive's morph targets.
Json draco_extension(int64_t buffer_view, std::span<const AttributeRequest> requests, size_t target_count);

// Makes the container or stream in a buffer view the extension `name` of the group's primitives. Replaces any
// Draco extension that they had.
void set_draco_extension(Document& document, const PrimitiveGroup& group, const char* name, int64_t buffer_view,
                         std::span<const AttributeRequest> requests);

// Gives the primitives' extension `from`, one of the two, the name `to`, and lists it: as required unless all
// of them have a fallback.
void rename_draco_extension(Document& document, std::span<const PrimitiveId> ids, const char* from,
                            const char* to);

// Replaces each primitive of groups[i] by counts[i] copies. Returns for each group the group of the first
// copies, of the second copies, and so on. `groups` refers to the primitives of the unchanged document.
std::vector<std::vector<PrimitiveGroup>> repeat_primitives(Document& document,
                                                           std::span<const PrimitiveGroup> groups,
                                                           std::span<const size_t> counts);

// Where the values of a geometry are stored.
enum class GeometryData { kStoredElsewhere, kInBufferViews, kSparse };

class PrimitiveEditor {
 public:
  // Counts the users of each accessor before anything is changed.
  explicit PrimitiveEditor(Document& document);

  // Makes the accessors of the primitives describe `mesh`, and with kInBufferViews hold it. `morphs` are in the
  // order of its points. A sparse morph target stays sparse if that is smaller, and targets that shared an
  // accessor still do. If `only` is not empty, attributes that it does not name stay as they are.
  void set_geometry(const PrimitiveGroup& group, const Mesh& mesh, const std::vector<MorphAttribute>& morphs,
                    GeometryData data, const std::vector<std::string>& only = {});
  // Sets the geometry for kInBufferViews and a mesh that is in a buffer of the document already, at the offsets
  // that lay_out (mesh_view.h) returned. Morph targets stay.
  struct PlacedMesh {
    const MeshView& view;
    size_t buffer;
    std::span<const uint64_t> offsets;
  };
  void set_placed_geometry(const PrimitiveGroup& group, const PlacedMesh& mesh);
  // Sets the geometry to a mesh in a temporary file, which becomes a buffer of the document.
  void set_geometry_in_file(const PrimitiveGroup& group, const MeshInFile& mesh);
  // Sets the geometry for kStoredElsewhere and a mesh that is not in memory, with the bounds of its attributes,
  // then of its indices. The bytes of its values are not used. Morph targets stay.
  struct Bounds {
    Json least, most;
  };
  void describe_geometry(const PrimitiveGroup& group, const MeshView& mesh, std::span<const Bounds> bounds);

  // Marks an accessor whose user was removed: finish() drops it if nothing else uses it.
  void release(int64_t accessor) { freed_.push_back(accessor); }

  // Compresses views of meshoptimizer again whose values moved. Drops the accessors and views that the edits
  // left without users, and removes unused extensions of Draco and meshoptimizer from the lists of extensions.
  void finish();

 private:
  int64_t accessor_to_edit(const PrimitiveGroup& group, const std::string& role, const Json* current,
                           size_t uses = 1);
  void set_morphs(const PrimitiveGroup& group, const std::vector<MorphAttribute>& morphs);
  // Where values are that are stored already.
  struct Placed {
    size_t buffer;
    uint64_t offset;
  };
  void set_attribute(const PrimitiveGroup& group, const MeshView::Values& attribute, GeometryData data,
                     const Placed* placed, const Bounds* bounds = nullptr);
  void set_indices(const PrimitiveGroup& group, const ValuesView& indices, GeometryData data,
                   const Placed* placed, const Bounds* bounds = nullptr);
  void fill(int64_t accessor, const ValuesView& data, int target, GeometryData how, bool with_bounds,
            const Placed* placed = nullptr, const Bounds* bounds = nullptr);

  Document& document_;
  std::map<int64_t, size_t> users_;
  std::map<int64_t, std::string> taken_;  // the edited accessors, and the role of each
  std::vector<int64_t> freed_;
  MeshoptViews meshopt_;
};

}  // namespace psplit
