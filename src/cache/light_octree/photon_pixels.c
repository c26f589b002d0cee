#include "cache/light_octree/photon_pixels.h"

#include "base/counters.h"
#include "base/parallel.h"
#include "cache/light_octree/voxel_work.h"
#include "trace/bsdf.h"

static void add(double sum[3], sl_rgb reflected, const sl_lobe_photons *p, size_t i) {
    const float f[3] = {reflected.r, reflected.g, reflected.b};
    for (int c = 0; c < 3; c++) sum[c] += (double)f[c] * (double)p->flux[c][i] * p->inverse_cosine[i];
}

sl_rgb sl_photons_radiance(sl_voxel_lights *lights, unsigned worker, const sl_surface *surface,
                           sl_vec3 to_viewer) {
    const sl_voxel_work *work = lights->work;
    const sl_voxel_light_options *o = &lights->options;
    sl_voxel_worker *w = &work->worker[worker];
    if (!work->tree || sl_material_is_mirror(surface->material)) return sl_grey(0.0f);
    sl_photon_query query = sl_voxel_query(work, o, surface->position, surface->geometric_normal, o->radius);
    query.both_sides = false;
    sl_voxel_gather gather = sl_voxel_gather_photons(work, &query, w);
    sl_bsdf bsdf = sl_bsdf_make(surface, to_viewer, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY);
    const sl_lobe_photons *p = &gather.front;
    double sum[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < p->count; i++) {
        sl_vec3 to_light = sl_v3(p->x[i], p->y[i], p->z[i]);
        add(sum, sl_bsdf_reflect(&bsdf, to_light, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY), p, i);
    }
    double area = sl_voxel_areas(work, o, &gather, w).side[0], scale = area > 0.0 ? gather.kappa / area : 0.0;
    sl_count(&w->counters, SL_COUNT_PHOTONS_GATHERED, gather.found);
    sl_rgb radiance = {(float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale)};
    return sl_rgb_is_finite(radiance) ? radiance : sl_grey(0.0f);
}

/* ---- pixels ---- */

typedef struct pixel_pass {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    sl_voxel_lights *lights;
    float *const *out;
} pixel_pass;

static sl_rgb light_of_pixel(const pixel_pass *pass, unsigned worker, size_t i) {
    const sl_gbuffer *g = pass->gbuffer;
    if (g->material[i] == SL_NO_INDEX) return sl_grey(0.0f);
    sl_vec3 viewer = g->seen_from ? g->seen_from[i] : pass->scene->camera.eye;
    sl_surface s = {.position = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
                    .geometric_normal = sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]),
                    .normal = sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i]),
                    .diffuse = {g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]},
                    .material = &pass->scene->materials[g->material[i]],
                    .front = true};
    return sl_photons_radiance(pass->lights, worker, &s,
                               sl_normalize_or(sl_sub(viewer, s.position), s.geometric_normal));
}

static void light_row(void *context, size_t row, unsigned worker) {
    const pixel_pass *pass = context;
    size_t width = (size_t)pass->gbuffer->width;
    for (size_t i = row * width; i < (row + 1) * width; i++) {
        sl_rgb radiance = light_of_pixel(pass, worker, i);
        pass->out[0][i] = radiance.r;
        pass->out[1][i] = radiance.g;
        pass->out[2][i] = radiance.b;
    }
}

void sl_photons_light_pixels(const sl_scene *scene, const sl_gbuffer *gbuffer, sl_voxel_lights *lights,
                             unsigned threads, float *const indirect[3], sl_counters *counters) {
    pixel_pass pass = {scene, gbuffer, lights, indirect};
    threads = sl_thread_count(threads);
    if (threads > lights->work->workers) threads = lights->work->workers;
    sl_parallel_for(threads, (size_t)gbuffer->height, light_row, &pass);
    sl_voxel_lights_count(lights, counters);
}
