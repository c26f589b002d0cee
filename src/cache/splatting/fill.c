/* Pixels that no record has reached yet, in a picture that was stopped early, take the mean of what surrounds
 * them: push sums of (w E, w) with w = 1 for covered pixels down a pyramid of 2x2 sums, then pull the coarser
 * mean wherever the finer level has nothing. Irradiance is filled, not radiance, so textures stay sharp. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/splatting/splatting.h"

enum { R, G, B, W, SUMS };

typedef struct {
    int width, height;
    float (*sum)[SUMS];
} level;

static size_t pixels_of(const level *l) { return (size_t)l->width * (size_t)l->height; }

/* Sums 2x2 pixels of the finer level; an odd last column or row is summed alone. */
static void push(const level *fine, const level *coarse) {
    for (size_t from = 0; from < pixels_of(fine); from++) {
        size_t x = from % (size_t)fine->width, y = from / (size_t)fine->width;
        float *to = coarse->sum[y / 2 * (size_t)coarse->width + x / 2];
        for (int c = 0; c < SUMS; c++) to[c] += fine->sum[from][c];
    }
}

/* The mean of the four coarse pixels nearest to a fine one, by the shares of a tent (9, 3, 3 and 1
 * sixteenths): the coarser level's squares do not show. Weight 0 where none of them has anything. */
static void tent(const level *coarse, int x, int y, float mean[SUMS]) {
    float sums[SUMS] = {0.0f, 0.0f, 0.0f, 0.0f};
    const int step_x = x % 2 ? 1 : -1, step_y = y % 2 ? 1 : -1;
    for (int k = 0; k < 4; k++) {
        int cx = x / 2 + (k & 1 ? step_x : 0), cy = y / 2 + (k & 2 ? step_y : 0);
        if (cx < 0 || cy < 0 || cx >= coarse->width || cy >= coarse->height) continue;
        const float *at = coarse->sum[(size_t)cy * (size_t)coarse->width + (size_t)cx];
        if (!(at[W] > 0.0f)) continue;
        float share = (k & 1 ? 1.0f : 3.0f) * (k & 2 ? 1.0f : 3.0f), over = share / at[W];
        for (int c = R; c <= B; c++) sums[c] += at[c] * over;
        sums[W] += share;
    }
    for (int c = R; c <= B; c++) mean[c] = sums[W] > 0.0f ? sums[c] / sums[W] : 0.0f;
    mean[W] = sums[W] > 0.0f ? 1.0f : 0.0f;
}

static void pull(const level *coarse, const level *fine) {
    for (size_t to = 0; to < pixels_of(fine); to++) {
        if (!(fine->sum[to][W] > 0.0f))
            tent(coarse, (int)(to % (size_t)fine->width), (int)(to / (size_t)fine->width), fine->sum[to]);
    }
}

/* Fills the holes of a level by those that are coarser. */
static bool fill(const level *fine) {
    level coarse = {(fine->width + 1) / 2, (fine->height + 1) / 2, NULL};
    if (fine->width == 1 && fine->height == 1) return true;
    coarse.sum = sl_allocate(pixels_of(&coarse), sizeof *coarse.sum);
    if (!coarse.sum) return false;
    push(fine, &coarse);
    bool filled = fill(&coarse);
    if (filled) pull(&coarse, fine);
    sl_free(coarse.sum);
    return filled;
}

sl_status sl_fill_uncovered(int width, int height, const float *weight, const uint32_t *receives, float *r,
                            float *g, float *b, sl_error *error) {
    level finest = {width, height, NULL};
    const size_t pixels = pixels_of(&finest);
    uint32_t holes = 0;
#pragma omp simd reduction(| : holes)
    for (size_t i = 0; i < pixels; i++) holes |= weight[i] > 0.0f ? 0 : receives[i];
    if (!holes) return SL_OK;
    finest.sum = sl_allocate(pixels, sizeof *finest.sum);
    if (!finest.sum) return sl_fail_memory(error, "filling uncovered pixels");
    for (size_t i = 0; i < pixels; i++) {
        float *to = finest.sum[i];
        if (weight[i] > 0.0f && receives[i]) to[R] = r[i], to[G] = g[i], to[B] = b[i], to[W] = 1.0f;
    }
    bool filled = fill(&finest);
    for (size_t i = 0; filled && i < pixels; i++) {
        const float *from = finest.sum[i];
        if (receives[i] && !(weight[i] > 0.0f)) r[i] = from[R], g[i] = from[G], b[i] = from[B];
    }
    sl_free(finest.sum);
    return filled ? SL_OK : sl_fail_memory(error, "filling uncovered pixels");
}
