#include "gltf_ext/files/uri.h"

#include <algorithm>
#include <array>

namespace psplit {
namespace {

namespace fs = std::filesystem;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

int hex_digit(char c) {
  if (is_digit(c)) return c - '0';
  const char small = lower(c);
  return small >= 'a' && small <= 'f' ? small - 'a' + 10 : -1;
}

bool starts_with_folded(std::string_view text, std::string_view prefix) {
  return text.size() >= prefix.size() &&
         std::equal(prefix.begin(), prefix.end(), text.begin(), [](char a, char b) { return a == lower(b); });
}

// "http:" and also "C:": neither names a file in the asset's folder.
bool has_scheme(std::string_view uri) {
  if (uri.empty() || !is_letter(uri[0])) return false;
  for (const char c : uri) {
    if (c == ':') return true;
    if (!is_letter(c) && !is_digit(c) && c != '+' && c != '-' && c != '.') return false;
  }
  return false;
}

constexpr std::array<int8_t, 256> base64_values() {
  std::array<int8_t, 256> values{};
  for (auto& value : values) value = -1;
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < kAlphabet.size(); ++i)
    values[static_cast<unsigned char>(kAlphabet[i])] = static_cast<int8_t>(i);
  return values;
}

Expected<std::vector<uint8_t>> decode_base64(std::string_view text) {
  static constexpr std::array<int8_t, 256> kValues = base64_values();
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1) return invalid_input("base64 data ends early");
  std::vector<uint8_t> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    const int value = kValues[static_cast<unsigned char>(c)];
    if (value < 0) return invalid_input("a character that is not base64");
    bits = bits << 6 | static_cast<uint32_t>(value);
    bit_count += 6;
    if (bit_count < 8) continue;
    bit_count -= 8;
    bytes.push_back(static_cast<uint8_t>(bits >> bit_count & 0xff));
  }
  return bytes;
}

}  // namespace

bool is_data_uri(std::string_view uri) { return starts_with_folded(uri, "data:"); }

Expected<std::vector<uint8_t>> decode_data_uri(std::string_view uri) {
  const size_t comma = uri.find(',');
  if (!is_data_uri(uri) || comma == std::string_view::npos) return invalid_input("a data URI without data");
  const std::string_view header = uri.substr(0, comma);
  const std::string_view data = uri.substr(comma + 1);
  constexpr std::string_view kBase64 = ";base64";
  const bool base64 = header.size() >= kBase64.size() &&
                      starts_with_folded(header.substr(header.size() - kBase64.size()), kBase64);
  if (base64 && data.find('%') == std::string_view::npos) return decode_base64(data);
  const std::string decoded = percent_decode(data);
  if (base64) return decode_base64(decoded);
  return std::vector<uint8_t>(decoded.begin(), decoded.end());
}

std::string percent_decode(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const bool escape =
        text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0;
    if (!escape) {
      decoded += text[i];
      continue;
    }
    decoded += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
    i += 2;
  }
  return decoded;
}

std::string percent_encode(std::string_view text) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    if (is_letter(c) || is_digit(c) || std::string_view("-._~").find(c) != std::string_view::npos) {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += '%';
    encoded += kHex[byte >> 4];
    encoded += kHex[byte & 15];
  }
  return encoded;
}

std::string uri_of_path(const fs::path& path) {
  std::string uri;
  for (const fs::path& part : path) {
    if (!uri.empty() && !uri.ends_with('/')) uri += '/';
    uri += part == "/" ? "/" : percent_encode(part.string());
  }
  return uri;
}

UriKind kind_of_uri(std::string_view uri) {
  if (starts_with_folded(uri, "http:") || starts_with_folded(uri, "https:")) return UriKind::kWeb;
  if (starts_with_folded(uri, "file:") || uri.starts_with('\\')) return UriKind::kAbsolute;
  // Escaped, a colon is a character of a name.
  if (has_scheme(uri)) return uri[1] == ':' ? UriKind::kAbsolute : UriKind::kUnknown;  // a drive letter
  const std::string decoded = percent_decode(uri);
  if (decoded.empty() || decoded.find('\0') != std::string::npos) return UriKind::kUnknown;
  return fs::path(decoded).has_root_path() ? UriKind::kAbsolute : UriKind::kRelative;
}

fs::path path_of_uri(std::string_view uri, const fs::path& folder) {
  const auto with_slashes = [](std::string text) {
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
  };
  const std::string decoded = percent_decode(with_slashes(std::string(uri)));
  const fs::path path = fs::path(decoded).lexically_normal();
  const fs::path other = fs::path(with_slashes(decoded)).lexically_normal();
  std::error_code error;
  const bool may_be_other = path != other && !other.has_root_path();
  return may_be_other && !fs::exists(folder / path, error) && fs::exists(folder / other, error) ? other : path;
}

bool leaves_folder(const fs::path& relative) {
  return relative.empty() || relative.has_root_path() || *relative.begin() == "..";
}

Expected<fs::path> relative_path_of_uri(std::string_view uri, const fs::path& folder) {
  const auto start = std::string(uri.substr(0, 80));
  if (has_scheme(uri)) return unsupported("the URI \"" + start + "\" is not a relative path");
  const UriKind kind = kind_of_uri(uri);
  if (kind == UriKind::kUnknown) return invalid_input("a URI that names no file");
  const fs::path path = path_of_uri(uri, folder);
  if (kind == UriKind::kAbsolute || leaves_folder(path))
    return unsupported("the URI \"" + start +
                       "\" leaves the asset's folder; only files in or below it are read");
  return path;
}

}  // namespace psplit
