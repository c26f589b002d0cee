/* Visible sizes (image pass 1): a counting sort of the id map's pixels by the faces that they show, and
 * within a face by the way down its quadtree. */
#include "cache/multi_mesh/pixels.h"

#include <stdlib.h>
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "scene/surface_rules.h"

enum { PATH_SHIFT = 32 };

typedef struct sort_job {
    const sl_scene *scene;
    const sl_view *view;
    const uint32_t *id;
    size_t pixels;
    float *weight[2];          /* by pixel of the screen: of the triangle's corners 1 and 2, */
    uint32_t *face, *path;     /* ... SL_NO_INDEX: none; the way down its quadtree */
    uint32_t *next;            /* by face: how many pixels show it; then where its next key goes */
    uint64_t *key;             /* path above pixel; by face */
    sl_visible_pixels *out;
} sort_job;

/* ---- what a pixel shows ---------------------------------------------------------------------- */

/* Returns the side that sl_scene_surface() has. */
static uint32_t side_of(const sort_job *j, uint32_t triangle, float w1, float w2) {
    const sl_scene *s = j->scene;
    sl_vec3 a = sl_scene_position(s, s->vertex[0][triangle]),
            b = sl_scene_position(s, s->vertex[1][triangle]),
            c = sl_scene_position(s, s->vertex[2][triangle]);
    sl_vec3 p = sl_v3(sl_interpolate(a.x, b.x - a.x, c.x - a.x, w1, w2),
                      sl_interpolate(a.y, b.y - a.y, c.y - a.y, w1, w2),
                      sl_interpolate(a.z, b.z - a.z, c.z - a.z, w1, w2));
    return sl_side_seen(sl_scene_geometric_normal(s, triangle), sl_sub(j->view->origin, p)) < 0.0f;
}

enum { ONE = 1 << 24 };

/* In [0, 1], 0 for NaN. */
static int32_t whole(float weight) {
    float clamped = weight > 0.0f ? weight : 0.0f;
    return (int32_t)((clamped < 1.0f ? clamped : 1.0f) * (float)ONE);
}

/* Returns a point's way down a quadtree of triangles, two bits a level, the first in the highest ones. A
 * child that keeps corner i holds the points whose weight of it is above one half, and all their weights
 * double there, i's less one. Child 3, turned by half a turn, holds the rest: weights w become 1 - 2 w. In
 * whole numbers nothing is rounded on the way. */
static uint32_t path_of(float w1, float w2) {
    int32_t w[3] = {0, whole(w1), whole(w2)};
    uint32_t path = 0;
    w[0] = ONE - w[1] - w[2] > 0 ? ONE - w[1] - w[2] : 0;
    for (int level = 0; level < SL_PATH_LEVELS; level++) {
        for (int c = 0; c < 3; c++) w[c] *= 2;
        uint32_t child = w[1] > ONE ? 1 : w[2] > ONE ? 2 : w[0] > ONE ? 0 : 3;
        path = path << 2 | child;
        for (int c = 0; c < 3 && child == 3; c++) w[c] = ONE - w[c];
        if (child < 3) w[child] -= ONE;
    }
    return path;
}

static void look_at_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const sort_job *j = context;
    size_t width = (size_t)j->view->width;
    for (size_t i = row * width; i < (row + 1) * width; i++) {
        float w1 = j->weight[0][i], w2 = j->weight[1][i];
        bool shows = j->id[i] != SL_NO_INDEX;
        j->face[i] = shows ? 2 * j->id[i] + side_of(j, j->id[i], w1, w2) : SL_NO_INDEX;
        j->path[i] = shows ? path_of(w1, w2) : 0;
    }
}

/* ---- the sort -------------------------------------------------------------------------------- */

/* Lists faces in view with their counts. */
static sl_status list_faces(sort_job *j, sl_error *error) {
    sl_visible_pixels *out = j->out;
    size_t faces = 2 * j->scene->triangle_count, visible = 0;
    for (size_t i = 0; i < j->pixels; i++)
        if (j->face[i] != SL_NO_INDEX) visible += j->next[j->face[i]]++ == 0;
    out->face = sl_allocate(visible, sizeof *out->face);
    if (!out->face) return sl_fail_memory(error, "visible sizes");
    uint32_t first = 0;
    for (size_t f = 0; f < faces; f++) {
        uint32_t count = j->next[f];
        out->entry_of_face[f] = count ? (uint32_t)out->face_count : SL_NO_INDEX;
        if (count) out->face[out->face_count++] = (sl_visible_face){(uint32_t)f, first, count};
        j->next[f] = first;
        first += count;
    }
    out->count = first;
    for (uint32_t i = 0; i < j->pixels; i++)
        if (j->face[i] != SL_NO_INDEX)
            j->key[j->next[j->face[i]]++] = (uint64_t)j->path[i] << PATH_SHIFT | i;
    return SL_OK;
}

/* By path, of one path by index: no two keys are equal. */
static int by_key(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static void sort_share(void *context, size_t share, unsigned worker) {
    (void)worker;
    sort_job *j = context;
    sl_visible_pixels *out = j->out;
    size_t begin, end;
    sl_visible_share(out, share, &begin, &end);
    for (size_t e = begin; e < end; e++) {
        sl_visible_face f = out->face[e];
        qsort(j->key + f.first, f.count, sizeof *j->key, by_key);
        for (size_t i = f.first; i < f.first + f.count; i++) {
            uint32_t pixel = out->pixel[i] = (uint32_t)j->key[i];
            out->path[i] = (uint32_t)(j->key[i] >> PATH_SHIFT);
            out->w1[i] = j->weight[0][pixel];
            out->w2[i] = j->weight[1][pixel];
        }
    }
}

static bool allocate(sort_job *j) {
    size_t n = j->pixels, faces = 2 * j->scene->triangle_count;
    sl_visible_pixels *out = j->out;
    j->weight[0] = sl_allocate_unset(2 * n, sizeof *j->weight[0]);
    j->face = sl_allocate_unset(n, sizeof *j->face);
    j->path = sl_allocate_unset(n, sizeof *j->path);
    j->key = sl_allocate_unset(n, sizeof *j->key);
    j->next = sl_allocate(faces, sizeof *j->next);
    out->entry_of_face = sl_allocate_unset(faces, sizeof *out->entry_of_face);
    out->pixel = sl_allocate_unset(n, sizeof *out->pixel);
    out->path = sl_allocate_unset(n, sizeof *out->path);
    out->w1 = sl_allocate_unset(n, sizeof *out->w1);
    out->w2 = sl_allocate_unset(n, sizeof *out->w2);
    return j->weight[0] && j->face && j->path && j->key && j->next && out->entry_of_face &&
           out->pixel && out->path && out->w1 && out->w2;
}

/* Writes what the Gouraud pass interpolates: a place in a triangle, told by its weights of corners 1 and
 * 2. */
static void corner_places(const void *context, uint32_t triangle, float *value) {
    static const float places[6] = {0, 0, 1, 0, 0, 1};
    (void)context;
    (void)triangle;
    memcpy(value, places, sizeof places);
}

static sl_status sort(sort_job *j, const sl_raster *raster, unsigned threads, sl_counters *counters,
                      sl_error *error) {
    if (!allocate(j)) return sl_fail_memory(error, "visible pixels");
    const sl_gouraud_pass pass = {.channels = 2, .corners = corner_places, .out = j->weight[0]};
    j->weight[1] = j->weight[0] + j->pixels;
    sl_raster_gouraud(raster, j->view, threads, j->id, &pass, counters);
    sl_parallel_for(threads, (size_t)j->view->height, look_at_row, j);
    sl_status status = list_faces(j, error);
    if (status == SL_OK) sl_parallel_for(threads, SL_VISIBLE_SHARES, sort_share, j);
    return status;
}

sl_status sl_visible_pixels_sort(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                                 const uint32_t *id, unsigned threads, sl_visible_pixels **pixels,
                                 sl_counters *counters, sl_error *error) {
    sl_visible_pixels *out = sl_allocate(1, sizeof *out);
    if (!out) return sl_fail_memory(error, "visible pixels");
    out->width = view->width;
    out->height = view->height;
    out->view = *view;
    sort_job job = {.scene = scene,
                    .view = view,
                    .id = id,
                    .pixels = (size_t)view->width * (size_t)view->height,
                    .out = out};
    sl_status status = sort(&job, raster, sl_thread_count(threads), counters, error);
    void *const work[] = {job.weight[0], job.face, job.path, job.next, job.key};
    for (size_t i = 0; i < sizeof work / sizeof work[0]; i++) sl_free(work[i]);
    if (status == SL_OK) *pixels = out;
    else sl_visible_pixels_destroy(out);
    return status;
}

void sl_visible_pixels_destroy(sl_visible_pixels *pixels) {
    if (!pixels) return;
    sl_free(pixels->face);
    sl_free(pixels->entry_of_face);
    sl_free(pixels->pixel);
    sl_free(pixels->path);
    sl_free(pixels->w1);
    sl_free(pixels->w2);
    sl_free(pixels);
}

static size_t entry_from(const sl_visible_pixels *pixels, size_t first) {
    size_t low = 0, high = pixels->face_count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (pixels->face[middle].first < first) low = middle + 1;
        else high = middle;
    }
    return low;
}

void sl_visible_share(const sl_visible_pixels *pixels, size_t share, size_t *begin, size_t *end) {
    *begin = entry_from(pixels, pixels->count * share / SL_VISIBLE_SHARES);
    *end = share + 1 == SL_VISIBLE_SHARES
               ? pixels->face_count
               : entry_from(pixels, pixels->count * (share + 1) / SL_VISIBLE_SHARES);
}

uint32_t sl_visible_from_path(const sl_visible_pixels *pixels, uint32_t first, uint32_t end, uint32_t path) {
    while (first < end) {
        uint32_t middle = first + (end - first) / 2;
        if (pixels->path[middle] < path) first = middle + 1;
        else end = middle;
    }
    return first;
}
