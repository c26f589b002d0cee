/* Cameras: an orthonormal frame from eye, target and up. */
#include <math.h>

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

sl_status sl_scene_set_camera(sl_scene *scene, const float eye[3], const float target[3], const float up[3],
                              float vertical_fov_rad, sl_error *error) {
    if (!scene || !eye || !target || !up) return sl_fail_null(error, "a scene and three vectors");
    if (!sl_camera_look_at(&scene->camera, sl_v3(eye[0], eye[1], eye[2]),
                           sl_v3(target[0], target[1], target[2]), sl_v3(up[0], up[1], up[2]),
                           vertical_fov_rad)) {
        return sl_fail(error, SL_ERROR_USAGE,
                       "camera: expected an eye apart from its target, an up vector not along the view "
                       "and a vertical field of view between 0 and 180 degrees");
    }
    sl_scene_measure_from(scene, scene->camera.eye);
    scene->version++;
    return SL_OK;
}
