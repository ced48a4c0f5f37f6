// The functions that Unity's package Draco loads from its native library. com.unity.cloud.draco 5 loads
// libdraco_unity.so, with an encoder (encoder.h); DracoUnity 4 loads libdracodec_unity.so. Both are built here,
// and take the place of these libraries. Names, structs and meanings are the package's, which calls them in
// this order:
//
//   DecodeDracoMeshStep1, which decodes everything, DecodeDracoMeshStep2, which has nothing left to do
//   GetAttributeByType or GetAttributeByUniqueId for each attribute
//   GetMeshIndices into the caller's memory, GetAttributeData for each attribute
//   ReleaseDracoData, ReleaseDracoAttribute, ReleaseDracoMesh
//
// Types have Draco's numbers. `flip` turns right-handed coordinates, as glTF has them, into Unity's: triangles
// turn round, values of two components get 1 - y, of three -x, of four -y and -z, in the values' own type. A
// pointer that a function sets must be null before. A call that fails returns false, or a negative number, and
// sets nothing. Thread-safe for different meshes, and for one mesh after it was decoded.
#pragma once

#include <cstdint>

#include "psplit/base.h"

#define PSPLIT_UNITY extern "C" PSPLIT_EXPORT

struct DracoMesh {
  int32_t numFaces;
  int32_t numVertices;
  int32_t numAttributes;
  bool isPointCloud;
  void* privateMesh;
};
struct DracoAttribute {
  int32_t attributeType;  // 0 position, 1 normal, 2 colour, 3 texture coordinate, 4 generic
  int32_t dataType;
  int32_t numComponents;
  int32_t uniqueId;
  const void* privateAttribute;
};
struct DracoData {
  int32_t dataType;
  void* data;
};

// Decodes a mesh or a point cloud of bitstream 2.2. The bytes are not read after the call. Returns 0; -1 for
// pointers that are not as above, -4 for a stream that does not decode. The package asserts that `decoder` and
// `buffer` are not null, and only gives them to DecodeDracoMeshStep2: both become a pointer that nobody frees.
PSPLIT_UNITY int32_t DecodeDracoMeshStep1(const char* data, uint32_t length, DracoMesh** mesh, void** decoder,
                                          void** buffer);
PSPLIT_UNITY int32_t DecodeDracoMeshStep2(DracoMesh** mesh, void* decoder, void* buffer);
PSPLIT_UNITY void ReleaseDracoMesh(DracoMesh** mesh);

PSPLIT_UNITY bool GetAttribute(const DracoMesh* mesh, int32_t index, DracoAttribute** attribute);
// The attribute at `index` among the attributes of a type.
PSPLIT_UNITY bool GetAttributeByType(const DracoMesh* mesh, int32_t type, int32_t index,
                                     DracoAttribute** attribute);
PSPLIT_UNITY bool GetAttributeByUniqueId(const DracoMesh* mesh, int32_t uniqueId, DracoAttribute** attribute);
PSPLIT_UNITY void ReleaseDracoAttribute(DracoAttribute** attribute);

// Writes three indices for each face, of Draco's type 4 (two bytes) or 6 (four). Fails if `indicesCount` is too
// small for them, or a point's number for two bytes.
PSPLIT_UNITY bool GetMeshIndices(const DracoMesh* mesh, int32_t dataType, void* indices, uint32_t indicesCount,
                                 bool flip);
// Values by point, of the attribute's own type and componentStride components each; components that the
// attribute lacks are 0. Fails for integers of 64 bits, doubles, bools, and more than four components.
PSPLIT_UNITY bool GetAttributeData(const DracoMesh* mesh, const DracoAttribute* attribute, DracoData** data,
                                   bool flip, int32_t componentStride);
PSPLIT_UNITY void ReleaseDracoData(DracoData** data);
