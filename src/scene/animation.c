#include "scene/animation.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/derive.h"

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

sl_key sl_track_at(const sl_track *track, double time) {
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
    const sl_key key = sl_track_at(track, time);
    sl_affine motion = sl_key_placement(&key);
    if (!animation->z_up) return motion;
    sl_affine turn = sl_affine_z_up(), back = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
    sl_affine turned = sl_affine_after(&motion, &back);
    return sl_affine_after(&turn, &turned);
}

/* ---- objects --------------------------------------------------------------------------------- */

static sl_vec3 moved(const sl_affine *motion, sl_vec3 rest) {
    return sl_to_float(sl_affine_point(motion, sl_to_double(rest)));
}

static sl_status check_motion(const sl_scene *scene, const sl_affine *motions, double time, sl_error *error) {
    const sl_animation *a = scene->animation;
    uint32_t bad = SL_NO_INDEX;
    for (size_t v = 0; v < scene->vertex_count; v++) {
        uint32_t track = a->track_of_vertex[v];
        if (track != SL_NO_INDEX && !sl_is_finite(moved(&motions[track], a->rest_position[v]))) bad = track;
    }
    for (size_t k = 0; k < 16 * scene->bicubic_count; k++) {
        uint32_t track = a->track_of_vertex[scene->bicubics[k / 16].first_vertex];
        if (track != SL_NO_INDEX && !sl_is_finite(moved(&motions[track], a->rest_control[k]))) bad = track;
    }
    if (bad == SL_NO_INDEX) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "keyframes move object '%s' beyond all numbers at time %g",
                   scene->object_names[a->tracks[bad].first], time);
}

static bool set_vector(float *x, float *y, float *z, sl_vec3 to) {
    bool changed = *x != to.x || *y != to.y || *z != to.z;
    *x = to.x;
    *y = to.y;
    *z = to.z;
    return changed;
}

static bool move_vertices(sl_scene *s, const sl_affine *motions, const sl_affine *normal_maps) {
    const sl_animation *a = s->animation;
    bool changed = false;
    for (size_t v = 0; v < s->vertex_count; v++) {
        uint32_t track = a->track_of_vertex[v];
        if (track == SL_NO_INDEX) continue;
        sl_vec3 normal = sl_affine_unit(&normal_maps[track], a->rest_normal[v]);
        if (!(sl_dot(normal, normal) > 0.5f)) normal = a->rest_normal[v];
        changed |= set_vector(&s->position_x[v], &s->position_y[v], &s->position_z[v],
                              moved(&motions[track], a->rest_position[v]));
        changed |= set_vector(&s->normal_x[v], &s->normal_y[v], &s->normal_z[v], normal);
    }
    return changed;
}

static bool move_surfaces(sl_scene *s, const sl_affine *motions) {
    const sl_animation *a = s->animation;
    bool changed = false;
    for (size_t k = 0; k < 16 * s->bicubic_count; k++) {
        sl_bicubic *b = &s->bicubics[k / 16];
        uint32_t track = a->track_of_vertex[b->first_vertex];
        sl_vec3 *point = &b->point[k % 16 / 4][k % 4];
        if (track != SL_NO_INDEX)
            changed |=
                set_vector(&point->x, &point->y, &point->z, moved(&motions[track], a->rest_control[k]));
    }
    return changed;
}

static bool emissive_moves(const sl_scene *s) {
    for (size_t t = 0; t < s->triangle_count; t++) {
        bool emissive = sl_material_is_emitter(&s->materials[s->material_index[t]]);
        if (emissive && s->animation->track_of_vertex[s->vertex[0][t]] != SL_NO_INDEX) return true;
    }
    return false;
}

/* Of every track (others than of objects have some that nobody asks for), and after them their maps of
 * normals; released with sl_free(). NULL where nothing moves. */
static sl_status motions_at(const sl_scene *scene, double time, sl_affine **motions, sl_error *error) {
    const sl_animation *a = scene->animation;
    *motions = NULL;
    if (a->track_count == 0) return SL_OK;
    sl_affine *m = sl_allocate(2 * a->track_count, sizeof *m);
    if (!m) return sl_fail_memory(error, "the motion of objects");
    for (size_t i = 0; i < a->track_count; i++) {
        m[i] = track_in_world(a, &a->tracks[i], time);
        m[a->track_count + i] = sl_affine_normal_map(&m[i]);
    }
    sl_status status = check_motion(scene, m, time, error);
    if (status == SL_OK) *motions = m;
    else sl_free(m);
    return status;
}

static sl_status move_objects(sl_scene *scene, double time, unsigned *changes, sl_error *error) {
    sl_affine *motions;
    sl_status status = motions_at(scene, time, &motions, error);
    if (!motions) return status;
    bool changed = move_vertices(scene, motions, motions + scene->animation->track_count);
    if (move_surfaces(scene, motions)) changed = true;
    if (changed) {
        sl_scene_derive(scene);
        *changes |= SL_CHANGED_OBJECTS;
        if (emissive_moves(scene)) *changes |= SL_CHANGED_LIGHTS;
    }
    sl_free(motions);
    return SL_OK;
}

/* ---- lights and camera ----------------------------------------------------------------------- */

static void move_lights(sl_scene *scene, double time, unsigned *changes) {
    for (size_t i = 0; i < scene->animation->track_count; i++) {
        const sl_track *track = &scene->animation->tracks[i];
        if (track->kind != SL_TRACK_LIGHT) continue;
        const sl_key key = sl_track_at(track, time);
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
        const sl_key key = sl_track_at(&scene->animation->tracks[i], time);
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

sl_status sl_scene_check_time(const sl_scene *scene, double time_seconds, sl_error *error) {
    sl_camera camera;
    sl_affine *motions = NULL;
    if (!isfinite(time_seconds)) return sl_fail(error, SL_ERROR_USAGE, "expected a finite time in seconds");
    sl_status status = scene->animation ? camera_at(scene, time_seconds, &camera, error) : SL_OK;
    if (status == SL_OK && scene->animation) status = motions_at(scene, time_seconds, &motions, error);
    sl_free(motions);
    return status;
}

/* Does all that can fail before the first change. */
sl_status sl_scene_set_time(sl_scene *scene, double time_seconds, unsigned *changes, sl_error *error) {
    unsigned changed = 0;
    if (changes) *changes = 0;
    if (!scene) return sl_fail_null(error, "a scene");
    if (!isfinite(time_seconds)) return sl_fail(error, SL_ERROR_USAGE, "expected a finite time in seconds");
    if (!scene->animation) return SL_OK;
    sl_camera camera;
    sl_status status = camera_at(scene, time_seconds, &camera, error);
    if (status == SL_OK) status = move_objects(scene, time_seconds, &changed, error);
    if (status != SL_OK) return status;
    move_lights(scene, time_seconds, &changed);
    if (!same_camera(&camera, &scene->camera)) changed |= SL_CHANGED_CAMERA;
    scene->camera = camera;
    if (changed) scene->version++;
    if (changes) *changes = changed;
    return SL_OK;
}

/* The track of every object, or SL_NO_INDEX; release with sl_free(). */
static uint32_t *tracks_of_objects(const sl_animation *a, size_t object_count) {
    uint32_t *tracks = sl_allocate(object_count, sizeof *tracks);
    if (!tracks) return NULL;
    memset(tracks, 0xff, object_count * sizeof *tracks); /* SL_NO_INDEX */
    for (size_t i = 0; i < a->track_count; i++) {
        const sl_track *track = &a->tracks[i];
        if (track->kind != SL_TRACK_OBJECTS) continue;
        for (size_t k = track->first; k < track->first + (size_t)track->count && k < object_count; k++)
            tracks[k] = (uint32_t)i;
    }
    return tracks;
}

sl_status sl_animation_attach(sl_scene *scene, sl_animation *a, sl_error *error) {
    scene->animation = a;
    a->track_of_vertex = sl_allocate(scene->vertex_count, sizeof *a->track_of_vertex);
    a->rest_position = sl_allocate(scene->vertex_count, sizeof *a->rest_position);
    a->rest_normal = sl_allocate(scene->vertex_count, sizeof *a->rest_normal);
    a->rest_control = sl_allocate(16 * scene->bicubic_count, sizeof *a->rest_control);
    uint32_t *tracks = tracks_of_objects(a, scene->object_count);
    if (!a->track_of_vertex || !a->rest_position || !a->rest_normal || !a->rest_control || !tracks) {
        sl_free(tracks);
        return sl_fail_memory(error, "the animation");
    }
    for (size_t v = 0; v < scene->vertex_count; v++) {
        a->track_of_vertex[v] = SL_NO_INDEX;
        a->rest_position[v] = sl_scene_position(scene, (uint32_t)v);
        a->rest_normal[v] = sl_scene_normal(scene, (uint32_t)v);
    }
    for (size_t t = 0; t < scene->triangle_count; t++) {
        uint32_t track = tracks[scene->object_index[t]];
        for (int c = 0; c < 3; c++) a->track_of_vertex[scene->vertex[c][t]] = track;
    }
    /* all its vertices, also those that no triangle uses */
    for (size_t i = 0; i < scene->bicubic_count; i++) {
        const sl_bicubic *b = &scene->bicubics[i];
        uint32_t side = (uint32_t)b->steps + 1, track = tracks[scene->object_index[b->first_triangle]];
        for (uint32_t v = 0; v < side * side; v++) a->track_of_vertex[b->first_vertex + v] = track;
        for (int k = 0; k < 16; k++) a->rest_control[16 * i + (size_t)k] = b->point[k / 4][k % 4];
    }
    sl_free(tracks);
    sl_status status = sl_scene_set_time(scene, 0.0, NULL, error);
    scene->version = 0;
    return status;
}

void sl_animation_destroy(sl_animation *a) {
    if (!a) return;
    for (size_t i = 0; i < a->track_count; i++) sl_free(a->tracks[i].keys);
    sl_free(a->tracks);
    sl_free(a->track_of_vertex);
    sl_free(a->rest_position);
    sl_free(a->rest_normal);
    sl_free(a->rest_control);
    sl_free(a);
}
