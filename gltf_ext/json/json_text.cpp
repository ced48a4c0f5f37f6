#include "gltf_ext/json/json_text.h"

#include <vector>

namespace psplit {
namespace {

constexpr size_t kMaxMembers = 16384;

// Looks at brackets and colons only. The parser checks the rest.
Status check_limits(std::string_view text) {
  std::vector<size_t> members;  // of each open array or object
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '{' || c == '[') {
      members.push_back(0);
      if (members.size() > static_cast<size_t>(kMaxJsonDepth))
        return invalid_input("the JSON nests too deeply");
    }
    if ((c == '}' || c == ']') && !members.empty()) members.pop_back();
    if (c == ':' && !members.empty() && ++members.back() > kMaxMembers)
      return invalid_input("a JSON object has over " + std::to_string(kMaxMembers) + " members");
  }
  return {};
}

}  // namespace

Expected<Json> parse_json(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (Status status = check_limits(text); !status.ok()) return status;
  Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) return invalid_input("not valid JSON");
  return json;
}

std::string json_line(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }
std::string json_lines(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace); }

bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

}  // namespace psplit
