/* Cameras: an orthonormal frame from eye, target and up; and which one a scene has. */
#include "base/error.h"
#include "base/math.h"
#include "scene/derive.h"

bool sl_camera_look_at(sl_camera *camera, sl_vec3 eye, sl_vec3 target, sl_vec3 up, float vertical_fov) {
    if (!(vertical_fov > 0.0f) || !(vertical_fov < (float)SL_PI)) return false;
    if (!sl_is_finite(eye) || !sl_is_finite(target) || !sl_is_finite(up)) return false;
    sl_vec3d back = sl_subd(sl_to_double(eye), sl_to_double(target));
    double distance = sl_lengthd(back), up_length = sl_lengthd(sl_to_double(up));
    if (!(distance > 0.0) || !(up_length > 0.0)) return false;
    back = sl_scaled(back, 1.0 / distance);
    sl_vec3d right = sl_crossd(sl_scaled(sl_to_double(up), 1.0 / up_length), back);
    double sine = sl_lengthd(right); /* of the angle between up and the view direction */
    if (!(sine > 1e-6)) return false;
    right = sl_scaled(right, 1.0 / sine);
    *camera = (sl_camera){eye, sl_to_float(right), sl_to_float(sl_crossd(back, right)), sl_to_float(back),
                          vertical_fov};
    return true;
}

static sl_status fail_of_view(sl_error *error) {
    return sl_fail(error, SL_ERROR_USAGE,
                   "camera: expected an eye apart from its target, an up vector not along the view and a "
                   "vertical field of view between 0 and 180 degrees");
}

sl_status sl_camera_take(sl_camera *camera, const float eye[3], const float target[3], const float up[3],
                         float vertical_fov, sl_error *error) {
    return sl_camera_look_at(camera, sl_v3_of(eye), sl_v3_of(target), sl_v3_of(up), vertical_fov)
               ? SL_OK
               : fail_of_view(error);
}

sl_status sl_scene_set_camera(sl_scene *scene, const float eye[3], const float target[3], const float up[3],
                              float vertical_fov_rad, sl_error *error) {
    if (!scene || !eye || !target || !up) return sl_fail_null(error, "a scene and three vectors");
    sl_status status = sl_camera_take(&scene->camera, eye, target, up, vertical_fov_rad, error);
    if (status != SL_OK) return status;
    sl_scene_measure_from(scene, scene->camera.eye);
    sl_scene_has_changed(scene, SL_CHANGED_CAMERA);
    return SL_OK;
}

/* ---- the one that a scene has ---------------------------------------------------------------- */

static bool camera_is_valid(const sl_camera *c) {
    sl_camera check;
    return sl_is_finite(c->right) && sl_is_finite(c->up) && sl_is_finite(c->eye) &&
           sl_camera_look_at(&check, sl_v3(0, 0, 0), sl_neg(c->back), c->up, c->vertical_fov);
}

/* Parts of a view that replace the camera's own; an eye alone looks at the middle of the scene. */
static bool take_view(const sl_viewpoint *v, const sl_scene *s, sl_camera *camera) {
    sl_vec3d low = sl_to_double(s->box_min), high = sl_to_double(s->box_max);
    sl_vec3 middle = sl_to_float(sl_scaled(sl_addd(low, high), 0.5));
    sl_vec3 eye = v->has_eye ? sl_v3_of(v->eye) : camera->eye;
    sl_vec3 target = v->has_target ? sl_v3_of(v->target)
                     : v->has_eye  ? middle
                                   : sl_sub(eye, camera->back);
    sl_vec3 up = v->has_up ? sl_v3_of(v->up) : sl_v3(0, 1, 0);
    float fov = v->has_fov ? v->vertical_fov_rad : camera->vertical_fov;
    if (!v->has_eye && !v->has_target) { /* looking from the origin keeps all bits of the direction */
        bool good =
            sl_camera_look_at(camera, sl_v3(0, 0, 0), sl_neg(camera->back), v->has_up ? up : camera->up, fov);
        camera->eye = eye;
        return good;
    }
    return sl_camera_look_at(camera, eye, target, up, fov);
}

sl_status sl_scene_place_camera(sl_scene *s, const sl_camera *given, const sl_viewpoint *view, bool *shut_out,
                                sl_error *error) {
    bool inside = false;
    *shut_out = false;
    if (given && !camera_is_valid(given))
        return sl_fail(
            error, SL_ERROR_INPUT,
            "camera: expected a finite frame and a vertical field of view between 0 and 180 degrees");
    s->camera = given ? *given : sl_camera_framed(s, &inside, shut_out);
    if (view && !take_view(view, s, &s->camera)) return fail_of_view(error);
    *shut_out = *shut_out && !(view && view->has_eye);
    if (given || (view && view->has_eye)) return SL_OK;
    sl_vec3 eye = s->camera.eye, back = s->camera.back;
    sl_scene_warn(s, "no camera: %s (eye %g %g %g, looking along %.3g %.3g %.3g, %.3g degrees)",
                  inside ? "one is put into the room" : "the whole scene is framed from outside",
                  (double)eye.x, (double)eye.y, (double)eye.z, -(double)back.x, -(double)back.y,
                  -(double)back.z, (double)s->camera.vertical_fov * 57.29577951308232);
    return SL_OK;
}
