#include "gltf_ext/convert/compress_rest.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gltf_ext/convert/rest_columns.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/packed_buffer.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/store_meshopt.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/accessors.h"

namespace psplit {
namespace {

constexpr size_t kRowMultiple = 4;  // of bytes, in rows of attributes

// Columns whose rows may be in one view: what glTF and the codec ask of them is the same.
using JoinKey = std::tuple<RestView, size_t, size_t, std::string>;  // its stride, its rows, its filter
JoinKey key_of(const RestColumn& column) {
  const bool has_stride = column.needs == RestView::kVertices;
  const bool is_index = column.needs == RestView::kIndices || column.needs == RestView::kTriangles;
  return {column.needs, has_stride || is_index ? column.width : 0, column.row,
          column.filtered ? column.filtered->filter : "NONE"};
}

// A view of several columns, one after the other.
struct JoinedView {
  std::vector<const RestColumn*> columns;
  std::vector<uint64_t> offsets;             // of each
  std::vector<uint8_t> rows, values, exact;  // for the codec; what loaders get; without the filter
  std::vector<uint64_t> exact_offsets;
  MeshoptRecord record;
  std::vector<uint8_t> compressed;
  bool is_smaller = false;

  RestView needs() const { return columns.front()->needs; }
};

// Puts columns into a joined view; equal ones share their place.
class Joiner {
 public:
  explicit Joiner(JoinedView& joined) : joined_(joined) {}

  void add(const RestColumn& column) {
    const bool is_index = column.needs == RestView::kIndices || column.needs == RestView::kTriangles;
    const size_t multiple = is_index ? column.width : column.row;
    const std::vector<uint8_t>& rows = column.filtered ? column.filtered->rows : column.values;
    const std::vector<uint8_t>& values = column.filtered ? column.filtered->values : column.values;
    joined_.columns.push_back(&column);
    const auto [exact, is_new_exact] = exact_.try_emplace(key(column.values), joined_.exact.size());
    joined_.exact_offsets.push_back(exact->second);
    if (is_new_exact) append(column.values, multiple, joined_.exact);
    const auto [found, is_new] = found_.try_emplace(key(rows), joined_.rows.size());
    joined_.offsets.push_back(found->second);
    if (!is_new) return;
    append(rows, multiple, joined_.rows);
    append(values, multiple, joined_.values);
  }

 private:
  static std::string key(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }
  static void append(const std::vector<uint8_t>& bytes, size_t multiple, std::vector<uint8_t>& to) {
    to.insert(to.end(), bytes.begin(), bytes.end());
    to.resize((to.size() + multiple - 1) / multiple * multiple);
  }

  JoinedView& joined_;
  std::unordered_map<std::string, uint64_t> found_, exact_;
};

// Tries the codecs that take such rows, and keeps the smallest result.
void compress(JoinedView& joined) {
  const RestColumn& first = *joined.columns.front();
  const auto attempt = [&](const char* mode, size_t stride) {
    std::vector<uint8_t> rows = joined.rows;
    rows.resize((rows.size() + stride - 1) / stride * stride);
    MeshoptRecord record;
    record.mode = mode;
    record.filter = first.filtered ? first.filtered->filter : "NONE";
    record.stride = stride;
    record.count = rows.size() / stride;
    if (!is_legal_meshopt(record)) return;
    std::vector<uint8_t> bytes = encode_meshopt_rows(record, rows);
    if (bytes.empty() || (!joined.compressed.empty() && bytes.size() >= joined.compressed.size())) return;
    joined.compressed = std::move(bytes);
    joined.record = std::move(record);
  };
  if (first.needs == RestView::kTriangles) attempt("TRIANGLES", first.width);
  if (first.needs == RestView::kTriangles || first.needs == RestView::kIndices) {
    attempt("INDICES", first.width);
    attempt("ATTRIBUTES", kRowMultiple);
  } else {
    attempt("ATTRIBUTES", first.row);
  }
  joined.values.resize(joined.record.decoded_bytes());
}

// The JSON of a view, but for its place in buffers.
Json describe_joined(const JoinedView& joined) {
  Json view = {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 0}};
  if (joined.needs() == RestView::kVertices) view["byteStride"] = joined.columns.front()->width;
  if (joined.needs() == RestView::kVertices) view["target"] = kArrayBuffer;
  const bool has_indices = joined.needs() == RestView::kIndices || joined.needs() == RestView::kTriangles;
  const bool is_sparse = joined.columns.front()->place.second != ElementsRole::kElements;
  if (has_indices && !is_sparse) view["target"] = kElementArrayBuffer;
  return view;
}

class RestCompressor {
 public:
  RestCompressor(Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool)
      : document_(document),
        pool_(pool),
        extension_(options.meshopt == MeshoptRest::kKhr ? "KHR_meshopt_compression"
                                                        : "EXT_meshopt_compression"),
        columns_(rest_columns(document, options, pool)) {}

  Status run() {
    join();
    std::vector<JoinedView*> views;
    for (auto& [key, joined] : joined_) views.push_back(&joined);
    pool_.for_each(views.size(), [&](size_t i) {
      compress(*views[i]);
      views[i]->is_smaller = is_smaller(*views[i]);
    });
    leave_views();
    for (auto& [key, joined] : joined_) store(joined);
    if (views_.empty()) return {};
    for (const auto& [index, is_of_vertices] : rounded_)
      if (Status status = set_bounds_of(index, is_of_vertices); !status.ok()) return status;
    list_extension(document_, extension_.c_str(), true);
    drop_unused(document_, share_accessors());
    return {};
  }

 private:
  // Sparse indices have no target, so they are not joined with indices of triangles and points.
  void join() {
    std::map<std::pair<JoinKey, bool>, std::vector<const RestColumn*>> groups;
    for (const RestColumn& column : columns_)
      groups[{key_of(column), column.place.second == ElementsRole::kSparseIndices}].push_back(&column);
    for (const auto& [key, columns] : groups) {
      Joiner joiner(joined_[key]);
      for (const RestColumn* column : columns) joiner.add(*column);
    }
  }

  // The JSON of a view with the extension takes more than that of one without.
  bool is_smaller(const JoinedView& joined) const {
    if (joined.compressed.empty()) return false;
    Json view = describe_joined(joined);
    const size_t before = json_line(view).size();
    view["extensions"][extension_] = {{"buffer", 0},
                                      {"byteOffset", joined.exact.size()},
                                      {"byteLength", joined.compressed.size()},
                                      {"byteStride", joined.record.stride},
                                      {"count", joined.record.count},
                                      {"mode", joined.record.mode},
                                      {"filter", joined.record.filter}};
    const size_t more = json_line(view).size() - before;
    return joined.compressed.size() + PackedBuffer::kAlignment + more < joined.exact.size();
  }

  // Views all of whose values would be in larger ones stay.
  void leave_views() {
    std::set<int64_t> change;
    for (const auto& [key, joined] : joined_)
      if (joined.is_smaller)
        for (const RestColumn* column : joined.columns) change.insert(column->view);
    std::map<std::pair<JoinKey, bool>, JoinedView> kept;
    for (auto& [key, joined] : joined_) {
      if (joined.is_smaller) {
        kept[key] = std::move(joined);
        continue;
      }
      Joiner joiner(kept[key]);
      for (const RestColumn* column : joined.columns)
        if (change.contains(column->view)) joiner.add(*column);
      if (kept[key].columns.empty()) kept.erase(key);
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
    const int64_t index = append_buffer_view(document_, joined.exact);
    Json view = describe_joined(joined);
    Json& stored = document_.json()["bufferViews"][static_cast<size_t>(index)];
    view.update(stored);
    stored = std::move(view);
    return index;
  }

  // Bounds that are stated follow the values of vertices. Others need none.
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

  // Accessors that say the same become one. Returns the others.
  std::vector<int64_t> share_accessors() {
    const UnknownReferences unknown = find_unknown_references(document_.json());
    Json& json = document_.json();
    std::unordered_map<std::string, int64_t> firsts;
    std::map<int64_t, int64_t> first_of;
    std::vector<int64_t> freed;
    for (size_t i = 0; i < json["accessors"].size(); ++i) {
      const auto index = static_cast<int64_t>(i);
      if (!is_moved(index) || unknown.accessors.contains(index)) continue;
      const auto [found, is_new] = firsts.try_emplace(json_line(json["accessors"][i]), index);
      if (is_new) continue;
      first_of[index] = found->second;
      freed.push_back(index);
    }
    for_each_accessor_reference(json, [&](Json& index) {
      const auto found = first_of.find(integer_value(index).value_or(-1));
      if (found != first_of.end()) index = found->second;
    });
    return freed;
  }

  Document& document_;
  const ThreadPool& pool_;
  const std::string extension_;
  const std::vector<RestColumn> columns_;
  std::map<std::pair<JoinKey, bool>, JoinedView> joined_;
  std::set<int64_t> views_;          // those that were made
  std::map<int64_t, bool> rounded_;  // accessors whose values are others than before; whether of vertices
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
  if (Status status = RestCompressor(document, options, pool).run(); !status.ok()) return status;
  // The lists of extensions, and the buffer that stands for the decoded bytes, may outweigh small views.
  if (glb_bytes(document) >= glb_bytes(before)) document = std::move(before);
  return document.check();
}

}  // namespace psplit
