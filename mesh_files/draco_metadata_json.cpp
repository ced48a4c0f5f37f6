#include "mesh_files/draco_metadata_json.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "gltf_ext/json/json_text.h"
#include "mesh_files/own_semantics.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

template <typename T>
std::vector<T> numbers_of(const Bytes& value) {
  std::vector<T> numbers(value.size() / sizeof(T));
  std::memcpy(numbers.data(), value.data(), numbers.size() * sizeof(T));
  return numbers;
}

// Integers that are read as doubles are tiny or huge.
bool are_usual(const std::vector<double>& numbers) {
  return std::ranges::all_of(numbers, [](double number) {
    return number == 0 || (std::fabs(number) > 1e-30 && std::fabs(number) < 1e30);
  });
}

template <typename T>
Json one_or_all(const std::vector<T>& numbers) {
  return numbers.size() == 1 ? Json(numbers[0]) : Json(numbers);
}

// Nothing if the bytes are not text.
std::optional<std::string> text_of(const Bytes& value) {
  const auto is_control = [](uint8_t c) { return c < ' ' && c != '\n' && c != '\r' && c != '\t'; };
  std::string text(value.begin(), value.end());
  if (std::ranges::any_of(value, is_control) || !is_utf8(text)) return {};
  return text;
}

// Null if there are too many numbers: a picture, for example, takes four times the bytes as JSON.
Json json_of_value(const Bytes& value) {
  constexpr size_t kMostNumbers = 1024;
  if (std::optional<std::string> text = text_of(value)) return std::move(*text);
  const bool is_zero = std::ranges::all_of(value, [](uint8_t byte) { return byte == 0; });
  const auto fit = [&](size_t bytes) {
    return value.size() % bytes == 0 && value.size() / bytes <= kMostNumbers;
  };
  if (fit(sizeof(double)) && !is_zero)
    if (const auto doubles = numbers_of<double>(value); are_usual(doubles)) return one_or_all(doubles);
  if (fit(sizeof(int32_t))) return one_or_all(numbers_of<int32_t>(value));
  return fit(1) ? one_or_all(value) : Json();
}

// As UTF-8, which may make names equal.
std::string unused_name(const Json& object, const std::string& name) {
  std::string unused = as_utf8(name);
  while (object.contains(unused)) unused += "_";
  return unused;
}

class MetadataConverter {
 public:
  // False if there is too much of it.
  bool add_members(const Metadata& metadata, int depth, Json& object) {
    constexpr int kMostDepth = 64;
    constexpr size_t kMostMembers = 4096;  // less than JSON is read with
    members_ += metadata.entries.size() + metadata.parts.size();
    if (depth > kMostDepth || members_ > kMostMembers) return false;
    for (const auto& [name, value] : metadata.entries) {
      Json json = json_of_value(value);
      if (json.is_null())
        ++lost_values_;
      else
        object[unused_name(object, name)] = std::move(json);
    }
    for (const Metadata& part : metadata.parts) {
      Json child = Json::object();
      if (!add_members(part, depth + 1, child)) return false;
      object[unused_name(object, part.name)] = std::move(child);
    }
    return true;
  }
  size_t lost_values() const { return lost_values_; }

 private:
  size_t members_ = 0, lost_values_ = 0;
};

const Bytes* name_in(const Metadata& metadata) {
  const Bytes* const name = metadata.find_entry("name");
  return name != nullptr ? name : metadata.find_entry("attribute_name");  // as Draco's writer of glTF has it
}

}  // namespace

Json json_of_metadata(const Metadata& metadata, const std::string& of, Losses& losses) {
  MetadataConverter converter;
  Json object = Json::object();
  if (!converter.add_members(metadata, 0, object)) {
    losses.say("metadata of " + of + " are left out: they have too many entries, or parts in each other");
    return {};
  }
  losses.add("value in metadata of " + of + " is left out: it is not text, and too long for numbers",
             "values in metadata of " + of + " are left out: they are not text, and too long for numbers",
             converter.lost_values());
  return object.empty() ? Json() : object;
}

std::vector<const Metadata*> metadata_of_attributes(const StreamMetadata& metadata,
                                                    const std::vector<AttributeRequest>& requests,
                                                    Losses& losses) {
  std::map<uint32_t, size_t> numbers;
  for (size_t i = 0; i < requests.size(); ++i) numbers[requests[i].unique_id] = i;
  std::vector<const Metadata*> of_attributes(requests.size(), nullptr);
  for (const AttributeMetadata& attribute : metadata.attributes) {
    const auto number = numbers.find(attribute.unique_id);
    const Metadata& tree = attribute.metadata;
    if (number != numbers.end() && of_attributes[number->second] == nullptr)
      of_attributes[number->second] = &tree;
    else if (!tree.entries.empty() || !tree.parts.empty())
      losses.say(number == numbers.end() ? "metadata of an attribute that does not exist are left out"
                                         : "metadata are left out: their attribute has others");
  }
  return of_attributes;
}

void take_names(const std::vector<const Metadata*>& of_attributes, std::vector<AttributeRequest>& requests) {
  constexpr size_t kLongestName = 256;
  OwnSemantics names;
  for (const AttributeRequest& request : requests) names.take(request.semantic);
  for (size_t i = 0; i < requests.size(); ++i) {
    if (of_attributes[i] == nullptr || !requests[i].semantic.starts_with("_GENERIC_")) continue;
    const Bytes* const name = name_in(*of_attributes[i]);
    if (name == nullptr || name->size() > kLongestName) continue;
    if (const std::optional<std::string> text = text_of(*name)) requests[i].semantic = names.add(*text);
  }
}

}  // namespace psplit
