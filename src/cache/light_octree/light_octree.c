/* One picture, pass by pass (section 1.1), and again with each deeper octree.
 *
 *   G-buffer ── direct light ── photons ── tree ── octree ─┬─ lights of its voxels ── textures ── pixels ─┬─ done
 *   what mirrors show                                      └──────────── one level deeper ────────────────┘
 */
#include "cache/light_octree/light_octree.h"

#include "base/error.h"
#include "base/memory.h"
#include "cache/announce.h"
#include "cache/light_octree/story.h"
#include "cache/light_octree/photon_pixels.h"

#include <stdio.h>
#include <string.h>

enum {
    PLANES = 6,        /* direct, indirect */
    DIRECT_ROWS = 64,  /* an update's */
    PHOTON_CHUNKS = 16,
    LEAVES = 4096,
    HARMONICS_ORDER = 2
};

/* How far the sky in the octree may rise above its own mean. */
static const double sky_contrast = 10.0;

typedef enum octree_phase { PHASE_GBUFFER, PHASE_DIRECT, PHASE_PHOTONS, PHASE_OCTREE, PHASE_LIGHTS, PHASE_SHADE, PHASE_DONE } octree_phase;

/* A finished octree: what pixels are lit from. */
typedef struct octree_level {
    sl_octree *octree;          /* made anew for each depth: a cut of the deepest rounds in another order than that depth alone */
    sl_voxel_lights *lights;
    sl_voxel_texture *texture;
} octree_level;

typedef struct octree_state {
    const sl_scene *scene;
    sl_settings settings;
    sl_octree_plan plan;

    sl_raster *raster;
    sl_tracer *tracer;
    sl_environment sky, sun;    /* of the scene's environment: in the octree, and direct light of pixels */
    sl_direct *direct;
    sl_cube_map *cube;          /* what mirrors show where they show the environment alone */

    sl_photon_list *photons;    /* until the tree takes them */
    sl_photon_tree *tree;
    octree_level shown, next;
    sl_lit_atlas *atlas;        /* as long as the geometry stays; NULL where it is not asked for */

    sl_gbuffer *gbuffer;
    sl_reflections *reflections;
    float *planes;
    float *direct_light[3], *indirect_light[3];

    octree_phase phase;
    bool lit;                   /* the picture's indirect light is that of `shown` */
    int depth;                  /* of the octree under way */
    int direct_row;
    size_t leaf;
    double radius;
    sl_counters counters;
    sl_announcer announcer;
} octree_state;

static size_t pixels_of(const octree_state *s) { return (size_t)s->settings.width * (size_t)s->settings.height; }

static void announce_picture(octree_state *s, const char *name, const char *source, const float *planes) {
    sl_announce(&s->announcer, name, source, s->settings.width, s->settings.height, 3, planes, true);
}

/* ---- what there is, and its end ---- */

static void forget_level(octree_level *level) {
    sl_voxel_texture_destroy(level->texture);
    sl_voxel_lights_destroy(level->lights);
    sl_octree_destroy(level->octree);
    *level = (octree_level){NULL, NULL, NULL};
}

static void forget_light(octree_state *s) {
    forget_level(&s->next);
    forget_level(&s->shown);
    sl_photon_tree_destroy(s->tree);
    sl_photon_list_destroy(s->photons);
    sl_direct_destroy(s->direct);
    sl_environment_release(&s->sky);
    sl_environment_release(&s->sun);
    s->tree = NULL;
    s->photons = NULL;
    s->direct = NULL;
    sl_cube_map_destroy(s->cube);
    s->cube = NULL;
}

static void forget_geometry(octree_state *s) {
    sl_lit_atlas_destroy(s->atlas);
    s->atlas = NULL;
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    s->tracer = NULL;
    s->raster = NULL;
}

static void octree_destroy(void *state) {
    octree_state *s = state;
    if (!s) return;
    forget_light(s);
    forget_geometry(s);
    sl_reflections_destroy(s->reflections);
    sl_gbuffer_destroy(s->gbuffer);
    sl_free(s->planes);
    sl_free(s);
}

static sl_status make_geometry(octree_state *s, sl_error *error) {
    sl_status status = sl_raster_create(s->scene, s->settings.threads, &s->raster, error);
    bool rays = s->plan.photons || (s->plan.mirrors && !s->settings.light_octree.environment_mirrors);
    if (status == SL_OK && rays) status = sl_tracer_create(s->scene, s->settings.threads, NULL, &s->tracer, error);
    return status;
}

static sl_status make_light(octree_state *s, sl_error *error) {
    sl_status status = SL_OK;
    bool cube = !s->cube && s->plan.mirrors && s->settings.light_octree.environment_mirrors && s->scene->environment.present;
    if (cube) status = sl_environment_cube(&s->scene->environment, s->settings.threads, &s->cube, error);
    if (status != SL_OK || !s->plan.direct) return status;
    const sl_environment *sampled = s->plan.environment ? &s->scene->environment : NULL;
    if (s->plan.sky) {
        status = sl_environment_split(&s->scene->environment, sky_contrast, &s->sky, &s->sun, error);
        sampled = s->sun.present ? &s->sun : NULL;
    }
    if (status != SL_OK) return status;
    sl_direct_settings direct = {.light_samples = s->settings.spp, .seed = s->settings.seed, .threads = s->settings.threads, .sun = sampled};
    return sl_direct_create(s->scene, s->tracer, &direct, &s->direct, error);
}

static sl_status octree_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport, void **state,
                               sl_error *error) {
    (void)transport; /* its own: sl_octree_transport() */
    octree_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the light octree");
    s->scene = scene;
    s->settings = *settings;
    s->announcer = (sl_announcer){.observer = settings->observer, .method = "light-octree", .counters = &s->counters};
    s->plan = sl_octree_plan_make(scene, settings);
    s->planes = sl_allocate(PLANES * pixels_of(s), sizeof *s->planes);
    sl_status status = s->planes ? sl_gbuffer_create(settings->width, settings->height, &s->gbuffer, error) : sl_fail_memory(error, "the picture");
    if (status == SL_OK) status = make_geometry(s, error);
    if (status == SL_OK) status = make_light(s, error);
    if (status != SL_OK) {
        octree_destroy(s);
        return status;
    }
    for (size_t k = 0; k < 3; k++) {
        s->direct_light[k] = s->planes + k * pixels_of(s);
        s->indirect_light[k] = s->planes + (3 + k) * pixels_of(s);
    }
    *state = s;
    return SL_OK;
}

/* ---- the view ---- */

static sl_status draw_gbuffer(octree_state *s, sl_error *error) {
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_status status = sl_raster_gbuffer(s->raster, &view, s->settings.threads, s->gbuffer, &s->counters, error);
    sl_reflections_destroy(s->reflections);
    s->reflections = NULL;
    if (status == SL_OK && s->plan.mirrors && s->settings.light_octree.environment_mirrors)
        status = sl_reflect_environment(s->scene, s->cube, s->settings.threads, s->gbuffer, &s->reflections, &s->counters, error);
    else if (status == SL_OK && s->plan.mirrors)
        status = sl_reflect_pixels(s->scene, s->tracer, s->settings.threads, s->gbuffer, &s->reflections, &s->counters, error);
    if (status != SL_OK) return status;
    sl_announce_gbuffer(&s->announcer, "section 5", s->gbuffer);
    s->lit = false;
    memset(s->planes, 0, PLANES * pixels_of(s) * sizeof *s->planes);
    s->direct_row = 0;
    s->phase = s->plan.direct ? PHASE_DIRECT : PHASE_PHOTONS;
    return status;
}

static sl_status light_rows(octree_state *s, sl_error *error) {
    int end = s->direct_row + DIRECT_ROWS < s->settings.height ? s->direct_row + DIRECT_ROWS : s->settings.height;
    sl_status status = sl_direct_rows(s->direct, s->gbuffer, s->direct_row, end, s->direct_light[0], s->direct_light[1], s->direct_light[2],
                                      &s->counters, error);
    if (status != SL_OK) return status;
    s->direct_row = end;
    if (end < s->settings.height) return status;
    announce_picture(s, "direct light", "section 5", s->direct_light[0]);
    s->phase = PHASE_PHOTONS;
    return status;
}

/* ---- P1, P2: photons ---- */

static sl_status finish_photons(octree_state *s, sl_error *error) {
    sl_announce_pass(&s->announcer, "photons", "section 3.1");
    sl_photon_list *list = s->photons;
    if (list) sl_octree_announce_photons(&s->announcer, list);
    s->photons = NULL;
    if (!list || !list->count) {
        sl_photon_list_destroy(list);
        s->phase = PHASE_DONE;
        return SL_OK;
    }
    sl_status status = sl_photon_tree_create(list, s->settings.threads, &s->tree, error);
    if (status != SL_OK) return status; /* without photons again */
    s->phase = PHASE_OCTREE;
    s->depth = s->plan.first_depth;
    return SL_OK;
}

static sl_status trace_photons(octree_state *s, sl_error *error) {
    if (!s->plan.photons) {
        s->phase = PHASE_DONE;
        return SL_OK;
    }
    if (s->tree) { /* of an earlier view */
        s->phase = s->shown.octree ? PHASE_SHADE : PHASE_OCTREE;
        return SL_OK;
    }
    sl_photon_options options = {.stored = s->settings.light_octree.photons, .store = s->settings.light_octree.store,
                                 .sky = s->sky.present ? &s->sky : NULL, .seed = s->settings.seed, .threads = s->settings.threads};
    bool done = false;
    sl_status status = sl_photons_trace(s->scene, s->tracer, &options, PHOTON_CHUNKS, &s->photons, &done, &s->counters, error);
    return status == SL_OK && done ? finish_photons(s, error) : status;
}

/* ---- G1: the octree, from the shallowest that is shown ---- */

sl_voxel_light_options sl_octree_light_options(const sl_light_octree_settings *o, double radius) {
    return (sl_voxel_light_options){.neighbours = (size_t)o->neighbours,
                                    .radius = radius,
                                    .flatness = o->flatness,
                                    .acceptance = o->acceptance,
                                    .area = o->area,
                                    .lobes = o->lobes,
                                    .lights = o->lights,
                                    .harmonics_order = HARMONICS_ORDER,
                                    .spread_tolerance = o->spread_tolerance,
                                    .unit_weights = o->unit_weights,
                                    .wide_directions = o->wide_directions,
                                    .median_of_subsets = o->median_of_subsets,
                                    .own_photons = o->own_photons,
                                    .split_by_normal = !o->whole_voxels && !o->own_photons,
                                    .estimated_radius = !o->fixed_neighbours};
}

static sl_status start_level(octree_state *s, sl_error *error) {
    const sl_light_octree_settings *o = &s->settings.light_octree;
    unsigned threads = s->settings.threads;
    sl_status status = sl_octree_create(s->scene, s->depth, 0.0, threads, &s->next.octree, error);
    if (status != SL_OK) return status;
    sl_announce_pass(&s->announcer, "octree", "section 3.2");
    s->leaf = 0;
    s->radius = o->radius > 0.0 ? o->radius : sl_voxel_radius(s->next.octree, (size_t)o->neighbours, sl_photon_tree_list(s->tree)->count);
    if (o->photons_at_pixels) { /* no lights in between */
        forget_level(&s->shown);
        s->shown = s->next;
        s->next = (octree_level){NULL, NULL, NULL};
        s->phase = PHASE_SHADE;
        return status;
    }
    sl_voxel_light_options options = sl_octree_light_options(o, s->radius);
    status = sl_voxel_lights_create(s->scene, s->next.octree, s->next.octree, s->tree, &options, threads, &s->next.lights, error);
    if (status == SL_OK) s->phase = PHASE_LIGHTS;
    else forget_level(&s->next);
    return status;
}

/* ---- P3 to P5: lights of the voxels, and their textures ---- */

static sl_status finish_level(octree_state *s, sl_error *error) {
    const octree_level *n = &s->next;
    bool dense = n->octree->depth <= 7; /* an index of 8 MiB at most */
    sl_status status = sl_voxel_texture_create(n->octree, n->lights, dense, &s->next.texture, error);
    if (status != SL_OK) return status;
    forget_level(&s->shown);
    s->shown = s->next;
    s->next = (octree_level){NULL, NULL, NULL};
    sl_octree_announce_lights(&s->announcer, s->shown.octree, s->shown.lights);
    s->lit = false;
    if (s->atlas) s->atlas->filled[SL_ATLAS_FRONT] = s->atlas->filled[SL_ATLAS_BACK] = false;
    s->phase = PHASE_SHADE;
    return status;
}

static sl_status light_leaves(octree_state *s, sl_error *error) {
    size_t left = s->next.octree->leaf_count - s->leaf, count = left < LEAVES ? left : LEAVES;
    sl_voxel_lights_compute(s->next.lights, s->leaf, count, s->settings.threads, &s->counters);
    s->leaf += count;
    return s->leaf == s->next.octree->leaf_count ? finish_level(s, error) : SL_OK;
}

/* ---- R1: pixels ---- */

static sl_status gather_at_pixels(octree_state *s, sl_error *error) {
    sl_photon_pixels pixels = {.scene = s->scene,
                               .gbuffer = s->gbuffer,
                               .octree = s->shown.octree,
                               .tree = s->tree,
                               .settings = &s->settings.light_octree,
                               .radius = s->radius,
                               .threads = s->settings.threads};
    return sl_photon_light_pixels(&pixels, s->indirect_light, &s->counters, error);
}

/* G2 to G4 once; its light is that of the octree that is shown. */
static sl_status ready_atlas(octree_state *s, sl_error *error) {
    if (!s->settings.light_octree.atlas || s->atlas) return SL_OK;
    sl_status status = sl_lit_atlas_create(s->scene, s->settings.light_octree.atlas_size, s->settings.threads, &s->atlas, error);
    sl_announce_pass(&s->announcer, "atlas", "section 4.2");
    return status;
}

static sl_octree_shading shading_of(const octree_state *s) {
    const sl_light_octree_settings *o = &s->settings.light_octree;
    return (sl_octree_shading){.texture = s->shown.texture, .filter = o->filter, .keep_void_dark = o->keep_void_dark, .facing = o->facing_voxels};
}

static sl_status light_pixels(octree_state *s, sl_error *error) {
    sl_octree_shading shading = shading_of(s);
    sl_octree_pixels pixels = {.scene = s->scene,
                               .gbuffer = s->gbuffer,
                               .reflections = s->reflections,
                               .shading = &shading,
                               .atlas = s->atlas,
                               .eye = s->scene->camera.eye,
                               .threads = s->settings.threads};
    return sl_octree_light_pixels(&pixels, s->indirect_light, &s->counters, error);
}

static sl_status shade(octree_state *s, sl_error *error) {
    char name[48];
    int depth = s->shown.octree->depth;
    bool gathered = s->settings.light_octree.photons_at_pixels;
    sl_status status = gathered ? gather_at_pixels(s, error) : ready_atlas(s, error);
    if (status == SL_OK && !gathered) status = light_pixels(s, error);
    if (status != SL_OK) return status;
    s->lit = true;
    if (gathered) snprintf(name, sizeof name, "indirect light, photons at pixels");
    else snprintf(name, sizeof name, "indirect light, depth %d", depth);
    announce_picture(s, name, "section 4", s->indirect_light[0]);
    s->depth = depth + 1;
    s->phase = s->depth <= s->settings.light_octree.depth ? PHASE_OCTREE : PHASE_DONE;
    return status;
}

/* ---- the method ---- */

/* A level has about four times the leaves of the one before. */
static double levels_done(const octree_state *s, double share) {
    double all = 1.0;
    for (int d = s->depth; d < s->settings.light_octree.depth; d++) all *= 0.25;
    return all * (0.25 + 0.75 * share);
}

/* Shares of the whole that the phases take, roughly, for the progress bar alone. */
static double fraction_done(const octree_state *s) {
    double stored = s->photons ? (double)s->photons->count / (double)s->settings.light_octree.photons : 0.0;
    switch (s->phase) {
    case PHASE_GBUFFER: return 0.0;
    case PHASE_DIRECT: return 0.3 * (double)s->direct_row / (double)s->settings.height;
    case PHASE_PHOTONS: return 0.3 + 0.2 * (stored < 1.0 ? stored : 1.0);
    case PHASE_OCTREE: return 0.5 + 0.5 * levels_done(s, 0.0);
    case PHASE_LIGHTS: return 0.5 + 0.5 * levels_done(s, (double)s->leaf / (double)s->next.octree->leaf_count);
    case PHASE_SHADE: return 0.5 + 0.5 * levels_done(s, 1.0);
    case PHASE_DONE: return 1.0;
    }
    return 1.0;
}

static sl_status octree_update(void *state, sl_progress *progress, sl_error *error) {
    octree_state *s = state;
    if (!s->raster) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = SL_OK;
    switch (s->phase) {
    case PHASE_GBUFFER: status = draw_gbuffer(s, error); break;
    case PHASE_DIRECT: status = light_rows(s, error); break;
    case PHASE_PHOTONS: status = trace_photons(s, error); break;
    case PHASE_OCTREE: status = start_level(s, error); break;
    case PHASE_LIGHTS: status = light_leaves(s, error); break;
    case PHASE_SHADE: status = shade(s, error); break;
    case PHASE_DONE: break;
    }
    progress->fraction = fraction_done(s);
    progress->frame_done = progress->done = s->phase == PHASE_DONE;
    return status;
}

static sl_status write_number(sl_image *image, const char *name, double value, sl_error *error) {
    char key[SL_METADATA_KEY_MAX], text[32];
    snprintf(key, sizeof key, "softlux.octree.%s", name);
    snprintf(text, sizeof text, "%.9g", value);
    return sl_image_set_metadata(image, key, text, error);
}

/* What the picture was made from. */
static sl_status write_statistics(const octree_state *s, sl_image *image, sl_error *error) {
    if (!s->shown.lights) return SL_OK;
    sl_voxel_statistics v;
    sl_voxel_lights_statistics(s->shown.lights, s->shown.octree, &v);
    const struct {
        const char *name;
        double value;
    } numbers[] = {{"depth", s->shown.octree->depth},
                   {"leaves", (double)s->shown.octree->leaf_count},
                   {"photons_emitted", (double)sl_photon_tree_list(s->tree)->emitted},
                   {"photons_a_voxel", v.mean_photons},
                   {"radius", v.mean_radius},
                   {"radius_in_voxels", v.mean_radius / sl_octree_voxel(s->shown.octree)},
                   {"spread_deg", v.rms_angle * 57.29577951308232},
                   {"flux", v.flux},
                   {"power_ratio", v.max_power_ratio},
                   {"texture_bytes", (double)sl_voxel_texture_bytes(s->shown.texture)}};
    sl_status status = SL_OK;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0] && status == SL_OK; i++)
        status = write_number(image, numbers[i].name, numbers[i].value, error);
    return status;
}

static sl_status octree_resolve(void *state, sl_image **image, sl_error *error) {
    octree_state *s = state;
    sl_octree_composition parts = {.scene = s->scene,
                                   .gbuffer = s->gbuffer,
                                   .reflections = s->reflections,
                                   .direct = {s->direct_light[0], s->direct_light[1], s->direct_light[2]},
                                   .indirect = {s->indirect_light[0], s->indirect_light[1], s->indirect_light[2]},
                                   .drawn = s->phase != PHASE_GBUFFER,
                                   .threads = s->settings.threads};
    sl_status status = sl_octree_compose(&parts, image, error);
    if (status == SL_OK) status = write_statistics(s, *image, error);
    if (status != SL_OK) {
        sl_image_destroy(*image);
        *image = NULL;
    }
    return status;
}

/* Photons and voxels do not know the camera. */
static sl_status octree_edit(void *state, unsigned changes, sl_error *error) {
    octree_state *s = state;
    sl_status status = SL_OK;
    s->phase = PHASE_GBUFFER;
    forget_level(&s->next);
    bool geometry = (changes & SL_CHANGED_OBJECTS) || !s->raster; /* an earlier edit may have failed */
    if (geometry || (changes & SL_CHANGED_LIGHTS)) forget_light(s);
    if (geometry) {
        forget_geometry(s);
        status = make_geometry(s, error);
    }
    if (status == SL_OK && !s->direct) status = make_light(s, error);
    if (status != SL_OK) { /* all or nothing: the next edit starts anew */
        forget_light(s);
        forget_geometry(s);
    }
    return status;
}

static sl_status octree_story(void *state, int x, int y, sl_story_writer *writer, sl_error *error) {
    (void)error;
    const octree_state *s = state;
    const sl_light_octree_settings *o = &s->settings.light_octree;
    bool voxels = s->lit && !o->photons_at_pixels;
    sl_octree_told told = {.scene = s->scene, .gbuffer = s->gbuffer, .reflections = s->reflections, .drawn = s->phase != PHASE_GBUFFER,
                           .shading = shading_of(s), .atlas = s->atlas != NULL,
                           .otherwise = o->photons_at_pixels ? "the photons nearest to the pixel" : "lights of voxels that made way for smaller ones"};
    if (!voxels) told.shading.texture = NULL;
    sl_octree_tell(&told, (size_t)y * (size_t)s->settings.width + (size_t)x, writer);
    return SL_OK;
}

static const sl_counters *octree_counters(const void *state) { return &((const octree_state *)state)->counters; }

static size_t level_bytes(const octree_level *level) {
    size_t bytes = level->octree ? sl_octree_bytes(level->octree) : 0;
    if (level->lights) bytes += sl_voxel_lights_bytes(level->lights);
    return bytes + (level->texture ? sl_voxel_texture_bytes(level->texture) : 0);
}

static size_t octree_memory_bytes(const void *state) {
    const octree_state *s = state;
    size_t bytes = sizeof *s + pixels_of(s) * (PLANES * sizeof(float) + 14 * sizeof(float) + 2 * sizeof(uint32_t));
    bytes += level_bytes(&s->shown) + level_bytes(&s->next);
    if (s->photons) bytes += s->photons->count * sizeof(sl_photon);
    if (s->tree) bytes += sl_photon_tree_bytes(s->tree);
    if (s->atlas) bytes += sl_lit_atlas_bytes(s->atlas);
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    return bytes;
}

const sl_method_class sl_light_octree_method = {
    .name = "light-octree",
    .complete = sl_octree_complete,
    .create = octree_create,
    .destroy = octree_destroy,
    .update = octree_update,
    .resolve = octree_resolve,
    .edit = octree_edit,
    .counters = octree_counters,
    .memory_bytes = octree_memory_bytes,
    .need = sl_octree_need,
    .concessions = sl_octree_concessions,
    .transport = sl_octree_transport,
    .plan = sl_octree_plan_write,
    .story = octree_story,
    .any_transport = false,
};
