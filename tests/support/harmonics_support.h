/* Hemispherical harmonics and a lobe's coefficients in plain loops, for tests to compare with. */
#pragma once

#include <math.h>
#include <string.h>

#include "cache/hemisphere/harmonics.h"

static inline void hsh_evaluate(int order, sl_vec3d direction, double *values) {
    sl_hsh_recurrence r;
    sl_hsh_recurrence_of(order, &r);
    sl_hsh_evaluate_by(&r, direction, values);
}

/* The coefficients of sl_moved_lobe_at(): r and n in the record's frame, cosine n . w_o. */
static inline void moved_lobe_look_up(const sl_moved_lobe *t, int order, sl_vec3 r, sl_vec3 n, float cosine,
                                      float *coefficients) {
    sl_phong_rows at = sl_moved_lobe_at(t, r.z), cut = sl_moved_lobe_at(t, cosine > 0.0f ? cosine : 0.0f);
    float length = sqrtf(r.x * r.x + r.y * r.y), c = length > 0.0f ? r.x / length : 1.0f,
          s = length > 0.0f ? r.y / length : 0.0f;
    float nx = c * n.x + s * n.y, ny = c * n.y - s * n.x, nz = r.z < 0.0f ? -n.z : n.z;
    float cos_m = 1.0f, sin_m = 0.0f;
    memset(coefficients, 0, sl_hsh_stride(order) * sizeof *coefficients);
    for (int m = 0; m < order; m++) {
        for (int l = m; l < order; l++) {
            size_t i = sl_hsh_even(l, m), w = sl_hsh_odd_start(order);
            float x = at.first[i] + at.mix * (at.second[i] - at.first[i]);
            float y = at.first[i + w] + at.mix * (at.second[i + w] - at.first[i + w]);
            float z = at.first[i + 2 * w] + at.mix * (at.second[i + 2 * w] - at.first[i + 2 * w]);
            float below = cut.first[i + 3 * w] + cut.mix * (cut.second[i + 3 * w] - cut.first[i + 3 * w]);
            float even = nx * x + nz * z - below, odd = ny * y;
            coefficients[i] = cos_m * even - sin_m * odd;
            if (m > 0) coefficients[sl_hsh_odd(order, l, -m)] = sin_m * even + cos_m * odd;
        }
        float turned = cos_m * c - sin_m * s;
        sin_m = sin_m * c + cos_m * s;
        cos_m = turned;
    }
}
