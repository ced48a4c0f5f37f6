// write_seeds FOLDER: what the fuzzers start from, in FOLDER/core_fuzzer and FOLDER/container_fuzzer.
#include <filesystem>
#include <fstream>
#include <iostream>

#include "encoder/encode_mesh.h"
#include "tests/support/draco_streams.h"
#include "tests/support/procedural_meshes.h"

namespace {

namespace fs = std::filesystem;

void write(const fs::path& folder, size_t number, std::span<const uint8_t> bytes) {
  constexpr size_t kSmall = 4000;
  if (bytes.size() > kSmall) return;
  std::ofstream(folder / std::to_string(number), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_seeds FOLDER\n";
    return 1;
  }
  const fs::path core = fs::path(argv[1]) / "core_fuzzer", container = fs::path(argv[1]) / "container_fuzzer";
  fs::create_directories(core);
  fs::create_directories(container);
  size_t number = 0;
  psplit::for_each_draco_stream([&](const psplit::DracoStream& stream) { write(core, number++, stream.bytes); },
                                psplit::StreamSet::kSmall);
  const psplit::ThreadPool pool;
  for (psplit::NamedMesh& named : psplit::nasty_meshes()) {
    std::erase_if(named.mesh.attributes,
                  [](const auto& attribute) { return attribute.semantic != "POSITION"; });
    std::vector<psplit::AttributeCoding> codings(named.mesh.attributes.size());
    psplit::EncodeOptions options;
    options.patch_count = 4;
    const auto encoded = psplit::encode_mesh(named.mesh, codings, options, pool);
    if (encoded) write(container, number++, encoded->container);
  }
}
