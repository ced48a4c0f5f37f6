#include "tools/gltf_psplit/report/exit_codes.h"

#include <algorithm>
#include <array>

#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

constexpr std::array<ExitCode, 9> kExitCodes{{
    {0, StatusCode::kOk, "success"},
    {1, StatusCode::kUsage, "the command line is wrong"},
    {2, StatusCode::kIo, "a file cannot be read or written"},
    {3, StatusCode::kInvalidInput, "an input is malformed, or breaks the extension's rules"},
    {4, StatusCode::kRuntimeFailure, "something failed that should not, such as verification"},
    {5, StatusCode::kUnsupported, "an input uses what gltf-psplit does not support"},
    {7, StatusCode::kDiffers, "two meshes that should be the same differ"},
    {8, StatusCode::kOutOfMemory, "memory ran out; with more of it, the same may succeed"},
    // EX_TEMPFAIL of sysexits.h, which schedulers take as "try again".
    {75, StatusCode::kMayPass, "it may succeed later: a full disk, a lock, a signal, a time-out"},
}};

}  // namespace

std::span<const ExitCode> exit_codes() { return kExitCodes; }

int exit_code(StatusCode code) {
  const auto found = std::ranges::find(kExitCodes, code, &ExitCode::code);
  return found == kExitCodes.end() ? exit_code(StatusCode::kRuntimeFailure) : found->number;
}

StatusCode status_code(int64_t number) {
  const auto found = std::ranges::find(kExitCodes, number, &ExitCode::number);
  return found == kExitCodes.end() ? StatusCode::kRuntimeFailure : found->code;
}

std::string exit_codes_help(size_t width) {
  std::string text = "Exit codes:\n";
  for (const ExitCode& exit : kExitCodes) {
    std::string code = std::to_string(exit.number);
    code.resize(2, ' ');
    text += "  " + code + "  " + wrap_text(exit.meaning, width - 6, 6) + "\n";
  }
  return text;
}

}  // namespace psplit
