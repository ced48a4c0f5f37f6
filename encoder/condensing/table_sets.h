// Sets of token tables. The patches that use a set are alike.
#pragma once

#include "encoder/condensing/shared_models.h"
#include "psplit/parallel.h"

namespace psplit {

// How often a patch uses each token with each table. Tokens that it does not use are absent.
struct PatchToken {
  uint16_t table = 0, token = 0;
  uint32_t count = 0;
};
using PatchTokens = std::vector<PatchToken>;
PatchTokens patch_tokens(const AttributeCounts& counts);

struct TableSets {
  std::vector<AttributeCounts> counts;  // by set
  std::vector<uint8_t> set;             // by patch
};

// Gives each patch of an attribute to one of at most `most` sets, such that tokens and tables take few bits.
// Unless `smallest`, more sets must save bits worth the slower decoding. The result is the same on every
// machine and with any number of threads.
TableSets choose_table_sets(std::span<const PatchTokens> patches, uint32_t most, bool smallest,
                            const ThreadPool& pool);

}  // namespace psplit
