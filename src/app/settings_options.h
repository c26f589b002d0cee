/* The settings of all methods as command-line options: one table for every command that runs a method or tells of one. */
#ifndef SL_APP_SETTINGS_OPTIONS_H
#define SL_APP_SETTINGS_OPTIONS_H

#include "app/options.h"
#include "softlux.h"

/* Values as the command line gives them. */
typedef struct sl_raw_settings {
    sl_settings settings; /* those that need no conversion */
    bool quality_given;
    int size[2], quality, gather, direct, filter, order, metric;
    uint64_t threads, spp, gather_size, harmonics_order, bounces, hit_samples, records_per_frame;
    int map_shape, weight, map_filter, mirror_light, visibility;
    uint64_t map_samples, map_size, reflections, cube_size, shadow_size, emitter_samples;
    double map_fov;
    int store, area, lobes, voxel_filter;
    uint64_t depth, neighbours, lights, atlas_size;
    double spread_tolerance, acceptance;
    int estimator, selection;
    uint64_t light_size, light_rays, max_depth, coarse_depth, batch;
    double gather_fov;
    int area_sampling, indirect, pixel_selection;
    uint64_t points, area_samples, indirect_samples, path_depth, ageing_window, change_window, frames_per_update, updates;
} sl_raw_settings;

enum { SL_SETTINGS_OPTIONS = 160 }; /* room for all of them and the end of the table */

/* Sets raw to the defaults and writes the table of options, with the entry that ends it. raw must stay where it is. */
void sl_settings_options(sl_raw_settings *raw, sl_option *options);
/* The settings once the command line has been read. */
sl_settings sl_settings_taken(const sl_raw_settings *raw);

#endif
