#include "tools/gltf_psplit/batch/batch_record.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "gltf_ext/document/image_bytes.h"
#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "system/files.h"
#include "system/io_error.h"
#include "system/text_lines.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = ".gltf-psplit-batch";
constexpr std::string_view kLineBegin = "{\"name\":\"";
constexpr std::string_view kWithdrawn = "withdrawn", kRemoved = "removed";

bool is_written(std::string_view output) {
  return !output.empty() && output != kWithdrawn && output != kRemoved;
}
bool is_written(const Hash128& output) {
  static const Hash128 others[] = {hash_of(""), hash_of(kWithdrawn), hash_of(kRemoved)};
  return std::ranges::find(others, output) == std::end(others);
}

// The name in a line, percent-encoded, without parsing the line: a shard reads the lines of all others.
std::string_view name_in(std::string_view line) {
  if (!line.starts_with(kLineBegin)) return {};
  line.remove_prefix(kLineBegin.size());
  return line.substr(0, std::min(line.find('"'), line.size()));
}

// Whether a record is that of another shard of the same count. It says nothing about the outputs of `shard`.
bool is_of_sibling(const std::string& file, const Shard& shard) {
  return file != shard.file_name() + ".jsonl" &&
         file.ends_with("-of-" + std::to_string(shard.count) + ".jsonl");
}

std::vector<fs::path> record_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(record_folder(folder), error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.ends_with(".jsonl") && !name.ends_with(".report.jsonl")) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Expected<OutputFiles> hash_files(std::span<const fs::path> files) {
  OutputFiles output;
  ContentHash hash;
  for (const fs::path& file : files) {
    const Expected<MappedFile> bytes = MappedFile::open(file);
    if (!bytes) return bytes.status();
    hash.add_framed(bytes->bytes());
    output.paths.push_back(file.string());
    output.bytes.files += bytes->bytes().size();
  }
  output.hash = hash.hex();
  return output;
}

}  // namespace

std::string hash_asset(const Document& document) {
  ContentHash hash;
  hash.add_framed(json_line(document.json()));
  for (const auto& buffer : document.buffers) hash.add_framed(buffer);
  for (const LinkedFile& link : linked_files(document)) {
    const Expected<std::vector<uint8_t>> bytes =
        link.state == LinkState::kFound ? read_file(link.path) : io_failure("missing");
    if (bytes)
      hash.add_framed(*bytes);
    else
      hash.add_framed("missing");
  }
  return hash.hex();
}

Expected<OutputFiles> hash_output(const fs::path& path) {
  const Expected<Document> document = read_document(path);
  if (!document) return document.status();
  std::vector<fs::path> files = document->files;
  for (const LinkedFile& link : linked_files(*document))
    if (link.state == LinkState::kFound) files.push_back(link.path);
  Expected<OutputFiles> output = hash_files(files);
  if (output) output->bytes = bytes_on_disk(*document);
  return output;
}

Expected<OutputFiles> hash_output(const fs::path& path, const Document& document, const WriteReport& written) {
  // Images in the JSON have moved to views.
  const ImageBytes images = image_bytes(document.json(), {});
  const bool is_alone = written.files.size() == 1 && images.in_json == 0 && linked_files(document).empty();
  if (!is_alone) return hash_output(path);
  Expected<OutputFiles> output = hash_files(written.files);
  if (output) output->bytes.textures = images.total();
  return output;
}

fs::path record_folder(const fs::path& output_folder) { return output_folder / kFolder; }
fs::path division_file(const fs::path& folder) { return record_folder(folder) / "division"; }

std::string record_name(const std::string& name, const std::string& check) {
  return percent_encode(name) + (check.empty() ? "" : "?" + check);
}

Status BatchRecord::open(const fs::path& folder, const Shard& shard) {
  const fs::path records = record_folder(folder);
  if (Status status = make_folders(records); !status.ok()) return status;
  const Expected<bool> joined = division_.join(division_file(folder), std::to_string(shard.count));
  if (!joined) return joined.status();
  if (!*joined)
    return may_pass("another batch, with another number of shards, is running in " + folder.string());
  const Expected<bool> is_ours = file_.open(records / (shard.file_name() + ".jsonl"));
  if (!is_ours) return is_ours.status();
  if (*is_ours) return {};
  return may_pass(shard.count == 1 ? "another batch is running in " + folder.string()
                                   : "shard " + shard.text() + " is already running in " + folder.string());
}

Status BatchRecord::join(const fs::path& folder, const Shard& shard) {
  return file_.join(record_folder(folder) / (shard.file_name() + ".jsonl"));
}

Status BatchRecord::load(const fs::path& folder, const Shard& shard) {
  facts_.clear();
  files_.clear();
  begun_.clear();
  file_.resume();
  for (const fs::path& file : record_files(folder)) {
    if (is_of_sibling(file.filename().string(), shard)) continue;
    if (Status status = load_file(file, shard); !status.ok()) return status;
  }
  std::sort(facts_.begin(), facts_.end());
  forget_removed();
  return {};
}

// What was said about an output before it was removed counts no more.
void BatchRecord::forget_removed() {
  const Hash128 removed = hash_of(kRemoved);
  for (auto begin = facts_.begin(); begin != facts_.end();) {
    const auto end =
        std::find_if(begin, facts_.end(), [&](const Fact& fact) { return fact.name != begin->name; });
    int64_t last = -1;
    for (auto fact = begin; fact != end; ++fact)
      if (fact->output == removed) last = std::max(last, fact->number);
    // Numbers that cannot be: the facts are erased below, all at once.
    for (auto fact = begin; fact != end; ++fact)
      if (fact->number <= last) fact->number = -1;
    begin = end;
  }
  std::erase_if(facts_, [](const Fact& fact) { return fact.number < 0; });
}

Status BatchRecord::load_file(const fs::path& file, const Shard& shard) {
  Expected<TextLines> lines = TextLines::open(file);
  if (!lines) return lines.status();
  files_.push_back(file);
  for (std::string_view line; lines->next(line);) {
    const std::string_view name = name_in(line);
    if (name.empty() || !lines->is_whole()) continue;
    // What follows the name of an asset that was only checked, "?validate", is not a part of it.
    if (!shard.owns(percent_decode(name.substr(0, name.find('?'))))) continue;
    const Expected<Json> json = parse_json(line);
    if (!json) continue;
    const std::string *made_from = string_field(*json, "made_from"), *output = string_field(*json, "output");
    if (made_from == nullptr || output == nullptr) continue;
    const int64_t number = std::max<int64_t>(0, integer_field(*json, "number").value_or(0));
    facts_.push_back(
        {hash_of(name), hash_of(*made_from), hash_of(*output), number, files_.size() - 1, lines->offset()});
    last_number_ = std::max(last_number_, facts_.back().number);
    if (output->empty())
      begun_.emplace(name);
    else
      begun_.erase(std::string(name));
  }
  return lines->status();
}

std::pair<std::vector<BatchRecord::Fact>::const_iterator, std::vector<BatchRecord::Fact>::const_iterator>
BatchRecord::facts(const std::string& name) const {
  // clang 14 does not compile std::ranges::equal_range of libstdc++ 12.
  const Hash128 hash = hash_of(name);
  const auto is_before = [](const Fact& fact, const Hash128& other) { return fact.name < other; };
  const auto begin = std::lower_bound(facts_.begin(), facts_.end(), hash, is_before);
  return {begin, std::find_if(begin, facts_.end(), [&](const Fact& fact) { return fact.name != hash; })};
}

std::vector<BatchRecord::Fact>::const_iterator BatchRecord::newest_of(std::vector<Fact>::const_iterator begin,
                                                                      std::vector<Fact>::const_iterator end) {
  return std::max_element(begin, end, [](const Fact& a, const Fact& b) { return a.number < b.number; });
}

bool BatchRecord::knows(const std::string& name) const {
  const auto [begin, end] = facts(name);
  if (std::any_of(begin, end, [](const Fact& fact) { return is_written(fact.output); })) return true;
  const auto newest = newest_of(begin, end);
  return newest != end && newest->output != hash_of(kWithdrawn);
}

bool BatchRecord::has(const std::string& name, const Entry& entry) const {
  const auto [begin, end] = facts(name);
  const Hash128 made_from = hash_of(entry.made_from), output = hash_of(entry.output);
  return std::any_of(begin, end,
                     [&](const Fact& fact) { return fact.made_from == made_from && fact.output == output; });
}

bool BatchRecord::is_newest(const std::string& name, const std::string& made_from) const {
  const auto [begin, end] = facts(name);
  const auto newest = newest_of(begin, end);
  return newest != end && is_written(newest->output) && newest->made_from == hash_of(made_from);
}

Expected<Json> BatchRecord::line_of(const Fact& fact) const {
  std::ifstream file(files_[fact.file], std::ios::binary);
  std::string line;
  file.seekg(static_cast<std::streamoff>(fact.at));
  if (!std::getline(file, line)) return io_failure("cannot read", {.file = files_[fact.file].string()});
  return parse_json(line);
}

Json BatchRecord::line(const std::string& name, const std::string& made_from) const {
  const auto [begin, end] = facts(name);
  const Hash128 wanted = hash_of(made_from);
  std::vector<Fact> found;
  std::copy_if(begin, end, std::back_inserter(found),
               [&](const Fact& fact) { return is_written(fact.output) && fact.made_from == wanted; });
  if (found.empty()) return {};
  const Expected<Json> line = line_of(*newest_of(found.begin(), found.end()));
  return line ? *line : Json();
}

Status BatchRecord::for_each_written(const std::function<void(const Json& line)>& visit) const {
  for (auto begin = facts_.begin(); begin != facts_.end();) {
    const Fact* newest = nullptr;
    auto fact = begin;
    for (; fact != facts_.end() && fact->name == begin->name; ++fact)
      if (is_written(fact->output) && (newest == nullptr || newest->number < fact->number)) newest = &*fact;
    begin = fact;
    if (newest == nullptr) continue;
    const Expected<Json> line = line_of(*newest);
    if (!line) return line.status();
    visit(*line);
  }
  return {};
}

std::set<fs::path> BatchRecord::unfinished_folders() const {
  std::set<fs::path> folders;
  for (const std::string& name : begun_) {
    const auto [begin, end] = facts(name);  // another file may end what this one began
    if (begin != end && newest_of(begin, end)->output == hash_of(""))
      folders.insert(fs::path(percent_decode(name)).parent_path());
  }
  return folders;
}

Status BatchRecord::withdraw(const std::string& name) { return add(name, {"", std::string(kWithdrawn)}); }
Status BatchRecord::forget(const std::string& name) { return add(name, {"", std::string(kRemoved)}); }

Status BatchRecord::add(const std::string& name, Entry entry) {
  const std::lock_guard lock(mutex_);
  Json line = object_with_room(6);
  line["name"] = name;
  line["made_from"] = std::move(entry.made_from);
  line["output"] = std::move(entry.output);
  line["number"] = ++last_number_;
  for (auto& [key, value] : entry.details.items()) line[key] = std::move(value);
  return file_.append(json_line(line) + "\n");
}

Status BatchRecord::sync() {
  const std::lock_guard lock(mutex_);
  return file_.sync();
}

Status merge_records(const fs::path& folder) {
  struct Line {
    Hash128 name;
    int64_t number = 0;
    bool is_written = false;
    size_t file = 0;
    uint64_t at = 0;  // in the file
    auto operator<=>(const Line&) const = default;
  };
  std::vector<Line> lines;
  const std::vector<fs::path> files = record_files(folder);
  // Visits the number of a file, that of a line in it, and the line.
  const auto for_each_line = [&](const auto& visit) -> Status {
    for (size_t file = 0; file < files.size(); ++file) {
      Expected<TextLines> text = TextLines::open(files[file]);
      if (!text) return text.status();
      for (std::string_view line; text->next(line);)
        if (text->is_whole() && !name_in(line).empty()) visit(file, text->number(), line);
      if (!text->status().ok()) return text->status();
    }
    return {};
  };
  Status status = for_each_line([&](size_t file, uint64_t at, std::string_view line) {
    const Expected<Json> json = parse_json(line);
    const std::string* output = json ? string_field(*json, "output") : nullptr;
    if (output == nullptr || string_field(*json, "made_from") == nullptr) return;
    lines.push_back(
        {hash_of(name_in(line)), integer_field(*json, "number").value_or(0), is_written(*output), file, at});
  });
  if (!status.ok()) return status;
  std::sort(lines.begin(), lines.end());
  // Of each name, the newest line is kept, and the newest that says that the output was written.
  std::vector<std::pair<size_t, uint64_t>> kept;
  bool has_written = false;
  for (size_t i = lines.size(); i-- > 0;) {
    const bool is_newest = i + 1 == lines.size() || lines[i + 1].name != lines[i].name;
    if (is_newest) has_written = false;
    if (is_newest || (lines[i].is_written && !has_written)) kept.emplace_back(lines[i].file, lines[i].at);
    has_written = has_written || lines[i].is_written;
  }
  std::sort(kept.begin(), kept.end());

  const fs::path merged = record_folder(folder) / "merged.jsonl";
  Status read;
  status = write_file(merged, [&](std::FILE* out) {
    auto next = kept.begin();
    bool is_whole = true;
    read = for_each_line([&](size_t file, uint64_t at, std::string_view line) {
      if (next == kept.end() || *next != std::pair(file, at)) return;
      ++next;
      is_whole = is_whole && std::fwrite(line.data(), 1, line.size(), out) == line.size() &&
                 std::fputc('\n', out) != EOF;
    });
    return is_whole && read.ok() && sync_to_disk(out);
  });
  if (!read.ok()) return read;
  if (!status.ok()) return status;
  // The other files have the same facts. They go only when a power failure no longer loses the new file.
  if (status = sync_to_disk(record_folder(folder)); !status.ok()) return status;
  std::error_code ignored;  // a file that stays repeats facts
  for (const fs::path& file : files)
    if (file != merged) fs::remove(file, ignored);
  return {};
}

}  // namespace psplit
