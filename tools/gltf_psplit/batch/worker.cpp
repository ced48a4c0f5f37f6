#include "tools/gltf_psplit/batch/worker.h"

#include <system_error>
#include <thread>

#include "gltf_ext/files/io_error.h"
#include "gltf_ext/files/temporary_file.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "tools/gltf_psplit/batch/asset_work.h"
#include "tools/gltf_psplit/batch/memory_estimate.h"
#include "tools/gltf_psplit/options/machine_limits.h"

namespace psplit {
namespace {

// What the assets may take together.
uint64_t memory_for_assets(uint64_t stated) {
  const uint64_t memory = stated != 0 ? stated : default_memory(cgroup_limits());
  return memory == 0 ? 0 : std::max(memory, kProcessMemory + 1) - kProcessMemory;
}

}  // namespace

int run_worker(ParentLink& link, const BatchArguments& arguments, const Session& session, BatchRecord& record,
               const std::filesystem::path& staging_folder) {
  const std::filesystem::path& folder = arguments.request.folder;
  const Status loaded = record.load(folder, arguments.shard.value_or(Shard()));
  if (!loaded.ok()) {
    link.send(
        line_of({{"failed", {{"code", static_cast<int>(loaded.code())}, {"message", loaded.to_string()}}}}));
    return static_cast<int>(loaded.code());
  }
  if (!arguments.dry_run && arguments.staging.store.empty())
    for (const std::filesystem::path& place : record.unfinished_folders())
      remove_dead_temporaries(folder / place);
  MemoryBudget memory(memory_for_assets(arguments.memory));
  AssetWork work(arguments, session, record, memory, staging_folder);
  const auto serve = [&] {
    while (const std::optional<std::string> line = link.receive()) {
      const Expected<Json> json = parse_json(*line);
      const Expected<BatchItem> item = json ? item_of(*json) : json.status();
      if (!item) continue;  // the parent wrote the line
      const auto id = static_cast<uint64_t>(integer_field(*json, "id").value_or(0));
      link.send(line_of({{"id", id}, {"waits", false}}));  // its time begins
      const BatchOutcome outcome = work.run(*item, id, [&](bool waits) {
        link.send(line_of({{"id", id}, {"waits", waits}}));
      });
      const bool alone = outcome.status.code() == kMayPass && outcome.status.message() == "out of memory";
      link.send(line_of({{"id", id},
                         {"row", to_json(outcome, arguments.verb)},
                         {"alone", alone},
                         {"spares_report", work.spares_report()}}));
    }
  };
  // As many assets at once as there are threads. Each asset also uses the pool's threads for its primitives and
  // patches, so that a large asset at the end does not leave threads idle.
  std::vector<std::thread> others;
  try {
    for (int i = 1; i < session.pool.thread_count(); ++i) others.emplace_back(serve);
  } catch (const std::system_error&) {
    // A container may allow fewer. The threads that there are do the work.
  }
  serve();
  for (std::thread& other : others) other.join();
  return 0;
}

}  // namespace psplit
