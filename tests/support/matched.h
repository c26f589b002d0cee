/* A picture against the path tracer on the same paths. */
#pragma once

#include "cache/frame/settings.h"

typedef struct matched {
    double error;   /* root of relMSE, less what the reference's own noise adds */
    double bias;
    double noise;   /* root of the reference's share */
    double records;
} matched;

/* By so many samples a pixel; counters (may be NULL) receives what the picture cost. Fails the test if the
 * picture holds a value that is negative or not finite. */
sl_comparison against_path_tracer(const sl_scene *scene, const sl_settings *settings, uint32_t spp,
                                  sl_counters *counters);
matched matched_with_path_tracer(const sl_scene *scene, const sl_settings *settings, uint32_t spp);
/* Every value of every layer is finite and not negative. */
void assert_sound_picture(const sl_image *image, const char *what);
