/* The visible share of the light samples, smoothed where it is noise: the mean over 5 x 5 pixels of the same
 * surface, as far as their shares differ by no more than the samples' own scatter explains. The scatter is
 * measured: what one half of a pixel's samples says against what the other half says, over the same pixels.
 * With more samples it falls, and fewer neighbours are alike, so that the result still converges to the
 * truth; where all agree nothing changes. */
#include "cache/light/direct_internal.h"

enum { RADIUS = 2 };

#define CHORD_SLOPE 0.05f

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

/* The chord between two points of one smooth surface leans as far out of it at one end as into it at the
 * other, so it is square to the sum of the normals. A step between two parallel surfaces is not, however
 * small the angle at which they are seen. */
static bool is_chord(sl_vec3 d, sl_vec3 sum) {
    float out = sl_dot(d, sum);
    return out * out <= CHORD_SLOPE * CHORD_SLOPE * 4.0f * sl_dot(d, d);
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
    return alike > 0.9f && (is_chord(d, sum_of(g->geometric_x, g->geometric_y, g->geometric_z, i, j)) ||
                            is_chord(d, sum_of(g->normal_x, g->normal_y, g->normal_z, i, j)));
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

/* Returns whether any pixel of the column scatters, within the window's rows. */
static bool column_scatters(const window *w, int column) {
    const sl_gbuffer *g = w->gbuffer;
    for (int v = -RADIUS; v <= RADIUS; v++) {
        int row = w->row + v;
        if (row < 0 || row >= g->height || column >= g->width) continue;
        if (w->sums->scatter[(size_t)row * (size_t)g->width + (size_t)column - w->sums->first] > 0.0f)
            return true;
    }
    return false;
}

void sl_direct_filter_row(const sl_direct_sums *sums, const sl_gbuffer *gbuffer, int row, float *share[3]) {
    window w = {sums, gbuffer, row};
    int scatters = -RADIUS - 1, next = 0; /* the last column so far that does, and the next to look at */
    for (int x = 0; x < gbuffer->width; x++) {
        size_t k = (size_t)row * (size_t)gbuffer->width + (size_t)x - sums->first;
        const bool sampled = sums->samples[k] > 0.0f;
        for (int c = 0; c < 3; c++) share[c][x] = sampled ? ratio(sums, c, k) : 0.0f;
        if (!sampled) continue;
        for (next = next > x - RADIUS ? next : x - RADIUS; next <= x + RADIUS; next++)
            if (next >= 0 && column_scatters(&w, next)) scatters = next;
        if (scatters < x - RADIUS || !(sums->all[0][k] + sums->all[1][k] + sums->all[2][k] > 0.0f)) continue;
        neighbours n;
        find_neighbours(&w, x, &n);
        float own = visible_share(sums, k), weights = 0.0f, sum[3] = {0.0f, 0.0f, 0.0f};
        if (!(n.scatter > 1e-8f)) continue;
        for (size_t j = 0; j < n.count; j++) {
            float weight = likeness(n.share[j] - own, 2.0f * n.scatter) * sums->samples[n.pixel[j]];
            weights += weight;
            for (int c = 0; c < 3; c++) sum[c] += weight * ratio(sums, c, n.pixel[j]);
        }
        for (int c = 0; c < 3 && weights > 0.0f; c++) share[c][x] = sum[c] / weights;
    }
}
