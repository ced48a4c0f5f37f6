// What `batch` reports: a row of JSON for each asset, their sums, and a summary for people.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "psplit/base.h"
#include "psplit/document.h"
#include "system/files.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/encode_report.h"

namespace psplit {

// What a batch does with each asset.
enum class BatchVerb { kEncode, kDecode, kValidate, kDiff };
inline constexpr BatchVerb kBatchVerbs[] = {BatchVerb::kEncode, BatchVerb::kDecode, BatchVerb::kValidate,
                                            BatchVerb::kDiff};
const char* done_word(BatchVerb verb);  // "encoded", "decoded", "validated", "compared"

// The result of one asset.
struct BatchOutcome {
  std::string input{}, output{};  // `output` is empty if the verb writes none
  Status status{};
  bool up_to_date = false;  // if so, the members below are unset, except `recorded`
  bool planned = false;     // --dry-run: it would be done; the members below are unset
  EncodeResult result{};    // only for encode
  WriteReport written{};
  AssetSizes sizes{};
  Json figures{};  // figures_of this outcome, or of the earlier one that the record has; null if unknown
  Json details{};  // what only one verb reports: findings, differences
  double wall_ms = 0;
  uint64_t memory = 0;       // the estimate that admitted it
  uint64_t peak_memory = 0;  // of the process, with all that it did before
};

// What totals are made of: "files", "geometry" and "total"; empty if the verb writes nothing.
Json figures_of(const BatchOutcome& outcome, BatchVerb verb);

// Members of a row that tell of the parts of an asset, and take most of its text.
inline constexpr const char* kDetailsOfRow[] = {"primitives", "result"};

// The row of an asset: "input", "output", "status", "error", "wall_ms", and what was done.
Json to_json(BatchOutcome outcome, BatchVerb verb);

// The sums over rows, with what was up to date, but without what failed. It keeps a few rows for the summary,
// so that its memory does not grow.
class BatchTally {
 public:
  explicit BatchTally(BatchVerb verb) : verb_(verb) {}
  void add(const Json& row);  // reads nothing of its members of kDetailsOfRow

  size_t assets() const { return assets_; }
  // kMayPass if any asset failed for a cause that may pass. Otherwise the code of the first failure in the
  // order of names, if more than `max_failures` assets failed.
  Status status(uint64_t max_failures) const;
  // One line: counts, bytes in and out, patches. `what` is the folder, or the shard and its folder.
  std::string line(const std::string& what, double wall_ms) const;
  // Several lines: counts, bytes in and out, the slowest assets, and failures with their reasons.
  // `wall_ms` is 0 if it is not known.
  std::string summary(const std::string& folder, double wall_ms) const;
  // {"encoded", "up_to_date", "failed", "may_pass", "files", "total"}
  Json to_json() const;

 private:
  std::string counts_text(const std::string& what, double wall_ms) const;
  std::string totals_text() const;

  BatchVerb verb_;
  size_t assets_ = 0, done_ = 0, up_to_date_ = 0, planned_ = 0;
  size_t failed_ = 0, may_pass_ = 0;  // `may_pass_`: of `failed_`, the assets that may succeed in another run
  // The code of the first that may not, in the order of names: threads end in any order.
  StatusCode first_ = StatusCode::kOk;
  std::string first_input_;
  EncodeRow total_;
  AssetSizes sizes_;
  struct Slow {
    double wall_ms;
    std::string input;
  };
  std::vector<Slow> slowest_;
  std::vector<std::string> failures_;
};

// The rows of a run, a line each, kept in a file until the report is written.
class BatchRows {
 public:
  // A new file at `path`, or one without a name if `path` is empty. Errors: as for io_error.
  Status create(const std::filesystem::path& path);
  // The file of an earlier run. Errors: as for io_error.
  Status open(const std::filesystem::path& path);

  // `row` is one line of JSON, without the end of the line. It is in the file when the call returns, so that a
  // kill loses none. Errors: as for io_error.
  Status add(std::string_view row);
  // Marks the end of a run that no signal stopped. `plan` names what all shards of the run worked on.
  Status add_end(double wall_ms, const std::string& plan);

  // Visits the row of each asset, until `visit` returns false. Returns the plan if the mark of the end follows.
  std::optional<std::string> for_each(const std::function<bool(std::string_view row)>& visit);

 private:
  std::string name_;
  OpenFile file_;
};

// Writes `head`, with the rows as its member "assets", to a file or to stdout ("-"). `for_each_row` calls its
// argument, which returns false after an error, with each row. Errors: as for io_error.
using RowVisitor = std::function<bool(std::string_view row)>;
Status write_batch_report(const std::string& path, const Json& head,
                          const std::function<void(const RowVisitor&)>& for_each_row,
                          IfReadOnly if_read_only = IfReadOnly::kFail);

}  // namespace psplit
