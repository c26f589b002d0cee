/* The choice of pixels that are compared, and of points from which gathers are made. */
#include <math.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "common.h"

/* Through a place of the film, -1 to 1 across and upwards. */
static void set_ray(const sl_scene *scene, double x, double y, double aspect, sl_ray16 *ray) {
    const sl_camera *c = &scene->camera;
    double tangent = sl_tan(0.5 * (double)c->vertical_fov);
    sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, (float)(x * tangent * aspect)), (float)(y * tangent), c->up),
                       c->back);
    d = sl_normalize_or(d, sl_neg(c->back));
    *ray = (sl_ray16){.far = {0.0f}};
    sl_ray16_set(ray, 0, c->eye, d, 0.0f, INFINITY, SL_NO_INDEX);
}

/* Finds what the ray hits, if it is a surface that reflects and does not shine. */
static bool sees_surface(const sl_scene *scene, const sl_tracer *tracer, const sl_ray16 *ray,
                         sl_surface *surface, uint32_t *triangle) {
    sl_hit16 hits;
    sl_counters counters = {{0}};
    sl_trace(tracer, ray, 1, false, &hits, &counters);
    *triangle = hits.triangle[0];
    if (*triangle == SL_NO_INDEX) return false;
    sl_vec3 back = sl_neg(sl_v3(ray->direction_x[0], ray->direction_y[0], ray->direction_z[0]));
    sl_scene_surface(scene, *triangle, hits.w1[0], hits.w2[0], back, surface);
    const sl_material *m = surface->material;
    return !sl_material_is_emitter(m) && (sl_material_is_diffuse(m) || sl_material_is_glossy(m));
}

/* The rasterizer snaps vertices to 1/256 of a pixel: on an edge, or where surfaces coincide, it may see
 * another triangle than the ray, which is no error of the method. What it sees of the scene's camera: */
static sl_gbuffer *draw(const sl_scene *scene, int width, int height) {
    const sl_view view = sl_view_scene(scene, width, height);
    sl_raster *raster;
    sl_gbuffer *gbuffer = NULL;
    sl_counters counters = {{0}};
    sl_error error;
    bench_check(sl_raster_create(scene, 1, &raster, &error), &error);
    bench_check(sl_gbuffer_create(width, height, &gbuffer, &error), &error);
    bench_check(sl_raster_gbuffer(raster, &view, 1, gbuffer, &counters, &error), &error);
    sl_raster_destroy(raster);
    return gbuffer;
}

void bench_pixels_make(const sl_scene *scene, const sl_tracer *tracer, int width, int height, int block,
                       bench_pixels *pixels) {
    int across = width / block, down = height / block;
    uint64_t key = sl_random_key(5, 12);
    *pixels = (bench_pixels){.width = width, .height = height, .block = block};
    pixels->index = bench_allocate((size_t)across * (size_t)down, sizeof *pixels->index);
    sl_gbuffer *gbuffer = draw(scene, width, height);
    for (int i = 0; i < across * down; i++) {
        uint32_t bits = sl_random_bits(key, (uint64_t)i);
        int x = i % across * block + (int)(bits % (uint32_t)block);
        int y = i / across * block + (int)(bits / 65536u % (uint32_t)block);
        uint32_t pixel = (uint32_t)(y * width + x), triangle;
        sl_ray16 ray;
        sl_surface surface;
        set_ray(scene, (2.0 * x + 1.0) / width - 1.0, 1.0 - (2.0 * y + 1.0) / height,
                (double)width / height, &ray);
        if (sees_surface(scene, tracer, &ray, &surface, &triangle) &&
            gbuffer->id[(size_t)(height - 1 - y) * (size_t)width + (size_t)x] == triangle)
            pixels->index[pixels->count++] = pixel;
    }
    sl_gbuffer_destroy(gbuffer);
}

void bench_pixels_free(bench_pixels *pixels) {
    sl_free(pixels->index);
    pixels->index = NULL;
}

size_t bench_visible_points(const sl_scene *scene, const sl_tracer *tracer, size_t count,
                            sl_gather_point *points) {
    double aspect = (double)scene->film_width / (double)scene->film_height;
    uint64_t key = sl_random_key(1, 2);
    size_t found = 0;
    for (uint64_t i = 0; i < 20 * count && found < count; i++) {
        double x = 2.0 * (double)sl_random_unit(key, 2 * i) - 1.0,
               y = 2.0 * (double)sl_random_unit(key, 2 * i + 1) - 1.0;
        sl_ray16 ray;
        sl_surface s;
        uint32_t triangle;
        set_ray(scene, x, y, aspect, &ray);
        if (!sees_surface(scene, tracer, &ray, &s, &triangle)) continue;
        points[found++] = (sl_gather_point){.position = s.position,
                                            .geometric_normal = s.geometric_normal,
                                            .normal = s.normal,
                                            .triangle = triangle,
                                            .key = sl_hash64(i)};
    }
    return found;
}
