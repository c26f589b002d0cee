/* Emitters: the irradiance of each is known in closed form where nothing is in the way (Lambert's formula);
 * light samples only tell which share of it arrives, sum(V f) / sum(f) (the ratio estimator of Heitz, Hill
 * and McGuire 2018, "Combining analytic direct illumination and stochastic shadows"). The closed forms also
 * are the best weights for choosing an emitter: the samples of many differ in nothing but visibility, and
 * what is seen whole or not at all has no noise. */
#include "cache/light/direct_internal.h"

/* Weighs all sides for all points, and adds up what arrives unoccluded. */
static void weigh(const sl_direct *direct, const sl_lit_block *block, sl_weighed_sides *w,
                  float exact[3][SL_LIGHT_BLOCK]) {
    sl_light_points points = sl_lit_points(block);
    w->sides = 0;
    for (size_t s = 0; s < direct->sides.count; s++) {
        float *share = w->share + w->sides * SL_LIGHT_BLOCK, *sum = w->sums + w->sides * SL_LIGHT_BLOCK;
        SL_KERNEL_OF(direct->isa, sl_polygon_light)(&points, &direct->sides.polygon[s], share);
        float largest = 0.0f, luminance = direct->sides.luminance[s];
        for (size_t i = 0; i < block->count; i++) largest = share[i] > largest ? share[i] : largest;
        if (!(largest > 0.0f)) continue;
        const float *colour = direct->sides.values + s * SL_SIDE_VALUES + 13;
        for (size_t i = 0; i < block->count; i++) {
            float e = share[i] * luminance;
            sum[i] = (w->sides ? sum[(ptrdiff_t)i - SL_LIGHT_BLOCK] : 0.0f) + e;
            exact[0][i] += colour[0] * e;
            exact[1][i] += colour[1] * e;
            exact[2][i] += colour[2] * e;
        }
        w->side[w->sides++] = (uint32_t)s;
    }
}

/* ---- emitters that are near are aimed at by solid angle ---- */

typedef struct {
    int32_t chosen;          /* among those of the block; -1: none yet */
    sl_near_light light;     /* not seen where it is not near */
} near_emitter;

static void look_at(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, int32_t chosen, near_emitter *e) {
    e->chosen = chosen;
    e->light.seen.parts = 0;
    if (sl_light_is_near(light, p)) sl_near_light_make(light, p, n, &e->light);
}

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
    sl_put(aim->x, aim->y, aim->z, i, sl_to_float(sl_scaled(direction, distance)));
    /* f / pdf = (cos solid angle / density) / (E_side / E_all) */
    aim->weight[i] = lit ? (float)(e->light.seen.solid_angle * cosine / density) / exact * total : 0.0f;
    aim->wanted[i] = lit && facing > 0.0 ? 1.0f : 0.0f;
}

static void aim_at_near(const sl_direct *direct, const sl_lit_block *block, const sl_aim_block *aims,
                        uint32_t samples) {
    enum { KEPT = 4 };
    for (size_t i = 0; i < block->count; i++) {
        sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]),
                n = sl_v3(block->normal_x[i], block->normal_y[i], block->normal_z[i]);
        near_emitter kept[KEPT];
        for (int k = 0; k < KEPT; k++) kept[k].chosen = -1;
        for (uint32_t k = 0; k < samples; k++) {
            int32_t chosen = aims[k].chosen[i];
            near_emitter *e = &kept[chosen % KEPT];
            if (e->chosen != chosen) look_at(&direct->sides.polygon[aims[k].side[chosen]], p, n, chosen, e);
            if (e->light.seen.parts) aim_by_angle(block, e, sl_to_double(n), &aims[k], i);
        }
    }
}

/* ---- samples ---- */

static void draw(const sl_direct *direct, const sl_lit_block *block, const sl_weighed_sides *w,
                 uint32_t first, sl_block_samples *s) {
    sl_light_points points = sl_lit_points(block);
    sl_aim_block aims[SL_LIGHT_CHUNK];
    sl_direct_points(direct, block, (sl_sample_range){first, first + s->samples}, SL_STREAM_SHARES,
                     SL_LIGHT_BLOCK, s->u0, s->u1, s->u2);
    for (uint32_t k = 0; k < s->samples; k++) {
        size_t lane = (size_t)k * SL_LIGHT_BLOCK;
        aims[k] = (sl_aim_block){
            &points,      w->sides,         w->side,      direct->sides.values, w->share,    w->sums,
            s->u0 + lane, s->u1 + lane,     s->u2 + lane, s->chosen + lane,  s->x + lane, s->y + lane,
            s->z + lane,  s->weight + lane, s->r + lane,  s->g + lane,       s->b + lane, s->wanted + lane};
        SL_KERNEL_OF(direct->isa, sl_direct_aim)(&aims[k]);
    }
    aim_at_near(direct, block, aims, s->samples);
}

/* Rays from neighbouring pixels to one emitter go the same way: lanes in the order of emitters, samples and
 * pixels. */
static size_t order_by_emitter(const sl_lit_block *block, size_t sides, const sl_block_samples *s,
                               uint32_t order[SL_SAMPLE_LANES]) {
    uint32_t start[SL_EXACT_EMITTERS_MAX + 1] = {0};
    for (uint32_t k = 0; k < s->samples; k++) {
        for (uint32_t lane = k * SL_LIGHT_BLOCK; lane < k * SL_LIGHT_BLOCK + block->count; lane++) {
            if (s->wanted[lane] > 0.0f) start[s->chosen[lane] + 1]++;
        }
    }
    for (size_t side = 0; side < sides; side++) start[side + 1] += start[side];
    size_t count = start[sides];
    for (uint32_t k = 0; k < s->samples; k++) {
        for (uint32_t lane = k * SL_LIGHT_BLOCK; lane < k * SL_LIGHT_BLOCK + block->count; lane++) {
            if (s->wanted[lane] > 0.0f) order[start[s->chosen[lane]]++] = lane;
        }
    }
    return count;
}

/* seen: how many samples of a pixel were, of: of how many. */
static void add_samples(const sl_lit_block *block, const sl_block_samples *s, float scale,
                        sl_direct_sums *sums, float *seen, float *of) {
    for (size_t i = 0; i < block->count; i++) {
        size_t p = block->pixel[i] - sums->first;
        for (size_t lane = i; lane < s->samples * SL_LIGHT_BLOCK; lane += SL_LIGHT_BLOCK) {
            float weight = s->weight[lane] * scale,
                  visible = s->wanted[lane] > 0.0f ? s->visible[lane] : 0.0f, arrives = weight * visible;
            sums->all[0][p] += s->r[lane] * weight;
            sums->all[1][p] += s->g[lane] * weight;
            sums->all[2][p] += s->b[lane] * weight;
            sums->seen[0][p] += s->r[lane] * arrives;
            sums->seen[1][p] += s->g[lane] * arrives;
            sums->seen[2][p] += s->b[lane] * arrives;
            if (lane / SL_LIGHT_BLOCK % 2) {
                float light = s->r[lane] + s->g[lane] + s->b[lane];
                sums->odd_seen[p] += light * arrives;
                sums->odd_all[p] += light * weight;
            }
            seen[i] += weight > 0.0f ? visible : 0.0f;
            of[i] += weight > 0.0f ? 1.0f : 0.0f;
        }
    }
}

typedef struct {
    float seen[SL_LIGHT_BLOCK], of[SL_LIGHT_BLOCK]; /* samples */
} answers;

/* Traces and adds up samples that are drawn. */
static void take(const sl_direct *direct, const sl_lit_block *block, size_t sides,
                 sl_direct_scratch *scratch, sl_direct_sums *sums, answers *a, sl_counters *counters) {
    sl_block_samples *s = &scratch->samples;
    size_t rays = order_by_emitter(block, sides, s, scratch->order);
    sl_direct_trace(direct, block, rays, scratch->order, (sl_aims){s->x, s->y, s->z, false}, s->visible,
                    counters);
    add_samples(block, s, 1.0f / (float)sl_direct_samples(direct), sums, a->seen, a->of);
}

static void conclude(const sl_lit_block *block, sl_sample_range range, const answers *a,
                     float exact[3][SL_LIGHT_BLOCK], sl_direct_sums *sums) {
    for (size_t i = 0; i < block->count; i++) {
        size_t p = block->pixel[i] - sums->first;
        sums->samples[p] += (float)(range.end - range.first);
        if (range.first > 0) continue;
        for (int c = 0; c < 3; c++) sums->exact[c][p] += exact[c][i];
        /* Where no sample tells anything of light that arrives, more may. */
        bool unknown = a->of[i] == 0.0f && exact[0][i] + exact[1][i] + exact[2][i] > 0.0f;
        if (unknown || (a->seen[i] > 0.0f && a->seen[i] < a->of[i])) sums->partly[p] = 1.0f;
    }
}

void sl_direct_exact(const sl_direct *direct, const sl_lit_block *block, sl_sample_range range,
                     sl_direct_scratch *scratch, sl_direct_sums *sums, sl_counters *counters) {
    sl_weighed_sides *w = &scratch->weighed;
    sl_block_samples *s = &scratch->samples;
    answers a = {{0.0f}, {0.0f}};
    float exact[3][SL_LIGHT_BLOCK] = {{0.0f}};
    weigh(direct, block, w, exact);
    if (w->sides == 0) return;
    for (uint32_t first = range.first; first < range.end; first += SL_LIGHT_CHUNK) {
        s->samples = range.end - first < SL_LIGHT_CHUNK ? range.end - first : SL_LIGHT_CHUNK;
        draw(direct, block, w, first, s);
        take(direct, block, w->sides, scratch, sums, &a, counters);
    }
    conclude(block, range, &a, exact, sums);
}
