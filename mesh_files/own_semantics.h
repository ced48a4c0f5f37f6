// Names of attributes that glTF does not define.
#pragma once

#include <map>
#include <set>
#include <string>

namespace psplit {

// The names of one primitive.
class OwnSemantics {
 public:
  void take(const std::string& semantic) { taken_.insert(semantic); }

  // "quality" becomes _QUALITY. If the name is taken, because two differ only in case, for example, it gets a
  // number. The result is taken afterwards.
  std::string add(const std::string& name);

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> last_number_;  // of each name that was taken: hostile files repeat names
};

}  // namespace psplit
