/* Many texture lookups, a block at a time, in two steps:
 *
 *     place    sixteen lookups together: texel numbers, weights      (lanes are lookups)
 *     filter   one lookup after the other: 4 texels of 4 channels    (lanes are channels)
 *
 * The second step needs no gather instructions, which on some processors are slower than loads: a texel of
 * RGBA is one load. */
#include "raster/textures/textures.h"

enum { N = SL_TEXTURE_BLOCK };

/* The four texels of each lookup: lower left, lower right, upper left, upper right. */
typedef struct {
    int32_t texel[4][N];
    double right[N], up[N];
} taps;

/* ---- place ---- */

/* The coordinate in [0,1]. NaN falls to the lower end. */
static inline double clamped(float u) {
    float cut = u > 0.0f ? u : 0.0f;
    return (double)(cut < 1.0f ? cut : 1.0f);
}

/* The two texels around x in [0,1], and the weight of the second. x n - 1/2 is the position in texel centres;
 * half a texel is added instead of taken away, so that truncation rounds down. Every step in double is exact.
 */
typedef struct {
    int32_t low, high;
    double weight;
} texel_pair;

static inline texel_pair texels_around(double x, int32_t n) {
    double position = x * (double)n + 0.5;
    int32_t i = (int32_t)position; /* 0 ... n */
    return (texel_pair){i == 0 ? 0 : i - 1, i == n ? n - 1 : i, position - (double)i};
}

static void place(const sl_texture_image *image, size_t count, const float *restrict s,
                  const float *restrict t, taps *restrict p) {
    int32_t *restrict a = p->texel[0], *restrict b = p->texel[1], *restrict c = p->texel[2],
                      *restrict d = p->texel[3];
    double *restrict right = p->right, *restrict up = p->up;
    const int32_t width = image->width, height = image->height;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        texel_pair column = texels_around(clamped(s[n]), width), row = texels_around(clamped(t[n]), height);
        a[n] = row.low * width + column.low;
        b[n] = row.low * width + column.high;
        c[n] = row.high * width + column.low;
        d[n] = row.high * width + column.high;
        right[n] = column.weight;
        up[n] = row.weight;
    }
}

/* ---- filter ---- */

#ifdef __AVX2__
/* A texel, and its channels as doubles in one register, by the compiler's own vectors: its loops over four
 * floats would convert them in halves. */
typedef float four_floats __attribute__((vector_size(16), aligned(4), may_alias));
typedef double four_doubles __attribute__((vector_size(32)));
#define TEXEL(number) \
    __builtin_convertvector(*(const four_floats *)(texels + 4 * (size_t)(number)), four_doubles)
#define MIX(a, b, t) ((a) + (t) * ((b) - (a))) /* mix(), channel by channel */

static inline void filter_four(const float *texels, const taps *p, size_t n, float *rgba) {
    const double right = p->right[n], up = p->up[n];
    four_doubles a = TEXEL(p->texel[0][n]), b = TEXEL(p->texel[1][n]), c = TEXEL(p->texel[2][n]),
                 d = TEXEL(p->texel[3][n]);
    four_doubles low = MIX(a, b, right), high = MIX(c, d, right);
    *(four_floats *)rgba = __builtin_convertvector(MIX(low, high, up), four_floats);
}
#else
static inline double mix(double a, double b, double t) { return a + t * (b - a); }

/* The same with what vectors there are. */
static inline void filter_four(const float *restrict texels, const taps *restrict p, size_t n,
                               float *restrict rgba) {
#pragma omp simd
    for (int k = 0; k < 4; k++) {
        const float *t = texels + k;
        double a = (double)t[4 * (size_t)p->texel[0][n]], b = (double)t[4 * (size_t)p->texel[1][n]];
        double c = (double)t[4 * (size_t)p->texel[2][n]], d = (double)t[4 * (size_t)p->texel[3][n]];
        rgba[k] = (float)mix(mix(a, b, p->right[n]), mix(c, d, p->right[n]), p->up[n]);
    }
}
#endif

void SL_KERNEL(sl_texture_sample)(const sl_texture_image *image, size_t count, const float *s, const float *t,
                                  float *const plane[4]) {
    taps p;
    float rgba[N][4];
    place(image, count, s, t, &p);
    for (size_t n = 0; n < count; n++) filter_four(image->texels, &p, n, rgba[n]);
    for (int c = 0; c < 4; c++) {
        float *restrict out = plane[c];
        for (size_t n = 0; out && n < count; n++) out[n] = rgba[n][c];
    }
}
