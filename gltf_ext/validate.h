// Every rule of PSPLIT_mesh_draco_patches, checked against a whole document.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/primitives.h"

namespace psplit {

struct Finding {
  std::string rule;  // stable: see the table in validate.cpp
  std::string message;
  Place place;
  bool error = true;  // otherwise a warning
};

// Decodes every patch and checks every reference. Empty when nothing is wrong.
std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool);

}  // namespace psplit
