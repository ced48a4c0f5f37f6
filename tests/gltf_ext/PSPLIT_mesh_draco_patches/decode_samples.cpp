// decode_samples ASSET FOLDER: decodes every primitive of an asset that has the extension, with nothing but the
// decoder's library, and writes what decode_samples.py compares: FOLDER/<mesh>.<primitive>.<indices or
// attribute>. Exits with 1 where a patch decoded alone is not what its stream is as stock Draco.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#ifdef PSPLIT_HAS_ENCODER
#include "encoder/fields/expand_container.h"
#endif
#include "psplit/decode.h"
#include "psplit/loader.h"
#include "src/container/patch_container.h"

namespace {

using namespace psplit;  // a program, not a library
namespace fs = std::filesystem;
using Json = nlohmann::json;
using Bytes = std::vector<uint8_t>;

[[noreturn]] void fail(const std::string& why) {
  std::cerr << "decode_samples: " << why << "\n";
  std::exit(1);
}

Bytes read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const fs::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) fail("cannot write " + path.string());
}

struct Asset {
  Json json;
  std::vector<Bytes> buffers;

  explicit Asset(const fs::path& path) {
    const Bytes file = read(path);
    const auto u32 = [&](size_t at) {
      uint32_t value = 0;
      std::memcpy(&value, &file.at(at), 4);
      return value;
    };
    if (path.extension() == ".glb") {
      const size_t json_bytes = u32(12);
      json = Json::parse(&file.at(20), &file.at(20) + json_bytes);
      buffers.emplace_back(file.begin() + static_cast<std::ptrdiff_t>(28 + json_bytes), file.end());
      return;
    }
    json = Json::parse(file);
    for (const Json& buffer : json.at("buffers"))
      buffers.push_back(read(path.parent_path() / buffer.at("uri").get<std::string>()));
  }

  std::span<const uint8_t> view(size_t number) const {
    const Json& view = json.at("bufferViews").at(number);
    return std::span(buffers.at(view.at("buffer").get<size_t>()))
        .subspan(view.value("byteOffset", size_t{0}), view.at("byteLength").get<size_t>());
  }

  PrimitiveSource source(const Json& primitive) const {
    const Json& extension = primitive.at("extensions").at("PSPLIT_mesh_draco_patches");
    PrimitiveSource source;
    source.bytes = view(extension.at("bufferView").get<size_t>());
    const auto add = [&](const std::string& name, const Json& id, const Json& index) {
      const Json& accessor = json.at("accessors").at(index.get<size_t>());
      const std::string type = accessor.at("type").get<std::string>();
      source.attributes.push_back({name, id.get<uint32_t>(),
                                   static_cast<ComponentType>(accessor.at("componentType").get<int>()),
                                   static_cast<uint8_t>(type == "SCALAR" ? 1 : type.back() - '0'),
                                   accessor.value("normalized", false)});
      source.point_count = accessor.at("count").get<uint64_t>();
    };
    for (const auto& [semantic, id] : extension.at("attributes").items())
      add(semantic, id, primitive.at("attributes").at(semantic));
    if (!extension.contains("targets")) return source;
    for (const auto& [semantic, ids] : extension.at("targets").items())
      for (size_t t = 0; t < ids.size(); ++t)
        if (ids.at(t) != -1)
          add(name_of_target(t, semantic), ids.at(t), primitive.at("targets").at(t).at(semantic));
    return source;
  }
};

struct Arrays {
  std::vector<std::byte> indices;
  std::vector<std::vector<std::byte>> values;

  PrimitiveBuffers sized(const std::vector<AttributeRequest>& requests, uint32_t points, uint32_t faces) {
    indices.resize(size_t{12} * faces);
    PrimitiveBuffers out{indices, 4, {}};
    values.resize(requests.size());
    for (size_t k = 0; k < requests.size(); ++k) {
      values[k].resize(component_bytes(requests[k].component_type) * requests[k].component_count * points);
      out.attributes.push_back({values[k], 0});
    }
    return out;
  }
  bool operator==(const Arrays&) const = default;
};

void expect(const Status& status) {
  if (!status.ok()) fail(status.to_string());
}

// The Draco stream of a patch. The encoder expands a condensed one; without it, such a patch has none.
Expected<Bytes> draco_stream(const PatchContainer& container, uint32_t patch) {
#ifdef PSPLIT_HAS_ENCODER
  return expand_patch(container, patch);
#else
  const std::span<const uint8_t> stream = container.streams[patch];
  return container.entries[patch].is_condensed ? Bytes() : Bytes(stream.begin(), stream.end());
#endif
}

// Each stream alone, as a patch and as stock Draco.
void check_streams(const CompressedPrimitive& primitive) {
  for (uint32_t n = 0; n < primitive.patch_count(); ++n) {
    const PatchSizes sizes = primitive.patch(n);
    Arrays patch, stock;
    expect(primitive.decode_patch(n, patch.sized(primitive.attributes(), sizes.point_count, sizes.face_count)));
    const Expected<Bytes> draco = draco_stream(primitive.container(), n);
    expect(draco.status());
    if (draco->empty()) continue;
    const Expected<CompressedPrimitive> stream =
        CompressedPrimitive::open({*draco, primitive.attributes(), 0, 0, Compression::kDraco});
    expect(stream.status());
    expect(stream->decode(stock.sized(primitive.attributes(), stream->point_count(), stream->face_count())));
    stock.indices.resize(std::min(stock.indices.size(), patch.indices.size()));  // of a residue
    if (!(stock == patch)) fail("stream " + std::to_string(n) + " is not what its patch is");
    const Expected<Mesh> whole = decode_draco(*draco);
    expect(whole.status());
    if (whole->point_count != sizes.point_count) fail("decode_draco: other points");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) fail("usage: decode_samples ASSET FOLDER");
  const Asset asset(argv[1]);
  for (size_t m = 0; m < asset.json.at("meshes").size(); ++m) {
    // The primitives of the mesh's extension replace coarse ones.
    const Json& mesh = asset.json.at("meshes").at(m);
    const auto path = Json::json_pointer("/extensions/PSPLIT_mesh_draco_patches/primitives");
    const Json& primitives = mesh.contains(path) ? mesh.at(path) : mesh.at("primitives");
    for (size_t p = 0; p < primitives.size(); ++p) {
      const Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(asset.source(primitives.at(p)));
      expect(primitive.status());
      Arrays arrays;
      expect(primitive->decode(
          arrays.sized(primitive->attributes(), primitive->point_count(), primitive->face_count())));
      check_streams(*primitive);
      const std::string name = std::to_string(m) + "." + std::to_string(p) + ".";
      write(fs::path(argv[2]) / (name + "indices"), arrays.indices);
      for (size_t k = 0; k < arrays.values.size(); ++k) {
        std::string semantic = primitive->attributes()[k].semantic;
        std::replace(semantic.begin(), semantic.end(), '/', '.');  // names of targets
        write(fs::path(argv[2]) / (name + semantic), arrays.values[k]);
      }
    }
  }
} catch (const std::exception& error) {
  fail(error.what());
}
