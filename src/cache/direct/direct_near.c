/* Emitters that are near: where the nearest part of an emitter is much nearer than the rest, points spread evenly over its area tell
 * little of what arrives. Few of them fall on that part, and those few outweigh all others: a wall beside a wide lamp is lit by what lies
 * next to it, but its samples go to the far end. There directions are chosen by solid angle instead (Arvo 1995), where nothing
 * but the cosine differs between them. */
#include "cache/direct/direct_internal.h"
#include "cache/light/spherical_triangle.h"

/* Nearer than so many times the distance of its farthest corner from the centroid (squared). */
#define NEAR_EXTENTS 2.0f
static const float near_squared = NEAR_EXTENTS * NEAR_EXTENTS;

static sl_vec3 centroid(const sl_polygon_light *p) {
    return sl_scale(sl_add(sl_add(p->corner[0], p->corner[1]), p->corner[2]), 1.0f / 3.0f);
}

/* ---- is any point of a block near? ---- */

static float gap(float x, float low, float high) { return x < low ? low - x : x > high ? x - high : 0.0f; }

sl_block_box sl_lit_block_box(const sl_lit_block *block) {
    sl_block_box box = {sl_v3(block->x[0], block->y[0], block->z[0]), sl_v3(block->x[0], block->y[0], block->z[0])};
    for (size_t i = 1; i < block->count; i++) {
        sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]);
        box.low = sl_v3(fminf(box.low.x, p.x), fminf(box.low.y, p.y), fminf(box.low.z, p.z));
        box.high = sl_v3(fmaxf(box.high.x, p.x), fmaxf(box.high.y, p.y), fmaxf(box.high.z, p.z));
    }
    return box;
}

bool sl_emitter_is_near(const sl_polygon_light *light, const sl_block_box *box) {
    sl_vec3 c = centroid(light);
    sl_vec3 d = sl_v3(gap(c.x, box->low.x, box->high.x), gap(c.y, box->low.y, box->high.y), gap(c.z, box->low.z, box->high.z));
    return sl_dot(d, d) < near_squared * light->extent_squared;
}

/* ---- samples ---- */

static double cosine_towards(sl_vec3 corner, sl_vec3 p, sl_vec3d n) {
    sl_vec3d d = sl_subd(sl_to_double(corner), sl_to_double(p));
    double length = sl_lengthd(d);
    return length > 0.0 ? sl_dotd(d, n) / length : 0.0;
}

/* Density proportional to a line from `low` at 0 to `high` at 1, both > 0. */
static double draw_line(double u, double low, double high) { return u * (low + high) / (low + sqrt(low * low + u * (high * high - low * low))); }

/* The cosine above the receiver differs between the corners of the emitter, and what is below the horizon brings nothing: numbers are bent by
 * what is bilinear between the corners' cosines (Hart et al. 2020, "Practical product sampling by fitting and composing warps"). u2 = 0 is
 * corner 1, whatever u1; u2 = 1 goes from corner 0 to corner 2. Returns the density. */
static double bend(const double cosine[3], double *u1, double *u2) {
    double c[3];
    for (int k = 0; k < 3; k++) c[k] = cosine[k] > 0.05 ? cosine[k] : 0.05;
    double end = 0.5 * (c[0] + c[2]);
    *u2 = draw_line(*u2, c[1], end);
    double low = c[1] + *u2 * (c[0] - c[1]), high = c[1] + *u2 * (c[2] - c[1]);
    *u1 = draw_line(*u1, low, high);
    return (low + *u1 * (high - low)) / (0.5 * (c[1] + end));
}

/* Replaces the sample of point i, where its emitter is near. */
static void aim_by_angle(const sl_lit_block *block, const sl_polygon_light *light, const sl_aim_block *aim, size_t i) {
    sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]), m = sl_sub(centroid(light), p);
    sl_vec3d direction, n = sl_v3d((double)block->normal_x[i], (double)block->normal_y[i], (double)block->normal_z[i]);
    double solid_angle, u1 = (double)aim->u1[i], u2 = (double)aim->u2[i], cosines[3];
    float exact = aim->share[(size_t)aim->chosen[i] * SL_LIGHT_BLOCK + i];
    if (!(sl_dot(m, m) < near_squared * light->extent_squared) || !(exact > 0.0f)) return;
    for (int k = 0; k < 3; k++) cosines[k] = cosine_towards(light->corner[k], p, n);
    double density = bend(cosines, &u1, &u2);
    if (!sl_spherical_point(light->corner, p, u1, u2, &direction, &solid_angle)) return;
    sl_vec3d out = sl_to_double(light->normal);
    double height = sl_dotd(out, sl_subd(sl_to_double(p), sl_to_double(light->corner[0])));
    double emitted = -sl_dotd(out, direction), distance = height / (emitted > 0.0 ? emitted : 1.0);
    double cosine = sl_dotd(direction, n);
    double facing = sl_dotd(direction, sl_v3d((double)block->geometric_x[i], (double)block->geometric_y[i], (double)block->geometric_z[i]));
    bool lit = cosine > 0.0 && emitted > 0.0 && distance > 0.0;
    float total = aim->sums[(aim->sides - 1) * SL_LIGHT_BLOCK + i];
    sl_vec3 to_light = sl_to_float(sl_scaled(direction, distance));
    aim->x[i] = to_light.x;
    aim->y[i] = to_light.y;
    aim->z[i] = to_light.z;
    /* f / pdf = (cos solid angle / density) / (E_side / E_all) */
    aim->weight[i] = lit ? (float)(solid_angle * cosine / density) / exact * total : 0.0f;
    aim->wanted[i] = lit && facing > 0.0 ? 1.0f : 0.0f;
}

void sl_direct_aim_near(const sl_direct *direct, const sl_lit_block *block, const bool *near, const sl_aim_block *aim) {
    for (size_t i = 0; i < block->count; i++) {
        size_t chosen = (size_t)aim->chosen[i];
        if (near[chosen]) aim_by_angle(block, &direct->polygons[aim->side[chosen]], aim, i);
    }
}
