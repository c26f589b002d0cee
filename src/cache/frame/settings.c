#include "cache/frame/settings.h"

#include "base/error.h"
#include "base/math.h"
#include "base/print.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- bounds ---- */

/* A whole number, or a choice, between bounds; 0 is a default where zero says so. */
typedef struct bound {
    const char *what;
    double value, minimum, maximum;
    bool zero;
} bound;

static sl_status check_bounds(const bound *bounds, size_t count, sl_error *error) {
    for (size_t i = 0; i < count; i++) {
        const bound *b = &bounds[i];
        if ((b->zero && b->value == 0.0) || (b->value >= b->minimum && b->value <= b->maximum)) continue;
        char text[32];
        return sl_fail(error, SL_ERROR_USAGE, "expected %s of %g to %g, got %s", b->what, b->minimum, b->maximum,
                       sl_outside_text(b->value, b->minimum, b->maximum, text));
    }
    return SL_OK;
}

#define CHECK(bounds, error) check_bounds(bounds, sizeof(bounds) / sizeof(bounds)[0], error)

/* Pixels a side: what is rasterized is snapped to 1/256 pixel, in 22 bits. */
static int largest_side(const sl_settings *s) {
    const bool by_rays_alone = strcmp(s->method, "path") == 0 || strcmp(s->method, "bidirectional") == 0;
    return by_rays_alone ? 32768 : 16384;
}

static sl_status check_common(const sl_settings *s, sl_error *error) {
    const int most = largest_side(s);
    if (s->width < 1 || s->height < 1 || s->width > most || s->height > most)
        return sl_fail(error, SL_ERROR_USAGE, "expected a size of 1 to %d pixels each way for %s, got %dx%d", most, s->method, s->width, s->height);
    const bound bounds[] = {
        {"a quality", s->quality, SL_QUALITY_DRAFT, SL_QUALITY_HIGH, false},
        {"samples a pixel", s->spp, 1, 1e8, true},
        {"a pixel filter", s->filter, SL_FILTER_METHOD, SL_FILTER_CENTRE, false},
    };
    return CHECK(bounds, error);
}

static sl_status check_splatting(const sl_settings *s, sl_error *error) {
    const bound bounds[] = {
        {"a gather", s->gather, SL_GATHER_AUTO, SL_GATHER_RAYS, false},
        {"a way to find direct light", s->direct, SL_DIRECT_AUTO, SL_DIRECT_SHADOW_MAPS, false},
        {"a traversal order", s->order, SL_ORDER_COARSE_TO_FINE, SL_ORDER_LINEAR, false},
        {"a metric", s->metric, SL_METRIC_AUTO, SL_METRIC_ADAPTIVE, false},
        {"an accuracy", s->accuracy, 1e-3, 2.0, true},
        {"a glossy accuracy", s->glossy_accuracy, 1e-3, 2.0, true},
        {"harmonics of an order", s->harmonics_order, 1, 12, true},
        {"bounces", s->bounces, 1, 64, true},
        {"samples a hit", s->hit_samples, 1, 256, true},
    };
    if (s->gather_size != 0 && (s->gather_size < 4 || s->gather_size > 1024 || s->gather_size % 2))
        return sl_fail(error, SL_ERROR_USAGE, "expected an even gather size of 4 to 1024, got %d", s->gather_size);
    return CHECK(bounds, error);
}

static sl_status check_radiance_map(const sl_radiance_map_settings *m, sl_error *error) {
    const bound bounds[] = {
        {"photons a side of a map's face", m->samples, 1, 256, true},
        {"a map", m->map_size, 1, 1024, true},
        {"a map's shape", m->shape, SL_MAP_AUTO, SL_MAP_CUBE, false},
        {"a map's field of view", m->map_fov, 0.01, 3.0, true},
        {"a photon's weight", m->weight, SL_WEIGHT_AUTO, SL_WEIGHT_BOX, false},
        {"a map filter", m->filter, SL_MAP_FILTER_AUTO, SL_MAP_FILTER_FLUX, false},
        {"a visibility", m->visibility, SL_VISIBILITY_NONE, SL_VISIBILITY_BLOCKS, false},
        {"a way to light mirrors", m->mirror_light, SL_MIRROR_LIGHT_FULL, SL_MIRROR_LIGHT_DIRECT, false},
        {"reflections", m->reflections, 1, 8, true},
        {"an environment cube", m->cube_size, 4, 4096, true},
        {"a depth cube", m->shadow_size, 16, 8192, true},
        {"samples a side of an emitter", m->emitter_samples, 1, 64, true},
    };
    return CHECK(bounds, error);
}

static sl_status check_light_octree(const sl_light_octree_settings *o, sl_error *error) {
    const bound bounds[] = {
        {"an octree's depth", o->depth, 1, 8, true},
        {"stored photons", (double)o->photons, 1, 1e9, true},
        {"neighbours", o->neighbours, 2, 4096, true},
        {"a radius", o->radius, 1e-12, 1e12, true},
        {"a flatness", o->flatness, 1e-3, 1.0, true},
        {"lights a voxel", o->lights, 1, 8, true},
        {"a spread", o->spread_tolerance, 1e-4, 1.6, true},
        {"an angle of acceptance", o->acceptance, 0.01, 3.15, true},
        {"photons to store", o->store, SL_STORE_INDIRECT, SL_STORE_CAUSTIC, false},
        {"a photon area", o->area, SL_PHOTON_AREA_CLIP, SL_PHOTON_AREA_DISC, false},
        {"lobes", o->lobes, SL_LOBES_PERPENDICULAR, SL_LOBES_HARMONICS, false},
        {"a voxel filter", o->filter, SL_VOXEL_TRILINEAR, SL_VOXEL_NEAREST, false},
        {"an atlas", o->atlas_size, 16, 16384, true},
        {"a dilation", o->dilation, 0.0, 1.0, false},
    };
    return CHECK(bounds, error);
}

static sl_status check_multi_mesh(const sl_multi_mesh_settings *m, sl_error *error) {
    const bound bounds[] = {
        {"a light estimator", m->estimator, SL_LIGHT_RATIO, SL_LIGHT_RAYS, false},
        {"pixels a side around a light", m->light_size, 16, 256, true},
        {"rays a side to a light", m->light_rays, 1, 256, true},
        {"a gather's field of view", m->gather_fov, 1.0, 3.11, true},
        {"a threshold scale", m->threshold_scale, 1e-3, 1e3, true},
        {"an exposure", m->exposure, 1e-30, 1e30, true},
        {"a leaf's area", m->leaf_area, 1, 1e9, true},
        {"a leaf's edge", m->leaf_edge, 1, 1e9, true},
        {"a mesh depth", m->max_depth, 1, 12, true},
        {"a coarse mesh's depth", m->coarse_depth, 1, 8, true},
        {"a coarse mesh's edge", m->coarse_edge, 1e-12, 1e12, true},
        {"a selection", m->selection, SL_SELECT_HEAP, SL_SELECT_CHAIN, false},
        {"a batch", m->batch, 1, 65536, true},
    };
    return CHECK(bounds, error);
}

static sl_status check_shading_cache(const sl_shading_cache_settings *c, sl_error *error) {
    const bound bounds[] = {
        {"points an update", c->points, 1, 1e6, true},
        {"samples of an area light", c->area_samples, 1, 1e6, true},
        {"a way to sample area lights", c->area, SL_AREA_RATIO, SL_AREA_SAMPLED, false},
        {"indirect samples", c->indirect_samples, 1, 1e6, true},
        {"a path depth", c->path_depth, 1, 64, true},
        {"an indirect renderer", c->indirect, SL_INDIRECT_BIDIRECTIONAL, SL_INDIRECT_NONE, false},
        {"a random share", c->random_share, 1e-4, 1.0, true},
        {"a pixel selection", c->selection, SL_PIXELS_HIT_AND_TEST, SL_PIXELS_SORTED, false},
        {"a flood threshold", c->flood_threshold, 1e-6, 1.0, true},
        {"a stop size", c->stop_size, 1e-4, 1e6, true},
        {"an ageing window", c->ageing_window, 1, 1e6, true},
        {"a cache limit", c->cache_limit, 0.01, 100.0, true},
        {"seconds to clean up", c->clean_up_seconds, 0.01, 1e6, true},
        {"a nominal rate", c->nominal_rate, 1.0, 1e9, true},
        {"a change threshold", c->change_threshold, 0.01, 255.0, true},
        {"a change window", c->change_window, 1, 1e6, true},
        {"blending", c->blending, 0.01, 1.0, true},
        {"frames an update", c->frames_per_update, 1, 1e6, true},
        {"a quality to hold for", c->hold_levels, 1e-6, 255.0, true},
        {"a middle radiance", c->mean_level_radiance, 1e-30, 1e30, true},
    };
    return CHECK(bounds, error);
}

sl_status sl_settings_check(const sl_settings *s, sl_error *error) {
    sl_status status = check_common(s, error);
    if (status == SL_OK) status = check_splatting(s, error);
    if (status == SL_OK) status = check_radiance_map(&s->radiance_map, error);
    if (status == SL_OK) status = check_light_octree(&s->light_octree, error);
    if (status == SL_OK) status = check_multi_mesh(&s->multi_mesh, error);
    if (status == SL_OK) status = check_shading_cache(&s->shading_cache, error);
    return status;
}

/* ---- metadata ---- */

typedef struct stamping {
    sl_image *image;
    sl_error *error;
    sl_status status;
} stamping;

static void stamp_text(stamping *st, const char *name, const char *value) {
    char key[SL_METADATA_KEY_MAX];
    snprintf(key, sizeof key, "softlux.%s", name);
    if (st->status == SL_OK) st->status = sl_image_set_metadata(st->image, key, value, st->error);
}

static void stamp_count(stamping *st, const char *name, uint64_t value) {
    char text[24];
    snprintf(text, sizeof text, "%" PRIu64, value);
    stamp_text(st, name, text);
}

/* As few digits as give the value again, so that what is stamped can be asked for. */
static void stamp_in_units(stamping *st, const char *name, double value, double unit) {
    enum { DIGITS_OF_A_DOUBLE = 17 };
    char text[32];
    void *before = sl_c_locale_begin();
    for (int digits = 9; digits <= DIGITS_OF_A_DOUBLE; digits++) {
        sl_print(text, sizeof text, "%.*g", digits, value / unit);
        if (strtod(text, NULL) * unit == value) break;
    }
    sl_c_locale_end(before);
    stamp_text(st, name, text);
}

static void stamp_real(stamping *st, const char *name, double value) { stamp_in_units(st, name, value, 1.0); }

/* In degrees, as options have it. */
static void stamp_angle(stamping *st, const char *name, double value) { stamp_in_units(st, name, value, SL_PI / 180.0); }

static void stamp_flag(stamping *st, const char *name, bool value) {
    if (value) stamp_text(st, name, "true");
}

static void stamp_splatting(stamping *st, const sl_settings *s) {
    static const char *const gathers[] = {"auto", "raster", "hemicube", "trace"};
    static const char *const directs[] = {"auto", "rays", "shadow-maps"};
    static const char *const orders[] = {"coarse-to-fine", "linear"};
    static const char *const metrics[] = {"auto", "harmonic", "minimum", "hessian", "adaptive"};
    stamp_real(st, "accuracy", s->accuracy);
    stamp_count(st, "gather_size", (uint64_t)s->gather_size);
    stamp_text(st, "gather", gathers[s->gather]);
    stamp_text(st, "direct", directs[s->direct]);
    stamp_text(st, "order", orders[s->order]);
    stamp_text(st, "metric", metrics[s->metric]);
    stamp_real(st, "glossy_accuracy", s->glossy_accuracy);
    stamp_count(st, "harmonics", (uint64_t)s->harmonics_order);
    stamp_count(st, "bounces", s->bounces);
    stamp_count(st, "hit_samples", s->hit_samples);
    stamp_count(st, "records_per_frame", s->records_per_frame);
    stamp_flag(st, "glossy_hits", s->glossy_hits);
}

static void stamp_radiance_map(stamping *st, const sl_radiance_map_settings *m) {
    static const char *const shapes[] = {"auto", "frustum", "hemicube", "cube"};
    static const char *const weights[] = {"auto", "flux", "polygon", "plain", "11", "14", "15"};
    static const char *const filters[] = {"auto", "point", "radiance", "flux"};
    static const char *const mirrors[] = {"full", "trick", "direct"};
    static const char *const visibilities[] = {"none", "rays", "blocks"};
    stamp_count(st, "photons", (uint64_t)m->samples);
    stamp_count(st, "map_size", (uint64_t)m->map_size);
    stamp_text(st, "map", shapes[m->shape]);
    stamp_angle(st, "map_fov", m->map_fov);
    stamp_text(st, "weight", weights[m->weight]);
    stamp_text(st, "map_filter", filters[m->filter]);
    stamp_text(st, "mirror_light", mirrors[m->mirror_light]);
    stamp_text(st, "visibility", visibilities[m->visibility]);
    stamp_count(st, "reflections", (uint64_t)m->reflections);
    stamp_count(st, "cube_size", (uint64_t)m->cube_size);
    stamp_count(st, "shadow_size", (uint64_t)m->shadow_size);
    stamp_count(st, "emitter_samples", (uint64_t)m->emitter_samples);
    stamp_flag(st, "light_mirrors", m->traced_light_mirrors);
    stamp_flag(st, "8_bit_positions", m->eight_bit_positions);
    stamp_flag(st, "local_light", m->local_light_only);
    stamp_flag(st, "direct_light", m->direct_light_only);
    stamp_flag(st, "without_layers", m->without_layers);
}

static void stamp_light_octree(stamping *st, const sl_light_octree_settings *o) {
    static const char *const stores[] = {"indirect", "all", "caustic"};
    static const char *const areas[] = {"clip", "section", "disc"};
    static const char *const lobes[] = {"perpendicular", "surface", "none", "harmonics"};
    static const char *const filters[] = {"trilinear", "nearest"};
    stamp_count(st, "depth", (uint64_t)o->depth);
    stamp_count(st, "stored_photons", o->photons);
    stamp_count(st, "neighbours", (uint64_t)o->neighbours);
    stamp_real(st, "radius", o->radius);
    stamp_real(st, "flatness", o->flatness);
    stamp_count(st, "lights", (uint64_t)o->lights);
    stamp_angle(st, "spread", o->spread_tolerance);
    stamp_angle(st, "acceptance", o->acceptance);
    stamp_text(st, "store", stores[o->store]);
    stamp_text(st, "photon_area", areas[o->area]);
    stamp_text(st, "lobes", lobes[o->lobes]);
    stamp_text(st, "voxel_filter", filters[o->filter]);
    stamp_flag(st, "unit_weights", o->unit_weights);
    stamp_flag(st, "median_of_subsets", o->median_of_subsets);
    stamp_flag(st, "wide_directions", o->wide_directions);
    stamp_flag(st, "own_photons", o->own_photons);
    stamp_flag(st, "photons_at_pixels", o->photons_at_pixels);
    stamp_flag(st, "whole_voxels", o->whole_voxels);
    stamp_flag(st, "whole_area", o->whole_area);
    stamp_flag(st, "fixed_neighbours", o->fixed_neighbours);
    stamp_flag(st, "void_dark", o->keep_void_dark);
    if (o->dilation > 0.0) stamp_real(st, "dilation", o->dilation);
    stamp_flag(st, "distance_weights", o->distance_weights);
    stamp_flag(st, "geometric_normals", o->geometric_normals);
    stamp_flag(st, "environment_mirrors", o->environment_mirrors);
    stamp_flag(st, "atlas", o->atlas);
    stamp_count(st, "atlas_size", (uint64_t)o->atlas_size);
    stamp_flag(st, "direct_sky", o->direct_sky);
    stamp_flag(st, "indirect_only", o->indirect_only);
}

static void stamp_multi_mesh(stamping *st, const sl_settings *s) {
    static const char *const estimators[] = {"ratio", "window", "look-at", "rays"};
    static const char *const selections[] = {"heap", "chain"};
    const sl_multi_mesh_settings *m = &s->multi_mesh;
    stamp_text(st, "light_estimator", estimators[m->estimator]);
    stamp_count(st, "light_size", (uint64_t)m->light_size);
    stamp_count(st, "light_rays", (uint64_t)m->light_rays);
    stamp_count(st, "gather_size", (uint64_t)s->gather_size);
    stamp_angle(st, "gather_fov", m->gather_fov);
    stamp_real(st, "threshold", m->threshold_scale);
    stamp_real(st, "exposure_of_thresholds", m->exposure);
    stamp_real(st, "leaf_area", m->leaf_area);
    stamp_real(st, "leaf_edge", m->leaf_edge);
    stamp_count(st, "mesh_depth", (uint64_t)m->max_depth);
    stamp_count(st, "coarse_depth", (uint64_t)m->coarse_depth);
    stamp_real(st, "coarse_edge", m->coarse_edge);
    stamp_text(st, "selection", selections[m->selection]);
    stamp_count(st, "batch", (uint64_t)m->batch);
    stamp_count(st, "bounces", s->bounces);
    stamp_flag(st, "joint_mesh", m->joint_mesh);
    stamp_flag(st, "keep_hanging", m->keep_hanging);
}

static void stamp_shading_cache(stamping *st, const sl_shading_cache_settings *c) {
    static const char *const areas[] = {"ratio", "sampled"};
    static const char *const renderers[] = {"bidirectional", "none"};
    static const char *const selections[] = {"hit-and-test", "systematic", "sorted"};
    stamp_count(st, "points", (uint64_t)c->points);
    stamp_count(st, "area_samples", (uint64_t)c->area_samples);
    stamp_text(st, "area_sampling", areas[c->area]);
    stamp_count(st, "indirect_samples", (uint64_t)c->indirect_samples);
    stamp_count(st, "path_depth", (uint64_t)c->path_depth);
    stamp_text(st, "indirect", renderers[c->indirect]);
    stamp_flag(st, "caustics", c->caustics);
    stamp_real(st, "random_share", c->random_share);
    stamp_text(st, "pixel_selection", selections[c->selection]);
    stamp_real(st, "flood_threshold", c->flood_threshold);
    stamp_flag(st, "no_flood", c->no_flood);
    stamp_flag(st, "no_random", c->no_random);
    stamp_flag(st, "plain_normalisation", c->plain_normalisation);
    stamp_flag(st, "no_ageing", c->no_ageing);
    stamp_flag(st, "by_channel", c->by_channel);
    stamp_flag(st, "no_resolution_drop", c->no_resolution_drop);
    stamp_real(st, "stop_size", c->stop_size);
    stamp_count(st, "ageing_window", (uint64_t)c->ageing_window);
    stamp_real(st, "cache_limit", c->cache_limit);
    stamp_real(st, "clean_up", c->clean_up_seconds);
    stamp_real(st, "nominal_rate", c->nominal_rate);
    stamp_real(st, "change_threshold", c->change_threshold);
    stamp_count(st, "change_window", (uint64_t)c->change_window);
    stamp_real(st, "blending", c->blending);
    stamp_flag(st, "variance_aware", c->variance_aware);
    stamp_count(st, "frames_per_update", (uint64_t)c->frames_per_update);
    stamp_real(st, "hold", c->hold_levels);
    stamp_count(st, "updates", c->updates);
    stamp_real(st, "mean_level", c->mean_level_radiance);
}

sl_status sl_settings_stamp(const sl_settings *s, sl_image *image, sl_error *error) {
    static const char *const qualities[] = {"draft", "normal", "high"};
    static const char *const filters[] = {"method", "box", "centre"};
    stamping st = {image, error, SL_OK};
    stamp_text(&st, "method", s->method);
    stamp_text(&st, "transport", s->transport);
    stamp_text(&st, "quality", qualities[s->quality]);
    stamp_text(&st, "filter", filters[s->filter]);
    stamp_count(&st, "seed", s->seed);
    stamp_count(&st, "spp", s->spp);
    if (strcmp(s->method, "splatting") == 0) stamp_splatting(&st, s);
    if (strcmp(s->method, "direct-radiance") == 0) stamp_radiance_map(&st, &s->radiance_map);
    if (strcmp(s->method, "light-octree") == 0) stamp_light_octree(&st, &s->light_octree);
    if (strcmp(s->method, "multi-mesh") == 0) stamp_multi_mesh(&st, s);
    if (strcmp(s->method, "shading-cache") == 0) stamp_shading_cache(&st, &s->shading_cache);
    return st.status;
}
