// Small assets for the tests of the subcommands.
#pragma once

#include "tests/tools/run_command.h"

namespace psplit {

// Each function makes an asset in the test's folder and returns its path.
class CommandOnSamples : public CommandTest {
 protected:
  // <shape>.glb: a plain asset.
  std::string sample(const std::string& shape = "terrain", const std::string& faces = "3000") {
    must_run({"generate", path(shape + ".glb"), "--shape", shape, "--faces", faces, "--seed", "7"});
    return path(shape + ".glb");
  }
  // split.glb: a terrain in four patches.
  std::string split_sample() {
    must_run({"encode", sample(), path("split.glb"), "--patches", "4", "-q"});
    return path("split.glb");
  }
  // stock.gltf: the same terrain as stock Draco.
  std::string stock_sample() {
    must_run({"decode", sample(), path("stock.gltf"), "--to", "draco", "-q"});
    return path("stock.gltf");
  }
  // mesh.drc: the stream of stock.gltf.
  std::string draco_sample() {
    stock_sample();
    const auto json = read_json("stock.gltf");
    const auto& extension = json.at("meshes").at(0).at("primitives").at(0).at("extensions");
    const auto& view =
        json.at("bufferViews").at(extension.at("KHR_draco_mesh_compression").at("bufferView").get<size_t>());
    const std::string stream =
        read_bytes(path(binary_of("stock.gltf")))
            .substr(view.value("byteOffset", size_t{0}), view.at("byteLength").get<size_t>());
    EXPECT_EQ(stream.substr(0, 5), "DRACO");
    write("mesh.drc", stream);
    return path("mesh.drc");
  }

  // The name of the .bin that a .gltf refers to.
  std::string binary_of(const std::string& gltf) const {
    return read_json(gltf).at("buffers").at(0).at("uri").get<std::string>();
  }
};

}  // namespace psplit
