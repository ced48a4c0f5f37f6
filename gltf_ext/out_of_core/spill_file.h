// A spill in a temporary file.
#pragma once

#include <filesystem>
#include <memory>

#include "encoder/out_of_core/spill.h"
#include "gltf_ext/out_of_core/file_blocks.h"

namespace psplit {

class SpillFile : public Spill {
 public:
  static Expected<std::unique_ptr<Spill>> create(const std::filesystem::path& folder) {
    Expected<AppendFile> file = AppendFile::create(folder);
    if (!file) return file.status();
    return std::unique_ptr<Spill>(new SpillFile(std::move(*file)));
  }

  Status append(std::span<const uint8_t> bytes) override { return file_.append(bytes); }
  uint64_t size() const override { return file_.size(); }
  Status read(uint64_t offset, std::span<uint8_t> to) override {
    Status status = file_.flush();
    return status.ok() ? file_.read(offset, to) : std::move(status);
  }

 private:
  explicit SpillFile(AppendFile file) : file_(std::move(file)) {}
  AppendFile file_;
};

}  // namespace psplit
