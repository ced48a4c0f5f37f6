#include "gltf_ext/convert/rest_columns.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <span>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_filters.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

constexpr size_t kMostRowBytes = 256;  // of the codec of attributes, whose rows are multiples of 4

template <typename T>
std::vector<T> numbers_of(std::span<const uint8_t> bytes) {
  std::vector<T> numbers(bytes.size() / sizeof(T));
  if (!numbers.empty()) std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(T));
  return numbers;
}

// As many whole periods as rows need to be multiples of 4, or as many elements if a row cannot hold these.
size_t row_bytes(size_t width, uint64_t period) {
  if (period <= kMostRowBytes) {
    const size_t row = std::lcm(width * static_cast<size_t>(period), size_t{4});
    if (row <= kMostRowBytes) return row;
  }
  return std::lcm(width, size_t{4});
}

// The rows of a filter, decoded.
FilteredRows undone(const char* filter, size_t stride, std::vector<uint8_t> rows) {
  FilteredRows result{filter, std::move(rows), {}, {}, false};
  MeshoptRecord record;
  record.mode = "ATTRIBUTES";
  record.filter = filter;
  record.stride = stride;
  record.count = result.rows.size() / stride;
  result.values = result.rows;
  undo_meshopt_filter(record, result.values.data());
  return result;
}

std::optional<FilteredRows> to_multiples(std::span<const float> values, int exponent) {
  std::vector<uint8_t> rows = filter_to_multiples(values, exponent);
  if (rows.empty()) return std::nullopt;
  FilteredRows filtered = undone("EXPONENTIAL", sizeof(float), std::move(rows));
  const std::vector<float> decoded = numbers_of<float>(filtered.values);
  const double most = std::ldexp(0.5, exponent);
  for (size_t i = 0; i < values.size(); ++i)
    if (!(std::fabs(double{decoded[i]} - double{values[i]}) <= most)) return std::nullopt;
  filtered.lifted = lift_multiples(filtered.rows);
  return filtered;
}

double dot_of(std::span<const double, 4> a, std::span<const double, 4> b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

std::optional<FilteredRows> to_rotations(std::span<const float> values, const RestPrecision& precision) {
  // Between keys about half a turn apart, rounding could change which way is shorter. Loaders divide by a
  // length that is not 1, or do not: so only unit quaternions mean the same to all.
  constexpr double kMostLengthError = 1.0 / 1024;
  const bool is_track = precision.kind == RestPrecision::Kind::kTurn;
  FilteredRows filtered = undone("QUATERNION", 4 * sizeof(int16_t), filter_rotations(values, precision.value));
  filtered.are_shorts = true;
  const std::vector<int16_t> decoded = numbers_of<int16_t>(filtered.values);
  const double half_step = 0.5 * std::sqrt(0.5) / ((1 << (precision.value - 1)) - 1), half_short = 0.5 / 32767;
  const double most = 3 * half_step + 4 * half_short;
  // Each of the two keys is off by at most the length of 4 such errors, which is 2 * most.
  const double least_dot = 2 * (2 * most);
  double before[4] = {};
  for (size_t i = 0; i + 4 <= values.size(); i += 4) {
    double rotation[4], rounded[4];
    for (size_t k = 0; k < 4; ++k) {
      rotation[k] = values[i + k];
      rounded[k] = decoded[i + k] / 32767.0;
    }
    const double length = std::sqrt(dot_of(rotation, rotation));
    if (!(std::fabs(length - 1) <= kMostLengthError)) return std::nullopt;
    for (double& number : rotation) number /= length;
    const double sign = dot_of(rotation, rounded) < 0 ? -1 : 1;
    for (size_t k = 0; k < 4; ++k)
      if (!(std::fabs(sign * rounded[k] - rotation[k]) <= most)) return std::nullopt;
    if (i > 0 && is_track && std::fabs(dot_of(rotation, before)) < least_dot) return std::nullopt;
    std::ranges::copy(rotation, before);
  }
  return filtered;
}

size_t distinct_elements(std::span<const uint8_t> bytes, size_t width) {
  std::unordered_set<std::string_view> found;
  for (size_t at = 0; at + width <= bytes.size(); at += width)
    found.emplace(reinterpret_cast<const char*>(&bytes[at]), width);
  return found.size();
}

std::optional<FilteredRows> filter_values(std::span<const uint8_t> bytes, const AccessorRecord& accessor,
                                          const RestPrecision& precision) {
  using Kind = RestPrecision::Kind;
  if (precision.kind == Kind::kExact || accessor.layout.component_type != ComponentType::kFloat32)
    return std::nullopt;
  const std::vector<float> values = numbers_of<float>(bytes);
  if (precision.kind == Kind::kStep) {
    std::optional<FilteredRows> filtered = to_multiples(values, precision.value);
    const size_t width = accessor.layout.stored_bytes();
    const bool is_joined = filtered && precision.keeps_apart &&
                           distinct_elements(filtered->values, width) < distinct_elements(bytes, width);
    return is_joined ? std::nullopt : filtered;
  }
  if (precision.kind == Kind::kBits) {
    const std::optional<int> exponent = exponent_for_bits(values, precision.value);
    return exponent ? to_multiples(values, *exponent) : std::nullopt;
  }
  // Sparse values have the type of the elements.
  if (accessor.layout.component_count() != 4 || accessor.sparse) return std::nullopt;
  return to_rotations(values, precision);
}

class ColumnFinder {
 public:
  ColumnFinder(const Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool)
      : document_(document), records_(document.records()), uses_(rest_uses(document, options, pool)) {}

  std::vector<RestColumn> run() {
    for (const auto& [index, use] : uses_) add_accessor(index, use);
    std::map<int64_t, size_t> columns_of;
    for (const RestColumn& column : columns_) ++columns_of[column.view];
    const DataUsers users(document_.json());
    std::erase_if(columns_, [&](const RestColumn& column) {
      return !DataUsers::has(users.views, column.view, columns_of[column.view]) ||
             !is_plain(column.view, columns_of[column.view] > 1);
    });
    for (RestColumn& column : columns_) read(column);
    return std::move(columns_);
  }

 private:
  void add_accessor(int64_t index, const RestUse& use) {
    const AccessorRecord& accessor = records_.accessor(index);
    const size_t width = accessor.layout.stored_bytes();
    if (accessor.has_view() && accessor.count > 0) {
      const bool has_stride = use.view == RestView::kVertices;
      const size_t stored = has_stride ? (width + 3) / 4 * 4 : width;
      add({index, ElementsRole::kElements}, accessor.elements.view, use.view, stored, use);
    }
    if (!accessor.sparse || accessor.sparse->count == 0) return;
    const SparseRecord& sparse = *accessor.sparse;
    add({index, ElementsRole::kSparseIndices}, sparse.indices.view, RestView::kIndices,
        component_bytes(sparse.index_type), use);
    add({index, ElementsRole::kSparseValues}, sparse.values.view, RestView::kPacked, width, use);
  }

  void add(ElementsPlace place, int64_t view, RestView needs, size_t width, const RestUse& use) {
    const uint64_t period = place.second == ElementsRole::kElements ? use.period : 1;
    columns_.push_back(
        {place, view, needs, use.view == RestView::kVertices, width, row_bytes(width, period), use.precision});
  }

  // Whether the view is in memory, and has nothing that would be lost with it. Extras of values that several
  // others join belong to none of these.
  bool is_plain(int64_t index, bool is_joined) const {
    const Json& view = document_.json()["bufferViews"][static_cast<size_t>(index)];
    return !records_.view(index).meshopt && field(view, "extensions") == nullptr &&
           !(is_joined && view.contains("extras")) && buffer_view_bytes(document_, index).ok();
  }

  void read(RestColumn& column) const {
    const auto& [index, role] = column.place;
    const AccessorRecord& accessor = records_.accessor(index);
    const bool is_index = role == ElementsRole::kSparseIndices, is_sparse = role != ElementsRole::kElements;
    const ElementsRecord& from = !is_sparse ? accessor.elements
                                 : is_index ? accessor.sparse->indices
                                            : accessor.sparse->values;
    const uint64_t count = is_sparse ? accessor.sparse->count : accessor.count;
    const size_t width = is_index ? column.width : accessor.layout.stored_bytes();
    const size_t last = is_index ? width : accessor.layout.last_bytes();
    const uint32_t stated = is_sparse ? 0 : records_.view(column.view).stride;
    const uint64_t stride = stated > 0 ? stated : width;
    const std::span<const uint8_t> bytes = *buffer_view_bytes(document_, column.view);
    if (const Json* extras = field(document_.json()["bufferViews"][static_cast<size_t>(column.view)], "extras"))
      column.extras = *extras;
    column.values.assign(static_cast<size_t>(count * column.width), 0);
    for (uint64_t i = 0; i < count; ++i)
      std::memcpy(&column.values[i * column.width], &bytes[from.offset + i * stride],
                  i + 1 < count ? width : last);
    if (is_index) return;
    // Bytes that pad elements in a view of vertices are not filtered: floats have none.
    column.filtered = filter_values(column.values, accessor, column.precision);
    if (column.filtered && column.filtered->are_shorts) column.row = 4 * sizeof(int16_t);
  }

  const Document& document_;
  const AssetRecords& records_;
  const std::map<int64_t, RestUse> uses_;
  std::vector<RestColumn> columns_;
};

}  // namespace

std::vector<RestColumn> rest_columns(const Document& document, const EncodeDocumentOptions& options,
                                     const ThreadPool& pool) {
  return ColumnFinder(document, options, pool).run();
}

RestColumn dense_column(const AccessorRecord& accessor, const RestColumn& indices, const RestColumn& values) {
  const size_t from = accessor.layout.stored_bytes(), to = (from + 3) / 4 * 4;
  RestColumn dense{{values.place.first, ElementsRole::kElements},
                   values.view,
                   RestView::kVertices,
                   true,
                   to,
                   row_bytes(to, 1),
                   values.precision};
  dense.indices_view = indices.view;
  dense.values.assign(static_cast<size_t>(accessor.count) * to, 0);
  for (size_t i = 0; (i + 1) * indices.width <= indices.values.size(); ++i) {
    uint32_t element = 0;
    std::memcpy(&element, &indices.values[i * indices.width], indices.width);  // little-endian, as glTF
    if (element < accessor.count) std::memcpy(&dense.values[element * to], &values.values[i * from], from);
  }
  dense.filtered = filter_values(dense.values, accessor, dense.precision);
  return dense;
}

}  // namespace psplit
