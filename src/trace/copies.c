#include "trace/copies.h"

#include <math.h>

#include "base/error.h"
#include "base/memory.h"

enum { LEAST_MESH = 256, TRIED = 8, EXPECTED_BY = 61 };

/* Maps that stretch unevenly by more lose too many digits when they are turned round. */
static const double MOST_CONDITION = 30.0;

/* A mesh that others may be copies of: four of its corners (3 triangle + corner, counted from its first) that
 * span space, and what turns vectors into multiples of the three edges between them. */
typedef struct candidate {
    sl_copied_mesh mesh;
    bool spans, is_flat;
    uint32_t corner[4];
    sl_affine from_edges;
} candidate;

typedef struct finder {
    const sl_scene *scene;
    double rounding;    /* of coordinates and distances in the scene, with what they are turned by */
    uint32_t step;      /* every so many corners are looked at */
    candidate *list;
    size_t count;
} finder;

static sl_vec3d corner_at(const sl_scene *s, uint32_t first, uint32_t corner) {
    return sl_to_double(sl_scene_position(s, s->vertex[corner % 3][first + corner / 3]));
}

/* ---- maps ------------------------------------------------------------------------------------ */

static bool inverse(const sl_affine *a, sl_affine *out) {
    const double volume = sl_affine_determinant(a);
    const bool has_one = fabs(volume) > 0.0 && isfinite(volume);
    if (has_one) *out = sl_affine_inverse(a);
    return has_one;
}

/* No vector becomes longer by more. */
static double stretch_of(const sl_affine *a) {
    double sum = 0.0;
    for (int i = 0; i < 9; i++) sum += a->m[i / 3][i % 3] * a->m[i / 3][i % 3];
    return sqrt(sum);
}

/* The edges from the first of four corners to the others, as columns. */
static sl_affine edges_of(const sl_scene *s, uint32_t first, const uint32_t corner[4]) {
    const sl_vec3d p = corner_at(s, first, corner[0]);
    sl_affine edges = {{{0}}};
    for (int k = 0; k < 3; k++) {
        const sl_vec3d e = sl_subd(corner_at(s, first, corner[k + 1]), p);
        edges.m[0][k] = e.x, edges.m[1][k] = e.y, edges.m[2][k] = e.z;
    }
    return edges;
}

/* Each corner is the one that adds most: length, area, volume. */
static void choose_corners(const sl_scene *s, candidate *c) {
    sl_vec3d p = corner_at(s, c->mesh.first, 0), a = {0}, normal = {0};
    double size = 0.0;
    c->spans = true;
    for (int k = 1; k < 4; k++) {
        double most = -1.0;
        for (uint32_t i = 0; i < 3 * c->mesh.count; i++) {
            const sl_vec3d d = sl_subd(corner_at(s, c->mesh.first, i), p);
            const double more = k == 1   ? sl_lengthd(d)
                                : k == 2 ? sl_lengthd(sl_crossd(a, d))
                                         : fabs(sl_dotd(normal, d));
            if (more > most) most = more, c->corner[k] = i;
        }
        const sl_vec3d edge = sl_subd(corner_at(s, c->mesh.first, c->corner[k]), p);
        if (k == 1) a = edge, size = most;
        if (k == 2) normal = sl_crossd(a, edge);
        c->is_flat |= k == 3 && !(most > 1e-4 * size * size * size);
    }
    const sl_affine edges = edges_of(s, c->mesh.first, c->corner);
    if (!c->is_flat) c->is_flat = !inverse(&edges, &c->from_edges);
}

/* ---- is it a copy? --------------------------------------------------------------------------- */

static sl_affine map_to(const sl_scene *s, const candidate *c, uint32_t first, float rounded[12]) {
    const sl_affine edges = edges_of(s, first, c->corner), linear = sl_affine_after(&edges, &c->from_edges);
    const sl_vec3d from = sl_affine_vector(&linear, corner_at(s, c->mesh.first, c->corner[0])),
                   move = sl_subd(corner_at(s, first, c->corner[0]), from);
    sl_affine map = linear;
    map.m[0][3] = move.x, map.m[1][3] = move.y, map.m[2][3] = move.z;
    for (int i = 0; i < 12; i++) {
        rounded[i] = (float)map.m[i % 3][i / 3];
        map.m[i % 3][i / 3] = (double)rounded[i];
    }
    return map;
}

/* Whatever the corners are apart by once the copy is turned back is what boxes must grow by. */
static bool is_copy(const finder *f, candidate *c, uint32_t first, sl_copy *copy) {
    const sl_scene *s = f->scene;
    if (!c->spans) choose_corners(s, c);
    if (c->is_flat) return false;
    const sl_affine map = map_to(s, c, first, copy->from_mesh);
    sl_affine back;
    if (!inverse(&map, &back)) return false;
    const double stretch = stretch_of(&back), condition = stretch * stretch_of(&map),
                 room = stretch * condition * f->rounding;
    double apart = 0.0;
    if (!(condition < MOST_CONDITION)) return false;
    for (uint32_t i = 0; i < 3 * c->mesh.count; i += f->step) {
        const sl_vec3d p = sl_affine_point(&back, corner_at(s, first, i)),
                       d = sl_subd(p, corner_at(s, c->mesh.first, i));
        apart = fmax(apart, fmax(fabs(d.x), fmax(fabs(d.y), fabs(d.z))));
        if (!(apart <= room)) return false;
    }
    c->mesh.slack = fmax(c->mesh.slack, room + apart);
    c->mesh.stretch = fmax(c->mesh.stretch, stretch);
    return true;
}

/* Takes a run of triangles as a copy of a mesh that came before, or as a new one. */
static void take(finder *f, uint32_t first, uint32_t count, sl_copy *copy) {
    int tried = 0;
    *copy = (sl_copy){.first = first, .from_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    for (size_t i = f->count; i-- > 0 && tried < TRIED;) {
        candidate *c = &f->list[i];
        if (c->mesh.count != count) continue;
        tried++;
        if (!is_copy(f, c, first, copy)) continue;
        copy->mesh = (uint32_t)i;
        c->mesh.copies++;
        return;
    }
    *copy = (sl_copy){.first = first, .mesh = (uint32_t)f->count, .from_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    f->list[f->count++] = (candidate){.mesh = {.first = first, .count = count, .copies = 1, .stretch = 1.0}};
}

/* ---- all of them ----------------------------------------------------------------------------- */

/* Returns the end of a run of triangles of one object. */
static uint32_t run_end(const sl_scene *s, uint32_t first) {
    uint32_t end = first + 1;
    while (end < s->triangle_count && s->object_index[end] == s->object_index[first]) end++;
    return end;
}

static size_t count_runs(const sl_scene *s) {
    size_t runs = 0;
    for (uint32_t t = 0, end; t < s->triangle_count; t = end) {
        end = run_end(s, t);
        runs += end - t >= LEAST_MESH;
    }
    return runs;
}

static finder finder_of(const sl_scene *s, uint32_t step, size_t runs) {
    const double coordinate =
        (double)fmaxf(sl_greatest_coordinate(s->box_min), sl_greatest_coordinate(s->box_max));
    const double far = coordinate + 4.0 * (double)s->diagonal;
    return (finder){s, 0x1p-21 * far, step, sl_allocate(runs, sizeof(candidate)), 0};
}

static void find_all(finder *f, sl_copies *c) {
    const sl_scene *s = f->scene;
    for (uint32_t t = 0, end; t < s->triangle_count; t = end) {
        end = run_end(s, t);
        if (end - t >= LEAST_MESH) take(f, t, end - t, &c->copy[c->copy_count++]);
    }
    for (size_t i = 0; i < f->count; i++) {
        const sl_copied_mesh *m = &f->list[i].mesh;
        c->saved += (size_t)(m->copies - 1) * m->count;
    }
}

/* Leaves out meshes that are there once. */
static void keep_copied(const finder *f, sl_copies *c) {
    size_t kept = 0;
    for (size_t i = 0; i < f->count; i++) c->mesh[i] = f->list[i].mesh;
    for (size_t k = 0; k < c->copy_count; k++) {
        const uint32_t mesh = c->copy[k].mesh;
        if (f->list[mesh].mesh.copies < 2) continue;
        c->triangles += f->list[mesh].mesh.count;
        c->copy[kept++] = c->copy[k];
    }
    c->mesh_count = f->count;
    c->copy_count = kept;
}

static bool find(const sl_scene *scene, uint32_t step, sl_copies *copies) {
    const size_t runs = count_runs(scene);
    finder f = finder_of(scene, step, runs);
    copies->copy = sl_allocate(runs, sizeof *copies->copy);
    copies->mesh = sl_allocate(runs, sizeof *copies->mesh);
    const bool room = f.list && copies->copy && copies->mesh;
    if (room) {
        find_all(&f, copies);
        keep_copied(&f, copies);
    }
    sl_free(f.list);
    return room;
}

sl_status sl_copies_find(const sl_scene *scene, size_t worth, sl_copies *copies, sl_error *error) {
    *copies = (sl_copies){0};
    if (scene->triangle_count <= worth) return SL_OK;
    if (!find(scene, 1, copies)) return sl_fail_memory(error, "the copies of meshes");
    if (copies->saved < worth) sl_copies_release(copies);
    return SL_OK;
}

void sl_copies_release(sl_copies *copies) {
    SL_FREE_ALL(copies->mesh, copies->copy);
    *copies = (sl_copies){0};
}

size_t sl_copies_expected(const sl_scene *scene) {
    sl_copies copies = {0};
    if (scene->triangle_count <= SL_COPIES_WORTH) return 0;
    const size_t saved = find(scene, EXPECTED_BY, &copies) ? copies.saved : 0;
    sl_copies_release(&copies);
    return saved < SL_COPIES_WORTH ? 0 : saved;
}
