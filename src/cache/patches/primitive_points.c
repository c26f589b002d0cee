/* Points of roots: from (u, v) to the scene's triangles and back. */
#include "cache/patches/primitive_parts.h"
#include "scene/bicubic.h"
#include "scene/surface_rules.h"

/* ---- corners and edges ----------------------------------------------------------------------- */

void sl_edge_point(int corners, int edge, uint32_t t, uint32_t *u, uint32_t *v) {
    const uint32_t one = SL_PATCH_DYADIC;
    if (corners == 3) {
        *u = edge == 0 ? t : edge == 1 ? one - t : 0;
        *v = edge == 0 ? 0 : edge == 1 ? t : one - t;
    } else {
        *u = edge == 0 ? t : edge == 1 ? one : edge == 2 ? one - t : 0;
        *v = edge == 0 ? 0 : edge == 1 ? t : edge == 2 ? one : one - t;
    }
}

int sl_edge_at(int corners, uint32_t u, uint32_t v, uint32_t *t) {
    const uint32_t one = SL_PATCH_DYADIC;
    if (v == 0 && u < one) return *t = u, 0;
    if (corners == 3) {
        if (u + v == one && v < one) return *t = v, 1;
        if (u == 0) return *t = one - v, 2;
    } else {
        if (u == one && v < one) return *t = v, 1;
        if (v == one && u > 0) return *t = one - u, 2;
        if (u == 0) return *t = one - v, 3;
    }
    return -1;
}

/* ---- triangles of quads and of bicubic patches ----------------------------------------------- */

/* Gives weights of a triangle's three corners, the first of which is its corner number `first`, as weights of
 * corners 1 and 2. */
static void turn(int first, const double weight[3], float *w1, float *w2) {
    *w1 = (float)weight[(1 - first + 3) % 3];
    *w2 = (float)weight[(2 - first + 3) % 3];
}

/* Returns which corner of a triangle is a vertex. */
static int corner_number(const sl_scene *s, uint32_t triangle, uint32_t vertex) {
    return s->vertex[0][triangle] == vertex ? 0 : s->vertex[1][triangle] == vertex ? 1 : 2;
}

/* Halves of a square, cut from (0, 0) to (1, 1): half 0 is (0,0) (1,0) (1,1), half 1 is (0,0) (1,1) (0,1). */
static int half_at(double u, double v, double weight[3]) {
    int half = u >= v ? 0 : 1;
    weight[0] = half == 0 ? 1.0 - u : 1.0 - v;
    weight[1] = half == 0 ? u - v : u;
    weight[2] = half == 0 ? v : v - u;
    return half;
}

static uint32_t quad_triangle_at(const sl_primitives *p, uint32_t primitive, double u, double v, float *w1,
                                 float *w2) {
    double weight[3];
    int half = half_at(u, v, weight);
    uint32_t triangle = p->first_triangle[primitive] + (uint32_t)half;
    turn(sl_quad_first(p, primitive, half), weight, w1, w2);
    return triangle;
}

static bool same_point(const sl_scene *s, uint32_t a, uint32_t b) {
    sl_vec3 p = sl_scene_position(s, a), q = sl_scene_position(s, b);
    return p.x == q.x && p.y == q.y && p.z == q.z;
}

/* Returns the other half's triangle. A half without area is a line, an edge of that: its corner that the
 * other does not have gives its weight to the one where it lies. */
static uint32_t other_half(const sl_primitives *p, const sl_bicubic *b, int column, int row, int missing,
                           double weight[3]) {
    uint32_t triangle = sl_bicubic_triangle(p->scene, b, column, row, 1 - missing);
    if (triangle == SL_NO_INDEX) return SL_NO_INDEX;
    uint32_t side = (uint32_t)b->steps + 1,
             origin = b->first_vertex + (uint32_t)row * side + (uint32_t)column;
    uint32_t lonely = missing == 0 ? origin + 1 : origin + side;
    double at_origin = weight[0], at_lonely = weight[missing == 0 ? 1 : 2],
           opposite = weight[missing == 0 ? 2 : 1];
    if (same_point(p->scene, lonely, origin)) at_origin += at_lonely;
    else opposite += at_lonely;
    weight[0] = at_origin;
    weight[1] = missing == 0 ? opposite : 0.0;
    weight[2] = missing == 0 ? 0.0 : opposite;
    return triangle;
}

static uint32_t bicubic_triangle_at(const sl_primitives *p, uint32_t primitive, double u, double v, float *w1,
                                    float *w2) {
    const sl_bicubic *b = &p->scene->bicubics[p->bicubic[primitive]];
    double x = u * (double)b->steps, y = v * (double)b->steps, weight[3];
    int column = (int)x < b->steps ? (int)x : b->steps - 1, row = (int)y < b->steps ? (int)y : b->steps - 1;
    int half = half_at(x - (double)column, y - (double)row, weight);
    uint32_t triangle = sl_bicubic_triangle(p->scene, b, column, row, half);
    if (triangle == SL_NO_INDEX) {
        triangle = other_half(p, b, column, row, half, weight);
        half = 1 - half;
    }
    if (triangle == SL_NO_INDEX) { /* the whole cell is a line: some point of the surface */
        *w1 = *w2 = 0.0f;
        return b->first_triangle;
    }
    uint32_t origin = b->first_vertex + (uint32_t)row * ((uint32_t)b->steps + 1) + (uint32_t)column;
    turn(corner_number(p->scene, triangle, origin), weight, w1, w2);
    return triangle;
}

uint32_t sl_root_triangle_at(const sl_primitives *p, uint32_t root, double u, double v, float *w1,
                             float *w2) {
    uint32_t primitive = root / 2;
    u = sl_clamp_unit(u);
    v = sl_clamp_unit(v);
    switch ((sl_primitive_kind)p->kind[primitive]) {
    case SL_PRIMITIVE_QUAD: return quad_triangle_at(p, primitive, u, v, w1, w2);
    case SL_PRIMITIVE_BICUBIC: return bicubic_triangle_at(p, primitive, u, v, w1, w2);
    case SL_PRIMITIVE_TRIANGLE: break;
    }
    *w1 = (float)u;
    *w2 = (float)v;
    return p->first_triangle[primitive];
}

/* ---- and back -------------------------------------------------------------------------------- */

void sl_root_parameters(const sl_primitives *p, uint32_t triangle, float w1, float w2, double *u, double *v) {
    uint32_t primitive = p->of_triangle[triangle];
    double weight[3] = {1.0 - (double)w1 - (double)w2, (double)w1, (double)w2};
    *u = (double)w1;
    *v = (double)w2;
    if (p->kind[primitive] == SL_PRIMITIVE_QUAD) {
        int half = (int)(triangle - p->first_triangle[primitive]);
        const int first = sl_quad_first(p, primitive, half);
        double second = weight[(first + 1) % 3], third = weight[(first + 2) % 3];
        *u = half == 0 ? second + third : second;
        *v = half == 0 ? third : second + third;
    } else if (p->kind[primitive] == SL_PRIMITIVE_BICUBIC) {
        const sl_bicubic *b = &p->scene->bicubics[p->bicubic[primitive]];
        *u = *v = 0.0;
        for (int c = 0; c < 3; c++) {
            uint32_t at = p->scene->vertex[c][triangle] - b->first_vertex, side = (uint32_t)b->steps + 1;
            *u += weight[c] * (double)(at % side) / (double)b->steps;
            *v += weight[c] * (double)(at / side) / (double)b->steps;
        }
    }
    *u = sl_clamp_unit(*u);
    *v = sl_clamp_unit(*v);
}

void sl_root_corner_parameters(const sl_primitives *p, uint32_t triangle, float uv[6]) {
    for (int c = 0; c < 3; c++) {
        double u, v;
        sl_root_parameters(p, triangle, c == 1 ? 1.0f : 0.0f, c == 2 ? 1.0f : 0.0f, &u, &v);
        uv[2 * c] = (float)u;
        uv[2 * c + 1] = (float)v;
    }
}

/* ---- points ---------------------------------------------------------------------------------- */

static sl_vec3 weighted(sl_vec3 a, sl_vec3 b, sl_vec3 c, float w1, float w2) {
    double w[3] = {1.0 - (double)w1 - (double)w2, (double)w1, (double)w2};
    sl_vec3d sum = sl_scaled(sl_to_double(a), w[0]);
    sum = sl_addd(sum, sl_scaled(sl_to_double(b), w[1]));
    return sl_to_float(sl_addd(sum, sl_scaled(sl_to_double(c), w[2])));
}

/* Returns the normal there; an edge that is one point has one, that of its middle. */
static sl_vec3 bicubic_normal(const sl_primitives *p, uint32_t primitive, uint32_t u, uint32_t v) {
    uint32_t t;
    int edge = sl_edge_at(4, u, v, &t), before = (edge + 3) % 4;
    if (edge >= 0 && p->edge_kind) {
        bool point = p->edge_kind[4 * primitive + (uint32_t)edge] & SL_EDGE_POINT;
        bool point_before = t == 0 && p->edge_kind[4 * primitive + (uint32_t)before] & SL_EDGE_POINT;
        if (point || point_before) sl_edge_point(4, point ? edge : before, SL_PATCH_DYADIC / 2, &u, &v);
    }
    sl_vec3 normal;
    sl_bicubic_at(&p->scene->bicubics[p->bicubic[primitive]], (double)u / SL_PATCH_DYADIC,
                  (double)v / SL_PATCH_DYADIC, NULL, &normal);
    return normal;
}

sl_vec3 sl_root_position(const sl_primitives *p, uint32_t root, uint32_t u, uint32_t v) {
    const sl_scene *s = p->scene;
    float w1, w2;
    uint32_t t =
        sl_root_triangle_at(p, root, (double)u / SL_PATCH_DYADIC, (double)v / SL_PATCH_DYADIC, &w1, &w2);
    return weighted(sl_scene_position(s, s->vertex[0][t]), sl_scene_position(s, s->vertex[1][t]),
                    sl_scene_position(s, s->vertex[2][t]), w1, w2);
}

void sl_root_point_at(const sl_primitives *p, uint32_t root, uint32_t u, uint32_t v, sl_lit_point *point) {
    const sl_scene *s = p->scene;
    uint32_t primitive = root / 2;
    float w1, w2, side = root % 2 ? -1.0f : 1.0f;
    uint32_t t =
        sl_root_triangle_at(p, root, (double)u / SL_PATCH_DYADIC, (double)v / SL_PATCH_DYADIC, &w1, &w2);
    uint32_t a = s->vertex[0][t], b = s->vertex[1][t], c = s->vertex[2][t];
    point->position =
        weighted(sl_scene_position(s, a), sl_scene_position(s, b), sl_scene_position(s, c), w1, w2);
    sl_vec3 geometric = sl_scene_geometric_normal(s, t);
    sl_vec3 normal =
        p->kind[primitive] == SL_PRIMITIVE_BICUBIC
            ? bicubic_normal(p, primitive, u, v)
            : weighted(sl_scene_normal(s, a), sl_scene_normal(s, b), sl_scene_normal(s, c), w1, w2);
    point->geometric_normal = sl_scale(geometric, side);
    point->normal = sl_shading_normal(sl_scale(normal, side), point->geometric_normal);
    bool inside = w1 > 0.0f && w2 > 0.0f && w1 + w2 < 1.0f;
    point->triangle = inside ? t : SL_NO_INDEX;
}
