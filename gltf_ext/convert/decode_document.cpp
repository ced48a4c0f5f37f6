#include <algorithm>
#include <utility>

#include "gltf_ext/convert/coarse_primitives.h"
#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/convert/stated_bytes.h"
#include "gltf_ext/convert/stock_rules.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/gltf.h"
#include "src/container/claims.h"
#include "src/cpu/checked_decode.h"
#include "system/operating_system.h"

namespace psplit {
namespace {

constexpr uint32_t kMostFaces = UINT32_MAX / 3;

bool is_in_patches(const Document& document, PrimitiveId id) {
  return document.records().primitive(id).patches.has_value();
}

void remove_extensions(Document& document, const PrimitiveGroup& group) {
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document, id);
    Json& extensions = primitive["extensions"];
    for (const char* name : {kExtensionName, kStockExtensionName}) extensions.erase(name);
    if (extensions.empty()) primitive.erase("extensions");
  }
}

// Decodes the meshes of all groups into one new buffer, laid out as append_buffer_view would after the last
// buffer. The counts of a container are known before it is decoded, so its mesh is decoded in place. Other
// meshes, such as stock Draco, are decoded first, and copied. If the meshes do not fit into memory, the buffer
// is a temporary file: containers are decoded window by window, and other meshes one after the other. The
// latter wait in another file.
class DocumentDecoder {
 public:
  DocumentDecoder(Document& document, std::span<const PrimitiveGroup> groups, const DecodeBackend& backend,
                  const ThreadPool& pool, const Progress& progress, const MemoryLimit& limit,
                  std::vector<Finding>* corrections)
      : document_(document),
        groups_(groups),
        backend_(backend),
        pool_(pool),
        progress_(progress),
        limit_(limit),
        corrections_(corrections),
        is_too_large_(limit.bytes > 0 && !stated_bytes(document).fit_into(limit)) {}

  Status run() {
    if (groups_.empty()) {
      if (Status status = check(); !status.ok()) return status;
      drop_coarse_primitives(document_);
      return {};
    }
    items_.resize(groups_.size());
    std::vector<Item*> whole;
    for (size_t i = 0; i < groups_.size(); ++i) {
      items_[i].id = groups_[i].ids.front();
      if (Status status = open(items_[i]); !status.ok()) return status;
      if (!items_[i].container) whole.push_back(&items_[i]);
    }
    const size_t at_once = is_too_large_ ? 1 : whole.size();
    for (size_t i = 0; i < whole.size(); i += at_once)
      if (Status status = decode_whole(std::span(whole).subspan(i, at_once)); !status.ok()) return status;
    for (const Item& item : items_)
      if (item.face_count > kMostFaces)
        return unsupported("has more indices than an accessor can count", place_of(document_, item.id));
    if (Status status = allocate(); !status.ok()) return status;
    for (Item* const item : whole)
      if (Status status = place_whole(*item); !status.ok()) return status;
    Status status = is_too_large_ ? decode_windows() : decode_in_place();
    if (status.ok()) status = check();
    if (status.ok()) edit();
    return status;
  }

 private:
  struct Item {
    PrimitiveId id;
    std::vector<AttributeRequest> requests;
    uint32_t point_count = 0, face_count = 0;
    std::optional<PatchContainer> container;  // decoded in place
    std::vector<StreamFindings> streams;      // errors of its streams; empty if they are not checked
    Mesh mesh;                                // without a container: waits here,
    uint64_t waits_at = 0;                    // or, laid out, in waiting_
    LaidOutMesh laid_out;
  };

  // The progress of `count` items.
  Progress progress_of(size_t count) {
    if (!progress_) return {};
    const size_t before = std::exchange(items_done_, items_done_ + count);
    return [this, before, count](size_t done, size_t total) {
      progress_(before * total + count * done, items_.size() * total);
    };
  }

  // Opens the item's container, if it is in one that can be decoded in place.
  Status open(Item& item) const {
    if (!is_in_patches(document_, item.id)) return {};
    Expected<StoredPrimitive> stored = stored_primitive(document_, item.id);
    if (!stored) return stored.status().at(place_of(document_, item.id));
    Expected<PatchContainer> container = open_container(stored->bytes);
    if (!container) return container.status().at(place_of(document_, item.id));
    if (is_too_large_) release_mapped(stored->bytes);
    item.requests = std::move(stored->requests);
    item.point_count = container->point_count();
    item.face_count = container->face_count();
    Status claims = check_results(item.point_count, item.face_count, item.requests, container->bytes.size());
    if (!claims.ok()) return std::move(claims).at(place_of(document_, item.id));
    if (std::ranges::all_of(item.requests, is_written_as_stored)) {
      if (checks_streams()) item.streams.resize(container->entries.size());
      item.container = std::move(*container);
    } else if (checks_streams()) {
      Expected<CheckedMesh> checked = decode_checked(*container, item.requests, pool_);
      if (!checked) return checked.status().at(place_of(document_, item.id));
      item.streams = std::move(checked->streams);
    }
    return {};
  }

  // The CPU's decoder keeps copies of points, so it takes containers unless the caller asks for another one.
  bool checks_streams() const { return is_too_large_ || (backend_.name != "cuda" && backend_.name != "draco"); }

  Status decode_whole(std::span<Item* const> items) {
    std::vector<PrimitiveId> ids;
    for (const Item* const item : items) ids.push_back(item->id);
    auto meshes = read_primitives(document_, ids, backend_, pool_, progress_of(items.size()));
    for (size_t i = 0; i < items.size(); ++i) {
      if (!meshes[i]) return meshes[i].status();
      if (Status status = keep(*items[i], std::move(*meshes[i])); !status.ok()) return status;
    }
    return {};
  }

  // Keeps the attributes of a mesh that the item's extension stores.
  Status keep(Item& item, Mesh mesh) {
    if (!is_in_patches(document_, item.id)) {
      const auto morphs = read_morph_targets(document_, item.id, mesh.point_count);
      if (morphs.status().code() == StatusCode::kInvalidInput) return morphs.status();
      if (corrections_ != nullptr)
        std::ranges::move(check_stock_counts(document_, item.id, view_of(mesh)),
                          std::back_inserter(*corrections_));
    }
    const PrimitiveRecord& primitive = document_.records().primitive(item.id);
    std::erase_if(mesh.attributes, [&](const Attribute& a) {
      return !(primitive.patches && primitive.patches->stores(a.semantic)) &&
             !(primitive.stock && primitive.stock->stores(a.semantic));
    });
    item.requests.clear();
    for (const Attribute& a : mesh.attributes)
      item.requests.push_back({a.semantic, 0, a.component_type, a.component_count, a.normalized});
    item.point_count = mesh.point_count;
    item.face_count = static_cast<uint32_t>(mesh.faces.size());
    if (!is_too_large_) {
      item.mesh = std::move(mesh);
      return {};
    }
    if (waiting_bytes_ == 0) {
      Expected<UnnamedFile> file = UnnamedFile::create(limit_.folder);
      if (!file) return file.status();
      waiting_ = std::move(*file);
    }
    std::vector<uint8_t> bytes(lay_out(item.requests, item.point_count, item.face_count, 0, {}).end);
    copy_mesh(mesh, lay_out(item.requests, item.point_count, item.face_count, 0, bytes));
    item.waits_at = std::exchange(waiting_bytes_, waiting_bytes_ + bytes.size());
    return waiting_.write(item.waits_at, bytes);
  }

  Status allocate() {
    const std::vector<uint8_t> tail = tail_of_last_buffer();
    const uint64_t bytes = lay_out_all(tail.size(), {});
    std::span<uint8_t> memory;
    if (is_too_large_) {
      Expected<FileMemory> file = FileMemory::create(limit_.folder, bytes);
      if (!file) return file.status();
      file_ = std::move(*file);
      memory = file_->bytes();
    } else {
      owned_.resize(bytes);
      memory = owned_;
    }
    lay_out_all(tail.size(), memory);
    std::ranges::copy(tail, memory.begin());
    return {};
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

  Status place_whole(Item& item) {
    if (!is_too_large_) {
      copy_mesh(item.mesh, item.laid_out);
      item.mesh = {};
      return {};
    }
    // The offsets between the parts of a mesh are the same wherever it begins on a 4-byte boundary.
    const uint64_t begin = item.laid_out.offsets.front();
    const auto to =
        file_->bytes().subspan(static_cast<size_t>(begin), static_cast<size_t>(item.laid_out.end - begin));
    if (Status status = waiting_.read(item.waits_at, to); !status.ok()) return status;
    release_mapped(to);
    return {};
  }

  static void copy_mesh(const Mesh& mesh, const LaidOutMesh& laid_out) {
    const auto to = [](std::span<std::byte> bytes) { return reinterpret_cast<uint8_t*>(bytes.data()); };
    const MeshView view = view_of(mesh);
    for (size_t i = 0; i < view.attributes.size(); ++i)
      write_values(view.attributes[i].values, kArrayBuffer, to(laid_out.buffers.attributes[i].bytes));
    write_values(IndexData(mesh), kElementArrayBuffer, to(laid_out.buffers.indices));
  }

  Status decode_windows() {
    for (Item& item : items_) {
      if (!item.container) continue;
      Status status = decode_into_file(*item.container, item.requests, item.laid_out, limit_, pool_,
                                       progress_of(1), &item.streams);
      if (!status.ok()) return std::move(status).at(place_of(document_, item.id));
    }
    return {};
  }

  Status decode_in_place() {
    std::vector<Item*> items;
    std::vector<DecodeTask> tasks;
    for (Item& item : items_) {
      if (!item.container) continue;
      items.push_back(&item);
      tasks.push_back({&*item.container, item.requests});
    }
    const auto buffers = [&](size_t i, uint32_t, uint32_t) -> Expected<PrimitiveBuffers> {
      return items[i]->laid_out.buffers;
    };
    if (tasks.empty()) return {};
    const Watch watch{progress_of(tasks.size())};
    std::vector<Status> statuses;
    if (checks_streams()) {
      std::vector<CheckedTask> checked;
      for (size_t i = 0; i < tasks.size(); ++i)
        checked.push_back({tasks[i], items[i]->laid_out.buffers, &items[i]->streams});
      statuses = decode_checked_into(checked, pool_, watch);
    } else {
      statuses = backend_.decode_into(tasks, buffers, pool_, watch);
    }
    for (size_t i = 0; i < tasks.size(); ++i)
      if (!statuses[i].ok()) return std::move(statuses[i]).at(place_of(document_, items[i]->id));
    return {};
  }

  Status check() const {
    std::vector<PrimitiveId> patched;
    std::vector<MeshView> views;
    std::vector<std::vector<StreamFindings>> streams;
    for (const Item& item : items_) {
      if (!is_in_patches(document_, item.id)) continue;
      patched.push_back(item.id);
      views.push_back(item.laid_out.view);
      streams.push_back(item.streams);
    }
    return check_decoded(document_, patched, views, streams, backend_, pool_);
  }

  void edit() {
    const std::vector<int64_t> freed = take_coarse_primitives(document_);
    PrimitiveEditor editor(document_);
    for (const int64_t accessor : freed) editor.release(accessor);
    const size_t buffer = document_.buffers.size();
    // The buffer before it may be dropped, so its name and all else that is said of it stay with the new one.
    Json described = Json::object();
    if (buffer > 0 && !has_no_bytes(document_, buffer - 1)) {
      described = document_.json()["buffers"][buffer - 1];
      described.erase("uri");
    }
    document_.buffers.push_back(is_too_large_ ? buffer_of(file_->view()) : Buffer(std::move(owned_)));
    described["byteLength"] = document_.buffers.back().size();
    document_.json()["buffers"].push_back(std::move(described));
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
  const Progress& progress_;
  const MemoryLimit& limit_;
  std::vector<Finding>* const corrections_;
  const bool is_too_large_;
  std::vector<Item> items_;
  size_t items_done_ = 0;
  std::vector<uint8_t> owned_;      // the new buffer,
  std::optional<FileMemory> file_;  // or, if it is too large for memory, its file
  UnnamedFile waiting_;
  uint64_t waiting_bytes_ = 0;
};

}  // namespace

Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                       const Progress& progress, const MemoryLimit& limit, std::vector<Finding>* corrections) {
  if (Status status = document.check(); !status.ok()) return status;
  make_meshopt_views_plain(document);
  std::vector<PrimitiveId> wanted;
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (!primitive.status.ok()) return Status(primitive.status).at({.file = document.source.string()});
    if (primitive.storage() != PrimitiveStorage::kPlain) {
      wanted.push_back(id);
    } else if (Status status = check_readable(document, id, backend, pool);
               status.code() == StatusCode::kInvalidInput) {
      return status;
    }
  }
  const std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  return DocumentDecoder(document, groups, backend, pool, progress, limit, corrections).run();
}

}  // namespace psplit
