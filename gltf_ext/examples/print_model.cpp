// print_model FILE.glb|FILE.gltf: loads an asset with tinygltf, decodes its Draco primitives, in patches or as
// stock KHR_draco_mesh_compression, and prints its contents.
#include <psplit/tinygltf.h>

#include <iostream>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: print_model FILE\n";
    return 1;
  }
  const std::string path = argv[1];
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  loader.SetFsCallbacks(psplit::tinygltf_file_callbacks());
  const bool is_glb = path.size() > 4 && path.compare(path.size() - 4, 4, ".glb") == 0;
  const bool parsed = is_glb ? loader.LoadBinaryFromFile(&model, &error, &warning, path)
                             : loader.LoadASCIIFromFile(&model, &error, &warning, path);
  if (!parsed) {
    std::cerr << path << ": " << error << "\n";
    return 3;
  }
  if (const psplit::Status status = psplit::decode_model(model); !status.ok()) {
    std::cerr << path << ": " << status.to_string() << "\n";
    return 3;
  }

  // From here on the model is a plain one.
  for (const tinygltf::Mesh& mesh : model.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      if (primitive.indices >= 0)
        std::cout << model.accessors.at(static_cast<size_t>(primitive.indices)).count / 3 << " triangles";
      for (const auto& [semantic, index] : primitive.attributes) {
        const tinygltf::Accessor& accessor = model.accessors.at(static_cast<size_t>(index));
        std::cout << ", " << accessor.count << " " << semantic;
        if (semantic != "POSITION" || accessor.bufferView < 0 || accessor.count == 0 ||
            accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
          continue;
        const tinygltf::BufferView& view = model.bufferViews.at(static_cast<size_t>(accessor.bufferView));
        const auto* floats = reinterpret_cast<const float*>(
            &model.buffers.at(static_cast<size_t>(view.buffer)).data.at(view.byteOffset + accessor.byteOffset));
        std::cout << " from (" << floats[0] << ", " << floats[1] << ", " << floats[2] << ")";
      }
      std::cout << "\n";
    }
}
