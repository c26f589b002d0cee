/* A loop as games have it: each frame moves a lamp and a box, tells the method, and writes a picture.
 * C11: cc moving_lamp.c $(pkg-config --cflags --libs softlux) -lm; moving_lamp METHOD FRAMES NAME */
#include <math.h>
#include <softlux.h>
#include <stdio.h>
#include <stdlib.h>

static sl_error error;

static void must(sl_status status) {
    if (status == SL_OK) return;
    fprintf(stderr, "%s\n", error.message);
    exit((int)status);
}

/* Objects are numbered as instances are added: the floor is 1, the box 2. The lamp is light 1. */
static sl_scene *build(void) {
    static const float corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    static const uint32_t faces[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                     3, 6, 2, 3, 7, 6, 0, 7, 3, 0, 4, 7, 1, 2, 6, 1, 6, 5};
    static const double floor_at[] = {8, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, 8, 0, -4, -0.2, -4, 1};
    const sl_mesh_data cube = {.size = sizeof cube, .vertex_count = 8, .positions = corners,
                               .triangle_count = 12, .indices = faces};
    const sl_light_data lamp = {.size = sizeof lamp, .type = SL_LIGHT_POINT, .position = {0, 3, 0},
                                .strength = {40, 36, 30}};
    const float eye[] = {1, 3, 6}, target[] = {0, 0.5f, 0}, up[] = {0, 1, 0};
    sl_scene_builder *builder;
    sl_instance_data placed = {.size = sizeof placed, .transform = floor_at};
    sl_scene *scene;
    must(sl_scene_builder_create(&builder, &error));
    must(sl_scene_builder_mesh(builder, &cube, &placed.mesh, &error));
    must(sl_scene_builder_instance(builder, &placed, &error));
    placed.transform = NULL;
    must(sl_scene_builder_instance(builder, &placed, &error));
    must(sl_scene_builder_light(builder, &lamp, &error));
    must(sl_scene_builder_camera(builder, eye, target, up, 0.7f, &error));
    must(sl_scene_builder_film(builder, 80, 60, &error));
    must(sl_scene_builder_build(builder, &scene, &error));
    sl_scene_builder_destroy(builder);
    return scene;
}

int main(int argc, char **argv) {
    if (argc != 4) return fprintf(stderr, "usage: %s METHOD FRAMES NAME\n", argv[0]), SL_ERROR_USAGE;
    sl_scene *scene = build();
    sl_settings *settings;
    sl_method *method;
    must(sl_settings_create(&settings, &error));
    must(sl_settings_set(settings, "quality", "draft", &error));
    must(sl_settings_set(settings, "method", argv[1], &error));
    must(sl_method_create(scene, settings, &method, &error));
    for (int frame = 0; frame < atoi(argv[2]); frame++) {
        const double time = 0.2 * frame, c = cos(time), s = sin(time);
        const double lamp[] = {2 * c, 3, 2 * s}, box[] = {c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, time, 0, 0, 1};
        sl_scene_edit *edit;
        must(sl_scene_edit_begin(scene, &edit, &error));
        must(sl_edit_light(edit, 1, NULL, lamp, NULL, &error));
        must(sl_edit_transform(edit, 2, box, &error));
        must(sl_scene_edit_commit(edit, NULL, &error)); /* both, or neither */
        must(sl_method_edit(method, 0, &error));

        sl_image *picture;
        sl_progress progress = {0};
        char path[256];
        while (!progress.done) must(sl_method_update(method, &progress, &error));
        must(sl_method_resolve(method, &picture, &error));
        snprintf(path, sizeof path, "%s-%03d.png", argv[3], frame);
        must(sl_image_write(picture, path, &error));
        sl_image_destroy(picture);
    }
    sl_method_destroy(method);
    sl_settings_destroy(settings);
    sl_scene_destroy(scene);
    return 0;
}
