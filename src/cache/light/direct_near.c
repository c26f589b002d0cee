/* Emitters that are near: where the nearest part of an emitter is much nearer than the rest, points spread
 * evenly over its area tell little of what arrives. Few of them fall on that part, and those few outweigh all
 * others: a wall beside a wide lamp is lit by what lies next to it, but its samples go to the far end. There
 * directions are chosen by solid angle instead (Arvo 1995), where nothing but the cosine differs between
 * them. */
#include "cache/light/direct_internal.h"
#include "cache/light/near_light.h"

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
    return sl_light_is_near(light, box->low, box->high);
}

typedef struct {
    int32_t chosen;          /* among those of the block; -1: none yet */
    sl_near_light light;     /* not seen where it is not near */
} near_emitter;

static void look_at(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, int32_t chosen, near_emitter *e) {
    e->chosen = chosen;
    e->light.seen.parts = 0;
    if (sl_light_is_near(light, p, p)) sl_near_light_make(light, p, n, &e->light);
}

/* ---- samples ---- */

/* Replaces the sample of point i. */
static void aim_by_angle(const sl_lit_block *block, const near_emitter *e, sl_vec3d n,
                         const sl_aim_block *aim, size_t i) {
    double density, distance;
    sl_vec3d direction =
        sl_near_light_draw(&e->light, (double)aim->u1[i], (double)aim->u2[i], &density, &distance);
    double cosine = sl_dotd(direction, n);
    double facing = sl_dotd(direction, sl_v3d((double)block->geometric_x[i], (double)block->geometric_y[i],
                                              (double)block->geometric_z[i]));
    float total = aim->sums[(aim->sides - 1) * SL_LIGHT_BLOCK + i],
          exact = aim->share[(size_t)e->chosen * SL_LIGHT_BLOCK + i];
    bool lit = cosine > 0.0 && distance > 0.0 && exact > 0.0f;
    sl_vec3 to_light = sl_to_float(sl_scaled(direction, distance));
    aim->x[i] = to_light.x;
    aim->y[i] = to_light.y;
    aim->z[i] = to_light.z;
    /* f / pdf = (cos solid angle / density) / (E_side / E_all) */
    aim->weight[i] = lit ? (float)(e->light.seen.solid_angle * cosine / density) / exact * total : 0.0f;
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
            if (e->chosen != chosen) look_at(&direct->sides.polygon[aims[k].side[chosen]], p, n, chosen, e);
            if (e->light.seen.parts) aim_by_angle(block, e, sl_to_double(n), &aims[k], i);
        }
    }
}
