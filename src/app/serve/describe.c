/* What there is, as messages. */
#include "app/serve/stage_parts.h"

#include "cache/frame/method.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degrees = 57.29577951308232;

void sl_add_numbers(cJSON *to, const char *name, const double *values, int count) {
    cJSON_AddItemToObject(to, name, cJSON_CreateDoubleArray(values, count));
}

void sl_add_floats(cJSON *to, const char *name, const float *values, int count) {
    cJSON *list = cJSON_AddArrayToObject(to, name);
    for (int i = 0; i < count; i++) cJSON_AddItemToArray(list, cJSON_CreateNumber((double)values[i]));
}

static void add_vector(cJSON *to, const char *name, sl_vec3 v) {
    sl_add_floats(to, name, (float[]){v.x, v.y, v.z}, 3);
}
static void add_colour(cJSON *to, const char *name, sl_rgb c) {
    sl_add_floats(to, name, (float[]){c.r, c.g, c.b}, 3);
}

/* ---- the camera ---- */

/* It looks at the middle of the scene as far as that lies ahead. */
static void add_camera(cJSON *to, const sl_scene *s) {
    const sl_camera *c = &s->camera;
    const sl_vec3 middle = sl_scale(sl_add(s->central_min, s->central_max), 0.5f);
    float ahead = -sl_dot(sl_sub(middle, c->eye), c->back);
    if (!(ahead > 0.05f * s->scale)) ahead = 0.25f * s->scale;
    add_vector(to, "eye", c->eye);
    add_vector(to, "target", sl_sub(c->eye, sl_scale(c->back, ahead)));
    add_vector(to, "up", c->up);
    cJSON_AddNumberToObject(to, "fov", (double)c->vertical_fov * degrees);
}

cJSON *sl_describe_camera(const sl_stage *stage) {
    cJSON *m = sl_message("camera");
    add_camera(m, stage->world.scene);
    cJSON_AddNumberToObject(m, "time", stage->world.time);
    return m;
}

/* ---- the scene ---- */

typedef struct object_box {
    sl_box box;
    uint32_t material;
    bool any;
} object_box;

static object_box *boxes_of(const sl_scene *s) {
    object_box *boxes = calloc(s->object_count + 1, sizeof *boxes);
    for (size_t t = 0; boxes && t < s->triangle_count; t++) {
        object_box *b = &boxes[s->object_index[t]];
        if (!b->any) *b = (object_box){sl_box_empty(), s->material_index[t], true};
        for (int k = 0; k < 3; k++) sl_box_add(&b->box, sl_scene_position(s, s->vertex[k][t]));
    }
    return boxes;
}

static cJSON *object_of(const sl_world *w, size_t i, const object_box *b) {
    const sl_vec3 low = b->box.low, high = b->box.high;
    cJSON *o = cJSON_CreateObject();
    double columns[16], rows[12];
    sl_scene_transform(w->scene, (uint32_t)i + 1, columns);
    for (int k = 0; k < 12; k++) rows[k] = columns[4 * (k % 4) + k / 4];
    cJSON_AddNumberToObject(o, "object", (double)i + 1);
    cJSON_AddStringToObject(o, "name", w->scene->object_names[i]);
    cJSON_AddNumberToObject(o, "material", b->material + 1);
    sl_add_floats(o, "bounds", (float[]){low.x, low.y, low.z, high.x, high.y, high.z}, 6);
    add_vector(o, "centre", sl_scale(sl_add(low, high), 0.5f));
    sl_add_numbers(o, "matrix", rows, 12);
    return o;
}

enum { LISTED = 1000 }; /* of a scene's thousands of objects or materials the first */

static void add_objects(cJSON *to, const sl_world *w) {
    cJSON *list = cJSON_AddArrayToObject(to, "objects");
    object_box *boxes = boxes_of(w->scene);
    for (size_t i = 0; boxes && i < w->scene->object_count && i < LISTED; i++)
        if (boxes[i].any) cJSON_AddItemToArray(list, object_of(w, i, &boxes[i]));
    free(boxes);
}

static void add_materials(cJSON *to, const sl_scene *s) {
    cJSON *list = cJSON_AddArrayToObject(to, "materials");
    for (size_t i = 0; i < s->material_count && i < LISTED; i++) {
        const sl_material *m = &s->materials[i];
        cJSON *o = cJSON_CreateObject();
        cJSON_AddNumberToObject(o, "material", (double)i + 1);
        cJSON_AddStringToObject(o, "name", m->name);
        add_colour(o, "diffuse", m->diffuse);
        add_colour(o, "specular", m->specular);
        add_colour(o, "mirror", m->mirror);
        add_colour(o, "emission", m->emission);
        cJSON_AddNumberToObject(o, "exponent", (double)m->exponent);
        cJSON_AddBoolToObject(o, "textured", m->texture != SL_NO_INDEX);
        cJSON_AddItemToArray(list, o);
    }
}

static void add_lights(cJSON *to, const sl_scene *s) {
    static const char *const types[] = {"point", "spot", "directional"};
    cJSON *list = cJSON_AddArrayToObject(to, "lights");
    for (size_t i = 0; i < s->light_count && i < LISTED; i++) {
        const sl_light *l = &s->lights[i];
        cJSON *o = cJSON_CreateObject();
        cJSON_AddNumberToObject(o, "light", (double)i + 1);
        cJSON_AddStringToObject(o, "type", types[l->type]);
        if (l->type != SL_LIGHT_DIRECTIONAL) add_vector(o, "position", l->position);
        if (l->type != SL_LIGHT_POINT) add_vector(o, "direction", l->direction);
        add_colour(o, "power", l->intensity);
        cJSON_AddItemToArray(list, o);
    }
}

static void add_scene(cJSON *m, const sl_stage *stage) {
    const sl_world *w = &stage->world;
    const sl_scene *s = w->scene;
    const char *slash = strrchr(w->path, '/');
    cJSON_AddStringToObject(m, "name", slash ? slash + 1 : w->path);
    cJSON_AddNumberToObject(m, "triangles", (double)s->triangle_count);
    add_camera(cJSON_AddObjectToObject(m, "camera"), s);
    cJSON_AddNumberToObject(m, "time", w->time);
    cJSON_AddNumberToObject(m, "duration", w->duration);
    cJSON_AddBoolToObject(m, "plays", stage->plays);
    add_objects(m, w);
    add_materials(m, s);
    add_lights(m, s);
    cJSON *sky = cJSON_AddObjectToObject(m, "sky");
    cJSON_AddBoolToObject(sky, "present", s->environment.present);
    cJSON_AddNumberToObject(sky, "stops", w->stops);
    cJSON_AddNumberToObject(m, "undo", (double)(w->undo_count - w->undone));
    cJSON_AddNumberToObject(m, "redo", (double)w->undone);
}

cJSON *sl_describe_scene(const sl_stage *stage) {
    cJSON *m = sl_message("scene");
    add_scene(m, stage);
    return m;
}

cJSON *sl_describe_changes(unsigned changes) {
    static const char *const names[SL_CHANGES] = {"camera",    "objects", "lights", "power",
                                                  "materials", "sky",     "kinds"};
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; i < SL_CHANGES; i++)
        if (changes >> i & 1u) cJSON_AddItemToArray(list, cJSON_CreateString(names[i]));
    return list;
}

/* ---- settings ---- */

cJSON *sl_describe_settings(const sl_settings *settings) {
    const sl_settings plain = sl_settings_default();
    cJSON *o = cJSON_CreateObject();
    const sl_setting *row;
    for (size_t i = 0; (row = sl_setting_at(i)) != NULL; i++) {
        char value[64], otherwise[64];
        if (strcmp(row->name, "method") == 0 || strcmp(row->name, "size") == 0) continue;
        sl_settings_get(settings, row->name, value, sizeof value, NULL);
        sl_settings_get(&plain, row->name, otherwise, sizeof otherwise, NULL);
        if (strcmp(value, otherwise) != 0) cJSON_AddStringToObject(o, row->name, value);
    }
    return o;
}

static cJSON *setting_of(const sl_setting *row) {
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", row->name);
    cJSON_AddStringToObject(o, "methods", row->methods);
    cJSON_AddStringToObject(o, "unit", row->unit);
    cJSON_AddStringToObject(o, "symbol", row->symbol);
    cJSON_AddStringToObject(o, "help", row->help);
    if (row->maximum > row->minimum) {
        cJSON_AddNumberToObject(o, "minimum", row->minimum);
        cJSON_AddNumberToObject(o, "maximum", row->maximum);
    }
    if (row->otherwise) cJSON_AddStringToObject(o, "otherwise", row->otherwise);
    else sl_add_numbers(o, "default", row->by_quality, 3);
    cJSON_AddBoolToObject(o, "everyday", row->everyday);
    return o;
}

cJSON *sl_describe_hello(const sl_stage *stage) {
    cJSON *m = sl_message("hello"), *list = cJSON_AddArrayToObject(m, "methods");
    cJSON_AddStringToObject(m, "version", SL_VERSION);
    cJSON_AddItemToObject(
        m, "size",
        cJSON_CreateIntArray((const int[]){stage->side[0].settings.width, stage->side[0].settings.height},
                             2));
    for (size_t i = 0; sl_method_name(i); i++)
        cJSON_AddItemToArray(list, cJSON_CreateString(sl_method_name(i)));
    list = cJSON_AddArrayToObject(m, "settings");
    for (size_t i = 0; sl_setting_at(i); i++) cJSON_AddItemToArray(list, setting_of(sl_setting_at(i)));
    cJSON *sides = cJSON_AddObjectToObject(m, "sides");
    for (int i = 0; i < SL_SIDES; i++)
        cJSON_AddStringToObject(sides, sl_side_name(i),
                                stage->side[i].wanted ? stage->side[i].settings.method : "");
    cJSON *tone = cJSON_AddObjectToObject(m, "tone");
    cJSON_AddNumberToObject(tone, "exposure", (double)stage->tone.exposure_stops);
    cJSON_AddStringToObject(tone, "curve", stage->tone.curve == SL_TONE_CLIP ? "clip" : "reinhard");
    cJSON_AddBoolToObject(tone, "auto", stage->tone.automatic);
    cJSON_AddNumberToObject(m, "event", (double)stage->world.count);
    add_scene(cJSON_AddObjectToObject(m, "scene"), stage);
    return m;
}
