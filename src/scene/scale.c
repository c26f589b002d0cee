/* The size in which most of a scene lies. The diagonal of the box that holds everything says little about a
 * room that stands on a plain a million times as large: any share of it that matters elsewhere is larger than
 * the room. Half of the vertices say more, since detail is where people look. The middle is the median of
 * each coordinate, and the radius the median of the distances from there: neither moves far while fewer than
 * half of the vertices lie elsewhere. */
#include <float.h>
#include <math.h>

#include "base/math.h"
#include "scene/derive.h"

/* Scenes that people make have a diagonal of 2 to 30 times that radius. Up to SPAN the diagonal is the
 * scale. */
static const double SPAN = 128.0;
/* Of an eye that stands further off the surroundings are wanted as well: a grain of dust may have most of a
 * room's vertices, and so may a far planet. */
static const double EYE_SPAN = 4.0;
/* Of the diagonal; below that floats as large as the whole scene do not tell the smaller part's vertices
 * apart. */
static const double LEAST = 0x1p-20;
/* The surroundings of the eye count as a scene of their own where the rest is that many times as far, with
 * nothing in between: most vertices may be in the rest. */
static const double GAP = 128.0;
/* Half the least extent of the central region, in radii. */
static const double CENTRAL = 2.0;

enum { DIGIT = 11, DIGITS = 1 << DIGIT, SAMPLES_MAX = 1 << 17 };

/* ---- medians ---- */

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
    return (float)fmin(sl_lengthd(sl_subd(sl_to_double(sl_scene_position(s->scene, vertex)), s->middle)),
                       (double)FLT_MAX);
}

/* The value with `rank` smaller ones, digit by digit from the highest: needs no memory, and does not know the
 * vertices' order. */
static float ranked(const sample *s, measure *value, size_t rank) {
    uint32_t prefix = 0, known = 0;
    for (int low = 32 - DIGIT; known != UINT32_MAX; low = low > DIGIT ? low - DIGIT : 0) {
        size_t count[DIGITS] = {0};
        for (size_t i = 0; i < s->count; i++) {
            uint32_t key = sl_float_key(value(s, (uint32_t)(i * s->stride)));
            if ((key & known) == prefix) count[key >> low & (DIGITS - 1)]++;
        }
        uint32_t digit = 0;
        while (digit < DIGITS - 1 && rank >= count[digit]) rank -= count[digit++];
        known |= (uint32_t)(DIGITS - 1) << low;
        prefix |= digit << low;
    }
    return sl_float_of_key(prefix);
}

/* The mean of the two in the middle where the count is even: so a mirrored scene has its mirrored median. */
static double median(const sample *s, measure *value) {
    return 0.5 * ((double)ranked(s, value, (s->count - 1) / 2) + (double)ranked(s, value, s->count / 2));
}

/* ---- the surroundings of the eye ---- */

static double squared_distance(const sl_scene *scene, sl_vec3d from, uint32_t vertex) {
    sl_vec3d d = sl_subd(sl_to_double(sl_scene_position(scene, vertex)), from);
    return sl_dotd(d, d);
}

/* By the powers of two between which a squared distance lies. */
enum { LOWEST = -300, HIGHEST = 300, OCTAVES = HIGHEST - LOWEST };
typedef struct octaves {
    double nearest[OCTAVES], farthest[OCTAVES]; /* squared; farthest < 0: there is nothing */
} octaves;

static void sort_by_distance(const sl_scene *scene, sl_vec3d eye, octaves *o) {
    for (int k = 0; k < OCTAVES; k++) o->nearest[k] = INFINITY, o->farthest[k] = -1.0;
    for (size_t v = 0; v < scene->vertex_count; v++) {
        int exponent;
        double d = squared_distance(scene, eye, (uint32_t)v);
        frexp(d, &exponent);
        int k = d > 0.0 && exponent > LOWEST ? (exponent < HIGHEST ? exponent - LOWEST : OCTAVES - 1) : 0;
        o->nearest[k] = fmin(o->nearest[k], d);
        o->farthest[k] = fmax(o->farthest[k], d);
    }
}

/* Van Oosterom and Strackee 1983. */
static double solid_angle(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    double la = sl_lengthd(a), lb = sl_lengthd(b), lc = sl_lengthd(c);
    double volume = fabs(sl_dotd(a, sl_crossd(b, c))),
           sum = la * lb * lc + sl_dotd(a, b) * lc + sl_dotd(b, c) * la + sl_dotd(c, a) * lb;
    return volume > 0.0 ? 2.0 * sl_atan2(volume, sum) : 0.0;
}

/* Tells whether the triangles whose corners all lie within the squared distance fill more of the directions
 * from the eye than all others do. */
static bool fills_most(const sl_scene *scene, sl_vec3d eye, double squared) {
    double within = 0.0, beyond = 0.0;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        sl_vec3d d[3];
        bool inside = true;
        for (int c = 0; c < 3; c++) {
            d[c] = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[c][t])), eye);
            inside &= sl_dotd(d[c], d[c]) <= squared;
        }
        *(inside ? &within : &beyond) += solid_angle(d[0], d[1], d[2]);
    }
    return within > beyond;
}

/* The squared distance to which what surrounds the eye reaches; infinite where there is no such gap behind
 * it. */
static double gap_behind(const sl_scene *scene, sl_vec3d eye) {
    octaves o;
    double last = -1.0;
    sort_by_distance(scene, eye, &o);
    for (int k = 0; k < OCTAVES; k++) {
        if (o.farthest[k] < 0.0) continue;
        if (last > 0.0 && o.nearest[k] > GAP * GAP * last && fills_most(scene, eye, last)) return last;
        last = o.farthest[k];
    }
    return INFINITY;
}

/* ---- scale and central region ---- */

/* Where people look: half of the vertices lie within the radius, or all that surround the eye. */
typedef struct detail {
    sl_vec3d middle;
    double radius;
    bool is_all; /* and not half: what lies beyond is behind the gap */
} detail;

static detail surroundings(const sl_scene *scene, sl_vec3d eye) {
    const double squared = gap_behind(scene, eye);
    sl_box box = sl_box_empty();
    if (isinf(squared)) return (detail){eye, INFINITY, true};
    for (size_t v = 0; v < scene->vertex_count; v++) {
        if (squared_distance(scene, eye, (uint32_t)v) <= squared)
            sl_box_add(&box, sl_scene_position(scene, (uint32_t)v));
    }
    const sl_vec3d low = sl_to_double(box.low), high = sl_to_double(box.high);
    return (detail){sl_scaled(sl_addd(low, high), 0.5), 0.5 * sl_lengthd(sl_subd(high, low)), true};
}

static double scale_of(const sl_scene *scene, const detail *d, sl_vec3d eye) {
    if (!(d->radius > 0.0)) return INFINITY;
    return fmax(fmax(SPAN * d->radius, EYE_SPAN * sl_lengthd(sl_subd(eye, d->middle))),
                fmax(LEAST * (double)scene->diagonal, (double)FLT_MIN));
}

/* The box of the vertices within `distance` of the middle along each axis. */
static void bound_central_region(sl_scene *scene, sl_vec3d middle, double distance) {
    sl_box box = sl_box_empty();
    for (size_t v = 0; v < scene->vertex_count; v++) {
        sl_vec3 p = sl_scene_position(scene, (uint32_t)v);
        sl_vec3d d = sl_subd(sl_to_double(p), middle);
        if (!(fabs(d.x) <= distance) || !(fabs(d.y) <= distance) || !(fabs(d.z) <= distance)) continue;
        sl_box_add(&box, p);
    }
    if (!(box.low.x <= box.high.x)) return;
    scene->central_min = box.low;
    scene->central_max = box.high;
}

void sl_scene_measure_from(sl_scene *scene, sl_vec3 vantage) {
    const sl_vec3d eye = sl_to_double(vantage);
    const detail half = {scene->middle, scene->radius, false}, around = surroundings(scene, eye);
    const detail *d = scale_of(scene, &around, eye) < scale_of(scene, &half, eye) ? &around : &half;
    const double diagonal = (double)scene->diagonal, scale = scale_of(scene, d, eye);
    scene->vantage = vantage;
    scene->scale = scene->diagonal;
    scene->central_min = scene->box_min;
    scene->central_max = scene->box_max;
    if (!(scale < diagonal)) return;
    scene->scale = (float)scale;
    /* All of the scene where the scale is all but the diagonal, so that nothing jumps. */
    const double wanted =
        d->is_all ? d->radius : fmax(CENTRAL * d->radius, sl_lengthd(sl_subd(eye, d->middle)));
    bound_central_region(scene, d->middle, fmax(wanted, scale * scale / diagonal));
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
