#include "mesh_files/mtl.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "system/files.h"
#include "system/uri.h"

namespace psplit {
namespace {

// The statements of a material, collected line by line.
struct Settings {
  std::array<float, 3> color{1, 1, 1}, emission{0, 0, 0};
  float alpha = 1, metalness = 0;
  std::optional<float> roughness, shininess;
};

Json json_of(const std::string& name, const Settings& settings) {
  const auto clamped = [](float value) { return std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : 0.0f; };
  Json json{{"name", as_utf8(name)}};
  const auto& [red, green, blue] = settings.color;
  const float alpha = clamped(settings.alpha);
  // The roughness whose highlight is about as wide as that of the Phong exponent.
  const float shininess = std::max(0.0f, settings.shininess.value_or(0));
  const float roughness = settings.roughness.value_or(std::sqrt(2 / (shininess + 2)));
  json["pbrMetallicRoughness"] = {{"baseColorFactor", {clamped(red), clamped(green), clamped(blue), alpha}},
                                  {"metallicFactor", clamped(settings.metalness)},
                                  {"roughnessFactor", clamped(roughness)}};
  const auto& [r, g, b] = settings.emission;
  if (clamped(r) + clamped(g) + clamped(b) > 0) json["emissiveFactor"] = {clamped(r), clamped(g), clamped(b)};
  if (alpha < 1) json["alphaMode"] = "BLEND";
  return json;
}

// The options before the name of a texture's file.
struct TextureOptions {
  std::array<double, 2> offset{0, 0}, scale{1, 1};
  double strength = 1;  // of a bump map
  bool has_others = false;
};

// Takes the options from the front of the text, like "-s 1 1 1" and "-bm 0.5". The name of the file stays.
TextureOptions take_options(std::string& text) {
  constexpr std::string_view kBlanks = " \t";
  TextureOptions options;
  while (text.starts_with('-')) {
    const size_t end = std::min(text.find_first_of(kBlanks), text.size());
    const std::string option = text.substr(0, end);
    text.erase(0, std::min(text.find_first_not_of(kBlanks, end), text.size()));
    const bool has_word = option == "-type" || option == "-imfchan" || option == "-clamp" ||
                          option == "-blendu" || option == "-blendv" || option == "-cc" ||
                          option == "-colorspace";
    const std::span<double> values = option == "-o"    ? std::span<double>(options.offset)
                                     : option == "-s"  ? std::span<double>(options.scale)
                                     : option == "-bm" ? std::span<double>(&options.strength, 1)
                                                       : std::span<double>();
    options.has_others = options.has_others || values.empty();
    // One word, or up to three numbers.
    for (size_t i = 0; i < (has_word ? 1 : 3); ++i) {
      const size_t word_end = std::min(text.find_first_of(kBlanks), text.size());
      const std::optional<double> number = parse_double(std::string_view(text).substr(0, word_end));
      if (!has_word && !number) break;
      if (word_end == text.size()) break;  // the name itself
      if (i < values.size() && std::isfinite(*number)) values[i] = *number;
      text.erase(0, std::min(text.find_first_not_of(kBlanks, word_end), text.size()));
    }
  }
  return options;
}

// glTF allows only these two kinds of images.
bool is_image_of_gltf(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

// Reads the numbers of a statement. A single number stands for a grey.
void read_numbers(Scanner& scanner, std::span<float> values, Losses& losses) {
  for (size_t i = 0; i < values.size(); ++i) {
    const std::string_view word = scanner.word();
    if (word.empty() && i == 1) {
      values[1] = values[2] = values[0];
      return;
    }
    const std::optional<float> number = parse_float(word);
    if (!number) {  // also spectral curves and CIE colours
      losses.add("line of the materials is not understood: left out",
                 "lines of the materials are not understood: left out");
      return;
    }
    values[i] = *number;
  }
}

}  // namespace

std::string uri_of_path(const std::string& path) {
  std::string uri, part;
  std::string text = path;
  std::replace(text.begin(), text.end(), '\\', '/');
  if (text.starts_with('/') || text.find(':') != std::string::npos || text.find('\0') != std::string::npos)
    return "";
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find('/', at), text.size());
    uri += (at == 0 ? "" : "/") + percent_encode(std::string_view(text).substr(at, end - at));
    at = end + 1;
  }
  return uri;
}

bool can_be_texture(const std::string& path, Losses& losses) {
  if (!uri_of_path(path).empty() && is_image_of_gltf(path)) return true;
  losses.say("the texture " + in_quotes(path) +
             " is left out: glTF allows relative paths of .png and .jpg files");
  return false;
}

std::optional<MaterialLibrary::Texture> MaterialLibrary::read_texture(Scanner& scanner, Losses& losses) {
  Texture texture{scanner.rest_of_line().value_or("")};
  const auto [offset, scale, strength, has_others] = take_options(texture.path);
  if (has_others) losses.say("some options of textures are left out");
  if (!can_be_texture(texture.path, losses)) return std::nullopt;
  texture.info = Json::object();
  if (strength != 1) texture.info["scale"] = strength;
  // MTL counts v from the bottom of the image, glTF from the top.
  Json transform = Json::object();
  const std::array<double, 2> from_top{offset[0], 1 - scale[1] - offset[1]};
  if (from_top != std::array<double, 2>{0, 0}) transform["offset"] = from_top;
  if (scale != std::array<double, 2>{1, 1}) transform["scale"] = scale;
  if (!transform.empty()) texture.info["extensions"] = {{kTextureTransform, std::move(transform)}};
  return texture;
}

void MaterialLibrary::read(Scanner& scanner, Losses& losses) {
  Material* material = nullptr;
  std::string name;
  Settings settings;
  const auto finish = [&] {
    if (material != nullptr) material->json = json_of(name, settings);
  };
  const auto numbers = [&](std::span<float> values) { read_numbers(scanner, values, losses); };
  const auto texture = [&](const char* member) {
    std::optional<Texture> found = read_texture(scanner, losses);
    if (!found) return;
    // Only normals have a strength in glTF.
    if (std::string_view(member) != "normalTexture") found->info.erase("scale");
    material->textures[member] = std::move(*found);
  };
  bool more = true;
  for (; more; more = scanner.next_line()) {
    const std::string keyword(scanner.word());
    if (keyword == "newmtl") {
      finish();
      name = scanner.rest_of_line().value_or("");
      material = &materials_[name];
      *material = {};
      settings = {};
    } else if (material == nullptr || keyword.empty()) {
      continue;
    } else if (keyword == "Kd") {
      numbers(settings.color);
    } else if (keyword == "Ke") {
      numbers(settings.emission);
    } else if (keyword == "d") {
      numbers({&settings.alpha, 1});
    } else if (keyword == "Tr") {
      numbers({&settings.alpha, 1});
      settings.alpha = 1 - settings.alpha;
    } else if (keyword == "Ns") {
      numbers({&settings.shininess.emplace(), 1});
    } else if (keyword == "Pr") {
      numbers({&settings.roughness.emplace(), 1});
    } else if (keyword == "Pm") {
      numbers({&settings.metalness, 1});
    } else if (keyword == "map_Kd") {
      texture("baseColorTexture");
    } else if (keyword == "map_Ke") {
      texture("emissiveTexture");
    } else if (keyword == "norm" || keyword == "map_Kn") {
      texture("normalTexture");
    } else if (keyword == "map_Bump" || keyword == "map_bump" || keyword == "bump") {
      // A texture of normals, as Blender writes it; but it may be one of heights. `norm` has precedence.
      const auto known = material->textures.find("normalTexture");
      if (known != material->textures.end() && !known->second.may_be_heights) continue;
      texture("normalTexture");
      if (material->textures.contains("normalTexture"))
        material->textures["normalTexture"].may_be_heights = true;
    } else if (keyword.starts_with("map_") || keyword == "disp" || keyword == "decal" || keyword == "refl") {
      losses.say("textures of " + in_quotes(keyword) + " are left out: glTF has no such textures");
    }
  }
  finish();
  if (!scanner.failure().ok())
    losses.say("only a part of the materials was read: " + scanner.failure().message());
}

int64_t add_texture(const std::string& path, MeshFile& file) {
  const std::string uri = uri_of_path(path);
  const auto is_it = [&](const Json& image) { return image["uri"] == uri; };
  const auto image = std::ranges::find_if(file.images, is_it);
  const auto index = image - file.images.begin();
  if (image == file.images.end()) {
    file.images.push_back({{"uri", uri}});
    file.textures.push_back({{"source", index}});  // one texture for each image
  }
  return index;
}

int64_t MaterialLibrary::use(const std::string& name, MeshFile& file) {
  const auto [known, is_new] = used_.try_emplace(name, static_cast<int64_t>(file.materials.size()));
  if (!is_new) return known->second;
  const auto found = materials_.find(name);
  if (found == materials_.end()) {
    file.losses.add("material is in no library: it gets only its name",
                    "materials are in no library: they get only their names");
    file.materials.push_back(json_of(name, {}));
    return known->second;
  }
  Json json = found->second.json;
  for (const auto& [member, found_texture] : found->second.textures) {
    Json texture{{"index", add_texture(found_texture.path, file)}};
    texture.update(found_texture.info);
    if (found_texture.may_be_heights) file.bump_maps.insert(uri_of_path(found_texture.path));
    if (member == "baseColorTexture") {
      json["pbrMetallicRoughness"][member] = texture;
    } else {
      json[member] = texture;
      // Exporters often write black as the colour that the texture is multiplied by.
      if (member == "emissiveTexture" && !json.contains("emissiveFactor")) json["emissiveFactor"] = {1, 1, 1};
    }
  }
  file.materials.push_back(std::move(json));
  return known->second;
}

}  // namespace psplit
