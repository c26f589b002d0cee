#include "cache/frame/antialias.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"

#include <string.h>

enum { SAMPLES = 4 };

/* A grid that is turned: no edge along rows or columns falls between its lines. */
static const float sample_right[SAMPLES] = {-0.125f, 0.375f, -0.375f, 0.125f},
                   sample_up[SAMPLES] = {-0.375f, -0.125f, 0.125f, 0.375f};

struct sl_antialias {
    int width, height;
    uint32_t *ids; /* at the centres, at each sample; rows from the bottom */
    uint8_t *at_edge;
    float *colour; /* of pixels at edges, before */
};

static size_t pixels_of(const sl_antialias *a) { return (size_t)a->width * (size_t)a->height; }

sl_status sl_antialias_create(int width, int height, sl_antialias **antialias, sl_error *error) {
    sl_antialias *a = *antialias = sl_allocate(1, sizeof *a);
    if (!a) return sl_fail_memory(error, "antialiasing");
    a->width = width;
    a->height = height;
    a->ids = sl_allocate_unset((1 + SAMPLES) * pixels_of(a), sizeof *a->ids);
    a->at_edge = sl_allocate_unset(pixels_of(a), sizeof *a->at_edge);
    a->colour = sl_allocate_unset(3 * pixels_of(a), sizeof *a->colour);
    if (a->ids && a->at_edge && a->colour) return SL_OK;
    sl_antialias_destroy(a);
    *antialias = NULL;
    return sl_fail_memory(error, "antialiasing");
}

void sl_antialias_destroy(sl_antialias *a) {
    if (a) SL_FREE_ALL(a->ids, a->at_edge, a->colour, a);
}

/* ---- identifiers ---- */

static sl_status draw_ids(sl_antialias *a, const sl_scene *scene, const sl_raster *raster, unsigned threads,
                          sl_counters *counters, sl_error *error) {
    sl_scene seen = *scene;
    sl_status status = SL_OK;
    for (int k = 0; k <= SAMPLES && status == SL_OK; k++) {
        seen.sub_frame = k ? (sl_sub_frame){.right = sample_right[k - 1], .up = sample_up[k - 1]}
                           : (sl_sub_frame){0};
        const sl_view view = sl_view_scene(&seen, a->width, a->height);
        const sl_target target = {a->width, a->height, a->ids + (size_t)k * pixels_of(a), NULL};
        status = sl_raster_id(raster, &view, threads, &target, counters, error);
    }
    return status;
}

/* Tells whether light goes on smoothly from one triangle to the other. */
static bool is_same_surface(const sl_scene *s, uint32_t a, uint32_t b) {
    const float SMOOTH = 0.9f; /* cosine */
    if (a == b) return true;
    if (a == SL_NO_INDEX || b == SL_NO_INDEX || s->object_index[a] != s->object_index[b] ||
        s->material_index[a] != s->material_index[b])
        return false;
    const float cosine = s->geometric_normal_x[a] * s->geometric_normal_x[b] +
                         s->geometric_normal_y[a] * s->geometric_normal_y[b] +
                         s->geometric_normal_z[a] * s->geometric_normal_z[b];
    return cosine >= SMOOTH;
}

/* ---- pixels ---- */

typedef struct pass {
    const sl_antialias *a;
    const sl_scene *scene;
    sl_image *picture;
} pass;

static void find_edges_of_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const pass *p = context;
    const sl_antialias *a = p->a;
    const size_t width = (size_t)a->width, first = row * width;
    for (size_t x = 0; x < width; x++) {
        const uint32_t *id = a->ids + first + x;
        const size_t beside[4] = {x ? 1 : 0, x + 1 < width ? 1 : 0, row ? width : 0,
                                  row + 1 < (size_t)a->height ? width : 0};
        const uint32_t next[4] = {id[0 - beside[0]], id[beside[1]], *(id - beside[2]), id[beside[3]]};
        a->at_edge[first + x] = 0;
        for (int k = 0; k < 4; k++) a->at_edge[first + x] |= !is_same_surface(p->scene, *id, next[k]);
    }
}

/* Returns the pixel whose centre is nearest to a sample and shows the same surface; the sample's own where
 * there is none. */
static size_t find_centre(const pass *p, int x, int y, int sample) {
    const sl_antialias *a = p->a;
    const size_t own = (size_t)y * (size_t)a->width + (size_t)x;
    const uint32_t seen = a->ids[(size_t)(sample + 1) * pixels_of(a) + own];
    size_t best = own;
    float least = 1e9f;
    for (int v = y - 1; v <= y + 1; v++) {
        for (int u = x - 1; u <= x + 1; u++) {
            const float dx = (float)(u - x) - sample_right[sample], dy = (float)(v - y) - sample_up[sample];
            const float distance = dx * dx + dy * dy;
            if (u < 0 || v < 0 || u >= a->width || v >= a->height || distance >= least) continue;
            const size_t pixel = (size_t)v * (size_t)a->width + (size_t)u;
            if (!is_same_surface(p->scene, seen, a->ids[pixel])) continue;
            best = pixel;
            least = distance;
        }
    }
    return best;
}

/* Rows of pictures begin at the top. */
static size_t place_of(const sl_antialias *a, size_t pixel) {
    const size_t width = (size_t)a->width;
    return ((size_t)a->height - 1 - pixel / width) * width + pixel % width;
}

static void mix_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const pass *p = context;
    const sl_antialias *a = p->a;
    for (int x = 0; x < a->width; x++) {
        const size_t pixel = row * (size_t)a->width + (size_t)x;
        float sum[3] = {0.0f, 0.0f, 0.0f};
        if (!a->at_edge[pixel]) continue;
        for (int k = 0; k < SAMPLES; k++) {
            const size_t from = place_of(a, find_centre(p, x, (int)row, k));
            for (size_t c = 0; c < 3; c++) sum[c] += p->picture->planes[c * pixels_of(a) + from];
        }
        for (size_t c = 0; c < 3; c++)
            a->colour[c * pixels_of(a) + pixel] = sl_picture_value(sum[c] * (1.0f / SAMPLES));
    }
}

static void put_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const pass *p = context;
    const sl_antialias *a = p->a;
    const size_t first = row * (size_t)a->width, end = first + (size_t)a->width;
    for (size_t pixel = first; pixel < end; pixel++) {
        if (!a->at_edge[pixel]) continue;
        for (size_t c = 0; c < 3; c++)
            p->picture->planes[c * pixels_of(a) + place_of(a, pixel)] = a->colour[c * pixels_of(a) + pixel];
    }
}

sl_status sl_antialias_edges(sl_antialias *a, const sl_scene *scene, const sl_raster *raster,
                             unsigned threads, sl_image *picture, sl_counters *counters, sl_error *error) {
    const size_t rows = (size_t)a->height;
    pass p = {a, scene, picture};
    if (scene->triangle_count > pixels_of(a)) return SL_OK;
    sl_status status = draw_ids(a, scene, raster, threads, counters, error);
    if (status != SL_OK) return status;
    sl_parallel_for(threads, rows, find_edges_of_row, &p);
    sl_parallel_for(threads, rows, mix_row, &p);
    sl_parallel_for(threads, rows, put_row, &p);
    return SL_OK;
}
