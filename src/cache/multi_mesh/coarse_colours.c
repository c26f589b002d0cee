/* The coarse mesh's colours: what bounces off it, k_d(x') U_dd(x'). The paper's equation (7) lacks k_d(x'),
 * without which no colour would bleed and indirect light would be too bright by 1 / k_d. */
#include "cache/multi_mesh/coarse.h"

#include <math.h>

#include "base/parallel.h"

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
    c->valid[vertex] = sl_rgb_is_finite(value);
    c->value[vertex] =
        c->valid[vertex] ? (sl_rgb){sane(value.r), sane(value.g), sane(value.b)} : sl_grey(0.0f);
}

sl_rgb sl_coarse_get(const sl_coarse *c, size_t vertex) {
    return c->valid[vertex] ? c->value[vertex] : sl_grey(NAN);
}

/* ---- reflectance ----------------------------------------------------------------------------- */

enum { SAMPLES_MAX = 16 }; /* squared: a texture's samples in a coarse triangle */

/* As many steps along an edge as make a sample of each texel. */
static int samples_along(const sl_scene *scene, uint32_t triangle, int parts) {
    const sl_material *m = &scene->materials[scene->material_index[triangle]];
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

/* The mean k_d of a coarse triangle, at the middles of m x m equal triangles, as far as the alpha mask lets
 * one see them. */
static sl_rgb mean_reflectance(const sl_coarse *c, uint32_t face, const place *p, int m) {
    const sl_scene *scene = c->scene;
    uint32_t triangle = face / 2;
    int rows = c->face[face].rows;
    double r = 0.0, g = 0.0, b = 0.0, count = 0.0;
    for (int s = 0; s < m * m; s++) {
        int j = 0, at = s;
        for (; at >= 2 * (m - j) - 1; j++) at -= 2 * (m - j) - 1;
        double third = at % 2 ? 2.0 / 3.0 : 1.0 / 3.0, x = (at / 2 + third) / m, y = (j + third) / m;
        double u = (p->i[0] + x * (p->i[1] - p->i[0]) + y * (p->i[2] - p->i[0])) / rows;
        double v = (p->j[0] + x * (p->j[1] - p->j[0]) + y * (p->j[2] - p->j[0])) / rows;
        float w1 = (float)u, w2 = (float)v;
        if (!sl_scene_is_opaque(scene, triangle, w1, w2)) continue;
        sl_rgb k = sl_scene_diffuse_nearest(scene, triangle, w1, w2);
        r += (double)k.r;
        g += (double)k.g;
        b += (double)k.b;
        count += 1.0;
    }
    if (!(count > 0.0)) return sl_grey(0.0f); /* all of it is holes */
    return (sl_rgb){sane((float)(r / count)), sane((float)(g / count)), sane((float)(b / count))};
}

/* ---- colours --------------------------------------------------------------------------------- */

/* U_dd at a coarse triangle's corners; where one has none, the mean of the others. */
static void corner_values(const sl_coarse *c, uint32_t face, const place *p, sl_rgb value[3]) {
    sl_rgb sum = sl_grey(0.0f);
    int valid[3], count = 0;
    for (int k = 0; k < 3; k++) {
        uint32_t vertex = sl_coarse_lattice_vertex(c, face, p->i[k], p->j[k]);
        valid[k] = c->valid[vertex];
        value[k] = c->value[vertex];
        if (valid[k]) sum = sl_rgb_add(sum, value[k]);
        count += valid[k];
    }
    sl_rgb mean = sl_rgb_scale(sum, count ? 1.0f / (float)count : 0.0f);
    for (int k = 0; k < 3; k++) value[k] = valid[k] ? value[k] : mean;
}

static void finish_triangle(sl_coarse *c, uint32_t face, const place *p, size_t at, int samples) {
    if (!c->reflectance_known) c->reflectance[at] = mean_reflectance(c, face, p, samples);
    sl_rgb colour[3];
    corner_values(c, face, p, colour);
    float *out = c->colour + at * SL_COARSE_FLOATS;
    for (int k = 0; k < 3; k++) {
        colour[k] = sl_rgb_mul(colour[k], c->reflectance[at]);
        sl_rgb rgb = k ? sl_rgb_sub(colour[k], colour[0]) : colour[0];
        out[3 * k] = rgb.r;
        out[3 * k + 1] = rgb.g;
        out[3 * k + 2] = rgb.b;
    }
}

static void finish_face(sl_coarse *c, uint32_t face) {
    int n = c->face[face].rows,
        samples = c->reflectance_known ? 0 : samples_along(c->scene, face / 2, n * n);
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
        const float *colour = c->colour + t * SL_COARSE_FLOATS;
        for (int k = 0; k < 3; k++) {
            float more = colour[3 + k] > colour[6 + k] ? colour[3 + k] : colour[6 + k],
                  value = colour[k] + (more > 0.0f ? more : 0.0f);
            most[k] = value > most[k] ? value : most[k];
        }
    }
    return (sl_rgb){most[0], most[1], most[2]};
}
