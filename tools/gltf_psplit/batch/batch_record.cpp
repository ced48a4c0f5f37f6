#include "tools/gltf_psplit/batch/batch_record.h"

#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/files/content_hash.h"
#include "gltf_ext/files/files.h"
#include "gltf_ext/files/uri.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecordName = ".gltf-psplit-batch.jsonl";

}  // namespace

std::string hash_asset(const Document& document) {
  ContentHash hash;
  hash.add_framed(document.json.dump(-1, ' ', false, Json::error_handler_t::replace));
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

Status BatchRecord::open(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path path = folder / kRecordName;
  const Expected<bool> is_ours = file_.open(path);
  if (!is_ours) return is_ours.status();
  if (!*is_ours) return io_failure("another batch is running in " + folder.string());
  const auto bytes = read_file(path);
  if (!bytes) return bytes.status();
  const std::string text(bytes->begin(), bytes->end());
  size_t at = 0;
  for (size_t end = text.find('\n'); end != std::string::npos; at = end + 1, end = text.find('\n', at)) {
    const auto line = parse_json(std::string_view(text).substr(at, end - at));
    if (!line) continue;
    const std::string *name = string_field(*line, "name"), *made_from = string_field(*line, "made_from"),
                      *output = string_field(*line, "output");
    if (name != nullptr && made_from != nullptr && output != nullptr) entries_[*name] = {*made_from, *output};
  }
  return at < text.size() ? file_.append("\n") : Status();
}

const BatchRecord::Entry* BatchRecord::find(const std::string& name) const {
  const auto found = entries_.find(percent_encode(name));
  return found == entries_.end() ? nullptr : &found->second;
}

Status BatchRecord::add(const std::string& name, const Entry& entry) {
  const std::string line =
      Json{{"name", percent_encode(name)}, {"made_from", entry.made_from}, {"output", entry.output}}.dump(
          -1, ' ', false, Json::error_handler_t::replace) +
      "\n";
  const std::lock_guard lock(mutex_);
  return file_.append(line);
}

}  // namespace psplit
