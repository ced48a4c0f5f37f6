#include "tools/gltf_psplit/batch/batch.h"

#include <algorithm>
#include <deque>
#include <map>
#include <set>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "mesh_files/read_asset.h"
#include "src/stopwatch.h"
#include "system/child_process.h"
#include "system/content_hash.h"
#include "system/files.h"
#include "system/io_error.h"
#include "system/operating_system.h"
#include "system/temporary_file.h"
#include "tools/gltf_psplit/batch/batch_record.h"
#include "tools/gltf_psplit/batch/worker.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// After a signal, what runs may end within this time. Slurm and Kubernetes kill after 30 seconds.
constexpr auto kGrace = std::chrono::seconds(5);

// An asset of the plan. If the status is not ok, nothing can be done about it: its line is invalid, or an
// earlier asset has the same name.
struct PlannedItem {
  BatchItem item;
  Status status{};
};

// The assets of a batch one after the other, out of a plan in memory or in a file.
class Items {
 public:
  Status open(const BatchArguments& arguments) {
    shard_ = arguments.shard.value_or(Shard());
    if (!arguments.manifest.empty()) {
      Expected<Manifest> manifest = Manifest::open(arguments.manifest);
      if (!manifest) return manifest.status();
      manifest_.emplace(std::move(*manifest));
      if (manifest_->head() && shard_.count == 1) count_ = manifest_->head()->count;
      return {};
    }
    Expected<std::vector<BatchItem>> planned = plan_batch(arguments.request);
    if (!planned) return planned.status();
    planned_ = std::move(*planned);
    for (const BatchItem& item : planned_) note(item);
    std::erase_if(planned_, [&](const BatchItem& item) { return !shard_.owns(item.name); });
    count_ = planned_.size();
    return {};
  }
  const std::vector<BatchItem>& planned() const { return planned_; }
  uint64_t count() const { return count_; }  // 0 if it is not known
  // Names what all shards together work on, once all items were read.
  std::string plan() const { return plan_.hex(); }

  // Nothing at the end. Errors: as for Manifest::next.
  Expected<std::optional<PlannedItem>> next() {
    if (!manifest_)
      return next_ < planned_.size() ? std::optional(PlannedItem{planned_[next_++]}) : std::nullopt;
    for (;;) {
      Expected<std::optional<ManifestLine>> line = manifest_->next();
      if (!line) return line.status();
      if (!*line) return std::optional<PlannedItem>();
      if (std::optional<PlannedItem> ours = item_of_line(**line)) return ours;
    }
  }

 private:
  // Nothing if it is another shard's.
  std::optional<PlannedItem> item_of_line(ManifestLine& line) {
    if (!line.item) {  // one shard reports it
      plan_.add_framed(line.text);
      const std::string place = "line " + std::to_string(line.number) + " of the manifest";
      if (!shard_.owns(line.text)) return std::nullopt;
      return PlannedItem{{.input = place}, line.item.status()};
    }
    BatchItem& item = *line.item;
    note(item);
    if (!shard_.owns(item.name)) return std::nullopt;
    if (!repeats_name(item)) return PlannedItem{std::move(item)};
    const std::string name = item.name;
    return PlannedItem{std::move(item),
                       wrong_usage("another asset of the manifest has the same name, " + name)};
  }

  // Whether an earlier item of this shard has the same name. `batch plan` excludes that, so that only other
  // manifests take memory for their names.
  bool repeats_name(const BatchItem& item) {
    return !manifest_->head() && !names_.insert(hash_of(name_to_compare(item.name))).second;
  }

  void note(const BatchItem& item) {
    plan_.add_framed(item.name);
    plan_.add_framed(item.input);
  }

  Shard shard_;
  ContentHash plan_;
  std::set<Hash128> names_;
  std::optional<Manifest> manifest_;
  std::vector<BatchItem> planned_;
  size_t next_ = 0;
  uint64_t count_ = 0;
};

class Batch {
 public:
  Batch(const BatchArguments& arguments, const Session& session)
      : arguments_(arguments), session_(session), tally_(arguments.verb) {}

  Status run() {
    const StopSignals signals;
    signals_ = &signals;
    if (Status status = prepare(); !status.ok()) return status;
    const Stopwatch watch;
    {
      ProgressBar bar(progress_label(), session_.log);
      bar_ = &bar;
      work();
    }
    if (failure_.ok() && !is_cut_short()) failure_ = rows_.add_end(watch.ms(), items_.plan());
    if (Status status = report(watch.ms()); failure_.ok()) failure_ = std::move(status);
    const std::string shard = arguments_.shard ? "shard " + arguments_.shard->text() + " of " : "";
    if (arguments_.summarize)
      Log(Verbosity::kNormal).note(tally_.line(shard + arguments_.folder, watch.ms()));
    else
      session_.log.block(tally_.summary(arguments_.folder, watch.ms()));
    return result();
  }

 private:
  // An asset that the worker has.
  struct Running {
    BatchItem item;
    Deadline deadline;  // nothing before it begins, and while it waits for memory
    bool waits = false;
    bool is_alone = false;
  };

  Status prepare() {
    if (Status status = items_.open(arguments_); !status.ok()) return status;
    if (Status status = check_report(); !status.ok()) return status;
    const fs::path& folder = arguments_.request.folder;
    const Shard shard = arguments_.shard.value_or(Shard());
    fs::path rows;
    if (!arguments_.dry_run) {
      if (Status status = record_.open(folder, shard); !status.ok()) return status;
      rows = record_folder(folder) / (shard.file_name() + ".report.jsonl");
    }
    // Only now, because the report may be in the output folder, which `open` has made.
    if (writes_report_file())
      if (Status status = check_output_place(arguments_.report, arguments_.force); !status.ok()) return status;
    if (arguments_.staging.any() && !arguments_.dry_run) {
      const fs::path place = arguments_.staging.folder;
      if (Status status = staged_.open(place.empty() ? record_folder(folder) : place); !status.ok())
        return status;
    }
    return rows_.create(rows);
  }

  bool writes_report_file() const { return !arguments_.report.empty() && arguments_.report != "-"; }

  Status check_report() const {
    if (!writes_report_file()) return {};
    if (!arguments_.manifest.empty() && is_asset_name(arguments_.report))
      return wrong_usage("--report " + arguments_.report + " has the name of an asset");
    const std::string report = whole_name(arguments_.report);
    for (const std::string& word : arguments_.request.words)
      if (word.starts_with('@') && whole_name(word.substr(1)) == report)
        return wrong_usage("--report would replace the list " + word.substr(1));
    for (const BatchItem& item : items_.planned())
      for (const fs::path& path : {arguments_.request.folder / item.name, fs::path(item.input)})
        if (whole_name(path) == report)
          return wrong_usage("--report would replace " + arguments_.report +
                             ", which is an input or an output");
    return {};
  }

  std::string progress_label() const {
    switch (arguments_.verb) {
      case BatchVerb::kEncode: return "encoding";
      case BatchVerb::kDecode: return "decoding";
      case BatchVerb::kValidate: return "validating";
      case BatchVerb::kDiff: return "comparing";
    }
    return "";
  }

  // Hands assets to the worker and takes their results until all are done, or until a signal or a failure stops
  // the batch.
  void work() {
    for (;;) {
      if (!worker_ && may_begin()) start_worker();
      while (may_begin() && running_.size() < most_at_once()) begin_next();
      if (running_.empty()) break;
      ChildProcess::Received received = worker_->receive(next_deadline());
      for (const std::string& line : received.lines) take(line);
      if (received.ended) worker_ended(worker_->wait());
      if (signals_->seen() && !stop_deadline_) stop_deadline_ = Clock::now() + kGrace;
      if (worker_) drop_late();
    }
    if (!worker_) return;
    worker_->close();
    worker_->wait();
  }

  bool is_stopping() const { return stop_deadline_ || signals_->seen() || !failure_.ok(); }
  bool may_begin() const { return !is_stopping() && !(at_end_ && again_.empty() && alone_.empty()); }
  bool is_cut_short() const { return dropped_ > 0 || !at_end_ || !again_.empty() || !alone_.empty(); }

  // An asset that may have ended a worker has the next one for itself.
  size_t most_at_once() const {
    const bool has_alone =
        std::ranges::any_of(running_, [](const auto& entry) { return entry.second.is_alone; });
    return has_alone || !alone_.empty() ? 1 : static_cast<size_t>(session_.pool.thread_count());
  }

  void start_worker() {
    Expected<std::unique_ptr<ChildProcess>> worker = ChildProcess::start(
        [this](ParentLink& link) { return run_worker(link, arguments_, session_, record_, staged_.path()); },
        staged_.path().string());
    if (worker)
      worker_ = std::move(*worker);
    else
      failure_ = worker.status();
  }

  void begin_next() {
    Running running;
    if (!alone_.empty() || !again_.empty()) {
      running.is_alone = !alone_.empty();
      std::deque<BatchItem>& waiting = running.is_alone ? alone_ : again_;
      running.item = std::move(waiting.front());
      waiting.pop_front();
    } else {
      Expected<std::optional<PlannedItem>> next = items_.next();
      if (!next) failure_ = next.status();
      if (next && !*next) at_end_ = true;
      if (!next || !*next) return;
      if (const Status& flaw = (*next)->status; !flaw.ok()) return note_failure((*next)->item, flaw);
      running.item = std::move((*next)->item);
    }
    Json json = to_json(running.item);
    json["id"] = ++last_id_;
    // Its time begins when the worker does: the worker first loads the record.
    // If this fails, the worker has ended, and `receive` will say so.
    static_cast<void>(worker_->send(json_line(json)));
    running_.emplace(last_id_, std::move(running));
  }

  Deadline deadline() const {
    if (arguments_.timeout_s <= 0) return std::nullopt;
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(arguments_.timeout_s));
  }

  Deadline next_deadline() const {
    Deadline next = stop_deadline_;
    for (const auto& [id, running] : running_)
      if (running.deadline && (!next || *running.deadline < *next)) next = running.deadline;
    return next;
  }

  void take(std::string_view line) {
    const size_t head = std::min(line.find(kBeforeText), line.size());
    const Expected<Json> json = parse_json(line.substr(0, head));
    if (!json) return;
    if (const Json* failed = object_field(*json, "failed")) {
      const std::string* message = string_field(*failed, "message");
      failure_ = Status(status_code(integer_field(*failed, "code").value_or(-1)),
                        message == nullptr ? "the worker failed" : *message);
    }
    const auto found = running_.find(static_cast<uint64_t>(integer_field(*json, "id").value_or(0)));
    if (found == running_.end()) return;
    Running& running = found->second;
    if (const Json* waits = field(*json, "waits")) {
      running.waits = *waits == true;
      running.deadline = running.waits ? std::nullopt : deadline();
    }
    const Json* const row = object_field(*json, "row");
    if (row == nullptr || head == line.size()) return;
    spares_report_ = spares_report_ || bool_field_or(*json, "spares_report", false);
    const bool had_company = running_.size() > 1;
    if (bool_field_or(*json, "alone", false) && had_company && !running.is_alone)
      alone_.push_back(std::move(running.item));
    else
      note(*row, line.substr(head + 1), running.item);
    running_.erase(found);
  }

  // The worker ended although assets ran. One that ran alone is the cause; otherwise each of them may be.
  void worker_ended(const ProcessEnd& end) {
    worker_.reset();
    const auto runs = [](const auto& entry) { return !entry.second.waits; };
    const auto suspects = std::ranges::count_if(running_, runs);
    for (auto& [id, running] : running_) {
      clean_up_after(id, running.item);
      if (!failure_.ok())
        ++dropped_;
      else if (running.waits)
        again_.push_back(std::move(running.item));
      else if (suspects > 1)
        alone_.push_back(std::move(running.item));
      else
        note_failure(running.item, cause_of(end));
    }
    running_.clear();
  }

  // The system kills without a word when memory runs out.
  static Status cause_of(const ProcessEnd& end) {
    constexpr int kKill = 9;
    const std::string number = std::to_string(end.number);
    if (!end.by_signal) return runtime_failure("its worker process ended with code " + number);
    return end.number == kKill ? may_pass("was killed, probably because memory ran out")
                               : runtime_failure("crashed with signal " + number);
  }

  // Kills the worker if an asset is late, or all assets after a signal.
  void drop_late() {
    const Clock::time_point now = Clock::now();
    const bool drops_all = stop_deadline_ && now >= *stop_deadline_;
    const auto is_late = [&](const Running& running) { return running.deadline && now >= *running.deadline; };
    if (!drops_all && std::ranges::none_of(running_, [&](const auto& entry) { return is_late(entry.second); }))
      return;
    worker_->kill();
    worker_.reset();
    for (auto& [id, running] : running_) {
      clean_up_after(id, running.item);
      if (drops_all)
        ++dropped_;
      else if (is_late(running))
        note_failure(running.item, may_pass("took longer than the " + with_decimals(arguments_.timeout_s, 1) +
                                            " s of --timeout"));
      else
        (running.is_alone ? alone_ : again_).push_back(std::move(running.item));
    }
    running_.clear();
  }

  // Removes the files that a killed worker left of an asset.
  void clean_up_after(uint64_t id, const BatchItem& item) const {
    if (arguments_.staging.any()) remove_folder(staged_.path() / std::to_string(id));
    if (!arguments_.dry_run) remove_dead_temporaries((arguments_.request.folder / item.name).parent_path());
  }

  void note_failure(const BatchItem& item, const Status& cause) {
    const BatchOutcome outcome{.input = item.input, .status = Status(cause).at({.file = item.input})};
    const Json row = to_json(outcome, arguments_.verb);
    note(row, json_line(row), item);
  }

  // An asset has ended. `text` is the row with its details.
  void note(const Json& row, std::string_view text, const BatchItem& item) {
    tally_.add(row);
    if (Status status = rows_.add(text); !status.ok() && failure_.ok()) failure_ = std::move(status);
    if (const Json* error = object_field(row, "error"))
      if (const std::string* message = string_field(*error, "message"))
        session_.log.error({status_code(integer_field(*error, "code").value_or(-1)), *message});
    if (arguments_.progress_as_json)
      if (Status status = write_text("-", std::string(text) + "\n"); !status.ok() && failure_.ok())
        failure_ = std::move(status);
    bytes_done_ += item.bytes.value_or(0);
    bar_->show({.done = tally_.assets(),
                .total = items_.count(),
                .noun = "asset",
                .stage = "",
                .amount = bytes_done_,
                .amount_noun = "byte"});
  }

  Status report(double wall_ms) {
    const bool asked = !arguments_.report.empty();
    const bool by_default = arguments_.reports_by_default && !arguments_.shard &&
                            !arguments_.progress_as_json && !stdout_is_terminal();
    if (spares_report_ || !(asked || by_default)) return {};
    Json head{{"folder", arguments_.folder},
              {"verified", arguments_.encode.options.verify},
              {"threads", session_.pool.thread_count()}};
    if (arguments_.shard) head["shard"] = arguments_.shard->text();
    head["wall_ms"] = wall_ms;
    head.update(tally_.to_json());
    return write_batch_report(
        asked ? arguments_.report : "-", head, [&](const RowVisitor& visit) { rows_.for_each(visit); },
        arguments_.force ? IfReadOnly::kReplace : IfReadOnly::kFail);
  }

  Status result() const {
    if (!failure_.ok()) return failure_;
    if (is_cut_short())
      return may_pass("stopped by a signal after " + counted(tally_.assets(), "asset") +
                      "; run the command again to continue");
    return tally_.status(arguments_.max_failures);
  }

  const BatchArguments& arguments_;
  const Session& session_;
  Items items_;
  BatchRecord record_;
  BatchRows rows_;
  BatchTally tally_;
  StagingFolder staged_;
  const StopSignals* signals_ = nullptr;
  ProgressBar* bar_ = nullptr;
  std::unique_ptr<ChildProcess> worker_;
  std::map<uint64_t, Running> running_;
  std::deque<BatchItem> again_, alone_;  // items that a worker lost
  uint64_t last_id_ = 0, bytes_done_ = 0;
  size_t dropped_ = 0;
  bool at_end_ = false;
  bool spares_report_ = false;  // the report would replace a file that an asset needs
  Deadline stop_deadline_;
  Status failure_;  // of the batch itself
};

}  // namespace

Status run_batch(const BatchArguments& arguments, const Session& session) {
  if (const std::unique_ptr<ParentLink> link = take_parent_link())
    return run_started_worker(*link, arguments, session);
  return Batch(arguments, session).run();
}

}  // namespace psplit
