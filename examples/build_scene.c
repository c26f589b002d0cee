/* Builds a scene from arrays, two boxes on a table under a square lamp, writes it as a scene file and renders
 * it. C11: cc build_scene.c $(pkg-config --cflags --libs softlux) */
#include <softlux.h>
#include <stdio.h>
#include <stdlib.h>

static sl_error error;

static void must(sl_status status) {
    if (status == SL_OK) return;
    fprintf(stderr, "%s\n", error.message);
    exit((int)status);
}

static void place(sl_scene_builder *builder, uint32_t cube, const char *name, const float colour[3],
                  const double transform[16]) {
    sl_material_data paint = {
        .size = sizeof paint, .name = name, .diffuse = {colour[0], colour[1], colour[2]}};
    sl_instance_data box = {.size = sizeof box, .mesh = cube, .name = name, .transform = transform};
    must(sl_scene_builder_material(builder, &paint, &box.material, &error));
    must(sl_scene_builder_instance(builder, &box, &error));
}

int main(int argc, char **argv) {
    static const float corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    static const uint32_t faces[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                     3, 6, 2, 3, 7, 6, 0, 7, 3, 0, 4, 7, 1, 2, 6, 1, 6, 5};
    const sl_mesh_data data = {.size = sizeof data, .name = "cube", .vertex_count = 8, .positions = corners,
                               .triangle_count = 12, .indices = faces};
    const sl_light_data lamp = {.size = sizeof lamp, .type = SL_LIGHT_QUAD, .position = {-1, 4, -1},
                                .edge1 = {2, 0, 0}, .edge2 = {0, 0, 2}, .strength = {150, 140, 120},
                                .is_power = true};
    const float eye[] = {1, 3, 6}, target[] = {0, 0.5f, 0}, up[] = {0, 1, 0};
    if (argc != 3) return fprintf(stderr, "usage: %s SCENE.json PICTURE.exr\n", argv[0]), SL_ERROR_USAGE;

    sl_scene_builder *builder;
    uint32_t cube;
    must(sl_scene_builder_create(&builder, &error));
    must(sl_scene_builder_mesh(builder, &data, &cube, &error));
    place(builder, cube, "table", (float[]){0.7f, 0.7f, 0.7f}, /* by columns */
          (double[]){8, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, 8, 0, -4, -0.2, -4, 1});
    place(builder, cube, "red", (float[]){0.7f, 0.1f, 0.1f},
          (double[]){0.8, 0, -0.6, 0, 0, 2, 0, 0, 0.6, 0, 0.8, 0, -1.6, 0, -0.6, 1});
    place(builder, cube, "green", (float[]){0.1f, 0.6f, 0.2f},
          (double[]){0.9, 0, 0.4, 0, 0, 1, 0, 0, -0.4, 0, 0.9, 0, 0.7, 0, 0, 1});
    must(sl_scene_builder_light(builder, &lamp, &error));
    must(sl_scene_builder_camera(builder, eye, target, up, 0.7f, &error));
    must(sl_scene_builder_film(builder, 80, 60, &error));
    sl_scene *scene;
    must(sl_scene_builder_build(builder, &scene, &error));
    sl_scene_builder_destroy(builder);
    must(sl_scene_write(scene, argv[1], &error));

    sl_settings *settings;
    sl_method *method;
    sl_image *picture;
    sl_progress progress = {0};
    must(sl_settings_create(&settings, &error));
    must(sl_settings_set(settings, "quality", "draft", &error));
    must(sl_method_create(scene, settings, &method, &error));
    while (!progress.done) must(sl_method_update(method, &progress, &error));
    must(sl_method_resolve(method, &picture, &error));
    must(sl_image_write(picture, argv[2], &error));
    sl_image_destroy(picture);
    sl_method_destroy(method);
    sl_settings_destroy(settings);
    sl_scene_destroy(scene);
    return 0;
}
