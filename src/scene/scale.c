/* The size in which most of a scene lies. The diagonal of the box that holds everything says little about a room that stands on a plain a million times as
 * large: any share of it that matters elsewhere is larger than the room. Half of the vertices say more, since detail is where people look. The middle is the
 * median of each coordinate, and the radius the median of the distances from there: neither moves far while fewer than half of the vertices lie elsewhere. */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "scene/derive.h"

/* Scenes that people make have a diagonal of 2 to 30 times that radius. Up to REACH the diagonal is the scale. */
static const double REACH = 128.0;
/* Of an eye that stands further off the surroundings are wanted as well: a grain of dust may have most of a room's vertices, and so may a far planet. */
static const double EYE_REACH = 4.0;
/* Of the diagonal; below that floats as large as the whole scene do not tell the smaller part's vertices apart. */
static const double LEAST = 0x1p-20;
/* How far from the middle the core reaches at least, in radii. */
static const double CORE = 2.0;

enum { DIGIT = 11, DIGITS = 1 << DIGIT, SAMPLES_MAX = 1 << 17 };

/* ---- medians ---- */

/* A number whose order is that of the floats. */
static uint32_t key_of(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static float value_of(uint32_t key) {
    uint32_t bits = key & 0x80000000u ? key & 0x7fffffffu : ~key;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

typedef struct {
    const sl_scene *scene;
    size_t count, stride; /* of the vertices asked */
    sl_vec3d middle;
} sample;

typedef float measure(const sample *s, uint32_t vertex);

static float x_of(const sample *s, uint32_t vertex) { return s->scene->position_x[vertex]; }
static float y_of(const sample *s, uint32_t vertex) { return s->scene->position_y[vertex]; }
static float z_of(const sample *s, uint32_t vertex) { return s->scene->position_z[vertex]; }
static float distance_of(const sample *s, uint32_t vertex) {
    return (float)fmin(sl_lengthd(sl_subd(sl_to_double(sl_scene_position(s->scene, vertex)), s->middle)), (double)FLT_MAX);
}

/* The value with `rank` smaller ones, digit by digit from the highest: needs no memory, and does not know the vertices' order. */
static float ranked(const sample *s, measure *value, size_t rank) {
    uint32_t prefix = 0, known = 0;
    for (int low = 32 - DIGIT; known != UINT32_MAX; low = low > DIGIT ? low - DIGIT : 0) {
        size_t count[DIGITS] = {0};
        for (size_t i = 0; i < s->count; i++) {
            uint32_t key = key_of(value(s, (uint32_t)(i * s->stride)));
            if ((key & known) == prefix) count[key >> low & (DIGITS - 1)]++;
        }
        uint32_t digit = 0;
        while (digit < DIGITS - 1 && rank >= count[digit]) rank -= count[digit++];
        known |= (uint32_t)(DIGITS - 1) << low;
        prefix |= digit << low;
    }
    return value_of(prefix);
}

/* The mean of the two in the middle where the count is even: so a mirrored scene has its mirrored median. */
static double median(const sample *s, measure *value) {
    return 0.5 * ((double)ranked(s, value, (s->count - 1) / 2) + (double)ranked(s, value, s->count / 2));
}

/* ---- scale and core ---- */

/* The box of the vertices within `reach` of the middle along each axis. */
static void bound_core(sl_scene *scene, double reach) {
    sl_vec3 low = sl_v3(FLT_MAX, FLT_MAX, FLT_MAX), high = sl_v3(-FLT_MAX, -FLT_MAX, -FLT_MAX);
    for (size_t v = 0; v < scene->vertex_count; v++) {
        sl_vec3 p = sl_scene_position(scene, (uint32_t)v);
        sl_vec3d d = sl_subd(sl_to_double(p), scene->middle);
        if (!(fabs(d.x) <= reach) || !(fabs(d.y) <= reach) || !(fabs(d.z) <= reach)) continue;
        low = sl_v3(fminf(low.x, p.x), fminf(low.y, p.y), fminf(low.z, p.z));
        high = sl_v3(fmaxf(high.x, p.x), fmaxf(high.y, p.y), fmaxf(high.z, p.z));
    }
    if (!(low.x <= high.x)) return;
    scene->core_min = low;
    scene->core_max = high;
}

void sl_scene_measure_from(sl_scene *scene, sl_vec3 vantage) {
    const double diagonal = (double)scene->diagonal, distance = sl_lengthd(sl_subd(sl_to_double(vantage), scene->middle));
    const double scale = fmax(fmax(REACH * scene->radius, EYE_REACH * distance), fmax(LEAST * diagonal, (double)FLT_MIN));
    scene->vantage = vantage;
    scene->scale = scene->diagonal;
    scene->core_min = scene->box_min;
    scene->core_max = scene->box_max;
    if (!(scene->radius > 0.0) || !(scale < diagonal)) return;
    scene->scale = (float)scale;
    /* All of the scene where the scale is all but the diagonal, so that nothing jumps. */
    bound_core(scene, fmax(fmax(CORE * scene->radius, distance), scale * scale / diagonal));
}

void sl_scene_measure(sl_scene *scene) {
    sample s = {.scene = scene, .stride = scene->vertex_count / SAMPLES_MAX + 1};
    s.count = scene->vertex_count / s.stride;
    scene->radius = 0.0;
    if (s.count > 0) {
        s.middle = scene->middle = sl_v3d(median(&s, x_of), median(&s, y_of), median(&s, z_of));
        scene->radius = (double)ranked(&s, distance_of, s.count / 2);
    }
    sl_scene_measure_from(scene, scene->vantage);
}
