/* Frames beside updates: geometry follows camera and objects at once, shading is what the last update has left. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/shading_cache/state.h"

typedef struct shading_window {
    sl_display *display;
    sl_window *window;
    sl_settings settings;
    float *planes; /* of a frame, bottom row first */
} shading_window;

static void window_destroy(void *window) {
    shading_window *w = window;
    if (!w) return;
    sl_window_destroy(w->window);
    sl_free(w->planes);
    sl_free(w);
}

static sl_status window_create(void *state, const sl_scene *twin, void **window, sl_error *error) {
    const sl_shading_state *s = state;
    shading_window *w = sl_allocate(1, sizeof *w);
    *window = NULL;
    if (!w) return sl_fail_memory(error, "a window of the display");
    w->display = s->display;
    w->settings = s->settings;
    w->planes = sl_allocate(3 * sl_shading_pixels(s), sizeof *w->planes);
    sl_status status = w->planes ? sl_window_create(s->display, twin, &w->window, error) : sl_fail_memory(error, "a window of the display");
    if (status == SL_OK) *window = w;
    else window_destroy(w);
    return status;
}

static sl_status window_move(void *window, sl_error *error) {
    const shading_window *w = window;
    return sl_window_move(w->display, w->window, error);
}

/* On the calling thread alone: the others are busy with samples. */
static sl_status window_draw(void *window, sl_image *image, uint64_t *versions, sl_counters *counters, sl_error *error) {
    const shading_window *w = window;
    size_t pixels = (size_t)w->settings.width * (size_t)w->settings.height;
    float *const planes[3] = {w->planes, w->planes + pixels, w->planes + 2 * pixels};
    sl_status status = sl_window_draw(w->display, w->window, 1, planes, counters, error);
    if (status != SL_OK) return status;
    for (int k = 0; k < 3; k++) sl_raster_flip(planes[k], w->settings.width, w->settings.height, image->planes + (size_t)k * pixels);
    *versions = sl_window_builds(w->window);
    return SL_OK;
}

const sl_window_class sl_shading_window = {.create = window_create, .destroy = window_destroy, .move = window_move, .draw = window_draw};
