// The public headers of psplit::decoder, in the order in which to read them. `#include <psplit/psplit.hpp>` is
// all that a loader needs.
//
// status.h and mesh.h have the types that everything returns: an Expected<T> holds a T or a Status, and a Mesh
// is one triangle primitive in plain arrays. loader.h is the one header that most loaders need: it turns the
// bytes of a primitive into indices and attributes in the caller's memory. The rest is for more than that.
// parallel.h has the pool of threads that decoding uses, decode_backend.h what a decoder is (the CPU's is the
// default), cpu_backend.h the CPU's decoder, draco_stream.h single Draco files, of meshes or point clouds,
// stream_description.h what a Draco stream holds, and draco_metadata.h what it says beside its geometry.
//
// draco_decoder.h, which this header does not include, fills libdraco's own classes.
//
// Each other component of the package has headers of its own, which are installed below psplit/:
//
//   psplit::cuda      decoder_cuda/psplit_cuda.h             decodes on a GPU
//   psplit::tinygltf  gltf_ext/tinygltf/tinygltf_plugin.h    loads whole glTF files with tinygltf
//   psplit::encoder   encoder/encode.h                       a mesh in, a patch container or Draco streams out
//                     encoder/libdraco/draco_backend.h       decodes with libdraco, to compare
//   psplit::gltf      gltf_ext/document/document.h           reads a glTF document
//                     gltf_ext/convert/encode_document.h     encodes all of its meshes
//                     gltf_ext/convert/decode_document.h     decodes all of its meshes
//                     gltf_ext/convert/expand_document.h     turns condensed patches into Draco streams
//                     gltf_ext/document/write_document.h     writes it
//
// gltf_ext/examples has a program for each of these.
//
// All of these headers are C++17. psplit itself is compiled as C++20.
#pragma once

// clang-format off: the order is for readers.
#include "src/container/decode_backend.h"
#include "src/container/stream_description.h"
#include "src/cpu/cpu_backend.h"
#include "src/cpu/draco_metadata.h"
#include "src/cpu/draco_stream.h"
#include "src/loader/loader.h"
#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/status.h"
// clang-format on
