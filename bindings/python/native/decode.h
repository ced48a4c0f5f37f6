// Draco streams and containers to tuples of arrays, of which the package makes its classes.
#pragma once

#include <pybind11/pybind11.h>

#include "psplit/mesh.h"

namespace psplit::python {

namespace py = pybind11;

// What the package makes a mesh of: (coding, point count, faces, attributes, metadata). An attribute is (name,
// unique id, values, normalized, bits, origin, range, whether the values are the stream's integers). Attributes
// of glTF have None for what only a stream says. `gltf_psplit.Mesh` has the same members.
py::tuple tuple_of(Mesh&& mesh, const char* coding);

void add_decode(py::module_& module);

}  // namespace psplit::python
