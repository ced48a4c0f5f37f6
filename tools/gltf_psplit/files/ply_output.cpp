#include "tools/gltf_psplit/files/ply_output.h"

#include <bit>
#include <cstdio>
#include <cstring>

#include "gltf_ext/files/files.h"
#include "gltf_ext/mesh_files/write_mesh_file.h"

namespace psplit {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr size_t kFaceBytes = 1 + 3 * sizeof(int32_t);

std::string header_text(const ShapeStream& shape, bool normals) {
  std::string properties;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    if (normals || name[0] != 'n') properties += std::string("property float ") + name + "\n";
  return ply_header_text(shape.point_count(), properties, shape.face_count());
}

// Two regions of the file that grow: the points, and the faces behind all points.
class PlyWriter {
 public:
  PlyWriter(std::FILE* file, uint64_t points_at, uint64_t faces_at)
      : file_(file), points_at_(points_at), faces_at_(faces_at) {}

  bool append(const ShapePiece& piece) { return append_points(piece) && append_faces(piece); }

 private:
  bool append_points(const ShapePiece& piece) {
    constexpr size_t kVector = 3 * sizeof(float);
    if (piece.normals.empty())
      return write(points_at_, piece.positions.data(), piece.positions.size() * kVector);
    bytes_.resize(piece.positions.size() * 2 * kVector);
    uint8_t* to = bytes_.data();
    for (size_t i = 0; i < piece.positions.size(); ++i, to += 2 * kVector) {
      std::memcpy(to, piece.positions[i].data(), kVector);
      std::memcpy(to + kVector, piece.normals[i].data(), kVector);
    }
    return write(points_at_, bytes_.data(), bytes_.size());
  }

  bool append_faces(const ShapePiece& piece) {
    bytes_.resize(piece.faces.size() * kFaceBytes);
    uint8_t* to = bytes_.data();
    for (const auto& face : piece.faces) {
      *to = 3;
      std::memcpy(to + 1, face.data(), kFaceBytes - 1);
      to += kFaceBytes;
    }
    return write(faces_at_, bytes_.data(), bytes_.size());
  }

  bool write(uint64_t& at, const void* bytes, size_t size) {
    if (std::fseek(file_, static_cast<long>(at), SEEK_SET) != 0) return false;
    at += size;
    return std::fwrite(bytes, 1, size, file_) == size;
  }

  std::FILE* file_;
  uint64_t points_at_, faces_at_;
  Array<uint8_t> bytes_;
};

}  // namespace

Status write_ply(const std::string& path, const ShapeStream& shape, bool normals, const ThreadPool& pool,
                 const Progress& progress, IfReadOnly if_read_only) {
  const std::string header = header_text(shape, normals);
  const uint64_t point_bytes = (normals ? 6 : 3) * sizeof(float);
  const auto write = [&](std::FILE* file) {
    if (std::fwrite(header.data(), 1, header.size(), file) != header.size()) return false;
    PlyWriter writer(file, header.size(), header.size() + shape.point_count() * point_bytes);
    uint64_t done = 0;
    const auto take = [&](ShapePiece&& piece) {
      if (!writer.append(piece)) return io_failure("cannot write");
      done += piece.faces.size();
      if (progress) progress(done, shape.face_count());
      return Status();
    };
    return shape.read(pool, take).ok();
  };
  return write_file(path, write, if_read_only);
}

}  // namespace psplit
