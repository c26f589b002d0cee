/* Pixels that no record has reached yet, in a picture that was stopped early, take the mean of what surrounds
 * them: push sums of (w E, w) with w = 1 for covered pixels down a pyramid of 2x2 sums, then pull the coarser
 * mean wherever the finer level has nothing. Irradiance is filled, not radiance, so textures stay sharp. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/splatting/splatting.h"

typedef struct {
    int width, height;
    float *r, *g, *b, *weight;
} level;

static bool level_create(level *l, int width, int height) {
    size_t pixels = (size_t)width * (size_t)height;
    *l = (level){width,
                 height,
                 sl_allocate(pixels, 4),
                 sl_allocate(pixels, 4),
                 sl_allocate(pixels, 4),
                 sl_allocate(pixels, 4)};
    return l->r && l->g && l->b && l->weight;
}

static void level_destroy(level *l) {
    sl_free(l->r);
    sl_free(l->g);
    sl_free(l->b);
    sl_free(l->weight);
}

/* Sums 2x2 pixels of the finer level; an odd last column or row is summed alone. */
static void push(const level *fine, level *coarse) {
    for (int y = 0; y < fine->height; y++) {
        for (int x = 0; x < fine->width; x++) {
            size_t from = (size_t)y * (size_t)fine->width + (size_t)x;
            size_t to = (size_t)(y / 2) * (size_t)coarse->width + (size_t)(x / 2);
            coarse->r[to] += fine->r[from];
            coarse->g[to] += fine->g[from];
            coarse->b[to] += fine->b[from];
            coarse->weight[to] += fine->weight[from];
        }
    }
}

/* The mean of the four coarse pixels nearest to a fine one, by the shares of a tent (9, 3, 3 and 1
 * sixteenths): the coarser level's squares do not show. False where none of them has anything. */
static bool tent(const level *coarse, int x, int y, float mean[3]) {
    float sums[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    const int step_x = x % 2 ? 1 : -1, step_y = y % 2 ? 1 : -1;
    for (int k = 0; k < 4; k++) {
        int cx = x / 2 + (k & 1 ? step_x : 0), cy = y / 2 + (k & 2 ? step_y : 0);
        if (cx < 0 || cy < 0 || cx >= coarse->width || cy >= coarse->height) continue;
        size_t i = (size_t)cy * (size_t)coarse->width + (size_t)cx;
        if (!(coarse->weight[i] > 0.0f)) continue;
        float share = (k & 1 ? 1.0f : 3.0f) * (k & 2 ? 1.0f : 3.0f), over = share / coarse->weight[i];
        sums[0] += coarse->r[i] * over;
        sums[1] += coarse->g[i] * over;
        sums[2] += coarse->b[i] * over;
        sums[3] += share;
    }
    for (int c = 0; c < 3; c++) mean[c] = sums[3] > 0.0f ? sums[c] / sums[3] : 0.0f;
    return sums[3] > 0.0f;
}

static void pull(const level *coarse, level *fine) {
    for (int y = 0; y < fine->height; y++) {
        for (int x = 0; x < fine->width; x++) {
            size_t to = (size_t)y * (size_t)fine->width + (size_t)x;
            float mean[3];
            if (fine->weight[to] > 0.0f || !tent(coarse, x, y, mean)) continue;
            fine->r[to] = mean[0];
            fine->g[to] = mean[1];
            fine->b[to] = mean[2];
            fine->weight[to] = 1.0f;
        }
    }
}

static bool any_uncovered(size_t pixels, const float *weight, const uint32_t *receives) {
    for (size_t i = 0; i < pixels; i++) {
        if (receives[i] && !(weight[i] > 0.0f)) return true;
    }
    return false;
}

sl_status sl_fill_uncovered(int width, int height, const float *weight, const uint32_t *receives, float *r,
                            float *g, float *b, sl_error *error) {
    enum { LEVELS = 17 };
    level levels[LEVELS];
    int count = 0;
    bool enough = true;
    if (!any_uncovered((size_t)width * (size_t)height, weight, receives)) return SL_OK;
    for (int w = width, h = height; enough && count < LEVELS; w = (w + 1) / 2, h = (h + 1) / 2) {
        enough = level_create(&levels[count++], w, h);
        if (w == 1 && h == 1) break;
    }
    if (enough) {
        size_t pixels = (size_t)width * (size_t)height;
        for (size_t i = 0; i < pixels; i++) {
            if (!(weight[i] > 0.0f) || !receives[i]) continue;
            levels[0].r[i] = r[i], levels[0].g[i] = g[i], levels[0].b[i] = b[i], levels[0].weight[i] = 1.0f;
        }
        for (int i = 0; i + 1 < count; i++) push(&levels[i], &levels[i + 1]);
        for (int i = count - 1; i > 0; i--) pull(&levels[i], &levels[i - 1]);
        for (size_t i = 0; i < pixels; i++) {
            if (weight[i] > 0.0f || !receives[i]) continue;
            r[i] = levels[0].r[i], g[i] = levels[0].g[i], b[i] = levels[0].b[i];
        }
    }
    for (int i = 0; i < count; i++) level_destroy(&levels[i]);
    return enough ? SL_OK : sl_fail_memory(error, "filling uncovered pixels");
}
