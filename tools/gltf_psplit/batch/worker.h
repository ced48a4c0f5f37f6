// The child process of a batch, which works on the assets that its parent names, several at once.
#pragma once

#include "system/child_process.h"
#include "tools/gltf_psplit/batch/batch.h"
#include "tools/gltf_psplit/batch/batch_record.h"

namespace psplit {

// The lines between a batch and its worker. Sent to the worker: an item and its "id". To the batch:
//   {"id", "waits": true or false}   the asset waits for memory, or it runs
//   {"id", "row", "alone", "spares_report"}   the asset ended; `alone`: it may succeed when it is alone. Of the
//                                    row it has what BatchTally reads; kBeforeText and the whole row follow
//   {"failed": {"code", "message"}}  the worker cannot work at all
inline constexpr char kBeforeText = '\t';  // JSON text on one line has none

// Runs in the child, and returns its exit code. `record` is open, except in a dry run; the worker loads it.
int run_worker(ParentLink& link, const BatchArguments& arguments, const Session& session, BatchRecord& record,
               const std::filesystem::path& staging_folder);
// Works in a child process that shares no memory with the batch (take_parent_link).
Status run_started_worker(ParentLink& link, const BatchArguments& arguments, const Session& session);

}  // namespace psplit
