#include "tools/gltf_psplit/batch/batch.h"

#include <algorithm>
#include <atomic>
#include <new>
#include <thread>

#include "gltf_ext/convert/encode_document.h"
#include "gltf_ext/files/content_hash.h"
#include "src/stopwatch.h"
#include "tools/gltf_psplit/batch/batch_record.h"
#include "tools/gltf_psplit/batch/batch_report.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/files/output_checks.h"
#include "tools/gltf_psplit/files/read_input.h"
#include "tools/gltf_psplit/files/text_output.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/report/log.h"
#include "tools/gltf_psplit/report/number_text.h"
#include "tools/gltf_psplit/report/progress.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class Batch {
 public:
  Batch(const BatchArguments& arguments, const Session& session) : arguments_(arguments), session_(session) {}

  Status run() {
    Expected<std::vector<BatchItem>> items = plan_batch(arguments_.request);
    if (!items) return items.status();
    items_ = std::move(*items);
    std::error_code error;
    const fs::path report_path = fs::weakly_canonical(arguments_.report, error);
    for (const BatchItem& item : items_)
      for (const fs::path& path : {item.output, fs::path(item.input)})
        if (writes_report_file() && fs::weakly_canonical(path, error) == report_path)
          return {StatusCode::kUsage,
                  "--report would replace " + arguments_.report + ", which is an input or an output"};
    if (Status status = record_.open(arguments_.request.folder); !status.ok()) return status;
    // Only now, because the report may be in the output folder, which `open` has made.
    if (writes_report_file())
      if (Status status = check_output_place(arguments_.report); !status.ok()) return status;

    const Stopwatch watch;
    for (const BatchItem& item : items_)
      outcomes_.push_back({.input = item.input, .output = item.output.string()});
    {
      ProgressBar bar("encoding", session_.log);
      encode_all(bar);
    }
    const BatchReport done = report(watch.ms());
    if (!spares_report_ && (!arguments_.report.empty() || !stdout_is_terminal())) {
      const std::string& path = arguments_.report.empty() ? "-" : arguments_.report;
      if (Status status = write_text(path, report_text(to_json(done))); !status.ok()) return status;
    }
    session_.log.block(summary_text(done));
    const auto first = std::ranges::find_if(outcomes_, [](const auto& o) { return !o.status.ok(); });
    if (first == outcomes_.end()) return {};
    return {first->status.code(),
            std::to_string(done.failed()) + " of " + counted(items_.size(), "asset") + " failed"};
  }

 private:
  bool writes_report_file() const { return !arguments_.report.empty() && arguments_.report != "-"; }

  // Encodes as many assets at once as there are threads. Each asset also uses the pool's threads for its
  // primitives and patches, so that a large asset at the end does not leave threads idle. Large files come
  // first for the same reason.
  void encode_all(ProgressBar& bar) {
    std::vector<std::pair<uintmax_t, size_t>> order;
    for (size_t i = 0; i < items_.size(); ++i) {
      std::error_code error;
      const uintmax_t bytes = fs::file_size(items_[i].input, error);
      order.emplace_back(error ? 0 : bytes, i);
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::atomic<size_t> next = 0, done = 0;
    std::atomic<uint64_t> bytes_done = 0;
    const auto work = [&] {
      for (size_t n = next++; n < order.size(); n = next++) {
        encode_item(order[n].second);
        bytes_done += order[n].first;
        ++done;
        bar.show({.done = done,
                  .total = order.size(),
                  .noun = "asset",
                  .stage = "",
                  .amount = bytes_done,
                  .amount_noun = "byte"});
      }
    };
    std::vector<std::thread> others;
    const size_t workers = std::min(items_.size(), static_cast<size_t>(session_.pool.thread_count()));
    for (size_t i = 1; i < workers; ++i) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
  }

  void encode_item(size_t i) {
    BatchOutcome& outcome = outcomes_[i];
    const Stopwatch watch;
    try {
      outcome.status = encode(items_[i], outcome);
    } catch (const std::bad_alloc&) {
      outcome.status = runtime_failure("out of memory");
    } catch (const std::exception& error) {
      outcome.status = runtime_failure(error.what());
    }
    outcome.status = std::move(outcome.status).at({.file = items_[i].input});
    if (!outcome.status.ok()) session_.log.error(outcome.status);
    outcome.wall_ms = watch.ms();
  }

  Status encode(const BatchItem& item, BatchOutcome& outcome) {
    Expected<Document> document = read_input(item.input, session_.log);
    if (!document) return document.status();
    if (Status status = check_not_an_input(arguments_.report, "--report", *document); !status.ok()) {
      spares_report_ = true;
      return status;
    }
    ContentHash hash;
    hash.add_framed(session_.version);
    hash.add_framed(describe_options(arguments_.encode.options));
    hash.add_framed(describe_images(arguments_.write));
    hash.add_framed(hash_asset(*document));
    const std::string made_from = hash.hex();
    if (is_up_to_date(item, made_from)) {
      outcome.up_to_date = true;
      session_.log.detail(item.output.string() + " is up to date");
      return {};
    }
    if (Status status = check_output(item); !status.ok()) return status;
    outcome.sizes.input = bytes_on_disk(document->source.string());
    const auto reports = encode_document(*document, arguments_.encode.options, find_backend({}), session_.pool);
    if (!reports) return reports.status();
    outcome.result = collect_rows(*reports, Log(Verbosity::kQuiet));
    log_reports(*reports, session_.log, item.input + ": ");
    warn_of_growth(outcome.result, session_.log, item.input);
    std::error_code error;
    fs::create_directories(item.output.parent_path(), error);  // if it fails, writing reports it
    if (Status status = record_.begin(item.name); !status.ok()) return status;
    if (Status status = write_document(*document, item.output, arguments_.write, &outcome.written);
        !status.ok())
      return status;
    log_written(outcome.written, session_.log, item.input + ": ");
    outcome.sizes.output = bytes_on_disk(item.output.string());
    const Expected<Document> written = read_document(item.output);
    if (!written) return written.status();
    session_.log.detail(written_text(item.output.string(), outcome.sizes, encode_summary(outcome.result)));
    return record_.add(item.name, {made_from, hash_asset(*written)});
  }

  // Files in the folder that no batch made are not replaced.
  Status check_output(const BatchItem& item) const {
    std::error_code error;
    if (record_.find(item.name) != nullptr || !fs::exists(fs::symlink_status(item.output, error))) return {};
    return {StatusCode::kUsage,
            item.output.string() + " exists, and no batch made it: move it away, or choose another --out-dir"};
  }

  // Whether the output was made from the same input with the same options, and has not changed since.
  bool is_up_to_date(const BatchItem& item, const std::string& made_from) const {
    const BatchRecord::Entry* entry = record_.find(item.name);
    if (entry == nullptr || entry->made_from != made_from) return false;
    const Expected<Document> output = read_document(item.output);
    return output && hash_asset(*output) == entry->output;
  }

  BatchReport report(double wall_ms) const {
    return {.folder = arguments_.folder,
            .verified = arguments_.encode.options.verify,
            .threads = session_.pool.thread_count(),
            .wall_ms = wall_ms,
            .outcomes = outcomes_};
  }

  const BatchArguments& arguments_;
  const Session& session_;
  std::vector<BatchItem> items_;
  std::vector<BatchOutcome> outcomes_;
  BatchRecord record_;
  std::atomic<bool> spares_report_ = false;  // the report would replace a file that an asset needs
};

}  // namespace

Status run_batch(const BatchArguments& arguments, const Session& session) {
  return Batch(arguments, session).run();
}

}  // namespace psplit
