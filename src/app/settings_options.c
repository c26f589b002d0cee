#include "app/settings_options.h"

#include <string.h>

static const char *const quality_names[] = {"draft", "normal", "high", NULL};
static const char *const gather_names[] = {"auto", "raster", "hemicube", "trace", NULL}; /* as sl_gather_kind */
static const char *const direct_names[] = {"auto", "rays", "shadow-maps", NULL};         /* as sl_direct_kind */
static const char *const filter_names[] = {"method", "box", "centre", NULL};             /* as sl_pixel_filter */
static const char *const order_names[] = {"coarse-to-fine", "linear", NULL};             /* as sl_traversal_order */
static const char *const metric_names[] = {"auto", "harmonic", "minimum", "hessian", "adaptive", NULL};     /* as sl_radius_metric */
static const char *const weight_names[] = {"auto", "flux", "polygon", "plain", "11", "14", "15", NULL};    /* as sl_photon_weight */
static const char *const shape_names[] = {"auto", "frustum", "hemicube", "cube", NULL};                     /* as sl_map_shape */
static const char *const map_filter_names[] = {"auto", "point", "radiance", "flux", NULL};                  /* as sl_map_filter */
static const char *const mirror_names[] = {"full", "trick", "direct", NULL};                                /* as sl_mirror_light */
static const char *const visibility_names[] = {"none", "rays", "blocks", NULL};                             /* as sl_photon_visibility */
static const char *const store_names[] = {"indirect", "all", "caustic", NULL};                              /* as sl_photon_store */
static const char *const area_names[] = {"clip", "section", "disc", NULL};                                  /* as sl_photon_area */
static const char *const lobe_names[] = {"perpendicular", "surface", "none", "harmonics", NULL};            /* as sl_voxel_lobes */
static const char *const voxel_filter_names[] = {"trilinear", "nearest", NULL};                             /* as sl_voxel_filter */

static const char *const estimator_names[] = {"ratio", "window", "look-at", "rays", NULL};                   /* as sl_light_estimator */
static const char *const selection_names[] = {"heap", "chain", NULL};                                       /* as sl_mesh_selection */
static const char *const area_sampling_names[] = {"ratio", "sampled", NULL};                                /* as sl_area_sampling */
static const char *const indirect_names[] = {"bidirectional", "none", NULL};                                /* as sl_indirect_renderer */
static const char *const pixel_selection_names[] = {"hit-and-test", "systematic", "sorted", NULL};          /* as sl_pixel_selection */

static const double degree = 0.017453292519943295;

typedef struct table {
    sl_option *option;
    size_t count;
} table;

static void add(table *t, const sl_option *options, size_t count) {
    memcpy(t->option + t->count, options, count * sizeof *options);
    t->count += count;
}

#define ADD(table, options) add(table, options, sizeof(options) / sizeof(options)[0])
#define HEADING(text) {"", 0, SL_OPTION_HEADING, NULL, NULL, NULL, text, 0, 0, NULL}

static void add_common(sl_raw_settings *r, table *t) {
    sl_settings *s = &r->settings;
    const sl_option options[] = {
        HEADING("every method"),
        {"method", 'm', SL_OPTION_TEXT, &s->method, NULL, "NAME", "splatting, direct-radiance, light-octree, multi-mesh, shading-cache, path, bidirectional or auto [splatting; live: shading-cache]", 0, 0, NULL},
        {"size", 's', SL_OPTION_SIZE, r->size, NULL, "WxH", "pixels, 16384 a side at most, 32768 for path and bidirectional [as the scene says]", 0, 0, NULL},
        {"quality", 'q', SL_OPTION_CHOICE, &r->quality, &r->quality_given, "Q", "draft, normal or high [normal]", 0, 0, quality_names},
        {"seed", 0, SL_OPTION_COUNT, &s->seed, NULL, "N", "another number, other noise [0]", 0, 0, NULL},
        {"threads", 't', SL_OPTION_COUNT, &r->threads, NULL, "N", "workers; the bits do not depend on it [all processors]", 1, 256, NULL},
        {"memory", 0, SL_OPTION_BYTES, &s->memory_bytes, NULL, "SIZE", "512M, 2G: do less, or nothing, rather than take more [no limit]", 0x1p24, 0x1p50, NULL},
        {"spp", 0, SL_OPTION_COUNT, &r->spp, NULL, "N", "path, bidirectional: samples a pixel; splatting, light-octree: light samples a pixel [by quality]", 1, 1e8, NULL},
        HEADING("path, bidirectional"),
        {"transport", 0, SL_OPTION_TEXT, &s->transport, NULL, "PATHS", "direct, one-bounce, full or matched:METHOD [full]", 0, 0, NULL},
        {"filter", 0, SL_OPTION_CHOICE, &r->filter, NULL, "F", "box or centre of the pixel [method]", 0, 0, filter_names},
    };
    ADD(t, options);
}

static void add_splatting(sl_raw_settings *r, table *t) {
    sl_settings *s = &r->settings;
    const sl_option options[] = {
        HEADING("splatting"),
        {"accuracy", 'a', SL_OPTION_REAL, &s->accuracy, NULL, "A", "the records' a [by quality]", 1e-3, 2.0, NULL},
        {"gather", 0, SL_OPTION_CHOICE, &r->gather, NULL, "HOW", "auto, raster, hemicube or trace [auto]", 0, 0, gather_names},
        {"gather-size", 0, SL_OPTION_COUNT, &r->gather_size, NULL, "N", "N x N samples a gather, N even; also of multi-mesh [by quality]", 4, 1024, NULL},
        {"direct", 0, SL_OPTION_CHOICE, &r->direct, NULL, "HOW", "auto, rays or shadow-maps [auto]", 0, 0, direct_names},
        {"order", 0, SL_OPTION_CHOICE, &r->order, NULL, "ORDER", "pixels coarse-to-fine or linear [coarse-to-fine]", 0, 0, order_names},
        {"metric", 0, SL_OPTION_CHOICE, &r->metric, NULL, "METRIC",
         "what decides how far records reach: auto, harmonic, minimum, hessian or adaptive [auto]", 0, 0, metric_names},
        {"glossy-accuracy", 0, SL_OPTION_REAL, &s->glossy_accuracy, NULL, "A", "a of the radiance records [by quality]", 1e-3, 2.0, NULL},
        {"harmonics", 0, SL_OPTION_COUNT, &r->harmonics_order, NULL, "N", "order of the radiance records' harmonics [by the lobes]", 1, 12, NULL},
        {"bounces", 0, SL_OPTION_COUNT, &r->bounces, NULL, "N", "diffuse bounces; also of matched:splatting; multi-mesh: 1 or 2 [1]", 1, 64, NULL},
        {"glossy-hits", 0, SL_OPTION_FLAG, &s->glossy_hits, NULL, NULL, "gathers see glossy lobes too", 0, 0, NULL},
        {"hit-samples", 0, SL_OPTION_COUNT, &r->hit_samples, NULL, "N", "light samples for what a gather sees [by quality]", 1, 256, NULL},
        {"records-per-frame", 0, SL_OPTION_COUNT, &r->records_per_frame, NULL, "N",
         "a walk-through, at most N new records a frame [no limit]", 1, 1e9, NULL},
    };
    ADD(t, options);
}

static void add_direct_radiance(sl_raw_settings *r, table *t) {
    sl_radiance_map_settings *m = &r->settings.radiance_map;
    const sl_option options[] = {
        HEADING("direct-radiance"),
        {"photons", 'M', SL_OPTION_COUNT, &r->map_samples, NULL, "M", "M x M sample photons a face of the map [by quality]", 1, 256, NULL},
        {"map-size", 0, SL_OPTION_COUNT, &r->map_size, NULL, "N", "texels a side of a face [16]", 1, 1024, NULL},
        {"map", 0, SL_OPTION_CHOICE, &r->map_shape, NULL, "SHAPE", "frustum, hemicube, cube or auto, by the light [auto]", 0, 0, shape_names},
        {"map-fov", 0, SL_OPTION_REAL, &r->map_fov, NULL, "DEGREES", "of a frustum [the spot's own, or 90]", 1.0, 170.0, NULL},
        {"weight", 0, SL_OPTION_CHOICE, &r->weight, NULL, "W", "a photon's: flux, polygon, plain, 11, 14, 15 or auto [auto]", 0, 0, weight_names},
        {"map-filter", 0, SL_OPTION_CHOICE, &r->map_filter, NULL, "F", "point, radiance, flux or auto [auto]", 0, 0, map_filter_names},
        {"visibility", 0, SL_OPTION_CHOICE, &r->visibility, NULL, "HOW", "indirect shadows: none, rays or blocks [none]", 0, 0, visibility_names},
        {"mirror-light", 0, SL_OPTION_CHOICE, &r->mirror_light, NULL, "HOW", "indirect light in curved mirrors: full, trick or direct [full]", 0, 0,
         mirror_names},
        {"reflections", 0, SL_OPTION_COUNT, &r->reflections, NULL, "N", "planar mirrors one after another [1]", 1, 8, NULL},
        {"cube-size", 0, SL_OPTION_COUNT, &r->cube_size, NULL, "N", "texels a side of a curved mirror's cube [128]", 4, 4096, NULL},
        {"light-mirrors", 0, SL_OPTION_FLAG, &m->traced_light_mirrors, NULL, NULL, "light by way of curved mirrors, traced", 0, 0, NULL},
        {"shadow-size", 0, SL_OPTION_COUNT, &r->shadow_size, NULL, "N", "texels a side of a depth cube's face [512]", 16, 8192, NULL},
        {"emitter-samples", 0, SL_OPTION_COUNT, &r->emitter_samples, NULL, "N", "area lights from N x N points, each with a map [2; draft: 1]", 1, 64, NULL},
        {"8-bit-positions", 0, SL_OPTION_FLAG, &m->eight_bit_positions, NULL, NULL, "the map's positions as colours", 0, 0, NULL},
        {"local-light", 0, SL_OPTION_FLAG, &m->local_light_only, NULL, NULL, "no shadows and no indirect light", 0, 0, NULL},
        {"direct-light", 0, SL_OPTION_FLAG, &m->direct_light_only, NULL, NULL, "no indirect light", 0, 0, NULL},
        {"without-layers", 0, SL_OPTION_FLAG, &m->without_layers, NULL, NULL, "R, G and B alone", 0, 0, NULL},
    };
    ADD(t, options);
}

static void add_light_octree(sl_raw_settings *r, table *t) {
    sl_light_octree_settings *o = &r->settings.light_octree;
    const sl_option options[] = {
        HEADING("light-octree"),
        {"depth", 0, SL_OPTION_COUNT, &r->depth, NULL, "D", "of the octree [by quality]", 1, 8, NULL},
        {"stored-photons", 0, SL_OPTION_COUNT, &o->photons, NULL, "N", "photons to be stored [by quality]", 1, 1e9, NULL},
        {"neighbours", 'k', SL_OPTION_COUNT, &r->neighbours, NULL, "K", "nearest photons that a voxel takes, at most [by quality]", 2, 4096, NULL},
        {"radius", 0, SL_OPTION_REAL, &o->radius, NULL, "R", "how far it looks for them [by density]", 1e-12, 1e12, NULL},
        {"flatness", 0, SL_OPTION_REAL, &o->flatness, NULL, "F", "of the ellipsoid in which it looks [0.25]", 1e-3, 1.0, NULL},
        {"lights", 0, SL_OPTION_COUNT, &r->lights, NULL, "N", "virtual directional lights a voxel [4]", 1, 8, NULL},
        {"spread", 0, SL_OPTION_REAL, &r->spread_tolerance, NULL, "DEGREES", "fewer lights where they spread less than that [off]", 0.01, 90.0, NULL},
        {"acceptance", 0, SL_OPTION_REAL, &r->acceptance, NULL, "DEGREES", "between photons' and voxels' normals [60]", 1.0, 180.0, NULL},
        {"store", 0, SL_OPTION_CHOICE, &r->store, NULL, "WHICH", "photon hits: indirect, all or caustic [indirect]", 0, 0, store_names},
        {"photon-area", 0, SL_OPTION_CHOICE, &r->area, NULL, "HOW", "clip, section or disc [clip]", 0, 0, area_names},
        {"lobes", 0, SL_OPTION_CHOICE, &r->lobes, NULL, "WHAT", "perpendicular, surface, none or harmonics [perpendicular]", 0, 0, lobe_names},
        {"voxel-filter", 0, SL_OPTION_CHOICE, &r->voxel_filter, NULL, "F", "trilinear or nearest [trilinear]", 0, 0, voxel_filter_names},
        {"unit-weights", 0, SL_OPTION_FLAG, &o->unit_weights, NULL, NULL, "K-means with equal weights", 0, 0, NULL},
        {"median-of-subsets", 0, SL_OPTION_FLAG, &o->median_of_subsets, NULL, NULL, "against fireflies: fifths of the photons vote on irradiance", 0, 0, NULL},
        {"wide-directions", 0, SL_OPTION_FLAG, &o->wide_directions, NULL, NULL, "12 + 12 bits a direction, not 8 + 8", 0, 0, NULL},
        {"own-photons", 0, SL_OPTION_FLAG, &o->own_photons, NULL, NULL, "a voxel counts its own photons, and looks for no others", 0, 0, NULL},
        {"photons-at-pixels", 0, SL_OPTION_FLAG, &o->photons_at_pixels, NULL, NULL, "the photon map itself: every pixel gathers, there are no lights", 0, 0, NULL},
        {"whole-voxels", 0, SL_OPTION_FLAG, &o->whole_voxels, NULL, NULL, "one set of lights a voxel, not one for each group of normals", 0, 0, NULL},
        {"whole-area", 0, SL_OPTION_FLAG, &o->whole_area, NULL, NULL, "surface that no photon met counts as area too", 0, 0, NULL},
        {"fixed-neighbours", 0, SL_OPTION_FLAG, &o->fixed_neighbours, NULL, NULL, "exactly K photons a voxel, not K/4 to K by an error estimate", 0, 0, NULL},
        {"void-dark", 0, SL_OPTION_FLAG, &o->keep_void_dark, NULL, NULL, "empty voxels count as black", 0, 0, NULL},
        {"dilation", 0, SL_OPTION_REAL, &o->dilation, NULL, "H", "voxels also hold what is within H of their edge around them [0]", 0.0, 1.0, NULL},
        {"distance-weights", 0, SL_OPTION_FLAG, &o->distance_weights, NULL, NULL, "voxels count by distance alone, not by their normals' cosines too", 0, 0, NULL},
        {"geometric-normals", 0, SL_OPTION_FLAG, &o->geometric_normals, NULL, NULL, "surfaces take light by their geometric normals", 0, 0, NULL},
        {"environment-mirrors", 0, SL_OPTION_FLAG, &o->environment_mirrors, NULL, NULL, "mirrors show a cube map of the environment alone", 0, 0, NULL},
        {"atlas", 0, SL_OPTION_FLAG, &o->atlas, NULL, NULL, "light goes to a texture atlas first", 0, 0, NULL},
        {"atlas-size", 0, SL_OPTION_COUNT, &r->atlas_size, NULL, "N", "texels a side [1024]", 16, 16384, NULL},
        {"direct-sky", 0, SL_OPTION_FLAG, &o->direct_sky, NULL, NULL, "the whole environment by light samples, none of it in the octree", 0, 0, NULL},
        {"indirect-only", 0, SL_OPTION_FLAG, &o->indirect_only, NULL, NULL, "direct light is left out", 0, 0, NULL},
    };
    ADD(t, options);
}

static void add_multi_mesh(sl_raw_settings *r, table *t) {
    sl_multi_mesh_settings *m = &r->settings.multi_mesh;
    const sl_option options[] = {
        HEADING("multi-mesh"),
        {"light-estimator", 0, SL_OPTION_CHOICE, &r->estimator, NULL, "HOW", "of area lights: ratio, window, look-at or rays [ratio]", 0, 0, estimator_names},
        {"light-size", 0, SL_OPTION_COUNT, &r->light_size, NULL, "N", "N x N pixels around a light, N up to a power of two [64]", 16, 256, NULL},
        {"light-rays", 0, SL_OPTION_COUNT, &r->light_rays, NULL, "N", "N x N shadow rays to a light, by rays [16]", 1, 256, NULL},
        {"gather-fov", 0, SL_OPTION_REAL, &r->gather_fov, NULL, "DEGREES", "of an indirect gather [160]", 60.0, 178.0, NULL},
        {"threshold", 0, SL_OPTION_REAL, &m->threshold_scale, NULL, "X", "times what an eye can tell [by quality]", 1e-3, 1e3, NULL},
        {"exposure-of-thresholds", 0, SL_OPTION_REAL, &m->exposure, NULL, "E", "which radiance displays how bright [by the light in the scene]", 1e-30, 1e30, NULL},
        {"leaf-area", 0, SL_OPTION_REAL, &m->leaf_area, NULL, "PIXELS", "larger mesh triangles are always split [by quality]", 1.0, 1e9, NULL},
        {"leaf-edge", 0, SL_OPTION_REAL, &m->leaf_edge, NULL, "PIXELS", "likewise, by their longest edges [by quality]", 1.0, 1e9, NULL},
        {"mesh-depth", 0, SL_OPTION_COUNT, &r->max_depth, NULL, "D", "splits of a triangle, one in another [12]", 1, 12, NULL},
        {"coarse-depth", 0, SL_OPTION_COUNT, &r->coarse_depth, NULL, "D", "of the coarse mesh [by quality]", 1, 8, NULL},
        {"coarse-edge", 0, SL_OPTION_REAL, &m->coarse_edge, NULL, "LENGTH", "of the coarse mesh [by quality]", 1e-12, 1e12, NULL},
        {"selection", 0, SL_OPTION_CHOICE, &r->selection, NULL, "HOW", "what is refined next: heap or chain [heap]", 0, 0, selection_names},
        {"batch", 0, SL_OPTION_COUNT, &r->batch, NULL, "K", "mesh triangles that are tested together [32]", 1, 65536, NULL},
        {"joint-mesh", 0, SL_OPTION_FLAG, &m->joint_mesh, NULL, NULL, "light and radiance share one mesh", 0, 0, NULL},
        {"keep-hanging", 0, SL_OPTION_FLAG, &m->keep_hanging, NULL, NULL, "T-vertices stay visible", 0, 0, NULL},
    };
    ADD(t, options);
}

static void add_shading_cache(sl_raw_settings *r, table *t) {
    sl_shading_cache_settings *c = &r->settings.shading_cache;
    const sl_option options[] = {
        HEADING("shading-cache"),
        {"points", 0, SL_OPTION_COUNT, &r->points, NULL, "M", "shaded in an update [64]", 1, 1e6, NULL},
        {"area-samples", 0, SL_OPTION_COUNT, &r->area_samples, NULL, "N", "points on each area light [by quality]", 1, 1e6, NULL},
        {"area-sampling", 0, SL_OPTION_CHOICE, &r->area_sampling, NULL, "HOW", "ratio to the closed form, or sampled alone [ratio]", 0, 0, area_sampling_names},
        {"indirect-samples", 0, SL_OPTION_COUNT, &r->indirect_samples, NULL, "N", "paths from each point [by quality]", 1, 1e6, NULL},
        {"path-depth", 0, SL_OPTION_COUNT, &r->path_depth, NULL, "N", "surfaces on a path [6]", 1, 64, NULL},
        {"indirect", 0, SL_OPTION_CHOICE, &r->indirect, NULL, "WHO", "bidirectional or none [bidirectional]", 0, 0, indirect_names},
        {"caustics", 0, SL_OPTION_FLAG, &c->caustics, NULL, NULL, "by a photon map of their own", 0, 0, NULL},
        {"random-share", 0, SL_OPTION_REAL, &c->random_share, NULL, "E", "pixels chosen whatever their priority, 1e-4 to 1 [0.03]", 1e-4, 1.0, NULL},
        {"pixel-selection", 0, SL_OPTION_CHOICE, &r->pixel_selection, NULL, "HOW", "hit-and-test, systematic or sorted [hit-and-test]", 0, 0,
         pixel_selection_names},
        {"flood-threshold", 0, SL_OPTION_REAL, &c->flood_threshold, NULL, "P", "priority down to which floods run [0.5]", 1e-6, 1.0, NULL},
        {"no-flood", 0, SL_OPTION_FLAG, &c->no_flood, NULL, NULL, "no flood fill", 0, 0, NULL},
        {"no-random", 0, SL_OPTION_FLAG, &c->no_random, NULL, NULL, "no pixels at random", 0, 0, NULL},
        {"plain-normalisation", 0, SL_OPTION_FLAG, &c->plain_normalisation, NULL, NULL, "priorities by mean and 4 sigma, as printed", 0, 0, NULL},
        {"by-channel", 0, SL_OPTION_FLAG, &c->by_channel, NULL, NULL, "errors of red, green and blue count, not their luminance's alone", 0, 0, NULL},
        {"no-ageing", 0, SL_OPTION_FLAG, &c->no_ageing, NULL, NULL, "samples do not grow old", 0, 0, NULL},
        {"no-resolution-drop", 0, SL_OPTION_FLAG, &c->no_resolution_drop, NULL, NULL, "what changes keeps its fine patches", 0, 0, NULL},
        {"stop-size", 0, SL_OPTION_REAL, &c->stop_size, NULL, "PIXELS", "smaller patches are not split [1; of pictures below 24x24 less]", 1e-4, 1e6, NULL},
        {"ageing-window", 0, SL_OPTION_COUNT, &r->ageing_window, NULL, "N", "updates for which the unseen is kept [60]", 1, 1e6, NULL},
        {"cache-limit", 0, SL_OPTION_REAL, &c->cache_limit, NULL, "X", "patches a pixel [1.5]", 0.01, 100.0, NULL},
        {"clean-up", 0, SL_OPTION_REAL, &c->clean_up_seconds, NULL, "SECONDS", "in which what changes is to look right again [5]", 0.01, 1e6, NULL},
        {"nominal-rate", 0, SL_OPTION_REAL, &c->nominal_rate, NULL, "R", "samples a second that is reckoned with [2000]", 1.0, 1e9, NULL},
        {"change-threshold", 0, SL_OPTION_REAL, &c->change_threshold, NULL, "LEVELS", "of change that count [2]", 0.01, 255.0, NULL},
        {"change-window", 0, SL_OPTION_COUNT, &r->change_window, NULL, "N", "updates without change that end it [3]", 1, 1e6, NULL},
        {"blending", 0, SL_OPTION_REAL, &c->blending, NULL, "B", "share of new values [1]", 0.01, 1.0, NULL},
        {"variance-aware", 0, SL_OPTION_FLAG, &c->variance_aware, NULL, NULL, "more samples where noise passes for contrast", 0, 0, NULL},
        {"frames-per-update", 0, SL_OPTION_COUNT, &r->frames_per_update, NULL, "N", "of the schedule [20]", 1, 1e6, NULL},
        {"hold", 0, SL_OPTION_REAL, &c->hold_levels, NULL, "LEVELS", "motion waits until the mean error that shows is at most that [motion does not wait]", 1e-6,
         255.0, NULL},
        {"updates", 0, SL_OPTION_COUNT, &r->updates, NULL, "N", "after which a picture is done [by quality and size]", 1, 1e9, NULL},
        {"mean-level", 0, SL_OPTION_REAL, &c->mean_level_radiance, NULL, "L", "radiance of a middle grey [by the light in the scene]", 1e-30, 1e30, NULL},
    };
    ADD(t, options);
}

void sl_settings_options(sl_raw_settings *raw, sl_option *options) {
    table t = {options, 0};
    *raw = (sl_raw_settings){.settings = sl_settings_default(), .quality = SL_QUALITY_NORMAL};
    add_common(raw, &t);
    add_splatting(raw, &t);
    add_direct_radiance(raw, &t);
    add_light_octree(raw, &t);
    add_multi_mesh(raw, &t);
    add_shading_cache(raw, &t);
    options[t.count] = (sl_option){0};
}

static void take_direct_radiance(const sl_raw_settings *r, sl_radiance_map_settings *m) {
    m->samples = (int)r->map_samples;
    m->map_size = (int)r->map_size;
    m->shape = (sl_map_shape)r->map_shape;
    m->map_fov = r->map_fov * degree;
    m->weight = (sl_photon_weight)r->weight;
    m->filter = (sl_map_filter)r->map_filter;
    m->visibility = (sl_photon_visibility)r->visibility;
    m->mirror_light = (sl_mirror_light)r->mirror_light;
    m->reflections = (int)r->reflections;
    m->cube_size = (int)r->cube_size;
    m->shadow_size = (int)r->shadow_size;
    m->emitter_samples = (int)r->emitter_samples;
}

static void take_light_octree(const sl_raw_settings *r, sl_light_octree_settings *o) {
    o->depth = (int)r->depth;
    o->neighbours = (int)r->neighbours;
    o->lights = (int)r->lights;
    o->spread_tolerance = r->spread_tolerance * degree;
    o->acceptance = r->acceptance * degree;
    o->store = (sl_photon_store)r->store;
    o->area = (sl_photon_area)r->area;
    o->lobes = (sl_voxel_lobes)r->lobes;
    o->filter = (sl_voxel_filter)r->voxel_filter;
    o->atlas_size = (int)r->atlas_size;
}

static void take_multi_mesh(const sl_raw_settings *r, sl_multi_mesh_settings *m) {
    m->estimator = (sl_light_estimator)r->estimator;
    m->light_size = (int)r->light_size;
    m->light_rays = (int)r->light_rays;
    m->gather_fov = r->gather_fov * degree;
    m->max_depth = (int)r->max_depth;
    m->coarse_depth = (int)r->coarse_depth;
    m->selection = (sl_mesh_selection)r->selection;
    m->batch = (int)r->batch;
}

static void take_shading_cache(const sl_raw_settings *r, sl_shading_cache_settings *c) {
    c->points = (int)r->points;
    c->area_samples = (int)r->area_samples;
    c->area = (sl_area_sampling)r->area_sampling;
    c->indirect_samples = (int)r->indirect_samples;
    c->path_depth = (int)r->path_depth;
    c->indirect = (sl_indirect_renderer)r->indirect;
    c->selection = (sl_pixel_selection)r->pixel_selection;
    c->ageing_window = (int)r->ageing_window;
    c->change_window = (int)r->change_window;
    c->frames_per_update = (int)r->frames_per_update;
    c->updates = (uint32_t)r->updates;
}

sl_settings sl_settings_taken(const sl_raw_settings *r) {
    sl_settings s = r->settings;
    s.width = r->size[0];
    s.height = r->size[1];
    s.quality = (sl_quality)r->quality;
    s.gather = (sl_gather_kind)r->gather;
    s.direct = (sl_direct_kind)r->direct;
    s.filter = (sl_pixel_filter)r->filter;
    s.order = (sl_traversal_order)r->order;
    s.metric = (sl_radius_metric)r->metric;
    s.harmonics_order = (int)r->harmonics_order;
    s.bounces = (uint32_t)r->bounces;
    s.hit_samples = (uint32_t)r->hit_samples;
    s.records_per_frame = (uint32_t)r->records_per_frame;
    s.spp = (uint32_t)r->spp;
    s.gather_size = (int)r->gather_size;
    s.threads = (unsigned)r->threads;
    take_direct_radiance(r, &s.radiance_map);
    take_light_octree(r, &s.light_octree);
    take_multi_mesh(r, &s.multi_mesh);
    take_shading_cache(r, &s.shading_cache);
    return s;
}
