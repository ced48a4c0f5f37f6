#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/meshopt_filters.h"
#include "gltf_ext/document/read_steps.h"

namespace psplit {
namespace {

// The compressed bytes of one view.
Expected<std::span<const uint8_t>> compressed_bytes(const Document& document, const ViewRecord& view) {
  const auto& [buffer, offset, length] = view.meshopt->range;
  const std::span<const uint8_t> bytes = document.buffers[static_cast<size_t>(buffer)];
  if (offset > bytes.size() || length > bytes.size() - offset) return invalid_input("reaches past its buffer");
  if (view.range.bytes > view.meshopt->decoded_bytes())
    return invalid_input("has fewer elements than its buffer view");
  return bytes.subspan(static_cast<size_t>(offset), static_cast<size_t>(length));
}

// What takes the place of each buffer that views name for their decoded bytes.
class DecodedBuffers {
 public:
  explicit DecodedBuffers(Document& document) : document_(document) {}

  uint64_t bytes() const { return bytes_; }

  // Appends bytes for the view, and makes the view refer to them. They have to be used before the next call.
  std::span<uint8_t> add(size_t index, const ViewRecord& view) {
    Json& json = document_.json()["bufferViews"][index];
    const auto [found, is_new] = slots_.try_emplace(view.range.buffer, slots_.size());
    if (is_new) decoded_.push_back({describe(view.range.buffer, json), {}});
    std::vector<uint8_t>& bytes = decoded_[found->second].second;
    const size_t start = (bytes.size() + 7) / 8 * 8, length = view.meshopt->decoded_bytes();
    bytes_ += start - bytes.size() + length;
    bytes.resize(start + length);
    json["buffer"] = document_.buffers.size() + found->second;
    json["byteOffset"] = start;
    return std::span(bytes).subspan(start);
  }

  bool finish() {
    for (auto& [json, bytes] : decoded_) {
      json["byteLength"] = bytes.size();
      document_.json()["buffers"].push_back(std::move(json));
      document_.buffers.push_back(std::move(bytes));
    }
    return !decoded_.empty();
  }

 private:
  // A buffer whose file has no bytes stays one of these. Otherwise the file has what loaders without the
  // extension need, and so will the file that is written.
  Json describe(int64_t buffer, const Json& view) const {
    Json json = std::as_const(document_).json()["buffers"][static_cast<size_t>(buffer)];
    const bool has_uri = json.erase("uri") > 0;
    if (!document_.buffers[static_cast<size_t>(buffer)].empty()) return {{"byteLength", 0}};
    if (has_uri && meshopt_extension(json) != nullptr) erase_meshopt_extension(json);
    if (has_uri || is_meshopt_fallback(json)) return json;
    json["extensions"][name_of_meshopt(view)] = {{"fallback", true}};
    return json;
  }

  Document& document_;
  std::map<int64_t, size_t> slots_;  // of the buffers in the file
  std::vector<std::pair<Json, std::vector<uint8_t>>> decoded_;
  uint64_t bytes_ = 0;
};

// Drops the buffers that decoded bytes took the place of, and the names of extensions that nothing has.
void sweep(Document& document) {
  drop_unused(document, {});
  // An unknown extension may keep a fallback buffer in its place.
  const AssetRecords records = document.records();
  std::set<int64_t> referred;
  for (const ViewRecord& view : records.views) referred.insert(view.range.buffer);
  for (size_t i = 0; i < document.buffers.size(); ++i) {
    if (!records.buffers[i].is_fallback || referred.contains(static_cast<int64_t>(i))) continue;
    Json& buffer = document.json()["buffers"][i];
    erase_meshopt_extension(buffer);
    if (document.buffers[i].empty()) buffer["byteLength"] = 0;
  }
  for (const char* name : kMeshoptExtensions) unlist_unused_extension(document, name);
}

}  // namespace

Status decode_meshopt_views(Document& document) {
  uint64_t all_bytes = 0, most_of_a_byte = 0;
  for (const auto& buffer : document.buffers) all_bytes += buffer.size();
  const std::vector<ViewRecord> views = document.records().views;
  DecodedBuffers decoded(document);
  for (size_t i = 0; i < views.size(); ++i) {
    if (!views[i].meshopt) continue;
    const MeshoptRecord& compressed = *views[i].meshopt;
    const std::string name = "buffer view " + std::to_string(i) + ", compressed by meshoptimizer, ";
    const Expected<std::span<const uint8_t>> bytes = compressed_bytes(document, views[i]);
    if (!bytes) return invalid_input(name + bytes.status().message());
    if (!is_readable_meshopt(compressed, *bytes)) continue;
    const uint64_t most = most_decoded_bytes(compressed, *bytes);
    if (compressed.decoded_bytes() > most)
      return invalid_input(name + "has more elements than its bytes can hold");
    if (!is_legal_meshopt(compressed))
      return invalid_input(name + "has an illegal combination of mode, filter and byteStride");
    // Views may share their bytes, but not so often that a small file becomes huge.
    if (!bytes->empty()) most_of_a_byte = std::max(most_of_a_byte, most / bytes->size());
    if (decoded.bytes() + compressed.decoded_bytes() > most_of_a_byte * all_bytes + 8 * (i + 1))
      return invalid_input(name + "shares its bytes with too many other views");
    const std::span<uint8_t> rows = decoded.add(i, views[i]);
    if (!decode_meshopt_rows(compressed, *bytes, rows.data())) return invalid_input(name + "cannot be decoded");
    undo_meshopt_filter(compressed, rows.data());
  }
  if (decoded.finish()) sweep(document);
  return {};
}

void make_meshopt_views_plain(Document& document) {
  const std::vector<ViewRecord> views = document.records().views;
  bool any = false;
  Json& json = document.json();
  for (size_t i = 0; i < views.size(); ++i) {
    if (!views[i].meshopt || document.buffers[static_cast<size_t>(views[i].range.buffer)].empty()) continue;
    erase_meshopt_extension(json["bufferViews"][i]);
    any = true;
  }
  if (!any) return;
  for (size_t i = 0; i < document.buffers.size(); ++i) {
    Json& buffer = json["buffers"][i];
    if (is_meshopt_fallback(buffer) && !document.buffers[i].empty()) erase_meshopt_extension(buffer);
  }
  sweep(document);
}

}  // namespace psplit
