// gltf-psplit compare A B: tells whether two assets hold the same meshes, and where they first differ.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/diff/compare_assets.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/memory_options.h"
#include "tools/gltf_psplit/options/session.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace psplit {

struct SamenessOptions {
  std::string second;  // the second file; empty if there is only one
  std::vector<std::string> tolerances, attributes;
  bool scene = false;  // compare meshes at the places where nodes put them
  MemoryChoice memory;
};

// Adds the options of `compare` for two files. `options` must outlive the parse.
void add_sameness_options(CLI::App& command, SamenessOptions& options);

// Writes the result to `output`, as text or json. kDiffers if the assets differ. Other errors name the file
// that they concern.
Status run_sameness(const std::string& first, const SamenessOptions& options, const std::string& format,
                    const std::string& output, const BackendChoice& backend, const Session& session);

// The result for people and for programs. `first` and `second` are the names of the two assets.
std::string to_text(const AssetComparison& comparison, const std::string& first, const std::string& second);
Json to_json(const AssetComparison& comparison);

}  // namespace psplit
