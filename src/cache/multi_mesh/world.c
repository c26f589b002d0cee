/* The world that a picture is made from, as long as lights and objects stay where they are: rays, corners,
 * lights and how they are sampled, irradiance meshes, the coarse mesh, the meshes that the eye sees. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <math.h>

#include "base/math.h"
#include "scene/ambient.h"

/* The finest of size criteria: leaves of direct light that are larger are probed for what lies between their
 * corners (probes.c). */
static const float FINE_AREA = 16.0f, FINE_EDGE = 8.0f;

enum { MINOR_PIXELS = 4, INDIRECT_MINOR_PIXELS = 32, MANY_LIGHTS = 16 };
/* Of the pixels that a leaf may have: fewer are minor. */
static const float MINOR = 1.0f / 9.0f;
/* Minor leaves are looked into where their pixels times contrast come to so much. Of indirect light most of
 * what is left out by it was cut for what gathers' pixels make: 96 instead of 48 takes three tenths of the
 * gathers away, for a tenth more squared error of indirect light. */
static const float MINOR_CONTRAST = 16.0f, INDIRECT_MINOR_CONTRAST = 96.0f;

/* ---- what a face shows: parts are judged as the eye sees them, beside all the others ---- */

static sl_rgb value_of(const sl_multi_mesh_state *s, sl_component part, uint32_t face, float w1, float w2) {
    float value[3];
    if (s->part[part] && sl_mesh_value(s->part[part]->mesh, face, w1, w2, value))
        return (sl_rgb){value[0], value[1], value[2]};
    return part == SL_INDIRECT && s->plan.indirect ? s->ambient : sl_grey(0.0f);
}

static sl_rgb shown_radiance(const void *context, sl_component part, uint32_t face, float w1, float w2,
                             sl_rgb value) {
    const sl_multi_mesh_state *s = context;
    const sl_material *material = sl_triangle_material(s->scene, face / 2);
    sl_rgb parts[SL_COMPONENTS];
    for (int i = 0; i < SL_COMPONENTS; i++)
        parts[i] = i == (int)part ? value : value_of(s, (sl_component)i, face, w1, w2);
    sl_rgb received =
        sl_rgb_add(parts[SL_DIRECT_DIFFUSE], sl_rgb_scale(parts[SL_INDIRECT], (float)(1.0 / SL_PI)));
    sl_rgb reflected = sl_rgb_add(sl_rgb_mul(material->diffuse, received),
                                  sl_rgb_mul(material->specular, parts[SL_DIRECT_SPECULAR]));
    return sl_rgb_add(reflected, sl_root_emission(material, face));
}

/* ---- what there is, and its end ---- */

void sl_mesh_world_forget(sl_mesh_world *w) {
    sl_light_sampling_destroy(w->sampling);
    sl_sampled_lights_destroy(w->lights);
    sl_object_places_destroy(w->places);
    sl_tracer_destroy(w->tracer);
    *w = (sl_mesh_world){NULL, NULL, NULL, NULL};
}

void sl_multi_mesh_forget_world(sl_multi_mesh_state *s) {
    for (int i = 0; i < SL_COMPONENTS; i++) {
        sl_displayed_destroy(s->part[i]);
        s->part[i] = NULL;
    }
    sl_multi_mesh_forget_coarse(&s->whole);
    sl_multi_mesh_forget_coarse(&s->next);
    sl_coarse_forget_kept(&s->kept);
    s->gathers_wait = s->hastens = false;
    sl_irradiance_meshes_destroy(s->irradiance);
    sl_mesh_world_forget(&s->now);
    sl_primitives_destroy(s->primitives);
    sl_raster_destroy(s->raster);
    s->irradiance = NULL;
    s->primitives = NULL;
    s->raster = NULL;
}

sl_status sl_multi_mesh_make_sampling(sl_multi_mesh_state *s, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    sl_light_sample_settings sampling = sl_light_sample_defaults();
    sampling.estimator = m->estimator;
    sampling.size = m->light_size;
    sampling.rays = m->light_rays;
    sampling.threads = s->settings.threads;
    sl_status status = sl_sampled_lights_find(s->scene, &s->now.lights, error);
    if (status == SL_OK)
        status = sl_light_sampling_create(s->scene, s->raster, s->now.tracer, s->now.lights, &sampling,
                                          &s->now.sampling, error);
    return status;
}

sl_irradiance_settings sl_multi_mesh_irradiance_settings(const sl_multi_mesh_state *s) {
    return (sl_irradiance_settings){.scene = s->scene,
                                    .primitives = s->primitives,
                                    .tracer = s->now.tracer,
                                    .lights = s->now.lights,
                                    .sampling = s->now.sampling,
                                    .perception = s->perception,
                                    .ambient = s->ambient,
                                    .few_rays = s->settings.multi_mesh.estimator == SL_LIGHT_RATIO &&
                                                s->now.lights->count >= MANY_LIGHTS,
                                    .max_depth = s->settings.multi_mesh.max_depth,
                                    .threads = s->settings.threads};
}

static sl_status make_lights(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = sl_multi_mesh_make_sampling(s, error);
    if (status != SL_OK) return status;
    s->light = sl_multi_mesh_irradiance_settings(s);
    return sl_irradiance_meshes_create(&s->light, &s->irradiance, error);
}

static uint32_t part_of(float area, float share, uint32_t least) {
    float pixels = fminf(share * area, 1e6f);
    return pixels > (float)least ? (uint32_t)pixels : least;
}

/* Pictures of fewer pixels a side than this are refined as if they had so many: all of a wall may show in one
 * of them, and what it shows there is not what its corners have. */
static float pixel_scale(const sl_settings *settings) {
    enum { SIDE = 24 };
    int side = settings->width < settings->height ? settings->width : settings->height;
    return side < SIDE ? (float)side / (float)SIDE : 1.0f;
}

static sl_status make_part(sl_multi_mesh_state *s, sl_component part, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    float coarser = part == SL_INDIRECT ? 2.0f : 1.0f; /* no shadow in it is as small as those of a lamp */
    float scale = pixel_scale(&s->settings), area = scale * scale * coarser * coarser * (float)m->leaf_area;
    bool small = scale < 1.0f;
    bool large = m->leaf_area > (double)FINE_AREA || m->leaf_edge > (double)FINE_EDGE;
    sl_displayed_settings settings = {
        .component = part,
        .leaf_area = area,
        .leaf_edge = scale * coarser * (float)m->leaf_edge,
        .below_pixels = small,
        .minor_pixels = small || part == SL_DIRECT_SPECULAR ? 0
                        : part == SL_INDIRECT               ? INDIRECT_MINOR_PIXELS
                                                            : part_of(area, MINOR, MINOR_PIXELS),
        .probed_area = large && part != SL_INDIRECT ? FINE_AREA : 0.0f,
        .probed_edge = FINE_EDGE,
        .sharp = part != SL_INDIRECT,
        .minor_contrast = (part == SL_INDIRECT ? INDIRECT_MINOR_CONTRAST : MINOR_CONTRAST) /
                          fmaxf(1.0f, (float)m->threshold_scale),
        .max_depth = m->max_depth,
        .selection = m->selection,
        .seed = s->settings.seed,
        .hanging = !m->keep_hanging,
        .perception = s->perception,
        .shown = {s, shown_radiance},
        .threads = s->settings.threads};
    return sl_displayed_create(s->primitives, &settings, &s->part[part], error);
}

static sl_status make_pictures(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    if (s->plan.indirect) status = sl_multi_mesh_begin_coarse(s, error);
    if (status == SL_OK && s->plan.direct_diffuse) status = make_part(s, SL_DIRECT_DIFFUSE, error);
    if (status == SL_OK && s->plan.direct_specular) status = make_part(s, SL_DIRECT_SPECULAR, error);
    if (status == SL_OK && s->plan.indirect) status = make_part(s, SL_INDIRECT, error);
    return status;
}

/* Displayed levels follow the light that is in the scene, never a picture's content. */
void sl_multi_mesh_set_perception(sl_multi_mesh_state *s) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    s->ambient = sl_ambient_irradiance(s->scene);
    s->ambient_in_motion =
        s->settings.bounces > 1 ? sl_ambient_irradiance_of_all_bounces(s->scene) : s->ambient;
    s->perception.threshold_scale = (float)m->threshold_scale;
    s->perception.exposure =
        m->exposure > 0.0 ? (float)m->exposure
                          : sl_perception_exposure(s->scene, sl_rgb_mean(s->ambient) * (float)(1.0 / SL_PI));
}

sl_status sl_multi_mesh_make_world(sl_multi_mesh_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_multi_mesh_set_perception(s);
    sl_status status = sl_raster_create(s->scene, threads, &s->raster, error);
    if (status == SL_OK && s->plan.lights)
        status = sl_tracer_create(s->scene, threads, NULL, &s->now.tracer, error);
    if (status == SL_OK) status = sl_primitives_of_triangles(s->scene, &s->primitives, error);
    if (status == SL_OK && s->plan.lights) status = make_lights(s, error);
    if (status == SL_OK) status = sl_object_places_take(s->scene, &s->now.places, error);
    s->scale = s->scene->scale;
    return status == SL_OK ? make_pictures(s, error) : status;
}
