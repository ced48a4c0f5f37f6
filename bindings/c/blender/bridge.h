// The functions that Blender's glTF add-on (io_scene_gltf2) loads from its Draco library. libextern_draco.so,
// which is built here, takes the place of Blender's own: the add-on finds it by its environment variable, or in
// the place of that library. Names and meanings are the add-on's; it calls them through ctypes:
//
//   import   decoderCreate, decoderDecode, decoderReadIndices and ...CopyIndices, for each attribute
//            decoderReadAttribute and ...CopyAttribute, decoderRelease
//   export   encoderCreate, for each attribute encoderSetAttribute, encoderSetIndices, encoderSet...,
//   encoderEncode,
//            encoderCopy, encoderRelease
//
// Types of components are glTF's numbers (5120 to 5126), and types of elements its names ("VEC3"). A call that
// fails returns false, 0 or nothing; a null handle fails. Decoder and encoder are for one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "psplit/base.h"

#define PSPLIT_BLENDER extern "C" PSPLIT_EXPORT

struct Decoder;
struct Encoder;

PSPLIT_BLENDER Decoder* decoderCreate();
PSPLIT_BLENDER void decoderRelease(Decoder* decoder);
// Decodes a mesh of any bitstream that libdraco knows; without libdraco only of 2.2. The bytes are not read
// after the call.
PSPLIT_BLENDER bool decoderDecode(Decoder* decoder, void* data, size_t byteLength);
PSPLIT_BLENDER uint32_t decoderGetVertexCount(Decoder* decoder);
PSPLIT_BLENDER uint32_t decoderGetIndexCount(Decoder* decoder);
// Attributes have the ids of the extension.
PSPLIT_BLENDER bool decoderAttributeIsNormalized(Decoder* decoder, uint32_t id);
// Converts the values to the type by libdraco's rules. Fails if a value does not fit.
PSPLIT_BLENDER bool decoderReadAttribute(Decoder* decoder, uint32_t id, size_t componentType, char* dataType);
// Of what was read.
PSPLIT_BLENDER size_t decoderGetAttributeByteLength(Decoder* decoder, size_t id);
PSPLIT_BLENDER void decoderCopyAttribute(Decoder* decoder, size_t id, void* output);
// Fails if an index does not fit the type.
PSPLIT_BLENDER bool decoderReadIndices(Decoder* decoder, size_t indexComponentType);
PSPLIT_BLENDER size_t decoderGetIndicesByteLength(Decoder* decoder);
PSPLIT_BLENDER void decoderCopyIndices(Decoder* decoder, void* output);

PSPLIT_BLENDER Encoder* encoderCreate(uint32_t vertexCount);
PSPLIT_BLENDER void encoderRelease(Encoder* encoder);
// 0 (fastest) to 10 (smallest).
PSPLIT_BLENDER void encoderSetCompressionLevel(Encoder* encoder, uint32_t compressionLevel);
// 0: exactly.
PSPLIT_BLENDER void encoderSetQuantizationBits(Encoder* encoder, uint32_t position, uint32_t normal,
                                               uint32_t uv, uint32_t color, uint32_t generic);
PSPLIT_BLENDER void encoderSetIndices(Encoder* encoder, size_t indexComponentType, uint32_t indexCount,
                                      void* indices);
// Copies a value for each vertex, tightly packed. Returns the id that the attribute will have. Add-ons pass one
// argument more since Blender 4.2, whether the values are normalized. It is not read, because older ones do
// not: integers are normalized where glTF wants that.
PSPLIT_BLENDER uint32_t encoderSetAttribute(Encoder* encoder, char* attributeName, size_t componentType,
                                            char* dataType, void* data);
// Writes one Draco stream. If preserveTriangleOrder is not 0, faces and vertices keep their order, as morph
// targets need it. Otherwise faces that repeat a vertex, and vertices that no face uses, are left out.
PSPLIT_BLENDER bool encoderEncode(Encoder* encoder, uint8_t preserveTriangleOrder);
PSPLIT_BLENDER uint32_t encoderGetEncodedVertexCount(Encoder* encoder);
PSPLIT_BLENDER uint32_t encoderGetEncodedIndexCount(Encoder* encoder);
PSPLIT_BLENDER uint64_t encoderGetByteLength(Encoder* encoder);
PSPLIT_BLENDER void encoderCopy(Encoder* encoder, uint8_t* data);
