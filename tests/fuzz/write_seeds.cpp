// write_seeds FOLDER: writes the seeds of each fuzzer into a folder of its own.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>

#include "encoder/encode_mesh.h"
#include "gltf_ext/json/json.h"
#include "gltf_ext/primitive/accessors.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "src/container/patch_container.h"
#include "tests/support/document_options.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/draco_streams.h"
#include "tests/support/mesh_file_seeds.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"

namespace {

namespace fs = std::filesystem;

void write(const fs::path& folder, size_t number, std::span<const uint8_t> bytes) {
  constexpr size_t kSmall = 4000;
  if (bytes.size() > kSmall) return;
  std::ofstream(folder / std::to_string(number), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// One small asset in every form: plain, in patches, as stock Draco, with a sparse morph target, in
// condensed patches, with a morph target in patches, as points that meshoptimizer's extensions compress; as
// .glb and as .gltf.
void write_documents(const fs::path& folder, const psplit::ThreadPool& pool) {
  using psplit::Json;
  const psplit::Mesh mesh = psplit::make_grid(4, 4);
  for (int form = 0; form < 8; ++form) {
    // Patches of the smallest mesh would not get smaller.
    psplit::Document document =
        psplit::document_from_mesh(form == 4 || form >= 6 ? psplit::make_grid(12, 12) : mesh);
    if (form == 1)
      (void)psplit::encode_document(document, psplit::DocumentOptions{.patches = {.count = 2, .always = true}},
                                    psplit::draco_backend(), pool);
    if (form == 2) (void)psplit::encode_document_stock(document, {}, pool);
    if (form == 3 || form == 5) {
      psplit::AccessorData data{psplit::ComponentType::kFloat32, 3, false, mesh.point_count,
                                mesh.attributes[0].values};
      std::fill(data.values.begin() + 12, data.values.end(), std::byte{0});
      Json accessor = psplit::describe_stored(data);
      psplit::store_values_sparse(document, accessor, data, 34962);
      document.json()["accessors"].push_back(accessor);
      document.json()["meshes"][0]["primitives"][0]["targets"] =
          Json::array({{{"POSITION", document.json()["accessors"].size() - 1}}});
    }
    if (form == 5)
      (void)psplit::encode_document(document, psplit::DocumentOptions{.patches = {.count = 2, .always = true}},
                                    psplit::draco_backend(), pool);
    if (form == 4)
      (void)psplit::encode_document(
          document, psplit::DocumentOptions{.patches = {.count = 3, .always = true}, .condense = true},
          psplit::draco_backend(), pool);
    if (form >= 6) {
      document.json()["meshes"][0]["primitives"][0]["mode"] = 0;
      const auto meshopt = form == 6 ? psplit::MeshoptRest::kExt : psplit::MeshoptRest::kKhr;
      (void)psplit::encode_document(document, psplit::DocumentOptions{.lossless = true, .meshopt = meshopt},
                                    psplit::draco_backend(), pool);
    }
    (void)psplit::write_document(document, folder / (std::to_string(form) + ".glb"));
    // A .gltf whose bytes are in a data URI without base64.
    Json json = document.json();
    constexpr const char* kHex = "0123456789abcdef";
    std::string uri = "data:,";
    for (const uint8_t byte : document.buffers[0].bytes()) {
      uri += '%';
      uri += kHex[byte >> 4];
      uri += kHex[byte & 15];
    }
    json["buffers"][0]["uri"] = uri;
    std::ofstream(folder / (std::to_string(form) + ".gltf")) << json.dump();
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_seeds FOLDER\n";
    return 1;
  }
  const fs::path folder = argv[1], core = folder / "core_fuzzer", cloud = folder / "cloud_fuzzer",
                 container = folder / "container_fuzzer", expand = folder / "expand_fuzzer",
                 document = folder / "document_fuzzer", mesh_file = folder / "mesh_file_fuzzer",
                 mesh = folder / "mesh_fuzzer";
  for (const fs::path& path : {core, cloud, container, expand, document, mesh_file, mesh})
    fs::create_directories(path);
  size_t number = 0;
  for (const psplit::DracoStream& stream : psplit::small_draco_streams()) write(core, number++, stream.bytes);
  for (const psplit::DracoStream& stream : psplit::small_draco_clouds()) write(cloud, number++, stream.bytes);
  // The first byte selects a name.
  for (std::string seed : psplit::mesh_file_seeds()) {
    seed.insert(0, 1, static_cast<char>(number % 4));
    write(mesh_file, number++, {reinterpret_cast<const uint8_t*>(seed.data()), seed.size()});
  }
  // Each byte is a choice.
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    std::vector<uint8_t> choices(300);
    for (uint8_t& choice : choices) choice = static_cast<uint8_t>(random());
    write(mesh, number++, choices);
  }
  const psplit::ThreadPool pool;
  write_documents(document, pool);
  for (psplit::NamedMesh named : psplit::nasty_meshes()) {
    std::erase_if(named.mesh.attributes,
                  [](const auto& attribute) { return attribute.semantic != "POSITION"; });
    std::vector<psplit::AttributeCoding> codings(named.mesh.attributes.size());
    psplit::StreamOptions options;
    options.patch_count = 4;
    const auto encoded = psplit::encode_mesh(named.mesh, codings, options, pool);
    if (!encoded) continue;
    write(container, number++, encoded->pieces[0].bytes);
    const std::vector<uint8_t> condensed =
        psplit::condensed_container(*psplit::open_container(encoded->pieces[0].bytes), number % 2 == 0, pool);
    write(container, number++, condensed);
    write(expand, number++, condensed);
  }
}
