#include "tools/gltf_psplit/preview/picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/gltf_psplit/preview/visibility.h"

namespace psplit {
namespace {

constexpr int kSamples = 2;  // per pixel, in each direction
constexpr size_t kGrain = 4096;
constexpr double kLargest = 1e30;  // limit of coordinates, so that their fourth powers are finite
// A normal further than 40 degrees from the normal of its face belongs to a crease whose faces share the point.
constexpr double kCrease = 0.77;
// The normal of a face of less height, in samples, may be noise; then the normals of its points are used.
constexpr double kSliver = 3 * kSamples;

Vec3 widen(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

// The faces of all instances, numbered one after the other.
class Drawing {
 public:
  Drawing(std::span<const PictureMesh> meshes, std::span<const MeshInstance> instances)
      : meshes_(meshes), instances_(instances) {
    for (const MeshInstance& instance : instances)
      first_face_.push_back(first_face_.back() + meshes[instance.mesh].faces.size());
  }

  uint64_t face_count() const { return first_face_.back(); }

  struct Face {
    const PictureMesh& mesh;
    const Transform& to_world;
    size_t number;  // in the mesh
    const std::array<uint32_t, 3>& points() const { return mesh.faces[number]; }
    std::array<Vec3, 3> corners() const {
      const auto [a, b, c] = points();
      return {to_world.point(widen(mesh.positions[a])), to_world.point(widen(mesh.positions[b])),
              to_world.point(widen(mesh.positions[c]))};
    }
  };
  Face face(uint64_t number) const {
    const auto next = std::ranges::upper_bound(first_face_, number);
    const MeshInstance& instance = instances_[static_cast<size_t>(next - first_face_.begin()) - 1];
    return {meshes_[instance.mesh], instance.to_world, static_cast<size_t>(number - *(next - 1))};
  }

  // Calls body(number, corners in the world) for each finite face of [begin, end).
  template <typename Body>
  void for_faces(uint64_t begin, uint64_t end, const Body& body) const {
    while (begin < end) {
      Face at = face(begin);
      for (; begin < end && at.number < at.mesh.faces.size(); ++begin, ++at.number) {
        const std::array<Vec3, 3> corners = at.corners();
        const bool finite = std::ranges::all_of(corners, [](Vec3 p) {
          return std::abs(p.x) < kLargest && std::abs(p.y) < kLargest && std::abs(p.z) < kLargest;
        });
        if (finite) body(static_cast<uint32_t>(begin), corners);
      }
    }
  }

 private:
  std::span<const PictureMesh> meshes_;
  std::span<const MeshInstance> instances_;
  std::vector<uint64_t> first_face_{0};
};

Camera frame(const Drawing& drawing, ImageSize size, const ThreadPool& pool) {
  std::vector<Framing> parts((drawing.face_count() + kGrain - 1) / kGrain, Framing(size));
  pool.for_ranges(drawing.face_count(), kGrain, [&](size_t begin, size_t end) {
    drawing.for_faces(begin, end, [&](uint32_t, const std::array<Vec3, 3>& corners) {
      for (const Vec3 corner : corners) parts[begin / kGrain].add(corner);
    });
  });
  Framing whole(size);
  for (const Framing& part : parts) whole.add(part);
  return whole.camera();
}

// v scaled to length 1, or `otherwise` if v has no direction.
Vec3 direction(Vec3 v, Vec3 otherwise) {
  const double size = length(v);
  return std::isnormal(size) ? v * (1 / size) : otherwise;
}

// The colour of one face at any of its samples.
class FaceShader {
 public:
  FaceShader(const Drawing::Face& face, const Camera& camera) : camera_(camera) {
    const std::array<Vec3, 3> corners = face.corners();
    Vec3 flat = direction(cross(corners[1] - corners[0], corners[2] - corners[0]), camera.back);
    for (size_t i = 0; i < 3; ++i) {
      const ScreenPoint place = camera.project(corners[i]);
      screen_[i] = {place.x, place.y, 0};
      normals_[i] = direction(face.to_world.normal(widen(face.mesh.normals[face.points()[i]])), flat);
    }
    if (height() < kSliver) flat = direction(normals_[0] + normals_[1] + normals_[2], flat);
    const bool seen_from_behind = dot(flat, camera.eye - corners[0]) < 0;
    for (Vec3& normal : normals_) {
      if (dot(normal, flat) < kCrease) normal = flat;
      if (seen_from_behind) normal = normal * -1;
    }
    const auto patch = std::ranges::upper_bound(face.mesh.patch_end, face.number) - face.mesh.patch_end.begin();
    color_ = face.mesh.patch_color[static_cast<size_t>(patch)];
  }

  Color at(double x, double y) const {
    // Interpolates linearly on the screen, without perspective. Faces are so small that the difference is
    // invisible.
    const Vec3 p = Vec3{x, y, 0} - screen_[0], b = screen_[1] - screen_[0], c = screen_[2] - screen_[0];
    const double area = cross(b, c).z, of_b = cross(p, c).z / area, of_c = cross(b, p).z / area;
    const Vec3 normal =
        direction(normals_[0] * (1 - of_b - of_c) + normals_[1] * of_b + normals_[2] * of_c, camera_.back);
    // The light is a lamp over the viewer's left shoulder, and a sky.
    const Vec3 lamp = camera_.back * 0.76 + camera_.up * 0.48 - camera_.right * 0.43;
    const double sky = 0.5 + 0.5 * dot(normal, camera_.up);
    return color_ * (0.16 + 0.2 * sky + 0.74 * std::max(0.0, dot(normal, lamp)));
  }

 private:
  // The height over the longest side, in samples.
  double height() const {
    const auto [a, b, c] = screen_;
    return std::abs(cross(b - a, c - a).z) / std::max({length(b - a), length(c - b), length(a - c)});
  }

  const Camera& camera_;
  std::array<Vec3, 3> screen_;  // without depth
  std::array<Vec3, 3> normals_;
  Color color_;
};

uint8_t to_srgb(double linear) {
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<uint8_t>(std::lround(255 * std::clamp(encoded, 0.0, 1.0)));
}

void shade_row(const Drawing& drawing, const Camera& camera, const VisibilityBuffer& visible, int row,
               ImageSize size, uint8_t* out) {
  std::optional<FaceShader> shader;
  uint32_t shaded = kNoFace;  // the face of `shader`, which adjacent samples often share
  for (int column = 0; column < size.width; ++column, out += 4) {
    Color sum;
    int covered = 0;
    for (int y = row * kSamples; y < (row + 1) * kSamples; ++y)
      for (int x = column * kSamples; x < (column + 1) * kSamples; ++x) {
        const uint32_t face = visible.face_at(x, y);
        if (face == kNoFace) continue;
        if (face != shaded) shader.emplace(drawing.face(face), camera);
        shaded = face;
        sum = sum + shader->at(x + 0.5, y + 0.5);
        ++covered;
      }
    if (covered == 0) continue;
    sum = sum * (1.0 / covered);
    out[0] = to_srgb(sum.x);
    out[1] = to_srgb(sum.y);
    out[2] = to_srgb(sum.z);
    out[3] = static_cast<uint8_t>(255 * covered / (kSamples * kSamples));
  }
}

}  // namespace

Expected<Image> draw_picture(std::span<const PictureMesh> meshes, std::span<const MeshInstance> instances,
                             ImageSize size, const ThreadPool& pool) {
  const Drawing drawing(meshes, instances);
  if (drawing.face_count() == 0) return unsupported("nothing to draw: the scene has no triangles");
  if (drawing.face_count() >= kNoFace) return unsupported("too many triangles to draw: 2^32 - 1 or more");

  const ImageSize sample_size{size.width * kSamples, size.height * kSamples};
  const Camera camera = frame(drawing, sample_size, pool);
  VisibilityBuffer visible(sample_size);
  pool.for_ranges(drawing.face_count(), kGrain, [&](size_t begin, size_t end) {
    drawing.for_faces(begin, end, [&](uint32_t number, const std::array<Vec3, 3>& corners) {
      visible.draw({camera.project(corners[0]), camera.project(corners[1]), camera.project(corners[2])},
                   number);
    });
  });

  const size_t row_bytes = static_cast<size_t>(size.width) * 4;
  Image image{size, std::vector<uint8_t>(row_bytes * static_cast<size_t>(size.height))};
  pool.for_each(static_cast<size_t>(size.height), [&](size_t row) {
    shade_row(drawing, camera, visible, static_cast<int>(row), size, image.rgba.data() + row * row_bytes);
  });
  if (std::ranges::all_of(image.rgba, [](uint8_t byte) { return byte == 0; }))
    return unsupported("nothing to draw: no triangle has an area");
  return image;
}

}  // namespace psplit
