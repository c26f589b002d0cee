#include "scene/animation.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/derive.h"
#include "scene/object_motion.h"

/* ---- rotations ------------------------------------------------------------------------------- */

static sl_quaternion multiply(sl_quaternion a, sl_quaternion b) {
    return (sl_quaternion){
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

sl_quaternion sl_quaternion_from_euler(double x, double y, double z) {
    sl_quaternion about_x = {sl_cos(0.5 * x), sl_sin(0.5 * x), 0, 0},
                  about_y = {sl_cos(0.5 * y), 0, sl_sin(0.5 * y), 0};
    sl_quaternion about_z = {sl_cos(0.5 * z), 0, 0, sl_sin(0.5 * z)};
    return multiply(about_z, multiply(about_y, about_x));
}

static sl_quaternion blend(sl_quaternion a, double wa, sl_quaternion b, double wb) {
    sl_quaternion q = {wa * a.w + wb * b.w, wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z};
    double length = sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (!(length > 0.0)) return a;
    return (sl_quaternion){q.w / length, q.x / length, q.y / length, q.z / length};
}

/* Shoemake's spherical interpolation; nearly equal rotations are blended, where the quotient of sines loses
 * its meaning. */
sl_quaternion sl_quaternion_slerp(sl_quaternion a, sl_quaternion b, double t) {
    double cosine = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
    double side = cosine < 0.0 ? -1.0 : 1.0; /* q and -q are one rotation; the nearer one is meant */
    double angle = sl_acos(side * cosine), sine = sl_sin(angle);
    if (!(sine > 1e-6)) return blend(a, 1.0 - t, b, side * t);
    return blend(a, sl_sin((1.0 - t) * angle) / sine, b, side * sl_sin(t * angle) / sine);
}

sl_affine sl_key_placement(const sl_key *key) {
    const sl_quaternion q = key->rotate;
    const sl_vec3d s = key->scale, t = key->position;
    return (sl_affine){{{s.x * (1 - 2 * (q.y * q.y + q.z * q.z)), s.y * 2 * (q.x * q.y - q.w * q.z),
                         s.z * 2 * (q.x * q.z + q.w * q.y), t.x},
                        {s.x * 2 * (q.x * q.y + q.w * q.z), s.y * (1 - 2 * (q.x * q.x + q.z * q.z)),
                         s.z * 2 * (q.y * q.z - q.w * q.x), t.y},
                        {s.x * 2 * (q.x * q.z - q.w * q.y), s.y * 2 * (q.y * q.z + q.w * q.x),
                         s.z * (1 - 2 * (q.x * q.x + q.y * q.y)), t.z}}};
}

/* ---- between two keys ------------------------------------------------------------------------ */

static sl_vec3d lerp(sl_vec3d a, sl_vec3d b, double t) {
    return sl_addd(sl_scaled(a, 1.0 - t), sl_scaled(b, t));
}

/* Directions turn at constant speed; opposite ones have no arc between them and flip half way. */
static sl_vec3 between_directions(sl_vec3d a, sl_vec3d b, double t) {
    double cosine = sl_dotd(a, b), angle = sl_acos(cosine), sine = sl_sin(angle);
    if (!(sine > 1e-6)) return sl_to_float(t < 0.5 ? a : b);
    sl_vec3d d =
        sl_addd(sl_scaled(a, sl_sin((1.0 - t) * angle) / sine), sl_scaled(b, sl_sin(t * angle) / sine));
    return sl_normalize_or(sl_to_float(d), sl_to_float(a));
}

/* The state between the keys on both sides of a time; before the first and after the last it rests. */
static sl_key track_at(const sl_track *track, double time) {
    size_t next = 0;
    while (next < track->key_count && track->keys[next].time <= time) next++;
    const sl_key *a = &track->keys[next > 0 ? next - 1 : 0],
                 *b = &track->keys[next < track->key_count ? next : track->key_count - 1];
    const double t = a == b ? 0.0 : (time - a->time) / (b->time - a->time);
    return (sl_key){.time = time,
                    .position = lerp(a->position, b->position, t),
                    .rotate = sl_quaternion_slerp(a->rotate, b->rotate, t),
                    .scale = lerp(a->scale, b->scale, t),
                    .direction = sl_to_double(between_directions(a->direction, b->direction, t)),
                    .target = lerp(a->target, b->target, t),
                    .up = lerp(a->up, b->up, t),
                    .vertical_fov = a->vertical_fov * (1.0 - t) + b->vertical_fov * t};
}

/* In the turned world the same motion is U K U^-1, with U a permutation of axes, so nothing is rounded. */
static sl_affine track_in_world(const sl_animation *animation, const sl_track *track, double time) {
    if (track->is_placed) return track->placement;
    const sl_key key = track_at(track, time);
    sl_affine placement = sl_key_placement(&key);
    if (!animation->z_up) return placement;
    sl_affine turn = sl_affine_z_up(), back = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
    sl_affine turned = sl_affine_after(&placement, &back);
    return sl_affine_after(&turn, &turned);
}

/* ---- objects --------------------------------------------------------------------------------- */

/* Returns the track of an object, of several the last one; NULL: it rests. */
static const sl_track *track_of(const sl_animation *a, uint32_t object) {
    const sl_track *last = NULL;
    for (size_t i = 0; a && i < a->track_count; i++) {
        const sl_track *t = &a->tracks[i];
        if (t->kind == SL_TRACK_OBJECTS && object >= t->first && object - t->first < t->count) last = t;
    }
    return last;
}

sl_affine sl_animation_placement(const sl_scene *scene, uint32_t object, bool *keyed) {
    const sl_track *track = track_of(scene->animation, object);
    *keyed = track && !track->is_placed;
    return track ? track_in_world(scene->animation, track, scene->time) : sl_affine_identity();
}

bool sl_scene_transform(const sl_scene *scene, uint32_t object, double columns[16]) {
    bool keyed;
    const sl_affine at = sl_animation_placement(scene, object - 1, &keyed);
    for (int k = 0; k < 16; k++) columns[k] = k % 4 < 3 ? at.m[k % 4][k / 4] : k == 15 ? 1.0 : 0.0;
    return keyed;
}

static sl_vec3 moved(const sl_affine *motion, sl_vec3 rest) {
    return sl_to_float(sl_affine_point(motion, sl_to_double(rest)));
}

/* A track's at some time, which is of objects if it moves. */
static sl_object_motion motion_at(const sl_animation *a, const sl_track *track, double time) {
    const sl_affine places = track_in_world(a, track, time);
    return (sl_object_motion){track->kind == SL_TRACK_OBJECTS, places, sl_affine_normal_map(&places)};
}

/* Returns the motion of a vertex; NULL: it stays where it is. */
static const sl_object_motion *motion_of(const sl_animation *a, const sl_object_motion *motions,
                                         size_t vertex) {
    const uint32_t track = a->track_of_vertex[vertex];
    return track != SL_NO_INDEX && motions[track].moves ? &motions[track] : NULL;
}

/* Returns a track that leaves all numbers; SL_NO_INDEX: none does. */
static uint32_t find_beyond(const sl_scene *scene, const sl_object_motion *motions) {
    const sl_animation *a = scene->animation;
    uint32_t bad = SL_NO_INDEX;
    for (size_t v = 0; v < scene->vertex_count; v++) {
        const sl_object_motion *m = motion_of(a, motions, v);
        if (m && !sl_is_finite(moved(&m->places, a->rest_position[v]))) bad = a->track_of_vertex[v];
    }
    for (size_t k = 0; k < 16 * scene->bicubic_count; k++) {
        const uint32_t vertex = scene->bicubics[k / 16].first_vertex;
        const sl_object_motion *m = motion_of(a, motions, vertex);
        if (m && !sl_is_finite(moved(&m->places, a->rest_control[k]))) bad = a->track_of_vertex[vertex];
    }
    return bad;
}

static bool set_vector(float *x, float *y, float *z, sl_vec3 to) {
    bool changed = *x != to.x || *y != to.y || *z != to.z;
    *x = to.x;
    *y = to.y;
    *z = to.z;
    return changed;
}

static bool move_vertices(sl_scene *s, const sl_object_motion *motions) {
    const sl_animation *a = s->animation;
    bool changed = false;
    for (size_t v = 0; v < s->vertex_count; v++) {
        const sl_object_motion *m = motion_of(a, motions, v);
        if (!m) continue;
        sl_vec3 normal = sl_affine_unit(&m->turns, a->rest_normal[v]);
        if (!(sl_dot(normal, normal) > 0.5f)) normal = a->rest_normal[v];
        changed |= set_vector(&s->position_x[v], &s->position_y[v], &s->position_z[v],
                              moved(&m->places, a->rest_position[v]));
        changed |= set_vector(&s->normal_x[v], &s->normal_y[v], &s->normal_z[v], normal);
    }
    return changed;
}

static bool move_surfaces(sl_scene *s, const sl_object_motion *motions) {
    const sl_animation *a = s->animation;
    bool changed = false;
    for (size_t k = 0; k < 16 * s->bicubic_count; k++) {
        sl_bicubic *b = &s->bicubics[k / 16];
        const sl_object_motion *m = motion_of(a, motions, b->first_vertex);
        sl_vec3 *point = &b->point[k % 16 / 4][k % 4];
        if (m)
            changed |=
                set_vector(&point->x, &point->y, &point->z, moved(&m->places, a->rest_control[k]));
    }
    return changed;
}

static bool emissive_moves(const sl_scene *s, const sl_object_motion *motions) {
    for (size_t t = 0; t < s->triangle_count; t++) {
        bool emissive = sl_material_is_emitter(sl_triangle_material(s, t));
        if (emissive && motion_of(s->animation, motions, s->vertex[0][t])) return true;
    }
    return false;
}

/* Moves what the motions move, none of it beyond all numbers, and tells what has changed by it. */
static unsigned move(sl_scene *scene, const sl_object_motion *motions) {
    bool changed = move_vertices(scene, motions);
    if (move_surfaces(scene, motions)) changed = true;
    if (!changed) return 0;
    sl_scene_derive(scene);
    return SL_CHANGED_OBJECTS | (emissive_moves(scene, motions) ? SL_CHANGED_LIGHTS : 0u);
}

/* Of every track; released with sl_free(). NULL where nothing moves. */
static sl_status motions_at(const sl_scene *scene, double time, sl_object_motion **motions, sl_error *error) {
    const sl_animation *a = scene->animation;
    *motions = NULL;
    if (a->track_count == 0) return SL_OK;
    sl_object_motion *m = sl_allocate(a->track_count, sizeof *m);
    if (!m) return sl_fail_memory(error, "the motion of objects");
    for (size_t i = 0; i < a->track_count; i++) m[i] = motion_at(a, &a->tracks[i], time);
    const uint32_t bad = find_beyond(scene, m);
    *motions = m;
    if (bad == SL_NO_INDEX) return SL_OK;
    sl_free(m);
    *motions = NULL;
    return sl_fail(error, SL_ERROR_INPUT, "keyframes move object '%s' beyond all numbers at time %g",
                   scene->object_names[a->tracks[bad].first], time);
}

/* ---- lights and camera ----------------------------------------------------------------------- */

static void move_lights(sl_scene *scene, double time, unsigned *changes) {
    for (size_t i = 0; i < scene->animation->track_count; i++) {
        const sl_track *track = &scene->animation->tracks[i];
        if (track->kind != SL_TRACK_LIGHT) continue;
        const sl_key key = track_at(track, time);
        sl_light *light = &scene->lights[track->first];
        const sl_vec3 position = sl_to_float(key.position), direction = light->type == SL_LIGHT_POINT
                                                                            ? light->direction
                                                                            : sl_to_float(key.direction);
        bool changed = set_vector(&light->position.x, &light->position.y, &light->position.z, position);
        changed |= set_vector(&light->direction.x, &light->direction.y, &light->direction.z, direction);
        if (changed) *changes |= SL_CHANGED_LIGHTS;
    }
}

static sl_status camera_at(const sl_scene *scene, double time, sl_camera *camera, sl_error *error) {
    *camera = scene->camera;
    for (size_t i = 0; i < scene->animation->track_count; i++) {
        if (scene->animation->tracks[i].kind != SL_TRACK_CAMERA) continue;
        const sl_key key = track_at(&scene->animation->tracks[i], time);
        if (!sl_camera_look_at(camera, sl_to_float(key.position), sl_to_float(key.target),
                               sl_to_float(key.up), (float)key.vertical_fov))
            return sl_fail(
                error, SL_ERROR_INPUT,
                "camera keyframes: at time %g the eye is at its target, or looks along its up vector", time);
    }
    return SL_OK;
}

static bool same(sl_vec3 a, sl_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_camera(const sl_camera *a, const sl_camera *b) {
    return same(a->eye, b->eye) && same(a->right, b->right) && same(a->up, b->up) && same(a->back, b->back) &&
           a->vertical_fov == b->vertical_fov;
}

/* ---- the whole ------------------------------------------------------------------------------- */

double sl_scene_duration(const sl_scene *scene) {
    const sl_animation *a = scene->animation;
    double last = 0.0;
    for (size_t i = 0; a && i < a->track_count; i++) {
        const sl_track *t = &a->tracks[i];
        if (t->key_count) last = fmax(last, t->keys[t->key_count - 1].time);
    }
    return last;
}

/* Does all that can fail before the first change. */
static sl_status look_ahead(const sl_scene *scene, double time, sl_camera *camera, sl_object_motion **motions,
                            sl_error *error) {
    *motions = NULL;
    if (!isfinite(time)) return sl_fail(error, SL_ERROR_USAGE, "expected a finite time in seconds");
    sl_status status = scene->animation ? camera_at(scene, time, camera, error) : SL_OK;
    return status == SL_OK && scene->animation ? motions_at(scene, time, motions, error) : status;
}

sl_status sl_scene_check_time(const sl_scene *scene, double time_seconds, sl_error *error) {
    sl_camera camera;
    sl_object_motion *motions;
    sl_status status = look_ahead(scene, time_seconds, &camera, &motions, error);
    sl_free(motions);
    return status;
}

sl_status sl_scene_set_time(sl_scene *scene, double time_seconds, unsigned *changes, sl_error *error) {
    unsigned changed = 0;
    if (changes) *changes = 0;
    if (!scene) return sl_fail_null(error, "a scene");
    sl_camera camera;
    sl_object_motion *motions;
    sl_status status = look_ahead(scene, time_seconds, &camera, &motions, error);
    if (status != SL_OK || !scene->animation) return status;
    if (motions) changed = move(scene, motions);
    sl_free(motions);
    move_lights(scene, time_seconds, &changed);
    if (!same_camera(&camera, &scene->camera)) changed |= SL_CHANGED_CAMERA;
    scene->camera = camera;
    scene->time = time_seconds;
    sl_scene_has_changed(scene, changed);
    if (changes) *changes = changed;
    return SL_OK;
}

/* Gives every vertex the track of its object, or SL_NO_INDEX: of several the last one. */
static bool follow_tracks(const sl_scene *s, const sl_animation *a) {
    uint32_t *of_object = sl_allocate_unset(s->object_count, sizeof *of_object);
    if (!of_object) return false;
    memset(of_object, 0xff, s->object_count * sizeof *of_object); /* SL_NO_INDEX */
    memset(a->track_of_vertex, 0xff, s->vertex_count * sizeof *a->track_of_vertex);
    for (size_t i = 0; i < a->track_count; i++) {
        const sl_track *track = &a->tracks[i];
        const size_t end = track->kind == SL_TRACK_OBJECTS ? track->first + (size_t)track->count : 0;
        for (size_t k = track->first; k < end && k < s->object_count; k++) of_object[k] = (uint32_t)i;
    }
    for (size_t k = 0; k < 3 * s->triangle_count; k++)
        a->track_of_vertex[s->vertex[k % 3][k / 3]] = of_object[s->object_index[k / 3]];
    for (size_t i = 0; i < s->bicubic_count; i++) { /* all its vertices, also those of no triangle */
        const sl_bicubic *b = &s->bicubics[i];
        const uint32_t side = (uint32_t)b->steps + 1, track = of_object[s->object_index[b->first_triangle]];
        for (uint32_t v = 0; v < side * side; v++) a->track_of_vertex[b->first_vertex + v] = track;
    }
    sl_free(of_object);
    return true;
}

/* Takes the scene as it stands for the rest state. */
static sl_status rest(const sl_scene *scene, sl_animation *a, sl_error *error) {
    a->track_of_vertex = sl_allocate_unset(scene->vertex_count, sizeof *a->track_of_vertex);
    a->rest_position = sl_allocate_unset(scene->vertex_count, sizeof *a->rest_position);
    a->rest_normal = sl_allocate_unset(scene->vertex_count, sizeof *a->rest_normal);
    a->rest_control = sl_allocate_unset(16 * scene->bicubic_count, sizeof *a->rest_control);
    if (!a->track_of_vertex || !a->rest_position || !a->rest_normal || !a->rest_control ||
        !follow_tracks(scene, a))
        return sl_fail_memory(error, "the animation");
    for (size_t v = 0; v < scene->vertex_count; v++) {
        a->rest_position[v] = sl_scene_position(scene, (uint32_t)v);
        a->rest_normal[v] = sl_scene_normal(scene, (uint32_t)v);
    }
    for (size_t k = 0; k < 16 * scene->bicubic_count; k++)
        a->rest_control[k] = scene->bicubics[k / 16].point[k % 16 / 4][k % 4];
    return SL_OK;
}

sl_status sl_animation_attach(sl_scene *scene, sl_animation *a, sl_error *error) {
    scene->animation = a;
    sl_status status = rest(scene, a, error);
    if (status == SL_OK) status = sl_scene_set_time(scene, 0.0, NULL, error);
    scene->version = 0;
    memset(scene->changed, 0, sizeof scene->changed);
    return status;
}

/* ---- objects that are placed ----------------------------------------------------------------- */

/* Gives an object the track by which it was placed before, or one of its own, for which there is room. */
static void place_track(sl_animation *a, const sl_placement *p, double time, sl_object_motion *motions) {
    size_t i = 0;
    while (i < a->track_count && !(a->tracks[i].is_placed && a->tracks[i].first == p->object)) i++;
    a->track_count += i == a->track_count;
    a->tracks[i] = (sl_track){.kind = SL_TRACK_OBJECTS,
                              .first = p->object,
                              .count = 1,
                              .is_placed = true,
                              .placement = p->placement};
    if (p->released) a->tracks[i].count = 0;
    const sl_track *track = track_of(a, p->object);
    if (!track) { /* back to rest */
        a->tracks[i].count = 1;
        a->tracks[i].placement = sl_affine_identity();
        track = &a->tracks[i];
    }
    motions[track - a->tracks] = motion_at(a, track, time);
}

/* Moves what the motions move, or nothing, where that would leave all numbers. */
static sl_status move_placed(sl_scene *s, sl_animation *with, const sl_object_motion *motions,
                             unsigned *changes, sl_error *error) {
    sl_animation *const before = s->animation;
    s->animation = with;
    const uint32_t bad = find_beyond(s, motions);
    if (bad == SL_NO_INDEX) *changes |= move(s, motions);
    s->animation = before;
    if (bad == SL_NO_INDEX) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "object '%s': expected 'transform' to leave it finite",
                   s->object_names[with->tracks[bad].first]);
}

static sl_status place(sl_scene *s, sl_animation *a, size_t count, const sl_placement *placement,
                       unsigned *changes, sl_error *error) {
    sl_animation with = *a;
    with.track_room = a->track_count + count;
    with.tracks = sl_allocate(with.track_room, sizeof *with.tracks);
    with.track_of_vertex = sl_allocate_unset(s->vertex_count, sizeof *with.track_of_vertex);
    sl_object_motion *motions = sl_allocate(with.track_room, sizeof *motions);
    const bool there = with.tracks && with.track_of_vertex && motions;
    if (there && a->track_count) memcpy(with.tracks, a->tracks, a->track_count * sizeof *a->tracks);
    for (size_t i = 0; i < count && there; i++) place_track(&with, &placement[i], s->time, motions);
    const sl_status status = there && follow_tracks(s, &with)
                                 ? move_placed(s, &with, motions, changes, error)
                                 : sl_fail_memory(error, "the motion of objects");
    sl_free(motions);
    sl_free(status == SL_OK ? a->tracks : with.tracks);
    sl_free(status == SL_OK ? a->track_of_vertex : with.track_of_vertex);
    if (status == SL_OK) *a = with;
    return status;
}

sl_status sl_animation_place(sl_scene *scene, size_t count, const sl_placement *placement, unsigned *changes,
                             sl_error *error) {
    sl_animation *a = scene->animation;
    sl_status status = SL_OK;
    if (count == 0) return SL_OK;
    if (!a) {
        a = sl_allocate(1, sizeof *a);
        status = a ? rest(scene, a, error) : sl_fail_memory(error, "the animation");
    }
    if (status == SL_OK) status = place(scene, a, count, placement, changes, error);
    if (status == SL_OK) scene->animation = a;
    else if (a != scene->animation) sl_animation_destroy(a);
    return status;
}

void sl_animation_destroy(sl_animation *a) {
    if (!a) return;
    for (size_t i = 0; i < a->track_count; i++) sl_free(a->tracks[i].keys);
    SL_FREE_ALL(a->tracks, a->track_of_vertex, a->rest_position, a->rest_normal, a->rest_control, a);
}
