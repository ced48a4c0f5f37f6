#include "gltf_ext/primitive/mesh_view.h"

#include <cstring>
#include <memory>

#include "gltf_ext/json/json.h"

namespace psplit {
namespace {

ValuesView values_of(const AttributeRequest& request, uint32_t count) {
  return {request.component_type, request.component_count, request.normalized, count, {}, 0};
}

}  // namespace

MeshView view_of(const Mesh& mesh) {
  MeshView view;
  view.point_count = mesh.point_count;
  for (const Attribute& attribute : mesh.attributes)
    view.attributes.push_back({attribute.semantic,
                               {attribute.component_type, attribute.component_count, attribute.normalized,
                                mesh.point_count, attribute.values}});
  view.indices = {ComponentType::kUint32, 1, false, static_cast<uint32_t>(mesh.faces.size() * 3),
                  std::as_bytes(std::span(mesh.faces))};
  return view;
}

IndexData::IndexData(const Mesh& mesh) : values_(view_of(mesh).indices) {
  if (index_type(mesh.point_count) != ComponentType::kUint16) return;
  narrow_.resize(size_t{values_.count} * sizeof(uint16_t));
  values_.component_type = ComponentType::kUint16;
  values_.bytes = narrow_;
  std::byte* out = narrow_.data();
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) {
      const auto low = static_cast<uint16_t>(point);
      std::memcpy(out, &low, sizeof low);
      out += sizeof low;
    }
}

Json append_primitive(Document& document, Mesh mesh, bool are_points) {
  Json attributes = Json::object();
  for (Attribute& attribute : mesh.attributes) {
    const auto values = std::make_shared<const Array<std::byte>>(std::move(attribute.values));
    const ValuesView data{attribute.component_type, attribute.component_count, attribute.normalized,
                          mesh.point_count, *values};
    attributes[attribute.semantic] =
        append_accessor(document, data, kArrayBuffer, attribute.semantic == "POSITION", values);
  }
  if (are_points) return {{"attributes", std::move(attributes)}, {"mode", kPointsMode}};
  const auto faces = std::make_shared<const Mesh>(std::move(mesh));
  const IndexData indices(*faces);
  const int64_t accessor =
      append_accessor(document, indices, kElementArrayBuffer, false, indices.are_narrow() ? nullptr : faces);
  return {{"attributes", std::move(attributes)}, {"indices", accessor}};
}

LaidOutMesh lay_out(std::span<const AttributeRequest> requests, uint32_t point_count, uint32_t face_count,
                    uint64_t begin, std::span<uint8_t> memory) {
  LaidOutMesh mesh;
  mesh.end = begin;
  const auto place = [&](uint64_t bytes) {
    const uint64_t offset = (mesh.end + 3) / 4 * 4;
    mesh.offsets.push_back(offset);
    mesh.end = offset + bytes;
    return memory.empty() ? std::span<std::byte>()
                          : std::as_writable_bytes(
                                memory.subspan(static_cast<size_t>(offset), static_cast<size_t>(bytes)));
  };
  mesh.view.point_count = point_count;
  for (const AttributeRequest& request : requests) {
    ValuesView values = values_of(request, point_count);
    values.stride = stored_stride(values, kArrayBuffer);
    const std::span<std::byte> bytes = place(uint64_t{point_count} * values.stride);
    values.bytes = bytes;
    mesh.view.attributes.push_back({request.semantic, values});
    mesh.buffers.attributes.push_back({bytes, values.stride});
  }
  ValuesView indices{index_type(point_count), 1, false, face_count * 3, {}, 0};
  mesh.buffers.index_bytes = static_cast<uint32_t>(indices.value_bytes());
  mesh.buffers.indices = place(uint64_t{indices.count} * indices.value_bytes());
  indices.bytes = mesh.buffers.indices;
  mesh.view.indices = indices;
  return mesh;
}

Expected<MeshInFile> lay_out_in_file(std::span<const AttributeRequest> requests, uint32_t point_count,
                                     uint32_t face_count, const std::filesystem::path& folder) {
  const uint64_t bytes = lay_out(requests, point_count, face_count, 0, {}).end;
  const Expected<FileMemory> memory = FileMemory::create(folder, bytes);
  if (!memory) return memory.status();
  return MeshInFile{*memory, lay_out(requests, point_count, face_count, 0, memory->bytes())};
}

bool is_written_as_stored(const AttributeRequest& request) {
  const std::optional<ElementLayout> layout = layout_of(request.component_type, request.component_count);
  return layout && layout->packed_bytes() == layout->stored_bytes();
}

}  // namespace psplit
