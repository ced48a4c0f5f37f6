// Prepares files for tinygltf.
#include <algorithm>
#include <filesystem>
#include <string_view>

#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "gltf_ext/tinygltf/model_geometry.h"

namespace psplit {
namespace {

// Gives indices without a buffer view the view of their extension. Returns false if there are no such indices.
bool lend_views(Json& json) {
  bool lent = false;
  Json* meshes = array_field(json, "meshes");
  for (size_t m = 0; meshes != nullptr && m < meshes->size(); ++m) {
    Json* primitives = array_field((*meshes)[m], "primitives");
    for (size_t p = 0; primitives != nullptr && p < primitives->size(); ++p) {
      const Json* extension = nullptr;
      for (const char* const name : kDracoExtensions)
        if (extension == nullptr) extension = extension_field((*primitives)[p], name);
      const auto view = extension == nullptr ? std::nullopt : integer_field(*extension, "bufferView");
      const auto indices = integer_field((*primitives)[p], "indices");
      Json* accessor = view && indices ? top_level_object(json, "accessors", *indices) : nullptr;
      if (accessor == nullptr || accessor->contains("bufferView")) continue;
      (*accessor)["bufferView"] = *view;
      lent = true;
    }
  }
  return lent;
}

// Gives meshes with coarse primitives the primitives that replace these. Returns whether there are such meshes.
Expected<bool> replace_coarse(Json& json) {
  if (Status status = exchange_primitives(json); !status.ok()) return status;
  bool replaced = false;
  Json* meshes = array_field(json, "meshes");
  for (size_t m = 0; meshes != nullptr && m < meshes->size(); ++m) {
    if (other_primitives((*meshes)[m]) == nullptr) continue;
    (*meshes)[m]["extensions"].erase(kExtensionName);
    replaced = true;
  }
  return replaced;
}

#ifndef TINYGLTF_NO_FS
// tinygltf after 2.8 has one more callback, and refuses all if one is missing.
template <typename Callbacks>
void set_size_callback(Callbacks& callbacks) {
  if constexpr (requires { callbacks.GetFileSizeInBytes; })
    callbacks.GetFileSizeInBytes = [](size_t* bytes, std::string* error, const std::string& path, void*) {
      std::error_code failed;
      const uintmax_t size = std::filesystem::file_size(path, failed);
      if (failed && error != nullptr) *error += path + ": " + failed.message();
      if (!failed) *bytes = static_cast<size_t>(size);
      return !failed;
    };
}
#endif

// The callbacks also read images and buffers.
bool is_text(std::span<const uint8_t> file) {
  constexpr std::string_view kNoText = "\xef\xbb\xbf \t\r\n";
  const auto first = std::find_if(file.begin(), file.end(), [&](uint8_t byte) {
    return kNoText.find(static_cast<char>(byte)) == std::string_view::npos;
  });
  return first != file.end() && *first == '{';
}

}  // namespace

Status prepare_for_tinygltf(std::vector<unsigned char>& file) {
  GlbChunks chunks{file, {}};
  if (is_glb(file)) {
    Expected<GlbChunks> parsed = parse_glb(file);
    if (!parsed) return parsed.status();
    chunks = *parsed;
  } else if (!is_text(file)) {
    return {};
  }
  const std::string_view text(reinterpret_cast<const char*>(chunks.json.data()), chunks.json.size());
  const auto is_named = [&](const char* name) { return text.find(name) != std::string_view::npos; };
  if (std::none_of(std::begin(kDracoExtensions), std::end(kDracoExtensions), is_named)) return {};
  Expected<Json> json = parse_json(text);
  if (!json) return json.status();
  const Expected<bool> replaced = replace_coarse(*json);
  if (!replaced) return replaced.status();
  if (!lend_views(*json) && !*replaced) return {};
  std::string edited = json->dump();
  if (!is_glb(file)) {
    file.assign(edited.begin(), edited.end());
    return {};
  }
  const std::span<const uint8_t> binary = chunks.binary.value_or(std::span<const uint8_t>());
  Expected<std::vector<uint8_t>> whole = glb_head(std::move(edited), binary.size());
  if (!whole) return whole.status();
  whole->insert(whole->end(), binary.begin(), binary.end());
  file = std::move(*whole);
  return {};
}

#ifndef TINYGLTF_NO_FS
tinygltf::FsCallbacks tinygltf_file_callbacks() {
  const auto read = [](std::vector<unsigned char>* out, std::string* error, const std::string& path,
                       void* user_data) {
    if (!tinygltf::ReadWholeFile(out, error, path, user_data)) return false;
    (void)prepare_for_tinygltf(*out);  // tinygltf reports the same errors
    return true;
  };
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = &tinygltf::FileExists;
  callbacks.ExpandFilePath = &tinygltf::ExpandFilePath;
  callbacks.ReadWholeFile = read;
  callbacks.WriteWholeFile = &tinygltf::WriteWholeFile;
  set_size_callback(callbacks);
  return callbacks;
}
#endif

}  // namespace psplit
