#include "tools/gltf_psplit/report/exit_codes.h"

#include <array>

#include "gltf_ext/files/io_error.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

constexpr std::array<ExitCode, 8> kExitCodes{{
    {StatusCode::kOk, "success"},
    {StatusCode::kUsage, "the command line is wrong"},
    {StatusCode::kIo, "a file cannot be read or written"},
    {StatusCode::kInvalidInput, "an input is malformed, or breaks the extension's rules"},
    {StatusCode::kRuntimeFailure, "something failed that should not, such as verification"},
    {StatusCode::kUnsupported, "an input uses what gltf-psplit does not support"},
    {StatusCode::kDiffers, "two meshes that should be the same differ"},
    {kMayPass, "it may succeed later: a full disk, no memory, a lock, a signal, a time-out"},
}};

}  // namespace

std::span<const ExitCode> exit_codes() { return kExitCodes; }

std::string exit_codes_help(size_t width) {
  std::string text = "Exit codes:\n";
  for (const ExitCode& exit : kExitCodes) {
    std::string code = std::to_string(static_cast<int>(exit.code));
    code.resize(2, ' ');
    text += "  " + code + "  " + wrap_text(exit.meaning, width - 6, 6) + "\n";
  }
  return text;
}

}  // namespace psplit
