// decode_with_libdraco FILE.drc: decodes into libdraco's own classes, for a program that uses them already.
// Only the type of the decoder is not libdraco's.
#include <psplit/draco_decoder.h>

#include <fstream>
#include <iostream>
#include <iterator>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: decode_with_libdraco FILE.drc\n";
    return 1;
  }
  std::ifstream stream(argv[1], std::ios::binary);
  const std::vector<char> file{std::istreambuf_iterator<char>(stream), {}};
  draco::DecoderBuffer buffer;
  buffer.Init(file.data(), file.size());
  psplit::DracoDecoder decoder;
  const draco::StatusOr<std::unique_ptr<draco::Mesh>> decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    std::cerr << argv[1] << ": " << decoded.status().error_msg() << "\n";
    return 3;
  }
  const draco::Mesh& mesh = *decoded.value();
  std::cout << mesh.num_faces() << " triangles, " << mesh.num_points() << " points";
  if (const draco::PointAttribute* positions = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION)) {
    float first[3];
    positions->GetMappedValue(draco::PointIndex(0), first);
    std::cout << " from (" << first[0] << ", " << first[1] << ", " << first[2] << ")";
  }
  std::cout << "\n";
}
