/* What the tests of tilted frames share. Include it after cmocka.h. */
#ifndef SL_TESTS_HARMONICS_SUPPORT_H
#define SL_TESTS_HARMONICS_SUPPORT_H

#include <string.h>

#include "base/math.h"
#include "cache/hemisphere/harmonics.h"

static const double degree = SL_PI / 180.0;

static inline sl_hsh_rotation *rotation_new(int order, double largest_degrees, sl_hsh_fill fill) {
    sl_hsh_rotation *r = NULL;
    assert_int_equal(sl_hsh_rotation_create(order, largest_degrees * degree, fill, 2, &r, NULL), SL_OK);
    return r;
}

static inline double entry_of(const float *const *parts, float mix, size_t place) {
    return (double)parts[0][place] + (double)mix * ((double)parts[1][place] - (double)parts[0][place]);
}

/* u = D^T v, as the header says. */
static inline void tilt_back(const sl_hsh_rotation *rotation, int order, double beta, const double *v, double *u) {
    sl_hsh_tilt t = sl_hsh_tilt_at(rotation, (float)beta);
    size_t odd_start = sl_hsh_odd_start(order), stride = sl_hsh_stride(order), odd_width = stride - odd_start;
    memset(u, 0, stride * sizeof *u);
    for (size_t i = 0; i < sl_hsh_even_count(order); i++)
        for (size_t j = 0; j < odd_start; j++) u[j] += v[i] * entry_of(t.even, t.mix, i * odd_start + j);
    for (size_t i = 0; i < sl_hsh_odd_count(order); i++)
        for (size_t j = 0; j < odd_width; j++) u[odd_start + j] += v[odd_start + i] * entry_of(t.odd, t.mix, i * odd_width + j);
}

/* R_y(beta) a: from the tilted frame to the record's. */
static inline sl_vec3d tilted(sl_vec3d a, double beta) {
    double c = cos(beta), s = sin(beta);
    return sl_v3d(c * a.x + s * a.z, a.y, -s * a.x + c * a.z);
}

#endif
