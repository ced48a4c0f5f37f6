// The JSON tree of a glTF document. Objects keep their members in the order of the file.
#pragma once

#include <nlohmann/json.hpp>

#include "gltf_ext/json/json_fwd.h"
