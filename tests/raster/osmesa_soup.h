/* Shared by the comparisons with OSMesa: the same vertices through the same matrix, by the same rounded
 * operations. */
#pragma once

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/random.h"
#include "osmesa.h"
#include "raster/raster.h"
#include "raster_soup.h"

static inline void open_or_skip(void) {
    const char *reason;
    if (osmesa_open(0, &reason)) return;
    print_message("skipped: %s\n", reason);
    skip();
}

static inline void *checked_calloc(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    assert_non_null(memory);
    return memory;
}

/* A vertex shader with our transform: the origin is subtracted first, then columns are added up in order,
 * without fused operations ("precise"). `declarations` and `body` carry further outputs. Inputs 0 to 2 are x,
 * y, z. */
static inline unsigned program_in_view(const char *declarations, const char *body,
                                       const char *fragment_shader) {
    char vertex[2000], fragment[2000];
    snprintf(
        vertex, sizeof vertex,
        "#version 400 core\n"
        "layout(location = 0) in float x; layout(location = 1) in float y; layout(location = 2) in float z;\n"
        "uniform mat4 columns; uniform vec3 origin; %s\n"
        "void main() {\n"
        "    precise vec3 q = vec3(x, y, z) - origin;\n"
        "    precise vec4 clip = ((columns[0] * q.x + columns[1] * q.y) + columns[2] * q.z) + columns[3];\n"
        "    gl_Position = clip;\n"
        "    %s\n"
        "}\n",
        declarations, body);
    snprintf(fragment, sizeof fragment, "#version 400 core\n%s", fragment_shader);
    return osmesa_program(vertex, fragment);
}

/* The number h of a triangle, 1 to 255: a small integer, so that sums of many are exact in float. */
static inline float triangle_number(uint32_t id) { return (float)(1 + (id * 2654435761u >> 24) % 255u); }
#define TRIANGLE_NUMBER_GLSL "float(1u + (uint(gl_PrimitiveID) * 2654435761u >> 24) % 255u)"

/* Of every soup or mesh: its positions as inputs 0..2, and one more of `channels` floats a vertex (NULL:
 * none). */
static inline osmesa_mesh mesh_of(float *const position[3], size_t vertices, const float *attributes,
                                  int channels, size_t index_count, const uint32_t *indices) {
    const osmesa_stream streams[] = {{position[0], vertices, 1, false},
                                     {position[1], vertices, 1, false},
                                     {position[2], vertices, 1, false},
                                     {attributes, vertices, channels, false}};
    return osmesa_mesh_create(attributes ? 4 : 3, streams, index_count, indices);
}

static inline void set_view(unsigned program, const sl_view *view) {
    const float origin[3] = {view->origin.x, view->origin.y, view->origin.z};
    osmesa_uniform_matrix(program, "columns", view->clip);
    osmesa_uniform(program, "origin", 3, origin);
}

/* Clears, and draws the whole mesh in the view, into its viewport of the target. */
static inline void judge_draw(unsigned program, const osmesa_target *target, const osmesa_mesh *mesh,
                              const sl_view *view, bool depth, bool add) {
    osmesa_clear(target);
    osmesa_viewport(view->x, view->y, view->width, view->height);
    osmesa_state(depth, add);
    set_view(program, view);
    osmesa_draw_all(program, mesh);
}

/* Words that differ, bit for bit; where[] (if given) is the first of them. */
static inline size_t differing_words(const void *a, const void *b, size_t count, size_t *where) {
    const uint32_t *p = a, *q = b;
    size_t differing = 0;
    if (memcmp(a, b, 4 * count) == 0) return 0;
    for (size_t i = 0; i < count; i++) {
        if (p[i] == q[i]) continue;
        if (!differing && where) *where = i;
        differing++;
    }
    return differing;
}

/* Sizes of target and viewport that every comparison goes through. */
typedef struct judged_size {
    const char *name;
    int target_width, target_height, x, y, width, height;
    double share; /* of the triangles */
} judged_size;
static const judged_size judged_sizes[] = {
    {"1024x1024", 1024, 1024, 0, 0, 1024, 1024, 0.60},
    {"1000x600", 1000, 600, 0, 0, 1000, 600, 0.20},
    {"640x480 at (91, 37) of 800x700", 800, 700, 91, 37, 640, 480, 0.10},
    {"333x217", 333, 217, 0, 0, 333, 217, 0.06},
    {"17x4000", 17, 4000, 0, 0, 17, 4000, 0.03},
    {"1x1", 1, 1, 0, 0, 1, 1, 0.01},
};

static inline soup judged_soup(soup_kind kind, uint64_t seed, size_t triangles, const judged_size *size) {
    soup s = soup_make(kind, seed, triangles, size->width, size->height);
    s.view.x = size->x;
    s.view.y = size->y;
    return s;
}

/* "1,234,567" */
static inline const char *with_commas(uint64_t n, char text[32]) {
    char digits[32];
    int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)n), out = 0;
    for (int i = 0; i < length; i++) {
        if (i && (length - i) % 3 == 0) text[out++] = ',';
        text[out++] = digits[i];
    }
    text[out] = 0;
    return text;
}
