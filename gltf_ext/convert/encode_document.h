// A glTF document to PSPLIT_mesh_draco_patches.
#pragma once

#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/document/document.h"
#include "src/container/decode_backend.h"
#include "src/export.h"

namespace psplit {

// Replaces the geometry of every triangle primitive in place: primitives that are split become
// PSPLIT_mesh_draco_patches, and primitives that stay whole become KHR_draco_mesh_compression. Two kinds are
// left as they are, unless patches were asked for (PatchTarget::is_given): stock Draco that would not become
// smaller, and plain geometry that is smaller than its stream. EXT_mesh_manifold is dropped from the meshes of
// replaced primitives, because its data refer to indices. Then all that is wanted is condensed
// (EncodeDocumentOptions::condense).
//
// Primitives that are in patches already stay as they are, except with Compat::kKhr. They are decoded once and
// checked whole; an invalid one is an error.
//
// With limits.memory, plain primitives that do not fit into memory are encoded part by part, and always become
// patches, or streams of their own with Compat::kKhr; the buffers should be mapped (FileAccess::kMap). One that
// exceeds a container, or what can be condensed in memory, becomes several primitives. kUnsupported if such a
// primitive would share its grid with others, or with keep_unused its points.
//
// After an error the document is unusable. `progress` counts faces, patch by patch, and is called from any
// thread.
PSPLIT_EXPORT Expected<std::vector<PrimitiveReport>> encode_document(
    Document& document, const EncodeDocumentOptions& options, const DecodeBackend& backend,
    const ThreadPool& pool, const Progress& progress = {}, const OutOfCoreOptions& limits = {});

}  // namespace psplit
