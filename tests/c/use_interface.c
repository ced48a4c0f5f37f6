/* use_interface FILE.glb: every function of the interface, as a program in C calls it. FILE has one mesh of
   patches with positions and texture coordinates. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "psplit/psplit.h"

#define CHECK(condition)                                      \
  do {                                                        \
    if (!(condition)) {                                       \
      fprintf(stderr, "line %d: %s\n", __LINE__, #condition); \
      exit(1);                                                \
    }                                                         \
  } while (0)
#define OK(call) CHECK((call) == PSPLIT_OK)

static unsigned char* read_file(const char* path, size_t* size) {
  unsigned char* bytes;
  FILE* file = fopen(path, "rb");
  CHECK(file != NULL);
  CHECK(fseek(file, 0, SEEK_END) == 0);
  *size = (size_t)ftell(file);
  CHECK(fseek(file, 0, SEEK_SET) == 0);
  bytes = malloc(*size);
  CHECK(bytes != NULL && fread(bytes, 1, *size, file) == *size);
  fclose(file);
  return bytes;
}

static void count_progress(void* user, size_t done, size_t total) {
  CHECK(done >= 1 && done <= total);
  *(size_t*)user = total;
}

/* Interleaved vertices, as an engine has them. */
typedef struct {
  float position[3];
  unsigned char untouched[4];
  float texcoord[2];
} vertex;

/* Decodes to interleaved vertices and 16-bit indices, and checks that all indices name points. */
static vertex* decode(const psplit_mesh* mesh, uint32_t* point_count, uint16_t** indices, uint32_t* face_count,
                      psplit_error* error) {
  psplit_mesh_info info;
  psplit_buffers buffers;
  psplit_attribute_buffer* attributes;
  vertex* vertices;
  psplit_run run;
  psplit_pool* pool = NULL;
  psplit_stop* stop = NULL;
  size_t total = 0;
  uint32_t i;
  const int32_t position = psplit_mesh_find_semantic(mesh, PSPLIT_POSITION, 0);
  const int32_t texcoord = psplit_mesh_find_name(mesh, "TEXCOORD_0");
  CHECK(position >= 0 && texcoord >= 0 && psplit_mesh_find_semantic(mesh, PSPLIT_POSITION, 1) == -1);
  PSPLIT_INIT(info);
  OK(psplit_mesh_get_info(mesh, &info, error));
  CHECK(info.least_index_size == 2);
  vertices = malloc(info.point_count * sizeof(vertex));
  *indices = malloc((size_t)3 * info.face_count * sizeof(uint16_t));
  attributes = calloc(info.attribute_count, sizeof(psplit_attribute_buffer));
  CHECK(vertices != NULL && *indices != NULL && attributes != NULL);
  memset(vertices, 0xa5, info.point_count * sizeof(vertex));
  for (i = 0; i < info.attribute_count; ++i) PSPLIT_INIT(attributes[i]);
  attributes[position].data = vertices[0].position;
  attributes[position].size = info.point_count * sizeof(vertex);
  attributes[position].stride = sizeof(vertex);
  attributes[texcoord].data = vertices[0].texcoord;
  attributes[texcoord].size = info.point_count * sizeof(vertex) - offsetof(vertex, texcoord);
  attributes[texcoord].stride = sizeof(vertex);
  PSPLIT_INIT(buffers);
  buffers.index_size = 2;
  buffers.indices = *indices;
  buffers.indices_size = (size_t)3 * info.face_count * sizeof(uint16_t);
  buffers.attributes = attributes;
  buffers.attribute_count = info.attribute_count;
  OK(psplit_pool_create(2, &pool, error));
  CHECK(psplit_pool_threads(pool) == 2);
  OK(psplit_stop_create(&stop, error));
  PSPLIT_INIT(run);
  run.pool = pool;
  run.stop = stop;
  run.progress = count_progress;
  run.user = &total;
  psplit_stop_set(stop, 1);
  CHECK(psplit_mesh_decode(mesh, &buffers, &run, error) == PSPLIT_ERROR_CANCELLED);
  psplit_stop_set(stop, 0);
  OK(psplit_mesh_decode(mesh, &buffers, &run, error));
  CHECK(total == info.patch_count);
  psplit_stop_free(stop);
  psplit_pool_free(pool);
  for (i = 0; i < 3 * info.face_count; ++i) CHECK((*indices)[i] < info.point_count);
  for (i = 0; i < info.point_count; ++i)
    CHECK(vertices[i].untouched[0] == 0xa5 && vertices[i].untouched[3] == 0xa5);
  free(attributes);
  *point_count = info.point_count;
  *face_count = info.face_count;
  return vertices;
}

/* Encodes the vertices, opens the result, and compares each point with the one that it was. */
static void encode(const vertex* vertices, uint32_t point_count, const uint16_t* indices, uint32_t face_count,
                   psplit_kind kind, psplit_error* error) {
  psplit_attribute_values values[2];
  psplit_encode_source source;
  psplit_encode_options options;
  psplit_encoded* encoded = NULL;
  psplit_encoded_info info;
  psplit_attribute_request requests[2];
  psplit_source stored;
  psplit_mesh* mesh = NULL;
  psplit_quantization quantization;
  psplit_output* output = NULL;
  vertex* decoded;
  uint16_t* decoded_indices;
  uint32_t decoded_points, decoded_faces, i;
  int c;
  PSPLIT_INIT(values[0]);
  values[0].name = "POSITION";
  values[0].type = PSPLIT_FLOAT32;
  values[0].components = 3;
  values[0].data = vertices[0].position;
  values[0].size = point_count * sizeof(vertex);
  values[0].stride = sizeof(vertex);
  values[1] = values[0];
  values[1].name = "TEXCOORD_0";
  values[1].components = 2;
  values[1].data = vertices[0].texcoord;
  values[1].size -= offsetof(vertex, texcoord);
  values[1].bits = -1;
  PSPLIT_INIT(source);
  source.point_count = point_count;
  source.indices = indices;
  source.indices_size = (size_t)3 * face_count * sizeof(uint16_t);
  source.index_size = sizeof(uint16_t);
  source.attributes = values;
  source.attribute_count = 2;
  PSPLIT_INIT(options);
  psplit_encode_options_init(&options);
  CHECK(options.speed == 5 && options.position_bits == 14);
  options.kind = kind;
  options.patch_faces = 100;
  options.position_bits = 16;
  if (!psplit_has_encoder()) {
    CHECK(psplit_encode(&source, &options, &encoded, error) == PSPLIT_ERROR_UNSUPPORTED && encoded == NULL);
    return;
  }
  OK(psplit_encode(&source, &options, &encoded, error));
  PSPLIT_INIT(info);
  OK(psplit_encoded_get_info(encoded, &info, error));
  CHECK(info.kind == kind && info.attribute_count == 2);
  CHECK(kind == PSPLIT_KIND_PATCHES ? info.patch_count > 3 : info.patch_count == 1);
  for (i = 0; i < 2; ++i) {
    PSPLIT_INIT(requests[i]);
    OK(psplit_encoded_get_attribute(encoded, i, &requests[i], error));
  }
  PSPLIT_INIT(stored);
  stored.kind = info.kind;
  stored.data = info.data;
  stored.size = info.size;
  stored.attributes = requests;
  stored.attribute_count = 2;
  stored.point_count = info.point_count;
  stored.flags = PSPLIT_COPY;
  OK(psplit_mesh_open(&stored, &mesh, error));
  PSPLIT_INIT(quantization);
  OK(psplit_mesh_get_quantization(mesh, 0, &quantization, error));
  CHECK(quantization.bits == 16 && quantization.origin_count == 3 && quantization.range > 0);
  decoded = decode(mesh, &decoded_points, &decoded_indices, &decoded_faces, error);
  CHECK(decoded_points == info.point_count && decoded_faces == info.face_count && decoded_faces == face_count);
  for (i = 0; i < decoded_points; ++i) {
    const vertex* const before = &vertices[info.source_points[i]];
    for (c = 0; c < 3; ++c)
      CHECK(fabsf(decoded[i].position[c] - before->position[c]) <= quantization.range / 65535);
    CHECK(memcmp(decoded[i].texcoord, before->texcoord, sizeof(before->texcoord)) == 0);
  }
  OK(psplit_encoded_get_quantization(encoded, 0, &quantization, error));
  CHECK(quantization.bits == 16 &&
        strcmp(psplit_encoded_reason(encoded, 0), "POSITION gets 16 bits, as the options say") == 0);
  OK(psplit_encoded_write_json(encoded, 0, 0, &output, error));
  CHECK(psplit_output_size(output) == strlen((const char*)psplit_output_data(output)) + 1);
  psplit_output_free(output);
  OK(psplit_encoded_write_glb(encoded, &output, error));
  CHECK(psplit_output_size(output) > info.size && memcmp(psplit_output_data(output), "glTF", 4) == 0);
  psplit_output_free(output);
  psplit_encoded_free(encoded);
  psplit_mesh_free(mesh);
  free(decoded);
  free(decoded_indices);
}

/* A triangle in bitstream 2.1, which libdraco decodes where it is built in: a sequential mesh with floats as
   they are. */
static void decode_older(psplit_error* error) {
  static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0.5f};
  static const unsigned char front[] = {'D', 'R', 'A', 'C', 'O', 2, 1, 1, 0, 0, 0, 1, 0, 0, 0, 3,
                                        0,   0,   0,   1,   0,   1, 2, 1, 1, 0, 9, 3, 0, 0, 0};
  unsigned char stream[sizeof(front) + sizeof(positions)];
  float decoded[9];
  uint32_t indices[3];
  psplit_source source;
  psplit_mesh* mesh = NULL;
  psplit_attribute_buffer attribute;
  psplit_buffers buffers;
  memcpy(stream, front, sizeof(front));
  memcpy(stream + sizeof(front), positions, sizeof(positions));
  PSPLIT_INIT(source);
  source.kind = PSPLIT_KIND_DRACO_FILE;
  source.data = stream;
  source.size = sizeof(stream);
  if (psplit_mesh_open(&source, &mesh, error) != PSPLIT_OK) {
    CHECK(error->code == PSPLIT_ERROR_UNSUPPORTED && strstr(error->text, "older than 2.2") != NULL);
    CHECK(strstr(error->text, "a build with the encoder and libdraco decodes older ones") != NULL);
    return;
  }
  CHECK(psplit_has_encoder());
  PSPLIT_INIT(attribute);
  attribute.data = decoded;
  attribute.size = sizeof(decoded);
  PSPLIT_INIT(buffers);
  buffers.index_size = 4;
  buffers.indices = indices;
  buffers.indices_size = sizeof(indices);
  buffers.attributes = &attribute;
  buffers.attribute_count = 1;
  OK(psplit_mesh_decode(mesh, &buffers, NULL, error));
  CHECK(indices[0] == 0 && indices[1] == 1 && indices[2] == 2);
  CHECK(memcmp(decoded, positions, sizeof(positions)) == 0);
  psplit_mesh_free(mesh);
}

int main(int argc, char** argv) {
  psplit_error error;
  psplit_gltf_source source;
  psplit_gltf* gltf = NULL;
  psplit_mesh* mesh = NULL;
  psplit_patch_info patch;
  vertex* vertices;
  uint16_t* indices;
  uint32_t point_count, face_count;
  size_t size;
  unsigned char* bytes;
  CHECK(argc == 2 && psplit_version() == PSPLIT_VERSION);
  bytes = read_file(argv[1], &size);
  PSPLIT_INIT(error);
  PSPLIT_INIT(source);
  source.data = bytes;
  source.size = size;
  source.flags = PSPLIT_COPY;
  OK(psplit_gltf_open(&source, &gltf, &error));
  free(bytes);
  CHECK(psplit_gltf_mesh_count(gltf) == 1 && psplit_gltf_primitive_count(gltf, 0) == 1);
  CHECK(psplit_gltf_primitive_kind(gltf, 0, 0) == PSPLIT_KIND_PATCHES);
  CHECK(psplit_gltf_buffer_count(gltf) == 1 && psplit_gltf_buffer_uri(gltf, 0) == NULL);
  CHECK(psplit_gltf_open_primitive(gltf, 0, 1, &mesh, &error) == PSPLIT_ERROR_USAGE && mesh == NULL);
  CHECK(strcmp(error.text, "mesh 0, primitive 1: there is no such primitive") == 0 && error.primitive == 1);
  CHECK(strcmp(psplit_code_name(error.code), "wrong usage") == 0);
  OK(psplit_gltf_open_primitive(gltf, 0, 0, &mesh, &error));
  CHECK(error.code == PSPLIT_OK && error.text[0] == 0);
  psplit_gltf_free(gltf);
  PSPLIT_INIT(patch);
  OK(psplit_mesh_get_patch(mesh, 0, &patch, &error));
  CHECK(patch.face_count > 0 && patch.first_face == 0 && psplit_mesh_find_id(mesh, 0) >= 0);
  vertices = decode(mesh, &point_count, &indices, &face_count, &error);
  psplit_mesh_free(mesh);
  encode(vertices, point_count, indices, face_count, PSPLIT_KIND_PATCHES, &error);
  encode(vertices, point_count, indices, face_count, PSPLIT_KIND_DRACO, &error);
  decode_older(&error);
  psplit_release_scratch();
  free(vertices);
  free(indices);
  return 0;
}
