#include "gltf_ext/convert/decode_document.h"

#include <algorithm>

#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/convert/stated_bytes.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "src/container/claims.h"

namespace psplit {
namespace {

constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr uint32_t kMostFaces = UINT32_MAX / 3;

// The attributes that the Draco extensions of a primitive store.
std::vector<std::string> stored_semantics(const Document& document, PrimitiveId id) {
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  std::vector<std::string> semantics;
  for (const char* name : {kExtensionName, kStockExtensionName})
    if (const Json* extension = extension_field(primitive, name))
      for (const auto& [semantic, unique_id] : (*extension)["attributes"].items())
        semantics.push_back(semantic);
  return semantics;
}

bool is_in_patches(const Document& document, PrimitiveId id) {
  return extension_field(document.json["meshes"][id.mesh]["primitives"][id.primitive], kExtensionName) !=
         nullptr;
}

void remove_extensions(Document& document, const PrimitiveGroup& group) {
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document, id);
    Json& extensions = primitive["extensions"];
    for (const char* name : {kExtensionName, kStockExtensionName}) extensions.erase(name);
    if (extensions.empty()) primitive.erase("extensions");
  }
}

// The meshes of all groups are in memory.
Status decode_in_memory(Document& document, std::span<const PrimitiveGroup> groups,
                        const DecodeBackend& backend, const ThreadPool& pool, const Progress& progress) {
  std::vector<PrimitiveId> ids;
  for (const PrimitiveGroup& group : groups) ids.push_back(group.ids.front());
  const std::vector<Expected<Mesh>> meshes = read_primitives(document, ids, backend, pool, progress);
  std::vector<PrimitiveId> patched;
  std::vector<MeshView> patched_meshes;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (!meshes[i]) return meshes[i].status();
    if (!is_in_patches(document, ids[i])) {
      const auto morphs = read_morph_targets(document, ids[i], meshes[i]->point_count);
      if (morphs.status().code() == StatusCode::kInvalidInput) return morphs.status();
      continue;
    }
    patched.push_back(ids[i]);
    patched_meshes.push_back(view_of(*meshes[i]));
  }
  if (Status status = check_decoded(document, patched, patched_meshes); !status.ok()) return status;
  PrimitiveEditor editor(document);
  for (size_t i = 0; i < groups.size(); ++i) {
    editor.set_geometry(groups[i], *meshes[i], {}, GeometryData::kInBufferViews,
                        stored_semantics(document, ids[i]));
    remove_extensions(document, groups[i]);
  }
  editor.finish();
  return {};
}

// The meshes of all groups go into one temporary file, laid out as append_buffer_view would lay them out behind
// the last buffer. Meshes that are not decoded window by window, such as those of stock Draco, are decoded one
// after the other; their layout needs counts that only decoding tells, so they wait in another file.
class FileDecoder {
 public:
  FileDecoder(Document& document, std::span<const PrimitiveGroup> groups, const DecodeBackend& backend,
              const ThreadPool& pool, const MemoryLimit& limit)
      : document_(document), groups_(groups), backend_(backend), pool_(pool), limit_(limit) {}

  Status run(const Progress& progress) {
    for (const PrimitiveGroup& group : groups_)
      if (Status status = open(group.ids.front()); !status.ok()) return status;
    const std::vector<uint8_t> tail = tail_of_last_buffer();
    const uint64_t bytes = lay_out_all(tail.size(), {});
    const Expected<FileMemory> memory = FileMemory::create(limit_.folder, bytes);
    if (!memory) return memory.status();
    memory_ = memory->bytes();
    lay_out_all(tail.size(), memory_);
    std::ranges::copy(tail, memory->bytes().begin());
    if (Status status = decode_all(progress); !status.ok()) return status;
    if (Status status = check(); !status.ok()) return status;
    edit(*memory);
    return {};
  }

 private:
  struct Item {
    PrimitiveId id;
    std::vector<AttributeRequest> requests;
    uint32_t point_count = 0, face_count = 0;
    std::optional<PatchContainer> container;  // decoded window by window
    uint64_t decoded_at = 0;                  // of the laid-out mesh in decoded_meshes_, without a container
    LaidOutMesh laid_out;
  };

  Place place_of(PrimitiveId id) const {
    return {document_.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1};
  }

  Status open(PrimitiveId id) {
    Item item;
    item.id = id;
    if (is_in_patches(document_, id)) {
      Expected<StoredPrimitive> stored = stored_primitive(document_, id, kExtensionName);
      if (!stored) return stored.status().at(place_of(id));
      Expected<PatchContainer> container = open_container(stored->bytes);
      if (!container) return container.status().at(place_of(id));
      release_mapped(stored->bytes);
      item.requests = std::move(stored->requests);
      item.point_count = container->point_count();
      item.face_count = container->face_count();
      Status claims = check_results(item.point_count, item.face_count, item.requests, container->bytes.size());
      if (!claims.ok()) return std::move(claims).at(place_of(id));
      if (std::ranges::all_of(item.requests, is_written_as_stored)) item.container = std::move(*container);
    }
    if (!item.container)
      if (Status status = decode_whole(item); !status.ok()) return status;
    if (item.face_count > kMostFaces)
      return unsupported("has more indices than an accessor can count", place_of(id));
    items_.push_back(std::move(item));
    return {};
  }

  Status decode_whole(Item& item) {
    Expected<Mesh> mesh = read_primitive(document_, item.id, backend_, pool_);
    if (!mesh) return mesh.status();
    const auto morphs = read_morph_targets(document_, item.id, mesh->point_count);
    if (morphs.status().code() == StatusCode::kInvalidInput) return morphs.status();
    const std::vector<std::string> stored = stored_semantics(document_, item.id);
    std::erase_if(mesh->attributes,
                  [&](const Attribute& a) { return std::ranges::find(stored, a.semantic) == stored.end(); });
    item.requests.clear();
    for (const Attribute& a : mesh->attributes)
      item.requests.push_back({a.semantic, 0, a.component_type, a.component_count, a.normalized});
    item.point_count = mesh->point_count;
    item.face_count = static_cast<uint32_t>(mesh->faces.size());
    if (item.face_count > kMostFaces) return {};
    if (decoded_bytes_ == 0) {
      Expected<UnnamedFile> file = UnnamedFile::create(limit_.folder);
      if (!file) return file.status();
      decoded_meshes_ = std::move(*file);
    }
    std::vector<uint8_t> bytes(lay_out(item.requests, item.point_count, item.face_count, 0, {}).end);
    copy_mesh(*mesh, lay_out(item.requests, item.point_count, item.face_count, 0, bytes));
    item.decoded_at = decoded_bytes_;
    decoded_bytes_ += bytes.size();
    return decoded_meshes_.write(item.decoded_at, bytes);
  }

  // Bytes move in blocks of 8 when unused ones between them are dropped (ByteRuns). The new bytes begin in the
  // last block of the buffer before them, if it has room for them.
  std::vector<uint8_t> tail_of_last_buffer() const {
    const size_t count = document_.buffers.size();
    if (count == 0 || has_no_bytes(document_, count - 1)) return {};
    const std::span<const uint8_t> bytes = document_.buffers.back();
    const size_t tail = bytes.size() % 8;
    if (tail > 4) return {};
    return {bytes.end() - static_cast<std::ptrdiff_t>(tail), bytes.end()};
  }

  uint64_t lay_out_all(uint64_t begin, std::span<uint8_t> memory) {
    for (Item& item : items_) {
      item.laid_out = lay_out(item.requests, item.point_count, item.face_count, begin, memory);
      begin = item.laid_out.end;
    }
    return begin;
  }

  Status decode_all(const Progress& progress) {
    size_t total = 0, done_before = 0;
    for (const Item& item : items_) total += item.container ? item.container->entries.size() : 1;
    for (Item& item : items_) {
      const auto count = [&](size_t done, size_t) {
        if (progress) progress(done_before + done, total);
      };
      if (item.container) {
        Status status = decode_to_file(*item.container, item.requests, item.laid_out, limit_, pool_, count);
        if (!status.ok()) return std::move(status).at(place_of(item.id));
        done_before += item.container->entries.size();
      } else {
        // The offsets between the parts of a mesh are the same wherever it begins on a 4-byte boundary.
        const uint64_t begin = item.laid_out.offsets.front();
        const auto to =
            memory_.subspan(static_cast<size_t>(begin), static_cast<size_t>(item.laid_out.end - begin));
        if (Status status = decoded_meshes_.read(item.decoded_at, to); !status.ok()) return status;
        release_mapped(to);
        count(1, 1);
        ++done_before;
      }
    }
    return {};
  }

  static void copy_mesh(const Mesh& mesh, const LaidOutMesh& laid_out) {
    const auto to = [](std::span<std::byte> bytes) { return reinterpret_cast<uint8_t*>(bytes.data()); };
    const MeshView view = view_of(mesh);
    for (size_t i = 0; i < view.attributes.size(); ++i)
      write_values(view.attributes[i].values, kArrayBuffer, to(laid_out.buffers.attributes[i].bytes));
    write_values(index_data(mesh), kElementArrayBuffer, to(laid_out.buffers.indices));
  }

  Status check() const {
    std::vector<PrimitiveId> patched;
    std::vector<MeshView> views;
    for (const Item& item : items_) {
      if (!is_in_patches(document_, item.id)) continue;
      patched.push_back(item.id);
      views.push_back(item.laid_out.view);
    }
    return check_decoded(document_, patched, views);
  }

  void edit(const FileMemory& memory) {
    PrimitiveEditor editor(document_);
    const size_t buffer = document_.buffers.size();
    document_.json["buffers"].push_back({{"byteLength", memory.bytes().size()}});
    document_.buffers.push_back(memory.view());
    for (size_t i = 0; i < groups_.size(); ++i) {
      editor.set_placed_geometry(groups_[i], {items_[i].laid_out.view, buffer, items_[i].laid_out.offsets});
      remove_extensions(document_, groups_[i]);
    }
    items_.clear();  // they point into buffers that go
    editor.finish();
  }

  Document& document_;
  const std::span<const PrimitiveGroup> groups_;
  const DecodeBackend& backend_;
  const ThreadPool& pool_;
  const MemoryLimit& limit_;
  std::vector<Item> items_;
  std::span<uint8_t> memory_;  // of all laid-out meshes
  UnnamedFile decoded_meshes_;
  uint64_t decoded_bytes_ = 0;  // in that file
};

// Whether decode_in_memory would take more than the limit: the meshes, their values as buffer views, and the
// buffer, which grows by doubling.
bool is_too_large(const Document& document, const MemoryLimit& limit) {
  if (limit.bytes == 0) return false;
  const StatedBytes bytes = stated_bytes(document);
  return !limit.allows(bytes.stored + 4 * bytes.decoded);
}

}  // namespace

Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                       const Progress& progress, const MemoryLimit& limit) {
  std::vector<PrimitiveId> wanted;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status().at({.file = document.source.string()});
    if (kind->storage != PrimitiveStorage::kPlain) {
      wanted.push_back(id);
    } else if (Status status = check_readable(document, id, backend, pool);
               status.code() == StatusCode::kInvalidInput) {
      return status;
    }
  }
  const std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  if (is_too_large(document, limit)) return FileDecoder(document, groups, backend, pool, limit).run(progress);
  return decode_in_memory(document, groups, backend, pool, progress);
}

}  // namespace psplit
