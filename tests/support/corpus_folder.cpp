#include "tests/support/corpus_folder.h"

namespace psplit {

std::filesystem::path corpus_folder() { return PSPLIT_CORPUS; }

}  // namespace psplit
