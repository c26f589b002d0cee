#include "app/serve/parse.h"

#include "base/error.h"

#include <math.h>
#include <string.h>

static const double degree = 0.017453292519943295;

/* ---- values ---- */

static sl_status malformed(const char *name, const char *expected, sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "%s: expected %s", name, expected);
}

static const cJSON *item_of(const cJSON *message, const char *name, bool *there) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(message, name);
    if (there) *there = item != NULL;
    return item;
}

static bool is_finite(const cJSON *item) { return cJSON_IsNumber(item) && fabs(item->valuedouble) <= 1e30; }

sl_status sl_take_number(const cJSON *message, const char *name, double least, double most, double *value,
                         bool *there, sl_error *error) {
    const cJSON *item = item_of(message, name, there);
    if (!item) return SL_OK;
    if (!is_finite(item)) return malformed(name, "a number", error);
    if (item->valuedouble < least || item->valuedouble > most)
        return sl_fail(error, SL_ERROR_USAGE, "%s: expected %g to %g", name, least, most);
    *value = item->valuedouble;
    return SL_OK;
}

sl_status sl_take_flag(const cJSON *message, const char *name, bool *value, sl_error *error) {
    const cJSON *item = item_of(message, name, NULL);
    if (!item) return SL_OK;
    if (!cJSON_IsBool(item)) return malformed(name, "true or false", error);
    *value = cJSON_IsTrue(item);
    return SL_OK;
}

sl_status sl_take_text(const cJSON *message, const char *name, const char **value, sl_error *error) {
    const cJSON *item = item_of(message, name, NULL);
    if (!item) return SL_OK;
    if (!cJSON_IsString(item) || strlen(item->valuestring) > 200)
        return malformed(name, "a short text", error);
    *value = item->valuestring;
    return SL_OK;
}

sl_status sl_take_numbers(const cJSON *message, const char *name, size_t count, double *values, bool *there,
                          sl_error *error) {
    const cJSON *list = item_of(message, name, there), *item;
    size_t i = 0;
    if (!list) return SL_OK;
    if (!cJSON_IsArray(list) || (size_t)cJSON_GetArraySize(list) != count)
        return malformed(name, "a list of numbers, of the right length", error);
    cJSON_ArrayForEach(item, list) {
        if (!is_finite(item)) return malformed(name, "finite numbers", error);
        values[i++] = item->valuedouble;
    }
    return SL_OK;
}

sl_status sl_take_side(const cJSON *message, int *side, sl_error *error) {
    const char *text = "a";
    sl_status status = sl_take_text(message, "side", &text, error);
    *side = text[0] == 'b';
    if (status == SL_OK && strcmp(text, "a") != 0 && strcmp(text, "b") != 0)
        status = malformed("side", "\"a\" or \"b\"", error);
    return status;
}

sl_status sl_take_pixel(const cJSON *message, const sl_settings *settings, double *x, double *y,
                        sl_error *error) {
    bool there[2] = {false, false};
    sl_status status = sl_take_number(message, "x", 0.0, settings->width - 1.0, x, &there[0], error);
    if (status == SL_OK)
        status = sl_take_number(message, "y", 0.0, settings->height - 1.0, y, &there[1], error);
    if (status == SL_OK && !(there[0] && there[1])) status = malformed("x, y", "a pixel", error);
    *x = floor(*x), *y = floor(*y);
    return status;
}

static sl_status take_floats(const cJSON *message, const char *name, float values[3], bool *there,
                             sl_error *error) {
    double numbers[3] = {0.0, 0.0, 0.0};
    bool given = false;
    sl_status status = sl_take_numbers(message, name, 3, numbers, &given, error);
    for (int i = 0; i < 3 && status == SL_OK && given; i++) values[i] = (float)numbers[i];
    if (there) *there = given;
    return status;
}

/* ---- the camera ---- */

sl_status sl_take_camera(const cJSON *message, const sl_scene *scene, sl_camera *camera, sl_error *error) {
    const sl_camera *now = &scene->camera;
    float eye[3], target[3], up[3] = {now->up.x, now->up.y, now->up.z};
    double fov = (double)now->vertical_fov / degree;
    bool has_eye = false, has_target = false;
    sl_status status = take_floats(message, "eye", eye, &has_eye, error);
    if (status == SL_OK) status = take_floats(message, "target", target, &has_target, error);
    if (status == SL_OK) status = take_floats(message, "up", up, NULL, error);
    if (status == SL_OK) status = sl_take_number(message, "fov", 0.01, 179.0, &fov, NULL, error);
    if (status != SL_OK) return status;
    if (!has_eye || !has_target) return malformed("camera", "an eye and a target", error);
    *camera = *now;
    const float radians =
        fabs(fov - (double)now->vertical_fov / degree) < 1e-5 ? now->vertical_fov : (float)(fov * degree);
    if (sl_camera_look_at(camera, sl_v3(eye[0], eye[1], eye[2]), sl_v3(target[0], target[1], target[2]),
                          sl_v3(up[0], up[1], up[2]), radians))
        return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE, "camera: an eye at its target, or an up vector along the view");
}

/* ---- edits ---- */

static sl_status take_index(const cJSON *edit, const char *name, size_t count, uint32_t *number,
                            sl_error *error) {
    double value = 0.0;
    bool there = false;
    sl_status status = sl_take_number(edit, name, 1.0, (double)count, &value, &there, error);
    if (status == SL_OK && (!there || floor(value) != value))
        status = malformed(name, "a number from 1", error);
    if (status == SL_OK) *number = (uint32_t)value;
    return status;
}

/* Three rows of four to four columns of four. */
static sl_status take_object(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    double rows[12];
    bool there = false;
    item->kind = SL_ITEM_OBJECT;
    sl_status status = take_index(edit, "object", w->scene->object_count, &item->number, error);
    if (cJSON_IsNull(item_of(edit, "matrix", NULL))) {
        item->kind = SL_ITEM_RELEASE;
        return status;
    }
    if (status == SL_OK) status = sl_take_numbers(edit, "matrix", 12, rows, &there, error);
    if (status == SL_OK && !there) status = malformed("matrix", "twelve numbers", error);
    for (int k = 0; k < 16 && status == SL_OK; k++)
        item->to.columns[k] = k % 4 < 3 ? rows[4 * (k % 4) + k / 4] : k == 15 ? 1.0 : 0.0;
    return status;
}

static sl_status take_material(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    sl_material_data *m = &item->to.material;
    const struct {
        const char *name;
        float *values;
    } colours[] = {
        {"diffuse", m->diffuse}, {"specular", m->specular}, {"mirror", m->mirror}, {"emission", m->emission}};
    item->kind = SL_ITEM_MATERIAL;
    sl_status status = take_index(edit, "material", w->scene->material_count, &item->number, error);
    if (status != SL_OK) return status;
    sl_scene_material(w->scene, item->number, m);
    double exponent = (double)m->exponent;
    for (size_t i = 0; i < sizeof colours / sizeof colours[0] && status == SL_OK; i++)
        status = take_floats(edit, colours[i].name, colours[i].values, NULL, error);
    if (status == SL_OK) status = sl_take_number(edit, "exponent", 0.0, 1e6, &exponent, NULL, error);
    m->exponent = (float)exponent;
    return status;
}

static sl_status take_power(const cJSON *edit, sl_light_item *l, sl_error *error) {
    sl_status status = take_floats(edit, "power", l->strength, &l->has_strength, error);
    for (int i = 0; i < 3 && status == SL_OK && l->has_strength; i++)
        if (l->strength[i] < 0.0f) status = sl_fail(error, SL_ERROR_USAGE, "power: expected nothing below 0");
    return status;
}

static sl_status take_light(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    sl_light_item *l = &item->to.light;
    double scale = 1.0;
    bool scales = false;
    *l = (sl_light_item){.has_strength = false};
    item->kind = SL_ITEM_LIGHT;
    sl_status status = take_index(edit, "light", w->scene->light_count, &item->number, error);
    if (status == SL_OK) status = take_power(edit, l, error);
    if (status == SL_OK) status = sl_take_numbers(edit, "position", 3, l->position, &l->has_position, error);
    if (status == SL_OK)
        status = sl_take_numbers(edit, "direction", 3, l->direction, &l->has_direction, error);
    if (status == SL_OK) status = sl_take_number(edit, "scale", 0.0, 1e6, &scale, &scales, error);
    if (status != SL_OK || !scales) return status;
    const sl_rgb now = w->scene->lights[item->number - 1].intensity;
    const float strength[3] = {now.r, now.g, now.b};
    for (int i = 0; i < 3; i++) l->strength[i] = (float)((double)strength[i] * scale);
    l->has_strength = true;
    return SL_OK;
}

static sl_status take_added_light(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    enum { LIGHTS = 256 };
    sl_light_item *l = &item->to.light;
    *l = (sl_light_item){.has_strength = false};
    item->kind = SL_ITEM_ADD_LIGHT;
    sl_status status = take_power(edit, l, error);
    if (status == SL_OK) status = sl_take_numbers(edit, "position", 3, l->position, &l->has_position, error);
    if (status == SL_OK && (!l->has_position || !l->has_strength))
        status = malformed("add-light", "a position and a power", error);
    if (status == SL_OK && w->scene->light_count >= LIGHTS)
        status = sl_fail(error, SL_ERROR_USAGE, "add-light: there are %d lights, which are the most", LIGHTS);
    return status;
}

static sl_status take_removed_light(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    item->kind = SL_ITEM_LIGHT;
    item->to.light = (sl_light_item){.has_strength = true};
    return take_index(edit, "light", w->scene->light_count, &item->number, error);
}

static sl_status take_sky(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    bool there = false;
    item->kind = SL_ITEM_SKY;
    sl_status status = sl_take_number(edit, "stops", -32.0, 32.0, &item->to.stops, &there, error);
    if (status == SL_OK && !there) status = malformed("stops", "a number", error);
    if (status == SL_OK && !w->scene->environment.present && w->stops == 0.0)
        status = sl_fail(error, SL_ERROR_USAGE, "sky: the scene has none");
    return status;
}

static sl_status take_sun(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    const sl_scene *s = w->scene;
    sl_light_item *l = &item->to.light;
    float brightest = -1.0f;
    item->kind = SL_ITEM_LIGHT;
    *l = (sl_light_item){.has_strength = false};
    for (size_t i = 0; i < s->light_count; i++) {
        const float power = sl_rgb_max(s->lights[i].intensity);
        if (s->lights[i].type != SL_LIGHT_DIRECTIONAL || power <= brightest) continue;
        item->number = (uint32_t)i + 1;
        brightest = power;
    }
    if (brightest < 0.0f) return sl_fail(error, SL_ERROR_USAGE, "sun: the scene has no directional light");
    sl_status status = sl_take_numbers(edit, "direction", 3, l->direction, &l->has_direction, error);
    return status == SL_OK && !l->has_direction ? malformed("direction", "three numbers", error) : status;
}

static const struct {
    const char *kind;
    sl_status (*take)(const cJSON *edit, const sl_world *world, sl_item *item, sl_error *error);
} edits[] = {{"object", take_object},
             {"material", take_material},
             {"light", take_light},
             {"add-light", take_added_light},
             {"remove-light", take_removed_light},
             {"sky", take_sky},
             {"sun", take_sun}};
enum { EDITS = sizeof edits / sizeof edits[0] };

static sl_status take_edit(const cJSON *edit, const sl_world *w, sl_item *item, sl_error *error) {
    const char *kind = "";
    *item = (sl_item){.number = 0};
    if (!cJSON_IsObject(edit)) return malformed("edits", "objects", error);
    sl_status status = sl_take_text(edit, "kind", &kind, error);
    for (int i = 0; i < EDITS && status == SL_OK; i++)
        if (strcmp(edits[i].kind, kind) == 0) return edits[i].take(edit, w, item, error);
    return status == SL_OK ? malformed("kind", "a kind of edit", error) : status;
}

sl_status sl_take_edits(const cJSON *message, const sl_world *w, sl_item *items, size_t *count,
                        sl_error *error) {
    const cJSON *list = item_of(message, "edits", NULL), *edit;
    sl_status status = SL_OK;
    *count = 0;
    if (!cJSON_IsArray(list) || !list->child || cJSON_GetArraySize(list) > SL_ITEMS)
        return malformed("edits", "a list of 1 to 16", error);
    cJSON_ArrayForEach(edit, list) {
        status = take_edit(edit, w, &items[*count], error);
        if (status != SL_OK) return status;
        ++*count;
    }
    return status;
}
