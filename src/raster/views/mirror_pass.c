/* The picture of a scene with planar mirrors (mirror.h): path by path, each drawn where the
 * stencil holds its number. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "raster/views/mirror.h"

typedef struct {
    int x0, y0, x1, y1; /* half-open; empty: x0 >= x1 */
} rectangle;

static const rectangle nothing = {INT32_MAX, INT32_MAX, 0, 0};

static int larger(int a, int b) { return a > b ? a : b; }
static int smaller(int a, int b) { return a < b ? a : b; }

static void include(rectangle *r, int x, int y) {
    if (x < r->x0) r->x0 = x;
    if (y < r->y0) r->y0 = y;
    if (x >= r->x1) r->x1 = x + 1;
    if (y >= r->y1) r->y1 = y + 1;
}

/* ---- stencil ---- */

static bool allocate_planes(sl_target *t, int width, int height) {
    size_t pixels = (size_t)width * (size_t)height;
    *t =
        (sl_target){width, height, sl_allocate(pixels, sizeof *t->id), sl_allocate(pixels, sizeof *t->depth)};
    return t->id && t->depth;
}

static void free_planes(sl_target *t) {
    sl_free(t->id);
    sl_free(t->depth);
}

static size_t pixel_at(const sl_target *t, int x, int y) { return (size_t)y * (size_t)t->width + (size_t)x; }

/* Copies a row of the rectangle aside, or brings back what the stencil keeps. Planes that are not wanted are
 * NULL. */
static void set_aside(const sl_target *target, const rectangle *r, int y, const sl_target *aside) {
    size_t from = pixel_at(target, r->x0, y), to = pixel_at(aside, 0, y - r->y0),
           count = (size_t)(r->x1 - r->x0);
    if (target->id) memcpy(aside->id + to, target->id + from, count * sizeof *aside->id);
    if (target->depth) memcpy(aside->depth + to, target->depth + from, count * sizeof *aside->depth);
}

static void bring_back(const sl_target *aside, const rectangle *r, int y, const uint8_t *stencil,
                       uint8_t reference, const sl_target *target) {
    for (int x = r->x0; x < r->x1; x++) {
        size_t to = pixel_at(target, x, y), from = pixel_at(aside, x - r->x0, y - r->y0);
        if (stencil[to] == reference) continue;
        if (target->id) target->id[to] = aside->id[from];
        if (target->depth) target->depth[to] = aside->depth[from];
    }
}

/* Draws the rectangle and then brings back the pixels that the stencil keeps: the hot loop knows no stencil,
 * and the price is that of the rectangle. */
static sl_status draw_stencilled(const sl_raster *raster, const sl_view *view, const uint8_t *stencil,
                                 uint8_t reference, const rectangle *r, unsigned threads,
                                 const sl_target *target, sl_counters *counters, sl_error *error) {
    sl_view part = *view;
    sl_target aside;
    part.scissor = (sl_scissor){r->x0, r->y0, r->x1, r->y1};
    sl_status status = allocate_planes(&aside, r->x1 - r->x0, r->y1 - r->y0)
                           ? SL_OK
                           : sl_fail_memory(error, "a stencilled pass");
    for (int y = r->y0; status == SL_OK && y < r->y1; y++) set_aside(target, r, y, &aside);
    if (status == SL_OK) status = sl_raster_id(raster, &part, threads, target, counters, error);
    for (int y = r->y0; status == SL_OK && y < r->y1; y++)
        bring_back(&aside, r, y, stencil, reference, target);
    free_planes(&aside);
    return status;
}

/* ---- paths ---- */

typedef struct {
    const sl_raster *raster;
    const sl_mirrors *mirrors;
    unsigned threads;
    sl_mirrored_image *image;
    rectangle *seen; /* by mirror: where one path sees it */
    sl_counters *counters;
} mirrored_pass;

static size_t path_at(const sl_mirrored_image *image, size_t pixel) {
    return image->path ? image->path[pixel] : 0;
}

/* The mirror that a path's pixel shows, or SL_NO_INDEX. A mirror does not show itself; rounding is not to say
 * otherwise. */
static uint32_t mirror_at(const mirrored_pass *p, size_t path, size_t pixel) {
    const sl_mirrored_image *image = p->image;
    uint32_t id = image->id[pixel];
    if (path_at(image, pixel) != path || id == SL_NO_INDEX) return SL_NO_INDEX;
    uint32_t mirror = p->mirrors->of_triangle[id];
    return mirror == image->paths[path].mirror ? SL_NO_INDEX : mirror;
}

static double row_at(const float row[4], sl_vec3d q) {
    return (double)row[0] * q.x + (double)row[1] * q.y + (double)row[2] * q.z + (double)row[3];
}

/* The pixels that a mirror may cover: those around its box's corners, with one to spare; all where the box
 * reaches to the eye's plane. */
static rectangle may_cover(const sl_view *view, sl_vec3 low, sl_vec3 high) {
    double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY, nearest = INFINITY,
           farthest = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        sl_vec3 p =
            sl_v3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z);
        sl_vec3d q = sl_subd(sl_to_double(p), sl_to_double(view->origin));
        double w = row_at(view->clip[3], q), x = row_at(view->clip[0], q) / w,
               y = row_at(view->clip[1], q) / w;
        nearest = fmin(nearest, w);
        farthest = fmax(farthest, w);
        x0 = fmin(x0, x);
        x1 = fmax(x1, x);
        y0 = fmin(y0, y);
        y1 = fmax(y1, y);
    }
    if (farthest < 0.0) return nothing;
    if (!(nearest > 1e-6 * farthest)) return (rectangle){0, 0, view->width, view->height};
    const double width = (double)view->width, height = (double)view->height;
    return (rectangle){(int)fmax(0.0, fmin(width, floor((x0 + 1.0) * 0.5 * width) - 1.0)),
                       (int)fmax(0.0, fmin(height, floor((y0 + 1.0) * 0.5 * height) - 1.0)),
                       (int)fmin(width, fmax(0.0, ceil((x1 + 1.0) * 0.5 * width) + 1.0)),
                       (int)fmin(height, fmax(0.0, ceil((y1 + 1.0) * 0.5 * height) + 1.0))};
}

/* The part of a path's pixels that mirrors may cover. */
static rectangle where_mirrors_may_be(const mirrored_pass *p, const sl_mirror_path *from) {
    rectangle all = nothing;
    for (size_t m = 0; m < p->mirrors->count; m++) {
        rectangle r = may_cover(&from->view, p->mirrors->low[m], p->mirrors->high[m]);
        if (r.x0 >= r.x1 || r.y0 >= r.y1) continue;
        include(&all, r.x0, r.y0);
        include(&all, r.x1 - 1, r.y1 - 1);
    }
    return (rectangle){larger(all.x0, from->x0), larger(all.y0, from->y0), smaller(all.x1, from->x1),
                       smaller(all.y1, from->y1)};
}

static void find_mirrors(const mirrored_pass *p, size_t path) {
    const rectangle part = where_mirrors_may_be(p, &p->image->paths[path]);
    for (size_t m = 0; m < p->mirrors->count; m++) p->seen[m] = nothing;
    for (int y = part.y0; y < part.y1; y++) {
        const size_t row = (size_t)y * (size_t)p->image->width;
        uint32_t id = SL_NO_INDEX, mirror = SL_NO_INDEX; /* mostly a pixel shows what its neighbour shows */
        for (int x = part.x0; x < part.x1; x++) {
            if (path_at(p->image, row + (size_t)x) != path) continue;
            if (p->image->id[row + (size_t)x] != id) {
                id = p->image->id[row + (size_t)x];
                mirror = mirror_at(p, path, row + (size_t)x);
            }
            if (mirror != SL_NO_INDEX) include(&p->seen[mirror], x, y);
        }
    }
}

/* Sets the stencil to the new path's number where the path shows the mirror, and draws there. */
static sl_status follow(const mirrored_pass *p, size_t path, uint32_t mirror, sl_error *error) {
    sl_mirrored_image *image = p->image;
    const rectangle *r = &p->seen[mirror];
    sl_view view;
    if (image->path_count == SL_MIRROR_PATHS) return SL_OK;
    if (!sl_view_mirrored(&image->paths[path].view, &p->mirrors->plane[mirror], p->mirrors->offset, &view))
        return SL_OK;
    if (!image->path)
        image->path = sl_allocate((size_t)image->width * (size_t)image->height, sizeof *image->path);
    if (!image->path) return sl_fail_memory(error, "the paths of a picture with mirrors");
    uint8_t number = (uint8_t)image->path_count++;
    image->paths[number] = (sl_mirror_path){view, mirror, (uint8_t)path, image->paths[path].reflections + 1,
                                            r->x0, r->y0, r->x1, r->y1};
    for (int y = r->y0; y < r->y1; y++) {
        for (int x = r->x0; x < r->x1; x++) {
            size_t pixel = (size_t)y * (size_t)image->width + (size_t)x;
            if (mirror_at(p, path, pixel) == mirror) image->path[pixel] = number;
        }
    }
    sl_target target = {
        .width = image->width, .height = image->height, .id = image->id, .depth = image->depth};
    return draw_stencilled(p->raster, &view, image->path, number, r, p->threads, &target, p->counters, error);
}

/* Paths are followed in the order in which they were found, so those of fewer reflections come first. */
static sl_status follow_all(const mirrored_pass *p, const sl_view *view, int reflections, sl_error *error) {
    sl_mirrored_image *image = p->image;
    sl_target target = {
        .width = image->width, .height = image->height, .id = image->id, .depth = image->depth};
    sl_status status = sl_raster_id(p->raster, view, p->threads, &target, p->counters, error);
    image->paths[0] = (sl_mirror_path){*view, SL_NO_INDEX, 0, 0, 0, 0, image->width, image->height};
    image->path_count = 1;
    for (size_t path = 0; status == SL_OK && path < image->path_count; path++) {
        if (image->paths[path].reflections >= reflections) break;
        find_mirrors(p, path);
        for (uint32_t m = 0; status == SL_OK && m < p->mirrors->count; m++) {
            if (p->seen[m].x0 < p->seen[m].x1) status = follow(p, path, m, error);
        }
    }
    return status;
}

sl_status sl_raster_mirrored(const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors,
                             int reflections, unsigned threads, uint32_t *id, float *depth,
                             sl_mirrored_image **image, sl_counters *counters, sl_error *error) {
    *image = NULL;
    if (view->width < 1 || view->height < 1 || view->x != 0 || view->y != 0) {
        return sl_fail(error, SL_ERROR_USAGE,
                       "a picture with mirrors of %d x %d pixels at (%d, %d): at least 1 each way, at (0, 0)",
                       view->width, view->height, view->x, view->y);
    }
    mirrored_pass p = {raster,
                       mirrors,
                       threads,
                       sl_allocate(1, sizeof *p.image),
                       sl_allocate(mirrors->count, sizeof(rectangle)),
                       counters};
    if (p.image)
        *p.image =
            (sl_mirrored_image){.width = view->width, .height = view->height, .id = id, .depth = depth};
    sl_status status = p.image && p.seen ? follow_all(&p, view, reflections, error)
                                         : sl_fail_memory(error, "a picture with mirrors");
    sl_free(p.seen);
    if (status != SL_OK) sl_mirrored_image_destroy(p.image);
    else *image = p.image;
    return status;
}

void sl_mirrored_image_destroy(sl_mirrored_image *image) {
    if (!image) return;
    sl_free(image->path);
    sl_free(image);
}
