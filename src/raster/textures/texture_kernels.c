/* Many texture lookups, a block at a time, in two steps:
 *
 *     place    sixteen lookups together: wrapping, texel numbers, weights      (lanes are lookups)
 *     filter   one lookup after the other: 4 or 8 texels of 4 channels each    (lanes are channels)
 *
 * The second step needs no gather instructions, which on some processors are slower than loads: a texel of RGBA is
 * one load. A lookup between two MIP levels and one between two slices of a 3D texture have the same form: two
 * footprints of four texels and the weight of the second. Same arithmetic in the same order as lookup.c, so the same
 * bits. */
#include "raster/textures/lookup_kernels.h"
#include "raster/textures/texel_place.h"

enum { N = SL_TEXTURE_BLOCK };

/* Two footprints for each lookup: lower left, lower right, upper left, upper right of the first, then of the second. */
typedef struct {
    int32_t texel[8][N];
    double right[2][N], up[2][N];
    double blend[N];
} taps;

/* ---- filter ---- */

#ifdef __AVX2__
/* A texel, and its channels as doubles in one register, by the compiler's own vectors: its loops over four floats
 * would convert them in halves. */
typedef float four_floats __attribute__((vector_size(16), aligned(4), may_alias));
typedef double four_doubles __attribute__((vector_size(32)));
#define TEXEL(number) __builtin_convertvector(*(const four_floats *)(texels + 4 * (size_t)(number)), four_doubles)
#define MIX(a, b, t) ((a) + (t) * ((b) - (a))) /* sl_mix(), channel by channel */

/* Four texels of one footprint. */
static inline void filter_four(const float *texels, const taps *p, size_t n, float *rgba) {
    const double right = p->right[0][n], up = p->up[0][n];
    four_doubles a = TEXEL(p->texel[0][n]), b = TEXEL(p->texel[1][n]), c = TEXEL(p->texel[2][n]), d = TEXEL(p->texel[3][n]);
    four_doubles low = MIX(a, b, right), high = MIX(c, d, right);
    *(four_floats *)rgba = __builtin_convertvector(MIX(low, high, up), four_floats);
}

static inline void filter_eight(const float *texels, const taps *p, size_t n, float *rgba) {
    const double right = p->right[0][n], up = p->up[0][n], right2 = p->right[1][n], up2 = p->up[1][n], blend = p->blend[n];
    four_doubles a = TEXEL(p->texel[0][n]), b = TEXEL(p->texel[1][n]), c = TEXEL(p->texel[2][n]), d = TEXEL(p->texel[3][n]);
    four_doubles e = TEXEL(p->texel[4][n]), f = TEXEL(p->texel[5][n]), g = TEXEL(p->texel[6][n]), h = TEXEL(p->texel[7][n]);
    four_doubles low = MIX(a, b, right), high = MIX(c, d, right), low2 = MIX(e, f, right2), high2 = MIX(g, h, right2);
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

static inline void filter_four(const float *restrict texels, const taps *restrict p, size_t n, float *restrict rgba) {
#pragma omp simd
    for (int k = 0; k < 4; k++) rgba[k] = (float)filter_channel(texels, p, n, 0, k);
}

static inline void filter_eight(const float *restrict texels, const taps *restrict p, size_t n, float *restrict rgba) {
#pragma omp simd
    for (int k = 0; k < 4; k++) {
        rgba[k] = (float)sl_mix(filter_channel(texels, p, n, 0, k), filter_channel(texels, p, n, 1, k), p->blend[n]);
    }
}
#endif

static void filter(const float *texels, const taps *p, bool linear, size_t count, float (*restrict rgba)[4]) {
    for (size_t n = 0; n < count; n++) {
        if (p->blend[n] > 0.0) filter_eight(texels, p, n, rgba[n]);
        else if (linear) filter_four(texels, p, n, rgba[n]);
        else memcpy(rgba[n], texels + 4 * (size_t)p->texel[0][n], sizeof rgba[n]); /* as it stands, also where infinite or -0 */
    }
}

/* Where no lookup of the block blends. */
static void filter_fours(const float *texels, const taps *p, size_t count, float (*restrict rgba)[4]) {
    for (size_t n = 0; n < count; n++) filter_four(texels, p, n, rgba[n]);
}

/* Nearest lookups, one texel each. */
static void copy(const float *texels, const int32_t *texel, size_t count, float (*restrict rgba)[4]) {
    for (size_t n = 0; n < count; n++) memcpy(rgba[n], texels + 4 * (size_t)texel[n], sizeof rgba[n]);
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

static void find_levels(const float *restrict lod, int32_t count_of_levels, sl_mip mip, size_t count, levels *restrict out) {
    if (!lod || mip == SL_MIP_NONE) {
        memset(out, 0, sizeof *out);
        return;
    }
    int32_t *restrict fine = out->level[0], *restrict coarse = out->level[1];
    double *restrict blend = out->blend;
    if (mip == SL_MIP_NEAREST) {
        for (size_t n = 0; n < count; n++) fine[n] = coarse[n] = sl_level_nearest(lod[n], count_of_levels);
        memset(blend, 0, sizeof out->blend);
        return;
    }
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        sl_level_pair pair = sl_levels_around(lod[n], count_of_levels);
        fine[n] = pair.fine;
        coarse[n] = pair.coarse;
        blend[n] = pair.weight;
    }
}

static void place_linear(const sl_texture_image *image, sl_axis along_s, sl_axis along_t, size_t count, const float *restrict s,
                         const float *restrict t, const int32_t *restrict level, int which, taps *restrict p) {
    int32_t *restrict a = p->texel[4 * which], *restrict b = p->texel[4 * which + 1], *restrict c = p->texel[4 * which + 2],
            *restrict d = p->texel[4 * which + 3];
    double *restrict right = p->right[which], *restrict up = p->up[which];
    const int32_t *restrict widths = image->width, *restrict heights = image->height, *restrict firsts = image->first;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        int32_t width = widths[level[n]], first = firsts[level[n]];
        sl_texel_pair column = sl_texels_around(sl_wrapped(s[n], along_s), width, along_s);
        sl_texel_pair row = sl_texels_around(sl_wrapped(t[n], along_t), heights[level[n]], along_t);
        int32_t low = first + row.low * width, high = first + row.high * width;
        a[n] = low + column.low;
        b[n] = low + column.high;
        c[n] = high + column.low;
        d[n] = high + column.high;
        right[n] = column.weight;
        up[n] = row.weight;
    }
}

static void place_nearest(const sl_texture_image *image, sl_axis along_s, sl_axis along_t, size_t count, const float *restrict s,
                          const float *restrict t, const int32_t *restrict level, int32_t *restrict texel) {
    const int32_t *restrict widths = image->width, *restrict heights = image->height, *restrict firsts = image->first;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        int32_t width = widths[level[n]];
        int32_t column = sl_nearest_texel(sl_wrapped(s[n], along_s), width);
        int32_t row = sl_nearest_texel(sl_wrapped(t[n], along_t), heights[level[n]]);
        texel[n] = (firsts[level[n]] + row * width) + column;
    }
}

/* A nearest lookup between two levels: footprints of one texel. */
static void spread_nearest(int which, size_t count, taps *p) {
    for (int k = 1; k < 4; k++) memcpy(p->texel[4 * which + k], p->texel[4 * which], count * sizeof p->texel[0][0]);
    memset(p->right[which], 0, sizeof p->right[which]);
    memset(p->up[which], 0, sizeof p->up[which]);
}

static bool blends(const double *blend, size_t count) {
    bool any = false;
    for (size_t n = 0; n < count; n++) any |= blend[n] > 0.0;
    return any;
}

static void sample_texture(const sl_texture_image *image, sl_sampler sampler, size_t count, const float *s, const float *t,
                           const float *lod, float *const plane[4]) {
    taps p;
    levels l;
    float rgba[N][4];
    sl_axis along_s = sl_axis_of(sampler.wrap_s), along_t = sl_axis_of(sampler.wrap_t);
    find_levels(lod, image->levels, sampler.mip, count, &l);
    memcpy(p.blend, l.blend, sizeof p.blend);
    int sets = blends(l.blend, count) ? 2 : 1;
    for (int k = 0; k < sets; k++) {
        if (sampler.linear) {
            place_linear(image, along_s, along_t, count, s, t, l.level[k], k, &p);
        } else {
            place_nearest(image, along_s, along_t, count, s, t, l.level[k], p.texel[4 * k]);
            spread_nearest(k, count, &p);
        }
    }
    if (sets == 2) filter(image->texels, &p, sampler.linear, count, rgba);
    else if (sampler.linear) filter_fours(image->texels, &p, count, rgba);
    else copy(image->texels, p.texel[0], count, rgba);
    spread(rgba, count, plane);
}

/* ---- cube maps ---- */

typedef struct {
    int32_t face[N];
    double s[N], t[N];
} cube_places;

static void place_directions(size_t count, const float *restrict x, const float *restrict y, const float *restrict z,
                             cube_places *restrict out) {
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
    int32_t *restrict a = p->texel[4 * which], *restrict b = p->texel[4 * which + 1], *restrict c = p->texel[4 * which + 2],
            *restrict d = p->texel[4 * which + 3];
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

static void place_nearest_in_faces(const sl_cube_map *cube, size_t count, const cube_places *restrict place,
                                   const int32_t *restrict level, int32_t *restrict texel) {
    const int32_t *restrict sizes = cube->level_size, *restrict firsts = cube->first;
    const int32_t *restrict face = place->face;
    const double *restrict s = place->s, *restrict t = place->t;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        int32_t size = sizes[level[n]], side = size + 2, first = firsts[level[n]] + face[n] * (side * side);
        texel[n] = first + (sl_nearest_texel(t[n], size) + 1) * side + (sl_nearest_texel(s[n], size) + 1);
    }
}

static void sample_cube(const sl_cube_map *cube, sl_sampler sampler, size_t count, const float *x, const float *y,
                        const float *z, const float *lod, float *const plane[4]) {
    taps p;
    levels l;
    cube_places place;
    float rgba[N][4];
    find_levels(lod, cube->levels, sampler.mip, count, &l);
    memcpy(p.blend, l.blend, sizeof p.blend);
    place_directions(count, x, y, z, &place);
    int sets = blends(l.blend, count) ? 2 : 1;
    for (int k = 0; k < sets; k++) {
        if (sampler.linear) {
            place_in_faces(cube, count, &place, l.level[k], k, &p);
        } else {
            place_nearest_in_faces(cube, count, &place, l.level[k], p.texel[4 * k]);
            spread_nearest(k, count, &p);
        }
    }
    if (sets == 2) filter(cube->texels, &p, sampler.linear, count, rgba);
    else if (sampler.linear) filter_fours(cube->texels, &p, count, rgba);
    else copy(cube->texels, p.texel[0], count, rgba);
    spread(rgba, count, plane);
}

/* ---- 3D ---- */

static void place_in_volume(const sl_volume *volume, sl_sampler sampler, size_t count, const float *restrict s,
                            const float *restrict t, const float *restrict r, taps *restrict p) {
    int32_t width = volume->width, height = volume->height, depth = volume->depth;
    sl_axis along_s = sl_axis_of(sampler.wrap_s), along_t = sl_axis_of(sampler.wrap_t), along_r = sl_axis_of(sampler.wrap_r);
    int32_t *restrict a = p->texel[0], *restrict b = p->texel[1], *restrict c = p->texel[2], *restrict d = p->texel[3];
    int32_t *restrict e = p->texel[4], *restrict f = p->texel[5], *restrict g = p->texel[6], *restrict h = p->texel[7];
    double *restrict right = p->right[0], *restrict up = p->up[0], *restrict right2 = p->right[1], *restrict up2 = p->up[1];
    double *restrict blend = p->blend;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        sl_texel_pair column = sl_texels_around(sl_wrapped(s[n], along_s), width, along_s);
        sl_texel_pair row = sl_texels_around(sl_wrapped(t[n], along_t), height, along_t);
        sl_texel_pair slice = sl_texels_around(sl_wrapped(r[n], along_r), depth, along_r);
        int32_t low = slice.low * height, high = slice.high * height;
        int32_t row0 = (low + row.low) * width, row1 = (low + row.high) * width;
        int32_t row2 = (high + row.low) * width, row3 = (high + row.high) * width;
        a[n] = row0 + column.low;
        b[n] = row0 + column.high;
        c[n] = row1 + column.low;
        d[n] = row1 + column.high;
        e[n] = row2 + column.low;
        f[n] = row2 + column.high;
        g[n] = row3 + column.low;
        h[n] = row3 + column.high;
        right[n] = right2[n] = column.weight;
        up[n] = up2[n] = row.weight;
        blend[n] = slice.weight;
    }
}

static void place_nearest_in_volume(const sl_volume *volume, sl_sampler sampler, size_t count, const float *restrict s,
                                    const float *restrict t, const float *restrict r, int32_t *restrict texel) {
    int32_t width = volume->width, height = volume->height, depth = volume->depth;
    sl_axis along_s = sl_axis_of(sampler.wrap_s), along_t = sl_axis_of(sampler.wrap_t), along_r = sl_axis_of(sampler.wrap_r);
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        int32_t column = sl_nearest_texel(sl_wrapped(s[n], along_s), width);
        int32_t row = sl_nearest_texel(sl_wrapped(t[n], along_t), height);
        int32_t slice = sl_nearest_texel(sl_wrapped(r[n], along_r), depth);
        texel[n] = (slice * height + row) * width + column;
    }
}

/* The stored bytes as one number, red lowest whatever the machine's byte order. */
static void pack(const uint8_t *restrict bytes, const int32_t *restrict texel, size_t count, uint32_t *restrict out) {
    for (size_t n = 0; n < count; n++) {
        const uint8_t *restrict b = bytes + 4 * (size_t)texel[n];
        out[n] = (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    }
}

static inline double byte_of(uint32_t word, int shift) { return (double)(int32_t)(word >> shift & 255u); }

/* Bytes are small enough that lanes are lookups here too: eight words of four bytes each, channel after channel. */
static void filter_bytes(const sl_volume *volume, const taps *p, size_t count, float *const plane[4]) {
    uint32_t word[8][N];
    for (int k = 0; k < 8; k++) pack(volume->bytes, p->texel[k], count, word[k]);
    const uint32_t *restrict w0 = word[0], *restrict w1 = word[1], *restrict w2 = word[2], *restrict w3 = word[3];
    const uint32_t *restrict w4 = word[4], *restrict w5 = word[5], *restrict w6 = word[6], *restrict w7 = word[7];
    const double *restrict right = p->right[0], *restrict up = p->up[0], *restrict blend = p->blend;
    for (int c = 0; c < 4; c++) {
        float *restrict out = plane[c];
        int shift = 8 * c;
        if (!out) continue;
#pragma omp simd
        for (size_t n = 0; n < count; n++) {
            double low = sl_mix(byte_of(w0[n], shift), byte_of(w1[n], shift), right[n]);
            double high = sl_mix(byte_of(w2[n], shift), byte_of(w3[n], shift), right[n]);
            double low2 = sl_mix(byte_of(w4[n], shift), byte_of(w5[n], shift), right[n]);
            double high2 = sl_mix(byte_of(w6[n], shift), byte_of(w7[n], shift), right[n]);
            out[n] = (float)(sl_mix(sl_mix(low, high, up[n]), sl_mix(low2, high2, up[n]), blend[n]) / 255.0);
        }
    }
}

static void nearest_bytes(const sl_volume *volume, const int32_t *texel, size_t count, float *const plane[4]) {
    uint32_t word[N];
    pack(volume->bytes, texel, count, word);
    for (int c = 0; c < 4; c++) {
        float *restrict out = plane[c];
        for (size_t n = 0; out && n < count; n++) out[n] = (float)(byte_of(word[n], 8 * c) / 255.0);
    }
}

static void sample_volume(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                          const float *r, float *const plane[4]) {
    float rgba[N][4];
    taps p;
    if (sampler.linear) place_in_volume(volume, sampler, count, s, t, r, &p);
    else place_nearest_in_volume(volume, sampler, count, s, t, r, p.texel[0]);
    if (volume->format == SL_VOLUME_RGBA8) {
        if (sampler.linear) filter_bytes(volume, &p, count, plane);
        else nearest_bytes(volume, p.texel[0], count, plane);
        return;
    }
    if (sampler.linear) filter(volume->texels, &p, true, count, rgba);
    else copy(volume->texels, p.texel[0], count, rgba);
    spread(rgba, count, plane);
}

static void nearest_in_volume(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                              const float *r, uint32_t *bytes) {
    int32_t texel[N];
    place_nearest_in_volume(volume, sampler, count, s, t, r, texel);
    pack(volume->bytes, texel, count, bytes);
}

static inline int32_t clamp_index(int32_t i, int32_t n) {
    int32_t above = i < 0 ? 0 : i;
    return above < n ? above : n - 1;
}

static void fetch_in_volume(const sl_volume *volume, size_t count, const int32_t *restrict x, const int32_t *restrict y,
                            const int32_t *restrict z, uint32_t *bytes) {
    int32_t texel[N], width = volume->width, height = volume->height, depth = volume->depth;
#pragma omp simd
    for (size_t n = 0; n < count; n++) {
        texel[n] = (clamp_index(z[n], depth) * height + clamp_index(y[n], height)) * width + clamp_index(x[n], width);
    }
    pack(volume->bytes, texel, count, bytes);
}

/* ---- the table ---- */

void SL_KERNEL(sl_textured_coordinates)(const sl_resolve_block *block, const sl_view *view, sl_lod_rule rule, bool lod,
                                        sl_textured_block *textured);

extern const sl_texture_kernels SL_KERNEL(sl_texture_kernels);
const sl_texture_kernels SL_KERNEL(sl_texture_kernels) = {sample_texture, sample_cube, sample_volume, nearest_in_volume,
                                                          fetch_in_volume, SL_KERNEL(sl_textured_coordinates)};
