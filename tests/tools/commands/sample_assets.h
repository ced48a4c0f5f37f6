// Small assets for the tests of the subcommands.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/tools/run_command.h"

namespace psplit {

// Each function makes an asset in the test's folder and returns its path.
class CommandOnSamples : public CommandTest {
 protected:
  // <shape>.glb: a plain asset.
  std::string sample(const std::string& shape = "terrain", const std::string& faces = "3000") const {
    const CommandOutcome outcome =
        run_command({"generate", path(shape + ".glb"), "--shape", shape, "--faces", faces, "--seed", "7"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return path(shape + ".glb");
  }
  // split.glb: a terrain in four patches.
  std::string split_sample() const {
    const CommandOutcome outcome = run_command({"encode", sample(), path("split.glb"), "--patches", "4", "-q"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return path("split.glb");
  }
  // stock.gltf: the same terrain as stock Draco.
  std::string stock_sample() const {
    const CommandOutcome outcome = run_command({"decode", sample(), path("stock.gltf"), "--to", "draco", "-q"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return path("stock.gltf");
  }
  // mesh.drc: the stream of stock.gltf.
  std::string draco_sample() const {
    const auto json = nlohmann::json::parse(read_bytes(stock_sample()));
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
    const auto json = nlohmann::json::parse(read_bytes(path(gltf)));
    return json.at("buffers").at(0).at("uri").get<std::string>();
  }
};

}  // namespace psplit
