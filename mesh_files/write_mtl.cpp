#include <algorithm>
#include <array>
#include <charconv>

#include "gltf_ext/json/json_fields.h"
#include "mesh_files/mesh_file.h"
#include "mesh_files/mtl.h"

namespace psplit {
namespace {

std::string number_text(double number) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return " " + std::string(text.data(), end);
}

// The number at `index` of an array member, or `fallback`.
double number_in(const Json& object, const char* name, int64_t index, double fallback) {
  const Json* const array = array_field(object, name);
  const Json* const value = array == nullptr ? nullptr : element(*array, index);
  return value == nullptr ? fallback : number_value(*value).value_or(fallback);
}

class MtlWriter {
 public:
  MtlWriter(const Json& json, const PathOfImage& path_of_image, std::set<std::string>& left_out)
      : json_(json), path_of_image_(path_of_image), left_out_(left_out) {}

  std::string write(const Json& material, const std::string& name) {
    text_ = "newmtl " + name + "\n";
    const Json none = Json::object();
    const Json* const found = object_field(material, "pbrMetallicRoughness");
    const Json& surface = found == nullptr ? none : *found;
    const std::string* const mode = string_field(material, "alphaMode");
    const bool opaque = mode == nullptr || *mode == "OPAQUE";
    const double alpha = number_in(surface, "baseColorFactor", 3, 1);
    // A reader takes an alpha below 1 for BLEND.
    if (!opaque && (*mode != "BLEND" || !(alpha < 1))) left_out_.insert("alphaMode");
    line("Kd", surface, "baseColorFactor", 1);
    text_ += "d" + number_text(opaque ? 1 : alpha) + "\n";
    text_ += "Pr" + number_text(number_field(surface, "roughnessFactor").value_or(1)) + "\n";
    text_ += "Pm" + number_text(number_field(surface, "metallicFactor").value_or(1)) + "\n";
    if (array_field(material, "emissiveFactor") != nullptr) line("Ke", material, "emissiveFactor", 0);
    texture("map_Kd", surface, "baseColorTexture");
    texture("map_Ke", material, "emissiveTexture");
    texture("map_Bump", material, "normalTexture");
    name_others(surface, {"baseColorFactor", "roughnessFactor", "metallicFactor", "baseColorTexture"});
    name_others(material, {"name", "pbrMetallicRoughness", "emissiveFactor", "emissiveTexture", "normalTexture",
                           "alphaMode", "alphaCutoff", "extensions", "extras"});
    return text_;
  }

 private:
  void line(const char* keyword, const Json& object, const char* member, double fallback) {
    text_ += keyword;
    for (int64_t i = 0; i < 3; ++i) text_ += number_text(number_in(object, member, i, fallback));
    text_ += "\n";
  }

  void texture(const char* keyword, const Json& object, const char* member) {
    const Json* const info = object_field(object, member);
    if (info == nullptr) return;
    const Json* const found = top_level_object(json_, "textures", integer_field(*info, "index").value_or(-1));
    const int64_t source = found == nullptr ? -1 : integer_field(*found, "source").value_or(-1);
    const bool exists = source >= 0 && static_cast<size_t>(source) < array_size(json_, "images");
    const std::string path = exists ? path_of_image_(static_cast<size_t>(source)) : "";
    if (path.empty() || integer_field_or(*info, "texCoord", 0) != 0) {
      left_out_.insert(member);
      return;
    }
    if (!repeats(*found)) left_out_.insert("sampler");
    text_ += keyword;
    if (const auto scale = number_field(*info, "scale")) text_ += " -bm" + number_text(*scale);
    if (const Json* const transform = extension_field(*info, kTextureTransform)) place(*transform);
    text_ += " " + path + "\n";
  }

  // Whether the texture repeats and is filtered linearly, as viewers of OBJ do it.
  bool repeats(const Json& texture) const {
    constexpr int kRepeat = 10497, kLinear = 9729, kLinearMipmaps = 9987;
    const Json* const sampler =
        top_level_object(json_, "samplers", integer_field_or(texture, "sampler", -1).value_or(-1));
    if (sampler == nullptr) return true;
    const auto is = [&](const char* name, int value, int other) {
      const auto found = integer_field_or(*sampler, name, value);
      return found == value || found == other;
    };
    return is("wrapS", kRepeat, kRepeat) && is("wrapT", kRepeat, kRepeat) &&
           is("magFilter", kLinear, kLinear) && is("minFilter", kLinearMipmaps, kLinear);
  }

  // The inverse of what the reader of MTL does: it counts v from the bottom of the image.
  void place(const Json& transform) {
    if (number_field(transform, "rotation").value_or(0) != 0 || transform.contains("texCoord"))
      left_out_.insert(kTextureTransform);
    const double scale_v = number_in(transform, "scale", 1, 1);
    text_ += " -o" + number_text(number_in(transform, "offset", 0, 0)) +
             number_text(1 - scale_v - number_in(transform, "offset", 1, 0)) + " -s" +
             number_text(number_in(transform, "scale", 0, 1)) + number_text(scale_v);
  }

  void name_others(const Json& object, std::initializer_list<std::string_view> known) {
    for (const auto& [name, value] : object.items())
      if (std::ranges::find(known, name) == known.end() && value != false) left_out_.insert(name);
  }

  const Json& json_;
  const PathOfImage& path_of_image_;
  std::set<std::string>& left_out_;
  std::string text_;
};

}  // namespace

std::string mtl_text(const Json& json, int64_t material, const std::string& name,
                     const PathOfImage& path_of_image, std::set<std::string>& left_out) {
  const Json* const found = top_level_object(json, "materials", material);
  return found == nullptr ? "" : MtlWriter(json, path_of_image, left_out).write(*found, name);
}

}  // namespace psplit
