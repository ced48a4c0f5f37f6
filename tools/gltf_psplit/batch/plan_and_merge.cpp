// What is done once for all shards of a batch: the plan before, and the merge after.
#include <algorithm>

#include "gltf_ext/files/io_error.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/mesh_files/read_asset.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/batch/batch_record.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// "3, 7, 8 and 12 more"
std::string listed(const std::vector<uint32_t>& numbers) {
  constexpr size_t kMost = 10;
  std::string text;
  for (size_t i = 0; i < std::min(kMost, numbers.size()); ++i)
    text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
  return numbers.size() > kMost ? text + " and " + std::to_string(numbers.size() - kMost) + " more" : text;
}

// A command of the batch is recorded in its rows: "encoded", "decoded" ...
BatchVerb verb_of(std::vector<BatchRows>& shards) {
  BatchVerb verb = BatchVerb::kEncode;
  for (BatchRows& rows : shards)
    rows.for_each([&](std::string_view row) {
      const Expected<Json> json = parse_json(row);
      const std::string* status = json ? string_field(*json, "status") : nullptr;
      for (const BatchVerb known : kBatchVerbs)
        if (status != nullptr && *status == done_word(known)) {
          verb = known;
          return false;
        }
      return true;
    });
  return verb;
}

}  // namespace

Status plan_into_file(const BatchArguments& arguments, const std::vector<std::string>& options,
                      bool with_hashes, const std::string& path, const Session& session) {
  Expected<std::vector<BatchItem>> items = plan_batch(arguments.request);
  if (!items) return items.status();
  if (path != "-" && is_asset_name(path))
    return {StatusCode::kUsage, path + " has the name of an asset; a plan is a .jsonl file"};
  for (BatchItem& item : *items) {
    const std::string input[] = {item.input};
    if (Status status = check_not_an_input(path, "--output", input); !status.ok()) return status;
    if (!with_hashes) continue;
    Expected<std::string> hash = hash_file(item.input);
    if (!hash) return hash.status();
    item.xxh128 = std::move(*hash);
  }
  if (Status status = check_output_place(path); !status.ok()) return status;
  if (Status status = write_manifest(path, {session.version, options, items->size()}, *items); !status.ok())
    return status;
  session.log.note((path == "-" ? "stdout" : path) + ": a plan of " + counted(items->size(), "asset"));
  return {};
}

Status merge_batch(const BatchArguments& arguments, const Session& session) {
  const fs::path& folder = arguments.request.folder;
  std::error_code error;
  if (!fs::is_directory(record_folder(folder), error))
    return io_failure("no batch has run in " + folder.string());
  GroupLock lock;
  const Expected<std::optional<std::string>> division = lock.take(division_file(folder));
  if (!division) return division.status();
  if (!*division) return may_pass("a batch is running in " + folder.string());
  if (Status status = merge_records(folder); !status.ok()) return status;

  const auto count = static_cast<uint32_t>(std::strtoul((*division)->c_str(), nullptr, 10));
  std::vector<BatchRows> shards;
  std::vector<uint32_t> missing;
  for (uint32_t index = 0; index < count; ++index) {
    BatchRows rows;
    const fs::path path = record_folder(folder) / (Shard{index, count}.file_name() + ".report.jsonl");
    if (!fs::exists(path, error)) {
      missing.push_back(index);
      continue;
    }
    if (Status status = rows.open(path); !status.ok()) return status;
    shards.push_back(std::move(rows));
    if (!shards.back().for_each([](std::string_view) { return true; })) missing.push_back(index);
  }
  BatchTally tally(verb_of(shards));
  for (BatchRows& rows : shards)
    rows.for_each([&](std::string_view row) {
      if (const Expected<Json> json = parse_json(row)) tally.add(*json);
      return true;
    });
  const bool asked = !arguments.report.empty();
  if (asked || !stdout_is_terminal()) {
    Json head{{"folder", arguments.folder}, {"shards", {{"count", count}, {"unfinished", missing}}}};
    head.update(tally.to_json());
    Status status = write_batch_report(asked ? arguments.report : "-", head, shards);
    if (!status.ok()) return status;
  }
  session.log.block(tally.summary(arguments.folder, 0));
  if (!missing.empty())
    return may_pass("of " + counted(count, "shard") + ", these have not finished: " + listed(missing));
  return tally.status(arguments.max_failures);
}

}  // namespace psplit
