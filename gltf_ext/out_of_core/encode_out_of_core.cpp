#include "gltf_ext/out_of_core/encode_out_of_core.h"

#include <algorithm>
#include <new>
#include <stdexcept>

#include "gltf_ext/files/io_error.h"
#include "gltf_ext/mesh_files/asset_format.h"
#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/ply.h"
#include "gltf_ext/mesh_files/stl.h"
#include "gltf_ext/out_of_core/encode_spool.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/out_of_core/temporary_space.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// What the header states. A property takes at most 4 bytes of a point. A count may be wrong: kMost is enough
// for any disk, and products of it do not overflow.
ExpectedSizes expected_sizes(const PlyHeader& header) {
  constexpr uint64_t kMost = uint64_t{1} << 40;
  ExpectedSizes sizes;
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      sizes.points = std::min(element.count, kMost);
      for (const PlyProperty& property : element.properties)
        if (!property.is_list) sizes.record_bytes += std::min<size_t>(4, ply_type_bytes(property.type));
    } else if (element.name == "face" || element.name == "faces") {
      sizes.faces = std::min(element.count, kMost);
    }
  }
  return sizes;
}

Status read_mesh(Scanner& scanner, const fs::path& source, const OutOfCoreOptions& limits, MeshSpool& spool,
                 Losses& losses) {
  const std::optional<AssetFormat> format = format_of(scanner, source);
  if (format == AssetFormat::kPly) {
    skip_byte_order_mark(scanner);
    const Expected<PlyHeader> header = read_ply_header(scanner);
    if (!header) return header.status();
    Status status = check_temporary_space(expected_sizes(*header), limits.temporary, limits.note);
    return status.ok() ? read_ply(scanner, *header, spool, losses) : std::move(status);
  }
  if (format == AssetFormat::kStl) {
    constexpr uint64_t kTextFacet = 100, kRecord = 24;  // bytes; a facet of a text takes about these at least
    const uint64_t facets = facet_count_of_binary_stl(scanner).value_or(
        static_cast<uint32_t>(scanner.bytes_left().value_or(0) / kTextFacet));
    Status status = check_temporary_space({3 * facets, facets, kRecord, true}, limits.temporary, limits.note);
    if (status.ok()) status = read_stl(scanner, spool, losses);
    return status.ok() && spool.face_count() == 0 ? invalid_input("STL: no facets") : std::move(status);
  }
  return unsupported(format
                         ? "it may not fit into --memory. Of mesh files and of pipes, which do not tell their "
                           "size, only PLY and STL are encoded part by part"
                         : "no format that is read");
}

Expected<OutOfCoreResult> encode(std::unique_ptr<ByteStream> stream, const fs::path& source,
                                 const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
                                 const ThreadPool& pool, const Progress& progress) {
  Expected<Scanner> scanner = open_scanner(std::move(stream));
  if (!scanner) return scanner.status();
  Losses losses;
  SpoolOptions spool_options;
  spool_options.folder = limits.temporary;
  spool_options.coding = options.coding();
  spool_options.samples_edges = options.position_bits_by_edges;
  spool_options.most_zero_normals = MemoryPlan(limits, 0).most_zero_normals;
  Expected<std::unique_ptr<MeshSpool>> spool = MeshSpool::create(std::move(spool_options), losses);
  if (!spool) return spool.status();
  Status status = read_mesh(*scanner, source, limits, **spool, losses);
  // A failure of the stream is the reason why the rest of the file is missing.
  if (Status failure = scanner->failure(); !failure.ok()) return failure;
  if (status.ok()) status = (*spool)->finish();
  if (!status.ok()) return status;
  Expected<EncodedSpool> encoded = encode_spool(**spool, options, limits, losses, pool, progress);
  if (!encoded) return encoded.status();

  // The document begins with small meshes, so that its JSON comes from the same code as always.
  MeshFile file;
  file.objects.push_back({(*spool)->name(), {}});
  std::vector<PrimitiveGroup> groups;
  for (const PartsContainer& container : encoded->encoded.containers) {
    groups.push_back({{{0, groups.size()}}});
    file.objects[0].parts.push_back({mesh_of_bounds(container, encoded->attributes), -1});
  }
  Expected<Document> document = document_from_mesh_file(std::move(file));
  if (!document) return document.status();
  status = store_containers(*document, groups, *encoded, limits.temporary);
  if (!status.ok()) return status;
  document->source = source;
  if (source != "-") document->files.push_back(source);
  return OutOfCoreResult{std::move(*document), std::move(encoded->reports), losses.sentences()};
}

}  // namespace

Status check_out_of_core(const EncodeDocumentOptions& options) {
  const auto refuse = [](const std::string& option) {
    return Status(StatusCode::kUsage,
                  option + " does not work with --memory: the mesh is encoded part by part");
  };
  if (options.keep_degenerate) return refuse("--keep-degenerate");
  if (options.keep_unused) return refuse("--keep-unused");
  if (options.keep_duplicates) return refuse("--keep-duplicates");
  if (options.fallback != Fallback::kNone) return refuse("--fallback uncompressed");
  if (options.compat != Compat::kNone) return refuse("--compat khr");
  if (options.condense) return refuse("--condense");
  return {};
}

Expected<OutOfCoreResult> encode_out_of_core(std::unique_ptr<ByteStream> stream, const fs::path& source,
                                             const EncodeDocumentOptions& options,
                                             const OutOfCoreOptions& limits, const ThreadPool& pool,
                                             const Progress& progress) {
  if (Status status = check_out_of_core(options); !status.ok()) return status;
  const Place place{.file = source == "-" ? "stdin" : source.string()};
  try {
    Expected<OutOfCoreResult> result = encode(std::move(stream), source, options, limits, pool, progress);
    if (!result) return result.status().at(place);
    return result;
  } catch (const std::bad_alloc&) {
    return may_pass("out of memory", place);
  } catch (const std::length_error&) {
    return runtime_failure("out of memory", place);
  }
}

}  // namespace psplit
