// The handle of a mesh to be decoded.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bindings/c/support.h"
#include "psplit/decode.h"
#include "psplit/loader.h"

namespace psplit::c {

struct MeshAttribute {
  std::string name;
  uint32_t unique_id = 0;
  DracoSemantic semantic = DracoSemantic::kGeneric;
  DataType type = DataType::kFloat32;
  uint32_t components = 0;
  bool normalized = false;
  size_t value_bytes = 0;
  bool is_integers = false;
};

// A whole Draco stream.
struct DracoFile {
  std::span<const uint8_t> stream;
  StreamDescription description;  // see StreamOutline
  // What libdraco is asked for if it decodes the stream, because its bitstream is older than 2.2; or nothing.
  std::optional<std::vector<AttributeRequest>> of_libdraco{};
};

// What decodes bitstreams before 2.2; null if it is not built in.
const OlderStreams* built_in_older_streams();

}  // namespace psplit::c

// One of `primitive` and `file` is there.
struct psplit_mesh {
  psplit_kind kind = PSPLIT_KIND_NONE;
  std::shared_ptr<const void> bytes{};  // keeps what they point to, if it is not the caller's
  psplit::Place place{};
  std::optional<psplit::CompressedPrimitive> primitive{};
  std::optional<psplit::c::DracoFile> file{};
  std::vector<psplit::c::MeshAttribute> attributes{};

  uint32_t point_count() const { return primitive ? primitive->point_count() : file->description.point_count; }
  uint32_t face_count() const { return primitive ? primitive->face_count() : file->description.face_count; }
  uint32_t patch_count() const { return primitive ? primitive->patch_count() : 1; }

  // What a stream of it stores. If a stream must be decoded for that, the first call does it.
  psplit::Expected<const psplit::StreamDescription*> description() const;

 private:
  mutable std::mutex mutex_{};  // of description_
  mutable std::optional<psplit::StreamDescription> description_{};
};

namespace psplit::c {

// A mesh of PSPLIT_KIND_PATCHES or PSPLIT_KIND_DRACO. `bytes` keeps the source's bytes, and may be null.
Expected<std::unique_ptr<psplit_mesh>> open_primitive(PrimitiveSource source,
                                                      std::shared_ptr<const void> bytes);

}  // namespace psplit::c
