/* Direct light of every pixel, diffuse and glossy lobes. */
#include "base/error.h"
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
    d->isa = sl_isa_best();
    d->offset = 1e-5f * scene->scale;
    sl_sequence_make(&d->sequence);
    for (size_t i = 0; i < scene->material_count; i++)
        d->glossy |= sl_material_is_glossy(&scene->materials[i]);
    sl_status status =
        settings->maps ? SL_OK : sl_light_sides_make(scene, SL_EXACT_EMITTERS_MAX, &d->sides, error);
    if (status == SL_OK && !settings->maps) status = make_sampler(d, error);
    if (status == SL_OK) *direct = d;
    else sl_direct_destroy(d);
    return status;
}

/* ---- in motion ---- */

/* Texels a side of a light's map, of samples of emitters a quarter. */
enum { QUICK_SIZE = 512, QUICK_SIZE_LEAST = 64, QUICK_TEXELS = 1 << 24 };

static int quick_size(const sl_scene *scene) {
    const double lights = (double)scene->light_count + 1.0;
    int size = QUICK_SIZE;
    while (size > QUICK_SIZE_LEAST && 6.0 * lights * size * size > QUICK_TEXELS) size /= 2;
    return size;
}

sl_status sl_direct_create_quick(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                                 const sl_direct_settings *settings, bool may_map, sl_direct **direct,
                                 sl_counters *counters, sl_error *error) {
    const sl_shadow_map_settings mapped = {
        .size = quick_size(scene), .sun = settings->sun, .threads = settings->threads};
    sl_direct_settings quick = *settings;
    sl_shadow_maps *maps = NULL;
    sl_status status = SL_OK;
    *direct = NULL;
    if (may_map && sl_emitter_sides(scene) <= SL_SHADOW_MAP_SIDES_MAX)
        status = sl_shadow_maps_create(scene, raster, &mapped, &maps, counters, error);
    quick.maps = maps;
    if (status == SL_OK) status = sl_direct_create(scene, tracer, &quick, direct, error);
    if (status == SL_OK) (*direct)->own_maps = maps, (*direct)->interleaves = true;
    else sl_shadow_maps_destroy(maps);
    return status;
}

void sl_direct_interleave(sl_direct *direct, bool interleaves) {
    if (direct) direct->interleaves = interleaves;
}

size_t sl_direct_map_bytes(const sl_direct *direct) {
    return direct && direct->own_maps ? sl_shadow_maps_bytes(direct->own_maps) : 0;
}

void sl_direct_destroy(sl_direct *direct) {
    if (!direct) return;
    sl_shadow_maps_destroy(direct->own_maps);
    sl_light_sampler_destroy(direct->sampler);
    sl_light_sides_release(&direct->sides);
    sl_free(direct);
}

/* ---- pixels ---- */

uint32_t sl_direct_samples(const sl_direct *direct) {
    const uint32_t all = direct->settings.light_samples, share = direct->scene->sub_frame.share;
    return share > 1 ? (all + share - 1) / share : all;
}

sl_bsdf sl_pixel_lobe(const sl_direct *direct, const sl_gbuffer *g, size_t i) {
    const sl_surface at = sl_gbuffer_surface(direct->scene, g, i);
    sl_vec3 viewer = sl_gbuffer_seen_from(g, direct->scene->camera.eye, i);
    return sl_bsdf_make(&at, sl_normalize_or(sl_sub(viewer, at.position), at.geometric_normal),
                        SL_LOBE_GLOSSY);
}

bool sl_pixel_is_glossy(const sl_gbuffer *g, const sl_scene *scene, size_t i) {
    return g->material[i] != SL_NO_INDEX && sl_material_is_glossy(&scene->materials[g->material[i]]);
}

bool sl_direct_is_mapped(const sl_direct *direct) { return direct->settings.maps; }

bool sl_pixel_reflects(const sl_gbuffer *g, const sl_scene *scene, size_t i) {
    if (g->material[i] == SL_NO_INDEX) return false;
    return g->diffuse_r[i] > 0.0f || g->diffuse_g[i] > 0.0f || g->diffuse_b[i] > 0.0f ||
           sl_pixel_is_glossy(g, scene, i);
}
