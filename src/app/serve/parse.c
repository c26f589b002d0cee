#include "app/serve/parse.h"

#include "base/error.h"

#include <math.h>
#include <string.h>

static const double degree = 0.017453292519943295;

/* ---- values ---- */

void sl_malformed(sl_taking *t, const char *name, const char *expected) {
    if (t->status == SL_OK) t->status = sl_fail(t->error, SL_ERROR_INPUT, "%s: expected %s", name, expected);
}

sl_status sl_take_all(sl_taking *t, bool there, const char *name, const char *expected) {
    if (!there) sl_malformed(t, name, expected);
    return t->status;
}

static const cJSON *item_of(const sl_taking *t, const char *name) {
    return cJSON_GetObjectItemCaseSensitive(t->message, name);
}

bool sl_is_there(const sl_taking *t, const char *name) { return item_of(t, name) != NULL; }

static bool is_finite(const cJSON *item) { return cJSON_IsNumber(item) && fabs(item->valuedouble) <= 1e30; }

double sl_take_number(sl_taking *t, const char *name, double least, double most, double otherwise) {
    const cJSON *item = item_of(t, name);
    if (item && !is_finite(item)) sl_malformed(t, name, "a number");
    if (!item || t->status != SL_OK) return otherwise;
    if (item->valuedouble < least || item->valuedouble > most)
        t->status = sl_fail(t->error, SL_ERROR_USAGE, "%s: expected %g to %g", name, least, most);
    return item->valuedouble;
}

bool sl_take_flag(sl_taking *t, const char *name, bool otherwise) {
    const cJSON *item = item_of(t, name);
    if (item && !cJSON_IsBool(item)) sl_malformed(t, name, "true or false");
    return item ? cJSON_IsTrue(item) : otherwise;
}

const char *sl_take_text(sl_taking *t, const char *name, const char *otherwise) {
    const cJSON *item = item_of(t, name);
    const bool sound = !item || (cJSON_IsString(item) && strlen(item->valuestring) <= 200);
    if (!sound) sl_malformed(t, name, "a short text");
    return item && sound ? item->valuestring : otherwise;
}

/* Returns whether they are there; else they are left alone. */
static bool take_numbers(sl_taking *t, const char *name, size_t count, double *values) {
    const cJSON *list = item_of(t, name), *item;
    size_t i = 0;
    if (!list) return false;
    if (!cJSON_IsArray(list) || (size_t)cJSON_GetArraySize(list) != count)
        sl_malformed(t, name, "a list of numbers, of the right length");
    cJSON_ArrayForEach(item, list) if (!is_finite(item)) sl_malformed(t, name, "finite numbers");
    if (t->status != SL_OK) return false;
    cJSON_ArrayForEach(item, list) values[i++] = item->valuedouble;
    return true;
}

static bool take_floats(sl_taking *t, const char *name, float values[3]) {
    double numbers[3];
    const bool there = take_numbers(t, name, 3, numbers);
    for (int i = 0; i < 3 && there; i++) values[i] = (float)numbers[i];
    return there;
}

int sl_take_side(sl_taking *t) {
    const char *text = sl_take_text(t, "side", "a");
    if (strcmp(text, "a") != 0 && strcmp(text, "b") != 0) sl_malformed(t, "side", "\"a\" or \"b\"");
    return text[0] == 'b';
}

sl_status sl_take_pixel(sl_taking *t, const sl_settings *settings, int *x, int *y) {
    *x = (int)sl_take_number(t, "x", 0.0, settings->width - 1.0, 0.0);
    *y = (int)sl_take_number(t, "y", 0.0, settings->height - 1.0, 0.0);
    return sl_take_all(t, sl_is_there(t, "x") && sl_is_there(t, "y"), "x, y", "a pixel");
}

/* ---- the camera ---- */

sl_status sl_take_camera(sl_taking *t, const sl_scene *scene, sl_camera *camera) {
    const sl_camera *now = &scene->camera;
    float eye[3], target[3], up[3] = {now->up.x, now->up.y, now->up.z};
    const double fov_now = (double)now->vertical_fov / degree;
    const bool has_eye = take_floats(t, "eye", eye), has_target = take_floats(t, "target", target);
    take_floats(t, "up", up);
    const double fov = sl_take_number(t, "fov", 0.01, 179.0, fov_now);
    if (sl_take_all(t, has_eye && has_target, "camera", "an eye and a target") != SL_OK) return t->status;
    *camera = *now;
    const float radians = fabs(fov - fov_now) < 1e-5 ? now->vertical_fov : (float)(fov * degree);
    if (sl_camera_look_at(camera, sl_v3_of(eye), sl_v3_of(target), sl_v3_of(up), radians)) return SL_OK;
    return sl_fail(t->error, SL_ERROR_USAGE,
                   "camera: an eye at its target, or an up vector along the view");
}

/* ---- edits: into items that are 0 so far ---- */

static uint32_t take_index(sl_taking *t, const char *name, size_t count) {
    const double value = sl_take_number(t, name, 1.0, (double)count, 0.5);
    if (floor(value) != value) sl_malformed(t, name, "a number from 1");
    return t->status == SL_OK ? (uint32_t)value : 0;
}

/* Three rows of four to four columns of four. */
static sl_status take_object(sl_taking *t, const sl_world *w, sl_item *item) {
    double rows[12];
    item->number = take_index(t, "object", w->scene->object_count);
    item->kind = cJSON_IsNull(item_of(t, "matrix")) ? SL_ITEM_RELEASE : SL_ITEM_OBJECT;
    if (item->kind == SL_ITEM_RELEASE) return t->status;
    const bool there = take_numbers(t, "matrix", 12, rows);
    for (int k = 0; k < 16 && there; k++)
        item->to.columns[k] = k % 4 < 3 ? rows[4 * (k % 4) + k / 4] : k == 15 ? 1.0 : 0.0;
    return sl_take_all(t, there, "matrix", "twelve numbers");
}

static sl_status take_material(sl_taking *t, const sl_world *w, sl_item *item) {
    sl_material_data *m = &item->to.material;
    item->kind = SL_ITEM_MATERIAL;
    item->number = take_index(t, "material", w->scene->material_count);
    if (t->status != SL_OK) return t->status;
    sl_scene_material(w->scene, item->number, m);
    take_floats(t, "diffuse", m->diffuse);
    take_floats(t, "specular", m->specular);
    take_floats(t, "mirror", m->mirror);
    take_floats(t, "emission", m->emission);
    m->exponent = (float)sl_take_number(t, "exponent", 0.0, 1e6, (double)m->exponent);
    return t->status;
}

static void take_power(sl_taking *t, sl_light_item *l) {
    l->has_strength = take_floats(t, "power", l->strength);
    for (int i = 0; i < 3; i++)
        if (t->status == SL_OK && l->strength[i] < 0.0f)
            t->status = sl_fail(t->error, SL_ERROR_USAGE, "power: expected nothing below 0");
}

static sl_status take_light(sl_taking *t, const sl_world *w, sl_item *item) {
    sl_light_item *l = &item->to.light;
    item->kind = SL_ITEM_LIGHT;
    item->number = take_index(t, "light", w->scene->light_count);
    take_power(t, l);
    l->has_position = take_numbers(t, "position", 3, l->position);
    l->has_direction = take_numbers(t, "direction", 3, l->direction);
    const double scale = sl_take_number(t, "scale", 0.0, 1e6, 1.0);
    if (t->status != SL_OK || !sl_is_there(t, "scale")) return t->status;
    const sl_rgb now = w->scene->lights[item->number - 1].intensity;
    const float strength[3] = {now.r, now.g, now.b};
    for (int i = 0; i < 3; i++) l->strength[i] = (float)((double)strength[i] * scale);
    l->has_strength = true;
    return SL_OK;
}

static sl_status take_added_light(sl_taking *t, const sl_world *w, sl_item *item) {
    enum { LIGHTS = 256 };
    sl_light_item *l = &item->to.light;
    item->kind = SL_ITEM_ADD_LIGHT;
    take_power(t, l);
    l->has_position = take_numbers(t, "position", 3, l->position);
    if (!l->has_position || !l->has_strength) sl_malformed(t, "add-light", "a position and a power");
    if (t->status == SL_OK && w->scene->light_count >= LIGHTS)
        return sl_fail(t->error, SL_ERROR_USAGE, "add-light: there are %d lights, which are the most",
                       LIGHTS);
    return t->status;
}

static sl_status take_removed_light(sl_taking *t, const sl_world *w, sl_item *item) {
    item->kind = SL_ITEM_LIGHT;
    item->to.light.has_strength = true;
    item->number = take_index(t, "light", w->scene->light_count);
    return t->status;
}

static sl_status take_sky(sl_taking *t, const sl_world *w, sl_item *item) {
    item->kind = SL_ITEM_SKY;
    item->to.stops = sl_take_number(t, "stops", -32.0, 32.0, 0.0);
    sl_take_all(t, sl_is_there(t, "stops"), "stops", "a number");
    if (t->status == SL_OK && !w->scene->environment.present && w->stops == 0.0)
        return sl_fail(t->error, SL_ERROR_USAGE, "sky: the scene has none");
    return t->status;
}

static sl_status take_sun(sl_taking *t, const sl_world *w, sl_item *item) {
    const sl_scene *s = w->scene;
    sl_light_item *l = &item->to.light;
    float brightest = -1.0f;
    item->kind = SL_ITEM_LIGHT;
    for (size_t i = 0; i < s->light_count; i++) {
        const float power = sl_rgb_max(s->lights[i].intensity);
        if (s->lights[i].type != SL_LIGHT_DIRECTIONAL || power <= brightest) continue;
        item->number = (uint32_t)i + 1;
        brightest = power;
    }
    if (brightest < 0.0f)
        return sl_fail(t->error, SL_ERROR_USAGE, "sun: the scene has no directional light");
    l->has_direction = take_numbers(t, "direction", 3, l->direction);
    return sl_take_all(t, l->has_direction, "direction", "three numbers");
}

static const struct {
    const char *kind;
    sl_status (*take)(sl_taking *t, const sl_world *world, sl_item *item);
} edits[] = {{"object", take_object},
             {"material", take_material},
             {"light", take_light},
             {"add-light", take_added_light},
             {"remove-light", take_removed_light},
             {"sky", take_sky},
             {"sun", take_sun}};
enum { EDITS = sizeof edits / sizeof edits[0] };

static sl_status take_edit(sl_taking *t, const sl_world *w, sl_item *item) {
    memset(item, 0, sizeof *item);
    if (!cJSON_IsObject(t->message)) return sl_take_all(t, false, "edits", "objects");
    const char *kind = sl_take_text(t, "kind", "");
    for (int i = 0; i < EDITS; i++)
        if (strcmp(edits[i].kind, kind) == 0) return edits[i].take(t, w, item);
    return sl_take_all(t, false, "kind", "a kind of edit");
}

sl_status sl_take_edits(sl_taking *t, const sl_world *w, sl_item *items, size_t *count) {
    const cJSON *list = item_of(t, "edits"), *edit;
    *count = 0;
    if (!cJSON_IsArray(list) || !list->child || cJSON_GetArraySize(list) > SL_ITEMS)
        return sl_take_all(t, false, "edits", "a list of 1 to 16");
    cJSON_ArrayForEach(edit, list) {
        sl_taking one = {edit, t->error, t->status};
        t->status = take_edit(&one, w, &items[*count]);
        if (t->status != SL_OK) return t->status;
        ++*count;
    }
    return SL_OK;
}
