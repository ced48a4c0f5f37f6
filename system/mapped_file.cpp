#include "system/mapped_file.h"

#include <algorithm>
#include <vector>

#include "system/files.h"
#include "system/operating_system.h"

namespace psplit {

Expected<MappedFile> MappedFile::open(const std::filesystem::path& path, uint64_t limit) {
  MappedFile file;
  if (const std::span<const uint8_t> mapped = map_file(path); !mapped.empty()) {
    file.owner_ = {mapped.data(), [mapped](const void*) { unmap_file(mapped); }};
    file.bytes_ = mapped.first(static_cast<size_t>(std::min<uint64_t>(mapped.size(), limit)));
    return file;
  }
  Expected<std::vector<uint8_t>> bytes = read_file(path, limit);
  if (!bytes) return bytes.status();
  const auto owner = std::make_shared<const std::vector<uint8_t>>(std::move(*bytes));
  file.bytes_ = *owner;
  file.owner_ = owner;
  return file;
}

Expected<MappedFile> MappedFile::open(const UnnamedFile& unnamed) {
  MappedFile file;
  const Expected<std::span<const uint8_t>> mapped = map_file(unnamed);
  if (!mapped) return mapped.status();
  if (mapped->empty()) return file;
  file.bytes_ = *mapped;
  file.owner_ = {mapped->data(), [bytes = *mapped](const void*) { unmap_file(bytes); }};
  return file;
}

MappedFile MappedFile::range(uint64_t offset, uint64_t length) const {
  MappedFile part = *this;
  part.bytes_ = bytes_.subspan(static_cast<size_t>(offset), static_cast<size_t>(length));
  return part;
}

Expected<FileMemory> FileMemory::create(const std::filesystem::path& folder, uint64_t bytes) {
  const Expected<UnnamedFile> file = UnnamedFile::create(folder);
  if (!file) return file.status();
  const Expected<std::span<uint8_t>> mapped = map_space(*file, bytes);
  if (!mapped) return mapped.status();
  FileMemory memory;
  memory.bytes_ = *mapped;
  memory.owner_ = {mapped->data(), [found = *mapped](const void*) { unmap_file(found); }};
  return memory;
}

MappedFile FileMemory::view() const {
  MappedFile file;
  file.owner_ = owner_;
  file.bytes_ = bytes_;
  return file;
}

bool visit_and_release(Span<const uint8_t> bytes, const std::function<bool(Span<const uint8_t>)>& visit) {
  while (!bytes.empty()) {
    const auto step = bytes.first(static_cast<size_t>(std::min<uint64_t>(bytes.size(), kReleaseStep)));
    if (!visit(step)) return false;
    release_mapped(step);
    bytes = bytes.subspan(step.size());
  }
  return true;
}

}  // namespace psplit
