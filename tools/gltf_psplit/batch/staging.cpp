#include "tools/gltf_psplit/batch/staging.h"

#include <cerrno>
#include <random>
#include <sstream>
#include <string_view>
#include <vector>

#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/json/json_fields.h"
#include "mesh_files/asset_format.h"
#include "mesh_files/mtl.h"
#include "system/child_process.h"
#include "system/files.h"
#include "system/io_error.h"
#include "system/operating_system.h"
#include "system/uri.h"
#include "tools/gltf_psplit/report/asset_bytes.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStaged = "gltf-psplit-staged-", kLock = ".lock";

// A command that outlived its process may still write into such a folder, so that no name is used twice.
std::string random_digits() {
  std::random_device random;
  std::string digits;
  while (digits.size() < 16) digits += "0123456789abcdef"[random() % 16];
  return digits;
}

// The part of a path after its folders.
std::string local_name(const std::string& path) { return allowed_name(fs::path(path).filename().string()); }

void remove_dead_folders(const fs::path& place) {
  std::error_code error;
  std::vector<fs::path> locks;
  for (fs::directory_iterator entry(place, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(kStaged) && name.ends_with(kLock)) locks.push_back(entry->path());
  }
  for (const fs::path& lock : locks) {
    fs::path folder = lock;
    remove_if_unlocked(lock, [&] { return remove_folder(folder.replace_extension()); });
  }
}

using Variables = std::vector<std::pair<std::string, std::string>>;

// `is_missing`: set, without an error, if the command finds no such input.
Status run(const std::string& option, const std::string& command, const std::vector<std::string>& arguments,
           const Variables& variables = {}, bool* is_missing = nullptr) {
  constexpr int kNoInput = 66, kNoPermission = 77;  // of sysexits.h
  const Expected<CommandEnd> end = run_shell(command, arguments, variables);
  if (!end) return end.status();
  if (!end->by_signal && end->number == 0) return {};
  if (is_missing != nullptr && !end->by_signal && end->number == kNoInput) {
    *is_missing = true;
    return {};
  }
  const std::string message = option + " failed: " + (end->by_signal ? "signal " : "exit code ") +
                              std::to_string(end->number) +
                              (end->last_lines.empty() ? "" : ": " + end->last_lines);
  if (end->by_signal) return may_pass(message);
  // 126 and 127: the shell found no such command.
  if (end->number == 126 || end->number == 127) return wrong_usage(message);
  return end->number == kNoInput || end->number == kNoPermission ? io_failure(message) : may_pass(message);
}

// The names in the "mtllib" lines of an OBJ. A file that cannot be read has none: the reader says why.
std::vector<std::string> libraries_of(const fs::path& file) {
  std::vector<std::string> names;
  Expected<std::unique_ptr<ByteStream>> stream = open_byte_stream(file);
  if (!stream) return names;
  Expected<Scanner> scanner = open_scanner(std::move(*stream));
  if (!scanner || format_of(*scanner, file) != AssetFormat::kObj) return names;
  do {
    if (scanner->word() == "mtllib") names.push_back(scanner->rest_of_line().value_or(""));
  } while (scanner->next_line());
  return names;
}

// What a command brought is a file of that size with that hash.
Status check(const fs::path& file, const std::string& option, std::optional<uint64_t> bytes,
             const std::string& xxh128) {
  std::error_code error;
  if (!is_disk_file(file)) return may_pass(option + " made no file");
  const uintmax_t size = fs::file_size(file, error);
  if (bytes && size != *bytes)
    return may_pass(option + " made a file of " + std::to_string(size) + " bytes instead of " +
                    std::to_string(*bytes));
  if (xxh128.empty()) return {};
  const Expected<std::string> hash = hash_file(file);
  if (!hash) return hash.status();
  return *hash == xxh128 ? Status()
                         : may_pass(option + " made a file with the hash " + *hash + " instead of " + xxh128);
}

}  // namespace

bool remove_folder(const fs::path& folder) {
  std::error_code error, ignored;
  fs::remove_all(folder, error);
  if (!error) return true;
  std::vector<fs::path> found{folder};
  const auto options = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator entry(folder, options, error), end; !error && entry != end;
       entry.increment(error)) {
    fs::permissions(entry->path(), fs::perms::owner_write, fs::perm_options::add | fs::perm_options::nofollow,
                    ignored);
    found.push_back(entry->path());
  }
  for (auto path = found.rbegin(); path != found.rend(); ++path) fs::remove(*path, ignored);
  return !fs::exists(fs::symlink_status(folder, error));
}

Status StagingFolder::open(const fs::path& place) {
  if (Status status = make_folders(place); !status.ok()) return status;
  remove_dead_folders(place);
  do {
    path_ = place / (std::string(kStaged) + random_digits());
    lock_ = create_locked(path_.string() + std::string(kLock));
  } while (lock_ == nullptr && errno == EEXIST);
  return lock_ == nullptr ? io_error("cannot write", errno, {.file = path_.string() + std::string(kLock)})
                          : Status();
}

StagingFolder::~StagingFolder() {
  if (lock_ == nullptr) return;
  std::error_code ignored;
  if (remove_folder(path_)) fs::remove(path_.string() + std::string(kLock), ignored);
  std::fclose(lock_);
}

StagedAsset::~StagedAsset() {
  if (is_open_) remove_folder(folder_);
}

Status StagedAsset::open() {
  is_open_ = true;
  remove_folder(folder_);
  return make_folders(folder_);
}

// The names keep what tells the format.
Expected<fs::path> StagedAsset::fetch(const BatchItem& item) const {
  const fs::path file = input(item);
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (Status status = run("--fetch", commands_.fetch, {item.input, file.string()}); !status.ok()) return status;
  if (Status status = check(file, "--fetch", item.bytes, item.xxh128); !status.ok()) return status;
  return file;
}

fs::path StagedAsset::input(const BatchItem& item) const { return folder_ / "in" / local_name(item.input); }

// False if there is no such file.
Expected<bool> StagedAsset::fetch_beside(const BatchItem& item, const fs::path& relative) const {
  const fs::path file = folder_ / "in" / relative;
  std::error_code error;
  if (fs::exists(file, error)) return true;
  fs::create_directories(file.parent_path(), error);
  const size_t name_bytes = fs::path(item.input).filename().string().size();
  std::string source = item.input.substr(0, item.input.size() - name_bytes) + relative.generic_string();
  if (source.starts_with('-')) source = "./" + source;  // no option of the command
  bool is_missing = false;
  if (Status status = run("--fetch", commands_.fetch, {source, file.string()}, {}, &is_missing); !status.ok())
    return Status(status.code(), source + ": " + status.message());
  if (!is_missing)
    if (Status status = check(file, "--fetch", std::nullopt, ""); !status.ok()) return status;
  return !is_missing;
}

Status StagedAsset::fetch_parts(const BatchItem& item) const {
  const auto fetch_uri = [&](const std::string& uri) -> Expected<bool> {
    const Expected<fs::path> relative = relative_path_of_uri(uri, input(item).parent_path());
    return relative ? fetch_beside(item, *relative) : false;
  };
  if (const Expected<Json> json = read_asset_json(input(item).string()))
    for (size_t i = 0; i < array_size(*json, "buffers"); ++i)
      if (const std::string* uri = string_field((*json)["buffers"][i], "uri");
          uri != nullptr && !is_data_uri(*uri))
        if (const Expected<bool> found = fetch_uri(*uri); !found) return found.status();
  // As the reader takes it, a line names one file, whose name may contain spaces, or several files.
  for (const std::string& line : libraries_of(input(item))) {
    const Expected<bool> whole = fetch_uri(uri_of_path(line));
    if (!whole) return whole.status();
    std::istringstream names(*whole || line.find_first_of(" \t") == std::string::npos ? "" : line);
    for (std::string name; names >> name;)
      if (const Expected<bool> found = fetch_uri(uri_of_path(name)); !found) return found.status();
  }
  return {};
}

Status StagedAsset::fetch_links(const BatchItem& item, const Document& document) const {
  for (const LinkedFile& link : linked_files(document)) {
    if (link.state != LinkState::kMissing) continue;
    if (link.leaves_folder)
      return unsupported(link.place + " names " + link.uri +
                         ", and --fetch brings only files below the input's folder");
    if (const Expected<bool> found = fetch_beside(item, link.relative); !found) return found.status();
  }
  return {};
}

fs::path StagedAsset::output(const BatchItem& item) const { return folder_ / "out" / local_name(item.name); }

Status StagedAsset::store(const BatchItem& item, bool replaces) const {
  const fs::path file = output(item);
  std::error_code error;
  const uint64_t bytes = fs::file_size(file, error);
  const Expected<std::string> hash = hash_file(file);
  if (!hash) return hash.status();
  const Variables variables{{"PSPLIT_BYTES", std::to_string(bytes)},
                            {"PSPLIT_XXH128", *hash},
                            {"PSPLIT_REPLACE", replaces ? "1" : "0"}};
  if (Status status = run("--store", commands_.store, {file.string(), item.name}, variables); !status.ok())
    return status;
  if (commands_.fetch_output.empty()) return {};
  const Expected<fs::path> back = bring_back(item);
  return back ? check(*back, "--fetch-output", bytes, *hash) : back.status();
}

Expected<fs::path> StagedAsset::bring_back(const BatchItem& item) const {
  const fs::path folder = folder_ / "back", file = folder / local_name(item.name);
  std::error_code error;
  fs::create_directories(folder, error);
  if (Status status = run("--fetch-output", commands_.fetch_output, {item.name, file.string()}); !status.ok())
    return status;
  if (Status status = check(file, "--fetch-output", std::nullopt, ""); !status.ok()) return status;
  return file;
}

}  // namespace psplit
