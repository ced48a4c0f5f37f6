#include "tools/gltf_psplit/batch/batch_report.h"

#include <algorithm>
#include <cerrno>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "system/files.h"
#include "system/io_error.h"
#include "system/text_lines.h"
#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/report/exit_codes.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

constexpr size_t kSlowest = 3;
constexpr size_t kFailures = 20;

uint64_t count_in(const Json& object, const char* name) {
  return static_cast<uint64_t>(integer_field(object, name).value_or(0));
}
double number_in(const Json& object, const char* name) { return number_field(object, name).value_or(0); }

AssetBytes bytes_of(const Json& sizes, const char* side) {
  const Json* bytes = object_field(sizes, side);
  return bytes == nullptr ? AssetBytes()
                          : AssetBytes{count_in(*bytes, "bytes"), count_in(*bytes, "texture_bytes")};
}

}  // namespace

const char* done_word(BatchVerb verb) {
  switch (verb) {
    case BatchVerb::kEncode: return "encoded";
    case BatchVerb::kDecode: return "decoded";
    case BatchVerb::kValidate: return "validated";
    case BatchVerb::kDiff: return "compared";
  }
  return "";
}

Json figures_of(const BatchOutcome& outcome, BatchVerb verb) {
  Json figures = object_with_room(4);
  if (outcome.sizes.output.files > 0) figures["files"] = sizes_json(outcome.sizes);
  if (verb != BatchVerb::kEncode) return figures;
  figures["geometry"] = {{"input_bytes", outcome.result.geometry.input},
                         {"output_bytes", outcome.result.geometry.output}};
  append_row(figures["total"], outcome.result.total);
  return figures;
}

Json to_json(BatchOutcome outcome, BatchVerb verb) {
  Json asset = object_with_room(16);
  asset["input"] = outcome.input;
  if (!outcome.output.empty()) asset["output"] = outcome.output;
  const bool is_done = outcome.status.ok() && !outcome.up_to_date && !outcome.planned;
  asset["status"] = !outcome.status.ok() ? "failed"
                    : outcome.up_to_date ? "up to date"
                    : outcome.planned    ? "planned"
                                         : done_word(verb);
  if (!outcome.status.ok())
    asset["error"] = {{"code", exit_code(outcome.status.code())}, {"message", outcome.status.to_string()}};
  const auto move_figures = [&] {
    for (auto& [key, value] : outcome.figures.items()) asset[key] = std::move(value);
  };
  if (is_done) {
    move_figures();
    if (outcome.sizes.output.files > 0) append_written(asset, outcome.written);
    if (verb == BatchVerb::kEncode) asset["primitives"] = std::move(outcome.result.primitives);
    if (!outcome.result.dropped_attributes.empty())
      asset["dropped_attributes"] = outcome.result.dropped_attributes;
  } else if (outcome.up_to_date) {
    move_figures();
  }
  if (!outcome.details.is_null()) asset["result"] = std::move(outcome.details);
  if (outcome.memory > 0)
    asset["memory"] = {{"estimate", outcome.memory}, {"peak_of_process", outcome.peak_memory}};
  asset["wall_ms"] = outcome.wall_ms;
  return asset;
}

void BatchTally::add(const Json& row) {
  ++assets_;
  const std::string *status = string_field(row, "status"), *input = string_field(row, "input");
  const std::string word = status == nullptr ? "failed" : *status;
  if (word == "planned") ++planned_;
  if (word == "failed") {
    ++failed_;
    const Json* error = object_field(row, "error");
    const StatusCode code =
        error == nullptr ? StatusCode::kOk : status_code(integer_field(*error, "code").value_or(-1));
    const bool may_pass = code == StatusCode::kMayPass || code == StatusCode::kOutOfMemory;
    if (may_pass) ++may_pass_;
    const std::string name = input == nullptr ? "" : *input;
    if (!may_pass && (first_ == StatusCode::kOk || name < first_input_)) {
      first_ = code;
      first_input_ = name;
    }
    const std::string* message = error == nullptr ? nullptr : string_field(*error, "message");
    if (message != nullptr && failures_.size() < kFailures) failures_.push_back(*message);
  }
  const bool is_done = word == done_word(verb_), is_up_to_date = word == "up to date";
  if (!is_done && !is_up_to_date) return;
  const Json *total = object_field(row, "total"), *files = object_field(row, "files");
  if (total != nullptr) total_ += row_of(*total);
  if (files != nullptr) sizes_ += {bytes_of(*files, "input"), bytes_of(*files, "output")};
  if (is_up_to_date) {
    ++up_to_date_;
    return;
  }
  ++done_;
  slowest_.push_back({number_in(row, "wall_ms"), input == nullptr ? "" : *input});
  std::ranges::stable_sort(slowest_, std::greater<>(), &Slow::wall_ms);
  if (slowest_.size() > kSlowest) slowest_.pop_back();
}

std::string BatchTally::counts_text(const std::string& what, double wall_ms) const {
  return what + ": " + counted(assets_, "asset") + ", " +
         (planned_ > 0 ? with_separators(planned_) + " to do, "
                       : with_separators(done_) + " " + done_word(verb_) + ", ") +
         with_separators(up_to_date_) + " up to date, " + with_separators(failed_) + " failed" +
         (wall_ms > 0 ? "; " + as_duration(wall_ms) : "");
}

std::string BatchTally::totals_text() const {
  const std::string sizes = sizes_text(sizes_);
  if (sizes.empty() || planned_ > 0) return "";
  return sizes + (verb_ == BatchVerb::kEncode ? "; " + counted(total_.summary.patches, "patch") : "");
}

std::string BatchTally::line(const std::string& what, double wall_ms) const {
  const std::string totals = totals_text();
  return counts_text(what, wall_ms) + (totals.empty() ? "" : "; ") + totals;
}

std::string BatchTally::summary(const std::string& folder, double wall_ms) const {
  std::string text = counts_text(folder, wall_ms) + "\n";
  if (done_ == 0 && failed_ == 0 && planned_ == 0)
    text += "nothing was " + std::string(done_word(verb_)) + "\n";
  if (const std::string totals = totals_text(); !totals.empty()) text += totals + "\n";
  for (size_t i = 0; slowest_.size() > 1 && i < slowest_.size(); ++i)
    text += (i == 0 ? "slowest: " : ", ") + slowest_[i].input + " " + as_duration(slowest_[i].wall_ms) +
            (i + 1 == slowest_.size() ? "\n" : "");
  for (const std::string& failure : failures_) text += "failed: " + failure + "\n";
  if (failed_ > failures_.size())
    text += "and " + counted(failed_ - failures_.size(), "more failure") + "; the report lists all\n";
  return text;
}

Json BatchTally::to_json() const {
  Json json{{done_word(verb_), done_},
            {"up_to_date", up_to_date_},
            {"failed", failed_},
            {"may_pass", may_pass_},
            {"files", sizes_json(sizes_)}};
  if (planned_ > 0) json["planned"] = planned_;
  if (verb_ == BatchVerb::kEncode) append_row(json["total"], total_);
  return json;
}

Status BatchTally::status(uint64_t max_failures) const {
  if (failed_ == 0) return {};
  const std::string message = std::to_string(failed_) + " of " + counted(assets_, "asset") + " failed";
  if (may_pass_ > 0)
    return psplit::may_pass(message + ", and " + std::to_string(may_pass_) +
                            " of them may succeed in another run");
  if (failed_ <= max_failures) return {};
  return {first_, message};
}

Status BatchRows::create(const std::filesystem::path& path) {
  name_ = path.empty() ? "the report" : path.string();
  file_.reset(path.empty() ? open_temporary() : open_file(path, "w+b"));
  return file_ == nullptr ? io_error("cannot write", errno, {.file = name_}) : Status();
}

Status BatchRows::open(const std::filesystem::path& path) {
  name_ = path.string();
  file_.reset(open_file(path, "rb"));
  return file_ == nullptr ? io_error("cannot open", errno, {.file = name_}) : Status();
}

Status BatchRows::add(std::string_view row) {
  if (std::fwrite(row.data(), 1, row.size(), file_.get()) == row.size() &&
      std::fputc('\n', file_.get()) != EOF && std::fflush(file_.get()) == 0)
    return {};
  return io_error("cannot write", errno, {.file = name_});
}

Status BatchRows::add_end(double wall_ms, const std::string& plan) {
  return add(json_line({{"ended", true}, {"wall_ms", wall_ms}, {"plan", plan}}));
}

std::optional<std::string> BatchRows::for_each(const std::function<bool(std::string_view row)>& visit) {
  std::rewind(file_.get());
  TextLines lines = TextLines::of(file_.get());
  for (std::string_view line; lines.next(line);) {
    if (!lines.is_whole()) break;
    if (line.starts_with(R"({"ended")")) {
      const Expected<Json> end = parse_json(line);
      const std::string* plan = end ? string_field(*end, "plan") : nullptr;
      return plan == nullptr ? std::string() : *plan;
    }
    if (!visit(line)) break;
  }
  return std::nullopt;
}

Status write_batch_report(const std::string& path, const Json& head,
                          const std::function<void(const RowVisitor&)>& for_each_row, IfReadOnly if_read_only) {
  const auto write_report = [&](std::FILE* file) {
    const auto write = [&](std::string_view text) {
      return std::fwrite(text.data(), 1, text.size(), file) == text.size();
    };
    std::string text = json_lines(head);
    text.resize(text.rfind('\n'));  // the brace that closes it follows the assets
    bool is_written = write(text + ",\n  \"assets\": ["), is_first = true;
    for_each_row([&](std::string_view row) {
      is_written = is_written && write(is_first ? "\n    " : ",\n    ") && write(row);
      is_first = false;
      return is_written;
    });
    return is_written && write(is_first ? "]\n}\n" : "\n  ]\n}\n");
  };
  return write_file(path, write_report, if_read_only);
}

}  // namespace psplit
