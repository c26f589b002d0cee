/* Visible sizes (image pass 1): a counting sort of the id map's pixels by the faces that they show. */
#include "cache/patches/display/pixels.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/patches/primitives.h"

typedef struct sort_job {
    const sl_primitives *primitives;
    sl_vec3 eye;
    const uint32_t *id;
    size_t pixels;
    float *weight[2];          /* by pixel of the screen: of the triangle's corners 1 and 2, */
    uint32_t *face;            /* ... SL_NO_INDEX: none */
    uint32_t *next;            /* by face: how many pixels show it; then where its next one goes */
    sl_visible_pixels *out;
} sort_job;

/* ---- the sort -------------------------------------------------------------------------------- */

static uint32_t root_seen(const sort_job *j, uint32_t triangle) {
    return sl_root_seen(j->primitives, j->primitives->scene, triangle, j->eye);
}

/* Lists faces in view with their counts, and their pixels. */
static sl_status list_faces(sort_job *j, sl_error *error) {
    sl_visible_pixels *out = j->out;
    size_t faces = 2 * j->primitives->count, visible = 0;
    for (size_t i = 0; i < j->pixels; i++) {
        bool again = i > 0 && j->id[i] == j->id[i - 1], none = j->id[i] == SL_NO_INDEX;
        j->face[i] = again ? j->face[i - 1] : none ? SL_NO_INDEX : root_seen(j, j->id[i]);
        if (!none) visible += j->next[j->face[i]]++ == 0;
    }
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
    for (uint32_t i = 0; i < j->pixels; i++) {
        if (j->face[i] == SL_NO_INDEX) continue;
        uint32_t at = j->next[j->face[i]]++;
        out->pixel[at] = i;
        out->w1[at] = j->weight[0][i];
        out->w2[at] = j->weight[1][i];
    }
    return SL_OK;
}

static bool allocate(sort_job *j) {
    size_t n = j->pixels, faces = 2 * j->primitives->count;
    sl_visible_pixels *out = j->out;
    j->weight[0] = sl_allocate_unset(2 * n, sizeof *j->weight[0]);
    j->face = sl_allocate_unset(n, sizeof *j->face);
    j->next = sl_allocate(faces, sizeof *j->next);
    out->entry_of_face = sl_allocate_unset(faces, sizeof *out->entry_of_face);
    out->pixel = sl_allocate_unset(n, sizeof *out->pixel);
    out->w1 = sl_allocate_unset(n, sizeof *out->w1);
    out->w2 = sl_allocate_unset(n, sizeof *out->w2);
    return j->weight[0] && j->face && j->next && out->entry_of_face &&
           out->pixel && out->w1 && out->w2;
}

/* The Gouraud pass interpolates a place (u, v) in the root. */
static void places(const void *context, uint32_t triangle, float *value) {
    sl_root_corner_parameters(((const sort_job *)context)->primitives, triangle, value);
}

static sl_status sort(sort_job *j, const sl_raster *raster, const sl_view *view, unsigned threads,
                      sl_counters *counters, sl_error *error) {
    if (!allocate(j)) return sl_fail_memory(error, "visible pixels");
    const sl_gouraud_pass pass = {.channels = 2, .corners = places, .context = j, .out = j->weight[0]};
    j->weight[1] = j->weight[0] + j->pixels;
    sl_raster_gouraud(raster, view, threads, j->id, &pass, counters);
    return list_faces(j, error);
}

sl_status sl_visible_pixels_sort(const sl_primitives *primitives, const sl_raster *raster,
                                 const sl_view *view, const uint32_t *id, unsigned threads,
                                 sl_visible_pixels **pixels, sl_counters *counters, sl_error *error) {
    sl_visible_pixels *out = sl_allocate(1, sizeof *out);
    if (!out) return sl_fail_memory(error, "visible pixels");
    out->view = *view;
    sort_job job = {.primitives = primitives,
                    .eye = view->origin,
                    .id = id,
                    .pixels = (size_t)view->width * (size_t)view->height,
                    .out = out};
    sl_status status = sort(&job, raster, view, sl_thread_count(threads), counters, error);
    SL_FREE_ALL(job.weight[0], job.face, job.next);
    if (status == SL_OK) *pixels = out;
    else sl_visible_pixels_destroy(out);
    return status;
}

void sl_visible_pixels_destroy(sl_visible_pixels *pixels) {
    if (!pixels) return;
    SL_FREE_ALL(pixels->face, pixels->entry_of_face, pixels->pixel, pixels->w1, pixels->w2, pixels);
}
