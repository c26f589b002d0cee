/* Differences that an eye can tell on the display (Walter's threshold map). Errors are judged at the final
 * pixel: radiance through the tone map to grey levels 0 to 255, a difference against the threshold of the
 * darker of the two. */
#pragma once

#include "base/math.h"
#include "scene/scene.h"

typedef struct sl_perception {
    /* e: D = 255 (eL / (1 + eL))^(1/2.2). Never of a picture's content: thresholds would flicker */
    float exposure;
    float threshold_scale;
} sl_perception;

/* Returns the exposure at which a radiance in the middle of what the scene's light makes of its surfaces
 * displays as a middle grey: from power, area and mean reflectance alone; 1 where the scene has no light. */
float sl_perception_exposure(const sl_scene *scene, float mean_radiance);

/* D of a channel, in [0,255], within 1e-4 of a grey level, and monotone but for as much; negative, NaN: 0;
 * infinite: 255. exposure >= 0. Loops over it vectorise. */
static inline float sl_display_level(float exposure, float radiance) {
    float exposed = exposure * radiance;
    exposed = exposed > 0.0f ? exposed : 0.0f;
    exposed = exposed < 0x1p100f ? exposed : 0x1p100f;
    return 255.0f * sl_powf(exposed / (1.0f + exposed), 1.0f / 2.2f);
}
/* T at level D: 10 at 0, 6 at 32, 4 at 64, 3 from 128 on, linear between; times threshold_scale. */
float sl_display_threshold(const sl_perception *perception, float level);
/* |D difference| / T of the darker one: above 1 an eye can tell. Where nothing is tolerated any difference is
 * the largest there is. */
float sl_levels_contrast(const sl_perception *perception, float a, float b);
/* Returns the largest of the channels'. */
float sl_display_contrast(const sl_perception *perception, sl_rgb a, sl_rgb b);
