/* The mesh in the making: snapped positions, normals, faces in runs of one object and material, and the frame
 * in which shapes are put. */
#include "mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/math.h"

double gen_length(v3 a) { return sqrt(gen_dot(a, a)); }

v3 gen_unit(v3 a) {
    double length = gen_length(a);
    return length > 0.0 ? gen_scale(a, 1.0 / length) : gen_v3(0.0, 1.0, 0.0);
}

void *gen_allocate(size_t bytes) {
    void *memory = malloc(bytes ? bytes : 1);
    if (!memory) {
        fprintf(stderr, "generate: out of memory (%zu bytes)\n", bytes);
        exit(5);
    }
    return memory;
}

void *gen_grow(void *array, size_t count, size_t *capacity, size_t size) {
    if (count < *capacity) return array;
    size_t wanted = *capacity ? *capacity * 2 : 1024;
    void *grown = realloc(array, wanted * size);
    if (!grown) {
        fprintf(stderr, "generate: out of memory (%zu bytes)\n", wanted * size);
        exit(5);
    }
    *capacity = wanted;
    return grown;
}

void gen_mesh_init(mesh *m, const gen_material *materials, uint32_t count) {
    *m = (mesh){.materials = materials, .material_count = count};
    m->frame = (frame){{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

void gen_mesh_free(mesh *m) {
    free(m->positions);
    free(m->normals);
    free(m->faces);
    free(m->runs);
    *m = (mesh){0};
}

void gen_paint(mesh *m, const char *object, uint32_t material) {
    m->runs = gen_grow(m->runs, m->run_count, &m->run_capacity, sizeof *m->runs);
    m->runs[m->run_count++] = (gen_run){m->face_count, object, material};
}

static v3 rotate(const frame *f, v3 a) {
    return gen_add(gen_add(gen_scale(f->x, a.x), gen_scale(f->y, a.y)), gen_scale(f->z, a.z));
}

static int32_t snap(double x) { return (int32_t)floor(x * 1e4 + 0.5); }

uint32_t gen_position(mesh *m, v3 local) {
    v3 p = gen_add(m->frame.origin, rotate(&m->frame, local));
    m->positions = gen_grow(m->positions, m->position_count, &m->position_capacity, sizeof *m->positions);
    int32_t *to = m->positions[m->position_count];
    to[0] = snap(p.x), to[1] = snap(p.y), to[2] = snap(p.z);
    return (uint32_t)m->position_count++;
}

uint32_t gen_normal(mesh *m, v3 local) {
    v3 n = gen_unit(rotate(&m->frame, gen_unit(local)));
    int32_t x = snap(n.x), y = snap(n.y), z = snap(n.z);
    if (m->normal_count) { /* flat shapes ask for the same one again and again */
        const int32_t *last = m->normals[m->normal_count - 1];
        if (last[0] == x && last[1] == y && last[2] == z) return (uint32_t)(m->normal_count - 1);
    }
    m->normals = gen_grow(m->normals, m->normal_count, &m->normal_capacity, sizeof *m->normals);
    int32_t *to = m->normals[m->normal_count];
    to[0] = x, to[1] = y, to[2] = z;
    return (uint32_t)m->normal_count++;
}

/* Exact: the snapped corners lie on one line. */
static bool is_degenerate(const mesh *m, gen_corner a, gen_corner b, gen_corner c) {
    const int32_t *pa = m->positions[a.position], *pb = m->positions[b.position],
                  *pc = m->positions[c.position];
    int64_t u[3], v[3];
    for (int i = 0; i < 3; i++) u[i] = (int64_t)pb[i] - pa[i], v[i] = (int64_t)pc[i] - pa[i];
    return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

void gen_face(mesh *m, gen_corner a, gen_corner b, gen_corner c) {
    if (is_degenerate(m, a, b, c)) return;
    m->faces = gen_grow(m->faces, m->face_count, &m->face_capacity, sizeof *m->faces);
    gen_corner *to = m->faces[m->face_count++];
    to[0] = a, to[1] = b, to[2] = c;
}

frame gen_move(mesh *m, double x, double y, double z) {
    frame before = m->frame;
    m->frame.origin = gen_add(before.origin, rotate(&before, gen_v3(x, y, z)));
    return before;
}

/* Right angles are exact, so that walls of turned parts stay in their planes. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    double quarter = degrees / 90.0;
    if (floor(quarter) == quarter) {
        static const double exact[4] = {0.0, 1.0, 0.0, -1.0};
        int turns = (int)(quarter - 4.0 * floor(quarter / 4.0));
        *sine = exact[turns];
        *cosine = exact[(turns + 1) % 4];
        return;
    }
    *sine = sl_sin(degrees * SL_PI / 180.0);
    *cosine = sl_cos(degrees * SL_PI / 180.0);
}

frame gen_turn(mesh *m, double degrees) {
    frame before = m->frame;
    double s, c;
    sine_cosine(degrees, &s, &c);
    m->frame.x = rotate(&before, gen_v3(c, 0.0, -s));
    m->frame.z = rotate(&before, gen_v3(s, 0.0, c));
    return before;
}

frame gen_tilt(mesh *m, double degrees) {
    frame before = m->frame;
    double s, c;
    sine_cosine(degrees, &s, &c);
    m->frame.y = rotate(&before, gen_v3(0.0, c, s));
    m->frame.z = rotate(&before, gen_v3(0.0, -s, c));
    return before;
}
