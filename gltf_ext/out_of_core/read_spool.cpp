#include "gltf_ext/out_of_core/read_spool.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "gltf_ext/out_of_core/obj_spool.h"
#include "mesh_files/obj.h"
#include "mesh_files/ply.h"
#include "mesh_files/stl.h"
#include "src/catch_exceptions.h"

namespace psplit {
namespace {

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

// A file too short for its points and faces is read, so that the reader reports the error.
bool has_room(uint64_t bytes, const PlyHeader& header, const ExpectedSizes& sizes) {
  uint64_t point = 0;
  for (const PlyElement& element : header.elements)
    for (const PlyProperty& property : element.properties)
      if (element.name == "vertex" && !property.is_list)
        point += header.encoding == PlyEncoding::kText ? 2 : ply_type_bytes(property.type);
  return sizes.points * point + sizes.faces <= bytes;
}

Status read_ply_to(Scanner& scanner, MeshSpool& spool, Losses& losses, const CheckSizes& check,
                   const ThreadPool& pool) {
  const Expected<PlyHeader> header = read_ply_header(scanner);
  if (!header) return header.status();
  const ExpectedSizes sizes = expected_sizes(*header);
  const std::optional<uint64_t> left = scanner.bytes_left();
  if (check && (!left || has_room(*left, *header, sizes)))
    if (Status status = check(sizes, left.has_value()); !status.ok()) return status;
  return read_ply(scanner, *header, spool, losses, pool);
}

Status read_stl_to(Scanner& scanner, MeshSpool& spool, Losses& losses, const CheckSizes& check) {
  constexpr uint64_t kTextFacet = 100;  // bytes; a facet of a text takes about these at least
  constexpr uint64_t kFacet = 50, kRecord = 24;
  const std::optional<uint64_t> left = scanner.bytes_left();
  const std::optional<uint32_t> counted = facet_count_of_binary_stl(scanner);
  const uint64_t facets = counted ? *counted : left.value_or(0) / kTextFacet;
  if (check && (!left || !counted || facets * kFacet <= *left))
    if (Status status = check({3 * facets, facets, kRecord, true}, left.has_value()); !status.ok())
      return status;
  Status status = read_stl(scanner, spool, losses);
  return status.ok() && spool.face_count() == 0 ? invalid_input("STL: no facets") : std::move(status);
}

Status read_obj_to(Scanner& scanner, const SpoolOptions& options, const OpenLibrary& open_library,
                   MeshSpool& spool, Losses& losses, const CheckSizes& check, ObjHead& head) {
  Expected<ObjSpool> values = ObjSpool::create(options.folder);
  if (!values) return values.status();
  Expected<ObjHead> read = read_obj_into(scanner, open_library, *values);
  if (!read) return read.status();
  losses = read->file.losses;
  head = std::move(*read);
  if (check)
    if (Status status = check(values->sizes(), true); !status.ok()) return status;
  return values->write_to(spool, losses, options.numbers_points);
}

Expected<Asset> read(Scanner& scanner, AssetFormat format, const std::filesystem::path& source,
                     SpoolOptions options, const CheckSizes& check, const ThreadPool& pool) {
  const bool is_obj = format == AssetFormat::kObj;
  if (!can_be_spooled(format)) return unsupported("this format is not read part by part");
  if (is_obj) options.most_zero_normals = 0;  // faces around one spooled point may belong to several points
  Losses losses;
  MeshSpool spool(options, losses);
  ObjHead head;
  std::vector<std::filesystem::path> libraries;
  Status status =
      is_obj ? read_obj_to(scanner, options, libraries_beside(source, libraries), spool, losses, check, head)
      : format == AssetFormat::kPly ? read_ply_to(scanner, spool, losses, check, pool)
                                    : read_stl_to(scanner, spool, losses, check);
  // A failure of the stream is the reason why the rest of the file is missing.
  if (Status failure = scanner.failure(); !failure.ok()) return failure;
  if (!status.ok()) return status;
  Expected<Document> document = spool.finish(head.file, head.material);
  if (!document) return document.status();
  document->spooled->are_repeated = format != AssetFormat::kPly;
  document->source = source;
  document->files = std::move(libraries);
  if (source != "-") document->files.push_back(source);
  std::vector<std::string> warnings = losses.sentences();
  say_heights(head.file, source.parent_path(), warnings);
  return Asset{std::move(*document), std::move(warnings), true};
}

}  // namespace

bool can_be_spooled(AssetFormat format) {
  return format == AssetFormat::kPly || format == AssetFormat::kStl || format == AssetFormat::kObj;
}

Expected<Asset> read_spool(Scanner& scanner, AssetFormat format, const std::filesystem::path& source,
                           SpoolOptions options, const CheckSizes& check, const ThreadPool& pool) {
  const Place place{.file = source == "-" ? "stdin" : source.string()};
  Expected<Asset> asset =
      catch_exceptions([&] { return read(scanner, format, source, std::move(options), check, pool); });
  if (!asset) return asset.status().at(place);
  return asset;
}

}  // namespace psplit
