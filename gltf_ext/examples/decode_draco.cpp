// decode_draco FILE.drc: decodes a stock Draco mesh stream, and prints its contents. KHR_draco_mesh_compression
// stores the same streams: print_model is an example with tinygltf, and <psplit/loader.h> decodes many
// of them at once into the caller's memory.
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <psplit/psplit.hpp>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: decode_draco FILE.drc\n";
    return 1;
  }
  std::ifstream stream(argv[1], std::ios::binary);
  const std::vector<uint8_t> file{std::istreambuf_iterator<char>(stream), {}};
  const psplit::Expected<psplit::Mesh> mesh = psplit::decode_draco(file);
  if (!mesh) {
    std::cerr << argv[1] << ": " << mesh.status().to_string() << "\n";
    return 3;
  }
  std::cout << mesh->faces.size() << " triangles, " << mesh->point_count << " points:";
  for (const psplit::Attribute& attribute : mesh->attributes) std::cout << " " << attribute.semantic;
  const psplit::Attribute* positions = mesh->find("POSITION");
  if (positions != nullptr && mesh->point_count > 0) {
    float first[3];
    std::memcpy(first, positions->values.data(), sizeof(first));
    std::cout << " from (" << first[0] << ", " << first[1] << ", " << first[2] << ")";
  }
  std::cout << "\n";
}
