/* What a pixel shows: a lamp without extent that is seen there or right beside, an object, or the sky. */
#include "app/serve/stage_parts.h"

#include "base/error.h"

#include <math.h>

sl_status sl_stage_needs_tracer(sl_stage *s, sl_error *error) {
    return s->tracer ? SL_OK : sl_tracer_create(s->world.scene, 1, NULL, &s->tracer, error);
}

void sl_stage_forget_tracer(sl_stage *s) {
    sl_tracer_destroy(s->tracer);
    s->tracer = NULL;
}

sl_mark_view sl_stage_view(const sl_stage *s) {
    const sl_scene *scene = s->world.scene;
    return (sl_mark_view){scene->camera, s->side[0].settings.width, s->side[0].settings.height, s->tracer,
                          scene->scale};
}

static sl_vec3 through(const sl_mark_view *v, double column, double row) {
    const double half = tan(0.5 * (double)v->camera.vertical_fov), pixel = 2.0 * half / v->height;
    const float right = (float)((column + 0.5 - 0.5 * v->width) * pixel),
                up = (float)((0.5 * v->height - row - 0.5) * pixel);
    return sl_sub(sl_add(sl_scale(v->camera.right, right), sl_scale(v->camera.up, up)), v->camera.back);
}

/* The nearest to the pixel of those within its reach that nothing hides. */
static uint32_t pick_light(const sl_stage *s, const sl_mark_view *v, double column, double row) {
    const double reach = 0.014 * v->height + 4.0;
    double nearest = reach * reach;
    uint32_t found = 0;
    for (size_t i = 0; i < s->world.scene->light_count; i++) {
        const sl_light *l = &s->world.scene->lights[i];
        const float at[3] = {l->position.x, l->position.y, l->position.z};
        double x, y;
        if (l->type == SL_LIGHT_DIRECTIONAL || !sl_mark_project(v, at, &x, &y) || sl_mark_is_hidden(v, at))
            continue;
        const double d = (x - column - 0.5) * (x - column - 0.5) + (y - row - 0.5) * (y - row - 0.5);
        if (d < nearest) nearest = d, found = (uint32_t)i + 1;
    }
    return found;
}

static void add_hit(cJSON *m, const sl_scene *scene, uint32_t triangle, const sl_hit16 *hit,
                    sl_vec3 direction) {
    sl_surface surface;
    sl_scene_surface(scene, triangle, hit->w1[0], hit->w2[0], sl_neg(direction), &surface);
    const uint32_t object = scene->object_index[triangle];
    const sl_vec3 at = surface.position, normal = surface.geometric_normal;
    cJSON_AddStringToObject(m, "what", "object");
    cJSON_AddNumberToObject(m, "object", object + 1);
    cJSON_AddStringToObject(m, "name", scene->object_names[object]);
    cJSON_AddNumberToObject(m, "material", scene->material_index[triangle] + 1);
    cJSON_AddNumberToObject(m, "triangle", triangle);
    sl_add_floats(m, "at", (float[]){at.x, at.y, at.z}, 3);
    sl_add_floats(m, "normal", (float[]){normal.x, normal.y, normal.z}, 3);
}

static void add_light(cJSON *m, const sl_scene *scene, uint32_t light) {
    const sl_vec3 at = scene->lights[light - 1].position;
    cJSON_AddStringToObject(m, "what", "light");
    cJSON_AddNumberToObject(m, "light", light);
    sl_add_floats(m, "at", (float[]){at.x, at.y, at.z}, 3);
}

sl_status sl_take_pick(sl_stage *s, sl_taking *t) {
    int column, row;
    sl_status status = sl_take_pixel(t, &s->side[0].settings, &column, &row);
    if (status == SL_OK) status = sl_stage_needs_tracer(s, t->error);
    if (status != SL_OK) return status;
    const sl_mark_view view = sl_stage_view(s);
    const sl_vec3 direction = through(&view, column, row);
    const uint32_t light = pick_light(s, &view, column, row);
    sl_counters unused = {{0}};
    sl_ray16 ray;
    sl_hit16 hit;
    sl_ray16_set(&ray, 0, view.camera.eye, direction, 0.0f, INFINITY, SL_NO_INDEX);
    sl_trace(s->tracer, &ray, 1, false, &hit, &unused);
    cJSON *m = sl_message("picked");
    cJSON_AddNumberToObject(m, "x", column);
    cJSON_AddNumberToObject(m, "y", row);
    if (light) add_light(m, s->world.scene, light);
    else if (hit.triangle[0] != SL_NO_INDEX) add_hit(m, s->world.scene, hit.triangle[0], &hit, direction);
    else cJSON_AddStringToObject(m, "what", "sky");
    sl_say(s, s->client, m);
    return SL_OK;
}
