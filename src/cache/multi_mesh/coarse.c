/* The coarse mesh: which faces it has, how finely they are cut, and its vertices, each listed once. */
#include "cache/multi_mesh/coarse.h"

#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "scene/ambient.h"

/* ---- what is to be sampled ------------------------------------------------------------------- */

/* Tells whether light that leaves this face can be seen, and any leaves it. */
static bool is_wanted(const sl_scene *scene, const sl_primitives *primitives, uint32_t face) {
    uint32_t triangle = face / 2;
    if (sl_triangle_is_degenerate(scene, triangle)) return false;
    if (face % 2 == 1 && sl_solids_hide_back(primitives->solids, triangle)) return false;
    return sl_material_is_diffuse(sl_triangle_material(scene, triangle));
}

static double longest_edge(const sl_scene *scene, uint32_t triangle) {
    sl_vec3d p[3];
    double longest = 0.0;
    for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle]));
    for (int k = 0; k < 3; k++) longest = fmax(longest, sl_lengthd(sl_subd(p[(k + 1) % 3], p[k])));
    return longest;
}

static void choose_levels(sl_coarse *c, float edge, int depth) {
    for (uint32_t face = 0; face < c->face_count; face++) {
        int level = 0;
        c->level[face] = SL_COARSE_ABSENT;
        c->face[face].rows = 1;
        if (!is_wanted(c->scene, c->primitives, face)) continue;
        double longest = longest_edge(c->scene, face / 2);
        for (; level < depth && longest > (double)edge; level++) longest *= 0.5;
        c->level[face] = (uint8_t)level;
        c->face[face].rows = 1 << level;
    }
}

/* ---- vertices -------------------------------------------------------------------------------- */

static sl_root_place lattice_place(const sl_coarse *c, uint32_t face, int i, int j) {
    int step = SL_PATCH_DYADIC / c->face[face].rows;
    return (sl_root_place){face, (uint16_t)(i * step), (uint16_t)(j * step)};
}

uint32_t sl_coarse_lattice_vertex(const sl_coarse *c, uint32_t face, int i, int j) {
    return sl_vertex_find(c->vertices, lattice_place(c, face, i, j));
}

/* Numbers them in the order of first use. */
static sl_status number_vertices(sl_coarse *c, sl_error *error) {
    sl_status status = SL_OK;
    for (uint32_t face = 0; face < c->face_count; face++) {
        int n = c->face[face].rows;
        for (int j = 0; c->level[face] != SL_COARSE_ABSENT && j <= n; j++)
            for (int i = 0; i <= n - j && status == SL_OK; i++)
                sl_vertex_make(c->vertices, lattice_place(c, face, i, j), &status, error);
    }
    c->vertex_count = c->vertices->vertex_count;
    return status;
}

/* Weights of 0 grow by a sixth of a coarse triangle's, half-way to its middle. Things meet at rims, and
 * corners there are darker than what lies between them, or stick in the next thing altogether. Gathers see
 * areas, of which such corners tell nothing (in the cathedral, with coarse triangles of two metres, a quarter
 * of all light). */
sl_root_place sl_coarse_lit_place(const sl_coarse *c, size_t vertex) {
    const sl_root_place at = c->vertex[vertex];
    const int step = SL_PATCH_DYADIC / (6 * c->face[at.root].rows);
    int weight[3] = {SL_PATCH_DYADIC - at.u - at.v, at.u, at.v}, zeros = 0, sum = 0;
    for (int k = 0; k < 3; k++) zeros += weight[k] == 0;
    for (int k = 0; k < 3; k++) {
        weight[k] = weight[k] == 0 ? step : weight[k] - zeros * step / (3 - zeros);
        sum += weight[k];
    }
    int most = weight[1] > weight[0] ? 1 : 0;
    if (weight[2] > weight[most]) most = 2;
    weight[most] += SL_PATCH_DYADIC - sum; /* halves of odd steps */
    return (sl_root_place){at.root, (uint16_t)weight[1], (uint16_t)weight[2]};
}

static void place_vertex(sl_coarse *c, uint32_t face, int i, int j) {
    sl_root_place *vertex = &c->vertex[sl_coarse_lattice_vertex(c, face, i, j)];
    bool finer = vertex->root == SL_NO_INDEX || c->level[vertex->root] < c->level[face];
    if (finer) *vertex = lattice_place(c, face, i, j);
}

static void place_vertices(sl_coarse *c) {
    for (size_t v = 0; v < c->vertex_count; v++) c->vertex[v].root = SL_NO_INDEX;
    for (uint32_t face = 0; face < c->face_count; face++) {
        int n = c->face[face].rows;
        for (int j = 0; c->level[face] != SL_COARSE_ABSENT && j <= n; j++)
            for (int i = 0; i <= n - j; i++) place_vertex(c, face, i, j);
    }
}

/* Returns of how many coarse triangles of a face a lattice point is a corner. */
static int corners_at(int n, int i, int j) {
    static const int by_sides[3] = {6, 3, 1};
    return by_sides[(i == 0) + (j == 0) + (i + j == n)];
}

void sl_coarse_areas(const sl_coarse *c, float *area) {
    for (size_t v = 0; v < c->vertex_count; v++) area[v] = 0.0f;
    for (uint32_t face = 0; face < c->face_count; face++) {
        if (c->level[face] == SL_COARSE_ABSENT) continue;
        const int n = c->face[face].rows;
        const double third = sl_triangle_area(c->scene, face / 2) / (3.0 * n * n);
        for (int j = 0; j <= n; j++)
            for (int i = 0; i <= n - j; i++)
                area[sl_coarse_lattice_vertex(c, face, i, j)] += (float)(corners_at(n, i, j) * third);
    }
}

/* ---- making it ------------------------------------------------------------------------------- */

/* After those that stand for absent faces and for nothing. */
static size_t number_triangles(sl_coarse *c) {
    size_t count = SL_COARSE_FIRST;
    for (uint32_t face = 0; face < c->face_count; face++) {
        bool absent = c->level[face] == SL_COARSE_ABSENT;
        c->face[face].first = absent ? SL_COARSE_BLACK : (int32_t)count;
        if (!absent) count += (size_t)1 << 2 * c->level[face];
        /* kernels index floats by int32_t */
        if (count > (size_t)INT32_MAX / SL_LATTICE_FLOATS) return SIZE_MAX;
    }
    for (size_t side = 0; side < 2; side++)
        c->face[c->face_count + side] = (sl_face_lattice){SL_COARSE_NOTHING, 1};
    return count;
}

/* A constant environment is a colour like others. One that is a picture is looked up by direction. */
static void colour_nothing(sl_coarse *c) {
    const sl_environment *e = &c->scene->environment;
    if (!e->present || e->width > 0 || !sl_rgb_is_finite(e->constant)) return;
    float *colour = c->colour + SL_COARSE_NOTHING * SL_LATTICE_FLOATS;
    colour[0] = e->constant.r;
    colour[1] = e->constant.g;
    colour[2] = e->constant.b;
}

static bool allocate_faces(sl_coarse *c) {
    size_t faces = c->face_count;
    c->level = sl_allocate(faces, sizeof *c->level);
    c->face = sl_allocate(faces + 2, sizeof *c->face);
    return c->level && c->face;
}

static bool allocate_values(sl_coarse *c) {
    c->vertex = sl_allocate(c->vertex_count, sizeof *c->vertex);
    if (c->scene->texture_count) c->reflectance = sl_allocate(c->triangle_count, sizeof *c->reflectance);
    c->colour = sl_allocate(c->triangle_count, SL_LATTICE_FLOATS * sizeof *c->colour);
    return c->vertex && (c->reflectance || !c->scene->texture_count) && c->colour;
}

static sl_status make(sl_coarse *c, float edge, int depth, sl_error *error) {
    if (!allocate_faces(c)) return sl_fail_memory(error, "the coarse mesh's faces");
    choose_levels(c, edge, depth);
    c->triangle_count = number_triangles(c);
    if (c->triangle_count == SIZE_MAX)
        return sl_fail(error, SL_ERROR_RESOURCES,
                       "the coarse mesh has too many triangles: raise its edge or lower its depth");
    const sl_patches_settings vertices = {.channels = 3, .max_depth = SL_MESH_DEPTH_MAX};
    sl_status status = sl_patches_create(c->primitives, &vertices, &c->vertices, error);
    if (status == SL_OK) status = number_vertices(c, error);
    if (status != SL_OK) return status;
    if (!allocate_values(c)) return sl_fail_memory(error, "the coarse mesh");
    place_vertices(c);
    colour_nothing(c);
    return SL_OK;
}

sl_status sl_coarse_create(const sl_scene *scene, const sl_primitives *primitives, float edge, int depth,
                           sl_coarse **coarse, sl_error *error) {
    *coarse = NULL;
    sl_coarse *c = sl_allocate(1, sizeof *c);
    if (!c) return sl_fail_memory(error, "the coarse mesh");
    c->scene = scene;
    c->primitives = primitives;
    c->face_count = 2 * primitives->count;
    sl_status status = make(c, edge, depth, error);
    if (status == SL_OK) *coarse = c;
    else sl_coarse_destroy(c);
    return status;
}

void sl_coarse_destroy(sl_coarse *c) {
    if (!c) return;
    sl_patches_destroy(c->vertices);
    SL_FREE_ALL(c->level, c->vertex, c->face, c->reflectance, c->colour, c);
}

size_t sl_coarse_memory_bytes(const sl_coarse *c) {
    size_t by_triangle =
        (c->reflectance ? sizeof *c->reflectance : 0) + SL_LATTICE_FLOATS * sizeof *c->colour;
    return sizeof *c + c->face_count * (sizeof *c->level + sizeof *c->face) +
           sl_patches_memory_bytes(c->vertices) + c->vertex_count * sizeof *c->vertex +
           c->triangle_count * by_triangle;
}

/* The coarse mesh's colours: what bounces off it, k_d(x') U_dd(x'). The paper's equation (7) lacks k_d(x'),
 * without which no colour would bleed and indirect light would be too bright by 1 / k_d. */

enum { FACES_A_TASK = 512 };

/* A coarse triangle of a face: its lattice corners. */
typedef struct place {
    int i[3], j[3];
} place;

static place place_of(int i, int j, int on_head) {
    if (on_head) return (place){{i + 1, i, i + 1}, {j + 1, j + 1, j}};
    return (place){{i, i + 1, i}, {j, j, j + 1}};
}

/* products and sums of N^2 of them stay finite when scaled by weights */
static const float VALUE_MAX = 1e30f;

static float sane(float value) { return value > 0.0f ? (value < VALUE_MAX ? value : VALUE_MAX) : 0.0f; }

void sl_coarse_set(sl_coarse *c, size_t vertex, sl_rgb value) {
    float *of = sl_vertex_value(c->vertices, (uint32_t)vertex);
    bool finite = sl_rgb_is_finite(value);
    sl_mesh_set_state(c->vertices, (uint32_t)vertex, finite ? SL_VERTEX_KNOWN : SL_VERTEX_INVALID);
    of[0] = finite ? sane(value.r) : 0.0f;
    of[1] = finite ? sane(value.g) : 0.0f;
    of[2] = finite ? sane(value.b) : 0.0f;
}

/* ---- reflectance ----------------------------------------------------------------------------- */

enum { SAMPLES_MAX = 16 }; /* squared: a texture's samples in a coarse triangle */

/* As many steps along an edge as make a sample of each texel. */
static int samples_along(const sl_scene *scene, uint32_t triangle, int parts) {
    const sl_material *m = sl_triangle_material(scene, triangle);
    if (m->texture == SL_NO_INDEX) return 1;
    const sl_texture *texture = &scene->textures[m->texture];
    double u[3], v[3];
    for (int k = 0; k < 3; k++) {
        u[k] = (double)scene->texture_u[scene->vertex[k][triangle]];
        v[k] = (double)scene->texture_v[scene->vertex[k][triangle]];
    }
    double area = fabs((u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0])) * texture->width *
                  texture->height;
    double along = sqrt(0.5 * area / parts);
    return along < SAMPLES_MAX ? 1 + (int)along : SAMPLES_MAX; /* NaN: the most */
}

/* Returns the mean k_d of a coarse triangle, at the middles of m x m equal triangles, as far as the alpha
 * mask lets one see them. */
static sl_rgb mean_reflectance(const sl_coarse *c, uint32_t face, const place *p, int m) {
    const sl_scene *scene = c->scene;
    uint32_t triangle = face / 2;
    int rows = c->face[face].rows;
    double sum[3] = {0.0, 0.0, 0.0}, count = 0.0;
    for (int s = 0; s < m * m; s++) {
        int j = 0, at = s;
        for (; at >= 2 * (m - j) - 1; j++) at -= 2 * (m - j) - 1;
        double third = at % 2 ? 2.0 / 3.0 : 1.0 / 3.0, x = (at / 2 + third) / m, y = (j + third) / m;
        double u = (p->i[0] + x * (p->i[1] - p->i[0]) + y * (p->i[2] - p->i[0])) / rows;
        double v = (p->j[0] + x * (p->j[1] - p->j[0]) + y * (p->j[2] - p->j[0])) / rows;
        float w1 = (float)u, w2 = (float)v;
        if (!sl_scene_is_opaque(scene, triangle, w1, w2)) continue;
        sl_sum_colour(sum, 1.0, sl_scene_diffuse_nearest(scene, triangle, w1, w2));
        count += 1.0;
    }
    if (!(count > 0.0)) return sl_grey(0.0f); /* all of it is holes */
    const sl_rgb mean = sl_sum_over(sum, count);
    return (sl_rgb){sane(mean.r), sane(mean.g), sane(mean.b)};
}

/* ---- colours --------------------------------------------------------------------------------- */

/* Gives U_dd at a coarse triangle's corners; where one has none, the mean of the others. */
static void corner_values(const sl_coarse *c, uint32_t face, const place *p, sl_rgb value[3]) {
    sl_rgb sum = sl_grey(0.0f);
    int valid[3], count = 0;
    for (int k = 0; k < 3; k++) {
        uint32_t vertex = sl_coarse_lattice_vertex(c, face, p->i[k], p->j[k]);
        const float *of = sl_vertex_value(c->vertices, vertex);
        valid[k] = sl_mesh_state(c->vertices, vertex) == SL_VERTEX_KNOWN;
        value[k] = (sl_rgb){of[0], of[1], of[2]};
        if (valid[k]) sum = sl_rgb_add(sum, value[k]);
        count += valid[k];
    }
    sl_rgb mean = sl_rgb_scale(sum, count ? 1.0f / (float)count : 0.0f);
    for (int k = 0; k < 3; k++) value[k] = valid[k] ? value[k] : mean;
}

static void finish_triangle(sl_coarse *c, uint32_t face, const place *p, size_t at, int samples) {
    const bool known = c->reflectance && c->reflectance_known;
    const sl_rgb reflectance = known ? c->reflectance[at] : mean_reflectance(c, face, p, samples);
    if (c->reflectance) c->reflectance[at] = reflectance;
    sl_rgb colour[3];
    corner_values(c, face, p, colour);
    float *out = c->colour + at * SL_LATTICE_FLOATS;
    for (int k = 0; k < 3; k++) {
        colour[k] = sl_rgb_mul(colour[k], reflectance);
        sl_rgb rgb = k ? sl_rgb_sub(colour[k], colour[0]) : colour[0];
        out[3 * k] = rgb.r;
        out[3 * k + 1] = rgb.g;
        out[3 * k + 2] = rgb.b;
    }
}

static void finish_face(sl_coarse *c, uint32_t face) {
    int n = c->face[face].rows,
        samples = c->reflectance && c->reflectance_known ? 0 : samples_along(c->scene, face / 2, n * n);
    size_t at = (size_t)c->face[face].first;
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < 2 * (n - j) - 1; k++) {
            place p = place_of(k / 2, j, k % 2);
            finish_triangle(c, face, &p, at++, samples);
        }
    }
}

static void finish_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    sl_coarse *c = context;
    size_t end = (task + 1) * FACES_A_TASK;
    for (size_t face = task * FACES_A_TASK; face < end && face < c->face_count; face++)
        if (c->level[face] != SL_COARSE_ABSENT) finish_face(c, (uint32_t)face);
}

void sl_coarse_finish(sl_coarse *c, unsigned threads) {
    size_t tasks = (c->face_count + FACES_A_TASK - 1) / FACES_A_TASK;
    sl_parallel_for(sl_thread_count(threads), tasks, finish_some, c);
    c->reflectance_known = true;
}

sl_rgb sl_coarse_brightest(const sl_coarse *c) {
    float most[3] = {0.0f, 0.0f, 0.0f};
    for (size_t t = SL_COARSE_FIRST; t < c->triangle_count; t++) {
        const float *colour = c->colour + t * SL_LATTICE_FLOATS;
        for (int k = 0; k < 3; k++) {
            float more = colour[3 + k] > colour[6 + k] ? colour[3 + k] : colour[6 + k],
                  value = colour[k] + (more > 0.0f ? more : 0.0f);
            most[k] = value > most[k] ? value : most[k];
        }
    }
    return (sl_rgb){most[0], most[1], most[2]};
}
