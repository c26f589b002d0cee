/* softlux info: what is in a scene, and the plan of a method. */
#include "app/auto_method.h"
#include "app/commands.h"
#include "app/options.h"
#include "app/page.h"
#include "scene/features.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_scene(const sl_scene *s) {
    sl_features f = sl_scene_features(s);
    printf("triangles    %zu (%zu diffuse, %zu glossy, %zu mirror, %zu emissive, %zu textured, %zu masked)\n",
           s->triangle_count, f.diffuse_triangles, f.glossy_triangles, f.mirror_triangles,
           f.emissive_triangles, f.textured_triangles, f.masked_triangles);
    if (s->bicubic_count)
        printf("surfaces     %zu bicubic, whose triangles are among these\n", s->bicubic_count);
    printf("vertices     %zu\nmaterials    %zu\ntextures     %zu\nobjects      %zu\n", s->vertex_count,
           s->material_count, s->texture_count, s->object_count);
    printf("lights       %zu point, %zu spot, %zu directional, %zu emissive triangles, %s\n", f.point_lights,
           f.spot_lights, f.directional_lights, f.emitters, f.environment ? "environment" : "no environment");
    printf("box          %g %g %g .. %g %g %g, diagonal %g\n", (double)s->box_min.x, (double)s->box_min.y,
           (double)s->box_min.z, (double)s->box_max.x, (double)s->box_max.y, (double)s->box_max.z,
           (double)s->diagonal);
    const sl_camera *c = &s->camera;
    printf("camera       eye %g %g %g, looking along %g %g %g, %.4g degrees high\n", (double)c->eye.x,
           (double)c->eye.y, (double)c->eye.z, -(double)c->back.x, -(double)c->back.y, -(double)c->back.z,
           (double)c->vertical_fov * 57.29577951308232);
    printf("film         %d x %d\nanimated     %s\nhash         %016" PRIx64 "\n", s->film_width,
           s->film_height, f.animated ? "yes" : "no", sl_scene_hash(s));
}

static sl_status print_plan(const sl_scene *scene, const sl_settings *settings, sl_error *error) {
    char *plan;
    sl_status status = sl_method_plan(scene, settings, &plan, error);
    if (status != SL_OK) return status;
    printf("\nplan of %s\n%s", settings->method, plan);
    free(plan);
    return SL_OK;
}

/* Prints which method --method auto takes, whatever the one whose plan is asked for; and if that is auto, its
 * plan.
 */
static sl_status print_choice(const sl_scene *scene, sl_settings *settings, sl_error *error) {
    sl_auto_budget budget = {.quality = settings->quality};
    sl_auto_choice choice;
    sl_status status = sl_auto_method(scene, settings, &budget, &choice, error);
    if (status != SL_OK) return status;
    printf("auto         %s\n", choice.why);
    if (strcmp(settings->method, "auto") == 0) settings->method = choice.method;
    return SL_OK;
}

int sl_command_info(int argc, char **argv) {
    const char *path;
    int operands, exit_status;
    sl_settings settings = sl_settings_default();
    sl_reading reading = {0};
    const sl_option none = {.name = NULL};
    const sl_command_line line = {
        "softlux info SCENE [options]",
        "Prints what is in a scene, what loading had to repair, and which passes a method would run.",
        NULL, &none, 1, 1, &reading, &settings, NULL};
    if (!sl_options_parse(&line, argc, argv, &path, &operands, &exit_status)) return exit_status;
    sl_error error;
    sl_scene *scene;
    sl_status status = sl_scene_load_with(path, &reading.load, &scene, &error);
    if (status == SL_OK) {
        print_scene(scene);
        for (size_t i = 0; i < sl_scene_warning_count(scene); i++)
            printf("warning      %s\n", sl_scene_warning(scene, i));
        status = print_choice(scene, &settings, &error);
        if (status == SL_OK) status = print_plan(scene, &settings, &error);
        sl_scene_destroy(scene);
    }
    return status == SL_OK ? 0 : sl_complain(&error);
}
