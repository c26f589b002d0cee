/* The camera of a file that brings none. Things are framed from outside, at a three-quarter view unless that
 * shows more backs than fronts. Rooms are shown from inside: where walls face inwards, where all lamps are
 * shut in, and where there is more to be seen within than without. */
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "scene/derive.h"
#include "scene/sight.h"

typedef struct view_angle {
    double azimuth, elevation; /* degrees: from +z towards +x, and up */
} view_angle;

/* In the order in which they are preferred. */
static const view_angle angles[] = {{30, 20},  {-30, 20}, {0, 12},   {150, 20}, {-150, 20},
                                    {180, 12}, {90, 12},  {-90, 12}, {30, 55},  {150, 55}};
enum { ANGLES = sizeof angles / sizeof angles[0], STARTS = 10, VIEWS = 4 };

static const double outside_fov = 0.78539816339744828,
                    inside_fov = 1.1344640137963142; /* 45 and 65 degrees */
/* Of what is seen from outside so much may be backs; beyond the second another view, or one from inside, is
 * looked for. */
static const double few_backs = 0.25, many_backs = 0.5;
/* A point is inside where so many rays hit something, and so many of these a front. */
enum { MORE_MATERIALS = 2 };
static const double inside_hits = 0.92, inside_fronts = 0.75;

static sl_vec3d centre_of(const sl_scene *s) {
    return sl_scaled(sl_addd(sl_to_double(s->box_min), sl_to_double(s->box_max)), 0.5);
}

/* ---- from outside -------------------------------------------------------------------------------------- */

static sl_vec3d outwards(view_angle a) {
    double turn = a.azimuth * (SL_PI / 180.0), rise = a.elevation * (SL_PI / 180.0);
    return sl_v3d(sl_sin(turn) * sl_cos(rise), sl_sin(rise), sl_cos(turn) * sl_cos(rise));
}

/* Returns how far from the centre along `back` every vertex is within the picture, with a twentieth to
 * spare. */
static double fitting_distance(const sl_scene *s, sl_vec3d right, sl_vec3d up, sl_vec3d back) {
    const double high = sl_tan(0.5 * outside_fov),
                 wide = high * ((double)s->film_width / (double)s->film_height);
    const sl_vec3d centre = centre_of(s);
    double distance = 0.0;
    for (size_t v = 0; v < s->vertex_count; v++) {
        sl_vec3d p = sl_subd(sl_to_double(sl_scene_position(s, (uint32_t)v)), centre);
        double across = fmax(fabs(sl_dotd(p, right)) / wide, fabs(sl_dotd(p, up)) / high);
        distance = fmax(distance, sl_dotd(p, back) + across);
    }
    return 1.05 * distance;
}

static sl_camera from_outside(const sl_scene *s, view_angle angle) {
    const sl_vec3d back = outwards(angle), centre = centre_of(s);
    sl_vec3d right = sl_crossd(sl_v3d(0, 1, 0), back);
    right = sl_scaled(right, 1.0 / sl_lengthd(right));
    const sl_vec3d up = sl_crossd(back, right);
    sl_vec3 eye = sl_to_float(sl_addd(centre, sl_scaled(back, fitting_distance(s, right, up, back))));
    /* The frame does not depend on how eye and centre round, however small the scene beside its distance from
     * the origin. */
    return (sl_camera){eye, sl_to_float(right), sl_to_float(up), sl_to_float(back), (float)outside_fov};
}

static double backs_seen(const sl_scene *s, const sl_camera *camera, int *materials) {
    sl_sight sight;
    sl_sight_view(&sight, s, camera);
    sl_sight_count count = sl_sight_counted(&sight, s);
    *materials = count.materials;
    return count.hit ? 1.0 - (double)count.front / count.hit : 0.0;
}

/* The first that shows few backs; or that with the fewest, if those are fewer by far than the first one
 * shows. */
static sl_camera best_outside(const sl_scene *s, sl_camera first, double first_backs) {
    sl_camera best = first;
    double least = first_backs - few_backs;
    for (int i = 1; i < ANGLES; i++) {
        sl_camera camera = from_outside(s, angles[i]);
        int materials;
        double backs = backs_seen(s, &camera, &materials);
        if (backs <= few_backs) return camera;
        if (backs < least) least = backs, best = camera;
    }
    return best;
}

/* ---- from inside --------------------------------------------------------------------------------------- */

/* The lamp in whose light a picture would be taken; false where light comes from outside, or there is
 * none. */
static bool lamp_at(const sl_scene *s, size_t index, sl_vec3 *place) {
    if (index < s->light_count) {
        *place = s->lights[index].position;
        return s->lights[index].type != SL_LIGHT_DIRECTIONAL;
    }
    if (index - s->light_count >= s->emitter_count) return false;
    uint32_t t = s->emitters[index - s->light_count].triangle;
    sl_vec3d sum = sl_to_double(sl_scene_position(s, s->vertex[0][t]));
    for (int c = 1; c < 3; c++) sum = sl_addd(sum, sl_to_double(sl_scene_position(s, s->vertex[c][t])));
    sl_vec3d off = sl_scaled(sl_to_double(sl_scene_geometric_normal(s, t)), 1e-4 * (double)s->diagonal);
    *place = sl_to_float(sl_addd(sl_scaled(sum, 1.0 / 3.0), off));
    return true;
}

/* Tells whether no light of the first, the middle and the last lamp leaves the scene; one of them in
 * *place. */
static bool lamps_are_shut_in(const sl_scene *s, sl_vec3 *place) {
    const size_t count = s->light_count + s->emitter_count, some[3] = {0, count / 2, count ? count - 1 : 0};
    if (s->environment.present || !count) return false;
    for (int i = 0; i < 3; i++) {
        if (i > 0 && some[i] == some[i - 1]) continue;
        sl_sight sight;
        if (!lamp_at(s, some[i], place)) return false;
        sl_sight_sphere(&sight, s, *place);
        bool leaves = false;
        for (int k = 0; k < SL_SIGHT_RAYS; k++) {
            bool shines =
                some[i] < s->light_count ||
                sl_dot(sl_sight_direction(&sight, k),
                       sl_scene_geometric_normal(s, s->emitters[some[i] - s->light_count].triangle)) > 0.0f;
            leaves |= shines && !isfinite(sight.distance[k]);
        }
        if (leaves) return false;
    }
    return true;
}

/* Returns how much room there is around a point; 0 where it is not inside, or fewer materials are seen from
 * there. */
static double room_around(const sl_scene *s, sl_vec3 point, int materials) {
    sl_sight sight;
    sl_sight_sphere(&sight, s, point);
    sl_sight_count count = sl_sight_counted(&sight, s);
    bool inside = count.hit >= inside_hits * SL_SIGHT_RAYS && count.front >= inside_fronts * count.hit;
    return inside && count.materials >= materials ? count.mean_distance : 0.0;
}

/* Half-way between what is hit in one direction and in the opposite one, axis by axis. */
static sl_vec3 middle_of_room(const sl_scene *s, sl_vec3 point) {
    static const sl_vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int k = 0; k < 3; k++) {
        sl_sight sight = {.origin = point};
        for (int i = 0; i < SL_SIGHT_RAYS; i++) sl_sight_set(&sight, i, i % 2 ? axis[k] : sl_neg(axis[k]));
        sl_sight_cast(&sight, s);
        if (!isfinite(sight.distance[0]) || !isfinite(sight.distance[1])) continue;
        point = sl_mad(point, 0.5f * (sight.distance[1] - sight.distance[0]), axis[k]);
    }
    return point;
}

/* The roomiest of some points; false where none is inside. */
static bool find_room(const sl_scene *s, const sl_vec3 *lamp, int materials, sl_vec3 *middle) {
    static const double offset[STARTS / 2][2] = {
        {0, 0}, {-0.25, -0.25}, {0.25, -0.25}, {-0.25, 0.25}, {0.25, 0.25}};
    const sl_vec3d centre = centre_of(s), size = sl_subd(sl_to_double(s->box_max), sl_to_double(s->box_min));
    double most = lamp ? room_around(s, *lamp, materials) : 0.0;
    if (most > 0.0) *middle = *lamp;
    for (int i = 0; i < STARTS && !(lamp && most > 0.0); i++) {
        sl_vec3 point =
            sl_to_float(sl_addd(centre, sl_v3d(offset[i / 2][0] * size.x, i % 2 ? 0.2 * size.y : 0.0,
                                               offset[i / 2][1] * size.z)));
        double room = room_around(s, point, materials);
        if (room > most) most = room, *middle = point;
    }
    if (!(most > 0.0)) return false;
    sl_vec3 moved = middle_of_room(s, *middle);
    if (room_around(s, moved, materials) > 0.0) *middle = moved;
    return true;
}

/* Looking along the direction, from near to what is behind the middle of the room. */
static bool look_along(const sl_sight *horizon, int ray, sl_camera *camera) {
    const int opposite = (ray + SL_SIGHT_RAYS / 2) % SL_SIGHT_RAYS;
    const float behind = isfinite(horizon->distance[opposite]) ? horizon->distance[opposite] : 0.0f;
    sl_vec3 along = sl_sight_direction(horizon, ray), eye = sl_mad(horizon->origin, -0.85f * behind, along);
    along.y = -0.1f;
    return sl_camera_look_at(camera, eye, sl_mad(eye, behind + fminf(horizon->distance[ray], 1e30f), along),
                             sl_v3(0, 1, 0), (float)inside_fov);
}

/* Returns how much of a view is far from its eye: fronts count by their distance, up to the span; what is
 * close up or a back, less than nothing. */
static double worth_of_view(const sl_scene *s, const sl_camera *camera, double span) {
    sl_sight sight;
    double sum = 0.0;
    sl_sight_view(&sight, s, camera);
    for (int i = 0; i < SL_SIGHT_RAYS; i++) {
        double share = fmin((double)sight.distance[i] / span, 1.0);
        bool good = share > 0.1 && isfinite(sight.distance[i]) && sight.facing[i] > 0.0f;
        sum += good ? share : -0.5;
    }
    return sum;
}

static double span_of(const sl_sight *horizon, int ray) {
    return fmin((double)horizon->distance[ray], 1e30) +
           fmin((double)horizon->distance[(ray + SL_SIGHT_RAYS / 2) % SL_SIGHT_RAYS], 1e30);
}

/* The longest lines through the middle, an eighth of a turn apart at least, each from both of its ends. */
static void longest_lines(const sl_sight *horizon, int ray[VIEWS]) {
    const int half = SL_SIGHT_RAYS / 2;
    int first = 0, second = -1;
    for (int i = 1; i < half; i++) first = span_of(horizon, i) > span_of(horizon, first) ? i : first;
    for (int i = 0; i < half; i++) {
        int apart = abs(i - first) < half / 2 ? abs(i - first) : half - abs(i - first);
        if (apart >= SL_SIGHT_RAYS / 8 && (second < 0 || span_of(horizon, i) > span_of(horizon, second)))
            second = i;
    }
    ray[0] = first, ray[1] = first + half, ray[2] = second, ray[3] = second + half;
}

/* Tells whether a side is missing: doors and windows are narrower, and a missing roof is no way out. */
static bool has_open_side(const sl_sight *horizon) {
    int gap = 0;
    for (int i = 0; i < 2 * SL_SIGHT_RAYS; i++) {
        gap = isfinite(horizon->distance[i % SL_SIGHT_RAYS]) ? 0 : gap + 1;
        if (gap > SL_SIGHT_RAYS / 8) return true;
    }
    return false;
}

static bool from_inside(const sl_scene *s, const sl_vec3 *lamp, int materials, sl_camera *camera) {
    sl_sight horizon;
    sl_vec3 middle;
    int ray[VIEWS];
    double best = -INFINITY;
    if (!find_room(s, lamp, materials, &middle)) return false;
    sl_sight_horizon(&horizon, s, middle);
    if (has_open_side(&horizon)) return false;
    longest_lines(&horizon, ray);
    for (int i = 0; i < VIEWS; i++) {
        sl_camera view;
        if (!look_along(&horizon, ray[i], &view)) continue;
        double worth = worth_of_view(s, &view, span_of(&horizon, ray[i]));
        if (worth > best) best = worth, *camera = view;
    }
    return best > -INFINITY;
}

sl_camera sl_camera_framed(const sl_scene *scene, bool *inside, bool *shut_out) {
    sl_camera outside = from_outside(scene, angles[0]), camera;
    int materials;
    double backs = backs_seen(scene, &outside, &materials);
    sl_vec3 lamp;
    bool shut_in = lamps_are_shut_in(scene, &lamp), is_room = shut_in || backs > many_backs;
    int more = is_room ? 0 : MORE_MATERIALS * materials;
    *inside = (is_room || more <= (int)fmin((double)scene->material_count, SL_SIGHT_RAYS)) &&
              from_inside(scene, shut_in ? &lamp : NULL, more, &camera);
    *shut_out = shut_in && !*inside;
    if (*inside) return camera;
    return backs <= few_backs ? outside : best_outside(scene, outside, backs);
}
