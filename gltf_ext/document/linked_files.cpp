#include "gltf_ext/document/linked_files.h"

#include <string_view>

#include "gltf_ext/json/json_fields.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

LinkedFile follow(const Document& document, std::string place, int64_t image, const std::string& uri) {
  LinkedFile link{std::move(place), image, uri, LinkState::kUnknown, {}, {}};
  switch (kind_of_uri(uri)) {
    case UriKind::kAbsolute: link.state = LinkState::kAbsolute; return link;
    case UriKind::kWeb: link.state = LinkState::kWeb; return link;
    case UriKind::kUnknown: return link;
    case UriKind::kRelative: break;
  }
  const fs::path folder = document.source.parent_path();
  link.relative = path_of_uri(uri, folder);
  link.path = folder / link.relative;
  link.leaves_folder = leaves_folder(link.relative);
  link.state = is_disk_file(link.path) ? LinkState::kFound : LinkState::kMissing;
  return link;
}

// A member of an object or an element of an array, and where that is. Few of the many places are ever named.
struct JsonPlace {
  const JsonPlace* parent = nullptr;  // null: the whole
  const std::string* member = nullptr;
  size_t element = 0;

  std::string text() const {
    if (parent == nullptr) return "";
    const std::string before = parent->text();
    if (member == nullptr) return before + "[" + std::to_string(element) + "]";
    return before.empty() ? *member : before + "." + *member;
  }
};

// Visits members called "uri" or "schemaUri" at any depth, except in `extras`, which belong to the application.
template <typename Visit>
void for_each_uri(const Json& tree, const JsonPlace& place, const Visit& visit) {
  if (tree.is_array()) {
    size_t number = 0;
    for (const Json& element : tree) for_each_uri(element, {&place, nullptr, number++}, visit);
  }
  const auto* const members = tree.get_ptr<const Json::object_t*>();
  if (members == nullptr) return;
  constexpr std::string_view kExtras = "extras", kUri = "uri", kSchemaUri = "schemaUri";
  for (const auto& [name, member] : *members) {
    if (name == kExtras) continue;
    if ((name == kUri || name == kSchemaUri) && member.is_string())
      visit(place.text(), *member.template get_ptr<const Json::string_t*>());
    else if (member.is_structured())
      for_each_uri(member, {&place, &name, 0}, visit);
  }
}

}  // namespace

std::vector<LinkedFile> linked_files(const Document& document) {
  std::vector<LinkedFile> links;
  const auto add = [&](const std::string& place, int64_t image, const std::string& uri) {
    if (!is_data_uri(uri)) links.push_back(follow(document, place, image, uri));
  };
  for (size_t i = 0; i < array_size(document.json(), "images"); ++i) {
    const Json& image = document.json()["images"][i];
    const std::string* uri = string_field(image, "uri");
    if (uri != nullptr && field(image, "bufferView") == nullptr)
      add("image " + std::to_string(i), static_cast<int64_t>(i), *uri);
  }
  for_each_uri(document.json(), JsonPlace(), [&](const std::string& place, const std::string& uri) {
    // Buffers are loaded already, and the images are listed.
    const bool is_own = place.find('.') == std::string::npos;
    if (!is_own || (!place.starts_with("buffers[") && !place.starts_with("images["))) add(place, -1, uri);
  });
  return links;
}

std::string describe_dangling(const LinkedFile& link) {
  const std::string uri = "\"" + link.uri.substr(0, 200) + "\"";
  switch (link.state) {
    case LinkState::kFound:
    case LinkState::kWeb: return "";
    case LinkState::kMissing: return link.place + " names a file that is missing: " + uri;
    case LinkState::kAbsolute: return link.place + " names a file by an absolute path: " + uri;
    case LinkState::kUnknown: return link.place + " has a URI that cannot be followed: " + uri;
  }
  return "";
}

}  // namespace psplit
