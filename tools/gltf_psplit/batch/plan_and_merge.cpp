// What is done once for all shards of a batch: the plan before, and the merge after.
#include <algorithm>
#include <cstdlib>
#include <optional>

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

// The reports of the shards of one count. One file at a time is open.
class Reports {
 public:
  Reports(const fs::path& folder, uint32_t count) : folder_(folder), count_(count) {}

  // Finds the shards whose last run has not finished, or was that of another plan than the newest.
  Status find_unfinished() {
    std::vector<std::optional<std::string>> plans;
    std::optional<fs::file_time_type> newest;
    std::string plan;
    for (uint32_t index = 0; index < count_; ++index) {
      std::optional<std::string>& its = plans.emplace_back();
      std::error_code error;
      const fs::file_time_type time = fs::last_write_time(path(index), error);
      if (error) continue;
      BatchRows rows;
      if (Status status = rows.open(path(index)); !status.ok()) return status;
      its = rows.for_each([](std::string_view) { return true; });
      if (!its || (newest && time < *newest)) continue;
      newest = time;
      plan = *its;
    }
    for (uint32_t index = 0; index < count_; ++index)
      if (!plans[index] || *plans[index] != plan) unfinished_.push_back(index);
    return {};
  }
  const std::vector<uint32_t>& unfinished() const { return unfinished_; }

  void for_each_row(const RowVisitor& visit) const {
    bool goes_on = true;
    for (uint32_t index = 0; index < count_ && goes_on; ++index) {
      BatchRows rows;
      std::error_code error;
      if (!fs::exists(path(index), error) || !rows.open(path(index)).ok()) continue;
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
  fs::path path(uint32_t index) const {
    return record_folder(folder_) / (Shard{index, count_}.file_name() + ".report.jsonl");
  }
  fs::path folder_;
  uint32_t count_;
  std::vector<uint32_t> unfinished_;
};

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
  GroupLock lock;
  const Expected<std::optional<std::string>> division = lock.take(division_file(folder));
  if (!division) return division.status();
  if (!*division) return may_pass("a batch is running in " + folder.string());
  const auto count = static_cast<uint32_t>(std::strtoul((*division)->c_str(), nullptr, 10));
  if (count == 0) return may_pass(division_file(folder).string() + " is empty: a shard was stopped too early");
  Reports reports(folder, count);
  if (Status status = reports.find_unfinished(); !status.ok()) return status;
  if (Status status = merge_records(folder); !status.ok()) return status;

  BatchTally tally(reports.verb());
  reports.for_each_row([&](std::string_view row) {
    if (const Expected<Json> json = parse_json(row)) tally.add(*json);
    return true;
  });
  const bool asked = !arguments.report.empty();
  if (asked || !stdout_is_terminal()) {
    Json head{{"folder", arguments.folder},
              {"shards", {{"count", count}, {"unfinished", reports.unfinished()}}}};
    head.update(tally.to_json());
    Status status = write_batch_report(asked ? arguments.report : "-", head,
                                       [&](const RowVisitor& visit) { reports.for_each_row(visit); });
    if (!status.ok()) return status;
  }
  session.log.block(tally.summary(arguments.folder, 0));
  if (!reports.unfinished().empty())
    return may_pass("of " + counted(count, "shard") +
                    ", these have not finished: " + listed(reports.unfinished()));
  return tally.status(arguments.max_failures);
}

}  // namespace psplit
