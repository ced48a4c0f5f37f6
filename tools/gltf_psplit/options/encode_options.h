// The options of `encode` and `batch`: how assets are split.
#pragma once

#include <functional>
#include <string>

#include "gltf_ext/convert/encode_document_options.h"

namespace CLI {
class App;
}

namespace psplit {

// Faces of a patch with --profile speed: one thread and many decode these fastest (docs/benchmarks.md).
inline constexpr uint64_t kSpeedPatchFaces = 4800;

struct EncodeArguments {
  std::string profile, gpu, volume = "mesh", fallback = "none", compat = "none";
  EncodeDocumentOptions options;
  bool no_verify = false;
};

// Adds the options; the arguments outlive the parse. Returns what fills in `options` from all others once the
// command line is parsed.
std::function<void()> add_encode_options(CLI::App& command, EncodeArguments& arguments);

// Puts the options of a command under headings in its help: those of add_encode_options.
void group_encode_options(CLI::App& command);

// Everything that the bytes of an output depend on, as text.
std::string describe_options(const EncodeDocumentOptions& options);

}  // namespace psplit
