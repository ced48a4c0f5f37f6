// The work of a batch on one asset.
#pragma once

#include <atomic>
#include <functional>

#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/batch/batch_record.h"
#include "tools/gltf_psplit/batch/memory_budget.h"

namespace psplit {

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
        staging_folder_(std::move(staging_folder)) {}

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
  Status compare(Job& job, const Document& input, const std::string& content);
  std::string made_from(const std::string& content) const;
  std::string recorded_input(const Job& job) const;
  Status note_up_to_date(Job& job, const std::string& key);
  Expected<bool> is_up_to_date(Job& job, const std::string& key);
  bool is_checked(Job& job, const std::string& key) const;
  Status check_output(const Job& job) const;
  Status check_report_beside(const Document& document);

  const BatchArguments& arguments_;
  const Session& session_;
  BatchRecord& record_;
  MemoryBudget& memory_;
  const std::filesystem::path staging_folder_;
  std::atomic<bool> spares_report_ = false;
};

}  // namespace psplit
