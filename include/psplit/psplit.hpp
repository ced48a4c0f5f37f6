// Includes all headers of psplit that need no other library. A loader needs no other one.
//
// The headers, in reading order:
//
//   psplit::decoder   base.h            what everything returns: an Expected<T> holds a T or a Status
//                     mesh.h            a Mesh is one triangle primitive in plain arrays
//                     loader.h          turns the bytes of a primitive into indices and attributes in the
//                                       caller's memory. Most loaders need no more
//                     parallel.h        the pool of threads that decoding uses
//                     decode.h          what a decoder is, the CPU's, and functions for single Draco files
//                     draco_types.h     types of a Draco stream
//                     version.h         the version as macros
//                     draco_decoder.h   fills libdraco's own classes; needs libdraco's headers
//   psplit::cuda      cuda.h            decodes on a GPU
//   psplit::tinygltf  tinygltf.h        loads whole glTF files with tinygltf, whose header it needs
//   psplit::encoder   encode.h          a mesh in, a container of patches or Draco streams out
//   psplit::gltf      document.h        reads, edits and writes a glTF document; needs nlohmann-json's headers
//                     gltf.h            encodes and decodes all of its meshes
//   psplit::c         psplit.h          decodes and encodes, for C and languages that call it
//
// gltf_ext/examples has a program for each of these. All headers but psplit.h and version.h are C++17. psplit
// itself is compiled as C++20.
#pragma once

#include "psplit/base.h"
#include "psplit/cuda.h"
#include "psplit/decode.h"
#include "psplit/draco_types.h"
#include "psplit/loader.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"
#include "psplit/version.h"
#if __has_include("psplit/encode.h")
#include "psplit/encode.h"
#endif
#if __has_include("psplit/gltf.h") && __has_include(<nlohmann/json_fwd.hpp>)
#include "psplit/document.h"
#include "psplit/gltf.h"
#endif
