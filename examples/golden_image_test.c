/* A golden-image test: renders a small picture and holds every bit of it against the one in a file. The first
 * run, without that file, makes it. C11 and C++: cc golden_image_test.c $(pkg-config --cflags --libs softlux)
 */
#include <softlux.h>
#include <stdio.h>

static int fail(const sl_error *error) {
    fprintf(stderr, "%s\n", error->message);
    return error->status;
}

int main(int argc, char **argv) {
    if (argc != 3) return fprintf(stderr, "usage: %s SCENE GOLDEN.exr\n", argv[0]), SL_ERROR_USAGE;
    sl_error error;
    sl_scene *scene = NULL;
    sl_method *method = NULL;
    sl_image *picture = NULL, *golden = NULL;
    sl_progress progress;
    sl_settings *settings = NULL;
    if (sl_scene_load(argv[1], &scene, &error) != SL_OK) return fail(&error);
    if (sl_settings_create(&settings, &error) != SL_OK) return fail(&error);
    if (sl_settings_set(settings, "size", "64x64", &error) != SL_OK) return fail(&error);
    if (sl_settings_set(settings, "quality", "draft", &error) != SL_OK) return fail(&error);
    if (sl_method_create(scene, settings, &method, &error) != SL_OK) return fail(&error);
    sl_settings_destroy(settings);
    do
        if (sl_method_update(method, &progress, &error) != SL_OK) return fail(&error);
    while (!progress.done);
    if (sl_method_resolve(method, &picture, &error) != SL_OK) return fail(&error);

    FILE *there = fopen(argv[2], "rb");
    if (!there) return sl_image_write(picture, argv[2], &error) == SL_OK ? 0 : fail(&error);
    fclose(there);
    sl_comparison result;
    if (sl_image_read(argv[2], &golden, &error) != SL_OK) return fail(&error);
    if (sl_image_compare(picture, golden, NULL, &result, NULL, &error) != SL_OK) return fail(&error);
    printf("%s: %s, relative RMSE %g\n", argv[2], result.identical ? "identical" : "different",
           result.rel_rmse);
    sl_image_destroy(golden);
    sl_image_destroy(picture);
    sl_method_destroy(method);
    sl_scene_destroy(scene);
    return result.identical ? 0 : 1;
}
