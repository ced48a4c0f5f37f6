// psplit's interface for C, and for all languages that can call C. It decodes meshes of
// PSPLIT_mesh_draco_patches, of KHR_draco_mesh_compression and of .drc files into the caller's memory, and
// encodes meshes. Link psplit::c of CMake's find_package(psplit), or `psplit` of pkg-config. bindings/ has
// packages for Rust and C#, and docs/c.md shows how to call the library from Go. For C++ there is psplit.hpp.
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
//            all other members zero. So programs and libraries of different versions work together. Set the
//            size of result structs, too. A struct that is larger than the library's own must be zero in the
//            members that the library does not know. All elements of an array have the size of the first.
//            `reserved` members are 0.
// Handles    Each kind of handle has a `psplit_..._free`, which accepts NULL. Handles may be freed in any
//            order: each keeps alive what it needs of others. Functions that return a number treat NULL as an
//            empty object.
// Errors     A function that can fail returns a psplit_code. If `error`, which may be NULL, is given, it gets
//            the code and a sentence with its place; after success, PSPLIT_OK and no text. Null pointers, sizes
//            that are too small, and buffers that do not fit are PSPLIT_ERROR_USAGE. After an error, handles to
//            be returned are NULL, other results are not set, and the contents of buffers are unspecified.
//            Nothing is written outside of buffers.
// Bytes      Decoding is safe for untrusted bytes. It takes at most 64 MiB of memory plus 4096 bytes for each
//            byte of the input.
// Bitstreams Draco meshes are of bitstream 2.2, point clouds of 2.2 or 2.3. Meshes of older bitstreams are
//            decoded by libdraco, without that limit of memory, if the library was built with its encoder and
//            libdraco; otherwise they are PSPLIT_ERROR_UNSUPPORTED. Opening such a mesh decodes it, to count
//            points. Its values always have types of glTF, even in a .drc file, and PSPLIT_INTEGERS has no
//            effect.
// Lifetime   The library reads the caller's bytes until the last handle that was made of them is freed, unless
//            PSPLIT_COPY is set. All other memory of the caller is used only during the call. Pointers in
//            results belong to the handle that was queried, and live as long as it.
// Threads    All functions are thread-safe, even with the same handle. Exceptions: while a handle is freed, or
//            psplit_gltf_set_buffer runs on it, no other call may use it.
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

// The version of the library, in the form of PSPLIT_VERSION, which is the version of this header.
PSPLIT_API uint32_t psplit_version(void);

// 1 if the library can encode, otherwise 0: psplit_encode then returns PSPLIT_ERROR_UNSUPPORTED.
PSPLIT_API int32_t psplit_has_encoder(void);

// Sets a struct to zero, and its size.
#define PSPLIT_INIT(object) \
  (memset(&(object), 0, sizeof(object)), (void)((object).struct_size = (uint32_t)sizeof(object)))

// ---- Errors ----

typedef int32_t psplit_code;
enum {
  PSPLIT_OK = 0,
  PSPLIT_ERROR_USAGE = 1,          // the arguments are wrong
  PSPLIT_ERROR_INVALID_INPUT = 3,  // the bytes are malformed, or contradict their description
  PSPLIT_ERROR_FAILURE = 4,        // an internal error
  PSPLIT_ERROR_UNSUPPORTED = 5,    // the input is valid, but uses a feature that psplit does not support
  PSPLIT_ERROR_CANCELLED = 6,      // a psplit_stop was set
  PSPLIT_ERROR_NO_MEMORY = 8       // memory ran out; the same call may succeed later
};

// The name of a code: "invalid input". Never NULL.
PSPLIT_API const char* psplit_code_name(psplit_code code);

typedef struct psplit_error {
  uint32_t struct_size;
  psplit_code code;
  int64_t mesh, primitive, patch;  // the place; -1: unknown, or does not apply
  char text[480];  // with the place, in UTF-8, truncated to fit: "mesh 0, primitive 1, patch 7: ..."
} psplit_error;

// ---- Threads ----

// Threads that several calls share, one after the other or at once.
typedef struct psplit_pool psplit_pool;

// threads: including the calling thread, at most 4096; 0 means one for each processor.
PSPLIT_API psplit_code psplit_pool_create(int32_t threads, psplit_pool** pool, psplit_error* error);
PSPLIT_API int32_t psplit_pool_threads(const psplit_pool* pool);
// No call may still use the pool.
PSPLIT_API void psplit_pool_free(psplit_pool* pool);

// A flag that stops decoding or encoding, which then returns PSPLIT_ERROR_CANCELLED. Decoding reads it before
// each patch, and before and after a stream of PSPLIT_KIND_DRACO_FILE; encoding reads it more often.
typedef struct psplit_stop psplit_stop;

PSPLIT_API psplit_code psplit_stop_create(psplit_stop** stop, psplit_error* error);
// May be called from any thread at any time. value: 0 or 1.
PSPLIT_API void psplit_stop_set(psplit_stop* stop, int32_t value);
// No call may still use the flag.
PSPLIT_API void psplit_stop_free(psplit_stop* stop);

// Called with the number of finished steps and their total, from any thread, also from several at once. It must
// return normally: without an exception or longjmp.
typedef void (*psplit_progress)(void* user, size_t done, size_t total);

// How a call runs. NULL in its place: with a thread for each processor, without progress and stop.
typedef struct psplit_run {
  uint32_t struct_size;
  int32_t threads;           // without a pool: as for psplit_pool_create
  const psplit_pool* pool;   // NULL: threads of this call; reuse a pool for frequent calls
  psplit_progress progress;  // counts patches; a Draco stream is one; may be NULL
  void* user;                // passed to progress
  const psplit_stop* stop;   // may be NULL
} psplit_run;

// Frees the memory that threads keep between calls: for each, about as much as its largest stream took.
PSPLIT_API void psplit_release_scratch(void);

// ---- Meshes to be decoded ----

// A compressed mesh whose bytes are opened and checked.
typedef struct psplit_mesh psplit_mesh;

typedef int32_t psplit_kind;
enum {
  PSPLIT_KIND_NONE = 0,     // a primitive of glTF that is not compressed
  PSPLIT_KIND_PATCHES = 1,  // a container of PSPLIT_mesh_draco_patches
  PSPLIT_KIND_DRACO = 2,    // a stream of KHR_draco_mesh_compression; the caller states its attributes
  // A whole Draco stream, mesh or point cloud: a .drc file. Opening finds its attributes, whose values have the
  // types of the stream. For that it decodes the faces, on the calling thread, but no values, which may turn
  // out to be malformed when they are decoded. So may every part of a kD-tree.
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

// The meaning of an attribute, with Draco's numbers.
typedef int32_t psplit_semantic;
enum { PSPLIT_POSITION = 0, PSPLIT_NORMAL = 1, PSPLIT_COLOR = 2, PSPLIT_TEXCOORD = 3, PSPLIT_GENERIC = 4 };

// How a Draco stream stores a mesh or a point cloud.
typedef int32_t psplit_coding;
enum {
  PSPLIT_CODING_UNKNOWN = -1,  // for PSPLIT_KIND_PATCHES and PSPLIT_KIND_DRACO
  PSPLIT_CODING_SEQUENTIAL = 0,
  PSPLIT_CODING_EDGEBREAKER = 1,
  PSPLIT_CODING_EDGEBREAKER_VALENCE = 3,
  PSPLIT_CODING_CLOUD_SEQUENTIAL = 4,
  PSPLIT_CODING_CLOUD_KD_TREE = 5
};

// A request for an attribute, as glTF's JSON describes it.
typedef struct psplit_attribute_request {
  uint32_t struct_size;
  uint32_t unique_id;   // the attribute's id in the extension
  const char* name;     // glTF's, such as "POSITION", in UTF-8; for a morph target "targets/0/POSITION"
  psplit_type type;     // the accessor's componentType, one of glTF's types
  uint32_t components;  // of a value, 1 to 16
  uint32_t normalized;  // 0 or 1
  uint32_t reserved;
} psplit_attribute_request;

// Flags of sources.
enum {
  PSPLIT_COPY = 1,  // copies the bytes, so that the caller may free them after the call
  // For PSPLIT_KIND_DRACO_FILE: values are decoded to the integers of the stream, int32: places on the grid of
  // a quantized attribute, two coordinates on the octahedron of a normal. Exact integers of at most 32 bits
  // become int32 as well; all other attributes keep their values.
  PSPLIT_INTEGERS = 2
};

typedef struct psplit_source {
  uint32_t struct_size;
  psplit_kind kind;
  const void* data;  // `size` bytes: the extension's buffer view, or a whole .drc file
  size_t size;
  // The wanted ones of the extension's attributes, in any order. None for PSPLIT_KIND_DRACO_FILE.
  const psplit_attribute_request* attributes;
  uint32_t attribute_count;
  uint32_t flags;
  // The `count` of the accessors of attributes and of indices, which are compared with the bytes; 0: unknown.
  // Without point_count, opening decodes the faces of some streams of PSPLIT_KIND_DRACO to count their points.
  uint64_t point_count, index_count;
} psplit_source;

PSPLIT_API psplit_code psplit_mesh_open(const psplit_source* source, psplit_mesh** mesh, psplit_error* error);
PSPLIT_API void psplit_mesh_free(psplit_mesh* mesh);

// Sizes of the decoded mesh. A point is a vertex of glTF: a tuple of attribute values.
typedef struct psplit_mesh_info {
  uint32_t struct_size;
  psplit_kind kind;
  psplit_coding coding;
  uint32_t point_count;
  uint32_t face_count;  // 0: a point cloud
  uint32_t attribute_count;
  uint32_t patch_count;       // including the residue; 1 for a Draco stream
  uint32_t has_residue;       // 1 if the last patch has the faces and points that no other stream can carry
  uint32_t least_index_size;  // bytes: 2 if all point numbers fit, otherwise 4
} psplit_mesh_info;
PSPLIT_API psplit_code psplit_mesh_get_info(const psplit_mesh* mesh, psplit_mesh_info* info,
                                            psplit_error* error);

typedef struct psplit_attribute_info {
  uint32_t struct_size;
  uint32_t unique_id;
  psplit_semantic semantic;  // stated by the stream; for the other kinds it follows from the name
  psplit_type type;          // of the decoded values
  uint32_t components;
  uint32_t normalized;
  uint32_t value_size;   // bytes of a value, tightly packed
  uint32_t is_integers;  // 1 if PSPLIT_INTEGERS made them integers
  // glTF's name; for the deltas of a morph target for example "targets/0/POSITION". For PSPLIT_KIND_DRACO_FILE
  // a name that glTF would allow: POSITION, NORMAL, TEXCOORD_n, COLOR_n or _GENERIC_n, or "" for all attributes
  // if glTF cannot hold the stream.
  const char* name;
} psplit_attribute_info;
PSPLIT_API psplit_code psplit_mesh_get_attribute(const psplit_mesh* mesh, uint32_t attribute,
                                                 psplit_attribute_info* info, psplit_error* error);

// Returns the number of the attribute with this name, with this unique id, or with this semantic after `skip`
// others with it; -1 if it does not exist.
PSPLIT_API int32_t psplit_mesh_find_name(const psplit_mesh* mesh, const char* name);
PSPLIT_API int32_t psplit_mesh_find_id(const psplit_mesh* mesh, uint32_t unique_id);
PSPLIT_API int32_t psplit_mesh_find_semantic(const psplit_mesh* mesh, psplit_semantic semantic, uint32_t skip);

// How the values of an attribute are stored. With 0 bits, they are exact. With bits but without an origin, they
// are unit vectors on an octahedral grid. With an origin, value i is origin + i * range / (2^bits - 1).
typedef struct psplit_quantization {
  uint32_t struct_size;
  int32_t bits;  // of a component
  float range;
  uint32_t origin_count;  // the number of components, or 0
  const float* origin;    // of each component; NULL without an origin
} psplit_quantization;
// The first call for a mesh of PSPLIT_KIND_PATCHES or PSPLIT_KIND_DRACO, or for a kD-tree, decodes one stream.
PSPLIT_API psplit_code psplit_mesh_get_quantization(const psplit_mesh* mesh, uint32_t attribute,
                                                    psplit_quantization* quantization, psplit_error* error);

// A part of a mesh that can be decoded alone. Its faces, and the points that it owns, are consecutive in the
// whole mesh.
typedef struct psplit_patch_info {
  uint32_t struct_size;
  uint32_t face_count;
  uint32_t point_count;  // decoded alone, including the points that other patches own
  uint32_t stream_size;  // bytes; 0 for PSPLIT_KIND_DRACO_FILE
  uint32_t first_face, first_owned_point, owned_point_count;
  uint32_t is_residue;
} psplit_patch_info;
PSPLIT_API psplit_code psplit_mesh_get_patch(const psplit_mesh* mesh, uint32_t patch, psplit_patch_info* info,
                                             psplit_error* error);

// ---- Decoding ----

// The destination of an attribute: a value for each point. The bytes between two values are not touched.
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
  uint32_t attribute_count;  // all of the mesh, in order; or 0: no attribute is wanted
  uint32_t reserved;
} psplit_buffers;

// Decodes the whole mesh. `run` may be NULL.
PSPLIT_API psplit_code psplit_mesh_decode(const psplit_mesh* mesh, const psplit_buffers* buffers,
                                          const psplit_run* run, psplit_error* error);

// Decodes one patch; psplit_patch_info has its sizes. Indices count from its first point. The streams of other
// patches are not read.
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
// Decodes many meshes at once, to keep all threads busy. An error of one mesh becomes its job's code, and does
// not affect others. Returns the first code that is not PSPLIT_OK, with that error in `error`.
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

// The number of buffers in the JSON, and the URI of one: NULL if it has none, like the buffer of a .glb file.
// The library opens no files: psplit_gltf_set_buffer gives it the bytes of a URI, in place of the bytes of an
// earlier call. They apply to primitives that are opened afterwards, are never copied, and must outlive these.
PSPLIT_API uint32_t psplit_gltf_buffer_count(const psplit_gltf* gltf);
PSPLIT_API const char* psplit_gltf_buffer_uri(const psplit_gltf* gltf, uint32_t buffer);
PSPLIT_API psplit_code psplit_gltf_set_buffer(psplit_gltf* gltf, uint32_t buffer, const void* data, size_t size,
                                              psplit_error* error);

// If a mesh has coarse primitives, for loaders without the extension, these functions see the full ones in
// their place.
PSPLIT_API uint32_t psplit_gltf_mesh_count(const psplit_gltf* gltf);
PSPLIT_API uint32_t psplit_gltf_primitive_count(const psplit_gltf* gltf, uint32_t mesh);
// PSPLIT_KIND_NONE also if the primitive does not exist. If a primitive has both extensions,
// PSPLIT_KIND_PATCHES.
PSPLIT_API psplit_kind psplit_gltf_primitive_kind(const psplit_gltf* gltf, uint32_t mesh, uint32_t primitive);

// Opens a primitive with all attributes that its extension stores, under their names in glTF. Its errors name
// mesh and primitive. PSPLIT_ERROR_USAGE: the primitive does not exist, it is not compressed, or its buffer's
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
  size_t size;          // bytes, at least stride * (points - 1) plus one value
  size_t stride;        // bytes from one value to the next; 0: tightly packed
  uint32_t components;  // of a value, 1 to 16
  uint32_t normalized;  // 0 or 1
  // Bits of a PSPLIT_FLOAT32 component, 1 to 30; 0: as in psplit_encode_options; -1: values are kept exactly.
  // Integers always are.
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

// Flags of psplit_encode_options. PSPLIT_KIND_DRACO allows only the last two.
enum {
  PSPLIT_ENCODE_KEEP_DUPLICATES = 1,     // does not merge points that are equal in all attributes
  PSPLIT_ENCODE_KEEP_DEGENERATE = 2,     // keeps faces that repeat an index, though they draw nothing
  PSPLIT_ENCODE_KEEP_UNUSED = 4,         // keeps points that no face uses
  PSPLIT_ENCODE_CONDENSE = 8,            // patches share their tables, if that saves bytes
  PSPLIT_ENCODE_WITHOUT_VERIFYING = 16,  // does not decode the result to compare it with the source
  // The source has points and no indices. It becomes a Draco point cloud, of PSPLIT_KIND_DRACO_FILE, with all
  // of its points: a kD-tree, which reorders points, or a sequential cloud at speed 10 or if floats are kept
  // exactly. Requires PSPLIT_KIND_NONE or PSPLIT_KIND_DRACO; the only other flag allowed is
  // PSPLIT_ENCODE_WITHOUT_VERIFYING.
  PSPLIT_ENCODE_POINTS = 32
};

// psplit_encode_options_init sets the defaults.
typedef struct psplit_encode_options {
  uint32_t struct_size;
  // PSPLIT_KIND_NONE, the default: patches if the mesh is split, otherwise a Draco stream. PSPLIT_KIND_PATCHES:
  // a container, of one patch if the mesh is not split. PSPLIT_KIND_DRACO: an ordinary Draco stream.
  psplit_kind kind;
  int32_t speed;            // 0 (smallest) to 10 (fastest); default 5
  int32_t threads;          // see psplit_run
  const psplit_pool* pool;  // see psplit_run
  // Both 0, the default: 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, from 20,000 faces on.
  // PSPLIT_KIND_NONE makes fewer patches where they would take over 3 % more bytes than one stream.
  uint32_t patch_count;
  uint32_t patch_faces;  // without patch_count: the number of faces of each patch, roughly
  // Bits of PSPLIT_FLOAT32 components, 1 to 30; -1: exactly. Normals take 2 bits or more. Feature ids
  // (_FEATURE_ID_n, _BATCHID), and values that no grid can hold, are kept exactly. So are whole numbers in
  // attributes without a meaning in glTF, if generic_bits has the default value. Where distinct values of the
  // mesh would become equal, default bits are increased, or the values kept exactly; other bits stay as given.
  int32_t position_bits, normal_bits, texcoord_bits, color_bits, generic_bits;  // default 14, 10, 12, 8, 12
  uint32_t flags;
  psplit_progress progress;  // counts encoded faces; may be NULL
  void* user;                // passed to progress
  const psplit_stop* stop;   // may be NULL
} psplit_encode_options;
// Sets all members except struct_size, which the caller must have set.
PSPLIT_API void psplit_encode_options_init(psplit_encode_options* options);

// An encoded mesh: its bytes, and the description that a loader needs.
typedef struct psplit_encoded psplit_encoded;

// Encodes a triangle mesh, or points with PSPLIT_ENCODE_POINTS. `options` may be NULL: the defaults. The bytes
// do not depend on the number of threads, and equal those of `gltf-psplit encode` and of psplit's other
// interfaces. Faces and points are reordered. Unless the flags say otherwise, faces that repeat an index and
// points that no face uses are dropped, and points that are equal in all attributes are merged, though not by
// PSPLIT_KIND_DRACO.
PSPLIT_API psplit_code psplit_encode(const psplit_encode_source* source, const psplit_encode_options* options,
                                     psplit_encoded** encoded, psplit_error* error);
PSPLIT_API void psplit_encoded_free(psplit_encoded* encoded);

typedef struct psplit_encoded_info {
  uint32_t struct_size;
  psplit_kind kind;  // to be used as psplit_source::kind
  const void* data;
  size_t size;
  uint32_t point_count, face_count;  // as decoded
  uint32_t patch_count;              // including the residue
  uint32_t attribute_count;          // of the source, in its order
  // For each decoded point, its point in the source. Use it to reorder further data per point, such as morph
  // targets.
  const uint32_t* source_points;
  // The largest distance between a position and its decoded position; negative if it was not measured.
  double position_error;
  uint32_t note_count;  // see psplit_encoded_note
  uint32_t reserved;
} psplit_encoded_info;
PSPLIT_API psplit_code psplit_encoded_get_info(const psplit_encoded* encoded, psplit_encoded_info* info,
                                               psplit_error* error);
// A sentence in UTF-8 about how the encoder kept the mesh's precision, or about lost precision. NULL if `note`
// is out of range.
PSPLIT_API const char* psplit_encoded_note(const psplit_encoded* encoded, uint32_t note);
// The request for an attribute, for psplit_source or glTF's JSON.
PSPLIT_API psplit_code psplit_encoded_get_attribute(const psplit_encoded* encoded, uint32_t attribute,
                                                    psplit_attribute_request* request, psplit_error* error);
// How an attribute is stored, and why: "POSITION gets 14 bits, as the options say". The reason is in UTF-8;
// NULL if the attribute does not exist.
PSPLIT_API psplit_code psplit_encoded_get_quantization(const psplit_encoded* encoded, uint32_t attribute,
                                                       psplit_quantization* quantization, psplit_error* error);
PSPLIT_API const char* psplit_encoded_reason(const psplit_encoded* encoded, uint32_t attribute);

// Bytes that the library allocated for the caller, and their number.
typedef struct psplit_output psplit_output;
PSPLIT_API const void* psplit_output_data(const psplit_output* output);
PSPLIT_API size_t psplit_output_size(const psplit_output* output);
PSPLIT_API void psplit_output_free(psplit_output* output);

// Writes the glTF JSON of the mesh, for a file that the caller writes, as zero-terminated UTF-8: an object with
// `primitive`, for a mesh's list of primitives; `accessors`, which the caller appends to the file's accessors,
// the first at index first_accessor; and `extensions`, the names for extensionsUsed and extensionsRequired. The
// caller stores the mesh's bytes in the buffer view with index buffer_view, without target and stride.
// PSPLIT_ERROR_UNSUPPORTED: an attribute has a number of components that no glTF type has, or PSPLIT_KIND_DRACO
// has morph targets.
PSPLIT_API psplit_code psplit_encoded_write_json(const psplit_encoded* encoded, uint32_t first_accessor,
                                                 uint32_t buffer_view, psplit_output** output,
                                                 psplit_error* error);
// Writes a whole .glb file with the mesh in a scene, without a material. PSPLIT_ERROR_UNSUPPORTED also if it
// would exceed 4 GB. Both functions refuse point clouds, for which glTF has no compression.
PSPLIT_API psplit_code psplit_encoded_write_glb(const psplit_encoded* encoded, psplit_output** output,
                                                psplit_error* error);

#ifdef __cplusplus
}
#endif

#endif
