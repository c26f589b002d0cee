/* 2D textures; 3D textures of bytes. */
#include "base/error.h"
#include "base/memory.h"
#include "raster/textures/textures.h"

sl_status sl_texture_image_create(int width, int height, sl_texture_image **image, sl_error *error) {
    *image = NULL;
    if (width < 1 || height < 1 || width > SL_TEXTURE_SIZE_MAX || height > SL_TEXTURE_SIZE_MAX) {
        return sl_fail(error, SL_ERROR_USAGE, "a texture of %d x %d texels: from 1 to %d each way", width,
                       height, (int)SL_TEXTURE_SIZE_MAX);
    }
    sl_texture_image *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "a texture");
    *m = (sl_texture_image){width, height,
                            sl_allocate((size_t)width * (size_t)height, 4 * sizeof *m->texels)};
    if (!m->texels) {
        sl_texture_image_destroy(m);
        return sl_fail_memory(error, "a texture");
    }
    *image = m;
    return SL_OK;
}

void sl_texture_image_destroy(sl_texture_image *image) {
    if (!image) return;
    sl_free(image->texels);
    sl_free(image);
}

/* The coordinate in [0,1]. NaN falls to the lower end. */
static double clamped(float u) {
    float cut = u > 0.0f ? u : 0.0f;
    return (double)(cut < 1.0f ? cut : 1.0f);
}

/* The two texels around x in [0,1], and the weight of the second. x n - 1/2 is the position in texel centres;
 * half a texel is added instead of taken away, so that truncation rounds down. Every step in double is exact.
 */
typedef struct texel_pair {
    int low, high;
    double weight;
} texel_pair;

static texel_pair texels_around(double x, int n) {
    double position = x * (double)n + 0.5;
    int i = (int)position; /* 0 ... n */
    return (texel_pair){i == 0 ? 0 : i - 1, i == n ? n - 1 : i, position - (double)i};
}

static double mix(double a, double b, double t) { return a + t * (b - a); }

void sl_texture_image_sample(const sl_texture_image *image, float s, float t, float rgba[4]) {
    const texel_pair column = texels_around(clamped(s), image->width),
                     row = texels_around(clamped(t), image->height);
    const float *low = image->texels + 4 * (size_t)row.low * (size_t)image->width,
                *high = image->texels + 4 * (size_t)row.high * (size_t)image->width;
    const size_t left = 4 * (size_t)column.low, right = 4 * (size_t)column.high;
    for (size_t c = 0; c < 4; c++) {
        double below = mix((double)low[left + c], (double)low[right + c], column.weight),
               above = mix((double)high[left + c], (double)high[right + c], column.weight);
        rgba[c] = (float)mix(below, above, row.weight);
    }
}

/* ---- 3D textures ---- */

sl_status sl_volume_create(int width, int height, int depth, sl_volume **volume, sl_error *error) {
    *volume = NULL;
    bool fits = width >= 1 && height >= 1 && depth >= 1 && width <= SL_TEXTURE_SIZE_MAX &&
                height <= SL_TEXTURE_SIZE_MAX && depth <= SL_TEXTURE_SIZE_MAX &&
                (int64_t)width * height * depth <= INT32_MAX;
    if (!fits) {
        return sl_fail(error, SL_ERROR_USAGE,
                       "a 3D texture of %d x %d x %d texels: from 1 to %d each way, less than 2^31", width,
                       height, depth, (int)SL_TEXTURE_SIZE_MAX);
    }
    sl_volume *v = sl_allocate(1, sizeof *v);
    if (v)
        *v =
            (sl_volume){width, height, depth, sl_allocate((size_t)width * (size_t)height * (size_t)depth, 4)};
    if (!v || !v->bytes) {
        sl_volume_destroy(v);
        return sl_fail_memory(error, "a 3D texture");
    }
    *volume = v;
    return SL_OK;
}

void sl_volume_destroy(sl_volume *volume) {
    if (!volume) return;
    sl_free(volume->bytes);
    sl_free(volume);
}

static size_t clamp_index(int i, int n) { return (size_t)(i < 0 ? 0 : i < n ? i : n - 1); }

uint32_t sl_volume_fetch(const sl_volume *volume, int x, int y, int z) {
    size_t row = clamp_index(z, volume->depth) * (size_t)volume->height + clamp_index(y, volume->height);
    const uint8_t *b = volume->bytes + 4 * (row * (size_t)volume->width + clamp_index(x, volume->width));
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}
