#include "gltf_ext/json/json_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "gltf_ext/json/text_encoding.h"

namespace psplit {
namespace {

constexpr size_t kMaxMembers = 16384;

// Builds the tree as nlohmann's parser calls it. That parser's own objects grow member by member, and an object
// that grows copies its members with their trees, because their names are constant.
class TreeBuilder {
 public:
  // What failed: a limit, or what parse_error was told.
  const Status& status() const { return status_; }
  size_t error_byte() const { return error_byte_; }  // counted from 1; 0 if the text is JSON
  Json tree() && { return std::move(tree_); }

  bool null() { return add(nullptr); }
  bool boolean(bool value) { return add(value); }
  bool number_integer(int64_t value) { return add(value); }
  bool number_unsigned(uint64_t value) { return add(value); }
  bool number_float(double value, const std::string&) { return add(value); }
  bool string(std::string& value) { return add(std::move(value)); }
  bool binary(Json::binary_t&) { return false; }  // JSON text has none
  bool start_object(size_t) { return open(Json(object_with_room(open_.empty() ? kMembersOfRoot : kMembers))); }
  bool start_array(size_t) { return open(Json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }

  bool key(std::string& name) {
    Json& object = *open_.back();
    // If a name is there twice, the second value counts.
    member_ = &(*object.get_ptr<Json::object_t*>())[name];
    if (object.size() <= kMaxMembers) return true;
    status_ = invalid_input("a JSON object has over " + std::to_string(kMaxMembers) + " members");
    return false;
  }

  bool parse_error(size_t byte, const std::string&, const Json::exception& error) {
    constexpr int kNumberOverflow = 406;
    if (error.id == kNumberOverflow)
      status_ = invalid_input("the JSON has a number that no double holds");
    else
      error_byte_ = byte;
    return false;
  }

 private:
  static constexpr size_t kMembers = 4, kMembersOfRoot = 16;  // that most objects do not exceed

  template <typename Value>
  bool add(Value&& value) {
    place() = std::forward<Value>(value);
    return true;
  }

  // Where the next value goes.
  Json& place() {
    if (open_.empty()) return tree_;
    if (open_.back()->is_object()) return *member_;
    return open_.back()->get_ptr<Json::array_t*>()->emplace_back();
  }

  bool open(Json&& value) {
    if (open_.size() >= static_cast<size_t>(kMaxJsonDepth)) {
      status_ = invalid_input("the JSON nests too deeply");
      return false;
    }
    Json& opened = place();
    opened = std::move(value);
    open_.push_back(&opened);
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  Json tree_;
  std::vector<Json*> open_;  // arrays and objects; each stays where it is while another in it is open
  Json* member_ = nullptr;   // of the innermost object
  Status status_;
  size_t error_byte_ = 0;
};

// The place of the byte `at`, counted from 1, as a text. The end of the document is one past its last byte.
std::string place_in(std::string_view text, size_t at) {
  if (text.find('\n') == text.npos) return "byte " + std::to_string(at);
  const std::string_view before = text.substr(0, at > 0 ? at - 1 : 0);
  const auto lines = std::count(before.begin(), before.end(), '\n');
  const size_t line_begin = before.rfind('\n') + 1;  // 0 if there is none
  return "line " + std::to_string(lines + 1) + ", column " + std::to_string(before.size() - line_begin + 1);
}

// Writes the text that nlohmann's library writes, but faster: the library looks at each character of a string.
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
      case Json::value_t::number_float: add_float(*json.get_ptr<const double*>()); break;
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

  // Writes the fewest digits that give the number back, in the layout of nlohmann's library. That library
  // writes more digits for one number in some thousand, so an asset that stays as it is would grow.
  void add_float(double number) {
    if (!std::isfinite(number)) {
      text_ += "null";
      return;
    }
    std::array<char, 32> scientific;  // as -1.25e+02
    const auto end = std::to_chars(scientific.data(), scientific.data() + scientific.size(), number,
                                   std::chars_format::scientific);
    std::string_view rest(scientific.data(), static_cast<size_t>(end.ptr - scientific.data()));
    if (rest.front() == '-') {
      text_ += '-';
      rest.remove_prefix(1);
    }
    const size_t e = rest.find('e');
    std::array<char, 24> digits;
    size_t count = 0;
    for (const char c : rest.substr(0, e))
      if (c != '.') digits[count++] = c;
    int exponent = 0;
    const std::string_view power = rest.substr(rest[e + 1] == '+' ? e + 2 : e + 1);
    std::from_chars(power.data(), power.data() + power.size(), exponent);
    add_digits(std::string_view(digits.data(), count), number == 0 ? 1 : exponent + 1);
  }

  // The number 0.`digits` times 10 to the power of `point`.
  void add_digits(std::string_view digits, int point) {
    constexpr int kMostBefore = 15, kMostZeros = 3;
    const auto count = static_cast<int>(digits.size());
    const auto zeros = [&](int number) { text_.append(static_cast<size_t>(number), '0'); };
    if (count <= point && point <= kMostBefore) {
      text_ += digits;
      zeros(point - count);
      text_ += ".0";
    } else if (0 < point && point <= kMostBefore) {
      text_ += digits.substr(0, static_cast<size_t>(point));
      text_ += '.';
      text_ += digits.substr(static_cast<size_t>(point));
    } else if (-kMostZeros <= point && point <= 0) {
      text_ += "0.";
      zeros(-point);
      text_ += digits;
    } else {
      text_ += digits[0];
      if (count > 1) {
        text_ += '.';
        text_ += digits.substr(1);
      }
      const int power = point - 1;
      text_ += power < 0 ? "e-" : "e+";
      if (std::abs(power) < 10) text_ += '0';
      add_integer(std::abs(power));
    }
  }

  const int indent_;
  size_t depth_ = 0;
  std::string text_;
};

}  // namespace

Expected<Json> parse_json(std::string_view text) {
  text = without_byte_order_mark(text);
  if (Status status = check_text_encoding(text); !status.ok()) return status;
  TreeBuilder builder;
  if (Json::sax_parse(text.begin(), text.end(), &builder)) return std::move(builder).tree();
  if (!builder.status().ok()) return builder.status();
  return invalid_input("not valid JSON: " + place_in(text, builder.error_byte()));
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
