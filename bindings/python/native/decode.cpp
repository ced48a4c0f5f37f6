#include "bindings/python/native/decode.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <tuple>
#include <vector>

#include "bindings/python/native/arrays.h"
#include "bindings/python/native/pools.h"
#include "psplit/decode.h"
#include "psplit/loader.h"
#include "src/container/stored_type.h"
#include "src/loader/older_streams.h"
#ifdef PSPLIT_PYTHON_ENCODES
#include "psplit/encode.h"
#endif

namespace psplit::python {
namespace {

// Names of metadata are bytes that a writer chose. Bytes that are not UTF-8 are escaped as Python escapes file
// names.
py::str text_of(const std::string& bytes) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "surrogateescape"));
}

bool is_text(const std::string& bytes) {
  const py::gil_scoped_acquire acquire;
  const auto text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), nullptr));
  if (!text) PyErr_Clear();
  return static_cast<bool>(text);
}

// The name of an attribute in the metadata; empty if they have none that is text.
std::string stated_name(const StreamMetadata& metadata, uint32_t unique_id) {
  const auto found = std::ranges::find(metadata.attributes, unique_id, &AttributeMetadata::unique_id);
  if (found == metadata.attributes.end()) return {};
  const std::vector<uint8_t>* const bytes = found->metadata.find_entry("name");
  if (bytes == nullptr) return {};
  std::string name(bytes->begin(), bytes->end());
  return is_text(name) ? name : std::string();
}

// glTF's names for Draco's semantics, whatever the type of the values. gltf_attributes gives the same names to
// data of the types that glTF allows. Generic attributes have the names that the metadata say, as far as no two
// names are equal.
std::vector<std::string> names_of(std::span<const StreamAttribute> attributes, const StreamMetadata& metadata) {
  std::array<uint32_t, 5> used{};
  std::vector<std::string> names;
  for (const StreamAttribute& attribute : attributes) {
    const uint32_t number = used[static_cast<size_t>(attribute.semantic)]++;
    const auto numbered = [&](const char* prefix) { return prefix + std::to_string(number); };
    switch (attribute.semantic) {
      case DracoSemantic::kPosition: names.push_back(number == 0 ? "POSITION" : numbered("_POSITION_")); break;
      case DracoSemantic::kNormal: names.push_back(number == 0 ? "NORMAL" : numbered("_NORMAL_")); break;
      case DracoSemantic::kColor: names.push_back(numbered("COLOR_")); break;
      case DracoSemantic::kTexCoord: names.push_back(numbered("TEXCOORD_")); break;
      case DracoSemantic::kGeneric: names.push_back(numbered("_GENERIC_")); break;
    }
  }
  std::set<std::string> taken(names.begin(), names.end());
  taken.insert("");
  taken.insert(OutArrays::kFaces);
  for (size_t i = 0; i < names.size(); ++i) {
    if (attributes[i].semantic != DracoSemantic::kGeneric) continue;
    std::string name = stated_name(metadata, attributes[i].unique_id);
    if (taken.insert(name).second) names[i] = std::move(name);
  }
  return names;
}

// (entries, parts): a dict of bytes, and a dict of the same.
py::tuple tuple_of(const Metadata& metadata) {
  py::dict entries, parts;
  for (const auto& [name, value] : metadata.entries)
    entries[text_of(name)] = py::bytes(reinterpret_cast<const char*>(value.data()), value.size());
  for (const Metadata& part : metadata.parts) parts[text_of(part.name)] = tuple_of(part);
  return py::make_tuple(entries, parts);
}

// The metadata of the geometry, and of attributes by their unique ids; None if there are none.
py::object tuple_of(const StreamMetadata& metadata) {
  if (metadata == StreamMetadata()) return py::none();
  py::dict attributes;
  for (const AttributeMetadata& attribute : metadata.attributes)
    attributes[py::int_(attribute.unique_id)] = tuple_of(attribute.metadata);
  return py::make_tuple(tuple_of(metadata.geometry), attributes);
}

struct DecodedStream {
  DracoGeometry geometry;
  std::vector<std::string> names;  // of the attributes
  StreamMetadata metadata;
};

// The memory for a stream: the caller's arrays, and the geometry where there is none.
Expected<GeometryPlaces> places_for(const StreamDescription& description, std::span<const StoredValues> stored,
                                    bool integers, std::span<const uint8_t> stream, OutArrays& out,
                                    DecodedStream& decoded) {
  Expected<StreamMetadata> metadata = read_metadata(stream);
  if (!metadata) return metadata.status();
  decoded.metadata = std::move(*metadata);
  decoded.names = names_of(description.attributes, decoded.metadata);
  DracoGeometry& geometry = decoded.geometry;
  Expected<GeometryPlaces> places = allocate_geometry(description, stored, integers, stream.size(), geometry);
  if (!places) return places;
  const Expected<std::byte*> faces = out.take_faces(description.face_count);
  if (!faces) return faces.status();
  if (*faces != nullptr) {
    places->faces = *faces;
    geometry.faces = {};
  }
  for (size_t i = 0; i < geometry.attributes.size(); ++i) {
    GeometryAttribute& attribute = geometry.attributes[i];
    const Expected<OutPlace> given =
        out.take(decoded.names[i], attribute.description.unique_id, type_code(attribute.type()),
                 description.point_count, attribute.component_count());
    if (!given) return given.status();
    if (given->data == nullptr) continue;
    places->attributes[i].values = given->data;
    places->attributes[i].stride = given->stride;
    attribute.values = {};
  }
  if (Status all = out.all_taken(); !all.ok()) return all;
  return places;
}

// The memory for a mesh of glTF: the caller's arrays, and the mesh where there is none.
Expected<PrimitiveBuffers> buffers_for(uint32_t point_count, uint32_t face_count,
                                       std::span<const AttributeRequest> requests, size_t stored_bytes,
                                       OutArrays& out, Mesh& mesh) {
  Expected<PrimitiveBuffers> buffers = allocate_mesh(point_count, face_count, requests, stored_bytes, mesh);
  if (!buffers) return buffers;
  const Expected<std::byte*> faces = out.take_faces(face_count);
  if (!faces) return faces.status();
  if (*faces != nullptr) {
    buffers->indices = std::span(*faces, mesh.faces.size() * sizeof(mesh.faces[0]));
    mesh.faces = {};
  }
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    Attribute& attribute = mesh.attributes[i];
    const Expected<OutPlace> given =
        out.take(requests[i].semantic, requests[i].unique_id, type_code(attribute.component_type), point_count,
                 attribute.component_count);
    if (!given) return given.status();
    if (given->data == nullptr) continue;
    const size_t bytes = point_count == 0 ? 0 : (point_count - 1) * given->stride + attribute.stride();
    buffers->attributes[i] = {std::span(given->data, bytes), given->stride};
    attribute.values = {};
  }
  if (Status all = out.all_taken(); !all.ok()) return all;
  return buffers;
}

const OlderStreams* built_in_older_streams() {
#ifdef PSPLIT_PYTHON_ENCODES
  return older_streams();
#else
  return nullptr;
#endif
}

// A mesh of a bitstream before 2.2, which libdraco decodes where it is built in. Its values have types of glTF,
// and it has no metadata.
Expected<DecodedStream> decode_older_stream(std::span<const uint8_t> stream, const Status& refusal,
                                            OutArrays& out) {
  const OlderStreams* const older = built_in_older_streams();
  const Expected<StreamDescription> description = describe_older(older, stream, refusal);
  if (!description) return description.status();
  Expected<std::vector<AttributeRequest>> requests = gltf_attributes(description->attributes);
  if (!requests) return requests.status();
  DecodedStream decoded;
  decoded.names = names_of(description->attributes, {});
  for (size_t i = 0; i < requests->size(); ++i) (*requests)[i].semantic = decoded.names[i];
  Mesh mesh;
  const Expected<PrimitiveBuffers> buffers =
      buffers_for(description->point_count, description->face_count, *requests, stream.size(), out, mesh);
  if (!buffers) return buffers.status();
  Status status =
      decode_older(*older, stream, *requests, description->point_count, description->face_count, *buffers);
  if (!status.ok()) return status;
  decoded.geometry.coding = description->coding;
  decoded.geometry.point_count = mesh.point_count;
  decoded.geometry.faces = std::move(mesh.faces);
  for (size_t i = 0; i < requests->size(); ++i) {
    decoded.geometry.attributes.push_back({description->attributes[i], std::move(mesh.attributes[i].values)});
    decoded.geometry.attributes[i].description.type = stored_type((*requests)[i].component_type);
  }
  return decoded;
}

// Decodes to the caller's arrays where there are some.
Expected<DecodedStream> decode_stream(std::span<const uint8_t> stream, bool integers, OutArrays& out) {
  DecodedStream decoded;
  Status status =
      decode_geometry(stream, [&](const StreamDescription& description, std::span<const StoredValues> stored) {
        return places_for(description, stored, integers, stream, out, decoded);
      });
  if (status.code() == StatusCode::kUnsupported) return decode_older_stream(stream, status, out);
  if (!status.ok()) return status;
  return decoded;
}

py::object tuple_of(GeometryAttribute&& attribute, const std::string& name, uint32_t point_count,
                    py::object given) {
  const StreamAttribute& description = attribute.description;
  const char* const type = type_code(attribute.type());
  const uint32_t columns = attribute.component_count();
  py::object values =
      given.is_none() ? array_of(std::move(attribute.values), type, point_count, columns) : std::move(given);
  py::object origin = py::none(), range = py::none();
  if (!description.origin.empty()) {
    origin = py::array_t<float>(static_cast<py::ssize_t>(description.origin.size()), description.origin.data());
    range = py::float_(double{description.range});
  }
  return py::make_tuple(name, description.unique_id, std::move(values), description.normalized,
                        int{description.bits}, std::move(origin), std::move(range), attribute.are_integers);
}

py::tuple tuple_of(DecodedStream&& decoded, const OutArrays& out) {
  DracoGeometry& geometry = decoded.geometry;
  py::object faces = out.taken_faces();
  if (faces.is_none()) faces = array_of(std::move(geometry.faces));
  py::list attributes;
  for (size_t i = 0; i < geometry.attributes.size(); ++i) {
    GeometryAttribute& attribute = geometry.attributes[i];
    py::object given = out.taken(decoded.names[i], attribute.description.unique_id);
    attributes.append(tuple_of(std::move(attribute), decoded.names[i], geometry.point_count, std::move(given)));
  }
  return py::make_tuple(coding_name(geometry.coding), geometry.point_count, std::move(faces),
                        std::move(attributes), tuple_of(decoded.metadata));
}

py::tuple decode(const py::object& data, bool quantized, const py::object& out_dict) {
  const HeldBytes held(data);
  OutArrays out(out_dict);
  std::optional<Expected<DecodedStream>> decoded;
  {
    const py::gil_scoped_release release;
    decoded.emplace(decode_stream(held.bytes(), quantized, out));
  }
  return tuple_of(value_or_throw(std::move(*decoded)), out);
}

// A tuple or an exception for each stream.
py::list decode_many(const py::list& data, bool quantized, int thread_count) {
  std::vector<HeldBytes> held;
  held.reserve(data.size());
  for (const py::handle item : data) held.emplace_back(item);
  // Large streams first: a last task that is large would keep one thread busy alone.
  std::vector<size_t> order(held.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return held[a].bytes().size() > held[b].bytes().size(); });
  std::vector<std::optional<Expected<DecodedStream>>> decoded(held.size());
  with_pool(thread_count, [&](const ThreadPool& pool) {
    const py::gil_scoped_release release;
    pool.for_each(held.size(), [&](size_t i) {
      OutArrays none;
      decoded[order[i]].emplace(decode_stream(held[order[i]].bytes(), quantized, none));
    });
  });
  py::list results;
  for (std::optional<Expected<DecodedStream>>& one : decoded)
    results.append(*one ? py::object(tuple_of(std::move(**one), OutArrays())) : exception_of(one->status()));
  return results;
}

using Requested = std::tuple<std::string, uint32_t, int, int, bool>;

AttributeRequest request_of(const Requested& requested) {
  const auto& [semantic, unique_id, component_type, component_count, normalized] = requested;
  const auto type = static_cast<ComponentType>(component_type);
  if (component_bytes(type) == 0)
    throw StatusError{wrong_usage(semantic + " has no component type " + std::to_string(component_type))};
  if (component_count < 1 || component_count > 16)
    throw StatusError{wrong_usage(semantic + " has " + std::to_string(component_count) + " components")};
  return {semantic, unique_id, type, static_cast<uint8_t>(component_count), normalized};
}

py::tuple tuple_of_mesh(Mesh&& mesh, const char* coding, std::span<const AttributeRequest> requests,
                        const OutArrays& out) {
  py::object faces = out.taken_faces();
  if (faces.is_none()) faces = array_of(std::move(mesh.faces));
  py::list attributes;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    Attribute& attribute = mesh.attributes[i];
    std::optional<uint32_t> unique_id;
    if (!requests.empty()) unique_id = requests[i].unique_id;
    py::object values = out.taken(attribute.semantic, unique_id);
    if (values.is_none())
      values = array_of(std::move(attribute.values), type_code(attribute.component_type), mesh.point_count,
                        attribute.component_count);
    attributes.append(py::make_tuple(attribute.semantic, unique_id, std::move(values), attribute.normalized,
                                     py::none(), py::none(), py::none(), false));
  }
  return py::make_tuple(coding, mesh.point_count, std::move(faces), std::move(attributes), py::none());
}

py::tuple decode_primitive(const py::object& data, const std::vector<Requested>& requested, bool is_stock,
                           uint64_t point_count, uint64_t index_count, int thread_count,
                           const py::object& out_dict) {
  const HeldBytes held(data);
  OutArrays out(out_dict);
  PrimitiveSource source{
      held.bytes(), {}, point_count, index_count, is_stock ? Compression::kDraco : Compression::kPatches};
  source.older = built_in_older_streams();
  for (const Requested& attribute : requested) source.attributes.push_back(request_of(attribute));
  Mesh mesh;
  const Status status = with_pool(thread_count, [&](const ThreadPool& pool) -> Status {
    const py::gil_scoped_release release;
    const Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(source);
    if (!primitive) return primitive.status();
    const Expected<PrimitiveBuffers> buffers =
        buffers_for(primitive->point_count(), primitive->face_count(), primitive->attributes(),
                    primitive->bytes().size(), out, mesh);
    if (!buffers) return buffers.status();
    LoadOptions options;
    options.pool = &pool;
    return primitive->decode(*buffers, options);
  });
  throw_if_failed(status);
  return tuple_of_mesh(std::move(mesh), is_stock ? "draco" : "patches", source.attributes, out);
}

}  // namespace

py::tuple tuple_of(Mesh&& mesh, const char* coding) {
  return tuple_of_mesh(std::move(mesh), coding, {}, OutArrays());
}

void add_decode(py::module_& module) {
  module.def("decode", &decode, py::arg("data"), py::arg("quantized"), py::arg("out"));
  module.def("decode_many", &decode_many, py::arg("data"), py::arg("quantized"), py::arg("threads"));
  module.def("decode_primitive", &decode_primitive, py::arg("data"), py::arg("attributes"), py::arg("is_stock"),
             py::arg("point_count"), py::arg("index_count"), py::arg("threads"), py::arg("out"));
  module.def("release_scratch", &release_scratch, py::call_guard<py::gil_scoped_release>());
}

}  // namespace psplit::python
