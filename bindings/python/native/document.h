// glTF assets, with the meshes that their primitives decode to.
#pragma once

#include <pybind11/pybind11.h>

namespace psplit::python {

void add_document(pybind11::module_& module);

}  // namespace psplit::python
