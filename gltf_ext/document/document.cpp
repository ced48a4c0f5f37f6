#include "gltf_ext/document/document.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/read_steps.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {

struct AssetTree::State {
  Json json;
  std::mutex mutex{};  // of the members below
  std::atomic<bool> is_read = false;
  AssetRecords records{};
  Status status{};
};

AssetTree::AssetTree() : state_(new State) {}
AssetTree::AssetTree(const AssetTree& other) : state_(new State{other.json()}) {}
AssetTree::AssetTree(AssetTree&& other) noexcept = default;
AssetTree& AssetTree::operator=(AssetTree other) noexcept {
  state_ = std::move(other.state_);
  return *this;
}
AssetTree::~AssetTree() = default;

const Json& AssetTree::json() const { return state_->json; }

Json& AssetTree::json() {
  state_->is_read = false;
  return state_->json;
}

const AssetRecords& AssetTree::records() const {
  State& state = *state_;
  if (state.is_read) return state.records;
  const std::lock_guard lock(state.mutex);
  if (state.is_read) return state.records;
  Expected<AssetRecords> read = read_records(state.json);
  state.status = read.status();
  state.records = read ? std::move(*read) : AssetRecords();
  state.is_read = true;
  return state.records;
}

Status AssetTree::check() const {
  records();
  return state_->status;
}

std::vector<uint8_t>& Buffer::own() {
  if (is_shared()) {
    owned_.reserve(shared_.size());
    visit_and_release(shared_, [&](Span<const uint8_t> step) {
      owned_.insert(owned_.end(), step.begin(), step.end());
      return true;
    });
    shared_ = {};
    owner_ = {};
  }
  return owned_;
}

void Buffer::cut_to(size_t offset, size_t length) {
  if (is_shared()) {
    shared_ = shared_.subspan(offset, length);
  } else {
    owned_.resize(offset + length);
    owned_.erase(owned_.begin(), owned_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
}

namespace {

Expected<Buffer> buffer_of(Expected<MappedFile> file) {
  if (!file) return file.status();
  return buffer_of(*file);
}
Expected<Buffer> buffer_of(Expected<std::vector<uint8_t>> bytes) {
  if (!bytes) return bytes.status();
  return Buffer(std::move(*bytes));
}

Expected<Buffer> load_file(const std::filesystem::path& path, uint64_t limit, FileAccess access) {
  std::error_code error;
  if (access == FileAccess::kMap && path != "-" && is_disk_file(path) &&
      std::filesystem::file_size(path, error) >= kMappedBytes && !error)
    return buffer_of(MappedFile::open(path, limit));
  return buffer_of(read_file(path, limit));
}

// Where each buffer's bytes are, if it says so.
using Uris = std::vector<std::optional<std::string>>;

// Takes the URIs of the placeholders for meshoptimizer's decoded data out of the JSON, or all others: their
// bytes will be in memory. Without a URI, the records stay.
Uris take_uris(Document& document, bool fallbacks) {
  const Json& json = std::as_const(document).json();
  Uris uris(array_size(json, "buffers"));
  for (size_t i = 0; i < uris.size(); ++i) {
    const Json& buffer = json["buffers"][i];
    const std::string* uri = string_field(buffer, "uri");
    if (uri == nullptr || is_meshopt_fallback(buffer) != fallbacks) continue;
    uris[i] = *uri;
    document.json()["buffers"][i].erase("uri");
  }
  return uris;
}

Expected<Buffer> load_uri(Document& document, const std::string& uri, uint64_t bytes, FileAccess access) {
  if (is_data_uri(uri)) {
    document.text_bytes -= std::min<uint64_t>(document.text_bytes, uri.size());
    return buffer_of(decode_data_uri(uri));
  }
  const auto relative = relative_path_of_uri(uri, document.source.parent_path());
  if (!relative) return relative.status();
  const std::filesystem::path path = document.source.parent_path() / *relative;
  // Regular files only: a pipe or a device named by an asset could block or never end.
  if (!is_disk_file(path)) return io_failure("no file " + path.string());
  document.files.push_back(path);
  return load_file(path, bytes, access);
}

Status set_buffer(Document& document, size_t index, uint64_t byte_length, Expected<Buffer> bytes) {
  const std::string name = "buffer " + std::to_string(index);
  if (!bytes) return {bytes.status().code(), name + ": " + bytes.status().to_string()};
  if (bytes->size() < byte_length)
    return invalid_input(name + " holds " + std::to_string(bytes->size()) + " bytes of " +
                         std::to_string(byte_length));
  bytes->cut_to(0, static_cast<size_t>(byte_length));
  document.buffers[index] = std::move(*bytes);
  return {};
}

// Loads the buffers that have bytes somewhere: all except placeholders for meshoptimizer's decoded data, or
// only these. Views that meshoptimizer could not decode may need them. `uris` comes from take_uris.
Status load_buffers(Document& document, const Uris& uris, bool fallbacks, std::optional<Buffer> binary_chunk,
                    FileAccess access) {
  const std::vector<BufferRecord>& records = document.records().buffers;
  document.buffers.resize(records.size());
  for (size_t i = 0; i < records.size(); ++i) {
    const auto& [bytes, is_fallback] = records[i];
    if (is_fallback != fallbacks) continue;
    Status status;
    if (uris[i]) {
      status = set_buffer(document, i, bytes, load_uri(document, *uris[i], bytes, access));
    } else if (i == 0 && document.from_glb && !fallbacks) {
      if (!binary_chunk) return invalid_input("buffer 0 has neither a uri nor a GLB chunk");
      status = set_buffer(document, i, bytes, std::move(*binary_chunk));
    }
    if (!status.ok()) return status;
  }
  return {};
}

Expected<Document> parse(Buffer file, const std::filesystem::path& source, FileAccess access) {
  Document document;
  document.source = source;
  document.from_glb = is_glb(file);
  // The parser of JSON would report a character of binary data, which helps nobody.
  if (!begins_as_gltf(file)) return invalid_input("not glTF: neither a GLB nor JSON");
  if (!source.empty() && source != "-") document.files.push_back(source);
  GlbChunks chunks{file, std::nullopt};
  if (document.from_glb) {
    auto parsed = parse_glb(file);
    if (!parsed) return parsed.status();
    chunks = *parsed;
  }
  auto json = parse_json({reinterpret_cast<const char*>(chunks.json.data()), chunks.json.size()});
  if (!json) return json.status();
  document.json() = std::move(*json);
  if (!document.from_glb) {
    document.text_bytes = chunks.json.size();
    file = {};
  }
  if (Status status = check_members(document.json()); !status.ok()) return status;
  if (Status status = exchange_primitives(document.json()); !status.ok()) return status;
  const Uris uris = take_uris(document, false);
  if (Status status = document.check(); !status.ok()) return status;
  if (Status status = check_scene(document); !status.ok()) return status;
  std::optional<Buffer> binary;
  if (chunks.binary) {
    const auto offset = static_cast<size_t>(chunks.binary->data() - file.bytes().data());
    file.cut_to(offset, chunks.binary->size());
    binary = std::move(file);
  }
  if (Status status = load_buffers(document, uris, false, std::move(binary), access); !status.ok())
    return status;
  if (Status status = decode_meshopt_views(document); !status.ok()) return status;
  const Uris fallbacks = take_uris(document, true);
  if (Status status = load_buffers(document, fallbacks, true, std::nullopt, access); !status.ok())
    return status;
  // With bytes of their own these are buffers like others.
  for (size_t i = 0; i < fallbacks.size(); ++i)
    if (fallbacks[i]) erase_meshopt_extension(document.json()["buffers"][i]);
  if (Status status = check_unbacked_bytes(document); !status.ok()) return status;
  return document;
}

Place place_of(const std::filesystem::path& source) {
  return {.file = source == "-" ? "stdin" : source.string()};
}

// The index of a buffer that may grow.
size_t growing_buffer(Document& document) {
  Json& buffers = document.json()["buffers"];
  if (!buffers.is_array()) buffers = Json::array();
  // The last buffer, so that appended bytes are together, unless it is a placeholder without bytes, or so large
  // that it takes long to move. One with a name or extras grows: without views it would be dropped with them.
  const auto takes_long = [&] {
    return document.buffers.back().size() >= kLargeBuffer && buffers.back().size() == 1;
  };
  if (!buffers.empty() && buffers.size() == document.buffers.size() &&
      !is_placeholder(document, buffers.size() - 1) && !takes_long())
    return buffers.size() - 1;
  buffers.push_back({{"byteLength", 0}});
  document.buffers.resize(buffers.size());
  return buffers.size() - 1;
}

Expected<Document> parse_at(Buffer file, const std::filesystem::path& source, FileAccess access) {
  auto document = parse(std::move(file), source, access);
  if (!document) return document.status().at(place_of(source));
  return document;
}

}  // namespace

Expected<Document> read_document(const std::filesystem::path& path, FileAccess access) {
  auto file = load_file(path, UINT64_MAX, access);
  if (!file) return file.status().at(place_of(path));
  return parse_at(std::move(*file), path, access);
}

Expected<Document> parse_document(std::vector<uint8_t>&& file, const std::filesystem::path& source) {
  return parse_at(std::move(file), source, FileAccess::kRead);
}

Expected<Document> parse_document(Span<const uint8_t> file, const std::filesystem::path& source) {
  return parse_document(std::vector<uint8_t>(file.begin(), file.end()), source);
}

Expected<Document> parse_document(MappedFile file, const std::filesystem::path& source) {
  return parse_at(buffer_of(file), source, FileAccess::kMap);
}

std::vector<PrimitiveId> all_primitives(const Document& document) {
  std::vector<PrimitiveId> ids;
  const auto& meshes = document.records().meshes;
  for (size_t mesh = 0; mesh < meshes.size(); ++mesh)
    for (size_t primitive = 0; primitive < meshes[mesh].size(); ++primitive) ids.push_back({mesh, primitive});
  return ids;
}

Document new_document() {
  Document document;
  document.json() = Json::parse(R"({
    "asset": {"version": "2.0", "generator": "psplit"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {}}]}]
  })");
  return document;
}

bool is_placeholder(const Document& document, size_t buffer) {
  const Json* object = top_level_object(document.json(), "buffers", static_cast<int64_t>(buffer));
  return object != nullptr && (is_meshopt_fallback(*object) || has_no_bytes(document, buffer));
}

bool has_no_bytes(const Document& document, size_t buffer) {
  const Json* object = top_level_object(document.json(), "buffers", static_cast<int64_t>(buffer));
  return object != nullptr && document.buffers[buffer].empty() &&
         integer_field(*object, "byteLength").value_or(0) > 0;
}

Expected<Span<const uint8_t>> buffer_view_bytes(const Document& document, int64_t index) {
  const std::string name = "buffer view " + std::to_string(index);
  const ViewRecord& view = document.records().view(index);
  const auto& [buffer, offset, count] = view.range;
  const Span<const uint8_t> bytes = document.buffers[static_cast<size_t>(buffer)];
  if (offset <= bytes.size() && count <= bytes.size() - offset)
    return bytes.subspan(static_cast<size_t>(offset), static_cast<size_t>(count));
  // The view has no bytes: it is compressed in an unknown way, or a placeholder of an unknown extension.
  if (view.meshopt) return unsupported(name + " " + why_meshopt_is_unreadable());
  if (bytes.empty()) return unsupported(name + " is in a buffer without a uri");
  return invalid_input(name + " reaches past its buffer");
}

size_t append_buffer(Document& document, Buffer bytes) {
  document.json()["buffers"].push_back({{"byteLength", bytes.size()}});
  document.buffers.push_back(std::move(bytes));
  return document.buffers.size() - 1;
}

int64_t append_buffer_view(Document& document, Span<const uint8_t> bytes) {
  const size_t buffer = growing_buffer(document);
  std::vector<uint8_t>& target = document.buffers[buffer].own();
  const size_t offset = (target.size() + 3) / 4 * 4;
  target.resize(offset);
  target.insert(target.end(), bytes.begin(), bytes.end());
  document.json()["buffers"][buffer]["byteLength"] = target.size();
  Json& views = document.json()["bufferViews"];
  if (!views.is_array()) views = Json::array();
  views.push_back({{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
  return static_cast<int64_t>(views.size() - 1);
}

}  // namespace psplit
