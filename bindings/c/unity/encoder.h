// The functions by which Unity's package com.unity.cloud.draco encodes, in the library that decodes (plugin.h).
// It calls them in this order:
//
//   dracoEncoderCreate, dracoEncoderSetAttribute for each attribute, dracoEncoderSetIndices,
//   dracoEncoderSetCompressionSpeed, dracoEncoderSetQuantizationBits, dracoEncoderEncode
//   dracoEncoderGetEncoded..., dracoEncoderGetEncodeBuffer, dracoEncoderRelease
//
// The bytes equal libdraco's encoder's. Types have Draco's numbers. `flip` turns Unity's coordinates into
// right-handed ones, the reverse of plugin.h. A point cloud has no indices: it
// is a kD-tree if libdraco would choose one. A call with arguments that cannot be encoded makes
// dracoEncoderEncode return false. Thread-safe for different encoders.
#pragma once

#include <cstdint>

#include "psplit/base.h"

#define PSPLIT_UNITY_ENCODER extern "C" PSPLIT_EXPORT

struct UnityEncoder;

PSPLIT_UNITY_ENCODER UnityEncoder* dracoEncoderCreate(uint32_t vertexCount);
PSPLIT_UNITY_ENCODER UnityEncoder* dracoEncoderCreatePointCloud(uint32_t vertexCount);
PSPLIT_UNITY_ENCODER void dracoEncoderRelease(UnityEncoder* encoder);

// The larger of both counts, as in libdraco.
PSPLIT_UNITY_ENCODER void dracoEncoderSetCompressionSpeed(UnityEncoder* encoder, uint32_t encodingSpeed,
                                                          uint32_t decodingSpeed);
// The bits of a component; 0 stores values exactly.
PSPLIT_UNITY_ENCODER void dracoEncoderSetQuantizationBits(UnityEncoder* encoder, uint32_t position,
                                                          uint32_t normal, uint32_t uv, uint32_t color,
                                                          uint32_t generic);

// Indices of 8, 16 or 32 bits. Copies them. False for other types.
PSPLIT_UNITY_ENCODER bool dracoEncoderSetIndices(UnityEncoder* encoder, int32_t indexComponentType,
                                                 uint32_t indexCount, bool flip, const void* indices);
// A value for each vertex, `stride` bytes apart. Copies them. Returns the attribute's unique id.
PSPLIT_UNITY_ENCODER uint32_t dracoEncoderSetAttribute(UnityEncoder* encoder, int32_t attributeType,
                                                       int32_t dataType, int32_t componentCount, int32_t stride,
                                                       bool flip, const void* data);

// Not 0: a sequential stream, which keeps the order of faces and points.
PSPLIT_UNITY_ENCODER bool dracoEncoderEncode(UnityEncoder* encoder, uint8_t preserveTriangleOrder);
// Of the stream; 0 before there is one.
PSPLIT_UNITY_ENCODER uint32_t dracoEncoderGetEncodedVertexCount(UnityEncoder* encoder);
PSPLIT_UNITY_ENCODER uint32_t dracoEncoderGetEncodedIndexCount(UnityEncoder* encoder);
PSPLIT_UNITY_ENCODER uint64_t dracoEncoderGetByteLength(UnityEncoder* encoder);
PSPLIT_UNITY_ENCODER void dracoEncoderCopy(UnityEncoder* encoder, uint8_t* data);
// They belong to the encoder.
PSPLIT_UNITY_ENCODER void dracoEncoderGetEncodeBuffer(UnityEncoder* encoder, void** data, uint64_t* size);
