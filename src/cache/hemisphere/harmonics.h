/* Hemispherical harmonics H_lm and what radiance caching needs of them (Gautron, Krivanek, Pattanaik,
 * Bouatouch 2004: "A Novel Hemispherical Basis for Accurate and Efficient Rendering"; Krivanek et al. 2005:
 * "Radiance Caching for Efficient Global Illumination Computation"): the functions, orthonormal over the
 * hemisphere, and Phong lobes: how much of them an order leaves out, and a pixel's lobe as coefficients in a
 * record's frame, without rotating coefficients as the papers do.
 *
 * Order n means bands l = 0 .. n-1, n^2 functions. Coefficients stand in this order everywhere: first those
 * that go with cos(m phi), m = 0 .. l, band after band, n(n+1)/2 of them ("even"); then those that go with
 * sin(m phi), m = 1 .. l, n(n-1)/2 of them ("odd"). Even and odd ones never mix when a frame tilts. Vectors
 * of coefficients are padded with zeros to whole groups of sixteen floats. */
#pragma once

#include "base/vec.h"
#include "softlux.h"

#ifndef SL_HSH_ORDER_MAX /* a test raises it */
#define SL_HSH_ORDER_MAX 12
#endif
enum { SL_HSH_MAX = SL_HSH_ORDER_MAX * SL_HSH_ORDER_MAX, SL_HSH_STRIDE_MAX = (SL_HSH_MAX + 30) / 16 * 16 };

static inline size_t sl_hsh_even_count(int order) { return (size_t)order * ((size_t)order + 1) / 2; }
static inline size_t sl_hsh_odd_count(int order) { return (size_t)order * ((size_t)order - 1) / 2; }
/* Floats from one padded vector to the next: even and odd parts each padded, so that both start on a group.
 */
static inline size_t sl_hsh_odd_start(int order) { return (sl_hsh_even_count(order) + 15) / 16 * 16; }
static inline size_t sl_hsh_stride(int order) {
    return sl_hsh_odd_start(order) + (sl_hsh_odd_count(order) + 15) / 16 * 16;
}
/* Places of H_lm in a padded vector, m >= 0 and m < 0. */
static inline size_t sl_hsh_even(int l, int m) { return (size_t)l * ((size_t)l + 1) / 2 + (size_t)m; }
static inline size_t sl_hsh_odd(int order, int l, int m) {
    return sl_hsh_odd_start(order) + (size_t)l * ((size_t)l - 1) / 2 + (size_t)(-m - 1);
}

/* ---- the functions ---- */

/* The numbers of the recurrence: P_l^m = first[m][l] x P_(l-1)^m -
 * second[m][l] P_(l-2)^m, P_m^m = diagonal[m] s P_(m-1)^(m-1). */
typedef struct sl_hsh_recurrence {
    int order;
    double diagonal[SL_HSH_ORDER_MAX], first[SL_HSH_ORDER_MAX][SL_HSH_ORDER_MAX],
        second[SL_HSH_ORDER_MAX][SL_HSH_ORDER_MAX];
} sl_hsh_recurrence;
void sl_hsh_recurrence_of(int order, sl_hsh_recurrence *recurrence);
/* All n^2 functions in a unit direction of the local frame (z >= 0 along the normal; x, y tangential):
 * sl_hsh_stride(order) doubles (at most SL_HSH_STRIDE_MAX), padding 0. At the zenith and at the horizon too:
 * no division by sin theta, no root of a negative; a direction below the horizon counts as one on it, one
 * that is not a number as the zenith. */
void sl_hsh_evaluate_by(const sl_hsh_recurrence *recurrence, sl_vec3d direction, double *values);

/* ---- Phong lobes ---- */

/* Returns the relative L2 error of the lobe that order n makes, at an outgoing angle of 45 degrees; and the
 * least order that keeps it within a bound (at most SL_HSH_ORDER_MAX, which may not suffice: ask for its
 * truncation; for exponents below 1, whose edge counts for more in that error than in what they reflect, the
 * order for 1 and two more). An exponent that is negative or not a number counts as 0. */
double sl_phong_truncation(int order, double exponent);
int sl_phong_order(double exponent, double largest_error);

/* Tables of lobes have 64 polar angles, evenly from 0 to 90 degrees. What belongs to a cosine lies between
 * two rows: first[i] + mix (second[i] - first[i]). */
enum { SL_PHONG_ANGLES = 64 };
typedef struct sl_phong_rows {
    const float *first, *second;
    float mix;
} sl_phong_rows;

/* A pixel's frame enters its lobe times its cosine, (s+2)/(2 pi) max(0, r . w)^s max(0, n . w), by the mirror
 * direction r, and by its normal n, linearly but where it cuts the lobe at the pixel's horizon. So the
 * coefficients in any other frame, a record's, are known without a rotation: look up the lobe's products with
 * w_x, w_y and w_z for where r is, and mix them by n. Directions below the record's horizon take their mirror
 * images' light. Of order n^2, where D takes n^4. */
typedef struct sl_moved_lobe sl_moved_lobe;
sl_status sl_moved_lobe_create(int order, double exponent, sl_moved_lobe **lobe, sl_error *error);
void sl_moved_lobe_destroy(sl_moved_lobe *lobe); /* NULL is allowed */
size_t sl_moved_lobe_bytes(const sl_moved_lobe *lobe);
/* Rows for the polar angle of r (cosine, of either sign: the angle from the nearer pole counts) and, of
 * `cut`, for the outgoing angle at the pixel (cosine n . w_o). Each row holds four vectors of
 * sl_hsh_odd_start(order) floats, all in the places of even coefficients: X, Y, Z, and the cut-off part C.
 * With n' the pixel's normal in the record's frame turned so that r has azimuth 0, and n'_z of the other sign
 * where r is below the horizon, e = n'_x X + n'_z Z - C    o = n'_y Y and, turned back to the azimuth phi of
 * r, H_lm has the coefficient cos(m phi) e - sin(m phi) o, H_l-m sin(m phi) e + cos(m phi) o. */
sl_phong_rows sl_moved_lobe_at(const sl_moved_lobe *lobe, float cosine);
