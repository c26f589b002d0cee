/* Pixels that no record has reached yet, in a picture that was stopped early, take the mean of what surrounds
 * them: push sums of (w E, w) with w = 1 for covered pixels down a pyramid of 2x2 sums, then pull the coarser
 * mean wherever the finer level has nothing. Irradiance is filled, not radiance, so textures stay sharp. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/splatting/splatting.h"

enum { R, G, B, W, SUMS };

typedef struct {
    int width, height;
    float (*sum)[SUMS];
} level;

static size_t pixels_of(const level *l) { return (size_t)l->width * (size_t)l->height; }

/* Two levels of the pyramid. */
typedef struct {
    const level *fine, *coarse;
} step;

/* Sums 2x2 pixels of the finer level; an odd last column or row is summed alone. */
static void push_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const level *fine = ((const step *)context)->fine, *coarse = ((const step *)context)->coarse;
    const size_t width = (size_t)fine->width, end = sl_fewer(2 * row + 2, (size_t)fine->height);
    for (size_t y = 2 * row; y < end; y++) {
        for (size_t x = 0; x < width; x++) {
            float *to = coarse->sum[row * (size_t)coarse->width + x / 2];
            for (int c = 0; c < SUMS; c++) to[c] += fine->sum[y * width + x][c];
        }
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

static void pull_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const level *fine = ((const step *)context)->fine, *coarse = ((const step *)context)->coarse;
    for (int x = 0; x < fine->width; x++) {
        float *to = fine->sum[row * (size_t)fine->width + (size_t)x];
        if (!(to[W] > 0.0f)) tent(coarse, x, (int)row, to);
    }
}

/* Makes the next coarser level of one, without holes where that has anything at all. */
static bool make_coarser(const level *fine, unsigned threads, level *coarse) {
    *coarse = (level){(fine->width + 1) / 2, (fine->height + 1) / 2, NULL};
    coarse->sum = sl_allocate(pixels_of(coarse), sizeof *coarse->sum);
    if (!coarse->sum) return false;
    sl_parallel_for(threads, (size_t)coarse->height, push_row, &(step){fine, coarse});
    if (coarse->width == 1 && coarse->height == 1) return true;
    level next;
    const bool made = make_coarser(coarse, threads, &next);
    if (made) sl_parallel_for(threads, (size_t)coarse->height, pull_row, &(step){coarse, &next});
    sl_free(next.sum);
    return made;
}

/* ---- the picture, which is the finest level ---- */

typedef struct {
    const level *finest, *coarse;
    const float *weight;
    const uint32_t *receives;
    float *mean[3];
} picture;

static void take_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const picture *p = context;
    const size_t first = row * (size_t)p->finest->width, end = first + (size_t)p->finest->width;
    for (size_t i = first; i < end; i++) {
        float *to = p->finest->sum[i];
        const bool known = p->weight[i] > 0.0f && p->receives[i];
        for (int c = R; c <= B; c++) to[c] = known ? p->mean[c][i] : 0.0f;
        to[W] = known ? 1.0f : 0.0f;
    }
}

static void put_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const picture *p = context;
    const size_t width = (size_t)p->finest->width;
    for (size_t x = 0; x < width; x++) {
        const size_t i = row * width + x;
        float mean[SUMS];
        if (!p->receives[i] || p->weight[i] > 0.0f) continue;
        tent(p->coarse, (int)x, (int)row, mean);
        for (int c = R; c <= B; c++) p->mean[c][i] = mean[c];
    }
}

sl_status sl_fill_uncovered(int width, int height, const float *weight, const uint32_t *receives,
                            unsigned threads, float *const mean[3], sl_error *error) {
    level finest = {width, height, NULL}, coarse;
    const size_t pixels = pixels_of(&finest), rows = (size_t)height;
    uint32_t holes = 0;
#pragma omp simd reduction(| : holes)
    for (size_t i = 0; i < pixels; i++) holes |= weight[i] > 0.0f ? 0 : receives[i];
    if (!holes) return SL_OK;
    finest.sum = sl_allocate_unset(pixels, sizeof *finest.sum);
    if (!finest.sum) return sl_fail_memory(error, "filling uncovered pixels");
    picture p = {&finest, &coarse, weight, receives, {mean[0], mean[1], mean[2]}};
    sl_parallel_for(threads, rows, take_row, &p);
    const bool filled = make_coarser(&finest, threads, &coarse);
    if (filled) sl_parallel_for(threads, rows, put_row, &p);
    sl_free(coarse.sum);
    sl_free(finest.sum);
    return filled ? SL_OK : sl_fail_memory(error, "filling uncovered pixels");
}
