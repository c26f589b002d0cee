/* Direct light of every pixel, diffuse and glossy lobes. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light/direct_internal.h"

/* ---- creation ---- */

static sl_status make_sampler(sl_direct *d, sl_error *error) {
    d->extended = *d->scene;
    d->extended.light_count = 0;
    d->extended.environment = d->settings.sun ? *d->settings.sun : (sl_environment){0};
    if (d->scene->emitter_count == 0 && !d->settings.sun) return SL_OK;
    sl_status status = sl_light_sampler_create(&d->extended, &d->sampler, error);
    if (status != SL_OK || d->sides.count) return status;
    return sl_light_sampler_plant_tree(d->sampler, error);
}

sl_status sl_direct_create(const sl_scene *scene, const sl_tracer *tracer, const sl_direct_settings *settings,
                           sl_direct **direct, sl_error *error) {
    *direct = NULL;
    sl_direct *d = sl_allocate(1, sizeof *d);
    if (!d) return sl_fail_memory(error, "direct light");
    d->scene = scene;
    d->tracer = tracer;
    d->settings = *settings;
    d->light = sl_light_kernels_for(sl_isa_best());
    d->offset = 1e-5f * scene->scale;
    for (size_t i = 0; i < scene->material_count; i++)
        d->glossy |= sl_material_is_glossy(&scene->materials[i]);
    sl_status status =
        settings->maps ? SL_OK : sl_light_sides_make(scene, SL_EXACT_EMITTERS_MAX, &d->sides, error);
    if (status == SL_OK && !settings->maps) status = make_sampler(d, error);
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
    sl_light_sides_release(&direct->sides);
    sl_free(direct);
}

/* ---- pixels ---- */

uint32_t sl_direct_samples(const sl_direct *direct) {
    const uint32_t all = direct->settings.light_samples, share = direct->scene->sub_frame.share;
    return share > 1 ? (all + share - 1) / share : all;
}

sl_receiver sl_receiver_at(const sl_direct *direct, const sl_gbuffer *g, size_t i) {
    sl_receiver at = {
        .position = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
        .normal = sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i]),
        .geometric_normal = sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]),
        .triangle = g->id[i],
        .material = &direct->scene->materials[g->material[i]],
    };
    sl_vec3 viewer = g->seen_from ? g->seen_from[i] : direct->scene->camera.eye;
    at.to_viewer = sl_normalize_or(sl_sub(viewer, at.position), at.geometric_normal);
    return at;
}

bool sl_pixel_is_glossy(const sl_gbuffer *g, const sl_scene *scene, size_t i) {
    return g->material[i] != SL_NO_INDEX && sl_material_is_glossy(&scene->materials[g->material[i]]);
}

bool sl_pixel_reflects(const sl_gbuffer *g, const sl_scene *scene, size_t i) {
    if (g->material[i] == SL_NO_INDEX) return false;
    return g->diffuse_r[i] > 0.0f || g->diffuse_g[i] > 0.0f || g->diffuse_b[i] > 0.0f ||
           sl_pixel_is_glossy(g, scene, i);
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
