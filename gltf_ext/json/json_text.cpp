#include "gltf_ext/json/json_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>
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

// Up to this many characters, digits are the fewest.
constexpr size_t kMostFewest = 16;

// Writes JSON as nlohmann's library does, which looks at each character of a string.
class TextWriter {
 public:
  // `indent` spaces for each level; all in one line if it is negative.
  explicit TextWriter(int indent) : indent_(indent) {}

  std::string write(const Json& json) && {
    add(json);
    return std::move(text_);
  }

 private:
  void add(const Json& json) {
    switch (json.type()) {
      case Json::value_t::object:
        add_all(*json.get_ptr<const Json::object_t*>(), '{', '}', [&](const auto& member) {
          add_string(member.first);
          text_ += indent_ < 0 ? ":" : ": ";
          add(member.second);
        });
        break;
      case Json::value_t::array:
        add_all(*json.get_ptr<const Json::array_t*>(), '[', ']', [&](const Json& element) { add(element); });
        break;
      case Json::value_t::string: add_string(*json.get_ptr<const Json::string_t*>()); break;
      case Json::value_t::number_float: add_float(json); break;
      case Json::value_t::number_integer: add_integer(*json.get_ptr<const int64_t*>()); break;
      case Json::value_t::number_unsigned: add_integer(*json.get_ptr<const uint64_t*>()); break;
      default: text_ += json.dump();
    }
  }

  template <typename List, typename Add>
  void add_all(const List& list, char begin, char end, const Add& add_one) {
    text_ += begin;
    ++depth_;
    bool is_first = true;
    for (const auto& one : list) {
      if (!std::exchange(is_first, false)) text_ += ',';
      begin_line();
      add_one(one);
    }
    --depth_;
    if (!is_first) begin_line();
    text_ += end;
  }

  void begin_line() {
    if (indent_ < 0) return;
    text_ += '\n';
    text_.append(depth_ * static_cast<size_t>(indent_), ' ');
  }

  // Most strings are names that have no character to escape.
  void add_string(const std::string& string) {
    const bool is_plain = std::all_of(string.begin(), string.end(),
                                      [](char c) { return c >= ' ' && c < '\x7f' && c != '"' && c != '\\'; });
    if (!is_plain) {
      text_ += Json(string).dump(-1, ' ', false, Json::error_handler_t::replace);
      return;
    }
    text_ += '"';
    text_ += string;
    text_ += '"';
  }

  template <typename Integer>
  void add_integer(Integer number) {
    std::array<char, 24> digits;
    text_.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
  }

  // nlohmann's digits give the number back, but in one of some thousand numbers they are not the fewest. An
  // asset that stays as it is would grow by that.
  void add_float(const Json& json) {
    const std::string number = json.dump();
    if (number.size() > kMostFewest && number.find('.') != number.npos) {
      std::array<char, 32> digits;
      const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), json.get<double>()).ptr;
      const std::string_view fewest(digits.data(), static_cast<size_t>(end - digits.data()));
      if (fewest.size() < number.size() && fewest.find('.') != fewest.npos) {
        text_ += fewest;
        return;
      }
    }
    text_ += number;
  }

  const int indent_;
  size_t depth_ = 0;
  std::string text_;
};

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

std::string json_line(const Json& json) { return TextWriter(-1).write(json); }
std::string json_lines(const Json& json) { return TextWriter(2).write(json); }

bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

}  // namespace psplit
