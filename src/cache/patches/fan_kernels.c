/* Points of a face side by side, in lanes: those that lie in one leaf, and what its fan shows there. */
#include "cache/patches/mesh.h"

enum { LANES = SL_FAN_LANES };

size_t SL_KERNEL(sl_mesh_run)(const sl_patch_place *place, size_t count, const float *w1, const float *w2,
                              float *leaf_w1, float *leaf_w2) {
    const double margin = 1e-9; /* beyond what rounding could do */
    /* powers of two: as exact as sl_patch_local()'s divisions */
    const double u = (double)place->u[0], v = (double)place->v[0], per_u = 1.0 / ((double)place->u[1] - u),
                 per_v = 1.0 / ((double)place->v[2] - v);
    int32_t inside[LANES];
    float a_of[LANES] = {0.0f}, b_of[LANES] = {0.0f};
    for (size_t l = 0; l < count; l++) {
        a_of[l] = w1[l];
        b_of[l] = w2[l];
    }
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double a, b;
        sl_mesh_clamp_weights(a_of[l], b_of[l], &a, &b);
        a = (a * SL_PATCH_DYADIC - u) * per_u;
        b = (b * SL_PATCH_DYADIC - v) * per_v;
        inside[l] = (a > margin) & (b > margin) & (a + b < 1.0 - margin);
        leaf_w1[l] = (float)a;
        leaf_w2[l] = (float)b;
    }
    size_t run = 1;
    while (run < count && inside[run]) run++;
    return run;
}

/* ---- values ---- */

static inline void flat_values(const sl_fan_shown *fan, const float *w1, const float *w2,
                               float value[3][SL_FAN_LANES]) {
    const float(*of)[3] = fan->value;
    for (int c = 0; c < fan->channels; c++) {
#pragma omp simd
        for (int l = 0; l < LANES; l++)
            value[c][l] = of[0][c] + (w1[l] * (of[1][c] - of[0][c]) + w2[l] * (of[2][c] - of[0][c]));
    }
}

typedef struct fan_lanes {
    int32_t edge[LANES], whole[LANES], low[LANES], high[LANES], from[LANES], to[LANES];
    float along[LANES], out[LANES];
} fan_lanes;

static inline void find_places(const float *w1, const float *w2, fan_lanes *p) {
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        const sl_fan_place at = sl_fan_place_of(true, w1[l], w2[l]);
        const float along = at.along * (float)SL_PATCH_DYADIC;
        p->edge[l] = at.edge;
        p->along[l] = along;
        p->out[l] = at.out;
        p->whole[l] = (int32_t)along;
        p->low[l] = 0;
        p->high[l] = SL_PATCH_DYADIC;
        p->from[l] = at.edge;
        p->to[l] = at.edge == 2 ? 0 : at.edge + 1;
    }
}

static inline void find_pieces(const sl_fan_shown *fan, fan_lanes *p) {
    for (size_t k = 0; k < fan->count; k++) {
        const int32_t at = fan->spoke[k].along, edge = fan->spoke[k].edge,
                      vertex = (int32_t)fan->spoke[k].vertex;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const bool here = p->edge[l] == edge, before = here & (at <= p->whole[l]),
                       beyond = here & (at > p->whole[l]) & (at < p->high[l]);
            p->low[l] = before ? at : p->low[l];
            p->from[l] = before ? vertex : p->from[l];
            p->high[l] = beyond ? at : p->high[l];
            p->to[l] = beyond ? vertex : p->to[l];
        }
    }
}

static inline void fan_values(const sl_fan_shown *fan, const float *w1, const float *w2,
                              float value[3][SL_FAN_LANES]) {
    fan_lanes p;
    float s[LANES], a[3][LANES], b[3][LANES];
    find_places(w1, w2, &p);
    find_pieces(fan, &p);
    for (int l = 0; l < LANES; l++) {
        for (int c = 0; c < 3; c++) {
            a[c][l] = fan->value[p.from[l]][c];
            b[c][l] = fan->value[p.to[l]][c];
        }
    }
#pragma omp simd
    for (int l = 0; l < LANES; l++) s[l] = (p.along[l] - (float)p.low[l]) / (float)(p.high[l] - p.low[l]);
    for (int c = 0; c < fan->channels; c++) {
        const float centre = fan->centre[c];
#pragma omp simd
        for (int l = 0; l < LANES; l++)
            value[c][l] = sl_fan_value(centre, p.out[l], s[l], a[c][l], b[c][l]);
    }
}

void SL_KERNEL(sl_mesh_fan_values)(const sl_fan_shown *fan, const float *w1, const float *w2,
                                   float value[3][SL_FAN_LANES]) {
    float a[LANES], b[LANES];
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        a[l] = sl_clamp_unitf(w1[l]);
        b[l] = sl_clamp_unitf(w2[l]);
    }
    if (fan->count == 0) flat_values(fan, a, b, value);
    else fan_values(fan, a, b, value);
}
