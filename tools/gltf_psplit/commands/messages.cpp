#include "tools/gltf_psplit/commands/messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "gltf_ext/files/operating_system.h"

namespace psplit {
namespace {

// One call, so that lines of several threads do not mix.
void print_line(const std::string& line) { std::fputs(("gltf-psplit: " + line + "\n").c_str(), stderr); }

constexpr std::array<ExitCode, 7> kExitCodes{{
    {StatusCode::kOk, "success"},
    {StatusCode::kUsage, "the command line is wrong"},
    {StatusCode::kIo, "a file cannot be read or written"},
    {StatusCode::kInvalidInput, "an input is malformed, or breaks the extension's rules"},
    {StatusCode::kRuntimeFailure, "something failed that should not, such as memory or verification"},
    {StatusCode::kUnsupported, "an input uses what gltf-psplit does not support"},
    {StatusCode::kDiffers, "two meshes that should be the same differ"},
}};

}  // namespace

void Log::error(const Status& status) const { print_line("error: " + status.to_string()); }
void Log::warning(const std::string& message) const {
  if (verbosity_ != Verbosity::kQuiet) print_line("warning: " + message);
}
void Log::note(const std::string& message) const {
  if (verbosity_ != Verbosity::kQuiet) print_line(message);
}
void Log::detail(const std::string& message) const {
  if (verbosity_ == Verbosity::kVerbose) print_line(message);
}
void Log::block(const std::string& lines) const {
  if (verbosity_ != Verbosity::kQuiet) std::fputs(lines.c_str(), stderr);
}
bool Log::interactive() const { return verbosity_ != Verbosity::kQuiet && is_terminal(stderr); }

bool stdout_is_terminal() { return is_terminal(stdout); }

std::span<const ExitCode> exit_codes() { return kExitCodes; }

std::string exit_codes_help() {
  std::string text = "Exit codes:\n";
  for (const ExitCode& exit : kExitCodes)
    text += "  " + std::to_string(static_cast<int>(exit.code)) + "  " + exit.meaning + "\n";
  return text;
}

std::string with_separators(uint64_t count) {
  std::string text = std::to_string(count);
  for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ',');
  return text;
}

std::string with_decimals(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string as_percent(double fraction) {
  std::string text = with_decimals(100 * fraction, 1);
  if (fraction >= 0) text.insert(text.begin(), '+');
  text += " %";
  return text;
}
std::string as_share(double fraction) { return with_decimals(100 * fraction, 1) + " %"; }

std::string as_duration(double ms) {
  if (ms < 100) return with_decimals(ms, 1) + " ms";
  if (ms < 1000) return with_decimals(ms, 0) + " ms";
  return with_decimals(ms / 1000, 2) + " s";
}

// Three digits, in powers of 1000.
std::string as_bytes(uint64_t bytes) {
  if (bytes < 1000) return counted(bytes, "byte");
  double value = static_cast<double>(bytes) / 1000;
  size_t unit = 0;
  constexpr std::array kUnits = {"kB", "MB", "GB", "TB", "PB", "EB"};
  // 999.6 would be 1000 in three digits.
  for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
  const int decimals = value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
  return with_decimals(value, decimals) + " " + kUnits[unit];
}

std::string plural(const std::string& noun) {
  const bool hisses = noun.ends_with("ch") || noun.ends_with("s");
  return noun + (hisses ? "es" : "s");
}
std::string counted(uint64_t count, const std::string& noun) {
  return count == 1 ? "1 " + noun : with_separators(count) + " " + plural(noun);
}

std::string describe_place(uint64_t mesh, uint64_t primitive) {
  return "mesh " + std::to_string(mesh) + ", primitive " + std::to_string(primitive);
}

TextTable::TextTable(std::vector<std::string> header, size_t left_columns) : left_columns_(left_columns) {
  rows_.push_back(std::move(header));
}

void TextTable::add(std::vector<std::string> row) {
  row.resize(rows_.front().size());
  rows_.push_back(std::move(row));
}

void TextTable::keep_columns(std::span<const std::string> headers) {
  std::vector<size_t> kept;
  size_t left_columns = 0;
  for (size_t i = 0; i < rows_.front().size(); ++i) {
    if (std::ranges::find(headers, rows_.front()[i]) == headers.end()) continue;
    if (i < left_columns_) ++left_columns;
    kept.push_back(i);
  }
  for (std::vector<std::string>& row : rows_) {
    std::vector<std::string> cells;
    for (const size_t i : kept) cells.push_back(std::move(row[i]));
    row = std::move(cells);
  }
  left_columns_ = left_columns;
}

std::string TextTable::to_string() const {
  std::vector<size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - row[i].size(), ' ');
      const bool left = i < left_columns_ || (last_left_ && i + 1 == row.size());
      line += (i == 0 ? "" : "  ") + (left ? row[i] + padding : padding + row[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace psplit
