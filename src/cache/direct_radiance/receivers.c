/* The camera's G-buffer with what planar mirrors show in it (passes 5 and 6). The scene is drawn again as seen from the eye's
 * mirror image where the stencil has the mirror's pixels; positions and normals are never unfolded, so shadow and photon look-ups stay in
 * world space, and only the eye differs from path to path. */
#include "cache/direct_radiance/receivers.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

/* ---- without a mirror ---- */

static sl_status outline_plainly(const sl_raster *raster, const sl_view *view, unsigned threads, sl_receivers *r, sl_counters *counters,
                                 sl_error *error) {
    r->path_count = 1;
    r->eye[0] = view->origin;
    r->view = sl_allocate(1, sizeof *r->view);
    if (!r->view) return sl_fail_memory(error, "the receivers' view");
    r->view[0] = *view;
    const sl_target target = {view->width, view->height, r->gbuffer->id, r->gbuffer->depth};
    return sl_raster_id(raster, view, threads, &target, counters, error);
}

/* ---- with mirrors ---- */

/* The product of k_s along each path; a path comes after the one that it prolongs. */
static void throughputs_of(const sl_scene *scene, const sl_mirrors *mirrors, const sl_mirrored_image *image, sl_rgb *throughput) {
    throughput[0] = sl_grey(1.0f);
    for (size_t p = 1; p < image->path_count; p++) {
        const sl_mirror_path *path = &image->paths[p];
        throughput[p] = sl_rgb_mul(throughput[path->before], scene->materials[mirrors->material[path->mirror]].mirror);
    }
}

typedef struct {
    const sl_receivers *receivers;
    const sl_rgb *of_path;
} spreading;

static void spread_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const spreading *s = context;
    const sl_receivers *r = s->receivers;
    const size_t width = (size_t)r->width;
    for (size_t i = row * width; i < (row + 1) * width; i++) {
        const sl_rgb t = s->of_path[r->path[i]];
        r->throughput[0][i] = t.r;
        r->throughput[1][i] = t.g;
        r->throughput[2][i] = t.b;
    }
}

static sl_status spread_throughput(const sl_scene *scene, const sl_mirrors *mirrors, const sl_mirrored_image *image, unsigned threads,
                                   sl_receivers *r, sl_error *error) {
    const size_t pixels = (size_t)r->width * (size_t)r->height;
    if (image->path_count == 1) return SL_OK;
    for (int k = 0; k < 3; k++) {
        r->throughput[k] = sl_allocate(pixels, sizeof *r->throughput[k]);
        if (!r->throughput[k]) return sl_fail_memory(error, "the throughput of mirrors");
    }
    sl_rgb of_path[SL_MIRROR_PATHS];
    throughputs_of(scene, mirrors, image, of_path);
    spreading s = {r, of_path};
    sl_parallel_for(sl_thread_count(threads), (size_t)r->height, spread_row, &s);
    return SL_OK;
}

static sl_status outline_mirrored(const sl_scene *scene, const sl_raster *raster, const sl_view *view, int reflections, unsigned threads,
                                  sl_receivers *r, sl_counters *counters, sl_error *error) {
    sl_mirrored_image *image = NULL;
    sl_status status = sl_raster_mirrored_into(raster, view, r->mirrors, reflections, threads, r->gbuffer->id, r->gbuffer->depth, &image,
                                               counters, error);
    if (status != SL_OK) return status;
    r->path_count = image->path_count;
    r->path = image->path;
    image->path = NULL;
    r->view = sl_allocate(r->path_count, sizeof *r->view);
    if (!r->view) status = sl_fail_memory(error, "the receivers' views");
    for (size_t p = 0; status == SL_OK && p < r->path_count; p++) {
        r->view[p] = image->paths[p].view;
        r->eye[p] = r->view[p].origin;
    }
    if (status == SL_OK) status = spread_throughput(scene, r->mirrors, image, threads, r, error);
    sl_mirrored_image_destroy(image);
    return status;
}

/* ---- the whole ---- */

static sl_status create_outline(int width, int height, bool depth, sl_gbuffer **gbuffer, sl_error *error) {
    size_t pixels = (size_t)width * (size_t)height;
    sl_gbuffer *g = sl_allocate(1, sizeof *g);
    if (!g) return sl_fail_memory(error, "the receivers");
    *g = (sl_gbuffer){.width = width, .height = height, .id = sl_allocate(pixels, sizeof *g->id)};
    if (depth) g->depth = sl_allocate(pixels, sizeof *g->depth);
    if (!g->id || (depth && !g->depth)) {
        sl_gbuffer_destroy(g);
        return sl_fail_memory(error, "the receivers");
    }
    *gbuffer = g;
    return SL_OK;
}

/* The G-buffer of an earlier frame of the same kind, or a new one: all of it is written anew in either case. */
static sl_status ready_gbuffer(sl_receivers *earlier, int width, int height, bool whole, bool depth, sl_gbuffer **gbuffer, sl_error *error) {
    sl_gbuffer *g = earlier ? earlier->gbuffer : NULL;
    if (!g || g->width != width || g->height != height || (g->position_x != NULL) != whole || (g->depth != NULL) != (whole || depth))
        return whole ? sl_gbuffer_create(width, height, gbuffer, error) : create_outline(width, height, depth, gbuffer, error);
    *gbuffer = g;
    earlier->gbuffer = NULL;
    return SL_OK;
}

static sl_status outline(const sl_scene *scene, const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors, int reflections,
                         unsigned threads, bool whole, sl_receivers **receivers, sl_counters *counters, sl_error *error) {
    sl_receivers *r = sl_allocate(1, sizeof *r), *earlier = *receivers;
    const bool mirrored = mirrors && mirrors->count > 0 && reflections > 0;
    *receivers = NULL;
    sl_status status = r ? ready_gbuffer(earlier, view->width, view->height, whole, mirrored, &r->gbuffer, error)
                         : sl_fail_memory(error, "the receivers");
    sl_receivers_destroy(earlier);
    if (!r) return status;
    r->width = view->width;
    r->height = view->height;
    r->mirrors = mirrors && mirrors->count ? mirrors : NULL;
    if (status == SL_OK) {
        status = mirrored ? outline_mirrored(scene, raster, view, reflections, threads, r, counters, error)
                          : outline_plainly(raster, view, threads, r, counters, error);
    }
    if (status != SL_OK) sl_receivers_destroy(r);
    else *receivers = r;
    return status;
}

sl_status sl_receivers_outline(const sl_scene *scene, const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors,
                               int reflections, unsigned threads, sl_receivers **receivers, sl_counters *counters, sl_error *error) {
    return outline(scene, raster, view, mirrors, reflections, threads, false, receivers, counters, error);
}

sl_status sl_receivers_render(const sl_scene *scene, const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors,
                              int reflections, unsigned threads, sl_receivers **receivers, sl_counters *counters, sl_error *error) {
    sl_status status = outline(scene, raster, view, mirrors, reflections, threads, true, receivers, counters, error);
    if (status != SL_OK) return status;
    const sl_receivers *r = *receivers;
    status = sl_raster_resolve(raster, r->path_count, r->view, r->path, threads, r->gbuffer, counters, error);
    if (status != SL_OK) {
        sl_receivers_destroy(*receivers);
        *receivers = NULL;
    }
    return status;
}

void sl_receivers_destroy(sl_receivers *r) {
    if (!r) return;
    sl_gbuffer_destroy(r->gbuffer);
    for (int k = 0; k < 3; k++) sl_free(r->throughput[k]);
    sl_free(r->path);
    sl_free(r->view);
    sl_free(r);
}

size_t sl_receivers_bytes(const sl_receivers *r) {
    enum { PLANES = 15, PLANE_BYTES = 4 };
    size_t pixels = (size_t)r->width * (size_t)r->height, bytes = sizeof *r + sizeof *r->gbuffer + r->path_count * sizeof *r->view;
    bytes += pixels * PLANE_BYTES * (r->gbuffer->position_x ? (size_t)PLANES : r->gbuffer->depth ? 2u : 1u);
    for (int k = 0; k < 3; k++) bytes += r->throughput[k] ? pixels * sizeof *r->throughput[k] : 0;
    return bytes + (r->path ? pixels : 0);
}
