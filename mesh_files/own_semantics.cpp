#include "mesh_files/own_semantics.h"

#include "mesh_files/mesh_file.h"

namespace psplit {

std::string OwnSemantics::add(const std::string& name) {
  std::string semantic = name.starts_with('_') ? "" : "_";
  for (const char c : as_utf8(name)) semantic += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  std::string unique = semantic;
  while (!taken_.insert(unique).second) {
    int& number = last_number_.try_emplace(semantic, 1).first->second;
    unique = semantic + "_" + std::to_string(++number);
  }
  return unique;
}

}  // namespace psplit
