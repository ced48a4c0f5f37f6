// What gltf-psplit says, and how: the log on stderr, numbers and tables for people, exit codes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/status.h"

namespace psplit {

enum class Verbosity { kQuiet, kNormal, kVerbose };

// Lines on stderr, each "gltf-psplit: ...". Safe to share between threads.
class Log {
 public:
  explicit Log(Verbosity verbosity) : verbosity_(verbosity) {}
  void error(const Status& status) const;          // always
  void warning(const std::string& message) const;  // not with -q
  void note(const std::string& message) const;     // not with -q
  void detail(const std::string& message) const;   // only with -v
  void block(const std::string& lines) const;      // several lines as they are; not with -q
  // True where a progress bar is welcome: stderr is a terminal and -q is not given.
  bool interactive() const;

 private:
  Verbosity verbosity_;
};

// Whether people would read there what programs are to read.
bool stdout_is_terminal();

struct ExitCode {
  StatusCode code;
  const char* meaning;
};
// Every exit code of gltf-psplit, as --help prints them.
std::span<const ExitCode> exit_codes();
std::string exit_codes_help();

std::string with_separators(uint64_t count);                   // 1,234,567
std::string with_decimals(double value, int decimals);         // 3.14
std::string as_percent(double fraction);                       // +3.2 %
std::string as_share(double fraction);                         // 3.2 %
std::string as_duration(double ms);                            // 12.3 ms, 4.56 s
std::string as_bytes(uint64_t bytes);                          // 12 bytes, 1.18 MB, 34.1 GB
std::string plural(const std::string& noun);                   // patches
std::string counted(uint64_t count, const std::string& noun);  // 1 patch, 2 patches

// "mesh 0, primitive 1"
std::string describe_place(uint64_t mesh, uint64_t primitive);

// What tables are made for where nobody asks for all of their columns.
inline constexpr size_t kTableWidth = 100;

// Columns as wide as their widest cell; the first `left_columns` are aligned left, the others right.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header, size_t left_columns = 1);
  void add(std::vector<std::string> row);
  // Drops all columns but those of such headers.
  void keep_columns(std::span<const std::string> headers);
  // The last column is aligned left: for names and lists, which may be of any length.
  void align_last_left() { last_left_ = true; }
  std::string to_string() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  size_t left_columns_;
  bool last_left_ = false;
};

}  // namespace psplit
