/* Direct light of every pixel, diffuse and glossy lobes. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/splatting/direct_internal.h"

enum { EXACT_EMITTERS_MAX = 16 }; /* beyond, the closed form costs more than the noise that it saves */

sl_status sl_direct_create(const sl_scene *scene, const sl_tracer *tracer, const sl_direct_settings *settings,
                           sl_direct **direct, sl_error *error) {
    *direct = NULL;
    sl_direct *d = sl_allocate(1, sizeof *d);
    if (!d) return sl_fail_memory(error, "direct light");
    d->scene = scene;
    d->tracer = tracer;
    d->settings = *settings;
    d->exact = !settings->maps && scene->emitter_count > 0 && scene->emitter_count <= EXACT_EMITTERS_MAX;
    d->emitters_alone = *scene;
    d->emitters_alone.light_count = 0;
    d->emitters_alone.environment.present = false;
    for (size_t i = 0; i < scene->emitter_count; i++) /* the closed form knows no masks */
        d->exact = d->exact && !sl_scene_has_alpha(scene, scene->emitters[i].triangle);
    sl_status status = sl_emitter_table_create(scene, &d->emitters, error);
    if (status == SL_OK && scene->emitter_count > SL_EMITTER_CHOICES_MAX)
        status = sl_light_sampler_create(&d->emitters_alone, &d->sampler, error);
    if (status != SL_OK) {
        sl_direct_destroy(d);
        return status;
    }
    *direct = d;
    return SL_OK;
}

void sl_direct_destroy(sl_direct *direct) {
    if (!direct) return;
    sl_light_sampler_destroy(direct->sampler);
    sl_emitter_table_destroy(&direct->emitters);
    sl_free(direct);
}

/* ---- pixels ---- */

sl_receiver sl_receiver_at(const sl_direct *direct, const sl_gbuffer *g, size_t i) {
    sl_receiver at = {
        .position = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
        .normal = sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i]),
        .geometric_normal = sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]),
        .triangle = g->id[i],
        .material = &direct->scene->materials[g->material[i]],
        .offset = 1e-5f * direct->scene->diagonal,
    };
    at.to_viewer = sl_normalize_or(sl_sub(direct->scene->camera.eye, at.position), at.geometric_normal);
    return at;
}

bool sl_pixel_is_glossy(const sl_gbuffer *g, const sl_scene *scene, size_t i) {
    return g->material[i] != SL_NO_INDEX && sl_material_is_glossy(&scene->materials[g->material[i]]);
}

bool sl_pixel_reflects(const sl_gbuffer *g, const sl_scene *scene, size_t i) {
    if (g->material[i] == SL_NO_INDEX) return false;
    return g->diffuse_r[i] > 0.0f || g->diffuse_g[i] > 0.0f || g->diffuse_b[i] > 0.0f || sl_pixel_is_glossy(g, scene, i);
}

sl_rgb sl_phong(const sl_receiver *at, sl_vec3 to_light) {
    if (!sl_material_is_glossy(at->material)) return sl_grey(0.0f);
    float n_v = sl_dot(at->normal, at->to_viewer);
    sl_vec3 mirrored = sl_sub(sl_scale(at->normal, 2.0f * n_v), at->to_viewer);
    float cos_alpha = sl_dot(mirrored, to_light);
    if (!(cos_alpha > 0.0f)) return sl_grey(0.0f);
    float n = at->material->exponent, lobe = sl_powf(cos_alpha < 1.0f ? cos_alpha : 1.0f, n);
    return sl_rgb_scale(at->material->specular, (n + 2.0f) * (float)(0.5 / SL_PI) * lobe);
}

sl_status sl_direct_rows(const sl_direct *direct, const sl_gbuffer *gbuffer, int row0, int row1, float *r, float *g, float *b,
                         sl_counters *counters, sl_error *error) {
    if (direct->settings.maps) return sl_direct_by_maps(direct, gbuffer, row0, row1, r, g, b, counters, error);
    return sl_direct_by_rays(direct, gbuffer, row0, row1, r, g, b, counters, error);
}
