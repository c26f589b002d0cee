/* Emitters that are near: where the nearest part of an emitter is much nearer than the rest, points spread
 * evenly over its area tell little of what arrives. Few of them fall on that part, and those few outweigh all
 * others: a wall beside a wide lamp is lit by what lies next to it, but its samples go to the far end. There
 * directions are chosen by solid angle instead (Arvo 1995), where nothing but the cosine differs between
 * them. */
#include "cache/light/direct_internal.h"
#include "cache/light/spherical_triangle.h"

/* Nearer than such a share of the distance of its farthest corner from its middle. */
#define NEAR_EXTENT 0.5f

static float gap(float low, float high, float from, float to) {
    return to < low ? low - to : from > high ? from - high : 0.0f;
}

/* Between the boxes about an emitter and about some points. */
static bool is_near(const sl_polygon_light *light, sl_vec3 low, sl_vec3 high) {
    const sl_vec3 *c = light->corner;
    float x = gap(fminf(c[0].x, fminf(c[1].x, c[2].x)), fmaxf(c[0].x, fmaxf(c[1].x, c[2].x)), low.x, high.x);
    float y = gap(fminf(c[0].y, fminf(c[1].y, c[2].y)), fmaxf(c[0].y, fmaxf(c[1].y, c[2].y)), low.y, high.y);
    float z = gap(fminf(c[0].z, fminf(c[1].z, c[2].z)), fmaxf(c[0].z, fmaxf(c[1].z, c[2].z)), low.z, high.z);
    return x * x + y * y + z * z < NEAR_EXTENT * NEAR_EXTENT * light->extent_squared;
}

sl_block_box sl_lit_block_box(const sl_lit_block *block) {
    sl_block_box box = {sl_v3(block->x[0], block->y[0], block->z[0]),
                        sl_v3(block->x[0], block->y[0], block->z[0])};
    for (size_t i = 1; i < block->count; i++) {
        sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]);
        box.low = sl_v3(fminf(box.low.x, p.x), fminf(box.low.y, p.y), fminf(box.low.z, p.z));
        box.high = sl_v3(fmaxf(box.high.x, p.x), fmaxf(box.high.y, p.y), fmaxf(box.high.z, p.z));
    }
    return box;
}

bool sl_emitter_is_near(const sl_polygon_light *light, const sl_block_box *box) {
    return is_near(light, box->low, box->high);
}

/* ---- one emitter, seen from a point ---- */

typedef struct {
    int32_t chosen;          /* among those of the block; -1: none yet */
    sl_seen_triangle seen;   /* without parts where it is not near */
    double cosine[2][3];     /* above the point, towards the corners of each part; at least COSINE_MIN */
    sl_vec3d out;            /* the emitter's normal */
    double height;           /* of the point above the emitter */
} near_emitter;

#define COSINE_MIN 0.05

/* The cosine above the receiver differs between the corners, so numbers are bent by what is bilinear between
 * the corners' cosines (Hart et al. 2020, "Practical product sampling by fitting and composing warps"). */
static void look_at(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, int32_t chosen, near_emitter *e) {
    e->chosen = chosen;
    e->seen.parts = 0;
    if (!is_near(light, p, p)) return;
    sl_seen_triangle_make(light->corner, p, n, &e->seen);
    for (int k = 0; k < e->seen.parts; k++) {
        const sl_spherical_triangle *t = &e->seen.part[k];
        const sl_vec3d towards[3] = {t->a, t->b, t->c};
        for (int c = 0; c < 3; c++)
            e->cosine[k][c] = fmax(COSINE_MIN, sl_dotd(towards[c], sl_to_double(n)));
    }
    e->out = sl_to_double(light->normal);
    e->height = sl_dotd(e->out, sl_subd(sl_to_double(p), sl_to_double(light->corner[0])));
}

/* Density proportional to a line from `low` at 0 to `high` at 1, both > 0. */
static double draw_line(double u, double low, double high) {
    return u * (low + high) / (low + sqrt(low * low + u * (high * high - low * low)));
}

/* A direction towards the emitter, and its density times the solid angle. */
static sl_vec3d draw_direction(const near_emitter *e, double u1, double u2, double *density) {
    int part = sl_seen_triangle_part(&e->seen, &u1);
    const double *c = e->cosine[part], mean = 0.5 * c[1] + 0.25 * (c[0] + c[2]);
    u2 = draw_line(u2, c[1], 0.5 * (c[0] + c[2]));
    double low = c[1] + u2 * (c[0] - c[1]), high = c[1] + u2 * (c[2] - c[1]);
    u1 = draw_line(u1, low, high);
    *density = (low + u1 * (high - low)) / mean;
    return sl_spherical_triangle_point(&e->seen.part[part], u1, u2);
}

/* ---- samples ---- */

/* Replaces the sample of point i. */
static void aim_by_angle(const sl_lit_block *block, const near_emitter *e, sl_vec3d n,
                         const sl_aim_block *aim, size_t i) {
    double density;
    sl_vec3d direction = draw_direction(e, (double)aim->u1[i], (double)aim->u2[i], &density);
    double emitted = -sl_dotd(e->out, direction), distance = e->height / (emitted > 0.0 ? emitted : 1.0),
           cosine = sl_dotd(direction, n);
    double facing = sl_dotd(direction, sl_v3d((double)block->geometric_x[i], (double)block->geometric_y[i],
                                              (double)block->geometric_z[i]));
    float total = aim->sums[(aim->sides - 1) * SL_LIGHT_BLOCK + i],
          exact = aim->share[(size_t)e->chosen * SL_LIGHT_BLOCK + i];
    bool lit = cosine > 0.0 && emitted > 0.0 && distance > 0.0 && exact > 0.0f;
    sl_vec3 to_light = sl_to_float(sl_scaled(direction, distance));
    aim->x[i] = to_light.x;
    aim->y[i] = to_light.y;
    aim->z[i] = to_light.z;
    /* f / pdf = (cos solid angle / density) / (E_side / E_all) */
    aim->weight[i] = lit ? (float)(e->seen.solid_angle * cosine / density) / exact * total : 0.0f;
    aim->wanted[i] = lit && facing > 0.0 ? 1.0f : 0.0f;
}

void sl_direct_aim_near(const sl_direct *direct, const sl_lit_block *block, const bool *near,
                        const sl_aim_block *aims, uint32_t samples) {
    enum { KEPT = 4 };
    for (size_t i = 0; i < block->count; i++) {
        sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]),
                n = sl_v3(block->normal_x[i], block->normal_y[i], block->normal_z[i]);
        near_emitter kept[KEPT];
        for (int k = 0; k < KEPT; k++) kept[k].chosen = -1;
        for (uint32_t k = 0; k < samples; k++) {
            int32_t chosen = aims[k].chosen[i];
            if (!near[chosen]) continue;
            near_emitter *e = &kept[chosen % KEPT];
            if (e->chosen != chosen) look_at(&direct->polygons[aims[k].side[chosen]], p, n, chosen, e);
            if (e->seen.parts) aim_by_angle(block, e, sl_to_double(n), &aims[k], i);
        }
    }
}
