/* decode_glb FILE.glb: decodes all compressed meshes of a .glb file at once, and prints them. With a .drc file
   it prints that. */
#include <psplit/psplit.h>
#include <stdio.h>
#include <stdlib.h>

/* A mesh, and the memory that it is decoded into. */
typedef struct {
  psplit_mesh* mesh;
  psplit_mesh_info info;
  psplit_attribute_buffer* attributes;
  psplit_buffers buffers;
} loaded_mesh;

static int fail(const char* text) {
  fprintf(stderr, "%s\n", text);
  return 3;
}

static unsigned char* read_file(const char* path, size_t* size) {
  unsigned char* bytes = NULL;
  size_t read;
  FILE* file = fopen(path, "rb");
  *size = 0;
  if (file == NULL) return NULL;
  do {
    unsigned char* grown = realloc(bytes, *size + 65536);
    if (grown == NULL) break;
    bytes = grown;
    read = fread(bytes + *size, 1, 65536, file);
    *size += read;
  } while (read > 0);
  fclose(file);
  return bytes;
}

/* Takes memory for the whole mesh: asks for the sizes first. */
static int allocate(loaded_mesh* loaded, psplit_error* error) {
  uint32_t i;
  PSPLIT_INIT(loaded->info);
  if (psplit_mesh_get_info(loaded->mesh, &loaded->info, error) != PSPLIT_OK) return 0;
  PSPLIT_INIT(loaded->buffers);
  loaded->buffers.index_size = loaded->info.least_index_size;
  loaded->buffers.indices_size = (size_t)3 * loaded->info.face_count * loaded->buffers.index_size;
  loaded->buffers.indices = malloc(loaded->buffers.indices_size + 1);
  loaded->attributes = calloc(loaded->info.attribute_count + 1, sizeof(psplit_attribute_buffer));
  if (loaded->buffers.indices == NULL || loaded->attributes == NULL) return 0;
  for (i = 0; i < loaded->info.attribute_count; ++i) {
    psplit_attribute_buffer* buffer = &loaded->attributes[i];
    psplit_attribute_info attribute;
    PSPLIT_INIT(attribute);
    if (psplit_mesh_get_attribute(loaded->mesh, i, &attribute, error) != PSPLIT_OK) return 0;
    PSPLIT_INIT(*buffer);
    buffer->size = (size_t)attribute.value_size * loaded->info.point_count;
    buffer->data = malloc(buffer->size + 1);
    if (buffer->data == NULL) return 0;
  }
  loaded->buffers.attributes = loaded->attributes;
  loaded->buffers.attribute_count = loaded->info.attribute_count;
  return 1;
}

static void release(loaded_mesh* loaded) {
  uint32_t i;
  for (i = 0; loaded->attributes != NULL && i < loaded->info.attribute_count; ++i)
    free(loaded->attributes[i].data);
  free(loaded->attributes);
  free(loaded->buffers.indices);
  psplit_mesh_free(loaded->mesh);
}

static void print(const loaded_mesh* loaded) {
  uint32_t i;
  int32_t position = psplit_mesh_find_name(loaded->mesh, "POSITION");
  printf("%u triangles, %u points:", (unsigned)loaded->info.face_count, (unsigned)loaded->info.point_count);
  for (i = 0; i < loaded->info.attribute_count; ++i) {
    psplit_attribute_info attribute;
    PSPLIT_INIT(attribute);
    if (psplit_mesh_get_attribute(loaded->mesh, i, &attribute, NULL) == PSPLIT_OK)
      printf(" %s", attribute.name);
  }
  if (position >= 0 && loaded->info.point_count > 0) {
    float first[3];
    memcpy(first, loaded->attributes[position].data, sizeof(first));
    printf(" from (%g, %g, %g)", first[0], first[1], first[2]);
  }
  printf("\n");
}

/* Opens every compressed primitive of a .glb file. Returns their number, or -1. */
static int open_glb(const unsigned char* bytes, size_t size, loaded_mesh** meshes, psplit_error* error) {
  psplit_gltf_source source;
  psplit_gltf* gltf = NULL;
  uint32_t mesh, primitive;
  int count = 0;
  PSPLIT_INIT(source);
  source.data = bytes;
  source.size = size;
  if (psplit_gltf_open(&source, &gltf, error) != PSPLIT_OK) return -1;
  for (mesh = 0; mesh < psplit_gltf_mesh_count(gltf) && count >= 0; ++mesh)
    for (primitive = 0; primitive < psplit_gltf_primitive_count(gltf, mesh) && count >= 0; ++primitive) {
      loaded_mesh* grown;
      if (psplit_gltf_primitive_kind(gltf, mesh, primitive) == PSPLIT_KIND_NONE) continue;
      grown = realloc(*meshes, ((size_t)count + 1) * sizeof(loaded_mesh));
      if (grown == NULL) break;
      *meshes = grown;
      memset(&grown[count], 0, sizeof(loaded_mesh));
      if (psplit_gltf_open_primitive(gltf, mesh, primitive, &grown[count].mesh, error) != PSPLIT_OK)
        count = -1;
      else
        ++count;
    }
  psplit_gltf_free(gltf); /* the meshes keep what they need */
  return count;
}

static int open_drc(const unsigned char* bytes, size_t size, loaded_mesh** meshes, psplit_error* error) {
  psplit_source source;
  *meshes = calloc(1, sizeof(loaded_mesh));
  if (*meshes == NULL) return -1;
  PSPLIT_INIT(source);
  source.kind = PSPLIT_KIND_DRACO_FILE;
  source.data = bytes;
  source.size = size;
  return psplit_mesh_open(&source, &(*meshes)->mesh, error) == PSPLIT_OK ? 1 : -1;
}

int main(int argc, char** argv) {
  psplit_error error;
  unsigned char* bytes;
  size_t size;
  loaded_mesh* meshes = NULL;
  psplit_job* jobs;
  int count, i;
  if (argc != 2) return fail("usage: decode_glb FILE");
  bytes = read_file(argv[1], &size);
  if (bytes == NULL) return fail("the file cannot be read");
  PSPLIT_INIT(error);
  count = size > 5 && memcmp(bytes, "DRACO", 5) == 0 ? open_drc(bytes, size, &meshes, &error)
                                                     : open_glb(bytes, size, &meshes, &error);
  if (count < 0) return fail(error.text);
  jobs = calloc((size_t)count + 1, sizeof(psplit_job));
  if (jobs == NULL) return fail("no memory");
  for (i = 0; i < count; ++i) {
    if (!allocate(&meshes[i], &error)) return fail("no memory");
    PSPLIT_INIT(jobs[i]);
    jobs[i].mesh = meshes[i].mesh;
    jobs[i].buffers = &meshes[i].buffers;
  }
  if (psplit_decode_meshes(jobs, (size_t)count, NULL, &error) != PSPLIT_OK) return fail(error.text);
  for (i = 0; i < count; ++i) {
    print(&meshes[i]);
    release(&meshes[i]);
  }
  free(meshes);
  free(jobs);
  free(bytes);
  return 0;
}
