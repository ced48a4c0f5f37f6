// Arrays to Draco streams and containers, with the project's encoder.
#pragma once

#include <pybind11/pybind11.h>

namespace psplit::python {

void add_encode(pybind11::module_& module);

}  // namespace psplit::python
