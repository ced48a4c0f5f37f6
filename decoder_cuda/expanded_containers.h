// Containers as the kernels decode them. The kernels do not decode border parts of condensed streams yet. So
// the host expands containers that have them, which takes about as long as decoding them on the CPU.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "src/condensed/expand_container.h"
#include "src/container/condensed_head.h"

namespace psplit {

class ExpandedContainers {
 public:
  // The container, or its expanded copy if it has border parts. The copy lives as long as this object, and
  // is made once for each container. Errors: those of expand_container.
  Expected<const PatchContainer*> find(const PatchContainer& container) {
    if (container.head == nullptr || !container.head->has_borders) return &container;
    std::unique_ptr<Copy>& copy = copies_[&container];
    if (copy != nullptr) return &copy->container;
    Expected<std::vector<uint8_t>> bytes = expand_container(container, ThreadPool());
    if (!bytes) return bytes.status();
    Expected<PatchContainer> opened = open_container(*bytes);
    if (!opened) return opened.status();
    copy = std::make_unique<Copy>(Copy{std::move(*bytes), std::move(*opened)});
    return &copy->container;
  }
  void clear() { copies_.clear(); }

 private:
  struct Copy {
    std::vector<uint8_t> bytes;
    PatchContainer container;  // refers to `bytes`
  };
  std::map<const PatchContainer*, std::unique_ptr<Copy>> copies_;
};

}  // namespace psplit
