/* The camera's G-buffer with what planar mirrors show in it (passes 5 and 6). The scene is drawn again as
 * seen from the eye's mirror image where the stencil has the mirror's pixels; positions and normals are never
 * unfolded, so shadow and photon look-ups stay in world space, and only the eye differs from path to path. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/receivers.h"

#include <string.h>

/* ---- without a mirror ---- */

static sl_status outline_plainly(const sl_raster *raster, const sl_view *view, unsigned threads,
                                 sl_receivers *r, sl_counters *counters, sl_error *error) {
    r->path_count = 1;
    r->eye[0] = view->origin;
    r->view = sl_allocate(1, sizeof *r->view);
    if (!r->view) return sl_fail_memory(error, "the receivers' view");
    r->view[0] = *view;
    const sl_target target = {view->width, view->height, r->gbuffer->id, r->gbuffer->depth};
    return sl_raster_id(raster, view, threads, &target, counters, error);
}

/* ---- with mirrors ---- */

/* Multiplies k_s along each path; a path comes after the one that it prolongs. */
static void throughputs_of(const sl_scene *scene, const sl_mirrors *mirrors, const sl_mirrored_image *image,
                           sl_rgb *throughput) {
    throughput[0] = sl_grey(1.0f);
    for (size_t p = 1; p < image->path_count; p++) {
        const sl_mirror_path *path = &image->paths[p];
        throughput[p] =
            sl_rgb_mul(throughput[path->before], scene->materials[mirrors->material[path->mirror]].mirror);
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

static sl_status spread_throughput(const sl_scene *scene, const sl_mirrors *mirrors,
                                   const sl_mirrored_image *image, unsigned threads, sl_receivers *r,
                                   sl_error *error) {
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

static sl_status outline_mirrored(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                                  int reflections, unsigned threads, sl_receivers *r, sl_counters *counters,
                                  sl_error *error) {
    sl_mirrored_image *image = NULL;
    sl_status status = sl_raster_mirrored(raster, view, r->mirrors, reflections, threads, r->gbuffer->id,
                                          r->gbuffer->depth, &image, counters, error);
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

/* Takes the G-buffer of an earlier frame of the same kind, or a new one: all of it is written anew in either
 * case.
 */
static sl_status ready_gbuffer(sl_receivers *earlier, int width, int height, bool whole, bool depth,
                               sl_gbuffer **gbuffer, sl_error *error) {
    sl_gbuffer *g = earlier ? earlier->gbuffer : NULL;
    if (!g || g->width != width || g->height != height || (g->position_x != NULL) != whole ||
        (g->depth != NULL) != (whole || depth))
        return whole ? sl_gbuffer_create(width, height, gbuffer, error)
                     : create_outline(width, height, depth, gbuffer, error);
    *gbuffer = g;
    earlier->gbuffer = NULL;
    return SL_OK;
}

static sl_status outline(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                         const sl_mirrors *mirrors, int reflections, unsigned threads, bool whole,
                         sl_receivers **receivers, sl_counters *counters, sl_error *error) {
    sl_receivers *r = sl_allocate(1, sizeof *r), *earlier = *receivers;
    const bool mirrored = mirrors && mirrors->count > 0 && reflections > 0;
    *receivers = NULL;
    sl_status status =
        r ? ready_gbuffer(earlier, view->width, view->height, whole, mirrored, &r->gbuffer, error)
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

sl_status sl_receivers_outline(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                               const sl_mirrors *mirrors, int reflections, unsigned threads,
                               sl_receivers **receivers, sl_counters *counters, sl_error *error) {
    return outline(scene, raster, view, mirrors, reflections, threads, false, receivers, counters, error);
}

sl_status sl_receivers_render(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                              const sl_mirrors *mirrors, int reflections, unsigned threads,
                              sl_receivers **receivers, sl_counters *counters, sl_error *error) {
    sl_status status =
        outline(scene, raster, view, mirrors, reflections, threads, true, receivers, counters, error);
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
    size_t pixels = (size_t)r->width * (size_t)r->height,
           bytes = sizeof *r + sizeof *r->gbuffer + r->path_count * sizeof *r->view;
    bytes += pixels * PLANE_BYTES * (r->gbuffer->position_x ? (size_t)PLANES : r->gbuffer->depth ? 2u : 1u);
    for (int k = 0; k < 3; k++) bytes += r->throughput[k] ? pixels * sizeof *r->throughput[k] : 0;
    return bytes + (r->path ? pixels : 0);
}

sl_status sl_receiver_kinds_find(const sl_scene *scene, sl_rgb trick_albedo, sl_receiver_kinds *kinds,
                                 sl_error *error) {
    *kinds = (sl_receiver_kinds){.scene = scene, .trick_albedo = trick_albedo};
    kinds->of_material = sl_allocate(scene->material_count + 1, sizeof *kinds->of_material);
    if (!kinds->of_material) return sl_fail_memory(error, "kinds of receivers");
    bool trick = sl_rgb_max(trick_albedo) > 0.0f;
    for (size_t m = 0; m < scene->material_count; m++) {
        const sl_material *material = &scene->materials[m];
        bool diffuse = sl_material_is_diffuse(material), glossy = sl_material_is_glossy(material);
        bool mirror = trick && sl_material_is_mirror(material);
        kinds->of_material[m] = glossy    ? SL_RECEIVER_GLOSSY
                                : diffuse ? SL_RECEIVER_DIFFUSE
                                : mirror  ? SL_RECEIVER_MIRROR
                                          : SL_RECEIVER_NONE;
        kinds->glossy |= glossy;
    }
    kinds->of_material[scene->material_count] = SL_RECEIVER_NONE;
    return SL_OK;
}

void sl_receiver_kinds_release(sl_receiver_kinds *kinds) {
    sl_free(kinds->of_material);
    kinds->of_material = NULL;
}

sl_receiver_kind sl_receiver_kind_at(const sl_receiver_kinds *kinds, const sl_gbuffer *g, size_t pixel) {
    size_t material = g->material[pixel], none = kinds->scene->material_count;
    return (sl_receiver_kind)kinds->of_material[material < none ? material : none];
}

/* ---- filling ---- */

/* Rows as they stand where every pixel is there, one by one otherwise. */
void sl_receiver_tile_fetch(const sl_gbuffer *g, const sl_receiver_kernels *kernels, sl_receiver_tile *t) {
    const float *const from[SL_TILE_PLANES] = {g->position_x,  g->position_y,  g->position_z, g->geometric_x,
                                               g->geometric_y, g->geometric_z, g->normal_x,   g->normal_y,
                                               g->normal_z,    g->diffuse_r,   g->diffuse_g,  g->diffuse_b};
    float *const to[SL_TILE_PLANES] = {t->x,           t->y,           t->z,          t->geometric_x,
                                       t->geometric_y, t->geometric_z, t->normal_x,   t->normal_y,
                                       t->normal_z,    t->diffuse[0],  t->diffuse[1], t->diffuse[2]};
    t->padded = (t->count + SL_TILE_LANES - 1) / SL_TILE_LANES * SL_TILE_LANES;
    for (size_t i = 0; i < t->count; i++) t->triangle[i] = g->id[t->pixel[i]];
    if (t->whole) {
        kernels->fetch_rows(from, (size_t)g->width, t);
        return;
    }
    for (int k = 0; k < SL_TILE_PLANES; k++) {
        for (size_t i = 0; i < t->count; i++) to[k][i] = from[k][t->pixel[i]];
        for (size_t i = t->count; i < t->padded; i++) to[k][i] = 0.0f;
    }
    kernels->prepare(t);
}

/* Curved mirrors alone: a planar one lies beyond the nesting limit, and has its indirect light already. */
static void set_trick(const sl_receivers *receivers, const sl_receiver_kinds *kinds, sl_receiver_tile *t) {
    const sl_gbuffer *g = receivers->gbuffer;
    const sl_mirrors *planar = receivers->mirrors;
    for (size_t i = 0; i < t->count; i++) {
        if (sl_receiver_kind_at(kinds, g, t->pixel[i]) != SL_RECEIVER_MIRROR) continue;
        if (planar && planar->of_triangle[g->id[t->pixel[i]]] != SL_NO_INDEX) continue;
        sl_rgb albedo =
            sl_rgb_mul(kinds->scene->materials[g->material[t->pixel[i]]].mirror, kinds->trick_albedo);
        t->diffuse[0][i] = albedo.r * (float)(1.0 / SL_PI);
        t->diffuse[1][i] = albedo.g * (float)(1.0 / SL_PI);
        t->diffuse[2][i] = albedo.b * (float)(1.0 / SL_PI);
    }
}

static void set_lobes(const sl_receivers *receivers, const sl_scene *scene,
                      const sl_receiver_kernels *kernels, sl_receiver_tile *t) {
    for (size_t i = 0; i < t->padded; i++) {
        size_t pixel = t->pixel[i < t->count ? i : 0];
        const sl_material *m = &scene->materials[receivers->gbuffer->material[pixel]];
        sl_vec3 eye = sl_receiver_eye(receivers, pixel);
        float scale = (m->exponent + 2.0f) * (float)(0.5 / SL_PI);
        t->mirrored_x[i] = eye.x, t->mirrored_y[i] = eye.y, t->mirrored_z[i] = eye.z;
        t->exponent[i] = m->exponent;
        t->specular[0][i] = m->specular.r * scale;
        t->specular[1][i] = m->specular.g * scale;
        t->specular[2][i] = m->specular.b * scale;
    }
    kernels->mirror_eye(t);
}

static bool receives(sl_receiver_kind kind, bool glossy) {
    return kind != SL_RECEIVER_NONE && (kind == SL_RECEIVER_GLOSSY) == glossy;
}

/* Lists all pixels of a tile that shows one material, as most do. */
static bool list_all(const sl_gbuffer *g, const sl_receiver_kinds *kinds, const sl_receiver_kernels *kernels,
                     bool glossy, int x0, int y0, sl_receiver_tile *t, bool *mirrors) {
    const uint32_t first = (uint32_t)y0 * (uint32_t)g->width + (uint32_t)x0;
    if (x0 + SL_TILE_WIDTH > g->width || y0 + SL_TILE_HEIGHT > g->height) return false;
    if (!kernels->survey(g->material, first, (uint32_t)g->width, t->pixel)) return false;
    const sl_receiver_kind kind = sl_receiver_kind_at(kinds, g, first);
    t->count = receives(kind, glossy) ? SL_TILE_PIXELS : 0;
    *mirrors = kind == SL_RECEIVER_MIRROR;
    return true;
}

static void list_wanted(const sl_gbuffer *g, const sl_receiver_kinds *kinds, bool glossy, int x0, int y0,
                        sl_receiver_tile *t, bool *mirrors) {
    const int x1 = x0 + SL_TILE_WIDTH < g->width ? x0 + SL_TILE_WIDTH : g->width;
    const int y1 = y0 + SL_TILE_HEIGHT < g->height ? y0 + SL_TILE_HEIGHT : g->height;
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            size_t pixel = (size_t)y * (size_t)g->width + (size_t)x;
            sl_receiver_kind kind = sl_receiver_kind_at(kinds, g, pixel);
            *mirrors |= kind == SL_RECEIVER_MIRROR;
            t->pixel[t->count] = (uint32_t)pixel;
            t->count += receives(kind, glossy) ? 1 : 0;
        }
    }
}

static void fill_tile(const sl_receivers *receivers, const sl_receiver_kinds *kinds,
                      const sl_receiver_kernels *kernels, bool glossy, int x0, int y0, sl_receiver_tile *t) {
    const sl_gbuffer *g = receivers->gbuffer;
    bool mirrors = false;
    t->count = 0;
    if (!list_all(g, kinds, kernels, glossy, x0, y0, t, &mirrors))
        list_wanted(g, kinds, glossy, x0, y0, t, &mirrors);
    t->whole = t->count == SL_TILE_PIXELS;
    if (t->count == 0) return;
    sl_receiver_tile_fetch(g, kernels, t);
    if (mirrors) set_trick(receivers, kinds, t);
    if (glossy) set_lobes(receivers, kinds->scene, kernels, t);
}

sl_light_points sl_receiver_tile_points(const sl_receiver_tile *t) {
    return (sl_light_points){t->padded,      t->x,           t->y,        t->z,        t->geometric_x,
                             t->geometric_y, t->geometric_z, t->normal_x, t->normal_y, t->normal_z};
}

/* ---- all tiles ---- */

void sl_receiver_tiles_strip(const sl_receivers *receivers, const sl_receiver_kinds *kinds, int y0,
                             sl_tile_program *program, void *context, sl_counters *counters) {
    const sl_receiver_kernels kernels = sl_receiver_kernels_for(sl_isa_best());
    sl_receiver_tile tile;
    for (int x = 0; x < receivers->width; x += SL_TILE_WIDTH) {
        for (int glossy = 0; glossy <= (kinds->glossy ? 1 : 0); glossy++) {
            fill_tile(receivers, kinds, &kernels, glossy, x, y0, &tile);
            if (tile.count == 0) continue;
            program(context, &tile, glossy, counters);
            sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, tile.count);
        }
    }
}
