/* Real spherical harmonics of bands 0 to 3, as polynomials of a unit direction; orthonormal over the sphere. For kernels too: inline, no
 * branches. And what a clamped cosine, or its power, makes of a band: zonal coefficients of max(0, cos)^s with unit integral. */
#ifndef SL_CACHE_LIGHT_OCTREE_HARMONIC_BASIS_H
#define SL_CACHE_LIGHT_OCTREE_HARMONIC_BASIS_H

static inline void sl_harmonic_basis(float x, float y, float z, float v[16]) {
    v[0] = 0.28209479f;
    v[1] = 0.48860251f * y;
    v[2] = 0.48860251f * z;
    v[3] = 0.48860251f * x;
    v[4] = 1.09254843f * x * y;
    v[5] = 1.09254843f * y * z;
    v[6] = 0.31539157f * (3.0f * z * z - 1.0f);
    v[7] = 1.09254843f * x * z;
    v[8] = 0.54627422f * (x * x - y * y);
    v[9] = 0.59004359f * y * (3.0f * x * x - y * y);
    v[10] = 2.89061144f * x * y * z;
    v[11] = 0.45704580f * y * (5.0f * z * z - 1.0f);
    v[12] = 0.37317633f * z * (5.0f * z * z - 3.0f);
    v[13] = 0.45704580f * x * (5.0f * z * z - 1.0f);
    v[14] = 1.44530572f * z * (x * x - y * y);
    v[15] = 0.59004359f * x * (x * x - 3.0f * y * y);
}

/* Integral of max(0, cos)^s P_l(cos) over the sphere, divided by that of max(0, cos)^s: 1, (s+1)/(s+2), and so on by the moments of
 * cos over [0,1], integral of t^(s+k) dt = 1 / (s+k+1). */
static inline void sl_harmonic_lobe(float s, float band[4]) {
    float m1 = (s + 1.0f) / (s + 2.0f), m2 = (s + 1.0f) / (s + 3.0f), m3 = (s + 1.0f) / (s + 4.0f);
    band[0] = 1.0f;
    band[1] = m1;
    band[2] = 1.5f * m2 - 0.5f;
    band[3] = 2.5f * m3 - 1.5f * m1;
}

#endif
