#include "bindings/python/native/arrays.h"

#include <vector>

#include "psplit/decode.h"
#include "src/container/stored_type.h"

namespace psplit::python {
namespace {

const char* code_name(StatusCode code) {
  switch (code) {
    case StatusCode::kOk: break;
    case StatusCode::kUsage: return "usage";
    case StatusCode::kIo: return "io";
    case StatusCode::kInvalidInput: return "invalid_input";
    case StatusCode::kRuntimeFailure: return "runtime_failure";
    case StatusCode::kUnsupported: return "unsupported";
    case StatusCode::kCancelled: return "cancelled";
    case StatusCode::kDiffers: return "differs";
    case StatusCode::kOutOfMemory: return "out_of_memory";
    case StatusCode::kMayPass: return "may_pass";
  }
  return "ok";
}

std::string shape_text(std::span<const size_t> shape) {
  std::string text = "(";
  for (size_t i = 0; i < shape.size(); ++i) text += (i == 0 ? "" : ", ") + std::to_string(shape[i]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

template <typename Values>
py::array owning_array(Values&& values, const py::dtype& type, std::vector<size_t> shape) {
  // The array and its views own the values, whatever becomes of the other arrays of the mesh.
  auto* const owned = new Values(std::move(values));
  const py::capsule owner(owned, [](void* at) { delete static_cast<Values*>(at); });
  return py::array(type, std::move(shape), owned->data(), owner);
}

size_t row_stride(const py::array& array) {
  if (array.ndim() != 2) return 0;
  return static_cast<size_t>(array.shape(0) > 1 ? array.strides(0) : array.shape(1) * array.itemsize());
}

// Why rows cannot be written to an array; null if they can. Arrays of other shapes are refused later.
const char* fault_of(const py::array& array) {
  if (!array.writeable()) return "is read-only, not writable";
  if (!array.dtype().attr("isnative").cast<bool>()) return "is not in native byte order";
  if (array.ndim() != 2 || array.size() == 0) return nullptr;
  const py::ssize_t rows = array.shape(0), columns = array.shape(1), size = array.itemsize();
  if ((rows > 1 && array.strides(0) < 0) || (columns > 1 && array.strides(1) < 0))
    return "has negative strides";
  if (columns > 1 && array.strides(1) != size) return "has rows whose values do not lie side by side";
  if (rows > 1 && array.strides(0) < columns * size) return "has rows that share memory";
  return nullptr;
}

}  // namespace

py::object exception_of(const Status& status) {
  const Place& place = status.place();
  const auto known = [](int64_t index) { return index < 0 ? py::object(py::none()) : py::int_(index); };
  return py::module_::import("gltf_psplit._errors")
      .attr("error_of")(code_name(status.code()), status.to_string(), known(place.patch), known(place.mesh),
                        known(place.primitive));
}

HeldBytes::HeldBytes(const py::handle& object) {
  if (PyUnicode_Check(object.ptr()) || PyObject_GetBuffer(object.ptr(), &view_, PyBUF_C_CONTIGUOUS) != 0) {
    PyErr_Clear();
    view_ = {};
    throw py::type_error("expected a contiguous bytes-like object, not " +
                         std::string(py::str(py::type::of(object).attr("__name__"))));
  }
}

const char* type_code(DataType type) {
  switch (type) {
    case DataType::kInt8: return "i1";
    case DataType::kUint8:
    case DataType::kBool: return "u1";
    case DataType::kInt16: return "i2";
    case DataType::kUint16: return "u2";
    case DataType::kInt32: return "i4";
    case DataType::kUint32: return "u4";
    case DataType::kInt64: return "i8";
    case DataType::kUint64: return "u8";
    case DataType::kFloat32: return "f4";
    case DataType::kFloat64: return "f8";
  }
  return "";
}

const char* type_code(ComponentType type) { return type_code(stored_type(type)); }

py::array array_of(Array<std::byte>&& values, const char* type, size_t rows, size_t columns) {
  return owning_array(std::move(values), py::dtype(type), {rows, columns});
}

py::array array_of(Array<std::array<uint32_t, 3>>&& faces) {
  const size_t count = faces.size();
  return owning_array(std::move(faces), py::dtype::of<uint32_t>(), {count, 3});
}

OutArrays::OutArrays(const py::object& dict) {
  if (dict.is_none()) return;
  std::vector<std::pair<std::string, py::array>> seen;
  const py::object share_memory = py::module_::import("numpy").attr("shares_memory");
  for (const auto& [name, value] : py::dict(dict)) {
    const std::string said = "out[" + std::string(py::repr(name)) + "] ";
    if (!py::isinstance<py::array>(value)) throw py::type_error(said + "is not a numpy array");
    Given given{py::reinterpret_borrow<py::array>(value), {}, {}};
    const py::array& array = given.array;
    if (const char* const fault = fault_of(array)) throw StatusError{wrong_usage(said + fault)};
    for (const auto& [other_said, other] : seen)
      if (share_memory(array, other).cast<bool>())
        throw StatusError{wrong_usage(other_said + "and " + said + "share memory")};
    seen.emplace_back(said, array);
    given.type = array.dtype().kind() + std::to_string(array.itemsize());
    given.shape =
        shape_text({reinterpret_cast<const size_t*>(array.shape()), static_cast<size_t>(array.ndim())});
    given.place = {static_cast<std::byte*>(given.array.mutable_data()), row_stride(array)};
    given_.emplace(key_of(name), std::move(given));
  }
}

OutArrays::Key OutArrays::key_of(const py::handle& key) {
  try {
    if (py::isinstance<py::str>(key)) return key.cast<std::string>();
    return key.cast<uint32_t>();
  } catch (const py::cast_error&) {
    throw py::type_error("out: " + std::string(py::repr(key)) + " is neither a name nor a unique id");
  }
}

const OutArrays::Given* OutArrays::find(const std::string& name, std::optional<uint32_t> unique_id) const {
  auto found = given_.find(name);
  if (found == given_.end() && unique_id) found = given_.find(*unique_id);
  return found == given_.end() ? nullptr : &found->second;
}

Expected<OutPlace> OutArrays::take(const std::string& name, std::optional<uint32_t> unique_id, const char* type,
                                   size_t rows, size_t columns) {
  auto* const given = const_cast<Given*>(find(name, unique_id));
  if (given == nullptr) return OutPlace{};
  const size_t shape[] = {rows, columns};
  if (given->is_taken) return wrong_usage("out has one array for two attributes: " + name);
  if (given->type != type || given->shape != shape_text(shape))
    return wrong_usage("out: " + name + " has the type " + type + " and the shape " + shape_text(shape) +
                       ", and the array is " + given->type + " of " + given->shape);
  given->is_taken = true;
  return given->place;
}

Expected<std::byte*> OutArrays::take_faces(size_t face_count) {
  const Expected<OutPlace> place = take(kFaces, {}, "u4", face_count, 3);
  if (!place) return place.status();
  if (place->data != nullptr && place->stride != 3 * sizeof(uint32_t))
    return wrong_usage("out: faces have gaps; only the values of attributes may lie apart");
  return place->data;
}

py::object OutArrays::taken(const std::string& name, std::optional<uint32_t> unique_id) const {
  const Given* const given = find(name, unique_id);
  return given == nullptr ? py::object(py::none()) : py::object(given->array);
}

Status OutArrays::all_taken() const {
  for (const auto& [key, given] : given_) {
    if (given.is_taken) continue;
    const auto* const name = std::get_if<std::string>(&key);
    return wrong_usage("out has an array for " + (name ? *name : std::to_string(std::get<uint32_t>(key))) +
                       ", which the data do not have");
  }
  return {};
}

}  // namespace psplit::python
