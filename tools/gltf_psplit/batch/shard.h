// The part of a batch that one process works on.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "psplit/base.h"

namespace psplit {

struct Shard {
  uint32_t index = 0, count = 1;

  // Whether this shard works on the output of that name. A hash of the name decides, so that new assets move no
  // others to another shard.
  bool owns(std::string_view name) const;
  std::string text() const;       // "3/128"
  std::string file_name() const;  // "3-of-128"
};

// The value of an environment variable, or null.
using GetVariable = std::function<const char*(const char*)>;

// "3/128": shard 3 of the shards 0 to 127. "auto": index and count come from the environment of a Slurm array
// or of an AWS Batch array. "auto/128": only the index does, and it counts from 0; that also works for an
// Indexed Job of Kubernetes, which does not know its count, and for a part of a Slurm array. Errors: kUsage.
Expected<Shard> parse_shard(const std::string& text, const GetVariable& environment);

}  // namespace psplit
