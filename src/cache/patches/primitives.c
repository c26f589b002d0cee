/* Primitives of the patch hierarchy: the scene's triangles, the parallelograms that importers cut in two, and
 * its bicubic patches. */
#include "cache/patches/primitives.h"

#include <math.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/primitive_parts.h"
#include "scene/ambient.h"

static const float SAME_NORMAL = 1e-4f;
static const double SAME_SIZE = 1e-5; /* of a parallelogram's */

/* ---- parallelograms -------------------------------------------------------------------------- */

static bool same_place(const sl_scene *s, uint32_t a, uint32_t b) {
    return a == b || (s->position_x[a] == s->position_x[b] && s->position_y[a] == s->position_y[b] &&
                      s->position_z[a] == s->position_z[b]);
}

bool sl_same_normal(sl_vec3 a, sl_vec3 b) {
    return fabsf(a.x - b.x) <= SAME_NORMAL && fabsf(a.y - b.y) <= SAME_NORMAL &&
           fabsf(a.z - b.z) <= SAME_NORMAL;
}

static bool has_texture(const sl_scene *s, uint32_t triangle) {
    const sl_material *m = sl_triangle_material(s, triangle);
    return m->texture != SL_NO_INDEX || m->alpha_texture != SL_NO_INDEX;
}

/* a + c = b + d where 0, 2 and 1, 3 are opposite each other; `size` is what differences are small against. */
static bool affine(double a, double b, double c, double d, double size) {
    return fabs(a + c - b - d) <= SAME_SIZE * size;
}

static bool is_parallelogram(const sl_scene *s, const uint32_t c[4]) {
    sl_vec3d p[4];
    for (int i = 0; i < 4; i++) p[i] = sl_to_double(sl_scene_position(s, c[i]));
    double size = fmax(sl_lengthd(sl_subd(p[2], p[0])), sl_lengthd(sl_subd(p[3], p[1])));
    sl_vec3d gap = sl_subd(sl_addd(p[0], p[2]), sl_addd(p[1], p[3]));
    return sl_lengthd(gap) <= SAME_SIZE * size;
}

static bool is_affine_texture(const sl_scene *s, const uint32_t c[4]) {
    double size = 0.0;
    for (int i = 1; i < 4; i++) {
        size = fmax(size, fabs((double)s->texture_u[c[i]] - (double)s->texture_u[c[0]]));
        size = fmax(size, fabs((double)s->texture_v[c[i]] - (double)s->texture_v[c[0]]));
    }
    return affine((double)s->texture_u[c[0]], (double)s->texture_u[c[1]], (double)s->texture_u[c[2]],
                  (double)s->texture_u[c[3]], size) &&
           affine((double)s->texture_v[c[0]], (double)s->texture_v[c[1]], (double)s->texture_v[c[2]],
                  (double)s->texture_v[c[3]], size);
}

static bool same_attributes(const sl_scene *s, uint32_t a, uint32_t b, bool texture) {
    if (a == b) return true;
    if (!same_place(s, a, b) || !sl_same_normal(sl_scene_normal(s, a), sl_scene_normal(s, b))) return false;
    return !texture || (fabsf(s->texture_u[a] - s->texture_u[b]) <= 1e-5f &&
                        fabsf(s->texture_v[a] - s->texture_v[b]) <= 1e-5f);
}

/* Corners of triangles t and t + 1 as a quadrilateral whose diagonal, which they share, runs from corner 0 to
 * 2: t holds corners 0 1 2, t + 1 corners 0 2 3. turn: 3 (which of t is corner 2) + which of t + 1 is corner
 * 0. */
static uint32_t quad_corner(const sl_scene *s, uint32_t t, int turn, int corner) {
    if (corner == 3) return s->vertex[(turn % 3 + 2) % 3][t + 1];
    return s->vertex[(turn / 3 + corner + 1) % 3][t];
}

static bool find_quad(const sl_scene *s, uint32_t t, int *turn) {
    uint32_t n = t + 1;
    if (s->material_index[t] != s->material_index[n] || s->object_index[t] != s->object_index[n])
        return false;
    /* Thin ones whose halves' normals have drowned in rounding stay two triangles. */
    if (!(sl_dot(sl_scene_geometric_normal(s, t), sl_scene_geometric_normal(s, n)) > 0.9999f)) return false;
    bool texture = has_texture(s, t);
    for (*turn = 0; *turn < 9; ++*turn) {
        const int i = *turn / 3, j = *turn % 3;
        uint32_t from = s->vertex[i][t], to = s->vertex[(i + 1) % 3][t]; /* corners 2 and 0 */
        uint32_t other_to = s->vertex[j][n], other_from = s->vertex[(j + 1) % 3][n], corner[4];
        if (!same_place(s, from, other_from) || !same_place(s, to, other_to)) continue;
        for (int c = 0; c < 4; c++) corner[c] = quad_corner(s, t, *turn, c);
        return same_attributes(s, from, other_from, texture) && same_attributes(s, to, other_to, texture) &&
               is_parallelogram(s, corner) && (!texture || is_affine_texture(s, corner));
    }
    return false;
}

/* ---- all primitives -------------------------------------------------------------------------- */

static uint32_t bicubic_corner(const sl_bicubic *b, int corner) {
    const uint32_t n = (uint32_t)b->steps, side = n + 1;
    return b->first_vertex + (corner == 1 || corner == 2 ? n : 0) + (corner >= 2 ? side * n : 0);
}

uint32_t sl_primitive_corner(const sl_primitives *p, uint32_t primitive, int corner) {
    const uint32_t t = p->first_triangle[primitive];
    switch ((sl_primitive_kind)p->kind[primitive]) {
    case SL_PRIMITIVE_QUAD: return quad_corner(p->scene, t, p->turn[primitive], corner);
    case SL_PRIMITIVE_BICUBIC: return bicubic_corner(&p->scene->bicubics[p->bicubic[primitive]], corner);
    case SL_PRIMITIVE_TRIANGLE: break;
    }
    return corner < 3 ? p->scene->vertex[corner][t] : SL_NO_INDEX;
}

uint32_t sl_primitive_triangles(const sl_primitives *p, uint32_t primitive) {
    if (p->kind[primitive] == SL_PRIMITIVE_BICUBIC)
        return p->scene->bicubics[p->bicubic[primitive]].triangle_count;
    return p->kind[primitive] == SL_PRIMITIVE_QUAD ? 2 : 1;
}

/* Adds one and returns how many triangles it has. */
static uint32_t add(sl_primitives *p, sl_primitive_kind kind, uint32_t first, int turn, uint32_t bicubic) {
    const uint32_t at = (uint32_t)p->count++;
    p->kind[at] = (uint8_t)kind;
    p->turn[at] = (uint8_t)turn;
    p->first_triangle[at] = first;
    if (p->bicubic) p->bicubic[at] = bicubic;
    p->curved += kind == SL_PRIMITIVE_BICUBIC;
    const uint32_t triangles = sl_primitive_triangles(p, at);
    for (uint32_t t = 0; t < triangles; t++) p->of_triangle[first + t] = at;
    return triangles;
}

static void find_all(sl_primitives *p, bool triangles) {
    const sl_scene *s = p->scene;
    uint32_t bicubic = 0, count = (uint32_t)s->triangle_count;
    for (uint32_t t = 0; t < count;) {
        const uint32_t next = bicubic < s->bicubic_count ? s->bicubics[bicubic].first_triangle : count;
        int turn;
        if (t == next && !triangles) t += add(p, SL_PRIMITIVE_BICUBIC, t, 0, bicubic++);
        else if (t + 1 < next && !triangles && find_quad(s, t, &turn))
            t += add(p, SL_PRIMITIVE_QUAD, t, turn, SL_NO_INDEX);
        else t += add(p, SL_PRIMITIVE_TRIANGLE, t, 0, SL_NO_INDEX);
    }
}

/* ---- k_d averaged over textures -------------------------------------------------------------- */

/* On 8 x 8 points, which a triangle folds into itself. */
static sl_rgb average_diffuse(const sl_primitives *p, uint32_t primitive) {
    enum { SIDE = 8 };
    bool triangle = p->kind[primitive] == SL_PRIMITIVE_TRIANGLE;
    double sum[3] = {0, 0, 0};
    for (int k = 0; k < SIDE * SIDE; k++) {
        double u = ((double)(k % SIDE) + 0.5) / SIDE, v = ((double)(k / SIDE) + 0.25) / SIDE;
        bool fold = triangle && u + v > 1.0;
        float w1, w2;
        uint32_t t = sl_root_triangle_at(p, 2 * primitive, fold ? 1.0 - u : u, fold ? 1.0 - v : v, &w1, &w2);
        sl_sum_colour(sum, 1.0, sl_scene_diffuse(p->scene, t, w1, w2));
    }
    return sl_sum_over(sum, SIDE * SIDE);
}

sl_rgb sl_root_mean_diffuse(const sl_primitives *p, uint32_t root) {
    return p->mean_diffuse ? p->mean_diffuse[root / 2] : sl_root_material(p, root)->diffuse;
}

/* ---- life ------------------------------------------------------------------------------------ */

static bool allocate_arrays(sl_primitives *p) {
    const size_t most = p->scene->triangle_count;
    const bool curved = p->scene->bicubic_count > 0;
    if (curved) p->bicubic = sl_allocate(most, sizeof *p->bicubic);
    p->first_triangle = sl_allocate(most, sizeof *p->first_triangle);
    p->of_triangle = sl_allocate(most, sizeof *p->of_triangle);
    p->kind = sl_allocate(most, 1);
    p->turn = sl_allocate(most, 1);
    return p->first_triangle && p->of_triangle && p->kind && p->turn && (p->bicubic || !curved);
}

static sl_status find(sl_primitives *p, bool triangles, sl_error *error) {
    const sl_scene *scene = p->scene;
    if (!allocate_arrays(p)) return sl_fail_memory(error, "primitives");
    find_all(p, triangles);
    if (!triangles && scene->texture_count) {
        p->mean_diffuse = sl_allocate(p->count, sizeof *p->mean_diffuse);
        if (!p->mean_diffuse) return sl_fail_memory(error, "primitives");
    }
    sl_status status = sl_solids_find(scene, &p->solids, error);
    if (status == SL_OK) status = sl_primitives_join(p, error);
    for (size_t i = 0; status == SL_OK && p->mean_diffuse && i < p->count; i++) {
        uint32_t material = scene->material_index[p->first_triangle[i]];
        bool plain = scene->materials[material].texture == SL_NO_INDEX;
        p->mean_diffuse[i] = plain ? scene->materials[material].diffuse : average_diffuse(p, (uint32_t)i);
    }
    return status;
}

static sl_status make(const sl_scene *scene, bool triangles, sl_primitives **primitives, sl_error *error) {
    *primitives = NULL;
    if (scene->triangle_count >= SL_NO_INDEX / 8)
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %u triangles", SL_NO_INDEX / 8);
    sl_primitives *made = sl_allocate(1, sizeof *made);
    if (!made) return sl_fail_memory(error, "primitives");
    made->scene = scene;
    sl_status status = find(made, triangles, error);
    if (status == SL_OK) *primitives = made;
    else sl_primitives_destroy(made);
    return status;
}

sl_status sl_primitives_find(const sl_scene *scene, sl_primitives **primitives, sl_error *error) {
    return make(scene, false, primitives, error);
}

sl_status sl_primitives_of_triangles(const sl_scene *scene, sl_primitives **primitives, sl_error *error) {
    return make(scene, true, primitives, error);
}

bool sl_triangle_is_degenerate(const sl_scene *scene, uint32_t triangle) {
    const double least = 1e-12 * (double)scene->scale * (double)scene->scale,
                 area = sl_triangle_area(scene, triangle);
    return !(area >= least && area > 0.0);
}

void sl_primitives_destroy(sl_primitives *p) {
    if (!p) return;
    sl_solids_destroy(p->solids);
    SL_FREE_ALL(p->kind, p->turn, p->first_triangle, p->bicubic, p->of_triangle, p->mean_diffuse,
                p->edge_next, p->corner_first, p->corner_next, p->edge_kind, p);
}

size_t sl_primitives_memory_bytes(const sl_primitives *p) {
    size_t by_triangle = (p->bicubic ? 3 : 2) * sizeof(uint32_t) + 2,
           by_primitive = 4 * (3 * sizeof(uint32_t) + 1);
    return sizeof *p + p->scene->triangle_count * by_triangle +
           p->count * (by_primitive + (p->mean_diffuse ? sizeof(sl_rgb) : 0));
}
