// gltf-psplit compare A B: whether two assets hold the same meshes, and where they first differ.
#pragma once

#include <string>
#include <vector>

#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/session.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace psplit {

struct SamenessOptions {
  std::string second;  // file; empty where there is only one
  std::vector<std::string> tolerances, attributes;
  bool scene = false;  // where nodes put meshes, and not the meshes themselves
};

// Options of `compare` that are for two files; the arguments outlive the parse.
void add_sameness_options(CLI::App& command, SamenessOptions& options);

// Writes what there is to say, as text or json, to `output`. kDiffers where they differ; errors name the file
// that is at fault.
Status run_sameness(const std::string& first, const SamenessOptions& options, const std::string& format,
                    const std::string& output, const BackendChoice& backend, const Session& session);

}  // namespace psplit
