#include "tools/gltf_psplit/inspect/inspected_asset.h"

#include <algorithm>

#include "encoder/fields/expand_container.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/decode.h"
#include "src/container/patch_boxes.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

// Adds the stream's coding, and the bits of each requested attribute.
Status add_coding(const StreamDescription& stream, InspectedPrimitive& primitive) {
  primitive.coding = stream.coding;
  primitive.bits.clear();
  for (const AttributeRequest& request : primitive.attributes) {
    const auto found = std::ranges::find(stream.attributes, request.unique_id, &StreamAttribute::unique_id);
    if (found == stream.attributes.end())
      return invalid_input("Draco stream: no attribute for " + request.semantic + " (unique id " +
                           std::to_string(request.unique_id) + ")");
    primitive.bits.push_back(found->bits);
  }
  return {};
}

// An attribute of the streams that the primitive does not use has no name.
std::string name_of(const StreamAttribute& attribute, const InspectedPrimitive& primitive) {
  const auto found = std::ranges::find(primitive.attributes, attribute.unique_id, &AttributeRequest::unique_id);
  return found == primitive.attributes.end() ? "unused" : found->semantic;
}

Status inspect_patches(const Document& document, const ThreadPool& pool, InspectedPrimitive& out) {
  const Expected<StoredPrimitive> patched = stored_primitive(document, out.id);
  if (!patched) return patched.status();
  const Expected<PatchContainer> container = open_container(patched->bytes);
  if (!container) return container.status();
  out.summary = summarize_streams(container->entries, container->has_residue, container->head_bytes,
                                  patched->bytes.size());
  out.attributes = patched->requests;
  out.bits.assign(out.attributes.size(), 0);
  // All streams of a container are coded alike, except the last if it holds the residue.
  const Expected<StreamDescription> stream = describe_patch(*container, 0);
  if (!stream) return stream.status();
  for (const StreamAttribute& attribute : stream->attributes)
    out.section_attributes.push_back(name_of(attribute, out));
  Expected<SectionBytes> sections = measure_sections(*container, pool);
  if (!sections) return sections.status();
  out.sections = std::move(*sections);
  Expected<std::vector<PatchBox>> boxes = patch_boxes(*container);
  out.boxes_bytes = boxes_section(*container).size();
  if (boxes)
    out.boxes = std::move(*boxes);
  else
    out.broken_boxes = boxes.status().message();
  return add_coding(*stream, out).at({.patch = 0});
}

Status inspect_stock(const Document& document, const DescribeStream& describe, InspectedPrimitive& out) {
  const Expected<StoredPrimitive> stock = stored_primitive(document, out.id);
  if (!stock) return stock.status();
  const Expected<StreamDescription> stream = describe(stock->bytes);
  if (!stream) return stream.status();
  out.summary = summarize_stream(*stream, stock->bytes.size());
  out.attributes = stock->requests;
  return add_coding(*stream, out);
}

// A .drc file of points, which is decoded already.
Status inspect_cloud(const Document& document, InspectedPrimitive& out) {
  const StoredCloud& cloud = *document.cloud;
  Expected<std::vector<AttributeRequest>> requests = gltf_attributes(cloud.stream.attributes);
  if (!requests) return requests.status();
  // Its accessors have the order of the stream, and may have names that its metadata state.
  const Json& attributes = primitive_json(document, {0, 0})["attributes"];
  for (auto attribute = attributes.begin(); attribute != attributes.end(); ++attribute)
    requests->at(attribute->get<size_t>()).semantic = attribute.key();
  out.storage = PrimitiveStorage::kStockDraco;
  out.summary = summarize_stream(cloud.stream, cloud.stream_bytes);
  out.attributes = *requests;
  return add_coding(cloud.stream, out);
}

// A plain primitive gets only the storage and the counts.
Status inspect_primitive(const Document& document, const DescribeStream& describe, const ThreadPool& pool,
                         InspectedPrimitive& out) {
  if (document.cloud) return inspect_cloud(document, out);
  const PrimitiveRecord& primitive = document.records().primitive(out.id);
  if (!primitive.status.ok()) return primitive.status;
  out.storage = primitive.storage();
  switch (out.storage) {
    case PrimitiveStorage::kPatches: return inspect_patches(document, pool, out);
    case PrimitiveStorage::kStockDraco: return inspect_stock(document, describe, out);
    case PrimitiveStorage::kPlain:
      out.summary.points = document.records().points_of(primitive);
      out.summary.faces = document.records().faces_of(primitive);
      break;
  }
  return {};
}

}  // namespace

Status inspect_primitives(const Document& document, const DescribeStream& describe, const ThreadPool& pool,
                          InspectedAsset& asset) {
  asset.coarse = coarse_counts(document);
  std::vector<InspectedPrimitive> all;
  for (const PrimitiveId id : all_primitives(document)) all.emplace_back().id = id;
  std::vector<Status> statuses(all.size());
  pool.for_each(all.size(),
                [&](size_t i) { statuses[i] = inspect_primitive(document, describe, pool, all[i]); });
  for (size_t i = 0; i < all.size(); ++i) {
    if (!statuses[i].ok()) return std::move(statuses[i]).at(place_of(all[i].id));
    if (!all[i].broken_boxes.empty())
      asset.warnings.push_back(describe_place(all[i].id.mesh, all[i].id.primitive) + ": " +
                               all[i].broken_boxes);
    const bool plain = all[i].storage == PrimitiveStorage::kPlain;
    (plain ? asset.plain : asset.compressed).push_back(std::move(all[i]));
  }
  return {};
}

}  // namespace psplit
