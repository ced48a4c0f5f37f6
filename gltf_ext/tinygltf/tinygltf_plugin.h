// PSPLIT_mesh_draco_patches and KHR_draco_mesh_compression for users of tinygltf:
//
//   tinygltf::TinyGLTF loader;
//   loader.SetFsCallbacks(psplit::tinygltf_file_callbacks());
//   if (!loader.LoadBinaryFromFile(&model, &error, &warning, "dragon.glb")) ...
//   psplit::Status status = psplit::decode_model(model);
//   if (!status.ok()) ... status.to_string() ...
//
// Why callbacks: tinygltf (2.7, and others without a decoder of their own) refuses a primitive whose indices
// have no buffer view, which is how both extensions store them unless there is a fallback. The callbacks read
// files as tinygltf's own do, and lend such indices the extension's view before the JSON is parsed. Whoever has
// a file in memory, or callbacks of his own, calls prepare_for_tinygltf. Indices that were lent a view are
// garbage until decode_model.
//
// A tinygltf built with TINYGLTF_ENABLE_DRACO decodes KHR_draco_mesh_compression on one thread while it parses;
// decode_model then decodes it once more, and what it decoded is what counts.
//
// Errors name mesh, primitive and patch: kInvalidInput (what is broken), kUnsupported, kCancelled, and what the
// backend has. Functions are safe to call from many threads, with models of their own.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "decoder_cuda/psplit_cuda.h"
#include "src/loader/loader.h"
#include "src/status.h"

namespace psplit {

#ifndef TINYGLTF_NO_FS
// For TinyGLTF::SetFsCallbacks: tinygltf's own, and every .gltf and .glb prepared as it is read.
PSPLIT_EXPORT tinygltf::FsCallbacks tinygltf_file_callbacks();
#endif

// Makes a whole .gltf or .glb fit for tinygltf to parse; all else is left as it is. Takes memory for the file
// once more. Errors (kInvalidInput: neither JSON nor GLB where an extension's name stands in it; kUnsupported:
// a GLB that would pass 4 GB) leave it as it is too.
PSPLIT_EXPORT Status prepare_for_tinygltf(std::vector<unsigned char>& file);

struct ModelOptions : LoadOptions {
  // Where it is set, extensionsRequired that are neither in it nor ours are kUnsupported.
  std::optional<std::vector<std::string>> known_extensions{};
};

// Decodes all primitives that have one of the two extensions, in one batch on all threads, and makes the model
// a plain one: accessors point to ordinary buffer views of one new buffer, and the extensions are listed
// nowhere any more. Strips of KHR_draco_mesh_compression become lists, which is what their streams hold.
// Indices of accessors, buffer views and buffers stay as they were; the compressed bytes stay too, used by
// nobody. An accessor that others use for something else is left to them, and the primitive gets a copy. After
// an error the model is as it was.
PSPLIT_EXPORT Status decode_model(tinygltf::Model& model, const ModelOptions& options = {});

// Where the arrays of a primitive lie on the device. Values are tightly packed.
struct DevicePrimitive {
  struct Attribute {
    AttributeRequest request;
    std::byte* values = nullptr;
  };
  size_t mesh = 0, primitive = 0;
  uint32_t point_count = 0, face_count = 0;
  void* indices = nullptr;  // three for each face
  uint32_t index_bytes = 4;
  std::vector<Attribute> attributes;
};

// Primitives that say the same share their arrays.
struct DeviceModel {
  CudaMemory memory;  // holds all of them
  std::vector<DevicePrimitive> primitives;
};

// Decodes all primitives that have one of the two extensions to the current device, with no way back to the
// host; the model stays as it is. In the order of `stream`, where one is given; done when it returns. `options`
// count for nothing but stop, before decoding starts, and known_extensions. Errors: kUnsupported without a
// device, or where an accessor asks for another type than was encoded.
PSPLIT_EXPORT Expected<DeviceModel> decode_model_to_device(const tinygltf::Model& model,
                                                           const ModelOptions& options = {},
                                                           CUstream_st* stream = nullptr);

}  // namespace psplit
