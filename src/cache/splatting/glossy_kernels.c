/* What a radiance record sends to the eye from a pixel: section 3 of Krivanek et al. 2005 with the rotation as a table. Vectors of
 * coefficients have an even part (cos m phi) and an odd one (sin m phi), each padded with zeros to groups of sixteen. */
#include "cache/splatting/glossy.h"

#include "base/math.h"

#include <math.h>

enum { LANES = 16, EVEN_MAX = 80, ODD_MAX = 80, VECTOR_MAX = EVEN_MAX + ODD_MAX };

/* Below this angle (its sine) frames count as one: the tilt would change nothing that a float holds. */
static const float no_tilt = 1e-4f;

/* cos m psi and sin m psi from the unit vector (cos psi, sin psi). */
static inline void powers(float cosine, float sine, int order, float *restrict cosines, float *restrict sines) {
    cosines[0] = 1.0f;
    sines[0] = 0.0f;
    for (int m = 1; m < order; m++) {
        cosines[m] = cosines[m - 1] * cosine - sines[m - 1] * sine;
        sines[m] = sines[m - 1] * cosine + cosines[m - 1] * sine;
    }
}

/* The cosine and the sine of an azimuth from tangential components of any length; zero length: azimuth 0. */
static inline void azimuth(float x, float y, float *cosine, float *sine) {
    float length = sqrtf(x * x + y * y);
    *cosine = length > 0.0f ? x / length : 1.0f;
    *sine = length > 0.0f ? y / length : 0.0f;
}

/* The lobe for azimuth 0, which is even, turned to azimuth psi. */
static inline void turn_lobe(const sl_glossy *g, const float *restrict lobe, const float *restrict cosines,
                             const float *restrict sines, float *restrict turned) {
    const size_t even = g->even, odd = g->stride - g->even;
    for (size_t i = 0; i < even; i++) turned[i] = lobe[i] * cosines[g->even_m[i]];
    for (size_t i = 0; i < odd; i++) turned[even + i] = 0.0f;
    for (int l = 1; l < g->order; l++) { /* sin goes to the place of -m */
        for (int m = 1; m <= l; m++) turned[sl_hsh_odd(g->order, l, -m)] = lobe[sl_hsh_even(l, m)] * sines[m];
    }
}

/* Z(alpha) transposed: from the frame whose x axis lies along the tilt to the record's own. */
static inline void turn_back(const sl_glossy *g, const float *restrict cosines, const float *restrict sines, float *restrict v) {
    for (int l = 1; l < g->order; l++) {
        for (int m = 1; m <= l; m++) {
            size_t e = sl_hsh_even(l, m), o = sl_hsh_odd(g->order, l, -m);
            float even = v[e], odd = v[o];
            v[e] = cosines[m] * even - sines[m] * odd;
            v[o] = sines[m] * even + cosines[m] * odd;
        }
    }
}

/* u = D^T v, of one part: rows of two neighbouring tables, mixed. */
static inline void tilt_part(const float *const table[2], float mix, const float *restrict v, size_t rows, size_t stride,
                             float *restrict u) {
    const float *restrict first = table[0], *restrict second = table[1];
    for (size_t j = 0; j < stride; j++) u[j] = 0.0f;
    for (size_t i = 0; i < rows; i++, first += stride, second += stride) {
        const float a = v[i] * (1.0f - mix), b = v[i] * mix;
#pragma omp simd
        for (size_t j = 0; j < stride; j++) u[j] += a * first[j] + b * second[j];
    }
}

static inline float sum_of_lanes(const float *lanes) {
    float sums[LANES];
    for (int l = 0; l < LANES; l++) sums[l] = lanes[l];
    for (int width = LANES / 2; width > 0; width /= 2) {
        for (int l = 0; l < width; l++) sums[l] += sums[l + width];
    }
    return sums[0];
}

/* sum over places of w (lambda + dx d/dx lambda + dy d/dy lambda) of one channel. */
static inline float reflect(const float *restrict w, const float *restrict lambda, const float *restrict along_x,
                            const float *restrict along_y, float dx, float dy, size_t stride) {
    float lanes[LANES] = {0};
    for (size_t j = 0; j < stride; j += LANES) {
#pragma omp simd
        for (size_t l = 0; l < LANES; l++) lanes[l] += w[j + l] * (lambda[j + l] + dx * along_x[j + l] + dy * along_y[j + l]);
    }
    return sum_of_lanes(lanes);
}

extern sl_glossy_kernel SL_KERNEL(sl_glossy_radiance);
void SL_KERNEL(sl_glossy_radiance)(const sl_glossy_view *view, const sl_glossy_record *record, size_t pixel, float radiance[3]) {
    const sl_glossy *g = view->glossy;
    const sl_receivers *r = view->receivers;
    const sl_phong_table *table = g->lobe[view->material[pixel]];
    const sl_vec3 p = sl_v3(r->position_x[pixel], r->position_y[pixel], r->position_z[pixel]);
    const sl_vec3 n = sl_v3(r->normal_x[pixel], r->normal_y[pixel], r->normal_z[pixel]);
    const sl_frame *f = &record->frame;
    _Alignas(64) float lobe[EVEN_MAX], turned[VECTOR_MAX], tilted[VECTOR_MAX];
    float cosines[SL_HSH_ORDER_MAX], sines[SL_HSH_ORDER_MAX], cosine, sine;
    radiance[0] = radiance[1] = radiance[2] = 0.0f;
    if (!table) return;
    /* Shading normals can turn away from the eye at silhouettes; such a pixel reflects as at grazing view. */
    const sl_vec3 out = sl_normalize_or(sl_sub(view->eye, p), n);
    const float up = sl_dot(out, n);
    sl_phong_table_look_up(table, up, lobe);
    const sl_vec3 along = sl_sub(out, sl_scale(n, up)); /* tangential */
    const sl_vec3 local = sl_frame_to_local(f, n);      /* (sin beta cos alpha, sin beta sin alpha, cos beta) */
    const float tilt = sqrtf(local.x * local.x + local.y * local.y);
    const float *weights = turned;
    if (tilt < no_tilt) {
        azimuth(sl_dot(along, f->x), sl_dot(along, f->y), &cosine, &sine);
        powers(cosine, sine, g->order, cosines, sines);
        turn_lobe(g, lobe, cosines, sines, turned);
    } else {
        /* gamma: where the pixel sees the record's normal tilt away from; psi: the azimuth of the eye from there. */
        const sl_vec3 away = sl_sub(sl_scale(n, sl_dot(n, f->z)), f->z);
        azimuth(sl_dot(away, along), sl_dot(n, sl_cross(away, along)), &cosine, &sine);
        powers(cosine, sine, g->order, cosines, sines);
        turn_lobe(g, lobe, cosines, sines, turned);
        const sl_hsh_tilt d = sl_hsh_tilt_at(g->rotation, (float)sl_atan2((double)tilt, (double)local.z));
        tilt_part(d.even, d.mix, turned, sl_hsh_even_count(g->order), g->even, tilted);
        tilt_part(d.odd, d.mix, turned + g->even, sl_hsh_odd_count(g->order), g->stride - g->even, tilted + g->even);
        azimuth(local.x, local.y, &cosine, &sine);
        powers(cosine, sine, g->order, cosines, sines);
        turn_back(g, cosines, sines, tilted);
        weights = tilted;
    }
    const sl_vec3 delta = sl_sub(p, record->position);
    const float dx = sl_dot(delta, f->x), dy = sl_dot(delta, f->y);
    const float *c = record->coefficients;
    for (size_t k = 0; k < 3; k++)
        radiance[k] = reflect(weights, c + k * g->stride, c + (3 + k) * g->stride, c + (6 + k) * g->stride, dx, dy, g->stride);
}
