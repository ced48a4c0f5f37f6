#include "system/uri.h"

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

bool is_url_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\f' || c == '\r'; }

// Browsers ignore spaces and ends of lines around a URI.
std::string_view trimmed(std::string_view uri) {
  while (!uri.empty() && is_url_space(uri.front())) uri.remove_prefix(1);
  while (!uri.empty() && is_url_space(uri.back())) uri.remove_suffix(1);
  return uri;
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
  values['-'] = values['+'];  // the alphabet for URLs and names of files
  values['_'] = values['/'];
  return values;
}

// As browsers decode it: lines may end anywhere, and padding may be missing.
Expected<std::vector<uint8_t>> decode_base64(std::string_view text) {
  static constexpr std::array<int8_t, 256> kValues = base64_values();
  std::vector<uint8_t> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0;
  int bit_count = 0;
  bool is_padded = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const int value = kValues[static_cast<unsigned char>(text[i])];
    if (is_url_space(text[i])) continue;
    if (text[i] == '=') {
      is_padded = true;
      continue;
    }
    if (value < 0) return invalid_input("character " + std::to_string(i + 1) + " of the data is not base64");
    if (is_padded)
      return invalid_input("character " + std::to_string(i + 1) + " of the data is after the end of base64");
    bits = bits << 6 | static_cast<uint32_t>(value);
    bit_count += 6;
    if (bit_count < 8) continue;
    bit_count -= 8;
    bytes.push_back(static_cast<uint8_t>(bits >> bit_count & 0xff));
  }
  if (bit_count == 6) return invalid_input("base64 data ends early");
  return bytes;
}

// Whether the front of a data URI ends as ";base64", and without that.
bool is_base64(std::string_view header) {
  constexpr std::string_view kBase64 = "base64";
  header = trimmed(header);
  if (header.size() < kBase64.size() ||
      !starts_with_folded(header.substr(header.size() - kBase64.size()), kBase64))
    return false;
  return trimmed(header.substr(0, header.size() - kBase64.size())).ends_with(';');
}

std::string with_slashes(std::string_view text) {
  std::string changed(text);
  std::replace(changed.begin(), changed.end(), '\\', '/');
  return changed;
}

fs::path plain_path_of(std::string_view uri) {
  return fs::path(percent_decode(with_slashes(uri))).lexically_normal();
}

}  // namespace

bool is_data_uri(std::string_view uri) { return starts_with_folded(trimmed(uri), "data:"); }

Expected<std::vector<uint8_t>> decode_data_uri(std::string_view uri) {
  const size_t comma = uri.find(',');
  if (!is_data_uri(uri) || comma == std::string_view::npos) return invalid_input("a data URI without data");
  const std::string_view data = uri.substr(comma + 1);
  const bool base64 = is_base64(uri.substr(0, comma));
  if (base64 && data.find('%') == std::string_view::npos) return decode_base64(data);
  if (base64) return decode_base64(percent_decode(data));
  std::string lines(trimmed(data));
  std::erase_if(lines, [](char c) { return c == '\t' || c == '\n' || c == '\r'; });
  const std::string decoded = percent_decode(lines);
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
  uri = trimmed(uri);
  if (starts_with_folded(uri, "http:") || starts_with_folded(uri, "https:")) return UriKind::kWeb;
  if (starts_with_folded(uri, "file:") || uri.starts_with('\\')) return UriKind::kAbsolute;
  // The scheme is tested before decoding: an escaped colon belongs to a name, not to a scheme.
  if (has_scheme(uri)) return uri[1] == ':' ? UriKind::kAbsolute : UriKind::kUnknown;  // a drive letter
  const std::string decoded = percent_decode(uri);
  if (decoded.empty() || decoded.find('\0') != std::string::npos) return UriKind::kUnknown;
  return fs::path(decoded).has_root_path() ? UriKind::kAbsolute : UriKind::kRelative;
}

fs::path path_of_uri(std::string_view uri, const fs::path& folder) {
  const fs::path path = plain_path_of(uri);
  std::vector<fs::path> others;
  const auto add = [&](fs::path other) {
    other = other.lexically_normal();
    if (other != path && !other.empty() && !other.has_root_path()) others.push_back(std::move(other));
  };
  add(with_slashes(percent_decode(uri)));
  // Many exporters write the name as it is, although it has characters that a URI escapes.
  add(with_slashes(uri));
  add(std::string(uri));
  add(plain_path_of(uri.substr(0, uri.find_first_of("?#"))));
  add(plain_path_of(trimmed(uri)));
  std::error_code error;
  if (others.empty() || fs::exists(folder / path, error)) return path;
  const auto is_there = [&](const fs::path& other) { return fs::exists(folder / other, error); };
  const auto found = std::ranges::find_if(others, is_there);
  return found == others.end() ? path : *found;
}

bool is_plain_uri_of(std::string_view uri, const fs::path& path) {
  return uri.find_first_of("?#\\") == std::string_view::npos &&
         fs::path(percent_decode(uri)).lexically_normal() == path;
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
