// How an asset is split and written: the options of `encode` and `batch`. `compare` and `decode --to draco`
// have some of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mesh_files/origin.h"
#include "psplit/gltf.h"

namespace CLI {
class App;
}

namespace psplit {

struct EncodeArguments {
  std::string profile, gpu, volume = "mesh", compat = "none", morph_targets = "fit", meshopt;
  EncodeDocumentOptions options;
  OriginChoice origin;  // of a mesh file
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
std::string describe_options(const EncodeDocumentOptions& options, const OriginChoice& origin);

// --origin. `origin` must outlive the parse.
void add_origin_option(CLI::App& command, OriginChoice& origin);
// What the bits of positions are, so that floats need not say more than these do.
void follow_bits(const EncodeDocumentOptions& options, OriginChoice& origin);

// The number of multiprocessors of a GPU, from a name like "H100" or "rtx 4090", or from the number itself (1
// to 4096). Nothing if the name is unknown.
std::optional<uint32_t> multiprocessors(const std::string& gpu);
// The names that `multiprocessors` knows, separated by commas.
std::string known_gpus();

// The number of patches that keep `multiprocessors` multiprocessors busy: a warp of patches for each of the
// four schedulers of each, rounded to a multiple of 512 (the paper's section 4.3).
uint32_t patches_in_flight(uint32_t multiprocessors);

// The options for precision and Draco's speed. With `fits_mesh` also --quantize-position auto and --max-error,
// which choose the bits of positions for each mesh. `options` must outlive the parse.
void add_coding_options(CLI::App& command, EncodeDocumentOptions& options, bool fits_mesh);
// --distance, --no-refine. `options` must outlive the parse.
void add_partition_options(CLI::App& command, EncodeDocumentOptions& options);

}  // namespace psplit
