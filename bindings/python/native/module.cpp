// The module gltf_psplit._native: what the package gltf_psplit does in C++. The package has the documented
// interface.
#include <pybind11/pybind11.h>

#include "bindings/python/native/arrays.h"
#include "bindings/python/native/decode.h"
#ifdef PSPLIT_PYTHON_ENCODES
#include "bindings/python/native/document.h"
#include "bindings/python/native/encode.h"
#endif
#include "psplit/version.h"

PYBIND11_MODULE(_native, module) {
  using namespace psplit::python;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const StatusError& error) {
      const py::object exception = exception_of(error.status);
      PyErr_SetObject(py::type::of(exception).ptr(), exception.ptr());
    }
  });
  add_decode(module);
#ifdef PSPLIT_PYTHON_ENCODES
  add_encode(module);
  add_document(module);
#endif
  module.attr("version") = PSPLIT_VERSION_TEXT;
}
