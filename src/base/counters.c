#include "base/counters.h"

static const char *const counter_names[SL_COUNTERS] = {
    [SL_COUNT_RASTER_PASSES] = "raster_passes",
    [SL_COUNT_RASTER_PASSES_SKIPPED] = "raster_passes_skipped",
    [SL_COUNT_CLUSTERS_TESTED] = "clusters_tested",
    [SL_COUNT_CLUSTERS_CULLED] = "clusters_culled",
    [SL_COUNT_TRIANGLES_SUBMITTED] = "triangles_submitted",
    [SL_COUNT_TRIANGLES_CULLED] = "triangles_culled",
    [SL_COUNT_TRIANGLES_DROPPED] = "triangles_dropped",
    [SL_COUNT_TRIANGLES_CLIPPED] = "triangles_clipped",
    [SL_COUNT_TRIANGLES_RASTERIZED] = "triangles_rasterized",
    [SL_COUNT_FRAGMENTS_SHADED] = "fragments_shaded",
    [SL_COUNT_FRAGMENTS_BLENDED] = "fragments_blended",
    [SL_COUNT_BYTES_READ_BACK] = "bytes_read_back",
    [SL_COUNT_SHADOW_LOOKUPS] = "shadow_lookups",
    [SL_COUNT_RAYS] = "rays",
    [SL_COUNT_SHADOW_RAYS] = "shadow_rays",
    [SL_COUNT_GATHERS] = "gathers",
    [SL_COUNT_RECORDS] = "records",
    [SL_COUNT_RECORDS_DISCARDED] = "records_discarded",
    [SL_COUNT_SPLATS] = "splats",
    [SL_COUNT_SECOND_LEVEL_RECORDS] = "second_level_records",
    [SL_COUNT_SECOND_LEVEL_LOOK_UPS] = "second_level_look_ups",
    [SL_COUNT_SECOND_LEVEL_MISSES] = "second_level_misses",
    [SL_COUNT_MAP_PHOTONS] = "map_photons",
    [SL_COUNT_MAP_PHOTONS_DROPPED] = "map_photons_dropped",
    [SL_COUNT_PHOTON_LOOK_UPS] = "photon_look_ups",
    [SL_COUNT_PHOTONS_EMITTED] = "photons_emitted",
    [SL_COUNT_PHOTONS_STORED] = "photons_stored",
    [SL_COUNT_PHOTONS_GATHERED] = "photons_gathered",
    [SL_COUNT_LEAVES] = "leaves",
    [SL_COUNT_LEAVES_WITHOUT_PHOTONS] = "leaves_without_photons",
    [SL_COUNT_DIRECTIONAL_LIGHTS] = "directional_lights",
    [SL_COUNT_TEXTURE_FETCHES] = "texture_fetches",
    [SL_COUNT_LIGHT_SAMPLES] = "light_samples",
    [SL_COUNT_LIGHT_SAMPLES_SKIPPED] = "light_samples_skipped",
    [SL_COUNT_COARSE_SAMPLES] = "coarse_samples",
    [SL_COUNT_INDIRECT_SAMPLES] = "indirect_samples",
    [SL_COUNT_SPLITS] = "splits",
    [SL_COUNT_COLLAPSES] = "collapses",
    [SL_COUNT_PIXELS_REDRAWN] = "pixels_redrawn",
    [SL_COUNT_PIXEL_TESTS] = "pixel_tests",
    [SL_COUNT_PIXELS_HIT] = "pixels_hit",
    [SL_COUNT_PIXELS_RANDOM] = "pixels_random",
    [SL_COUNT_PIXELS_FLOODED] = "pixels_flooded",
    [SL_COUNT_POINTS_SHADED] = "points_shaded",
    [SL_COUNT_PATCHES_EVICTED] = "patches_evicted",
    [SL_COUNT_CHANGES_DETECTED] = "changes_detected",
    [SL_COUNT_CHANGES_SHOWN] = "changes_shown",
    [SL_COUNT_UPDATES_TO_SHOW] = "updates_to_show",
    [SL_COUNT_FRAMES_DISPLAYED] = "frames_displayed",
    [SL_COUNT_SAMPLES] = "samples",
    [SL_COUNT_NONFINITE] = "nonfinite",
};

const char *sl_counter_name(sl_counter counter) {
    return counter >= 0 && counter < SL_COUNTERS ? counter_names[counter] : "unknown";
}

void sl_counters_add(sl_counters *sum, const sl_counters *other) {
    for (int i = 0; i < SL_COUNTERS; i++) sum->value[i] += other->value[i];
}

void sl_counters_subtract(sl_counters *from, const sl_counters *other) {
    for (int i = 0; i < SL_COUNTERS; i++) from->value[i] -= other->value[i];
}
