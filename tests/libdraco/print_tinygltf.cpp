// print_tinygltf FILE.glb: loads an asset by tinygltf with its own decoding of Draco, and prints all bytes of
// its buffers as a number, and its accessors. It is compiled with Debian's tiny_gltf.h, and with a copy whose
// draco::Decoder is a psplit::DracoDecoder: the one change that a program of libdraco needs.
#include <draco/compression/decode.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#if PSPLIT_DECODES
#include "psplit/draco_decoder.h"
#endif

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include PSPLIT_TINYGLTF

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error, warning;
  if (!loader.LoadBinaryFromFile(&model, &error, &warning, argv[1])) {
    std::cerr << argv[1] << ": " << error << "\n";
    return 3;
  }
  for (const tinygltf::Buffer& buffer : model.buffers) {
    uint64_t hash = 14695981039346656037u;  // FNV-1a
    for (const unsigned char byte : buffer.data) hash = (hash ^ byte) * 1099511628211u;
    std::cout << "buffer of " << buffer.data.size() << " bytes: " << hash << "\n";
  }
  for (const tinygltf::Accessor& accessor : model.accessors)
    std::cout << "accessor: view " << accessor.bufferView << " offset " << accessor.byteOffset << " type "
              << accessor.type << "x" << accessor.componentType << " count " << accessor.count << "\n";
}
