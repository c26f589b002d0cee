/* The settings of a method, field by field, and the table of options that sets, checks and tells them. */
#pragma once

#include "base/choices.h"
#include "cache/frame/options.h"
#include "softlux.h"

#define SL_SETTINGS_FIELD(type, field, ...) type field;

typedef struct sl_radiance_map_settings {
    SL_OPTIONS_OF_RADIANCE_MAP(SL_SETTINGS_FIELD)
} sl_radiance_map_settings;

typedef struct sl_light_octree_settings {
    SL_OPTIONS_OF_LIGHT_OCTREE(SL_SETTINGS_FIELD)
} sl_light_octree_settings;

typedef struct sl_multi_mesh_settings {
    SL_OPTIONS_OF_MULTI_MESH(SL_SETTINGS_FIELD)
} sl_multi_mesh_settings;

typedef struct sl_shading_cache_settings {
    SL_OPTIONS_OF_SHADING_CACHE(SL_SETTINGS_FIELD)
} sl_shading_cache_settings;

struct sl_settings {
    SL_OPTIONS_OF_COMMON(SL_SETTINGS_FIELD)
    SL_OPTIONS_OF_GATHERING(SL_SETTINGS_FIELD)
    SL_OPTIONS_OF_SPLATTING(SL_SETTINGS_FIELD)
    int height; /* of "size" */
    sl_radiance_map_settings radiance_map;
    sl_light_octree_settings light_octree;
    sl_multi_mesh_settings multi_mesh;
    sl_shading_cache_settings shading_cache;
    const sl_observer *observer; /* or NULL */
};

#undef SL_SETTINGS_FIELD

/* Splatting at normal quality, everything else by quality, scene and machine; pixels are means, and light may
 * bounce as often as it matters. */
sl_settings sl_settings_default(void);
/* The same, but for pictures as the papers have them: what pixels' centres show, of one bounce. */
sl_settings sl_settings_of_papers(void);
/* SL_ERROR_USAGE with what was expected. 0 is allowed wherever it stands for a default; width and height are
 * not 0 any more. */
sl_status sl_settings_check(const sl_settings *settings, sl_error *error);
/* Of a picture whose size is chosen. */
static inline size_t sl_settings_pixels(const sl_settings *settings) {
    return (size_t)settings->width * (size_t)settings->height;
}
/* Replaces 0 by the table's default, of any method's options. What the table leaves to the methods stays 0.
 */
void sl_settings_complete(sl_settings *settings);
/* Metadata "softlux.NAME": what the method that made the picture was asked for. */
sl_status sl_settings_stamp(const sl_settings *settings, sl_image *image, sl_error *error);
/* A number, or a flag as 0 or 1, in the field's own unit; name: one of the table's, whole. */
double sl_settings_number(const sl_settings *settings, const char *name);
void sl_settings_put_number(sl_settings *settings, const char *name, double value);
/* The option of that whole name, or else with that last part; NULL where there is none. */
const sl_setting *sl_setting_named(const char *name);

/* Tells whether the method is one of the reference tracers. */
bool sl_is_tracer(const char *method);

/* Returns how far the pixel filter reaches that is asked for, where that is a matter of choice. */
static inline double sl_filter_radius(const sl_settings *settings) {
    if (settings->filter != SL_FILTER_BLACKMAN_HARRIS) return 0.0;
    return settings->filter_radius > 0.0 ? settings->filter_radius : 1.5;
}
