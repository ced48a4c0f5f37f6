#include "gltf_ext/out_of_core/spooled_mesh.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/files/operating_system.h"

namespace psplit {
namespace {

// Gives the memory of the first `bytes` back in large steps.
class ReleasedInSteps {
 public:
  void written(std::span<std::byte> column, size_t bytes) {
    if (bytes - released_ < kReleaseStep && bytes < column.size()) return;
    release_mapped({reinterpret_cast<const uint8_t*>(column.data()) + released_, bytes - released_});
    released_ = bytes;
  }

 private:
  size_t released_ = 0;
};

Status write_points(const MeshSpool& spool, const LaidOutMesh& mesh) {
  const std::vector<Attribute>& attributes = spool.attributes();
  std::vector<ReleasedInSteps> released(attributes.size());
  const size_t record = spool.record_bytes();
  std::vector<uint8_t> repaired;
  return spool.for_each_point([&](uint64_t first, std::span<const uint8_t> records) -> Status {
    const size_t count = records.size() / record;
    if (spool.is_soup()) {
      repaired.assign(records.begin(), records.end());
      spool.repair_soup(repaired, std::vector<uint8_t>(count, 1));
      records = repaired;
    }
    size_t offset = 0;
    for (size_t i = 0; i < attributes.size(); ++i) {
      const size_t width = attributes[i].stride(), stride = mesh.buffers.attributes[i].stride;
      const std::span<std::byte> column = mesh.buffers.attributes[i].bytes;
      for (size_t k = 0; k < count; ++k)
        std::memcpy(column.data() + (static_cast<size_t>(first) + k) * stride,
                    records.data() + k * record + offset, width);
      released[i].written(column, (static_cast<size_t>(first) + count) * stride);
      offset += width;
    }
    return {};
  });
}

Status write_faces(const MeshSpool& spool, const LaidOutMesh& mesh) {
  const std::span<std::byte> column = mesh.buffers.indices;
  const size_t width = mesh.buffers.index_bytes;
  ReleasedInSteps released;
  size_t end = 0;
  const auto write = [&](const Face& face) {
    for (const uint32_t point : face) {
      std::memcpy(column.data() + end, &point, width);  // little-endian, as glTF
      end += width;
    }
    released.written(column, end);
  };
  if (!spool.is_soup())
    return spool.for_each_face([&](std::span<const Face> block) -> Status {
      for (const Face& face : block) write(face);
      return {};
    });
  for (uint32_t i = 0; i < spool.face_count(); ++i) write({3 * i, 3 * i + 1, 3 * i + 2});
  return {};
}

}  // namespace

Expected<MeshInFile> lay_out_spool(const MeshSpool& spool, const std::filesystem::path& folder) {
  if (spool.point_count() >= UINT32_MAX || 3 * spool.face_count() > UINT32_MAX)
    return unsupported("has more points or indices than an accessor can count");
  const auto points = static_cast<uint32_t>(spool.point_count()),
             faces = static_cast<uint32_t>(spool.face_count());
  std::vector<AttributeRequest> requests;
  for (const Attribute& a : spool.attributes())
    requests.push_back({a.semantic, 0, a.component_type, a.component_count, a.normalized});
  Expected<MeshInFile> mesh = lay_out_in_file(requests, points, faces, folder);
  if (!mesh) return mesh;
  Status status = write_points(spool, mesh->laid_out);
  if (status.ok()) status = write_faces(spool, mesh->laid_out);
  if (!status.ok()) return status;
  return mesh;
}

}  // namespace psplit
