#include "bindings/python/native/encode.h"

#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <future>

#include "bindings/python/native/arrays.h"
#include "bindings/python/native/pools.h"
#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"
#include "encoder/stream/attribute_plan.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/mesh/no_indices.h"

namespace psplit::python {
namespace {

using Indices = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;
// (bits, origin, range); an octahedron has no origin.
using Grid = std::tuple<int, std::vector<float>, float>;
// (semantic, C-contiguous values of (points, components), normalized, bits that replace the options', a grid
// that the values get, a grid that they keep if all of them are on it)
using Given =
    std::tuple<std::string, py::array, bool, std::optional<int>, std::optional<Grid>, std::optional<Grid>>;

ComponentType component_type(const py::dtype& type) {
  const std::string code = type.kind() + std::to_string(type.itemsize());
  for (const ComponentType candidate :
       {ComponentType::kInt8, ComponentType::kUint8, ComponentType::kInt16, ComponentType::kUint16,
        ComponentType::kUint32, ComponentType::kFloat32})
    if (code == type_code(candidate)) return candidate;
  throw py::type_error("glTF has no attributes of the type " + code);
}

// The caller's arrays, which must outlive it.
MeshView view_of(const Indices& faces, const std::vector<Given>& attributes) {
  const auto bytes_of = [](const py::array& array) {
    return Span<const std::byte>(static_cast<const std::byte*>(array.data()),
                                 static_cast<size_t>(array.nbytes()));
  };
  const auto point_count = static_cast<uint32_t>(std::get<1>(attributes.at(0)).shape(0));
  MeshView view{point_count, {}, {ComponentType::kUint32, 1, false, 0, bytes_of(faces), 0}};
  view.indices.count = static_cast<uint32_t>(faces.size());
  for (const auto& [semantic, values, normalized, bits, grid, stated] : attributes)
    view.attributes.push_back({semantic,
                               {component_type(values.dtype()), static_cast<uint8_t>(values.shape(1)),
                                normalized, point_count, bytes_of(values), 0}});
  return view;
}

// Calls work(watch) on another thread, so that Ctrl-C stops it: this thread asks for signals meanwhile.
template <typename Work>
auto interruptible(const Work& work) {
  std::atomic<bool> stop = false;
  Watch watch;
  watch.stop = &stop;
  auto done = std::async(std::launch::async, [&] { return work(watch); });
  bool is_interrupted = false;
  const py::gil_scoped_release release;
  while (done.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    const py::gil_scoped_acquire acquire;
    if (is_interrupted || PyErr_CheckSignals() == 0) continue;
    is_interrupted = stop = true;
  }
  const py::gil_scoped_acquire acquire;
  auto result = done.get();
  if (is_interrupted) throw py::error_already_set();
  return result;
}

py::bytes bytes_of(const std::vector<uint8_t>& bytes) {
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

AttributeCoding coding_of(const Grid& grid) {
  const auto& [bits, origin, range] = grid;
  return {bits, origin.empty(), origin, range};
}

// The last place of a grid may be decoded as a value a little beyond the range. Returns whether all values are
// on the grid, and some are there: the encoder takes the grid of such values from the caller alone. Moves them
// to the end of the range, which has the same place.
bool is_on_grid_and_beyond(Attribute& attribute, const AttributeCoding& grid) {
  if (attribute.component_type != ComponentType::kFloat32 || grid.octahedral || !grid_extremes(grid) ||
      !is_on_grid(attribute, grid, {}))
    return false;
  bool is_beyond = false;
  for (size_t at = 0; at < attribute.values.size(); at += sizeof(float)) {
    const float low = grid.origin[at / sizeof(float) % grid.origin.size()];
    float value = 0;
    std::memcpy(&value, attribute.values.data() + at, sizeof value);
    if (double{value} - double{low} <= double{grid.range}) continue;
    is_beyond = true;
    if (value - low <= grid.range) continue;
    value = low + grid.range;
    while (value - low > grid.range) value = std::nextafter(value, low);
    std::memcpy(attribute.values.data() + at, &value, sizeof value);
  }
  return is_beyond;
}

// The caller's arrays, with what the caller says about each.
Expected<MeshToEncode> source_of(const MeshView& view, const std::vector<Given>& attributes, bool is_cloud) {
  if (view.indices.count == 0 && !is_cloud) return invalid_input("the mesh has no triangles");
  Expected<Mesh> mesh = mesh_of(view);
  if (!mesh) return mesh.status();
  MeshToEncode source{std::move(*mesh)};
  for (size_t i = 0; i < attributes.size(); ++i) {
    const auto& [semantic, values, normalized, bits, grid, stated] = attributes[i];
    if (grid) source.own_codings[i] = {std::get<0>(*grid), coding_of(*grid)};
    if (bits) source.own_codings[i] = {*bits, {}};
    source.stated.push_back(stated ? coding_of(*stated) : AttributeCoding());
    if (stated && is_on_grid_and_beyond(source.mesh.attributes[i], source.stated[i]))
      source.own_codings[i] = {source.stated[i].bits, source.stated[i]};
  }
  return source;
}

Expected<EncodedMesh> encode_mesh(const MeshView& view, const std::vector<Given>& attributes,
                                  const EncodeOptions& options, const ThreadPool& pool, const Watch& watch) {
  Expected<MeshToEncode> source = source_of(view, attributes, options.storage == Storage::kCloud);
  if (!source) return source.status();
  MeshToEncode* const planned[] = {&*source};
  if (Status status = plan(planned, options, pool); !status.ok()) return status;
  return encode(std::move(*source), options, pool, watch);
}

EncodeOptions options_of(int position_bits, int normal_bits, int texcoord_bits, int speed) {
  EncodeOptions options;
  options.position_bits = position_bits;
  options.normal_bits = normal_bits;
  options.texcoord_bits = texcoord_bits;
  options.encode_speed = speed;
  return options;
}

// What the caller's bits lose becomes a warning of Python.
void warn_of_losses(const EncodedMesh& encoded) {
  for (const PrecisionNote& note : encoded.notes)
    if (note.is_warning && PyErr_WarnEx(PyExc_UserWarning, note.text.c_str(), 2) != 0)
      throw py::error_already_set();
}

// Whether the stream itself does not name an attribute.
bool needs_name(const EncodedMesh& encoded, size_t i, bool is_cloud) {
  return draco_semantic(encoded.pieces[0].decoded.attributes[i], encoded.codings[i], is_cloud) ==
         DracoSemantic::kGeneric;
}

// One ordinary Draco stream, the bits of its positions, and the names of its generic attributes, by unique id.
// Sequential streams keep the order of points and faces. A cloud has no faces.
py::tuple encode(const Indices& faces, const std::vector<Given>& attributes, int position_bits, int normal_bits,
                 int texcoord_bits, int speed, bool sequential, bool is_cloud) {
  MeshView view = view_of(faces, attributes);
  if (is_cloud) view.indices = no_indices();
  EncodeOptions options = options_of(position_bits, normal_bits, texcoord_bits, speed);
  // The stream's metadata repeat the bits of positions. A stated grid has its own.
  options.given.position = !std::get<5>(attributes.at(0)).has_value();
  options.storage = is_cloud ? Storage::kCloud : sequential ? Storage::kInOrder : Storage::kOneStream;
  if (is_cloud && sequential) options.encode_speed = kMostEncodeSpeed;  // others may be trees
  options.keep_duplicates = true;                                       // as Draco keeps them
  const EncodedMesh done = value_or_throw(interruptible(
      [&](const Watch& watch) { return encode_mesh(view, attributes, options, ThreadPool(1), watch); }));
  warn_of_losses(done);
  const EncodedPiece& piece = done.pieces[0];
  py::dict generic;
  for (size_t i = 0; i < done.requests.size(); ++i)
    if (needs_name(done, i, is_cloud))
      generic[py::int_(done.requests[i].unique_id)] = done.requests[i].semantic;
  return py::make_tuple(bytes_of(piece.bytes), done.codings[0].bits, std::move(generic));
}

// (bytes, [(semantic, unique id, component type, components, normalized)], point count, face count)
py::tuple encode_container(const Indices& faces, const std::vector<Given>& attributes, int position_bits,
                           int normal_bits, int texcoord_bits, int speed, uint32_t patch_count,
                           int thread_count) {
  const MeshView view = view_of(faces, attributes);
  EncodeOptions options = options_of(position_bits, normal_bits, texcoord_bits, speed);
  options.storage = Storage::kContainer;
  options.patches.count = patch_count;
  options.patches.always = true;
  const EncodedMesh done = value_or_throw(with_pool(thread_count, [&](const ThreadPool& pool) {
    return interruptible(
        [&](const Watch& watch) { return encode_mesh(view, attributes, options, pool, watch); });
  }));
  warn_of_losses(done);
  py::list requests;
  for (const AttributeRequest& request : done.requests)
    requests.append(py::make_tuple(request.semantic, request.unique_id, int{uint16_t(request.component_type)},
                                   int{request.component_count}, request.normalized));
  const EncodedPiece& piece = done.pieces[0];
  return py::make_tuple(bytes_of(piece.bytes), requests, piece.point_count, piece.face_count);
}

}  // namespace

void add_encode(py::module_& module) {
  module.def("encode", &encode, py::arg("faces"), py::arg("attributes"), py::arg("position_bits"),
             py::arg("normal_bits"), py::arg("texcoord_bits"), py::arg("speed"), py::arg("sequential"),
             py::arg("is_cloud"));
  module.def("encode_container", &encode_container, py::arg("faces"), py::arg("attributes"),
             py::arg("position_bits"), py::arg("normal_bits"), py::arg("texcoord_bits"), py::arg("speed"),
             py::arg("patches"), py::arg("threads"));
}

}  // namespace psplit::python
