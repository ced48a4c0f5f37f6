// What `compare` says, as a page to show to others: one file, nothing of it from a network, no scripts.
#pragma once

#include <string>

#include "tools/gltf_psplit/compare/comparison_report.h"

namespace psplit {

// The same page for the same report. Text that comes from files and machines is escaped.
std::string to_html(const ComparisonReport& report);

}  // namespace psplit
