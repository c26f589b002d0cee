/* The visible share of the light samples, smoothed where it is noise: the mean over 5 x 5 pixels of the same
 * surface, as far as their shares differ by no more than the samples' own scatter explains. The scatter is
 * measured: what one half of a pixel's samples says against what the other half says, over the same pixels.
 * With more samples it falls, and fewer neighbours are alike, so that the result still converges to the
 * truth; where all agree nothing changes. */
#include "base/math.h"
#include "cache/light/direct_internal.h"

enum { RADIUS = 2 };

typedef struct {
    const sl_direct_sums *sums;
    const sl_gbuffer *gbuffer;
    int row;
} window;

static float ratio(const sl_direct_sums *s, int c, size_t k) {
    return s->all[c][k] > 0.0f ? s->seen[c][k] / s->all[c][k] : 0.0f;
}

/* Of all channels together. */
static float visible_share(const sl_direct_sums *s, size_t k) {
    float all = s->all[0][k] + s->all[1][k] + s->all[2][k];
    return all > 0.0f ? (s->seen[0][k] + s->seen[1][k] + s->seen[2][k]) / all : 0.0f;
}

/* (A - B)^2 / 4, A and B what the halves of the samples say: the variance of their mean. */
static float scatter_of(const sl_direct_sums *s, size_t k) {
    float seen = s->seen[0][k] + s->seen[1][k] + s->seen[2][k] - s->odd_seen[k],
          all = s->all[0][k] + s->all[1][k] + s->all[2][k] - s->odd_all[k];
    if (!(s->odd_all[k] > 0.0f) || !(all > 1e-4f * s->odd_all[k])) return 0.0f;
    float difference = s->odd_seen[k] / s->odd_all[k] - seen / all;
    return 0.25f * difference * difference;
}

void sl_direct_find_scatter(const sl_direct_sums *sums, size_t first, size_t count) {
    for (size_t k = first; k < first + count; k++)
        sums->scatter[k] = sums->samples[k] > 0.0f ? scatter_of(sums, k) : 0.0f;
}

static sl_vec3 sum_of(const float *x, const float *y, const float *z, size_t i, size_t j) {
    return sl_v3(x[i] + x[j], y[i] + y[j], z[i] + z[j]);
}

/* Alike normals, and a chord by those that are smooth or by those that are true. */
static bool same_surface(const sl_gbuffer *g, size_t i, size_t j) {
    sl_vec3 d = sl_sub(sl_gbuffer_position(g, j),
                       sl_gbuffer_position(g, i));
    float alike =
        g->normal_x[i] * g->normal_x[j] + g->normal_y[i] * g->normal_y[j] + g->normal_z[i] * g->normal_z[j];
    return alike > 0.9f && (sl_is_chord(d, sum_of(g->geometric_x, g->geometric_y, g->geometric_z, i, j)) ||
                            sl_is_chord(d, sum_of(g->normal_x, g->normal_y, g->normal_z, i, j)));
}

typedef struct {
    size_t count;
    size_t pixel[(2 * RADIUS + 1) * (2 * RADIUS + 1)]; /* in the sums */
    float share[(2 * RADIUS + 1) * (2 * RADIUS + 1)];
    float scatter; /* variance of a share */
} neighbours;

static void find_neighbours(const window *w, int x, neighbours *n) {
    const sl_gbuffer *g = w->gbuffer;
    const sl_direct_sums *s = w->sums;
    size_t width = (size_t)g->width, centre = (size_t)w->row * width + (size_t)x;
    n->count = 0;
    n->scatter = 0.0f;
    for (int v = -RADIUS; v <= RADIUS; v++) {
        for (int u = -RADIUS; u <= RADIUS; u++) {
            int column = x + u, row = w->row + v;
            if (column < 0 || column >= g->width || row < 0 || row >= g->height) continue;
            size_t i = (size_t)row * width + (size_t)column, k = i - s->first;
            if (!(s->all[0][k] + s->all[1][k] + s->all[2][k] > 0.0f) || !same_surface(g, centre, i)) continue;
            n->pixel[n->count] = k;
            n->share[n->count++] = visible_share(s, k);
            n->scatter += s->scatter[k];
        }
    }
    n->scatter = n->count ? n->scatter / (float)n->count : 0.0f;
}

/* Falls from 1 to 0 at three deviations of the difference of two shares. */
static float likeness(float difference, float variance) {
    float t = 1.0f - difference * difference / (9.0f * variance);
    return t > 0.0f ? t * t : 0.0f;
}

bool sl_direct_is_near(const sl_direct_sums *sums, const float *plane, const sl_gbuffer *g, size_t pixel,
                       int radius) {
    const int x = (int)(pixel % (size_t)g->width), y = (int)(pixel / (size_t)g->width),
              left = sl_greater(x - radius, 0), right = sl_lesser(x + radius, g->width - 1),
              low = sl_greater(y - radius, 0), high = sl_lesser(y + radius, g->height - 1);
    for (int row = low; row <= high; row++) {
        const float *of_row = plane + ((size_t)row * (size_t)g->width - sums->first);
        for (int column = left; column <= right; column++)
            if (of_row[column] > 0.0f) return true;
    }
    return false;
}

/* Replaces the pixel's own share, column x of the row, by the mean. */
static void smooth(const window *w, int x, size_t k) {
    const sl_direct_sums *s = w->sums;
    neighbours n;
    find_neighbours(w, x, &n);
    float own = visible_share(s, k), weights = 0.0f, sum[3] = {0.0f, 0.0f, 0.0f};
    if (!(n.scatter > 1e-8f)) return;
    for (size_t j = 0; j < n.count; j++) {
        float weight = likeness(n.share[j] - own, 2.0f * n.scatter) * s->samples[n.pixel[j]];
        weights += weight;
        for (int c = 0; c < 3; c++) sum[c] += weight * ratio(s, c, n.pixel[j]);
    }
    for (int c = 0; c < 3 && weights > 0.0f; c++) s->light[c][k] = sum[c] / weights;
}

void sl_direct_filter_run(const sl_direct_sums *s, const sl_gbuffer *gbuffer, int row, sl_pixel_run run,
                          bool smoothed) {
    const window w = {s, gbuffer, row};
    for (size_t i = run.first; i < run.end; i++) {
        const size_t k = i - s->first;
        const int x = (int)(i - (size_t)row * (size_t)gbuffer->width);
        const bool sampled = s->samples[k] > 0.0f;
        for (int c = 0; c < 3; c++) s->light[c][k] = sampled ? ratio(s, c, k) : 0.0f;
        if (!sampled || !(s->all[0][k] + s->all[1][k] + s->all[2][k] > 0.0f)) continue;
        if (smoothed && sl_direct_is_near(s, s->scatter, gbuffer, i, RADIUS)) smooth(&w, x, k);
    }
}
