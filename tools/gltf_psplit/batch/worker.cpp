#include "tools/gltf_psplit/batch/worker.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "gltf_ext/convert/validate.h"
#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "psplit/gltf.h"
#include "src/catch_exceptions.h"
#include "src/stopwatch.h"
#include "system/child_process.h"
#include "system/content_hash.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "system/temporary_file.h"
#include "system/uri.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/batch/batch_record.h"
#include "tools/gltf_psplit/batch/memory_estimate.h"
#include "tools/gltf_psplit/diff/compare_assets.h"
#include "tools/gltf_psplit/diff/diff_report.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/file_options.h"
#include "tools/gltf_psplit/options/machine_limits.h"
#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/verdict.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// Reads a GLB that is small and names no other file: that takes less time than to estimate its memory first.
// Nothing for other files, and for files that cannot be read.
std::optional<Document> read_small_glb(const fs::path& path) {
  constexpr uint64_t kMost = uint64_t{1} << 16;
  Expected<std::vector<uint8_t>> file = read_file(path, kMost);
  if (!file || file->size() == kMost || !is_glb(*file)) return {};
  const std::string_view text(reinterpret_cast<const char*>(file->data()), file->size());
  if (text.find("uri\"") != text.npos) return {};
  Expected<Document> document = parse_document(std::move(*file), path);
  return document ? std::optional(std::move(*document)) : std::nullopt;
}

// Thread-safe. Assets begin in the order in which they ask, so that small ones do not hold up a large one.
class MemoryBudget {
 public:
  // 0: no limit.
  explicit MemoryBudget(uint64_t bytes) : limit_(bytes) {}

  // What an asset took. The destructor gives it back; the budget must outlive it.
  class Share {
   public:
    Share(MemoryBudget& budget, uint64_t bytes) : budget_(&budget), bytes_(bytes) {}
    Share(Share&& other) noexcept : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_) {}
    Share& operator=(Share&&) = delete;
    ~Share() {
      if (budget_ != nullptr) budget_->give_back(bytes_);
    }

   private:
    MemoryBudget* budget_;
    uint64_t bytes_;
  };
  // Waits until the asset fits beside the running ones. Calls `wait` first, if it has to wait. An asset that
  // never fits runs alone: the estimate may be too high, and the worker process protects the others.
  Share take(uint64_t bytes, const std::function<void()>& wait);

 private:
  void give_back(uint64_t bytes);

  const uint64_t limit_;
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t taken_ = 0;
  uint64_t next_ticket_ = 0, turn_ = 0;
};

MemoryBudget::Share MemoryBudget::take(uint64_t bytes, const std::function<void()>& wait) {
  if (limit_ != 0) bytes = std::min(bytes, limit_);  // it runs alone
  std::unique_lock lock(mutex_);
  const uint64_t ticket = next_ticket_++;
  const auto fits = [&] { return ticket == turn_ && (limit_ == 0 || taken_ + bytes <= limit_); };
  if (!fits()) {
    wait();
    changed_.wait(lock, fits);
  }
  ++turn_;
  taken_ += bytes;
  changed_.notify_all();
  return Share(*this, bytes);
}

void MemoryBudget::give_back(uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  taken_ -= bytes;
  changed_.notify_all();
}

// What the record calls a check of an asset; empty for verbs that write it.
const char* check_of(BatchVerb verb) {
  return verb == BatchVerb::kValidate ? "validate" : verb == BatchVerb::kDiff ? "diff" : "";
}

constexpr const char* kPassed = "passed";

// Thread-safe: all threads of a batch share it. The arguments must outlive it.
class AssetWork {
 public:
  // `staging_folder` is for the files of --fetch and --store.
  AssetWork(const BatchArguments& arguments, const Session& session, BatchRecord& record, MemoryBudget& memory,
            std::filesystem::path staging_folder)
      : arguments_(arguments),
        session_(session),
        record_(record),
        memory_(memory),
        staging_folder_(std::move(staging_folder)),
        options_(describe_options(arguments.encode.options, arguments.encode.origin)) {}

  // `id` is unique among the assets that run at once. Calls `waits(true)` before it waits for memory, and
  // `waits(false)` after. Failures are in the outcome.
  BatchOutcome run(const BatchItem& item, uint64_t id, const std::function<void(bool)>& waits);

  // Whether the report would replace a file that an asset needs.
  bool spares_report() const { return spares_report_; }

 private:
  struct Job;
  Status work(Job& job, const std::function<void(bool)>& waits);
  Status work_on_file(Job& job);
  Status fetch_links(Job& job, const Document& document);
  Status encode(Job& job, Document& document);
  Status write(Job& job, const Document& document, const std::string& key);
  Status validate(Job& job);
  Status diff(Job& job, const Document& input, const std::string& content);
  std::string made_from(const std::string& content) const;
  std::string recorded_input(const Job& job) const;
  Status note_up_to_date(Job& job, const std::string& key);
  Expected<bool> is_up_to_date(Job& job, const std::string& key);
  bool is_checked(Job& job, const std::string& key) const;
  Status check_output(const Job& job) const;
  template <typename Files>  // a document, or paths
  Status check_report_beside(const Files& files);

  const BatchArguments& arguments_;
  const Session& session_;
  BatchRecord& record_;
  MemoryBudget& memory_;
  const std::filesystem::path staging_folder_;
  const std::string options_;  // options of encoding, for made_from
  std::atomic<bool> spares_report_ = false;
};

struct AssetWork::Job {
  const BatchItem& item;
  BatchOutcome& outcome;
  StagedAsset staged;
  fs::path input{};   // the file to read
  fs::path output{};  // the file to write, or to compare with
  std::string record_name{};
  std::optional<Document> document{};  // the input, if it was read before its memory was known
  std::string content{};  // what the plan says about the input's content; empty if it has to be read
};

BatchOutcome AssetWork::run(const BatchItem& item, uint64_t id, const std::function<void(bool)>& waits) {
  BatchOutcome outcome{.input = item.input};
  const bool writes = *check_of(arguments_.verb) == '\0';
  const fs::path place = (arguments_.request.folder / item.name).make_preferred();
  if (writes || arguments_.verb == BatchVerb::kDiff)
    outcome.output = arguments_.staging.any() ? item.name : place.string();
  Job job{item, outcome, {arguments_.staging, staging_folder_ / std::to_string(id)}};
  job.input = item.input;
  job.output = writes && !arguments_.staging.store.empty() ? job.staged.output(item) : place;
  job.record_name = psplit::record_name(item.name, check_of(arguments_.verb));
  const bool is_known = !item.version.empty() || !item.xxh128.empty();
  if (!arguments_.staging.fetch.empty() && is_known && arguments_.verb != BatchVerb::kDiff)
    job.content = "given: " + item.xxh128 + " " + item.version;
  const Stopwatch watch;
  outcome.status = catch_exceptions([&] { return work(job, waits); });
  // The user knows the input by its own name, not by that of a copy.
  if (const Status& status = outcome.status; status.place().file == job.input.string() && !status.ok()) {
    Place at = status.place();
    at.file = item.input;
    outcome.status = Status(status.code(), status.message(), std::move(at));
  }
  outcome.status = std::move(outcome.status).at({.file = item.input});
  outcome.peak_memory = peak_memory();
  outcome.wall_ms = watch.ms();
  return outcome;
}

Status AssetWork::work(Job& job, const std::function<void(bool)>& waits) {
  // If the plan says which content the input has, an output that is up to date costs no transfer.
  if (!job.content.empty() && arguments_.staging.fetch_output.empty() && !arguments_.force &&
      record_.is_newest(job.record_name, made_from(job.content)))
    return note_up_to_date(job, made_from(job.content));
  if (arguments_.dry_run && arguments_.staging.any()) {
    job.outcome.planned = true;  // it may be up to date, but only a transfer would tell
    return {};
  }
  if (arguments_.staging.any())
    if (Status status = job.staged.open(); !status.ok()) return status;
  if (!arguments_.staging.fetch.empty()) {
    Expected<fs::path> fetched = job.staged.fetch(job.item);
    if (!fetched) return fetched.status();
    job.input = std::move(*fetched);
    if (Status status = job.staged.fetch_parts(job.item); !status.ok()) return status;
  }
  const bool with_coarse = arguments_.encode.options.fallback == Fallback::kCoarse;
  job.document = read_small_glb(job.input);
  const uint64_t memory = job.document ? estimate_memory(*job.document, arguments_.verb, with_coarse)
                                       : estimate_memory(job.input.string(), arguments_.verb, "", with_coarse);
  job.outcome.memory = memory;
  bool waited = false;
  const MemoryBudget::Share share = memory_.take(memory, [&] {
    waited = true;
    waits(true);
  });
  if (waited) waits(false);
  return work_on_file(job);
}

Status AssetWork::work_on_file(Job& job) {
  if (arguments_.verb == BatchVerb::kValidate) return validate(job);
  OriginChoice origin = arguments_.encode.origin;
  if (arguments_.verb == BatchVerb::kDecode) origin.bits = 0;
  Expected<Document> document = job.document
                                    ? std::move(*job.document)
                                    : read_input(job.input.string(), session_, "auto", FileAccess::kRead, {},
                                                 {}, PointClouds::kRefuse, origin);
  if (!document) return document.status();
  if (Status status = fetch_links(job, *document); !status.ok()) return status;
  if (Status status = check_report_beside(*document); !status.ok()) return status;
  const std::string content = job.content.empty() ? hash_asset(*document) : job.content;
  if (arguments_.verb == BatchVerb::kDiff) return diff(job, *document, content);
  const std::string key = made_from(content);
  const Expected<bool> up_to_date = is_up_to_date(job, key);
  if (!up_to_date) return up_to_date.status();
  if (*up_to_date) return note_up_to_date(job, key);
  if (Status status = check_output(job); !status.ok()) return status;
  if (arguments_.dry_run) {
    // What the work would refuse is no plan.
    if (Status status = check_document(*document, find_backend({}), session_.pool); !status.ok()) return status;
    job.outcome.planned = true;
    session_.log.note(job.outcome.output + would_be_written(job.output));
    return {};
  }
  job.outcome.sizes.input = bytes_on_disk(*document);
  std::vector<Finding> corrections;
  Status status = arguments_.verb == BatchVerb::kEncode
                      ? encode(job, *document)
                      : decode_document(*document, find_backend({}), session_.pool, {}, {}, &corrections);
  if (status.ok()) warn_of_corrections(corrections, session_.log, job.item.input);
  return status.ok() ? write(job, *document, key) : status;
}

// The plan knows only the content of the input. If there are other files, the content of all decides whether
// the output is up to date.
Status AssetWork::fetch_links(Job& job, const Document& document) {
  if (arguments_.staging.fetch.empty()) return {};
  if (document.files.size() > 1 || !linked_files(document).empty()) job.content.clear();
  return job.staged.fetch_links(job.item, document);
}

Status AssetWork::encode(Job& job, Document& document) {
  drop_extensions(document, arguments_.encode.drop_extensions, job.item.input, session_.log);
  const auto reports = encode_document(document, arguments_.encode.options, find_backend({}), session_.pool);
  if (!reports) return reports.status();
  const std::string prefix = job.item.input + ": ";
  job.outcome.result = collect_rows(*reports, arguments_.encode.options.skip, Log(Verbosity::kQuiet));
  log_reports(*reports, session_.log, prefix);
  warn_of_result(job.outcome.result, session_.log, job.item.input);
  return {};
}

Status AssetWork::write(Job& job, const Document& document, const std::string& key) {
  BatchOutcome& outcome = job.outcome;
  const bool replaces = record_.knows(job.record_name);
  if (Status status = make_folders(job.output.parent_path()); !status.ok()) return status;
  if (Status status = record_.begin(job.record_name); !status.ok()) return status;
  // After a power failure the record must not say that the storage still has the earlier output.
  if (!arguments_.staging.store.empty())
    if (Status status = record_.sync(); !status.ok()) return status;
  WriteOptions options = arguments_.write;
  options.replace_read_only = arguments_.force;
  if (Status status = write_document(document, job.output, options, &outcome.written); !status.ok()) {
    // What others put there from now on is theirs. If this fails as well, the failure to write is reported.
    static_cast<void>(record_.withdraw(job.record_name));
    return status;
  }
  log_written(outcome.written, session_.log, job.item.input + ": ");
  const Expected<OutputFiles> written = hash_output(job.output, document, outcome.written);
  if (!written) return written.status();
  outcome.sizes.output = written->bytes;
  if (Status status = check_report_beside(written->paths); !status.ok()) return status;
  if (!arguments_.staging.store.empty()) {
    if (outcome.written.files.size() != 1)
      return wrong_usage("--store takes one file for each asset: use --as glb and --images embed");
    if (Status status = job.staged.store(job.item, replaces); !status.ok()) return status;
  }
  if (session_.log.shows_details())
    session_.log.detail(written_text(outcome.output, outcome.sizes,
                                     arguments_.verb == BatchVerb::kEncode
                                         ? encode_summary(outcome.result, arguments_.encode.options)
                                         : done_word(arguments_.verb)));
  outcome.figures = figures_of(outcome, arguments_.verb);
  Json details{{"figures", outcome.figures}};
  if (const std::string input = recorded_input(job); !input.empty()) details["input"] = input;
  return record_.add(job.record_name, {key, written->hash, std::move(details)});
}

// Empty if a command brings the input or takes the output away.
std::string AssetWork::recorded_input(const Job& job) const {
  if (arguments_.staging.any()) return "";
  return percent_encode(fs::absolute(job.item.input).lexically_normal().string());
}

// Takes the asset's figures out of the record. An input that was moved is recorded at its new place.
Status AssetWork::note_up_to_date(Job& job, const std::string& key) {
  job.outcome.up_to_date = true;
  if (arguments_.dry_run)
    session_.log.note(job.outcome.output + " is up to date, and would be left");
  else
    session_.log.detail(job.outcome.output + " is up to date");
  const Json line = record_.line(job.record_name, key);
  if (const Json* figures = object_field(line, "figures")) job.outcome.figures = *figures;
  const std::string *before = string_field(line, "input"), *output = string_field(line, "output");
  const std::string input = recorded_input(job);
  if (arguments_.dry_run || input.empty() || output == nullptr || (before != nullptr && *before == input))
    return {};
  return record_.add(job.record_name, {key, *output, {{"figures", job.outcome.figures}, {"input", input}}});
}

Status AssetWork::validate(Job& job) {
  const Expected<Document> document = job.document ? std::move(*job.document) : read_document(job.input);
  if (!document) return document.status();
  if (Status status = fetch_links(job, *document); !status.ok()) return status;
  const std::string key = made_from(job.content.empty() ? hash_asset(*document) : job.content);
  if (is_checked(job, key)) return {};
  const std::vector<Finding> findings = validate_document(*document, find_backend({}), session_.pool);
  if (Status failure = first_failure(findings); !failure.ok()) return failure;
  Verdict verdict = verdict_of(job.item.input, findings);
  job.outcome.details = std::move(verdict.json);
  return verdict.status.ok() ? record_.add(job.record_name, {key, kPassed}) : verdict.status;
}

Status AssetWork::diff(Job& job, const Document& input, const std::string& content) {
  if (!arguments_.staging.fetch_output.empty()) {
    Expected<fs::path> back = job.staged.bring_back(job.item);
    if (!back) return back.status();
    job.output = std::move(*back);
  }
  const Expected<Document> output = read_document(job.output);
  if (!output) return output.status();
  const std::string key = made_from(content + hash_asset(*output));
  if (is_checked(job, key)) return {};
  const auto read = [&](const Document& document) {
    return read_asset_meshes(document, find_backend({}), find_describer("auto"), session_.pool);
  };
  const Expected<AssetMeshes> a = read(input), b = read(*output);
  if (!a) return a.status();
  if (!b) return b.status();
  const Expected<AssetComparison> comparison = compare_assets(*a, *b, {}, {session_.pool});
  if (!comparison) return comparison.status();
  if (comparison->same()) return record_.add(job.record_name, {key, kPassed});
  job.outcome.details = psplit::to_json(*comparison);
  return {StatusCode::kDiffers, "does not hold the same meshes as " + job.outcome.output};
}

// What a result depends on besides the input: this program, and the options of verbs that write.
std::string AssetWork::made_from(const std::string& content) const {
  ContentHash hash;
  hash.add_framed(session_.version);
  if (arguments_.verb == BatchVerb::kEncode) {
    hash.add_framed(options_);
    for (const std::string& name : arguments_.encode.drop_extensions) hash.add_framed(name);
  } else {
    hash.add_framed(done_word(arguments_.verb));
  }
  hash.add_framed(describe_images(arguments_.write));
  hash.add_framed(content);
  return hash.hex();
}

// Whether the output was made from the same input with the same options, and has not changed since. An output
// in a storage that --fetch-output cannot read is believed to be there.
Expected<bool> AssetWork::is_up_to_date(Job& job, const std::string& key) {
  if (arguments_.force || !record_.knows(job.record_name)) return false;
  if (!arguments_.staging.store.empty() && arguments_.staging.fetch_output.empty())
    return record_.is_newest(job.record_name, key);
  fs::path file = job.output;
  if (!arguments_.staging.store.empty()) {
    Expected<fs::path> back = job.staged.bring_back(job.item);
    if (!back) return false;  // it is stored again
    file = std::move(*back);
  }
  const Expected<OutputFiles> output = hash_output(file);
  if (output)
    if (Status status = check_report_beside(output->paths); !status.ok()) return status;
  return output && record_.has(job.record_name, {key, output->hash});
}

// The report must replace no file of an asset, before or after the work.
template <typename Files>
Status AssetWork::check_report_beside(const Files& files) {
  Status status = check_not_an_input(arguments_.report, "--report", files);
  spares_report_ = spares_report_ || !status.ok();
  return status;
}

// Whether a check, which has no output, need not run.
bool AssetWork::is_checked(Job& job, const std::string& key) const {
  job.outcome.up_to_date = !arguments_.force && record_.has(job.record_name, {key, kPassed});
  job.outcome.planned = !job.outcome.up_to_date && arguments_.dry_run;
  return job.outcome.up_to_date || job.outcome.planned;
}

// Files in the folder that no batch made are not replaced. A storage is protected by --store (PSPLIT_REPLACE).
Status AssetWork::check_output(const Job& job) const {
  std::error_code error;
  if (!arguments_.staging.store.empty()) return {};
  if (!arguments_.force && is_read_only(job.output))
    return io_failure("is read-only; --force replaces it", {.file = job.output.string()});
  if (file_type_at(job.output) == fs::file_type::character)
    return wrong_usage("has the name of a device", {.file = job.output.string()});
  const fs::file_status found = fs::symlink_status(job.output, error);
  if (!fs::exists(found) || (record_.knows(job.record_name) && !fs::is_symlink(found))) return {};
  return wrong_usage(job.output.string() +
                     " exists, and no batch made it: move it away, or choose another folder");
}

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
    link.send(json_line({{"failed", {{"code", exit_code(loaded.code())}, {"message", loaded.to_string()}}}}));
    return exit_code(loaded.code());
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
      if (arguments.timeout_s > 0) link.send(json_line({{"id", id}, {"waits", false}}));  // its time begins
      BatchOutcome outcome = work.run(*item, id, [&](bool waits) {
        link.send(json_line({{"id", id}, {"waits", waits}}));
      });
      Json answer{{"id", id},
                  {"alone", outcome.status.code() == StatusCode::kOutOfMemory},
                  {"spares_report", work.spares_report()}};
      Json row = to_json(std::move(outcome), arguments.verb);
      const std::string text = json_line(row);
      for (const char* details : kDetailsOfRow) row.erase(details);
      answer["row"] = std::move(row);
      link.send(json_line(answer) + kBeforeText + text);
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

Status run_started_worker(ParentLink& link, const BatchArguments& arguments, const Session& session) {
  const std::optional<std::string> staging_folder = link.receive();
  if (!staging_folder) return {};  // the batch has ended
  BatchRecord record;
  if (!arguments.dry_run)
    if (Status status = record.join(arguments.request.folder, arguments.shard.value_or(Shard())); !status.ok())
      return status;
  const int code = run_worker(link, arguments, session, record, *staging_folder);
  return code == 0 ? Status() : Status(status_code(code), "the worker failed");
}

}  // namespace psplit
