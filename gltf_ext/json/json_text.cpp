#include "gltf_ext/json/json_text.h"

#include <algorithm>
#include <array>
#include <charconv>
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

// The place of the byte `at`, counted from 1, as a text. The end of the document is one past its last byte.
std::string place_in(std::string_view text, size_t at) {
  if (text.find('\n') == text.npos) return "byte " + std::to_string(at);
  const std::string_view before = text.substr(0, at > 0 ? at - 1 : 0);
  const auto lines = std::count(before.begin(), before.end(), '\n');
  const size_t line_begin = before.rfind('\n') + 1;  // 0 if there is none
  return "line " + std::to_string(lines + 1) + ", column " + std::to_string(before.size() - line_begin + 1);
}

bool is_part_of_number(char c) {
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
}

// Up to this many characters, digits are the fewest.
constexpr size_t kMostFewest = 16;

// nlohmann's digits give the number back, but in one of some thousand numbers they are not the fewest. An asset
// that stays as it is would grow by that.
void append_number(std::string_view number, std::string& to) {
  std::array<char, 32> digits;
  if (number.size() > kMostFewest && number.find('.') != number.npos) {
    const auto value = Json::parse(number.begin(), number.end()).get<double>();
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    const std::string_view fewest(digits.data(), static_cast<size_t>(end - digits.data()));
    if (fewest.size() < number.size() && fewest.find('.') != fewest.npos) number = fewest;
  }
  to += number;
}

std::string text_of(const Json& json, int indent) {
  std::string text = json.dump(indent, ' ', false, Json::error_handler_t::replace);
  std::string result;
  size_t copied = 0;  // up to here, the text is in the result
  for (size_t i = 0; i < text.size();) {
    size_t end = i + 1;
    if (text[i] == '"') {
      for (; text[end] != '"'; ++end)
        if (text[end] == '\\') ++end;
      ++end;
    } else if (is_part_of_number(text[i])) {
      while (end < text.size() && is_part_of_number(text[end])) ++end;
      if (end - i > kMostFewest) {
        if (copied == 0) result.reserve(text.size());
        result.append(text, copied, i - copied);
        append_number(std::string_view(text).substr(i, end - i), result);
        copied = end;
      }
    }
    i = end;
  }
  if (copied == 0) return text;
  result.append(text, copied);
  return result;
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

std::string json_line(const Json& json) { return text_of(json, -1); }
std::string json_lines(const Json& json) { return text_of(json, 2); }

bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

}  // namespace psplit
