// The result of `compare` as an HTML page: one file without scripts, which loads nothing from a network.
#pragma once

#include <string>

#include "tools/gltf_psplit/compare/comparison_report.h"

namespace psplit {

// Deterministic. Text that comes from files and from the machine is escaped.
std::string to_html(const ComparisonReport& report);

}  // namespace psplit
