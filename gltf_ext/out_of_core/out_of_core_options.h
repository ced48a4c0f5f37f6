// The limits of encoding out of core.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace psplit {

// The least memory that works.
inline constexpr uint64_t kLeastMemory = uint64_t{128} << 20;

struct OutOfCoreOptions {
  uint64_t memory = 0;              // of the process, in bytes, at least kLeastMemory
  std::filesystem::path temporary;  // the folder of temporary files, which have no names
  uint64_t most_part_faces = 0;     // smaller parts than the memory allows; 0: no limit
  // The most points of a container; the next container is another primitive.
  uint64_t most_container_points = 0xfffffffe;
  bool to_glb = false;  // the result must fit into a GLB: it is refused as soon as it is known that it does not
  std::function<void(const std::string&)> note{};  // gets a sentence about the temporary space before the work
};

}  // namespace psplit
