/* Many texture lookups, a block at a time, in two steps:
 *
 *     place    sixteen lookups together: wrapping, texel numbers, weights      (lanes are lookups)
 *     filter   one lookup after the other: 4 or 8 texels of 4 channels each    (lanes are channels)
 *
 * The second step needs no gather instructions, which on some processors are slower than loads: a texel of
 * RGBA is one load. A lookup between two MIP levels is two footprints of four texels and the weight of the
 * second. Same arithmetic in the same order as lookup.c, so the same bits. */
#include <string.h>

#include "raster/textures/textures.h"
#include "raster/textures/texel_place.h"

enum { N = SL_TEXTURE_BLOCK };

/* Two footprints for each lookup: lower left, lower right, upper left, upper right of the first, then of the
 * second. */
typedef struct {
    int32_t texel[8][N];
    double right[2][N], up[2][N];
    double blend[N];
} taps;

/* ---- filter ---- */

#ifdef __AVX2__
/* A texel, and its channels as doubles in one register, by the compiler's own vectors: its loops over four
 * floats would convert them in halves. */
typedef float four_floats __attribute__((vector_size(16), aligned(4), may_alias));
typedef double four_doubles __attribute__((vector_size(32)));
#define TEXEL(number) \
    __builtin_convertvector(*(const four_floats *)(texels + 4 * (size_t)(number)), four_doubles)
#define MIX(a, b, t) ((a) + (t) * ((b) - (a))) /* sl_mix(), channel by channel */

/* Four texels of one footprint. */
static inline void filter_four(const float *texels, const taps *p, size_t n, float *rgba) {
    const double right = p->right[0][n], up = p->up[0][n];
    four_doubles a = TEXEL(p->texel[0][n]), b = TEXEL(p->texel[1][n]), c = TEXEL(p->texel[2][n]),
                 d = TEXEL(p->texel[3][n]);
    four_doubles low = MIX(a, b, right), high = MIX(c, d, right);
    *(four_floats *)rgba = __builtin_convertvector(MIX(low, high, up), four_floats);
}

static inline void filter_eight(const float *texels, const taps *p, size_t n, float *rgba) {
    const double right = p->right[0][n], up = p->up[0][n], right2 = p->right[1][n], up2 = p->up[1][n],
                 blend = p->blend[n];
    four_doubles a = TEXEL(p->texel[0][n]), b = TEXEL(p->texel[1][n]), c = TEXEL(p->texel[2][n]),
                 d = TEXEL(p->texel[3][n]);
    four_doubles e = TEXEL(p->texel[4][n]), f = TEXEL(p->texel[5][n]), g = TEXEL(p->texel[6][n]),
                 h = TEXEL(p->texel[7][n]);
    four_doubles low = MIX(a, b, right), high = MIX(c, d, right), low2 = MIX(e, f, right2),
                 high2 = MIX(g, h, right2);
    four_doubles first = MIX(low, high, up), second = MIX(low2, high2, up2);
    *(four_floats *)rgba = __builtin_convertvector(MIX(first, second, blend), four_floats);
}
#else
/* The same with what vectors there are. */
static inline double filter_channel(const float *texels, const taps *p, size_t n, int which, int channel) {
    const float *t = texels + channel;
    int k = 4 * which;
    double a = (double)t[4 * (size_t)p->texel[k][n]], b = (double)t[4 * (size_t)p->texel[k + 1][n]];
    double c = (double)t[4 * (size_t)p->texel[k + 2][n]], d = (double)t[4 * (size_t)p->texel[k + 3][n]];
    return sl_mix(sl_mix(a, b, p->right[which][n]), sl_mix(c, d, p->right[which][n]), p->up[which][n]);
}

static inline void filter_four(const float *restrict texels, const taps *restrict p, size_t n,
                               float *restrict rgba) {
#pragma omp simd
    for (int k = 0; k < 4; k++) rgba[k] = (float)filter_channel(texels, p, n, 0, k);
}

static inline void filter_eight(const float *restrict texels, const taps *restrict p, size_t n,
                                float *restrict rgba) {
#pragma omp simd
    for (int k = 0; k < 4; k++) {
        rgba[k] = (float)sl_mix(filter_channel(texels, p, n, 0, k), filter_channel(texels, p, n, 1, k),
                                p->blend[n]);
    }
}
#endif

static void filter(const float *texels, const taps *p, size_t count, float (*restrict rgba)[4]) {
    for (size_t n = 0; n < count; n++) {
        if (p->blend[n] > 0.0) filter_eight(texels, p, n, rgba[n]);
        else filter_four(texels, p, n, rgba[n]);
    }
}

/* Where no lookup of the block blends. */
static void filter_fours(const float *texels, const taps *p, size_t count, float (*restrict rgba)[4]) {
    for (size_t n = 0; n < count; n++) filter_four(texels, p, n, rgba[n]);
}

static void spread(float (*restrict rgba)[4], size_t count, float *const plane[4]) {
    for (int c = 0; c < 4; c++) {
        float *restrict out = plane[c];
        for (size_t n = 0; out && n < count; n++) out[n] = rgba[n][c];
    }
}

/* ---- 2D ---- */

typedef struct {
    int32_t level[2][N];
    double blend[N];
} levels;

static void find_levels(const float *restrict lod, int32_t count_of_levels, size_t count,
                        levels *restrict out) {
    if (!lod || count_of_levels == 1) {
        memset(out, 0, sizeof *out);
        return;
    }
    int32_t *restrict fine = out->level[0], *restrict coarse = out->level[1];
    double *restrict blend = out->blend;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        sl_level_pair pair = sl_levels_around(lod[n], count_of_levels);
        fine[n] = pair.fine;
        coarse[n] = pair.coarse;
        blend[n] = pair.weight;
    }
}

static void place_linear(const sl_texture_image *image, size_t count, const float *restrict s,
                         const float *restrict t, const int32_t *restrict level, int which,
                         taps *restrict p) {
    int32_t *restrict a = p->texel[4 * which], *restrict b = p->texel[4 * which + 1],
                      *restrict c = p->texel[4 * which + 2], *restrict d = p->texel[4 * which + 3];
    double *restrict right = p->right[which], *restrict up = p->up[which];
    const int32_t *restrict widths = image->width, *restrict heights = image->height,
                            *restrict firsts = image->first;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        int32_t width = widths[level[n]], first = firsts[level[n]];
        sl_texel_pair column = sl_texels_around(sl_clamped(s[n]), width);
        sl_texel_pair row = sl_texels_around(sl_clamped(t[n]), heights[level[n]]);
        int32_t low = first + row.low * width, high = first + row.high * width;
        a[n] = low + column.low;
        b[n] = low + column.high;
        c[n] = high + column.low;
        d[n] = high + column.high;
        right[n] = column.weight;
        up[n] = row.weight;
    }
}

static bool blends(const double *blend, size_t count) {
    bool any = false;
    for (size_t n = 0; n < count; n++) any |= blend[n] > 0.0;
    return any;
}

/* The rest of a lookup, when levels and places are known. */
static void filter_and_spread(const float *texels, const taps *p, int sets, size_t count,
                              float *const plane[4]) {
    float rgba[N][4];
    if (sets == 2) filter(texels, p, count, rgba);
    else filter_fours(texels, p, count, rgba);
    spread(rgba, count, plane);
}

static void sample_texture(const sl_texture_image *image, size_t count, const float *s, const float *t,
                           const float *lod, float *const plane[4]) {
    taps p;
    levels l;
    find_levels(lod, image->levels, count, &l);
    memcpy(p.blend, l.blend, count * sizeof *p.blend);
    int sets = blends(l.blend, count) ? 2 : 1;
    for (int k = 0; k < sets; k++) place_linear(image, count, s, t, l.level[k], k, &p);
    filter_and_spread(image->texels, &p, sets, count, plane);
}

/* ---- cube maps ---- */

typedef struct {
    int32_t face[N];
    double s[N], t[N];
} cube_places;

static void place_directions(size_t count, const float *restrict x, const float *restrict y,
                             const float *restrict z, cube_places *restrict out) {
    int32_t *restrict face = out->face;
    double *restrict s = out->s, *restrict t = out->t;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        sl_cube_place p = sl_cube_place_of(x[n], y[n], z[n]);
        face[n] = p.face;
        s[n] = p.s;
        t[n] = p.t;
    }
}

/* Texels are numbered with the border: texel (x, y) of a face is (x + 1, y + 1) there. */
static void place_in_faces(const sl_cube_map *cube, size_t count, const cube_places *restrict place,
                           const int32_t *restrict level, int which, taps *restrict p) {
    int32_t *restrict a = p->texel[4 * which], *restrict b = p->texel[4 * which + 1],
                      *restrict c = p->texel[4 * which + 2], *restrict d = p->texel[4 * which + 3];
    double *restrict right = p->right[which], *restrict up = p->up[which];
    const int32_t *restrict sizes = cube->level_size, *restrict firsts = cube->first;
    const int32_t *restrict face = place->face;
    const double *restrict s = place->s, *restrict t = place->t;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        int32_t size = sizes[level[n]], side = size + 2, first = firsts[level[n]] + face[n] * (side * side);
        double x = s[n] * (double)size + 0.5, y = t[n] * (double)size + 0.5;
        int32_t column = (int32_t)x, row = (int32_t)y, corner = first + row * side + column;
        a[n] = corner;
        b[n] = corner + 1;
        c[n] = corner + side;
        d[n] = corner + side + 1;
        right[n] = x - (double)column;
        up[n] = y - (double)row;
    }
}

static void sample_cube(const sl_cube_map *cube, size_t count, const float *x, const float *y, const float *z,
                        const float *lod, float *const plane[4]) {
    taps p;
    levels l;
    cube_places place;
    find_levels(lod, cube->levels, count, &l);
    memcpy(p.blend, l.blend, count * sizeof *p.blend);
    place_directions(count, x, y, z, &place);
    int sets = blends(l.blend, count) ? 2 : 1;
    for (int k = 0; k < sets; k++) place_in_faces(cube, count, &place, l.level[k], k, &p);
    filter_and_spread(cube->texels, &p, sets, count, plane);
}

extern const sl_texture_kernels SL_KERNEL(sl_texture_kernels);
const sl_texture_kernels SL_KERNEL(sl_texture_kernels) = {sample_texture, sample_cube};
