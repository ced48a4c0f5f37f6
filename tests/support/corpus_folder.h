// Where test assets that others made lie, if they are on this machine (CMake's PSPLIT_CORPUS).
#pragma once

#include <filesystem>

namespace psplit {

std::filesystem::path corpus_folder();

}  // namespace psplit
