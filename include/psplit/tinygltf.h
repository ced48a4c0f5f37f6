// PSPLIT_mesh_draco_patches and KHR_draco_mesh_compression for users of tinygltf:
//
//   tinygltf::TinyGLTF loader;
//   loader.SetFsCallbacks(psplit::tinygltf_file_callbacks());
//   if (!loader.LoadBinaryFromFile(&model, &error, &warning, "dragon.glb")) ...
//   psplit::Status status = psplit::decode_model(model);
//   if (!status.ok()) ... status.to_string() ...
//
// Why callbacks are needed: without a fallback, both extensions store indices without a buffer view. tinygltf
// (2.7, and other versions without a decoder of their own) refuses such primitives. The callbacks read files
// like tinygltf's own, and give such indices the extension's view before the JSON is parsed. For a file in
// memory, or with callbacks of your own, call prepare_for_tinygltf instead. Indices with such a view are
// garbage until decode_model. In meshes with coarse primitives, which are for loaders without the extension,
// the full primitives replace them; the coarse data stay, unused.
//
// A tinygltf built with TINYGLTF_ENABLE_DRACO decodes KHR_draco_mesh_compression on one thread while it parses.
// decode_model then decodes it again, and its result replaces tinygltf's.
//
// Errors name mesh, primitive and patch: kInvalidInput (broken data), kUnsupported, kCancelled, and the errors
// of the backend. Functions are thread-safe if each thread has its own model.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/cuda.h"
#include "psplit/loader.h"

namespace psplit {

#ifndef TINYGLTF_NO_FS
// For TinyGLTF::SetFsCallbacks: tinygltf's own callbacks, which also prepare every .gltf and .glb that they
// read.
PSPLIT_EXPORT tinygltf::FsCallbacks tinygltf_file_callbacks();
#endif

// Edits a whole .gltf or .glb so that tinygltf can parse it. Leaves all other files unchanged. Takes memory for
// a second copy of the file. Errors also leave the file unchanged: kInvalidInput (an extension's name is in a
// file that is neither JSON nor GLB), kUnsupported (the GLB would be larger than 4 GB).
PSPLIT_EXPORT Status prepare_for_tinygltf(std::vector<unsigned char>& file);

struct ModelOptions : LoadOptions {
  // The extensions that the caller knows. If set, any other extension in extensionsRequired is kUnsupported,
  // except the two of this plugin.
  std::optional<std::vector<std::string>> known_extensions{};
  // See PrimitiveSource::older. Ignored by decode_model_to_device.
  const OlderStreams* older = nullptr;
};

// Decodes all primitives that have one of the two extensions, in one batch on all threads, and makes the model
// a plain one: accessors point to ordinary buffer views of one new buffer, and the extensions are removed from
// all lists. Strips of KHR_draco_mesh_compression become lists, because their streams hold lists. The numbers
// of accessors, buffer views and buffers do not change. The compressed bytes stay, unused. If an accessor of
// such a primitive has other users, the primitive gets a copy of it. An error leaves the model unchanged.
PSPLIT_EXPORT Status decode_model(tinygltf::Model& model, const ModelOptions& options = {});

// The arrays of a primitive on the device. Values are tightly packed.
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

// Primitives with the same data share their arrays.
struct DeviceModel {
  CudaMemory memory;  // of all arrays
  std::vector<DevicePrimitive> primitives;
};

// Decodes all primitives that have one of the two extensions to the current device. Nothing is copied to the
// host, and the model does not change. Works in the order of `stream`, if one is given, and is done when it
// returns. Of `options`, only known_extensions counts, and stop before decoding starts. Errors: kUnsupported
// without a device, or if an accessor declares another type than was encoded.
PSPLIT_EXPORT Expected<DeviceModel> decode_model_to_device(const tinygltf::Model& model,
                                                           const ModelOptions& options = {},
                                                           CUstream_st* stream = nullptr);

}  // namespace psplit
