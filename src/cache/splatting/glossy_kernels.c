/* Radiance that a record sends to the eye from a pixel (Krivanek et al. 2005): the pixel's lobe moved into
 * the record's frame (cache/hemisphere/lobes.c). Vectors of coefficients have an even part (cos m phi) and an
 * odd one (sin m phi), each padded with zeros to groups of sixteen. */
#include "cache/splatting/glossy.h"

#include <math.h>
#include <string.h>

/* Bands are copied by sixteen floats, whatever their length; the next band overwrites what was too much, and
 * SPARE takes the last. */
enum { LANES = 16, SPARE = LANES, EVEN_MAX = 80, VECTOR_MAX = 160 };

/* The end of the padding, which no band's copy reaches. */
static inline void clear(float *sixteen) { memset(sixteen, 0, LANES * sizeof *sixteen); }

/* cos m phi and sin m phi from the unit vector (cos phi, sin phi), at the places of all even coefficients (l,
 * m). */
static inline void powers(float cosine, float sine, int order, float *restrict cosines,
                          float *restrict sines) {
    float c[LANES] = {1.0f}, s[LANES] = {0.0f};
    for (int m = 1; m < order; m++) {
        c[m] = c[m - 1] * cosine - s[m - 1] * sine;
        s[m] = s[m - 1] * cosine + c[m - 1] * sine;
    }
    for (int l = 0; l < order && l < SL_HSH_ORDER_MAX; l++) {
        memcpy(cosines + sl_hsh_even(l, 0), c, sizeof c);
        memcpy(sines + sl_hsh_even(l, 0), s, sizeof s);
    }
}

/* Coefficients of the lobe with mirror direction r at a pixel with normal n, both in the record's frame. In
 * the frame turned so that r has azimuth 0 they are even = n_x X + n_z Z - C and odd = n_y Y; the turn back
 * mixes those of equal l and m. */
static inline void move_lobe(const sl_glossy *g, const sl_moved_lobe *lobe, sl_vec3 r, sl_vec3 n,
                             float cosine_out, float *restrict weights) {
    const size_t width = g->even;
    const sl_phong_rows at = sl_moved_lobe_at(lobe, r.z), cut = sl_moved_lobe_at(lobe, cosine_out);
    const float *x0 = at.first, *y0 = x0 + width, *z0 = y0 + width, *c0 = cut.first + 3 * width;
    const float *x1 = at.second, *y1 = x1 + width, *z1 = y1 + width, *c1 = cut.second + 3 * width;
    _Alignas(64) float cosines[EVEN_MAX + SPARE], sines[EVEN_MAX + SPARE], turned[EVEN_MAX + SPARE];
    const float length = sqrtf(r.x * r.x + r.y * r.y); /* at the pole all azimuths are the same */
    const float cosine = length > 0.0f ? r.x / length : 1.0f, sine = length > 0.0f ? r.y / length : 0.0f;
    const float nx = cosine * n.x + sine * n.y, ny = cosine * n.y - sine * n.x, nz = r.z < 0.0f ? -n.z : n.z;
    clear(cosines + width - LANES);
    clear(sines + width - LANES);
    clear(turned + width);
    clear(weights + g->stride - LANES);
    powers(cosine, sine, g->order, cosines, sines);
#pragma omp simd
    for (size_t i = 0; i < width; i++) {
        float x = x0[i] + at.mix * (x1[i] - x0[i]), y = y0[i] + at.mix * (y1[i] - y0[i]),
              z = z0[i] + at.mix * (z1[i] - z0[i]);
        float even = nx * x + nz * z - (c0[i] + cut.mix * (c1[i] - c0[i])), odd = ny * y;
        weights[i] = cosines[i] * even - sines[i] * odd;
        turned[i] = sines[i] * even + cosines[i] * odd;
    }
    /* To the places of odd coefficients, which have no m = 0. */
    for (int l = 1; l < g->order && l < SL_HSH_ORDER_MAX; l++)
        memcpy(weights + sl_hsh_odd(g->order, l, -1), turned + sl_hsh_even(l, 1), LANES * sizeof(float));
}

static inline float sum_of_lanes(const float *lanes) {
    float sums[LANES];
    for (int l = 0; l < LANES; l++) sums[l] = lanes[l];
    for (int width = LANES / 2; width > 0; width /= 2) {
        for (int l = 0; l < width; l++) sums[l] += sums[l + width];
    }
    return sums[0];
}

/* The translation may change what a lobe reflects by half: gradients at a wall that is almost touched, or of
 * light that vanishes, say nothing any further away, and where they do the lobe would show it as a blot. */
static const float most_change = 0.5f;

/* sum over places of w (lambda + dx d/dx lambda + dy d/dy lambda) of one channel. */
static inline float reflect(const float *restrict w, const float *restrict lambda,
                            const float *restrict along_x, const float *restrict along_y, float dx, float dy,
                            size_t stride) {
    float lanes[LANES] = {0}, changes[LANES] = {0};
    for (size_t j = 0; j < stride; j += LANES) {
#pragma omp simd
        for (size_t l = 0; l < LANES; l++) {
            lanes[l] += w[j + l] * lambda[j + l];
            changes[l] += w[j + l] * (dx * along_x[j + l] + dy * along_y[j + l]);
        }
    }
    const float here = sum_of_lanes(lanes), change = sum_of_lanes(changes), most = most_change * fabsf(here);
    return here + (change < most ? (change > -most ? change : -most) : most);
}

void SL_KERNEL(sl_glossy_radiance)(const sl_glossy_view *view, const sl_glossy_record *record, size_t pixel,
                                   float radiance[3]) {
    const sl_glossy *g = view->glossy;
    const sl_splat_receivers *receivers = view->receivers;
    const sl_moved_lobe *lobe = g->lobe[view->material[pixel]];
    const sl_vec3 p =
        sl_v3(receivers->position_x[pixel], receivers->position_y[pixel], receivers->position_z[pixel]);
    const sl_vec3 n =
        sl_v3(receivers->normal_x[pixel], receivers->normal_y[pixel], receivers->normal_z[pixel]);
    const sl_frame *f = &record->frame;
    _Alignas(64) float weights[VECTOR_MAX + SPARE];
    radiance[0] = radiance[1] = radiance[2] = 0.0f;
    if (!lobe) return;
    const sl_vec3 from =
        view->gbuffer && view->gbuffer->seen_from ? view->gbuffer->seen_from[pixel] : view->eye;
    /* Shading normals can turn away from the eye at silhouettes; such a pixel reflects as at grazing view. */
    const sl_vec3 out = sl_normalize_or(sl_sub(from, p), n);
    const float up = sl_dot(out, n), seen = up > 0.0f ? up : 0.0f;
    const sl_vec3 mirrored = sl_sub(sl_scale(n, seen + up), out);
    move_lobe(g, lobe, sl_frame_to_local(f, mirrored), sl_frame_to_local(f, n), seen, weights);
    const sl_vec3 delta = sl_sub(p, record->position);
    const float dx = sl_dot(delta, f->x), dy = sl_dot(delta, f->y);
    const float *c = record->coefficients;
    for (size_t k = 0; k < 3; k++)
        radiance[k] = reflect(weights, c + k * g->stride, c + (3 + k) * g->stride, c + (6 + k) * g->stride,
                              dx, dy, g->stride);
}
