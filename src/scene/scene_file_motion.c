/* Scene files: where things are, and how they move. */
#include <float.h>
#include <math.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/scene_file.h"

/* sl_json_vec3(), turned to y up. */
static bool read_vector(sl_scene_file *file, const cJSON *item, sl_vec3d *vector) {
    if (!sl_json_vec3(&file->json, item, vector)) return false;
    *vector = sl_affine_vector(&file->turn, *vector);
    return true;
}

/* ---- transforms ------------------------------------------------------------------------------ */

/* A number or three; keyframes want what a size can be, a transform only that nothing is flattened. */
static void read_scale(sl_json *json, const cJSON *item, bool positive, sl_vec3d *scale) {
    if (!item || json->status != SL_OK) return;
    double all;
    if (cJSON_IsNumber(item)) {
        if (sl_json_number(json, item, -(double)FLT_MAX, (double)FLT_MAX, &all))
            *scale = sl_v3d(all, all, all);
    } else {
        sl_json_vec3(json, item, scale);
    }
    bool some = scale->x != 0.0 && scale->y != 0.0 && scale->z != 0.0,
         above = scale->x > 0.0 && scale->y > 0.0 && scale->z > 0.0;
    if (!some || (positive && !above))
        sl_json_fail(json, item, "expected 'scale' to be %s", positive ? "above 0" : "other than 0");
}

static void read_placement(sl_json *json, const cJSON *object, bool positive, sl_key *key) {
    sl_vec3d degrees = {0, 0, 0};
    key->scale = sl_v3d(1, 1, 1);
    key->position = sl_v3d(0, 0, 0);
    sl_json_vec3(json, sl_json_get(object, "translate"), &key->position);
    if (sl_json_vec3(json, sl_json_get(object, "rotate_deg"), &degrees) &&
        !(fabs(degrees.x) <= 1e5 && fabs(degrees.y) <= 1e5 && fabs(degrees.z) <= 1e5)) {
        sl_json_fail(json, sl_json_get(object, "rotate_deg"), "expected 'rotate_deg' from -100000 to 100000");
    }
    read_scale(json, sl_json_get(object, "scale"), positive, &key->scale);
    key->rotate = sl_quaternion_from_euler(sl_radians(degrees.x), sl_radians(degrees.y),
                                           sl_radians(degrees.z));
}

static sl_affine matrix_transform(sl_json *json, const cJSON *item) {
    double m[16];
    sl_affine a = sl_affine_identity();
    const char *expected = sl_json_numbers(json, item, 16, m) ? sl_matrix_fault(m, &a) : NULL;
    if (expected) sl_json_fail(json, item, "%s", expected);
    return a;
}

sl_affine sl_scene_file_transform(sl_scene_file *file, const cJSON *item) {
    if (!item || file->json.status != SL_OK) return sl_affine_identity();
    if (cJSON_IsArray(item)) return matrix_transform(&file->json, item);
    if (!SL_JSON_KEYS(&file->json, item, "a transform", "translate", "rotate_deg", "scale"))
        return sl_affine_identity();
    sl_key key = {0};
    read_placement(&file->json, item, false, &key);
    return sl_key_placement(&key);
}

/* ---- keyframes ------------------------------------------------------------------------------- */

typedef void read_key(sl_scene_file *file, const cJSON *item, sl_key *key);

/* Reads a track: objects with these keys whose times rise, and what `read` makes of each of them, from the
 * one before. */
static void read_track(sl_scene_file *file, const cJSON *list, sl_track track, sl_key state, read_key *read,
                       const char *const *names, size_t name_count) {
    sl_json *json = &file->json;
    sl_animation *a = file->animation;
    const size_t count = sl_json_array(json, list);
    if (list && count == 0) sl_json_fail(json, list, "expected at least one keyframe");
    if (count == 0) return;
    track.keys = sl_allocate(count, sizeof *track.keys);
    if (!track.keys || !sl_make_room(&a->tracks, a->track_count, &a->track_room, sizeof *a->tracks)) {
        json->status = sl_fail_memory(json->error, "keyframes");
        sl_free(track.keys);
        return;
    }
    double last = -INFINITY;
    for (const cJSON *item = list->child; item && json->status == SL_OK;
         item = item->next, last = state.time) {
        if (!sl_json_keys(json, item, "a keyframe", names, name_count)) break;
        sl_json_number(json, sl_json_need(json, item, "time"), -1e9, 1e9, &state.time);
        if (!(state.time > last))
            sl_json_fail(json, item,
                         "expected keyframes in the order of their times, each later than the one before");
        read(file, item, &state);
        track.keys[track.key_count++] = state;
    }
    a->tracks[a->track_count++] = track;
}

static void read_object_key(sl_scene_file *file, const cJSON *item, sl_key *key) {
    read_placement(&file->json, item, true, key);
}

void sl_scene_file_object_keys(sl_scene_file *file, const cJSON *list, uint32_t first_object,
                               uint32_t object_count) {
    static const char *const names[] = {"time", "translate", "rotate_deg", "scale"};
    const sl_track track = {.kind = SL_TRACK_OBJECTS, .first = first_object, .count = object_count};
    read_track(file, list, track, (sl_key){0}, read_object_key, names, 4);
}

static void read_light_key(sl_scene_file *file, const cJSON *item, sl_key *key) {
    sl_json *json = &file->json;
    const cJSON *direction = sl_json_get(item, "direction");
    sl_vec3d v;
    read_vector(file, sl_json_get(item, "position"), &key->position);
    if (!read_vector(file, direction, &v)) return;
    const double length = sl_lengthd(v);
    if (length > 0.0) key->direction = sl_scaled(v, 1.0 / length);
    else sl_json_fail(json, direction, "expected 'direction' to be other than 0");
}

/* Values that a key does not give stay as they were at the one before, or in the light itself. */
void sl_scene_file_light_keys(sl_scene_file *file, const cJSON *list, uint32_t light) {
    static const char *const names[] = {"time", "position", "direction"};
    const sl_light *rest = &file->model.scene.lights[light];
    const sl_key state = {.position = sl_to_double(rest->position),
                          .direction = sl_to_double(rest->direction)};
    const sl_track track = {.kind = SL_TRACK_LIGHT, .first = light, .count = 1};
    read_track(file, list, track, state, read_light_key, names, 3);
}

/* ---- camera ---------------------------------------------------------------------------------- */

static void read_camera(sl_scene_file *file, const cJSON *item, sl_key *key) {
    sl_json *json = &file->json;
    double degrees;
    read_vector(file, sl_json_get(item, "eye"), &key->position);
    read_vector(file, sl_json_get(item, "target"), &key->target);
    read_vector(file, sl_json_get(item, "up"), &key->up);
    if (sl_json_number(json, sl_json_get(item, "fov_deg"), SL_LEAST_FOV_DEG, SL_MOST_FOV_DEG,
                       &degrees))
        key->vertical_fov = sl_radians(degrees);
    sl_camera check;
    if (!sl_camera_look_at(&check, sl_to_float(key->position), sl_to_float(key->target), sl_to_float(key->up),
                           (float)key->vertical_fov)) {
        sl_json_fail(json, item, SL_EXPECTED_VIEW);
    }
}

static bool is_frame(const sl_camera *c) {
    const double least = 1.0 - 1e-5, most = 1e-5;
    const sl_vec3d x = sl_to_double(c->right), y = sl_to_double(c->up), z = sl_to_double(c->back);
    return fabs(sl_dotd(x, y)) < most && fabs(sl_dotd(y, z)) < most && fabs(sl_dotd(z, x)) < most &&
           sl_lengthd(x) > least && sl_lengthd(y) > least && sl_lengthd(z) > least &&
           fabs(sl_dotd(sl_crossd(x, y), z) - 1.0) < most;
}

/* Reads the camera's axes as they stand, in place of what they would be computed from. */
static void read_frame(sl_scene_file *file, const cJSON *item, const cJSON *frame) {
    sl_json *json = &file->json;
    sl_camera *c = &file->model.camera;
    sl_vec3 *const axes[] = {&c->right, &c->up, &c->back};
    sl_vec3d eye = {0, 0, 0};
    double m[9] = {0}, degrees = 45.0;
    if (sl_json_get(item, "target") || sl_json_get(item, "up") || sl_json_get(item, "keyframes"))
        sl_json_fail(json, frame, "expected no 'target', 'up' or 'keyframes' beside 'frame'");
    read_vector(file, sl_json_need(json, item, "eye"), &eye);
    sl_json_numbers(json, frame, 9, m);
    sl_json_number(json, sl_json_get(item, "fov_deg"), 0.0, 180.0, &degrees);
    c->eye = sl_to_float(eye);
    c->vertical_fov = (float)sl_radians(degrees);
    for (int i = 0; i < 3; i++)
        *axes[i] =
            sl_to_float(sl_affine_vector(&file->turn, sl_v3d(m[3 * i], m[3 * i + 1], m[3 * i + 2])));
    if (!is_frame(c))
        sl_json_fail(json, frame,
                     "expected 'frame' to be three unit vectors at right angles: right, up and back");
    file->model.has_camera = json->status == SL_OK;
}

/* A view of the caller's stands still, but the keys are checked. */
void sl_scene_file_camera(sl_scene_file *file, const cJSON *item) {
    static const char *const names[] = {"time", "eye", "target", "up", "fov_deg"};
    sl_json *json = &file->json;
    if (!item ||
        !SL_JSON_KEYS(json, item, "the camera", "eye", "target", "up", "fov_deg", "keyframes", "frame"))
        return;
    const cJSON *frame = sl_json_get(item, "frame");
    if (frame) {
        read_frame(file, item, frame);
        return;
    }
    sl_key state = {.up = {0, 1, 0}, .vertical_fov = sl_radians(45.0)};
    sl_json_need(json, item, "eye");
    sl_json_need(json, item, "target");
    read_camera(file, item, &state);
    if (json->status != SL_OK) return;
    file->model.has_camera =
        sl_camera_look_at(&file->model.camera, sl_to_float(state.position), sl_to_float(state.target),
                          sl_to_float(state.up), (float)state.vertical_fov);
    sl_animation *a = file->animation;
    const size_t tracks = a->track_count;
    read_track(file, sl_json_get(item, "keyframes"), (sl_track){.kind = SL_TRACK_CAMERA}, state, read_camera,
               names, 5);
    if (file->model.view && a->track_count > tracks) sl_free(a->tracks[--a->track_count].keys);
}
