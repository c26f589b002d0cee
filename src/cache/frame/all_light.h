/* Measures by a few thousand paths how much of a picture's light a method finds. Lamps and sky as they are
 * seen are left out, since they are the same whatever is counted. */
#pragma once

#include "cache/frame/settings.h"
#include "scene/scene.h"

/* Tells whether the method, or the one whose paths a tracer takes, counts as many bounces as it is asked for.
 */
bool sl_has_bounces(const sl_settings *settings);

typedef struct sl_bounces_measured {
    uint32_t bounces; /* so many that all further ones together add less than half a per cent; 64 at most */
    double left;      /* the share of all light that they would add */
} sl_bounces_measured;

/* settings->bounces is not looked at. The same numbers at any number of threads. */
sl_status sl_measure_bounces(const sl_scene *scene, const sl_settings *settings, sl_bounces_measured *found,
                             sl_error *error);
/* Light paths as options name them. */
typedef struct sl_light_paths {
    const char *method, *transport;
} sl_light_paths;

/* light[i]: mean luminance of a small picture by paths[i], whose options besides are the settings'. The same
 * numbers at any number of threads; of two sets of one method what both count is the same in both. */
sl_status sl_measure_light(const sl_scene *scene, const sl_settings *settings, const sl_light_paths *paths,
                           size_t count, unsigned samples, double *light, sl_error *error);
