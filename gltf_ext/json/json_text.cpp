#include "gltf_ext/json/json_text.h"

#include <algorithm>
#include <vector>

#include "gltf_ext/json/text_encoding.h"

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

// Where the byte `at` is, counted from 1. An end of the text is behind its last byte.
std::string place_in(std::string_view text, size_t at) {
  if (text.find('\n') == text.npos) return "byte " + std::to_string(at);
  const std::string_view before = text.substr(0, at > 0 ? at - 1 : 0);
  const auto lines = std::count(before.begin(), before.end(), '\n');
  const size_t line_begin = before.rfind('\n') + 1;  // 0 if there is none
  return "line " + std::to_string(lines + 1) + ", column " + std::to_string(before.size() - line_begin + 1);
}

}  // namespace

Expected<Json> parse_json(std::string_view text) {
  text = without_byte_order_mark(text);
  if (Status status = check_text_encoding(text); !status.ok()) return status;
  if (Status status = check_limits(text); !status.ok()) return status;
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& error) {
    return invalid_input("not valid JSON: " + place_in(text, error.byte));
  } catch (const Json::exception&) {
    return invalid_input("the JSON has a number that no double holds");
  }
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
