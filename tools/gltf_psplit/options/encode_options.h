// The options of `encode` and `batch`: how an asset is split and written.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"

namespace CLI {
class App;
}

namespace psplit {

// Faces of a patch with --profile speed. On one thread and on several, patches of this size decode fastest
// (docs/benchmarks.md).
inline constexpr uint64_t kSpeedPatchFaces = 4800;

struct EncodeArguments {
  std::string profile, gpu, volume = "mesh", fallback = "none", compat = "none";
  EncodeDocumentOptions options;
  bool condense = false, no_condense = false;
  bool no_verify = false;
  std::vector<std::string> drop_extensions;
};

// Adds the options. `arguments` must outlive the parse. Returns a function that completes `arguments.options`;
// call it once the command line is parsed.
std::function<void()> add_encode_options(CLI::App& command, EncodeArguments& arguments);

// Puts those options of add_encode_options that `command` has under headings in its help.
void group_encode_options(CLI::App& command);

// All options that the bytes of an output depend on, as text.
std::string describe_options(const EncodeDocumentOptions& options);

}  // namespace psplit
