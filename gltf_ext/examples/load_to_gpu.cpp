// load_to_gpu FILE.glb: decodes an asset's patches into memory of the CUDA device, from which they can be
// drawn. Exits with 5 if there is no device.
#include <psplit/tinygltf.h>

#include <iostream>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: load_to_gpu FILE\n";
    return 1;
  }
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  loader.SetFsCallbacks(psplit::tinygltf_file_callbacks());
  if (!loader.LoadBinaryFromFile(&model, &error, &warning, argv[1])) {
    std::cerr << argv[1] << ": " << error << "\n";
    return 3;
  }
  const psplit::Expected<psplit::DeviceModel> device = psplit::decode_model_to_device(model);
  if (!device) {
    std::cerr << argv[1] << ": " << device.status().to_string() << "\n";
    return device.status().code() == psplit::StatusCode::kUnsupported ? 5 : 3;
  }
  for (const psplit::DevicePrimitive& primitive : device->primitives) {
    std::cout << "mesh " << primitive.mesh << ", primitive " << primitive.primitive << ": "
              << primitive.face_count << " triangles, " << primitive.point_count << " points on the device";
    // A renderer binds `values` and `indices` as they are. This example only looks at the first point.
    for (const psplit::DevicePrimitive::Attribute& attribute : primitive.attributes) {
      if (attribute.request.semantic != "POSITION" || primitive.point_count == 0 ||
          attribute.request.component_type != psplit::ComponentType::kFloat32)
        continue;
      float first[3];
      const psplit::Status status = psplit::CudaMemory::download(attribute.values, first);
      if (!status.ok()) {
        std::cerr << status.to_string() << "\n";
        return 3;
      }
      std::cout << " from (" << first[0] << ", " << first[1] << ", " << first[2] << ")";
    }
    std::cout << "\n";
  }
}
