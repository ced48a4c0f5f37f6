#include "bindings/python/native/document.h"

#include <pybind11/stl.h>

#include <memory>
#include <vector>

#include "bindings/python/native/arrays.h"
#include "bindings/python/native/decode.h"
#include "bindings/python/native/pools.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"
#include "psplit/encode.h"

namespace psplit::python {
namespace {

// Decodes the meshes of triangle primitives on the CPU. If there is libdraco, it decodes older streams of
// Draco.
std::vector<Expected<Mesh>> read_triangles(const Document& document, std::span<const PrimitiveId> ids,
                                           const ThreadPool& pool) {
  std::vector<Expected<Mesh>> meshes = read_primitives(document, ids, cpu_backend(), pool);
  for (size_t i = 0; i < ids.size(); ++i)
    if (has_draco() && meshes[i].status().code() == StatusCode::kUnsupported &&
        document.records().primitive(ids[i]).storage() == PrimitiveStorage::kStockDraco)
      meshes[i] = read_primitive(document, ids[i], draco_backend(), pool);
  return meshes;
}

struct ReadPrimitive {
  PrimitiveId id;
  int corner_count = 3;  // of an element: 3 for triangles, 2 for lines, 1 for points
  Status status{};
  Mesh mesh{};
  std::vector<MorphAttribute> morphs{};
};

std::vector<ReadPrimitive> read_all(const Document& document, const ThreadPool& pool) {
  std::vector<ReadPrimitive> read;
  std::vector<PrimitiveId> triangles;
  std::vector<size_t> places;
  for (const PrimitiveId id : all_primitives(document)) {
    ReadPrimitive& primitive = read.emplace_back(ReadPrimitive{id});
    if (document.records().primitive(id).has_triangles()) {
      triangles.push_back(id);
      places.push_back(read.size() - 1);
      continue;
    }
    Expected<LinesOrPoints> elements = read_lines_or_points(document, id);
    primitive.status = elements.status();
    if (!elements) continue;
    primitive.corner_count = elements->corner_count;
    primitive.mesh = std::move(elements->mesh);
  }
  std::vector<Expected<Mesh>> meshes = read_triangles(document, triangles, pool);
  for (size_t i = 0; i < places.size(); ++i) {
    read[places[i]].status = meshes[i].status();
    if (meshes[i]) read[places[i]].mesh = std::move(*meshes[i]);
  }
  for (ReadPrimitive& primitive : read) {
    if (!primitive.status.ok() || document.records().primitive(primitive.id).targets.empty()) continue;
    primitive.morphs = take_targets(primitive.mesh);
    auto morphs = read_morph_targets(document, primitive.id, primitive.mesh.point_count);
    primitive.status = morphs.status();
    if (morphs) std::ranges::move(*morphs, std::back_inserter(primitive.morphs));
  }
  return read;
}

py::list targets_of(std::vector<MorphAttribute>&& morphs, size_t target_count) {
  std::vector<py::dict> targets(target_count);
  for (MorphAttribute& morph : morphs)
    targets[morph.target][py::str(morph.semantic)] =
        array_of(std::move(morph.data.values), type_code(morph.data.component_type), morph.data.count,
                 morph.data.component_count);
  return py::cast(targets);
}

class Asset {
 public:
  // From bytes, or from the file `source` if `data` is None.
  Asset(const std::string& source, const py::object& data) {
    std::optional<HeldBytes> held;
    if (!data.is_none()) held.emplace(data);
    std::optional<Expected<Document>> document;
    {
      const py::gil_scoped_release release;
      document.emplace(held ? parse_document(held->bytes(), source) : read_document(source));
    }
    document_ = value_or_throw(std::move(*document));
  }

  py::str json() const {
    Json as_read = document_.json();
    throw_if_failed(exchange_primitives(as_read));
    return py::str(json_line(as_read));
  }

  // For each mesh a list of its primitives: (corners of an element, mesh, morph targets), or an exception.
  py::list primitives(int thread_count) const {
    std::vector<ReadPrimitive> read = with_pool(thread_count, [&](const ThreadPool& pool) {
      const py::gil_scoped_release release;
      return read_all(document_, pool);
    });
    std::vector<py::list> meshes(document_.records().meshes.size());
    for (ReadPrimitive& primitive : read) {
      py::list& mesh = meshes[primitive.id.mesh];
      if (!primitive.status.ok()) {
        mesh.append(exception_of(std::move(primitive.status).at(place_of(document_, primitive.id))));
        continue;
      }
      const PrimitiveRecord& record = document_.records().primitive(primitive.id);
      mesh.append(py::make_tuple(primitive.corner_count, tuple_of(std::move(primitive.mesh), coding_of(record)),
                                 targets_of(std::move(primitive.morphs), record.targets.size())));
    }
    return py::cast(meshes);
  }

  size_t buffer_view_count() const { return document_.records().views.size(); }

  // `index` is below buffer_view_count().
  py::bytes buffer_view(size_t index) const {
    const std::span<const uint8_t> bytes =
        value_or_throw(buffer_view_bytes(document_, static_cast<int64_t>(index)));
    return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }

 private:
  static const char* coding_of(const PrimitiveRecord& record) {
    switch (record.storage()) {
      case PrimitiveStorage::kPatches: return "patches";
      case PrimitiveStorage::kStockDraco: return "draco";
      case PrimitiveStorage::kPlain: break;
    }
    return "plain";
  }

  Document document_;
};

}  // namespace

void add_document(py::module_& module) {
  py::class_<Asset>(module, "Asset")
      .def(py::init<const std::string&, const py::object&>(), py::arg("source"), py::arg("data"))
      .def("json", &Asset::json)
      .def("primitives", &Asset::primitives, py::arg("threads"))
      .def("buffer_view_count", &Asset::buffer_view_count)
      .def("buffer_view", &Asset::buffer_view, py::arg("index"));
}

}  // namespace psplit::python
