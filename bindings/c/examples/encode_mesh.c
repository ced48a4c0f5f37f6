/* encode_mesh [PATCHES]: encodes a mesh from memory as a patch container, and decodes it again. */
#include <psplit/psplit.h>
#include <stdio.h>
#include <stdlib.h>

enum { COLUMNS = 120, ROWS = 100, POINTS = (COLUMNS + 1) * (ROWS + 1), FACES = 2 * COLUMNS * ROWS };

static float positions[POINTS][3];
static uint32_t faces[FACES][3];

/* A sheet of COLUMNS x ROWS quads. */
static void make_sheet(void) {
  uint32_t x, y, point = 0, face = 0;
  for (y = 0; y <= ROWS; ++y)
    for (x = 0; x <= COLUMNS; ++x, ++point) {
      const float u = (float)x / COLUMNS, v = (float)y / ROWS;
      positions[point][0] = u;
      positions[point][1] = v;
      positions[point][2] = u * v;
      if (x == COLUMNS || y == ROWS) continue;
      faces[face][0] = faces[face + 1][0] = point;
      faces[face][1] = point + 1;
      faces[face][2] = faces[face + 1][1] = point + COLUMNS + 2;
      faces[face + 1][2] = point + COLUMNS + 1;
      face += 2;
    }
}

static int fail(const psplit_error* error) {
  fprintf(stderr, "%s\n", error->text);
  return error->code;
}

int main(int argc, char** argv) {
  psplit_error error;
  psplit_attribute_values position;
  psplit_encode_source source;
  psplit_encode_options options;
  psplit_encoded* encoded = NULL;
  psplit_encoded_info result;
  psplit_attribute_request request;
  psplit_source stored;
  psplit_mesh* mesh = NULL;
  psplit_mesh_info info;
  PSPLIT_INIT(error);

  make_sheet();
  PSPLIT_INIT(position);
  position.name = "POSITION";
  position.type = PSPLIT_FLOAT32;
  position.components = 3;
  position.data = positions;
  position.size = sizeof(positions);
  PSPLIT_INIT(source);
  source.point_count = POINTS;
  source.indices = faces;
  source.indices_size = sizeof(faces);
  source.index_size = sizeof(faces[0][0]);
  source.attributes = &position;
  source.attribute_count = 1;
  PSPLIT_INIT(options);
  psplit_encode_options_init(&options);
  options.patch_count = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 4;
  if (psplit_encode(&source, &options, &encoded, &error) != PSPLIT_OK) return fail(&error);
  PSPLIT_INIT(result);
  if (psplit_encoded_get_info(encoded, &result, &error) != PSPLIT_OK) return fail(&error);

  /* A loader knows the container's bytes, and from JSON the attributes. */
  PSPLIT_INIT(request);
  if (psplit_encoded_get_attribute(encoded, 0, &request, &error) != PSPLIT_OK) return fail(&error);
  PSPLIT_INIT(stored);
  stored.kind = result.kind;
  stored.data = result.data;
  stored.size = result.size;
  stored.attributes = &request;
  stored.attribute_count = 1;
  if (psplit_mesh_open(&stored, &mesh, &error) != PSPLIT_OK) return fail(&error);
  PSPLIT_INIT(info);
  if (psplit_mesh_get_info(mesh, &info, &error) != PSPLIT_OK) return fail(&error);
  printf("%u patches, %lu bytes: %u triangles, %u points\n", (unsigned)result.patch_count,
         (unsigned long)result.size, (unsigned)info.face_count, (unsigned)info.point_count);
  psplit_mesh_free(mesh);
  psplit_encoded_free(encoded);
  return 0;
}
