/* Reduction of a pbuffer by repeated 2x2 sums (the papers' way to sum on graphics hardware), and the turn
 * from the target's row order into an image's. */
#include <string.h>

#include "base/counters.h"
#include "raster/raster.h"

/* The hardware halves the whole picture, then the half, and so on. A sum's operands are the same if a strip
 * of STRIP rows goes through several halvings before the next strip is looked at, and what lies between two
 * halvings then stays in the first cache. */
enum { STRIP = 16 };

/* 2x2 sums of `rows` rows (even) of `width` pixels (even) into rows / 2 rows of width / 2. */
typedef void halve_kernel(const float *in, int width, int rows, float *out);
SL_KERNEL_VARIANTS(halve_kernel, sl_raster_halve);

/* rows (a power of two) rows of a plane to one row of `width / rows` sums; strip: room for the halvings
 * between. */
static void reduce_strip(halve_kernel *halve, const float *in, int width, int rows, float *strip,
                         float *out) {
    float *between[2] = {strip, strip + (size_t)(width / 2) * (size_t)(rows / 2)};
    for (int now = 0; rows > 1; now = 1 - now, rows /= 2, width /= 2) {
        float *to = rows == 2 ? out : between[now];
        halve(in, width, rows, to);
        in = to;
    }
}

/* scratch: size*size/2. The strips and what STRIP rows each leave behind take size*size (1/4 + 1/16 + 1/256 +
 * 1/65536) at most. */
static void reduce_plane(halve_kernel *halve, const float *plane, int size, int final, float *scratch,
                         float *out) {
    size_t pixels = (size_t)size * (size_t)size;
    float *strip = scratch,
          *kept[2] = {scratch + pixels / 4 + pixels / 16, scratch + pixels / 4 + pixels / 16 + pixels / 256};
    for (int now = 0; size > final; now = 1 - now) {
        int rows = size / final < STRIP ? size / final : STRIP, left = size / rows;
        float *to = left == final ? out : kept[now];
        for (int y = 0; y < left; y++) {
            reduce_strip(halve, plane + (size_t)(y * rows) * (size_t)size, size, rows, strip,
                         to + (size_t)y * (size_t)left);
        }
        plane = to;
        size = left;
    }
}

void sl_raster_reduce(const float *planes, int size, int channels, int final, float *scratch, float *out,
                      sl_counters *counters) {
    halve_kernel *halve = SL_KERNEL_OF(sl_isa_best(), sl_raster_halve);
    size_t pixels = (size_t)size * (size_t)size, left = (size_t) final * (size_t) final,
           depth = (size_t)channels;
    if (size == final) memcpy(out, planes, depth * left * sizeof *out);
    for (size_t c = 0; size > final && c < depth; c++)
        reduce_plane(halve, planes + c * pixels, size, final, scratch, out + c * left);
    /* A fragment sums all planes of its pixel. */
    for (int at = size; at > final; at /= 2)
        sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (uint64_t)(at / 2) * (uint64_t)(at / 2));
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, depth * left * sizeof *out);
}

void sl_raster_flip(const float *plane, int width, int height, float *image_plane) {
    size_t row = (size_t)width;
    for (int y = 0; y < height; y++) {
        memcpy(image_plane + (size_t)y * row, plane + (size_t)(height - 1 - y) * row, row * sizeof *plane);
    }
}
