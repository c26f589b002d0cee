/* large_scene FOLDER TRIANGLES [point]: a room whose floor is a landscape of about so many triangles, as
 * large.ply (binary) and large.json. Its lamp is a square below the ceiling, or with `point` a light without
 * extent. The same bytes on every machine. */
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const float side = 10.0f, height = 6.0f;

/* Three waves of parabolas: the sum has hills within hills and no two triangles in one plane. */
static float wave(float x) {
    float t = x - (float)(int)x;
    return 4.0f * t * (1.0f - t);
}

static float ground(float x, float z) {
    return 0.5f * wave(0.31f * x + 0.07f * z) * wave(0.27f * z) +
           0.1f * wave(1.7f * x) * wave(1.3f * z + 0.4f * x) + 0.01f * wave(13.0f * x) * wave(11.0f * z);
}

static void put(FILE *file, const void *data, size_t bytes) {
    if (fwrite(data, 1, bytes, file) == bytes) return;
    perror("large_scene");
    exit(4);
}

static void put_face(FILE *file, uint32_t a, uint32_t b, uint32_t c) {
    uint8_t record[13] = {3};
    memcpy(record + 1, (uint32_t[3]){a, b, c}, 12);
    put(file, record, sizeof record);
}

static FILE *open_file(const char *folder, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (file) return file;
    fprintf(stderr, "large_scene: %s: %s\n", path, strerror(errno));
    exit(4);
}

/* Eight corners after those of the landscape; walls and ceiling face inwards. */
static void put_walls(FILE *file, uint32_t first) {
    static const uint8_t quads[5][4] = {{4, 5, 6, 7}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 4, 7, 3}, {1, 2, 6, 5}};
    for (int q = 0; q < 5; q++) {
        put_face(file, first + quads[q][0], first + quads[q][1], first + quads[q][2]);
        put_face(file, first + quads[q][0], first + quads[q][2], first + quads[q][3]);
    }
}

static void write_mesh(const char *folder, uint32_t cells) {
    FILE *file = open_file(folder, "large.ply");
    uint32_t corners = (cells + 1) * (cells + 1);
    fprintf(file,
            "ply\nformat binary_little_endian 1.0\nelement vertex %u\nproperty float x\nproperty float "
            "y\nproperty float z\n"
            "element face %u\nproperty list uchar uint vertex_indices\nend_header\n",
            corners + 8, 2 * cells * cells + 10);
    for (uint32_t row = 0; row <= cells; row++) {
        for (uint32_t column = 0; column <= cells; column++) {
            float x = side * (float)column / (float)cells, z = side * (float)row / (float)cells;
            put(file, (float[3]){x, ground(x, z), z}, 12);
        }
    }
    for (int k = 0; k < 8; k++)
        put(file,
            (float[3]){k % 4 == 1 || k % 4 == 2 ? side : 0.0f, k < 4 ? 0.0f : height,
                       k % 4 >= 2 ? side : 0.0f},
            12);
    for (uint32_t row = 0; row < cells; row++) {
        for (uint32_t column = 0; column < cells; column++) {
            uint32_t a = row * (cells + 1) + column, b = a + 1, c = a + cells + 1, d = c + 1;
            put_face(file, a, c, b);
            put_face(file, b, c, d);
        }
    }
    put_walls(file, corners);
    if (fclose(file) != 0) exit(4);
}

static void write_scene(const char *folder, int point) {
    FILE *file = open_file(folder, "large.json");
    fprintf(file,
            "{\"softlux\": 1, \"meshes\": [{\"file\": \"large.ply\", \"material\": \"stone\"}],\n"
            " \"materials\": {\"stone\": {\"diffuse\": 0.6}},\n \"lights\": [%s],\n"
            " \"camera\": {\"eye\": [1, 3.5, 9.5], \"target\": [5.5, 0.6, 4], \"up\": [0, 1, 0], "
            "\"fov_deg\": 60},\n"
            " \"film\": {\"width\": 256, \"height\": 256}}\n",
            point ? "{\"type\": \"point\", \"position\": [5, 5, 5], \"intensity\": [40, 36, 30]}"
                  : "{\"type\": \"quad\", \"corner\": [4.5, 5.9, 4.5], \"edge1\": [1, 0, 0], \"edge2\": [0, "
                    "0, 1], \"radiance\": [40, 36, 30]}");
    if (fclose(file) != 0) exit(4);
}

int main(int argc, char **argv) {
    double triangles = argc > 2 ? atof(argv[2]) : 0.0;
    if (!(triangles >= 2.0 && triangles <= 1e9)) {
        fprintf(stderr, "usage: large_scene FOLDER TRIANGLES [point]\n");
        return 2;
    }
    uint32_t cells = 1;
    while (2.0 * (double)(cells + 1) * (double)(cells + 1) <= triangles) cells++;
    if (mkdir(argv[1], 0777) != 0 && errno != EEXIST) {
        perror(argv[1]);
        return 4;
    }
    write_mesh(argv[1], cells);
    write_scene(argv[1], argc > 3 && strcmp(argv[3], "point") == 0);
    return 0;
}
