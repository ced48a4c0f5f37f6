#include "tools/gltf_psplit/batch/batch_plan.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>

#include "mesh_files/read_asset.h"
#include "system/content_hash.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "system/text_lines.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

fs::path whole_path(const fs::path& path) {
  fs::path whole = fs::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();  // without a trailing slash
}

bool is_same_path(const fs::path& a, const fs::path& b) {
  return a == b || name_to_compare(a.string()) == name_to_compare(b.string());
}

// The components of a path below the folder; empty if the path is not below it.
fs::path path_below(const fs::path& folder, const fs::path& path) {
  auto [in_folder, in_path] =
      std::mismatch(folder.begin(), folder.end(), path.begin(), path.end(), is_same_path);
  fs::path rest;
  if (in_folder == folder.end())
    for (; in_path != path.end(); ++in_path) rest /= *in_path;
  return rest;
}
bool is_below(const fs::path& path, const fs::path& folder) { return !path_below(folder, path).empty(); }

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end; !error && entry != end;
       entry.increment(error))
    entries.push_back(folder / entry->path().filename());
  std::sort(entries.begin(), entries.end());
  return entries;
}

// A file, or a link whose target cannot be found: such an asset fails, and is not left out in silence.
bool is_file_or_broken_link(const fs::path& entry) {
  std::error_code error;
  const fs::file_status target = fs::status(entry, error);
  if (!error) return fs::is_regular_file(target);
  return fs::is_symlink(fs::symlink_status(entry, error));
}

// Matches a pattern part by part.
void match(const fs::path& folder, fs::path::const_iterator part, fs::path::const_iterator end,
           std::vector<fs::path>& found) {
  std::error_code error;
  if (part == end) return;
  const bool is_last = std::next(part) == end;
  if (*part == "**") {
    match(folder, std::next(part), end, found);
    for (const fs::path& entry : sorted_entries(folder))
      if (is_searched_folder(entry)) match(entry, part, end, found);
    return;
  }
  const auto visit = [&](const fs::path& entry) {
    if (is_last && is_file_or_broken_link(entry)) found.push_back(entry);
    if (!is_last && fs::is_directory(entry, error)) match(entry, std::next(part), end, found);
  };
  if (!is_pattern(part->string())) return visit(folder / *part);
  for (const fs::path& entry : sorted_entries(folder))
    if (matches_pattern(entry.filename().string(), part->string())) visit(entry);
}

class Planner {
 public:
  explicit Planner(const BatchRequest& request) : request_(request), folder_(whole_path(request.folder)) {}

  Expected<std::vector<BatchItem>> run() {
    for (const std::string& word : request_.words) {
      Status status = word.starts_with('@') ? add_list(word.substr(1)) : add_word(word);
      if (!status.ok()) return status;
    }
    if (inputs_.empty()) return wrong_usage("there is no input");
    std::ranges::stable_sort(inputs_, std::less<>(), &Input::whole);
    const auto is_same = [](const Input& a, const Input& b) { return a.whole == b.whole; };
    inputs_.erase(std::unique(inputs_.begin(), inputs_.end(), is_same), inputs_.end());
    if (!request_.base.empty()) base_ = whole_path(request_.base);
    std::vector<BatchItem> items;
    for (const Input& input : inputs_) {
      const fs::path below = path_below(base_, input.whole);
      if (below.empty())
        return wrong_usage(input.word + (request_.base.empty()
                                             ? " has no folder in common with the other inputs"
                                             : " is not below " + base_.string()));
      fs::path relative = without_asset_extensions(below);
      relative += request_.extension;
      std::error_code error;
      const uintmax_t bytes = fs::file_size(input.word, error);
      items.push_back({.input = input.word, .name = relative.generic_string()});
      if (!error) items.back().bytes = bytes;
    }
    if (Status status = check_outputs(items); !status.ok()) return status;
    std::ranges::stable_sort(items, std::greater<>(), [](const BatchItem& item) { return item.bytes; });
    return items;
  }

 private:
  struct Input {
    std::string whole;  // the absolute path
    std::string word;   // as the user wrote it
  };

  // No two inputs may have one output, and no output may be an input. There may be millions of paths: their
  // hashes take less memory.
  Status check_outputs(const std::vector<BatchItem>& items) const {
    std::vector<std::pair<Hash128, size_t>> names, files;
    for (size_t i = 0; i < items.size(); ++i) {
      names.emplace_back(hash_of(name_to_compare(items[i].name)), i);
      // Through links, one file may have two names.
      files.emplace_back(hash_of(whole_name(inputs_[i].whole)), i);
    }
    std::sort(names.begin(), names.end());
    std::sort(files.begin(), files.end());
    for (size_t i = 1; i < names.size(); ++i)
      if (names[i - 1].first == names[i].first)
        return wrong_usage(items[names[i - 1].second].input + " and " + items[names[i].second].input +
                           " would both become " + (request_.folder / items[names[i].second].name).string());
    for (const BatchItem& item : items) {
      const Hash128 output = hash_of(whole_name(folder_ / item.name));
      const auto found = std::lower_bound(files.begin(), files.end(), std::pair(output, size_t{0}));
      if (found != files.end() && found->first == output)
        return wrong_usage(item.input + " would replace the input " + items[found->second].input);
    }
    return {};
  }

  Status add_list(const std::string& name) {
    Expected<TextLines> lines = TextLines::open(name);
    if (!lines) return lines.status();
    for (std::string_view line; lines->next(line);) {
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (line.empty() || line.starts_with('#')) continue;
      if (Status status = add_word(std::string(line)); !status.ok()) return status;
    }
    return lines->status();
  }

  Status add_word(const std::string& word) {
    std::error_code error;
    if (fs::is_directory(word, error))
      return add_matches(fs::path(word), fs::path("**") / "*", "no asset is in the folder " + word);
    if (word == "-") return wrong_usage("stdin (-) cannot be one of many inputs");
    if (!fs::exists(word, error) && is_pattern(word)) return add_pattern(word);
    add(word, fs::path(word).parent_path());
    return {};
  }

  Status add_pattern(const fs::path& pattern) {
    fs::path fixed = pattern.root_path();
    const fs::path parts = pattern.relative_path();
    auto part = parts.begin();
    fs::path rest;
    for (; std::next(part) != parts.end() && !is_pattern(part->string()); ++part) fixed /= *part;
    for (; part != parts.end(); ++part) rest /= *part;
    return add_matches(fixed, rest, "no asset matches " + pattern.string());
  }

  // The assets below a folder that a pattern matches.
  Status add_matches(const fs::path& fixed, const fs::path& pattern, const std::string& none) {
    std::vector<fs::path> found;
    match(fixed, pattern.begin(), pattern.end(), found);
    bool any = false, any_output = false;
    for (const fs::path& file : found) {
      if (!is_asset_name(file)) continue;
      const bool is_output = is_below(whole_path(file), folder_);
      if (!is_output) add(file.string(), fixed);
      (is_output ? any_output : any) = true;
    }
    if (any) return {};
    return wrong_usage(any_output ? none + " outside " + request_.folder.string() +
                                        ", which is for the outputs: choose another folder for them"
                                  : none);
  }

  void add(const std::string& input, const fs::path& start) {
    inputs_.push_back({whole_path(input).string(), input});
    const fs::path folder = whole_path(start.empty() ? "." : start);
    if (base_.empty()) base_ = folder;
    // Of two drives, one is not below the folder that is left, and `run` says so.
    while (!is_same_path(folder, base_) && !is_below(folder, base_) && base_.has_relative_path())
      base_ = base_.parent_path();
  }

  const BatchRequest& request_;
  fs::path folder_, base_;
  std::vector<Input> inputs_;
};

}  // namespace

bool is_pattern(std::string_view text) { return text.find_first_of("*?[") != std::string_view::npos; }

Expected<std::vector<BatchItem>> plan_batch(const BatchRequest& request) { return Planner(request).run(); }

}  // namespace psplit
