// One geometry on its way through the encoder, in memory or in parts.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "encoder/coding/precision_guard.h"
#include "encoder/encode_mesh.h"
#include "encoder/encode_parts.h"
#include "encoder/welding/reduce.h"
#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// A mesh that was encoded part by part.
struct EncodedInParts {
  uint64_t faces = 0, points = 0;          // of the input
  std::vector<PartsContainer> containers;  // on one grid; or streams without a container
};

// Which meshes share grids: those of one group.
struct GridGroups {
  QuantizationVolume volume = QuantizationVolume::kMesh;
  std::map<size_t, size_t> joined{};  // the group of meshes that share a geometry with others

  // Nothing if each primitive has grids of its own.
  std::optional<size_t> of_mesh(size_t mesh) const {
    if (volume == QuantizationVolume::kPrimitive) return std::nullopt;
    const auto found = joined.find(mesh);
    return volume == QuantizationVolume::kScene ? 0 : found == joined.end() ? mesh : found->second;
  }
};

struct EncodeJob {
  PrimitiveGroup group;  // the primitives that have this geometry
  Mesh mesh;             // without points and faces if it is in parts; without arrays after free_mesh()
  std::vector<MorphAttribute> morphs;
  std::vector<Attribute> unrounded;     // the skin weights of the input
  std::vector<AttributeCoding> stated;  // the grids of the input: see MeshToCode
  std::vector<AttributeCoding> codings;
  std::vector<PrecisionNote> precision;  // about the codings
  EncodeOptions options;
  EncodedMesh encoded;
  std::optional<EncodedInParts> parts;  // has the bytes instead of `encoded`
  bool drops_attributes = false;        // which its stock Draco stream would keep
  StoredAs stored_as = StoredAs::kAsItWas;
  uint64_t stored_bytes = 0;  // of the container or the streams
  uint64_t freed_faces = 0;
  std::vector<std::string> warnings;  // what it loses
  Status status;

  uint64_t face_count() const { return parts ? parts->faces : mesh.faces.size() + freed_faces; }
  uint64_t point_count() const { return parts ? parts->points : mesh.point_count; }
  // Containers and lone streams: each becomes a primitive.
  size_t piece_count() const {
    return parts ? parts->containers.size() : std::max<size_t>(1, encoded.lone_streams.size());
  }

  // How POSITION is quantized; null if it is stored exactly.
  AttributeCoding* position_coding() {
    for (size_t i = 0; i < codings.size(); ++i)
      if (mesh.attributes[i].semantic == "POSITION" && codings[i].bits > 0) return &codings[i];
    return nullptr;
  }

  // Frees the values and the faces. Their counts stay.
  void free_mesh();
  // Fills in stored_as and stored_bytes.
  void note_storage();
  // Fills in what the report says about the output.
  void report(PrimitiveReport& report);
  // Adds what it says about precision, once for each geometry.
  void report_precision(PrimitiveReport& report) const;

  Place place(const Document& document) const { return place_of(document, group.ids.front()); }
};

// What the options say about the streams of a mesh, which are not condensed: condense_document does that when
// all are there.
EncodeOptions options_of_streams(const EncodeDocumentOptions& options);

// The mesh that encode_job stores.
ReducedMesh reduce_job(const EncodeJob& job, const ThreadPool& pool);
// For each point of the job's mesh 1 if encode_job stores its values, otherwise 0.
std::vector<uint8_t> stored_points_of(const EncodeJob& job);

// Encodes the job with `options`, which may differ from the job's in the patches and in verification. Points
// whose morph targets differ stay apart, and points whose weights differed before rounding.
Expected<EncodedMesh> encode_job(const EncodeJob& job, const EncodeOptions& options, const ThreadPool& pool);

// Morph targets in the order of the stored points: point i is source_point[i] of the input.
std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point);

// The number of patches of each primitive, given its number of faces.
std::vector<uint32_t> patch_counts(std::span<const uint64_t> faces, const EncodeDocumentOptions& options);

// The same of jobs.
std::vector<uint32_t> patch_counts(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& options);

}  // namespace psplit
