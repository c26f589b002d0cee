/* Visible sizes (image pass 1): a counting sort of the id map's pixels by the faces that they show, and
 * within a face by the way down its quadtree. */
#include "cache/multi_mesh/pixels.h"

#include <stdatomic.h>
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/multi_mesh/path_kernels.h"
#include "scene/surface_rules.h"

enum {
    STRIP = SL_GOURAUD_STRIP,
    SHORT_LIST = 24,
    PATH_SHIFT = 32,
    TOP_SHIFT = PATH_SHIFT + 2 * SL_PATH_LEVELS - 4
};

typedef struct sort_job {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_view *view;
    const uint32_t *id;
    size_t pixel_count, strips;
    /* in the arrays below: pixels that show something, as they lie on the screen */
    size_t *strip_start;
    uint32_t *pixel, *face;
    float *w1, *w2;
    uint32_t *path;                /* out's, until all have gone into keys */
    uint64_t *key, *spare;         /* path above index into those arrays; by face */
    atomic_uint *of_face;          /* by face: how many pixels show it; then where its next key goes */
    sl_path_kernel *paths;
    sl_visible_pixels *out;
} sort_job;

static void count_strip(void *context, size_t strip, unsigned worker) {
    (void)worker;
    sort_job *j = context;
    size_t shown = 0;
    for (size_t i = strip * STRIP; i < j->pixel_count && i < (strip + 1) * STRIP; i++)
        shown += j->id[i] != SL_NO_INDEX;
    j->strip_start[strip + 1] = shown;
}

/* Sides as sl_scene_surface() has them. Where the eye is not close to the triangle's plane one pixel says it
 * for all. */
typedef struct side_seen {
    uint32_t triangle, back;
    bool clear;
} side_seen;

static side_seen side_of(const sort_job *j, uint32_t triangle, float w1, float w2) {
    const sl_scene *s = j->scene;
    sl_vec3 a = sl_scene_position(s, s->vertex[0][triangle]),
            b = sl_scene_position(s, s->vertex[1][triangle]),
            c = sl_scene_position(s, s->vertex[2][triangle]), n = sl_scene_geometric_normal(s, triangle);
    sl_vec3 p = sl_v3(sl_interpolate(a.x, b.x - a.x, c.x - a.x, w1, w2),
                      sl_interpolate(a.y, b.y - a.y, c.y - a.y, w1, w2),
                      sl_interpolate(a.z, b.z - a.z, c.z - a.z, w1, w2));
    sl_vec3 to_eye = sl_sub(j->view->origin, p);
    float reach = sl_length(to_eye) + sl_length(sl_sub(b, a)) + sl_length(sl_sub(c, a)) + sl_length(p);
    return (side_seen){triangle, sl_side_seen(n, to_eye) < 0.0f,
                       fabsf(sl_dot(n, to_eye)) > 1e-4f * (reach + s->scale)};
}

/* From i on, pixels beside each other that show one face: where they end. */
static size_t end_of_run(const sort_job *j, size_t i, size_t end) {
    uint32_t face = j->face[i];
    while (++i < end && j->face[i] == face) continue;
    return i;
}

/* What the Gouraud pass interpolates: a place in a triangle, told by its weights of corners 1 and 2. */
static void corner_places(const void *context, uint32_t triangle, float *value) {
    static const float places[6] = {0, 0, 1, 0, 0, 1};
    (void)context;
    (void)triangle;
    memcpy(value, places, sizeof places);
}

/* A strip's pixels: weights, face, path; counts those of each face. */
static void resolve_strip(void *context, const sl_gouraud_pixels *pixels) {
    sort_job *j = context;
    size_t strip = pixels->first / STRIP, first = j->strip_start[strip], end = j->strip_start[strip + 1],
           at = first;
    for (size_t i = 0; i < pixels->count; i++) {
        if (pixels->id[i] == SL_NO_INDEX) continue;
        j->pixel[at] = (uint32_t)(pixels->first + i);
        j->face[at] = pixels->id[i];
        j->w1[at] = pixels->value[0][i];
        j->w2[at++] = pixels->value[1][i];
    }
    j->paths(end - first, j->w1 + first, j->w2 + first, j->path + first);
    side_seen side = {SL_NO_INDEX, 0, false};
    for (size_t i = first; i < end; i++) {
        uint32_t triangle = j->face[i];
        if (!side.clear || triangle != side.triangle) side = side_of(j, triangle, j->w1[i], j->w2[i]);
        j->face[i] = 2 * triangle + side.back;
    }
    for (size_t i = first, next; i < end; i = next) {
        next = end_of_run(j, i, end);
        atomic_fetch_add_explicit(&j->of_face[j->face[i]], (unsigned)(next - i), memory_order_relaxed);
    }
}

/* Faces in view with their counts. */
static sl_status list_faces(sort_job *j, sl_error *error) {
    sl_visible_pixels *out = j->out;
    size_t faces = 2 * j->scene->triangle_count, visible = 0;
    for (size_t f = 0; f < faces; f++)
        visible += atomic_load_explicit(&j->of_face[f], memory_order_relaxed) != 0;
    out->face = sl_allocate(visible, sizeof *out->face);
    if (!out->face) return sl_fail_memory(error, "visible sizes");
    uint32_t first = 0;
    for (size_t f = 0; f < faces; f++) {
        uint32_t count = atomic_load_explicit(&j->of_face[f], memory_order_relaxed);
        out->entry_of_face[f] = count ? (uint32_t)out->face_count : SL_NO_INDEX;
        if (count) out->face[out->face_count++] = (sl_visible_face){(uint32_t)f, first, count};
        atomic_store_explicit(&j->of_face[f], first, memory_order_relaxed);
        first += count;
    }
    return SL_OK;
}

/* Keys of a face in any order, which depends on the threads: they are sorted. */
static void deal_strip(void *context, size_t strip, unsigned worker) {
    (void)worker;
    sort_job *j = context;
    size_t end = j->strip_start[strip + 1];
    for (size_t i = j->strip_start[strip], next; i < end;) {
        next = end_of_run(j, i, end);
        unsigned at =
            atomic_fetch_add_explicit(&j->of_face[j->face[i]], (unsigned)(next - i), memory_order_relaxed);
        for (; i < next; i++) j->key[at++] = (uint64_t)j->path[i] << PATH_SHIFT | i;
    }
}

static void insert_in_order(uint64_t *key, size_t count) {
    for (size_t i = 1; i < count; i++) {
        uint64_t k = key[i];
        size_t at = i;
        for (; at > 0 && key[at - 1] > k; at--) key[at] = key[at - 1];
        key[at] = k;
    }
}

/* Two levels of the quadtree at a time; of one path by index. No two keys are equal. */
static void sort_by_path(uint64_t *key, uint64_t *spare, size_t count, int shift) {
    if (count <= SHORT_LIST) {
        insert_in_order(key, count);
        return;
    }
    if (shift < 0) return;
    size_t start[17] = {0}, next[16];
    for (size_t i = 0; i < count; i++) start[(key[i] >> shift & 15) + 1]++;
    for (int b = 0; b < 16; b++) start[b + 1] += start[b];
    memcpy(next, start, sizeof next);
    for (size_t i = 0; i < count; i++) spare[next[key[i] >> shift & 15]++] = key[i];
    memcpy(key, spare, count * sizeof *key);
    for (int b = 0; b < 16; b++)
        sort_by_path(key + start[b], spare + start[b], start[b + 1] - start[b], shift - 4);
}

static void sort_share(void *context, size_t share, unsigned worker) {
    (void)worker;
    sort_job *j = context;
    sl_visible_pixels *out = j->out;
    size_t begin, end;
    sl_visible_share(out, share, &begin, &end);
    for (size_t e = begin; e < end; e++) {
        sl_visible_face f = out->face[e];
        sort_by_path(j->key + f.first, j->spare + f.first, f.count, TOP_SHIFT);
        for (size_t i = f.first; i < f.first + f.count; i++) {
            uint32_t from = (uint32_t)j->key[i];
            out->pixel[i] = j->pixel[from];
            out->path[i] = (uint32_t)(j->key[i] >> PATH_SHIFT);
            out->w1[i] = j->w1[from];
            out->w2[i] = j->w2[from];
        }
    }
}

static bool allocate(sort_job *j) {
    size_t n = j->out->count;
    sl_visible_pixels *out = j->out;
    j->pixel = sl_allocate_unset(n, sizeof *j->pixel);
    j->face = sl_allocate_unset(n, sizeof *j->face);
    j->w1 = sl_allocate_unset(n, sizeof *j->w1);
    j->w2 = sl_allocate_unset(n, sizeof *j->w2);
    j->key = sl_allocate_unset(n, sizeof *j->key);
    j->spare = sl_allocate_unset(n, sizeof *j->spare);
    j->of_face = sl_allocate(2 * j->scene->triangle_count, sizeof *j->of_face);
    out->entry_of_face = sl_allocate_unset(2 * j->scene->triangle_count, sizeof *out->entry_of_face);
    out->pixel = sl_allocate_unset(n, sizeof *out->pixel);
    out->path = j->path = sl_allocate_unset(n, sizeof *out->path);
    out->w1 = sl_allocate_unset(n, sizeof *out->w1);
    out->w2 = sl_allocate_unset(n, sizeof *out->w2);
    return j->pixel && j->face && j->w1 && j->w2 && j->key && j->spare && j->of_face && out->entry_of_face &&
           out->pixel && out->path && out->w1 && out->w2;
}

static void release(sort_job *j) {
    sl_free(j->strip_start);
    sl_free(j->pixel);
    sl_free(j->face);
    sl_free(j->w1);
    sl_free(j->w2);
    sl_free(j->key);
    sl_free(j->spare);
    sl_free(j->of_face);
}

static sl_status sort(sort_job *j, unsigned threads, sl_counters *counters, sl_error *error) {
    sl_visible_pixels *out = j->out;
    j->strip_start = sl_allocate(j->strips + 1, sizeof *j->strip_start);
    if (!j->strip_start) return sl_fail_memory(error, "visible pixels");
    sl_parallel_for(threads, j->strips, count_strip, j);
    for (size_t s = 0; s < j->strips; s++) j->strip_start[s + 1] += j->strip_start[s];
    out->count = j->strip_start[j->strips];
    if (!allocate(j)) return sl_fail_memory(error, "visible pixels");
    const sl_gouraud_pass pass = {
        .channels = 2, .corners = corner_places, .shade = resolve_strip, .context = j};
    sl_raster_gouraud(j->raster, j->view, threads, j->id, &pass, counters);
    sl_status status = list_faces(j, error);
    if (status != SL_OK) return status;
    sl_parallel_for(threads, j->strips, deal_strip, j);
    sl_parallel_for(threads, SL_VISIBLE_SHARES, sort_share, j);
    return SL_OK;
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
                    .raster = raster,
                    .view = view,
                    .id = id,
                    .pixel_count = (size_t)view->width * (size_t)view->height,
                    .paths = sl_path_kernel_for(sl_isa_best()),
                    .out = out};
    job.strips = (job.pixel_count + STRIP - 1) / STRIP;
    sl_status status = sort(&job, sl_thread_count(threads), counters, error);
    release(&job);
    if (status != SL_OK) {
        sl_visible_pixels_destroy(out);
        return status;
    }
    *pixels = out;
    return SL_OK;
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
