#include "gltf_ext/mesh_files/spool_bytes.h"

namespace psplit {

Expected<SpooledBytes> spool_bytes(Scanner& scanner, const std::filesystem::path& folder) {
  Expected<UnnamedFile> file = UnnamedFile::create(folder);
  if (!file) return file.status();
  uint64_t written = 0;
  for (std::string_view block = scanner.peek(Scanner::kMostPeeked); !block.empty();
       block = scanner.peek(Scanner::kMostPeeked)) {
    Status status = file->write(written, {reinterpret_cast<const uint8_t*>(block.data()), block.size()});
    if (!status.ok()) return status;
    written += block.size();
    scanner.skip(block.size());
  }
  if (Status status = scanner.failure(); !status.ok()) return status;
  Expected<MappedFile> bytes = MappedFile::open(*file);
  if (!bytes) return bytes.status();
  return SpooledBytes{std::move(*file), std::move(*bytes)};
}

}  // namespace psplit
