#include "gltf_ext/convert/validate.h"

#include <algorithm>

#include "gltf_ext/convert/check_values.h"
#include "gltf_ext/convert/stock_rules.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/document/read_steps.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "gltf_ext/primitive/view_in_place.h"
#include "psplit/decode.h"

namespace psplit {
namespace {

// rule                what it checks
// ------------------  ----------------------------------------------------------------------------------
// extension-used      extensionsUsed lists the extension if a primitive has it
// extension-required  extensionsRequired lists it if a primitive has no fallback (a warning for stock Draco)
// extension-unused    a list names the extension, but no primitive has it (warning)
// mode                a primitive in patches is a triangle list
// members             bufferView and attributes exist and refer to existing objects
// exclusion           no stock Draco on the same primitive, no sparse accessor, no compressed container
// container           header, directory and lengths obey the specification's appendix
// decode              every stream decodes to the counts in its row, and every reference resolves
// attribute-type      every stream stores the component types that the accessors state
// copies              all copies of a point in patches decode to the same bits
// boxes               the section of boxes can be read, and each box has all finite positions of its stream
// accessor-count      accessors count the decoded data: one value for each point, three indices for each face
// accessor-bounds     min and max are the bounds of the decoded values
// index-type          indices are scalars of a component type that can hold every index
// fallback            accessors with data of their own hold the decoded data
// attribute-extra     an attribute of the primitive is not in the patches (warning)
// geometry            data outside of patches can be read: accessors, indices, stock Draco, morph targets
// coarse              coarse primitives can be read, have as many morph targets, and are not in patches
// target-count        morph targets of lines and points have as many values as the primitive (warning)
// finite              values are neither infinite nor NaN (warning)
// unit-normals        normals are unit vectors (warning)
// weights-sum         the weights of a point sum to one (warning)
// joints-range        joints are joints of the skin (warning)
// linked-file         the file of an image or an extension exists, at a relative path (warning)
//
// The rules for stock Draco are extension-used, extension-required, mode, members, exclusion, attribute-type,
// accessor-count, accessor-bounds and index-type: loaders disagree about an asset that breaks one, so these are
// errors. decode_document does not need the accessors' statements, so it corrects them, and says so.
//
// gltf_ext/PSPLIT_mesh_draco_patches/README.md is the specification.

bool has_patches(const Document& document, PrimitiveId id) {
  return document.records().primitive(id).patches.has_value();
}

// What the lists must say of one of the two Draco extensions.
struct ExtensionUse {
  bool any = false, any_without_fallback = false;
};

void check_lists(const Document& document, std::vector<Finding>& findings) {
  const auto report = [&](const char* rule, const std::string& message, bool error, bool only_validated) {
    Place place{.file = document.source.string()};
    findings.push_back({rule, message, std::move(place), error, StatusCode::kInvalidInput, only_validated});
  };
  ExtensionUse patches, stock;
  for (size_t i = 0; i < array_size(document.json(), "meshes"); ++i) {
    const Json* const coarse = other_primitives(document.json()["meshes"][i]);
    if (coarse == nullptr) continue;
    patches.any = true;
    for (const Json& primitive : *coarse)
      stock.any |= extension_field(primitive, kStockExtensionName) != nullptr;
  }
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveStorage storage = document.records().primitive(id).storage();
    if (storage == PrimitiveStorage::kPlain) continue;
    ExtensionUse& use = storage == PrimitiveStorage::kPatches ? patches : stock;
    use.any = true;
    use.any_without_fallback |= !all_have_fallbacks(document, std::span(&id, 1));
  }
  const auto check = [&](const ExtensionUse& use, const char* name, const std::string& the_extension,
                         bool only_validated) {
    const bool used = lists_extension(document.json(), "extensionsUsed", name);
    const bool required = lists_extension(document.json(), "extensionsRequired", name);
    if (use.any && !used)
      report("extension-used", "extensionsUsed does not list " + the_extension, true, only_validated);
    // Real assets of stock Draco have this fault, and every loader reads them.
    if (use.any_without_fallback && !required)
      report("extension-required",
             "a primitive has no fallback, but extensionsRequired does not list " + the_extension,
             !only_validated, only_validated);
    if (!use.any && (used || required))
      report("extension-unused", the_extension + " is listed, but nothing uses it", false, false);
  };
  check(patches, kExtensionName, "the extension", false);
  check(stock, kStockExtensionName, kStockExtensionName, true);
}

// A failure to read a primitive without patches. Lines, points, and data that only other software knows pass
// through plain primitives. Stock Draco has to be decoded.
std::vector<Finding> unreadable(const Document& document, PrimitiveId id, const Status& status) {
  const bool is_stock = document.records().primitive(id).storage() == PrimitiveStorage::kStockDraco;
  if (status.ok() || (!is_stock && status.code() != StatusCode::kInvalidInput)) return {};
  return {
      {"geometry", status.message(), Status(status).at(place_of(document, id)).place(), true, status.code()}};
}

std::vector<Finding> check_geometry(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                                    const ThreadPool& pool, ValueWarnings warnings) {
  const bool is_stock = document.records().primitive(id).storage() == PrimitiveStorage::kStockDraco;
  // Large primitives are not copied into memory. If something is wrong, read_primitive says what.
  std::optional<MeshView> view = valid_view_in_place(document, id);
  Expected<Mesh> mesh = Mesh();
  if (!view) {
    mesh = read_primitive(document, id, backend, pool);
    if (!mesh) {
      std::vector<Finding> findings = unreadable(document, id, mesh.status());
      if (findings.empty() && warnings == ValueWarnings::kAll) findings = check_target_counts(document, id);
      return findings;
    }
    view = view_of(*mesh);
  }
  // Morph targets are plain, whatever the primitive is.
  const Status morphs = read_morph_targets(document, id, view->point_count).status();
  if (morphs.code() == StatusCode::kInvalidInput)
    return {{"geometry", morphs.message(), Status(morphs).at(place_of(document, id)).place()}};
  std::vector<Finding> findings;
  if (warnings == ValueWarnings::kNone) return findings;
  if (is_stock) findings = check_stock_primitive(document, id, *view);
  std::ranges::move(check_values(document, id, *view), std::back_inserter(findings));
  return findings;
}

// What loaders without the extension show. They see a copy of the document, in which the coarse primitives are
// the only ones.
std::vector<Finding> check_coarse(const Document& document, const DecodeBackend& backend,
                                  const ThreadPool& pool) {
  std::vector<Finding> findings;
  std::vector<size_t> meshes;
  const Json& json = document.json();
  for (size_t i = 0; i < array_size(json, "meshes"); ++i)
    if (other_primitives(json["meshes"][i]) != nullptr) meshes.push_back(i);
  if (meshes.empty()) return {};
  Document shown = document;
  if (!exchange_primitives(shown.json()).ok()) return {};
  for (const size_t mesh : meshes) shown.json()["meshes"][mesh]["extensions"].erase(kExtensionName);
  if (const Status status = check_scene(shown); !status.ok())
    return {{"coarse", "coarse: " + status.message(),
             Status(status).at({.file = document.source.string()}).place()}};
  for (const size_t mesh : meshes) {
    const std::vector<PrimitiveRecord>& primitives = shown.records().meshes[mesh];
    for (size_t p = 0; p < primitives.size(); ++p) {
      const PrimitiveId id{mesh, p};
      const auto report = [&](std::string message, StatusCode code = StatusCode::kInvalidInput) {
        findings.push_back({"coarse", "coarse: " + std::move(message), place_of(document, id), true, code});
      };
      if (primitives[p].patches) report("is in patches");
      const size_t targets = document.records().meshes[mesh].front().targets.size();
      if (primitives[p].targets.size() != targets)
        report(std::to_string(primitives[p].targets.size()) +
               " morph targets, but the primitives that replace it have " + std::to_string(targets));
      const Status status = primitives[p].patches ? Status() : check_readable(shown, id, backend, pool);
      if (status.code() == StatusCode::kInvalidInput) report(status.message(), status.code());
    }
  }
  return findings;
}

// The findings of all primitives, or of primitives in patches alone, and of the lists.
std::vector<Finding> find_all(const Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                              const MemoryLimit& limit, ValueWarnings warnings, bool only_patches) {
  if (const Status status = document.check(); !status.ok())
    return {{"members", status.message(), {.file = document.source.string()}, true, status.code()}};
  // Equal primitives in patches share a container, which is decoded once.
  std::vector<PrimitiveId> patched;
  std::vector<PrimitiveGroup> groups;
  for (const PrimitiveId id : all_primitives(document)) {
    if (has_patches(document, id))
      patched.push_back(id);
    else if (!only_patches)
      groups.push_back({{id}});
  }
  const size_t plain_count = groups.size();
  for (PrimitiveGroup& group : group_equal_primitives(document, patched)) groups.push_back(std::move(group));
  std::vector<std::vector<Finding>> found(groups.size());
  const auto check = [&](size_t i) {
    const PrimitiveId id = groups[i].ids.front();
    found[i] = i < plain_count ? check_geometry(document, id, backend, pool, warnings)
                               : check_patched_primitive(document, id, backend, pool, limit, warnings);
  };
  std::vector<size_t> large, others;
  for (size_t i = 0; i < groups.size(); ++i) {
    const bool is_large =
        i >= plain_count && limit.bytes > 0 && is_too_large_to_check(document, groups[i].ids.front(), limit);
    (is_large ? large : others).push_back(i);
  }
  pool.for_each(others.size(), [&](size_t i) { check(others[i]); });
  for (const size_t i : large) check(i);  // threads share the patches of each

  std::map<PrimitiveId, const std::vector<Finding>*> found_of;
  for (size_t i = 0; i < groups.size(); ++i)
    for (const PrimitiveId id : groups[i].ids) found_of[id] = &found[i];
  std::vector<Finding> findings;
  for (const auto& [id, of_primitive] : found_of)
    for (Finding finding : *of_primitive) {
      finding.place.mesh = static_cast<int64_t>(id.mesh);
      finding.place.primitive = static_cast<int64_t>(id.primitive);
      findings.push_back(std::move(finding));
    }
  std::ranges::move(check_coarse(document, backend, pool), std::back_inserter(findings));
  check_lists(document, findings);
  return findings;
}

Status first_refusal(std::vector<Finding> findings) {
  for (Finding& finding : findings)
    if (finding.is_refused())
      return {finding.code, finding.message + " [" + finding.rule + "]", std::move(finding.place)};
  return {};
}

}  // namespace

std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool, const MemoryLimit& limit) {
  std::vector<Finding> findings = find_all(document, backend, pool, limit, ValueWarnings::kAll, false);
  if (!document.check().ok()) return findings;
  for (const LinkedFile& link : linked_files(document))
    if (std::string text = describe_dangling(link); !text.empty())
      findings.push_back({"linked-file", std::move(text), {.file = document.source.string()}, false});
  return findings;
}

Status check_readable(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                      const ThreadPool& pool) {
  // Large primitives are not copied into memory. If something is wrong, read_primitive says what.
  if (const std::optional<MeshView> view = valid_view_in_place(document, id))
    return read_morph_targets(document, id, view->point_count).status();
  const Expected<Mesh> mesh = read_primitive(document, id, backend, pool);
  if (!mesh) return mesh.status();
  return read_morph_targets(document, id, mesh->point_count).status();
}

Status check_document(const Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                      const MemoryLimit& limit) {
  return first_refusal(find_all(document, backend, pool, limit, ValueWarnings::kNone, false));
}

Status check_patches(const Document& document, const ThreadPool& pool) {
  return first_refusal(find_all(document, cpu_backend(), pool, {}, ValueWarnings::kNone, true));
}

Status check_decoded(const Document& document, std::span<const PrimitiveId> ids,
                     std::span<const MeshView> meshes, std::span<const std::vector<StreamFindings>> streams,
                     const DecodeBackend& backend, const ThreadPool& pool) {
  std::vector<Finding> findings;
  for (size_t i = 0; i < ids.size(); ++i)
    std::ranges::move(check_decoded_primitive(document, ids[i], meshes[i], streams[i]),
                      std::back_inserter(findings));
  std::ranges::move(check_coarse(document, backend, pool), std::back_inserter(findings));
  check_lists(document, findings);
  return first_refusal(std::move(findings));
}

}  // namespace psplit
