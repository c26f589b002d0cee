/* The coarse mesh: which faces it has, how finely they are cut, and its vertices, each listed once. */
#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/multi_mesh/coarse_tables.h"

/* Cells in which corners of small faces share a sample: half as wide as edges may be long, and of the
 * diagonal of the scene's central region no more than that. */
static const double CELL = 0.5, CELL_MOST = 1.0 / 48.0;
/* Slices may be longer than others by this. */
static const double STRETCH = 4.0;

/* ---- what is to be sampled ------------------------------------------------------------------- */

/* Can light that leaves this face be seen, and does any leave it? */
static bool is_wanted(const sl_scene *scene, const sl_topology *topology, uint32_t face) {
    uint32_t triangle = face / 2;
    if (topology->degenerate[triangle]) return false;
    if (face % 2 == 1 && sl_solids_hide_back(topology->solids, triangle)) return false;
    return sl_material_is_diffuse(&scene->materials[scene->material_index[triangle]]);
}

/* Lengths of edges, k opposite to corner k; the area. */
static double measure(const sl_scene *scene, uint32_t triangle, double length[3]) {
    sl_vec3d p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle]));
    for (int k = 0; k < 3; k++) length[k] = sl_lengthd(sl_subd(p[(k + 2) % 3], p[(k + 1) % 3]));
    return 0.5 * sl_lengthd(sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0])));
}

/* Returns the length that a slice across a long face may have. The narrower the face, the less of it is to be
 * seen, and the less it takes in a picture of all the scene if light changes along a slice: slices have the
 * area of other coarse triangles, but are not absurdly long. */
static double slice_edge(double edge, double longest, double area) {
    double width = 2.0 * area / longest, longer = width > 0.0 ? sqrt(0.5 * edge / width) : 1.0;
    return edge * fmin(fmax(longer, 1.0), STRETCH);
}

/* A face's level by its longest edge, and whether it is enough to slice it: then the far corner becomes the
 * lattice's corner 0. */
static bool cut(sl_coarse *c, uint32_t face, const sl_coarse_settings *settings) {
    double length[3], edge = (double)settings->edge;
    double area = measure(c->scene, face / 2, length);
    int shortest = length[1] < length[0] ? 1 : 0, level = 0, depth = settings->depth;
    if (settings->finer && settings->finer[face / 2]) {
        edge *= SL_COARSE_FINER;
        depth = depth + 2 < SL_MESH_DEPTH_MAX ? depth + 2 : SL_MESH_DEPTH_MAX;
    }
    if (length[2] < length[shortest]) shortest = 2;
    double longest = length[0] > length[1] ? length[0] : length[1];
    if (length[2] > longest) longest = length[2];
    bool sliced = length[shortest] <= edge && 2.0 * length[shortest] < longest;
    if (sliced) edge = slice_edge(edge, longest, area);
    for (; level < depth && longest > edge; level++) longest *= 0.5;
    c->level[face] = (uint8_t)level;
    sliced = sliced && level > 0;
    c->turn[face / 2] = (uint8_t)(sliced ? shortest : 0);
    c->face[face].rows = sliced ? -(1 << level) : 1 << level;
    return sliced;
}

static void choose_levels(sl_coarse *c, const sl_coarse_settings *settings) {
    for (uint32_t face = 0; face < c->topology->face_count; face++) {
        c->level[face] = SL_COARSE_ABSENT;
        c->face[face].rows = 1;
        if (!is_wanted(c->scene, c->topology, face)) continue;
        bool sliced = cut(c, face, settings);
        for (int k = 0; k < 3; k++) {
            uint8_t *along = &c->edge_level[c->topology->edge[k][face]];
            if (sliced && k == c->turn[face / 2]) continue; /* the short edge stays whole */
            if (c->level[face] > *along) *along = c->level[face];
        }
    }
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* The k-th of n equal steps from the first to the second end of the edge opposite to a corner of the lattice;
 * on the edge, steps count from its lower site. */
static uint32_t vertex_on_edge(const sl_coarse *c, uint32_t face, int corner, int k, int n) {
    const sl_topology *t = c->topology;
    corner = (corner + c->turn[face / 2]) % 3;
    uint32_t edge = t->edge[corner][face];
    bool forwards = t->site[(corner + 1) % 3][face] <= t->site[(corner + 2) % 3][face];
    int steps = forwards ? k : n - k, finer = c->edge_level[edge] - c->level[face];
    return c->edge_vertex[edge] + (uint32_t)(steps << finer) - 1;
}

uint32_t sl_coarse_lattice_vertex(const sl_coarse *c, uint32_t face, int i, int j) {
    int n = sl_coarse_rows(c, face), h = n - i - j, turn = c->turn[face / 2];
    if (h == n) return c->site_vertex[c->topology->site[turn][face]];
    if (i == n) return c->site_vertex[c->topology->site[(1 + turn) % 3][face]];
    if (j == n) return c->site_vertex[c->topology->site[(2 + turn) % 3][face]];
    if (h == 0) return vertex_on_edge(c, face, 0, j, n);
    if (i == 0) return vertex_on_edge(c, face, 1, h, n);
    if (j == 0) return vertex_on_edge(c, face, 2, i, n);
    return c->inner_vertex[face] + (uint32_t)((j - 1) * (n - 1) - j * (j - 1) / 2 + i - 1);
}

/* Numbers in the order of first use. An edge's vertices are numbered all at once, by the first of the finest
 * faces along it: coarser ones use every second of them, every fourth, ... */
static size_t number_vertices(sl_coarse *c, const uint32_t *stand_in) {
    const sl_topology *t = c->topology;
    size_t count = 0;
    for (size_t s = 0; s < t->site_count; s++) c->site_vertex[s] = SL_NO_INDEX;
    for (size_t e = 0; e < t->edge_count; e++) c->edge_vertex[e] = SL_NO_INDEX;
    for (uint32_t face = 0; face < t->face_count; face++) {
        if (c->level[face] == SL_COARSE_ABSENT) continue;
        size_t n = (size_t)1 << c->level[face];
        for (int k = 0; k < 3; k++) {
            uint32_t *vertex = &c->site_vertex[stand_in[t->site[k][face]]];
            if (*vertex == SL_NO_INDEX) *vertex = (uint32_t)count++;
        }
        for (int k = 0; k < 3; k++) {
            uint32_t edge = t->edge[k][face], *vertex = &c->edge_vertex[edge];
            if (c->level[face] < c->edge_level[edge] || *vertex != SL_NO_INDEX) continue;
            if (sl_coarse_is_sliced(c, face) && k == c->turn[face / 2]) continue;
            *vertex = (uint32_t)count;
            count += n - 1;
        }
        c->inner_vertex[face] = (uint32_t)count;
        if (!sl_coarse_is_sliced(c, face)) count += (n - 1) * (n - 2) / 2;
        if (count >= SL_NO_INDEX) return SIZE_MAX;
    }
    for (size_t s = 0; s < t->site_count; s++) c->site_vertex[s] = c->site_vertex[stand_in[s]];
    return count;
}

/* The site at a lattice point; SL_NO_INDEX: there is none. */
static uint32_t site_at(const sl_coarse *c, uint32_t face, int i, int j) {
    int n = sl_coarse_rows(c, face), turn = c->turn[face / 2];
    if (i + j == 0) return c->topology->site[turn][face];
    if (i == n || j == n) return c->topology->site[(turn + (i == n ? 1 : 2)) % 3][face];
    return SL_NO_INDEX;
}

/* Each vertex by the first of the finest faces that have it; a cluster's where the site is that stands for
 * it. */
static void place_vertex(sl_coarse *c, const uint32_t *stand_in, uint32_t face, int i, int j) {
    sl_coarse_vertex *vertex = &c->vertex[sl_coarse_lattice_vertex(c, face, i, j)];
    uint32_t site = site_at(c, face, i, j);
    if (site != SL_NO_INDEX && stand_in[site] != site) return;
    if (vertex->face != SL_NO_INDEX && vertex->depth >= c->level[face]) return;
    int n = sl_coarse_rows(c, face), step = SL_MESH_DYADIC / n, turn = c->turn[face / 2];
    const int weight[3] = {n - i - j, i, j}; /* of the lattice's corners */
    *vertex = (sl_coarse_vertex){.face = face,
                                 .p = (uint16_t)(weight[(4 - turn) % 3] * step),
                                 .q = (uint16_t)(weight[(5 - turn) % 3] * step),
                                 .depth = c->level[face]};
}

static void place_vertices(sl_coarse *c, const uint32_t *stand_in) {
    for (size_t v = 0; v < c->vertex_count; v++) c->vertex[v].face = SL_NO_INDEX;
    for (uint32_t face = 0; face < c->topology->face_count; face++) {
        if (c->level[face] == SL_COARSE_ABSENT) continue;
        int n = sl_coarse_rows(c, face);
        for (int i = 0; sl_coarse_is_sliced(c, face) && i <= n; i++) {
            place_vertex(c, stand_in, face, i, 0);
            place_vertex(c, stand_in, face, 0, i);
        }
        for (int j = 0; !sl_coarse_is_sliced(c, face) && j <= n; j++) {
            for (int i = 0; i <= n - j; i++) place_vertex(c, stand_in, face, i, j);
        }
    }
}

/* ---- making it ------------------------------------------------------------------------------- */

/* After those that stand for absent faces and for nothing. */
static size_t number_triangles(sl_coarse *c) {
    size_t count = SL_COARSE_FIRST;
    for (uint32_t face = 0; face < c->topology->face_count; face++) {
        bool absent = c->level[face] == SL_COARSE_ABSENT;
        c->face[face].first = absent ? SL_COARSE_BLACK : (int32_t)count;
        if (!absent) count += (size_t)sl_coarse_triangles(c, face);
        /* kernels index floats by int32_t */
        if (count > (size_t)INT32_MAX / SL_COARSE_FLOATS) return SIZE_MAX;
    }
    for (size_t side = 0; side < 2; side++)
        c->face[c->topology->face_count + side] = (sl_coarse_face){SL_COARSE_NOTHING, 1};
    return count;
}

/* A constant environment is a colour like others. One that is a picture is looked up by direction. */
static void colour_nothing(sl_coarse *c) {
    const sl_environment *e = &c->scene->environment;
    if (!e->present || e->width > 0 || !sl_rgb_is_finite(e->constant)) return;
    float *colour = c->colour + SL_COARSE_NOTHING * SL_COARSE_FLOATS;
    colour[0] = e->constant.r;
    colour[1] = e->constant.g;
    colour[2] = e->constant.b;
}

static bool allocate_faces(sl_coarse *c) {
    const sl_topology *t = c->topology;
    c->level = sl_allocate(t->face_count, sizeof *c->level);
    c->turn = sl_allocate(t->face_count / 2, sizeof *c->turn);
    c->edge_level = sl_allocate(t->edge_count, sizeof *c->edge_level);
    c->site_vertex = sl_allocate(t->site_count, sizeof *c->site_vertex);
    c->edge_vertex = sl_allocate(t->edge_count, sizeof *c->edge_vertex);
    c->inner_vertex = sl_allocate(t->face_count, sizeof *c->inner_vertex);
    c->face = sl_allocate(t->face_count + 2, sizeof *c->face);
    c->block_brightest = sl_allocate(t->face_count / SL_COARSE_BLOCK + 1, sizeof *c->block_brightest);
    return c->level && c->turn && c->edge_level && c->site_vertex && c->edge_vertex && c->inner_vertex &&
           c->face && c->block_brightest;
}

static bool allocate_values(sl_coarse *c) {
    c->vertex = sl_allocate(c->vertex_count, sizeof *c->vertex);
    c->value = sl_allocate(c->vertex_count, sizeof *c->value);
    c->valid = sl_allocate(c->vertex_count, sizeof *c->valid);
    c->reflectance = sl_allocate(c->triangle_count, sizeof *c->reflectance);
    c->colour = sl_allocate(c->triangle_count, SL_COARSE_FLOATS * sizeof *c->colour);
    return c->vertex && c->value && c->valid && c->reflectance && c->colour;
}

static sl_status make_vertices(sl_coarse *c, const sl_coarse_settings *settings, uint32_t *stand_in,
                               sl_error *error) {
    double cell =
        fmin(CELL * (double)settings->edge, CELL_MOST * (double)sl_scene_central_diagonal(c->scene));
    sl_status status = sl_coarse_cluster(c, cell, stand_in, error);
    if (status != SL_OK) return status;
    c->vertex_count = number_vertices(c, stand_in);
    c->triangle_count = number_triangles(c);
    if (c->vertex_count == SIZE_MAX || c->triangle_count == SIZE_MAX) {
        return sl_fail(error, SL_ERROR_RESOURCES,
                       "the coarse mesh has too many triangles: raise its edge or lower its depth");
    }
    if (!allocate_values(c)) return sl_fail_memory(error, "the coarse mesh");
    place_vertices(c, stand_in);
    return sl_coarse_leave_borders(c, error);
}

static sl_status make(sl_coarse *c, const sl_coarse_settings *settings, sl_error *error) {
    if (settings->depth < 0 || settings->depth > SL_MESH_DEPTH_MAX || !(settings->edge >= 0.0f)) {
        return sl_fail(error, SL_ERROR_USAGE, "coarse mesh: depth must be 0 to %d and edge not negative",
                       SL_MESH_DEPTH_MAX);
    }
    if (!allocate_faces(c)) return sl_fail_memory(error, "the coarse mesh's faces");
    choose_levels(c, settings);
    uint32_t *stand_in = sl_allocate(c->topology->site_count, sizeof *stand_in);
    sl_status status =
        stand_in ? make_vertices(c, settings, stand_in, error) : sl_fail_memory(error, "the coarse mesh");
    sl_free(stand_in);
    if (status == SL_OK) colour_nothing(c);
    return status;
}

sl_status sl_coarse_create(const sl_scene *scene, const sl_topology *topology,
                           const sl_coarse_settings *settings, sl_coarse **coarse, sl_error *error) {
    *coarse = NULL;
    sl_coarse *c = sl_allocate(1, sizeof *c);
    if (!c) return sl_fail_memory(error, "the coarse mesh");
    c->scene = scene;
    c->topology = topology;
    c->edge = settings->edge;
    sl_status status = make(c, settings, error);
    if (status == SL_OK) *coarse = c;
    else sl_coarse_destroy(c);
    return status;
}

void sl_coarse_destroy(sl_coarse *c) {
    if (!c) return;
    void *blocks[] = {c->level,        c->turn,   c->edge_level,     c->site_vertex, c->edge_vertex,
                      c->inner_vertex, c->vertex, c->value,          c->valid,       c->face,
                      c->reflectance,  c->colour, c->block_brightest};
    for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++) sl_free(blocks[k]);
    sl_free(c);
}

size_t sl_coarse_memory_bytes(const sl_coarse *c) {
    const sl_topology *t = c->topology;
    size_t by_face = sizeof *c->level + sizeof *c->inner_vertex + sizeof *c->face,
           by_edge = sizeof *c->edge_level + sizeof *c->edge_vertex;
    size_t by_vertex = sizeof *c->vertex + sizeof *c->value + sizeof *c->valid;
    size_t by_triangle = sizeof *c->reflectance + SL_COARSE_FLOATS * sizeof *c->colour;
    return sizeof *c + t->face_count / 2 * sizeof *c->turn + t->face_count * by_face +
           t->edge_count * by_edge + t->site_count * sizeof *c->site_vertex + c->vertex_count * by_vertex +
           c->triangle_count * by_triangle;
}

size_t sl_coarse_vertex_count(const sl_coarse *c) { return c->vertex_count; }
size_t sl_coarse_triangle_count(const sl_coarse *c) { return c->triangle_count; }
const sl_coarse_vertex *sl_coarse_vertices(const sl_coarse *c) { return c->vertex; }
