/* Scene files: where things are, and how they move. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/scene_file.h"

double sl_scene_file_radians(double degrees) { return degrees * (SL_PI / 180.0); }

sl_vec3 sl_scene_file_point(const sl_scene_file *file, sl_vec3d p) {
    return sl_to_float(sl_affine_vector(&file->turn, p));
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

static void read_placement(sl_json *json, const cJSON *object, bool positive, sl_object_key *key) {
    sl_vec3d degrees = {0, 0, 0};
    key->scale = sl_v3d(1, 1, 1);
    key->translate = sl_v3d(0, 0, 0);
    sl_json_vec3(json, sl_json_get(object, "translate"), &key->translate);
    if (sl_json_vec3(json, sl_json_get(object, "rotate_deg"), &degrees) &&
        !(fabs(degrees.x) <= 1e5 && fabs(degrees.y) <= 1e5 && fabs(degrees.z) <= 1e5)) {
        sl_json_fail(json, sl_json_get(object, "rotate_deg"), "expected 'rotate_deg' from -100000 to 100000");
    }
    read_scale(json, sl_json_get(object, "scale"), positive, &key->scale);
    key->rotate = sl_quaternion_from_euler(sl_scene_file_radians(degrees.x), sl_scene_file_radians(degrees.y),
                                           sl_scene_file_radians(degrees.z));
}

static sl_affine matrix_transform(sl_json *json, const cJSON *item) {
    double m[16];
    sl_affine a = sl_affine_identity();
    if (!sl_json_numbers(json, item, 16, m)) return a;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) a.m[i][j] = m[4 * j + i];
    }
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
        sl_json_fail(json, item,
                     "expected 'transform' by columns, its bottom row (every fourth number) 0 0 0 1");
    } else if (!(fabs(sl_affine_determinant(&a)) > 0.0)) {
        sl_json_fail(json, item, "expected 'transform' to be a matrix that can be inverted");
    }
    return a;
}

sl_affine sl_scene_file_transform(sl_scene_file *file, const cJSON *item) {
    if (!item || file->json.status != SL_OK) return sl_affine_identity();
    if (cJSON_IsArray(item)) return matrix_transform(&file->json, item);
    if (!SL_JSON_KEYS(&file->json, item, "a transform", "translate", "rotate_deg", "scale"))
        return sl_affine_identity();
    sl_object_key key = {0};
    read_placement(&file->json, item, false, &key);
    return sl_object_track_at(&(sl_object_track){.key_count = 1, .keys = &key}, 0.0);
}

/* ---- keyframes ------------------------------------------------------------------------------- */

/* Returns how many keyframes there are; they must be objects with these keys, and their times must rise. */
static size_t check_keyframes(sl_json *json, const cJSON *list, const char *const *keys, size_t key_count) {
    size_t count = sl_json_array(json, list);
    if (list && count == 0) sl_json_fail(json, list, "expected at least one keyframe");
    double last = -INFINITY;
    for (const cJSON *item = count ? list->child : NULL; item && json->status == SL_OK; item = item->next) {
        double time = 0.0;
        if (!sl_json_keys(json, item, "a keyframe", keys, key_count)) break;
        sl_json_number(json, sl_json_need(json, item, "time"), -1e9, 1e9, &time);
        if (!(time > last))
            sl_json_fail(json, item,
                         "expected keyframes in the order of their times, each later than the one before");
        last = time;
    }
    return json->status == SL_OK ? count : 0;
}

static void out_of_memory(sl_json *json) {
    if (json->status == SL_OK) json->status = sl_fail_memory(json->error, "keyframes");
}

/* One more entry at the end of a list, whose room is the next power of two. */
static void *append(sl_json *json, void *list, size_t *count, size_t size) {
    if (*count & (*count - 1)) {
        (*count)++;
        return list;
    }
    char *longer = sl_allocate(*count ? 2 * *count : 1, size);
    if (!longer) {
        out_of_memory(json);
        return list;
    }
    if (*count) memcpy(longer, list, *count * size);
    sl_free(list);
    (*count)++;
    return longer;
}

void sl_scene_file_object_keys(sl_scene_file *file, const cJSON *list, uint32_t first_object,
                               uint32_t object_count) {
    static const char *const keys[] = {"time", "translate", "rotate_deg", "scale"};
    sl_json *json = &file->json;
    sl_animation *a = file->animation;
    size_t count = check_keyframes(json, list, keys, 4);
    if (count == 0) return;
    a->object_tracks = append(json, a->object_tracks, &a->object_track_count, sizeof *a->object_tracks);
    if (json->status != SL_OK) return;
    sl_object_track *track = &a->object_tracks[a->object_track_count - 1];
    *track = (sl_object_track){first_object, object_count, 0, sl_allocate(count, sizeof *track->keys)};
    if (!track->keys) {
        out_of_memory(json);
        return;
    }
    for (const cJSON *item = list->child; item; item = item->next) {
        sl_object_key *key = &track->keys[track->key_count++];
        sl_json_number(json, sl_json_get(item, "time"), -1e9, 1e9, &key->time);
        read_placement(json, item, true, key);
    }
}

/* Reads a light's keyframes: what one does not give stays as it was at the one before (or in the light
 * itself). */
void sl_scene_file_light_keys(sl_scene_file *file, const cJSON *list, uint32_t light) {
    static const char *const keys[] = {"time", "position", "direction"};
    sl_json *json = &file->json;
    sl_animation *a = file->animation;
    size_t count = check_keyframes(json, list, keys, 3);
    if (count == 0) return;
    a->light_tracks = append(json, a->light_tracks, &a->light_track_count, sizeof *a->light_tracks);
    if (json->status != SL_OK) return;
    sl_light_track *track = &a->light_tracks[a->light_track_count - 1];
    *track = (sl_light_track){light, 0, sl_allocate(count, sizeof *track->keys)};
    if (!track->keys) {
        out_of_memory(json);
        return;
    }
    const sl_light *rest = &file->model.scene.lights[light];
    sl_light_key state = {0.0, sl_to_double(rest->position), sl_to_double(rest->direction)};
    for (const cJSON *item = list->child; item; item = item->next) {
        sl_vec3d v;
        sl_json_number(json, sl_json_get(item, "time"), -1e9, 1e9, &state.time);
        if (sl_json_vec3(json, sl_json_get(item, "position"), &v))
            state.position = sl_affine_vector(&file->turn, v);
        if (sl_json_vec3(json, sl_json_get(item, "direction"), &v)) {
            double length = sl_lengthd(v);
            if (!(length > 0.0))
                sl_json_fail(json, sl_json_get(item, "direction"), "expected 'direction' to be other than 0");
            else state.direction = sl_affine_vector(&file->turn, sl_scaled(v, 1.0 / length));
        }
        track->keys[track->key_count++] = state;
    }
}

/* ---- camera ---------------------------------------------------------------------------------- */

static void read_camera(sl_scene_file *file, const cJSON *item, sl_camera_key *key) {
    sl_json *json = &file->json;
    sl_vec3d v;
    double degrees;
    if (sl_json_vec3(json, sl_json_get(item, "eye"), &v)) key->eye = sl_affine_vector(&file->turn, v);
    if (sl_json_vec3(json, sl_json_get(item, "target"), &v)) key->target = sl_affine_vector(&file->turn, v);
    if (sl_json_vec3(json, sl_json_get(item, "up"), &v)) key->up = sl_affine_vector(&file->turn, v);
    if (sl_json_number(json, sl_json_get(item, "fov_deg"), 0.01, 179.0, &degrees))
        key->vertical_fov = sl_scene_file_radians(degrees);
    sl_camera check;
    if (!sl_camera_look_at(&check, sl_to_float(key->eye), sl_to_float(key->target), sl_to_float(key->up),
                           (float)key->vertical_fov)) {
        sl_json_fail(json, item,
                     "expected the camera's 'eye' apart from its 'target', and 'up' not along the view");
    }
}

void sl_scene_file_camera(sl_scene_file *file, const cJSON *item) {
    static const char *const keys[] = {"time", "eye", "target", "up", "fov_deg"};
    sl_json *json = &file->json;
    if (!item || !SL_JSON_KEYS(json, item, "the camera", "eye", "target", "up", "fov_deg", "keyframes"))
        return;
    sl_camera_key state = {.up = {0, 1, 0}, .vertical_fov = sl_scene_file_radians(45.0)};
    sl_json_need(json, item, "eye");
    sl_json_need(json, item, "target");
    read_camera(file, item, &state);
    if (json->status != SL_OK) return;
    file->model.has_camera =
        sl_camera_look_at(&file->model.camera, sl_to_float(state.eye), sl_to_float(state.target),
                          sl_to_float(state.up), (float)state.vertical_fov);
    const cJSON *list = sl_json_get(item, "keyframes");
    size_t count = check_keyframes(json, list, keys, 5);
    if (count == 0) return;
    sl_animation *a = file->animation;
    a->camera_keys = sl_allocate(count, sizeof *a->camera_keys);
    if (!a->camera_keys) out_of_memory(json);
    for (const cJSON *key = list->child; key && json->status == SL_OK; key = key->next) {
        sl_json_number(json, sl_json_get(key, "time"), -1e9, 1e9, &state.time);
        read_camera(file, key, &state);
        a->camera_keys[a->camera_key_count++] = state;
    }
    if (file->model.view) a->camera_key_count = 0; /* that camera stands still */
}
