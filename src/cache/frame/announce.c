#include "cache/frame/announce.h"

#include "base/counters.h"
#include "base/memory.h"

#include <string.h>

/* Tells it with what the counters have grown by since the last pass; no picture: NULL. */
static void tell(sl_announcer *a, sl_pass pass) {
    sl_counters cost = *a->counters;
    sl_counters_subtract(&cost, &a->told);
    a->told = *a->counters;
    pass.method = a->method;
    pass.counters = &cost;
    a->observer->pass(a->observer->context, &pass);
}

void sl_announce(sl_announcer *a, const char *name, const char *source, int width, int height, int channels,
                 const float *planes, bool bottom_first) {
    if (!sl_announcing(a)) return;
    sl_image *image = NULL;
    const size_t pixels = (size_t)width * (size_t)height;
    if (planes && sl_image_create(width, height, channels, NULL, &image, NULL) == SL_OK) {
        for (size_t c = 0; c < (size_t)channels; c++) {
            const float *plane = planes + c * pixels;
            float *out = image->planes + c * pixels;
            if (bottom_first) sl_raster_flip(plane, width, height, out);
            else memcpy(out, plane, pixels * sizeof *out);
        }
    }
    tell(a, (sl_pass){.name = name, .source = source, .buffer = image});
    sl_image_destroy(image);
}

void sl_announce_marks(sl_announcer *a, const char *name, const char *source, const sl_mark *marks,
                       size_t count) {
    if (sl_announcing(a))
        tell(a, (sl_pass){.name = name, .source = source, .marks = marks, .mark_count = count});
}

void sl_announce_ids(sl_announcer *a, const char *name, const char *source, int width, int height,
                     const uint32_t *id) {
    size_t pixels = (size_t)width * (size_t)height;
    float *plane = sl_announcing(a) ? sl_allocate(pixels, sizeof *plane) : NULL;
    for (size_t i = 0; plane && i < pixels; i++) plane[i] = id[i] == SL_NO_INDEX ? -1.0f : (float)id[i];
    sl_announce(a, name, source, plane ? width : 0, plane ? height : 0, plane ? 1 : 0, plane, true);
    sl_free(plane);
}

void sl_announce_pass(sl_announcer *a, const char *name, const char *source) {
    sl_announce(a, name, source, 0, 0, 0, NULL, true);
}

void sl_announce_planes(sl_announcer *a, const char *name, const char *source, int width, int height,
                        const float *const planes[3]) {
    size_t pixels = (size_t)width * (size_t)height;
    float *together = sl_announcing(a) ? sl_allocate(3 * pixels, sizeof *together) : NULL;
    if (!together) return;
    for (size_t c = 0; c < 3; c++) memcpy(together + c * pixels, planes[c], pixels * sizeof *together);
    sl_announce(a, name, source, width, height, 3, together, true);
    sl_free(together);
}

void sl_announce_gbuffer(sl_announcer *a, const char *source, const sl_gbuffer *g) {
    const struct {
        const char *name;
        const float *planes[3];
    } pictures[] = {{"G-buffer: positions", {g->position_x, g->position_y, g->position_z}},
                    {"G-buffer: normals", {g->normal_x, g->normal_y, g->normal_z}},
                    {"G-buffer: albedo", {g->diffuse_r, g->diffuse_g, g->diffuse_b}}};
    sl_announce(a, "G-buffer: depth", source, g->width, g->height, 1, g->depth, true);
    for (size_t i = 0; i < sizeof pictures / sizeof pictures[0]; i++)
        sl_announce_planes(a, pictures[i].name, source, g->width, g->height, pictures[i].planes);
}
