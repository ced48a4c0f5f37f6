// one_patch FILE.glb NUMBER: decodes a single patch of the first mesh, and nothing else. It reads the JSON
// itself, as a loader on top of fastgltf, cgltf or an engine's own parser does.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <psplit/psplit.hpp>

namespace {

int fail(const std::string& message) {
  std::cerr << message << "\n";
  return 3;
}

uint32_t u32(psplit::Span<const uint8_t> bytes, size_t at) {
  uint32_t value = 0;
  if (at + 4 <= bytes.size()) std::memcpy(&value, &bytes[at], 4);
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage: one_patch FILE.glb NUMBER");
  std::ifstream stream(argv[1], std::ios::binary);
  const std::vector<uint8_t> file{std::istreambuf_iterator<char>(stream), {}};
  // A GLB has a header of 12 bytes, and then the JSON and the buffer, each after 8 bytes of its own.
  const size_t json_bytes = u32(file, 12), buffer_at = 20 + json_bytes + 8;
  if (u32(file, 0) != 0x46546C67 || buffer_at > file.size()) return fail("not a GLB file");
  const nlohmann::json json = nlohmann::json::parse(&file[20], &file[20 + json_bytes], nullptr, false);

  psplit::PrimitiveSource source;
  try {
    const nlohmann::json& primitive = json.at("meshes").at(0).at("primitives").at(0);
    const nlohmann::json& extension = primitive.at("extensions").at("PSPLIT_mesh_draco_patches");
    const nlohmann::json& view = json.at("bufferViews").at(extension.at("bufferView").get<size_t>());
    const size_t offset = view.value("byteOffset", size_t{0}), bytes = view.at("byteLength").get<size_t>();
    if (offset > file.size() - buffer_at || bytes > file.size() - buffer_at - offset)
      return fail("the buffer view leaves the file");
    source.bytes = psplit::Span<const uint8_t>(file).subspan(buffer_at + offset, bytes);
    // Only positions: attributes that are not requested are not written.
    source.attributes = {{"POSITION", extension.at("attributes").at("POSITION").get<uint32_t>()}};
  } catch (const nlohmann::json::exception& error) {
    return fail(error.what());
  }

  const psplit::Expected<psplit::CompressedPrimitive> primitive = psplit::CompressedPrimitive::open(source);
  if (!primitive) return fail(primitive.status().to_string());
  const auto number = static_cast<uint32_t>(std::strtoul(argv[2], nullptr, 10));
  if (number >= primitive->patch_count())
    return fail("there are " + std::to_string(primitive->patch_count()) + " patches");
  const psplit::PatchSizes sizes = primitive->patch(number);
  std::vector<uint32_t> indices(size_t{3} * sizes.face_count);
  std::vector<float> positions(size_t{3} * sizes.point_count);
  const psplit::Status status = primitive->decode_patch(number, {indices, 4, {{positions}}});
  if (!status.ok()) return fail(status.to_string());

  std::cout << "patch " << number << " of " << primitive->patch_count() << ": " << sizes.face_count
            << " triangles, " << sizes.point_count << " points, largest index "
            << (indices.empty() ? 0 : *std::max_element(indices.begin(), indices.end()));
  if (sizes.point_count > 0)
    std::cout << ", from (" << positions[0] << ", " << positions[1] << ", " << positions[2] << ")";
  std::cout << "\n";
}
