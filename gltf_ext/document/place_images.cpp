#include "gltf_ext/document/place_images.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/document/named_binary.h"
#include "gltf_ext/json/json_fields.h"
#include "system/files.h"
#include "system/image_type.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

bool is_image_name(const fs::path& path) {
  constexpr std::array<std::string_view, 12> kImages = {".png", ".jpg",   ".jpeg", ".webp", ".ktx2", ".ktx",
                                                        ".dds", ".basis", ".avif", ".gif",  ".bmp",  ".tga"};
  return std::find(kImages.begin(), kImages.end(), lower_extension(path)) != kImages.end();
}

// An image's file, and the kind of image that its first bytes show.
struct Source {
  fs::path path;
  std::optional<ImageType> type;
};

// The path of `file` from `folder`: by names alone if that leads to the file, otherwise with links resolved.
fs::path path_from(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  const fs::path relative = fs::absolute(file, error)
                                .lexically_normal()
                                .lexically_relative(fs::absolute(folder, error).lexically_normal());
  if (!relative.empty() && fs::equivalent(folder / relative, file, error)) return relative;
  return fs::relative(file, folder, error);
}

class ImagePlacer {
 public:
  ImagePlacer(const Document& document, const fs::path& output, ImagePlacement placement,
              PackedDocument& packed, WriteReport& report)
      : placement_(placement), packed_(packed), report_(report) {
    if (output == "-") return;
    std::error_code error;
    output_ = fs::absolute(output, error).lexically_normal();
    folder_ = output_.parent_path();
    const fs::path from = document.source.parent_path();
    stays_ = fs::equivalent(*folder_, from.empty() ? "." : from, error);
  }

  Status place(const LinkedFile& link) {
    if (link.state != LinkState::kFound) {
      if (const std::string text = describe_dangling(link); !text.empty()) warn(text);
      return {};
    }
    const bool moves = !stays_;
    if (link.image < 0) {
      if (moves) warn(link.place + " names \"" + link.uri + "\", which is not copied: its URI may dangle");
      return {};
    }
    if (!moves && placement_ != ImagePlacement::kEmbed) return {};
    const auto head = read_file(link.path, kImageHeadBytes);
    if (!head) return head.status();
    const std::optional<ImageType> type = image_type(*head);
    // An asset must not make us copy files that are not images.
    if (!type && (link.leaves_folder || !is_image_name(link.path))) {
      warn(link.place + " names \"" + link.uri + "\", which is not an image of a known kind: it is not copied");
      return {};
    }
    const Source source{link.path, type};
    if (placement_ == ImagePlacement::kEmbed && type) return embed(link, source);
    if (placement_ == ImagePlacement::kEmbed)
      warn(link.place + ", \"" + link.uri + "\", is of an unknown kind: it is not embedded");
    if (!moves) return {};
    if (!folder_) {
      warn(link.place + " names \"" + link.uri + "\", which cannot be found from stdout");
      return {};
    }
    return placement_ == ImagePlacement::kReference ? refer(link) : copy(link, source);
  }

 private:
  void warn(const std::string& text) { report_.warnings.push_back(text); }
  Json& image_of(const LinkedFile& link) { return packed_.json["images"][static_cast<size_t>(link.image)]; }

  // Paths to the same file, however they are written, are one key.
  fs::path key_of(const fs::path& path) const {
    std::error_code error;
    const fs::path key = fs::canonical(path, error);
    return error ? path : key;
  }

  Status embed(const LinkedFile& link, const Source& source) {
    const auto [found, is_new] = views_.try_emplace(key_of(source.path), 0);
    if (is_new) {
      auto bytes = read_file(source.path);
      if (!bytes) return bytes.status();
      Json& views = packed_.json["bufferViews"];
      if (!views.is_array()) views = Json::array();
      found->second = views.size();
      report_.image_bytes += bytes->size();
      const size_t length = bytes->size();
      const uint64_t start = packed_.bytes.add(std::move(*bytes));
      views.push_back({{"buffer", 0}, {"byteOffset", start}, {"byteLength", length}});
    }
    Json& image = image_of(link);
    image.erase("uri");
    image["bufferView"] = found->second;
    image["mimeType"] = source.type->mime_type;
    // Without a name nothing would tell any more which file the image was.
    if (field(image, "name") == nullptr) image["name"] = source.path.stem().string();
    ++report_.embedded_images;
    return {};
  }

  Status refer(const LinkedFile& link) {
    image_of(link)["uri"] = uri_of_path(path_from(*folder_, link.path));
    return {};
  }

  Status copy(const LinkedFile& link, const Source& source) {
    const auto [found, is_new] = copies_.try_emplace(key_of(source.path));
    if (is_new) {
      const auto bytes = read_file(source.path);
      if (!bytes) return bytes.status();
      const fs::path wanted = link.leaves_folder ? link.path.filename() : link.relative;
      const Expected<fs::path> written = write_copy(wanted, source, *bytes);
      if (!written) return written.status();
      found->second = *written;
      report_.image_bytes += bytes->size();
      report_.files.push_back(*folder_ / *written);
      if (*written != wanted)
        report_.notes.push_back(link.place + ", \"" + link.uri + "\", is copied as " + written->string());
    }
    if (!is_plain_uri_of(link.uri, found->second)) image_of(link)["uri"] = uri_of_path(found->second);
    ++report_.copied_images;
    return {};
  }

  // Copies the file under its own name, or under a name after its content if another file has that name. An
  // existing file with the same bytes serves as the copy.
  Expected<fs::path> write_copy(const fs::path& wanted, const Source& source, std::span<const uint8_t> bytes) {
    std::error_code error;
    const std::span<const uint8_t> parts[] = {bytes};
    const fs::path by_content = path_with_digits(
        wanted, content_digits(parts),
        source.type && !is_image_name(wanted) ? source.type->extension : wanted.extension().string());
    fs::create_directories((*folder_ / wanted).parent_path(), error);  // if it fails, writing reports it
    std::vector<fs::path> names{wanted, by_content};
    std::erase_if(names, [&](const fs::path& name) {
      return !is_image_name(name) || (*folder_ / name).lexically_normal() == output_;
    });
    Expected<fs::path> written = write_beside(*folder_, names, bytes);
    if (written && written->empty())
      return io_failure("cannot copy " + source.path.string() + ": " + (*folder_ / by_content).string() +
                        " is another file");
    return written;
  }

  fs::path output_;
  ImagePlacement placement_;
  PackedDocument& packed_;
  WriteReport& report_;
  std::optional<fs::path> folder_;  // the output's folder; nothing for stdout
  bool stays_ = false;              // whether URIs of output and input start from the same folder
  std::map<fs::path, size_t> views_;
  std::map<fs::path, fs::path> copies_;  // the copies' paths from the output's folder
};

}  // namespace

Status place_images(const Document& document, const fs::path& output, ImagePlacement placement,
                    PackedDocument& packed, WriteReport& report) {
  ImagePlacer placer(document, output, placement, packed, report);
  for (const LinkedFile& link : linked_files(document))
    if (Status status = placer.place(link); !status.ok()) return status;
  return {};
}

}  // namespace psplit
