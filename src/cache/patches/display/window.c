/* From where frames are drawn: a camera and the positions of objects, the hardware that holds them, planes.
 * The thread that builds the arrays has one window for its id maps, another thread may have one to show them
 * in; the two meet in the copies of the arrays alone (copies.h). */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/patches/display/display.h"

static size_t pixels_of(const sl_display *d) {
    return (size_t)d->settings.width * (size_t)d->settings.height;
}

static bool allocate_planes(sl_window *w, bool curved) {
    const size_t pixels = pixels_of(w->display);
    w->id = sl_allocate(pixels, sizeof *w->id);
    if (!curved) return w->id != NULL;
    w->curved_id = sl_allocate(pixels, sizeof *w->curved_id);
    w->depth = sl_allocate(pixels, sizeof *w->depth);
    w->curved_depth = sl_allocate(pixels, sizeof *w->curved_depth);
    return w->id && w->curved_id && w->depth && w->curved_depth;
}

sl_status sl_window_open(sl_display *d, const sl_scene *scene, unsigned threads, sl_window *w,
                         sl_error *error) {
    *w = (sl_window){.display = d, .scene = scene, .threads = sl_thread_count(threads)};
    if (!allocate_planes(w, d->curved != NULL))
        return sl_fail_memory(error, "the display");
    sl_status status = sl_raster_create(scene, w->threads, &w->raster, error);
    if (status == SL_OK && d->curved) status = sl_tessellate(w, error);
    return status;
}

void sl_window_close(sl_window *w) {
    sl_tessellation_release(&w->tessellation);
    sl_raster_destroy(w->raster);
    SL_FREE_ALL(w->id, w->curved_id, w->depth, w->curved_depth, w->picture);
}

sl_status sl_window_create(sl_display *d, const sl_scene *scene_copy, unsigned threads, sl_window **window,
                           sl_error *error) {
    sl_window *w = sl_allocate(1, sizeof *w);
    *window = NULL;
    if (!w) return sl_fail_memory(error, "a window of the display");
    sl_status status = sl_window_open(d, scene_copy, threads, w, error);
    if (status == SL_OK && !(w->picture = sl_allocate(3 * pixels_of(d), sizeof *w->picture)))
        status = sl_fail_memory(error, "a window of the display");
    if (status == SL_OK) *window = w;
    else sl_window_destroy(w);
    return status;
}

void sl_window_destroy(void *window) {
    if (window) sl_window_close(window);
    sl_free(window);
}

sl_status sl_window_move(void *window, sl_error *error) {
    sl_window *w = window;
    sl_status status = sl_raster_move(w->raster, w->threads, error);
    return status == SL_OK && w->display->curved ? sl_tessellation_move(w, error) : status;
}

const uint32_t *sl_window_ids(const void *window) { return ((const sl_window *)window)->id; }

sl_status sl_window_picture(void *window, sl_image *image, uint64_t *builds, sl_counters *counters,
                            sl_error *error) {
    sl_window *w = window;
    size_t pixels = pixels_of(w->display);
    float *const planes[6] = {w->picture, w->picture + pixels, w->picture + 2 * pixels};
    sl_status status = sl_window_draw(w, planes, counters, error);
    for (size_t k = 0; k < 3 && status == SL_OK; k++)
        sl_raster_flip(planes[k], image->width, image->height, image->planes + k * pixels);
    *builds = w->builds;
    return status;
}
