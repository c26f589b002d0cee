/* Keyframes of objects, lights and camera. A state is a pure function of the time: what moves is always
 * placed from its rest state, never from where it was. */
#ifndef SL_SCENE_ANIMATION_H
#define SL_SCENE_ANIMATION_H

#include "scene/affine.h"
#include "scene/scene.h"

typedef struct sl_quaternion {
    double w, x, y, z;
} sl_quaternion;

/* Rotations about x, then y, then z, in radians. */
sl_quaternion sl_quaternion_from_euler(double x, double y, double z);
/* Along the shorter arc, at constant angular speed; t in [0,1]. Unit quaternions. */
sl_quaternion sl_quaternion_slerp(sl_quaternion a, sl_quaternion b, double t);

/* Scale, then rotate, then translate: comes after the object's own transform. */
typedef struct sl_object_key {
    double time;
    sl_vec3d translate, scale; /* scale > 0 */
    sl_quaternion rotate;
} sl_object_key;
typedef struct sl_object_track {
    uint32_t first_object, object_count;
    size_t key_count;
    sl_object_key *keys; /* times rise strictly */
} sl_object_track;

typedef struct sl_light_key {
    double time;
    sl_vec3d position, direction;
} sl_light_key;
typedef struct sl_light_track {
    uint32_t light;
    size_t key_count;
    sl_light_key *keys;
} sl_light_track;

typedef struct sl_camera_key {
    double time;
    sl_vec3d eye, target, up;
    double vertical_fov;
} sl_camera_key;

struct sl_animation {
    bool z_up; /* object keys are in a world with z up */
    size_t object_track_count, light_track_count, camera_key_count;
    sl_object_track *object_tracks;
    sl_light_track *light_tracks;
    sl_camera_key *camera_keys;
    /* Made by sl_animation_attach(): of each vertex its track (or SL_NO_INDEX) and its rest state. */
    uint32_t *track_of_vertex;
    sl_vec3 *rest_position, *rest_normal;
    sl_vec3 *rest_control; /* 16 of each bicubic surface; its track is that of its vertices */
};

sl_affine sl_object_track_at(const sl_object_track *track, double time);

/* Tells whether sl_scene_set_time() would succeed, and why not; what it takes memory for is not asked. */
sl_status sl_scene_check_time(const sl_scene *scene, double time_seconds, sl_error *error);

/* The scene takes the animation over (also where this fails: it goes with the scene), keeps the scene's state
 * as the rest state, and moves the scene to time 0. */
sl_status sl_animation_attach(sl_scene *scene, sl_animation *animation, sl_error *error);
void sl_animation_destroy(sl_animation *animation); /* NULL is allowed */

#endif
