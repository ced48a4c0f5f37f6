// Runs once for all shards of a batch: the plan before, and the merge after.
#include <algorithm>
#include <cstdlib>
#include <optional>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "mesh_files/read_asset.h"
#include "system/files.h"
#include "system/io_error.h"
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

// The reports of the shards of one count. One file at a time is open.
class Reports {
 public:
  Reports(const fs::path& folder, uint32_t count) : folder_(folder), count_(count) {}

  // Finds the shards whose last run has not finished, or belongs to an older plan; among these the shards that
  // run now, and among the others the shards with failed assets.
  Status find_states() {
    std::vector<std::optional<std::string>> plans;
    std::vector<bool> has_failed;
    std::optional<fs::file_time_type> newest;
    std::string plan;
    for (uint32_t index = 0; index < count_; ++index) {
      std::optional<std::string>& its = plans.emplace_back();
      has_failed.push_back(false);
      std::error_code error;
      const fs::file_time_type time = fs::last_write_time(report(index), error);
      if (error) continue;
      BatchRows rows;
      if (Status status = rows.open(report(index)); !status.ok()) return status;
      its = rows.for_each([&](std::string_view row) {
        // The text occurs only there: in a string its quotes have backslashes.
        if (row.find(R"("status":"failed")") != std::string_view::npos) has_failed[index] = true;
        return true;
      });
      if (!its || (newest && time < *newest)) continue;
      newest = time;
      plan = *its;
    }
    for (uint32_t index = 0; index < count_; ++index) {
      const bool is_finished = plans[index] && *plans[index] == plan;
      if (!is_finished) unfinished_.push_back(index);
      if (!is_finished && is_owned(record_folder(folder_) / (Shard{index, count_}.file_name() + ".jsonl")))
        running_.push_back(index);
      if (is_finished && has_failed[index]) failed_.push_back(index);
    }
    return {};
  }
  const std::vector<uint32_t>& unfinished() const { return unfinished_; }

  Json to_json() const {
    return {{"count", count_}, {"unfinished", unfinished_}, {"running", running_}, {"failed", failed_}};
  }
  // "8 shards: 5 finished; 1 of them has failed assets: 3; 1 runs: 4; 2 have not begun or were stopped: 5, 7"
  std::string text() const {
    std::vector<uint32_t> missing;
    std::ranges::set_difference(unfinished_, running_, std::back_inserter(missing));
    const auto part = [](const std::vector<uint32_t>& shards, const char* one, const char* many) {
      if (shards.empty()) return std::string();
      return "; " + std::to_string(shards.size()) + (shards.size() == 1 ? one : many) + ": " + listed(shards);
    };
    return counted(count_, "shard") + ": " + std::to_string(count_ - unfinished_.size()) + " finished" +
           part(failed_, " of them has failed assets", " of them have failed assets") +
           part(running_, " runs", " run") +
           part(missing, " has not begun or was stopped", " have not begun or were stopped") + "\n";
  }

  void for_each_row(const RowVisitor& visit) const {
    bool goes_on = true;
    for (uint32_t index = 0; index < count_ && goes_on; ++index) {
      BatchRows rows;
      std::error_code error;
      if (!fs::exists(report(index), error) || !rows.open(report(index)).ok()) continue;
      rows.for_each([&](std::string_view row) { return goes_on = visit(row); });
    }
  }

  // What the shards did with assets: "encoded", "decoded" ...
  BatchVerb verb() const {
    std::optional<BatchVerb> found;
    for_each_row([&](std::string_view row) {
      const Expected<Json> json = parse_json(row);
      const std::string* status = json ? string_field(*json, "status") : nullptr;
      for (const BatchVerb known : kBatchVerbs)
        if (status != nullptr && *status == done_word(known)) found = known;
      return !found;
    });
    return found.value_or(BatchVerb::kEncode);
  }

 private:
  fs::path report(uint32_t index) const {
    return record_folder(folder_) / (Shard{index, count_}.file_name() + ".report.jsonl");
  }
  fs::path folder_;
  uint32_t count_;
  std::vector<uint32_t> unfinished_, running_, failed_;
};

}  // namespace

Status plan_into_file(const BatchArguments& arguments, const std::vector<std::string>& options,
                      bool with_hashes, const std::string& path, const Session& session) {
  Expected<std::vector<BatchItem>> items = plan_batch(arguments.request);
  if (!items) return items.status();
  if (path != "-" && is_asset_name(path))
    return wrong_usage(path + " has the name of an asset; a plan is a .jsonl file");
  for (BatchItem& item : *items) {
    const std::string input[] = {item.input};
    if (Status status = check_not_an_input(path, "--output", input); !status.ok()) return status;
    if (!with_hashes) continue;
    Expected<std::string> hash = hash_file(item.input);
    if (!hash) return hash.status();
    item.xxh128 = std::move(*hash);
  }
  if (Status status = check_output_place(path, session.force); !status.ok()) return status;
  if (Status status =
          write_manifest(path, {session.version, options, items->size()}, *items, session.if_read_only());
      !status.ok())
    return status;
  session.log.note((path == "-" ? "stdout" : path) + ": a plan of " + counted(items->size(), "asset"));
  return {};
}

Status merge_batch(const BatchArguments& arguments, const Session& session) {
  const fs::path& folder = arguments.request.folder;
  std::error_code error;
  if (!fs::is_directory(record_folder(folder), error))
    return io_failure("no batch has run in " + folder.string());
  const Expected<std::vector<uint8_t>> division = read_file(division_file(folder));
  const std::string count_text = division ? std::string(division->begin(), division->end()) : "";
  const auto count = static_cast<uint32_t>(std::strtoul(count_text.c_str(), nullptr, 10));
  if (count == 0) return may_pass(division_file(folder).string() + " is empty: no shard has begun");
  Reports reports(folder, count);
  if (Status status = reports.find_states(); !status.ok()) return status;
  // Before all shards have finished, this is a look at them: it locks nothing and changes nothing.
  if (reports.unfinished().empty()) {
    GroupLock lock;
    const Expected<std::optional<std::string>> is_alone = lock.take(division_file(folder));
    if (!is_alone) return is_alone.status();
    if (!*is_alone) return may_pass("a batch is running in " + folder.string());
    if (Status status = merge_records(folder); !status.ok()) return status;
  }

  BatchTally tally(reports.verb());
  reports.for_each_row([&](std::string_view row) {
    if (const Expected<Json> json = parse_json(row)) tally.add(*json);
    return true;
  });
  const bool asked = !arguments.report.empty();
  if (asked || !stdout_is_terminal()) {
    Json head{{"folder", arguments.folder}, {"shards", reports.to_json()}};
    head.update(tally.to_json());
    Status status = write_batch_report(asked ? arguments.report : "-", head,
                                       [&](const RowVisitor& visit) { reports.for_each_row(visit); });
    if (!status.ok()) return status;
  }
  session.log.block((count > 1 ? reports.text() : "") + tally.summary(arguments.folder, 0));
  if (!reports.unfinished().empty())
    return may_pass("of " + counted(count, "shard") +
                    ", these have not finished: " + listed(reports.unfinished()));
  return tally.status(arguments.max_failures);
}

}  // namespace psplit
