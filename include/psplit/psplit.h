// The interface of psplit for C, and for all languages that call C: it decodes meshes of
// PSPLIT_mesh_draco_patches, of KHR_draco_mesh_compression and of .drc files into the caller's memory, and
// encodes them. The library is `psplit`: psplit::c for CMake's find_package(psplit), `psplit` for pkg-config.
// bindings/ has packages for Rust and C# over it, and docs/c.md shows how to call it from Go. C++ has
// interfaces of its own: psplit.hpp.
//
//   psplit_error error;
//   PSPLIT_INIT(error);
//   psplit_gltf_source source;  // of a whole file in memory
//   PSPLIT_INIT(source);
//   source.data = bytes;
//   source.size = size;
//   psplit_gltf* file = NULL;
//   psplit_mesh* mesh = NULL;
//   if (psplit_gltf_open(&source, &file, &error) != PSPLIT_OK) return fail(error.text);
//   if (psplit_gltf_open_primitive(file, 0, 0, &mesh, &error) != PSPLIT_OK) return fail(error.text);
//   psplit_mesh_info info;  // how much memory the result takes
//   PSPLIT_INIT(info);
//   psplit_mesh_get_info(mesh, &info, NULL);
//   ...
//   psplit_mesh_decode(mesh, &buffers, NULL, &error);  // NULL: on all threads
//
// Structs    The first member of each struct is its size, which the caller sets: PSPLIT_INIT does, and makes
//            all other members zero. So a program and a library of other versions fit together. The size is
//            also that of results. A larger struct than the library knows must be zero beyond what it knows.
//            All elements of an array have the size of the first. `reserved` members are 0.
// Handles    Each is made by a function with a `psplit_..._free`, which takes NULL too. They may be freed in
//            any order: each keeps what it needs of others. Functions that return a number take NULL for an
//            object without content.
// Errors     A function that can fail returns a psplit_code. If `error`, which may be NULL, is given, it gets
//            the code and a sentence with its place; after success, PSPLIT_OK and no text. PSPLIT_ERROR_USAGE
//            is also the code of null pointers, sizes that are too small, and buffers that do not fit. After an
//            error, handles to be returned are NULL, other results are not set, and buffers may hold anything.
//            Nothing is written outside of them.
// Bytes      Bytes to be decoded may be anything. Memory is taken in proportion to them: at most 64 MiB, and
//            4096 bytes for each byte.
// Bitstreams Draco streams are of bitstream 2.2, point clouds also of 2.3. Meshes of older ones are decoded by
//            libdraco, if the library was built with its encoder and libdraco; its memory has no such limit.
//            Otherwise they are PSPLIT_ERROR_UNSUPPORTED. Opening decodes them, to count points. Their values
//            have types of glTF: those of a .drc file become these, and are never PSPLIT_INTEGERS.
// Lifetime   The library reads the caller's bytes until the last handle that was made of them is freed, unless
//            PSPLIT_COPY is set. All other memory of the caller's is used only during a call. Pointers in
//            results belong to the handle that was asked, and live as long as it.
// Threads    All functions are thread-safe, also with one handle. Only freeing a handle, and
//            psplit_gltf_set_buffer, need it for themselves.
#ifndef PSPLIT_PSPLIT_H
#define PSPLIT_PSPLIT_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "version.h"

#if defined(_WIN32) && defined(PSPLIT_C_BUILDS)
#define PSPLIT_API __declspec(dllexport)
#elif defined(_WIN32)
#define PSPLIT_API __declspec(dllimport)
#elif defined(__GNUC__)
#define PSPLIT_API __attribute__((visibility("default")))
#else
#define PSPLIT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---- Versions ----

// That of the library, as PSPLIT_VERSION, which is that of this header.
PSPLIT_API uint32_t psplit_version(void);

// 1 if the library can encode, otherwise 0: psplit_encode then returns PSPLIT_ERROR_UNSUPPORTED.
PSPLIT_API int32_t psplit_has_encoder(void);

// Makes a struct zero, and sets its size.
#define PSPLIT_INIT(object) \
  (memset(&(object), 0, sizeof(object)), (void)((object).struct_size = (uint32_t)sizeof(object)))

// ---- Errors ----

typedef int32_t psplit_code;
enum {
  PSPLIT_OK = 0,
  PSPLIT_ERROR_USAGE = 1,          // the arguments are wrong
  PSPLIT_ERROR_INVALID_INPUT = 3,  // the bytes, or what was said about them, are malformed
  PSPLIT_ERROR_FAILURE = 4,        // what should not fail failed
  PSPLIT_ERROR_UNSUPPORTED = 5,    // the input is valid, but uses what psplit does not support
  PSPLIT_ERROR_CANCELLED = 6,      // a psplit_stop was set
  PSPLIT_ERROR_NO_MEMORY = 8       // memory ran out; the same call may succeed later
};

// The name of a code: "invalid input". Never NULL.
PSPLIT_API const char* psplit_code_name(psplit_code code);

typedef struct psplit_error {
  uint32_t struct_size;
  psplit_code code;
  int64_t mesh, primitive, patch;  // the place; -1: it is not known, or does not apply
  char text[480];  // with the place, in UTF-8, cut to the size: "mesh 0, primitive 1, patch 7: ..."
} psplit_error;

// ---- Threads ----

// Threads that several calls use, one after the other or at once.
typedef struct psplit_pool psplit_pool;

// threads: with the calling thread, at most 4096; 0 means one for each processor.
PSPLIT_API psplit_code psplit_pool_create(int32_t threads, psplit_pool** pool, psplit_error* error);
PSPLIT_API int32_t psplit_pool_threads(const psplit_pool* pool);
// No call may use the pool any more.
PSPLIT_API void psplit_pool_free(psplit_pool* pool);

// A flag that ends decoding or encoding, which then returns PSPLIT_ERROR_CANCELLED. It is read before each
// patch, before and after the stream of PSPLIT_KIND_DRACO_FILE is decoded, and more often by encoding.
typedef struct psplit_stop psplit_stop;

PSPLIT_API psplit_code psplit_stop_create(psplit_stop** stop, psplit_error* error);
// From any thread, also while it is read. value: 0 or 1.
PSPLIT_API void psplit_stop_set(psplit_stop* stop, int32_t value);
// No call may use the flag any more.
PSPLIT_API void psplit_stop_free(psplit_stop* stop);

// Called with the number of finished steps and their total, from any thread, also from several at once. It must
// return normally: no exception, no longjmp.
typedef void (*psplit_progress)(void* user, size_t done, size_t total);

// How a call runs. NULL instead of it: on all threads, without the rest.
typedef struct psplit_run {
  uint32_t struct_size;
  int32_t threads;           // without a pool: as psplit_pool_create has it
  const psplit_pool* pool;   // NULL: threads of this call. Who calls often keeps a pool
  psplit_progress progress;  // in patches; a Draco stream is one; may be NULL
  void* user;                // passed to progress
  const psplit_stop* stop;   // may be NULL
} psplit_run;

// Frees the memory that threads keep from one call to the next: for each, about what its largest stream took.
PSPLIT_API void psplit_release_scratch(void);

// ---- Meshes to be decoded ----

// A compressed mesh, opened and checked.
typedef struct psplit_mesh psplit_mesh;

typedef int32_t psplit_kind;
enum {
  PSPLIT_KIND_NONE = 0,     // of a primitive of glTF that is not compressed
  PSPLIT_KIND_PATCHES = 1,  // a container of PSPLIT_mesh_draco_patches
  PSPLIT_KIND_DRACO = 2,    // a stream of KHR_draco_mesh_compression, whose attributes the caller knows
  // A whole Draco stream, mesh or point cloud: a .drc file. Opening finds its attributes, whose values have the
  // types of the stream. It decodes the faces for that, on the calling thread, and no values: these may turn
  // out to be malformed when they are decoded. So may all of a kD-tree.
  PSPLIT_KIND_DRACO_FILE = 3
};

// Types of a component, with Draco's numbers. glTF has the first four, PSPLIT_UINT32 and PSPLIT_FLOAT32.
typedef int32_t psplit_type;
enum {
  PSPLIT_INT8 = 1,
  PSPLIT_UINT8 = 2,
  PSPLIT_INT16 = 3,
  PSPLIT_UINT16 = 4,
  PSPLIT_INT32 = 5,
  PSPLIT_UINT32 = 6,
  PSPLIT_INT64 = 7,
  PSPLIT_UINT64 = 8,
  PSPLIT_FLOAT32 = 9,
  PSPLIT_FLOAT64 = 10,
  PSPLIT_BOOL = 11  // a byte
};

// What an attribute is, with Draco's numbers.
typedef int32_t psplit_semantic;
enum { PSPLIT_POSITION = 0, PSPLIT_NORMAL = 1, PSPLIT_COLOR = 2, PSPLIT_TEXCOORD = 3, PSPLIT_GENERIC = 4 };

// How a Draco stream stores a mesh or a point cloud.
typedef int32_t psplit_coding;
enum {
  PSPLIT_CODING_UNKNOWN = -1,  // of PSPLIT_KIND_PATCHES and PSPLIT_KIND_DRACO
  PSPLIT_CODING_SEQUENTIAL = 0,
  PSPLIT_CODING_EDGEBREAKER = 1,
  PSPLIT_CODING_EDGEBREAKER_VALENCE = 3,
  PSPLIT_CODING_CLOUD_SEQUENTIAL = 4,
  PSPLIT_CODING_CLOUD_KD_TREE = 5
};

// An attribute as glTF's JSON describes it.
typedef struct psplit_attribute_request {
  uint32_t struct_size;
  uint32_t unique_id;   // the extension's number for the attribute
  const char* name;     // glTF's, such as "POSITION", in UTF-8; of a morph target "targets/0/POSITION"
  psplit_type type;     // one of glTF's; the accessor's componentType
  uint32_t components;  // of a value, 1 to 16
  uint32_t normalized;  // 0 or 1
  uint32_t reserved;
} psplit_attribute_request;

// Flags of sources.
enum {
  PSPLIT_COPY = 1,  // copies the bytes, so that the caller may free them after the call
  // Of PSPLIT_KIND_DRACO_FILE: values are the integers of the stream, int32: places on the grid of a quantized
  // attribute, two coordinates on the octahedron of a normal. Attributes that are stored exactly have integers
  // too, if they are integers of at most 32 bits; the others keep their values.
  PSPLIT_INTEGERS = 2
};

typedef struct psplit_source {
  uint32_t struct_size;
  psplit_kind kind;
  const void* data;  // `size` bytes: those of the extension's buffer view, or a whole .drc file
  size_t size;
  // Those of the extension's attributes that are wanted, in any order. None for PSPLIT_KIND_DRACO_FILE.
  const psplit_attribute_request* attributes;
  uint32_t attribute_count;
  uint32_t flags;
  // The `count` of the accessors of attributes and of indices, which are compared with the bytes; 0: not known.
  // Without point_count, the faces of some streams of PSPLIT_KIND_DRACO are decoded to count their points.
  uint64_t point_count, index_count;
} psplit_source;

PSPLIT_API psplit_code psplit_mesh_open(const psplit_source* source, psplit_mesh** mesh, psplit_error* error);
PSPLIT_API void psplit_mesh_free(psplit_mesh* mesh);

// Sizes of the result. A point is a vertex of glTF: a tuple of attribute values.
typedef struct psplit_mesh_info {
  uint32_t struct_size;
  psplit_kind kind;
  psplit_coding coding;
  uint32_t point_count;
  uint32_t face_count;  // 0: a point cloud
  uint32_t attribute_count;
  uint32_t patch_count;       // with the residue; 1 for a Draco stream
  uint32_t has_residue;       // 1 if the last patch has the faces and points that no other stream can carry
  uint32_t least_index_size;  // bytes: 2 if all point numbers fit, otherwise 4
} psplit_mesh_info;
PSPLIT_API psplit_code psplit_mesh_get_info(const psplit_mesh* mesh, psplit_mesh_info* info,
                                            psplit_error* error);

typedef struct psplit_attribute_info {
  uint32_t struct_size;
  uint32_t unique_id;
  psplit_semantic semantic;  // the stream's; of other kinds, that of the name
  psplit_type type;          // of the values that are decoded
  uint32_t components;
  uint32_t normalized;
  uint32_t value_size;   // bytes of a value, tightly packed
  uint32_t is_integers;  // 1 if they are integers by PSPLIT_INTEGERS
  // glTF's name; of the deltas of a morph target like "targets/0/POSITION". Of PSPLIT_KIND_DRACO_FILE a name
  // that glTF would allow: POSITION, NORMAL, TEXCOORD_n, COLOR_n or _GENERIC_n, or "" for all attributes if
  // glTF cannot hold the stream.
  const char* name;
} psplit_attribute_info;
PSPLIT_API psplit_code psplit_mesh_get_attribute(const psplit_mesh* mesh, uint32_t attribute,
                                                 psplit_attribute_info* info, psplit_error* error);

// The attribute of that name, of that unique id, or the one after `skip` others of that semantic. -1 if there
// is none.
PSPLIT_API int32_t psplit_mesh_find_name(const psplit_mesh* mesh, const char* name);
PSPLIT_API int32_t psplit_mesh_find_id(const psplit_mesh* mesh, uint32_t unique_id);
PSPLIT_API int32_t psplit_mesh_find_semantic(const psplit_mesh* mesh, psplit_semantic semantic, uint32_t skip);

// How the values of an attribute are stored. bits is 0: exactly. Otherwise, without an origin, as coordinates
// on an octahedron of unit vectors. With one: value = origin + i * range / (2^bits - 1).
typedef struct psplit_quantization {
  uint32_t struct_size;
  int32_t bits;  // of a component
  float range;
  uint32_t origin_count;  // the number of components, or 0
  const float* origin;    // of each component; NULL if there is none
} psplit_quantization;
// The first call with a mesh of PSPLIT_KIND_PATCHES or PSPLIT_KIND_DRACO, or with a kD-tree, decodes one stream
// for that.
PSPLIT_API psplit_code psplit_mesh_get_quantization(const psplit_mesh* mesh, uint32_t attribute,
                                                    psplit_quantization* quantization, psplit_error* error);

// A part of a mesh that is decoded alone. Its faces, and the points that it owns, are consecutive in the whole.
typedef struct psplit_patch_info {
  uint32_t struct_size;
  uint32_t face_count;
  uint32_t point_count;  // as it decodes alone, with the points that other patches own
  uint32_t stream_size;  // bytes; 0 for PSPLIT_KIND_DRACO_FILE
  uint32_t first_face, first_owned_point, owned_point_count;
  uint32_t is_residue;
} psplit_patch_info;
PSPLIT_API psplit_code psplit_mesh_get_patch(const psplit_mesh* mesh, uint32_t patch, psplit_patch_info* info,
                                             psplit_error* error);

// ---- Decoding ----

// Where an attribute goes: a value for each point. The bytes between two values are not touched.
typedef struct psplit_attribute_buffer {
  uint32_t struct_size;
  uint32_t reserved;
  void* data;     // of any alignment. NULL: the attribute is not wanted
  size_t size;    // bytes, at least stride * (points - 1) + value_size
  size_t stride;  // bytes from one value to the next, at least value_size; 0: tightly packed
} psplit_attribute_buffer;

// The caller's memory for a mesh, or for a patch. No two parts of it overlap.
typedef struct psplit_buffers {
  uint32_t struct_size;
  uint32_t index_size;  // bytes: 4, or 2 for at most 65,535 points
  void* indices;        // three for each face, tightly packed, aligned to index_size
  size_t indices_size;  // bytes, at least 3 * faces * index_size
  const psplit_attribute_buffer* attributes;
  uint32_t attribute_count;  // those of the mesh, in their order; or 0: no attribute is wanted
  uint32_t reserved;
} psplit_buffers;

// Decodes the whole mesh. `run` may be NULL.
PSPLIT_API psplit_code psplit_mesh_decode(const psplit_mesh* mesh, const psplit_buffers* buffers,
                                          const psplit_run* run, psplit_error* error);

// Decodes one patch, which has the sizes of psplit_patch_info. Indices count from its first point. No other
// patch's stream is read.
PSPLIT_API psplit_code psplit_mesh_decode_patch(const psplit_mesh* mesh, uint32_t patch,
                                                const psplit_buffers* buffers, const psplit_run* run,
                                                psplit_error* error);

// One mesh of many.
typedef struct psplit_job {
  uint32_t struct_size;
  psplit_code code;  // a result
  const psplit_mesh* mesh;
  const psplit_buffers* buffers;
  psplit_error* error;  // gets the error of this mesh; may be NULL
} psplit_job;
// Decodes many meshes at once, so that all threads are busy. The error of one mesh does not affect another: it
// becomes the job's code. Returns the first code that is not PSPLIT_OK, and `error` gets that error.
PSPLIT_API psplit_code psplit_decode_meshes(psplit_job* jobs, size_t job_count, const psplit_run* run,
                                            psplit_error* error);

// ---- glTF ----

// The JSON of a glTF file, and its bytes.
typedef struct psplit_gltf psplit_gltf;

typedef struct psplit_gltf_source {
  uint32_t struct_size;
  uint32_t flags;    // PSPLIT_COPY or 0
  const void* data;  // a .glb file, or the JSON of a .gltf file
  size_t size;
} psplit_gltf_source;

// Reads the JSON, and checks its meshes, accessors, buffer views and buffers.
PSPLIT_API psplit_code psplit_gltf_open(const psplit_gltf_source* source, psplit_gltf** gltf,
                                        psplit_error* error);
PSPLIT_API void psplit_gltf_free(psplit_gltf* gltf);

// The buffers of the JSON, and the URI of one: NULL if it has none, as the buffer in a .glb file. The library
// opens no files: psplit_gltf_set_buffer gives it the bytes of a URI, which replace those of an earlier call.
// They are for the primitives that are opened afterwards, are never copied, and must stay as long as these.
PSPLIT_API uint32_t psplit_gltf_buffer_count(const psplit_gltf* gltf);
PSPLIT_API const char* psplit_gltf_buffer_uri(const psplit_gltf* gltf, uint32_t buffer);
PSPLIT_API psplit_code psplit_gltf_set_buffer(psplit_gltf* gltf, uint32_t buffer, const void* data, size_t size,
                                              psplit_error* error);

// A mesh has the primitives of its extension, if it has coarse ones for loaders without the extension.
PSPLIT_API uint32_t psplit_gltf_mesh_count(const psplit_gltf* gltf);
PSPLIT_API uint32_t psplit_gltf_primitive_count(const psplit_gltf* gltf, uint32_t mesh);
// PSPLIT_KIND_NONE also if there is no such primitive. If a primitive has both extensions, ours counts.
PSPLIT_API psplit_kind psplit_gltf_primitive_kind(const psplit_gltf* gltf, uint32_t mesh, uint32_t primitive);

// Opens a primitive with all attributes that its extension stores, under their names in glTF. Its errors name
// mesh and primitive. PSPLIT_ERROR_USAGE: there is no such primitive, it is not compressed, or its buffer's
// bytes are not set.
PSPLIT_API psplit_code psplit_gltf_open_primitive(const psplit_gltf* gltf, uint32_t mesh, uint32_t primitive,
                                                  psplit_mesh** result, psplit_error* error);

// ---- Encoding ----

// The values of an attribute, one for each point.
typedef struct psplit_attribute_values {
  uint32_t struct_size;
  psplit_type type;     // one of glTF's
  const char* name;     // glTF's, in UTF-8: "POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0", "_FEATURE_ID_0" ...
  const void* data;     // of any alignment
  size_t size;          // bytes, at least stride * (points - 1) and a value
  size_t stride;        // bytes from one value to the next; 0: tightly packed
  uint32_t components;  // of a value, 1 to 16
  uint32_t normalized;  // 0 or 1
  // Of a component of PSPLIT_FLOAT32, 1 to 30; 0: as psplit_encode_options has it; -1: the values are kept
  // exactly, as integers always are.
  int32_t bits;
  uint32_t reserved;
} psplit_attribute_values;

typedef struct psplit_encode_source {
  uint32_t struct_size;
  uint32_t point_count;
  const void* indices;  // three for each face, tightly packed, of any alignment; NULL with PSPLIT_ENCODE_POINTS
  size_t indices_size;  // bytes
  uint32_t index_size;  // bytes of an index: 1, 2 or 4
  uint32_t attribute_count;
  const psplit_attribute_values* attributes;  // POSITION is one of them
} psplit_encode_source;

// Flags of psplit_encode_options. PSPLIT_KIND_DRACO has the last two only.
enum {
  PSPLIT_ENCODE_KEEP_DUPLICATES = 1,     // points that are equal in everything stay apart
  PSPLIT_ENCODE_KEEP_DEGENERATE = 2,     // keeps faces that repeat an index; they draw nothing
  PSPLIT_ENCODE_KEEP_UNUSED = 4,         // keeps points that no face uses
  PSPLIT_ENCODE_CONDENSE = 8,            // patches share their tables, if that saves bytes
  PSPLIT_ENCODE_WITHOUT_VERIFYING = 16,  // does not decode the result to compare it with the source
  // The source has points and no indices. It becomes a Draco point cloud, of PSPLIT_KIND_DRACO_FILE, with all
  // of its points: a kD-tree, which has an order of its own, or at speed 10, or with floats that are exact, a
  // sequential cloud. Only with PSPLIT_KIND_NONE or PSPLIT_KIND_DRACO, and with
  // PSPLIT_ENCODE_WITHOUT_VERIFYING.
  PSPLIT_ENCODE_POINTS = 32
};

// psplit_encode_options_init sets the defaults.
typedef struct psplit_encode_options {
  uint32_t struct_size;
  // PSPLIT_KIND_NONE, the default: patches if the mesh is split, otherwise a Draco stream. PSPLIT_KIND_PATCHES:
  // a container of patches, if only of one. PSPLIT_KIND_DRACO: a stream as any encoder of Draco writes it.
  psplit_kind kind;
  int32_t speed;            // 0 (smallest) to 10 (fastest); default 5
  int32_t threads;          // see psplit_run
  const psplit_pool* pool;  // see psplit_run
  // Both 0, the default: 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, from 20,000 faces on.
  // With PSPLIT_KIND_NONE these are fewer where they would take more than 3 % beyond the bytes of one stream.
  uint32_t patch_count;
  uint32_t patch_faces;  // without patch_count: about as many faces in each patch
  // Of components of PSPLIT_FLOAT32, 1 to 30; -1: exactly. Normals take 2 bits or more. Feature ids
  // (_FEATURE_ID_n, _BATCHID), and values that no grid can hold, are kept exactly. So are whole numbers in
  // attributes to which glTF gives no meaning, unless generic_bits are not the default. The default bits grow,
  // or values are kept exactly, where a grid would make equal what the mesh tells apart; other bits are kept
  // to.
  int32_t position_bits, normal_bits, texcoord_bits, color_bits, generic_bits;  // default 14, 10, 12, 8, 12
  uint32_t flags;
  psplit_progress progress;  // in faces that are encoded; may be NULL
  void* user;                // passed to progress
  const psplit_stop* stop;   // may be NULL
} psplit_encode_options;
// Sets all members but struct_size, which must be set.
PSPLIT_API void psplit_encode_options_init(psplit_encode_options* options);

// Encoded bytes, and what a loader must know about them.
typedef struct psplit_encoded psplit_encoded;

// Encodes a triangle mesh, or points with PSPLIT_ENCODE_POINTS. `options` may be NULL: the defaults. The bytes
// are the same for any number of threads, and those of `gltf-psplit encode` and of psplit for other languages.
// Faces and points get another order. Faces that repeat an index and points that no face uses are dropped, and
// points that are equal in everything merged, unless the flags say otherwise; PSPLIT_KIND_DRACO merges none.
PSPLIT_API psplit_code psplit_encode(const psplit_encode_source* source, const psplit_encode_options* options,
                                     psplit_encoded** encoded, psplit_error* error);
PSPLIT_API void psplit_encoded_free(psplit_encoded* encoded);

typedef struct psplit_encoded_info {
  uint32_t struct_size;
  psplit_kind kind;  // a kind for psplit_mesh_open
  const void* data;
  size_t size;
  uint32_t point_count, face_count;  // as decoded
  uint32_t patch_count;              // with a residue
  uint32_t attribute_count;          // of the source, in its order
  // For each decoded point the point of the source that it was. Data beside the attributes, such as morph
  // targets, are reordered by it.
  const uint32_t* source_points;
  // The largest distance between a position and its decoded one; below 0 if it was not measured.
  double position_error;
  uint32_t note_count;  // see psplit_encoded_note
  uint32_t reserved;
} psplit_encoded_info;
PSPLIT_API psplit_code psplit_encoded_get_info(const psplit_encoded* encoded, psplit_encoded_info* info,
                                               psplit_error* error);
// A sentence in UTF-8 about the precision of the mesh: what the encoder did for it, or what it lost. NULL if
// there is no such note.
PSPLIT_API const char* psplit_encoded_note(const psplit_encoded* encoded, uint32_t note);
// How psplit_source, or glTF's JSON, requests an attribute.
PSPLIT_API psplit_code psplit_encoded_get_attribute(const psplit_encoded* encoded, uint32_t attribute,
                                                    psplit_attribute_request* request, psplit_error* error);
// How an attribute is stored, and why: "POSITION gets 14 bits, as the options say". In UTF-8; NULL if there is
// no such attribute.
PSPLIT_API psplit_code psplit_encoded_get_quantization(const psplit_encoded* encoded, uint32_t attribute,
                                                       psplit_quantization* quantization, psplit_error* error);
PSPLIT_API const char* psplit_encoded_reason(const psplit_encoded* encoded, uint32_t attribute);

// Bytes that the library made for the caller, and their number.
typedef struct psplit_output psplit_output;
PSPLIT_API const void* psplit_output_data(const psplit_output* output);
PSPLIT_API size_t psplit_output_size(const psplit_output* output);
PSPLIT_API void psplit_output_free(psplit_output* output);

// What glTF's JSON says about the mesh, for a file of the caller's, as a text in UTF-8 that ends with a zero
// byte: an object with `primitive`, for a mesh's list of primitives; `accessors`, which the caller appends to
// those of the file, where they get the numbers from first_accessor on; and `extensions`, the names for
// extensionsUsed and extensionsRequired. The bytes of the mesh are in the buffer view of the number
// buffer_view, which has no target and no stride. PSPLIT_ERROR_UNSUPPORTED: no type of glTF has so many
// components, or PSPLIT_KIND_DRACO has morph targets.
PSPLIT_API psplit_code psplit_encoded_write_json(const psplit_encoded* encoded, uint32_t first_accessor,
                                                 uint32_t buffer_view, psplit_output** output,
                                                 psplit_error* error);
// A whole .glb file with that mesh in a scene, without a material. PSPLIT_ERROR_UNSUPPORTED also if it would
// exceed 4 GB. Neither for a point cloud: glTF has no compressed ones.
PSPLIT_API psplit_code psplit_encoded_write_glb(const psplit_encoded* encoded, psplit_output** output,
                                                psplit_error* error);

#ifdef __cplusplus
}
#endif

#endif
