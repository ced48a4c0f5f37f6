#include "gltf_ext/convert/compress_rest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gltf_ext/convert/join_data.h"
#include "gltf_ext/convert/rest_columns.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/packed_buffer.h"
#include "gltf_ext/document/store_meshopt.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/accessors.h"

namespace psplit {
namespace {

constexpr size_t kRowMultiple = 4;  // of bytes, in rows of attributes

bool has_indices(RestView needs) { return needs == RestView::kIndices || needs == RestView::kTriangles; }

// Columns whose rows may be in one view: what glTF and the codec ask of them is the same.
using JoinKey = std::tuple<RestView, size_t, size_t, std::string, int64_t>;  // stride, rows, filter, own view
JoinKey key_of(const RestColumn& column) {
  const bool has_stride = column.needs == RestView::kVertices;
  return {column.needs, has_stride || has_indices(column.needs) ? column.width : 0, column.row,
          column.filtered ? column.filtered->filter : "NONE", column.extras.is_null() ? -1 : column.view};
}

// A view of several columns, one after the other.
struct JoinedView {
  std::vector<const RestColumn*> columns;
  std::vector<uint64_t> offsets, exact_offsets;  // of each
  JoinedBlocks rows, exact;                      // for the codec; without the filter
  std::vector<uint8_t> values;                   // what loaders get of the rows
  std::vector<uint8_t> lifted;                   // other rows of the same values, if the filter has these
  MeshoptRecord record;
  std::vector<uint8_t> compressed;
  bool is_smaller = false;

  RestView needs() const { return columns.front()->needs; }
  size_t alignment() const { return has_indices(needs()) ? columns.front()->width : columns.front()->row; }

  void add(const RestColumn& column) {
    columns.push_back(&column);
    exact_offsets.push_back(exact.add(column.values, alignment()).begin);
    exact.pad(alignment());
    const auto [begin, is_new] = rows.add(column.filtered ? column.filtered->rows : column.values, alignment());
    rows.pad(alignment());
    offsets.push_back(begin);
    if (!is_new) return;
    const auto append = [&](std::vector<uint8_t>& to, const std::vector<uint8_t>& added) {
      to.insert(to.end(), added.begin(), added.end());
      to.resize(rows.bytes().size());
    };
    append(values, column.filtered ? column.filtered->values : column.values);
    if (column.filtered && !column.filtered->lifted.empty()) append(lifted, column.filtered->lifted);
  }
};

// Tries the codecs that take such rows, and keeps the smallest result.
void compress(JoinedView& joined, bool is_khr) {
  const RestColumn& first = *joined.columns.front();
  const auto attempt = [&](const char* mode, size_t stride, std::vector<uint8_t> rows) {
    rows.resize((rows.size() + stride - 1) / stride * stride);
    MeshoptRecord record;
    record.mode = mode;
    record.filter = first.filtered ? first.filtered->filter : "NONE";
    record.stride = stride;
    record.count = rows.size() / stride;
    record.is_khr = is_khr;
    if (!is_legal_meshopt(record)) return;
    std::vector<uint8_t> bytes = encode_meshopt_rows(record, rows);
    if (bytes.empty() || (!joined.compressed.empty() && bytes.size() >= joined.compressed.size())) return;
    joined.compressed = std::move(bytes);
    joined.record = std::move(record);
  };
  if (first.needs == RestView::kTriangles) attempt("TRIANGLES", first.width, joined.rows.bytes());
  if (has_indices(first.needs)) {
    attempt("INDICES", first.width, joined.rows.bytes());
    attempt("ATTRIBUTES", kRowMultiple, joined.rows.bytes());
  } else {
    attempt("ATTRIBUTES", first.row, joined.rows.bytes());
    if (!joined.lifted.empty()) attempt("ATTRIBUTES", first.row, joined.lifted);
  }
  joined.values.resize(joined.record.decoded_bytes());
}

// The JSON of a view, but for its place in buffers.
Json describe_joined(const JoinedView& joined) {
  Json view = {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 0}};
  if (joined.needs() == RestView::kVertices) view["byteStride"] = joined.columns.front()->width;
  if (joined.needs() == RestView::kVertices) view["target"] = kArrayBuffer;
  const bool is_sparse = joined.columns.front()->place.second != ElementsRole::kElements;
  if (has_indices(joined.needs()) && !is_sparse) view["target"] = kElementArrayBuffer;
  if (const Json& extras = joined.columns.front()->extras; !extras.is_null()) view["extras"] = extras;
  return view;
}

class RestCompressor {
 public:
  RestCompressor(Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool)
      : document_(document),
        pool_(pool),
        is_khr_(options.meshopt == MeshoptRest::kKhr),
        extension_(kMeshoptExtensions[is_khr_ ? 1 : 0]),
        columns_(rest_columns(document, options, pool)) {}

  Status run() {
    choose_dense();
    join();
    std::vector<JoinedView*> views;
    for (auto& [key, joined] : joined_) views.push_back(&joined);
    pool_.for_each(views.size(), [&](size_t i) {
      compress(*views[i], is_khr_);
      views[i]->is_smaller = is_smaller(*views[i]);
    });
    leave_views();
    for (auto& [key, joined] : joined_) store(joined);
    if (views_.empty()) return {};
    for (const auto& [index, is_of_vertices] : rounded_)
      if (Status status = set_bounds_of(index, is_of_vertices); !status.ok()) return status;
    list_extension(document_, extension_.c_str(), true);
    drop_unused(document_, share_accessors(document_, moved_accessors()));
    return {};
  }

 private:
  // Compressed zeros take next to nothing, so that sparse values are often larger than dense ones.
  void choose_dense() {
    std::map<int64_t, std::array<const RestColumn*, 2>> pairs;  // indices and values, by accessor
    for (const RestColumn& column : columns_) {
      const auto& [index, role] = column.place;
      const AccessorRecord& accessor = document_.records().accessor(index);
      if (role != ElementsRole::kElements && column.is_of_vertices && !accessor.has_view() &&
          column.extras.is_null())
        pairs[index][role == ElementsRole::kSparseIndices ? 0 : 1] = &column;
    }
    std::erase_if(pairs, [](const auto& entry) { return !entry.second[0] || !entry.second[1]; });
    std::vector<std::pair<int64_t, std::optional<RestColumn>>> dense;
    for (const auto& [index, pair] : pairs) dense.emplace_back(index, std::nullopt);
    pool_.for_each(dense.size(), [&](size_t i) {
      auto& [index, chosen] = dense[i];
      const auto& [indices, values] = pairs.at(index);
      RestColumn column = dense_column(document_.records().accessor(index), *indices, *values);
      // "sparse" takes kSparseJson bytes more than "bufferView" in a GLB's JSON. Each stream ends in kTail
      // bytes.
      constexpr size_t kSparseJson = 100, kTail = 32;
      if (bytes_alone(column) + kTail <= bytes_alone(*indices) + bytes_alone(*values) + kSparseJson)
        chosen = std::move(column);
    });
    std::erase_if(dense, [](const auto& entry) { return !entry.second; });
    std::set<int64_t> chosen;
    for (const auto& entry : dense) chosen.insert(entry.first);
    std::erase_if(columns_, [&](const RestColumn& column) { return chosen.contains(column.place.first); });
    for (auto& entry : dense) columns_.push_back(std::move(*entry.second));
  }

  size_t bytes_alone(const RestColumn& column) const {
    JoinedView alone;
    alone.add(column);
    compress(alone, is_khr_);
    return alone.compressed.empty() ? column.values.size() : alone.compressed.size();
  }

  // Sparse indices have no target, so they are not joined with indices of triangles and points.
  void join() {
    std::map<std::pair<JoinKey, bool>, std::vector<const RestColumn*>> groups;
    for (const RestColumn& column : columns_)
      groups[{key_of(column), column.place.second == ElementsRole::kSparseIndices}].push_back(&column);
    for (const auto& [key, columns] : groups)
      for (const RestColumn* column : columns) joined_[key].add(*column);
  }

  // The JSON of a view with the extension takes more than that of one without.
  bool is_smaller(const JoinedView& joined) const {
    if (joined.compressed.empty()) return false;
    Json view = describe_joined(joined);
    const size_t before = json_line(view).size();
    view["extensions"][extension_] = {{"buffer", 0},
                                      {"byteOffset", joined.exact.bytes().size()},
                                      {"byteLength", joined.compressed.size()},
                                      {"byteStride", joined.record.stride},
                                      {"count", joined.record.count},
                                      {"mode", joined.record.mode},
                                      {"filter", joined.record.filter}};
    const size_t more = json_line(view).size() - before;
    return joined.compressed.size() + PackedBuffer::kAlignment + more < joined.exact.bytes().size();
  }

  // Views all of whose values would be in larger ones stay.
  void leave_views() {
    std::set<int64_t> change;
    for (const auto& [key, joined] : joined_)
      if (joined.is_smaller)
        for (const RestColumn* column : joined.columns) change.insert({column->view, column->indices_view});
    std::map<std::pair<JoinKey, bool>, JoinedView> kept;
    for (auto& [key, joined] : joined_) {
      if (joined.is_smaller) {
        kept[key] = std::move(joined);
        continue;
      }
      for (const RestColumn* column : joined.columns)
        if (change.contains(column->view)) kept[key].add(*column);
    }
    joined_ = std::move(kept);
  }

  void store(const JoinedView& joined) {
    const auto view = joined.is_smaller ? store_compressed(joined) : store_plain(joined);
    views_.insert(view);
    const std::vector<uint64_t>& offsets = joined.is_smaller ? joined.offsets : joined.exact_offsets;
    for (size_t i = 0; i < joined.columns.size(); ++i) {
      const RestColumn& column = *joined.columns[i];
      Json& accessors = document_.json()["accessors"];
      if (column.indices_view >= 0) {
        Json& dense = accessors[static_cast<size_t>(column.place.first)];
        dense.erase("sparse");
        dense["bufferView"] = view;
      }
      Json& place = *elements_json(accessors, column.place);
      place["bufferView"] = view;
      if (offsets[i] == 0)
        place.erase("byteOffset");
      else
        place["byteOffset"] = offsets[i];
      if (!column.filtered || !joined.is_smaller) continue;
      rounded_[column.place.first] = column.is_of_vertices;
      if (!column.filtered->are_shorts) continue;
      Json& accessor = accessors[static_cast<size_t>(column.place.first)];
      accessor["componentType"] = static_cast<int>(ComponentType::kInt16);
      accessor["normalized"] = true;
    }
  }

  int64_t store_compressed(const JoinedView& joined) {
    Json view = describe_joined(joined);
    view["buffer"] = meshopt_fallback(document_, extension_);
    view["extensions"][extension_] = Json::object();
    Json& views = document_.json()["bufferViews"];
    views.push_back(std::move(view));
    const size_t index = views.size() - 1;
    store_meshopt_rows(document_, index, joined.record, joined.compressed, joined.values);
    return static_cast<int64_t>(index);
  }

  int64_t store_plain(const JoinedView& joined) {
    const int64_t index = append_buffer_view(document_, joined.exact.bytes());
    Json view = describe_joined(joined);
    Json& stored = document_.json()["bufferViews"][static_cast<size_t>(index)];
    view.update(stored);
    stored = std::move(view);
    return index;
  }

  // Bounds that an accessor of vertices states become the bounds of its new values. Other bounds are dropped.
  Status set_bounds_of(int64_t index, bool is_of_vertices) {
    const auto accessor = [&]() -> Json& { return document_.json()["accessors"][static_cast<size_t>(index)]; };
    const bool has_bounds = field(accessor(), "min") != nullptr || field(accessor(), "max") != nullptr;
    for (const char* name : {"min", "max"}) accessor().erase(name);
    if (!has_bounds || !is_of_vertices) return {};
    const Expected<AccessorData> data = read_accessor(document_, index);
    if (!data) return data.status();
    Json bounds = Json::object();
    describe_decoded(bounds, *data, true);
    for (const char* name : {"min", "max"}) accessor()[name] = bounds[name];
    return {};
  }

  bool is_moved(int64_t accessor) const {
    const Json& json = std::as_const(document_).json();
    return std::ranges::any_of(kElementsRoles, [&](ElementsRole role) {
      const Json* place = elements_json(json["accessors"], {accessor, role});
      return place != nullptr && views_.contains(integer_field(*place, "bufferView").value_or(-1));
    });
  }

  // Accessors that unknown data may name stay apart.
  std::vector<int64_t> moved_accessors() const {
    const Json& json = std::as_const(document_).json();
    const UnknownReferences unknown = find_unknown_references(json);
    std::vector<int64_t> moved;
    for (int64_t index = 0; std::cmp_less(index, json["accessors"].size()); ++index)
      if (is_moved(index) && !unknown.accessors.contains(index)) moved.push_back(index);
    return moved;
  }

  Document& document_;
  const ThreadPool& pool_;
  const bool is_khr_;
  const std::string extension_;
  std::vector<RestColumn> columns_;
  std::map<std::pair<JoinKey, bool>, JoinedView> joined_;
  std::set<int64_t> views_;          // the views that were made
  std::map<int64_t, bool> rounded_;  // accessors whose values changed; whether they are of vertices
};

}  // namespace

Status check_rest(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits) {
  if (options.meshopt == MeshoptRest::kNo) return {};
  const auto is_within = [](int bits, int least, int most) { return bits >= least && bits <= most; };
  const AnimationBits& bits = options.animation_bits;
  if (!is_within(bits.translation, kLeastAnimationBits, kMostAnimationBits) ||
      !is_within(bits.scale, kLeastAnimationBits, kMostAnimationBits) ||
      !is_within(bits.rotation, kLeastRotationBits, kMostRotationBits) ||
      !is_within(bits.weight, 1, kMostWeightBits))
    return wrong_usage("the bits of animations are out of their ranges");
  if (limits.memory > 0) return wrong_usage("meshoptimizer compresses only assets that are in memory");
  return check_meshopt_encoder();
}

Status compress_rest(Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool) {
  if (options.meshopt == MeshoptRest::kNo) return {};
  Document before = document;
  if (options.meshopt == MeshoptRest::kKhr) make_meshopt_khr(document);
  if (Status status = RestCompressor(document, options, pool).run(); !status.ok()) return status;
  // The lists of extensions, and the buffer that stands for the decoded bytes, may outweigh small views.
  if (glb_bytes(document) >= glb_bytes(before)) document = std::move(before);
  return document.check();
}

}  // namespace psplit
