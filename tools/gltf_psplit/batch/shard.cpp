#include "tools/gltf_psplit/batch/shard.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "system/content_hash.h"

namespace psplit {
namespace {

std::optional<uint32_t> number(std::string_view text) {
  uint32_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

// What an engine tells the tasks of an array.
struct Engine {
  const char *name, *index, *count;  // `count` is null if the engine does not tell it
};
constexpr Engine kEngines[] = {{"Slurm", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT"},
                               {"AWS Batch", "AWS_BATCH_JOB_ARRAY_INDEX", "AWS_BATCH_JOB_ARRAY_SIZE"},
                               {"Kubernetes", "JOB_COMPLETION_INDEX", nullptr}};

struct Found {
  const Engine* engine;
  uint32_t index;
};

Expected<Found> find_engine(const GetVariable& environment) {
  std::vector<Found> found;
  for (const Engine& engine : kEngines) {
    const char* const text = environment(engine.index);
    if (text == nullptr) continue;
    const std::optional<uint32_t> index = number(text);
    if (!index) return wrong_usage(std::string(engine.index) + " is not a number: " + text);
    found.push_back({&engine, *index});
  }
  if (found.empty())
    return wrong_usage(
        "--shard auto finds no array: neither SLURM_ARRAY_TASK_ID nor AWS_BATCH_JOB_ARRAY_INDEX nor "
        "JOB_COMPLETION_INDEX is set; write --shard INDEX/COUNT");
  if (found.size() > 1)
    return wrong_usage("--shard auto finds two arrays: " + std::string(found[0].engine->index) + " and " +
                       found[1].engine->index + " are set; write --shard INDEX/COUNT");
  return found[0];
}

// The number of tasks of an array. The indices of a Slurm array may begin anywhere and have any step; the index
// in `found` is made to count from 0.
Expected<uint32_t> count_of_array(Found& found, const GetVariable& environment) {
  const Engine& engine = *found.engine;
  const char* const text = engine.count == nullptr ? nullptr : environment(engine.count);
  const std::optional<uint32_t> count = text == nullptr ? std::nullopt : number(text);
  if (!count)
    return wrong_usage(std::string("--shard auto: ") + engine.name +
                       " does not tell how many tasks there are; write --shard auto/COUNT");
  const char* const first = environment("SLURM_ARRAY_TASK_MIN");
  const char* const last = environment("SLURM_ARRAY_TASK_MAX");
  const char* const stated_step = environment("SLURM_ARRAY_TASK_STEP");
  if (engine.name != std::string_view("Slurm") || first == nullptr || last == nullptr) return *count;
  const uint32_t least = number(first).value_or(0), most = number(last).value_or(0);
  const uint32_t step = std::max(1u, number(stated_step == nullptr ? "1" : stated_step).value_or(1));
  if (most < least || (most - least) / step + 1 != *count || found.index < least ||
      (found.index - least) % step != 0)
    return wrong_usage(
        "--shard auto: the tasks of this Slurm array do not follow each other; write --shard auto/COUNT");
  found.index = (found.index - least) / step;
  return *count;
}

}  // namespace

bool Shard::owns(std::string_view name) const { return count == 1 || hash_of(name).low % count == index; }
std::string Shard::text() const { return std::to_string(index) + "/" + std::to_string(count); }
std::string Shard::file_name() const { return std::to_string(index) + "-of-" + std::to_string(count); }

Expected<Shard> parse_shard(const std::string& text, const GetVariable& environment) {
  const size_t slash = text.find('/');
  const std::string index_text = text.substr(0, slash);
  std::optional<uint32_t> index = number(index_text), count;
  if (slash != std::string::npos) count = number(std::string_view(text).substr(slash + 1));
  if (index_text == "auto") {
    Expected<Found> found = find_engine(environment);
    if (!found) return found.status();
    if (slash == std::string::npos) {
      const Expected<uint32_t> known = count_of_array(*found, environment);
      if (!known) return known.status();
      count = *known;
    }
    index = found->index;
  }
  if (!index || !count)
    return wrong_usage("--shard " + text + " is neither INDEX/COUNT, such as 3/128, nor auto, nor auto/COUNT");
  constexpr uint32_t kMost = 1000000;
  if (*count > kMost)
    return wrong_usage("--shard " + text + ": there may be at most " + std::to_string(kMost) + " shards");
  if (*index >= *count)
    return wrong_usage("--shard " + text + ": the index " + std::to_string(*index) +
                       " is not below the count " + std::to_string(*count) + "; indices begin with 0");
  return Shard{*index, *count};
}

}  // namespace psplit
