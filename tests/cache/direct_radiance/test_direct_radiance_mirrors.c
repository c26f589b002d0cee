/* Whole frames of direct radiance mapping with mirrors before the eye. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "rendering.h"
#include "scene/scene.h"

enum { SIZE = 64, PIXELS = SIZE * SIZE };

/* A floor, a glossy wall and a lamp that shines towards the plane x = 0; there a mirror, or nothing. */
static const char json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}],"
    " \"materials\": {\"floor\": {\"diffuse\": [0.5, 0.6, 0.7]}, \"lamp\": {\"emission\": [8, 4, 2]},"
    " \"wall\": {\"diffuse\": 0.3, \"specular\": 0.4, \"exponent\": 8}%s},"
    " \"environment\": {\"radiance\": [0.25, 0.5, 1]},"
    " \"camera\": {\"eye\": [%g, 1, 0.3], \"target\": [%g, 0.9, 0], \"fov_deg\": 50}}";
static const char room_obj[] =
    "v 0 0 -2\nv 3 0 -2\nv 3 0 2\nv 0 0 2\nv 0 2 -2\nv 3 2 -2\nv 2 1.2 -1\nv 2 1.6 -1\nv 2 1.6 -0.4\nv 2 1.2 "
    "-0.4\n"
    "v 0 -9 -9\nv 0 9 -9\nv 0 9 9\nv 0 -9 9\nusemtl floor\nf 1 4 3 2\nusemtl wall\nf 1 2 6 5\n"
    "usemtl lamp\nf 7 10 9 8\n%s";
static const char glass[] = ", \"glass\": {\"mirror\": [0.9, 0.6, 0.3]}";
static const char mirror_obj[] = "usemtl glass\nf 11 12 13 14\n";

static sl_image *seen_from(float x, float towards, const char *mirror) {
    char scene_text[2048], mesh_text[1024];
    snprintf(scene_text, sizeof scene_text, json, *mirror ? glass : "", (double)x, (double)towards);
    snprintf(mesh_text, sizeof mesh_text, room_obj, mirror);
    sl_scene *scene = scene_from_text(scene_text, mesh_text);
    sl_settings settings = small_settings("direct-radiance", SIZE, SIZE);
    sl_image *image = render(scene, &settings, NULL);
    sl_scene_destroy(scene);
    return image;
}

/* Seen by way of the mirror x = 0, and from the eye's mirror image: the same turned round, times the mirror's
 * reflectance; there is no light by way of the mirror in the second, so the indirect part may be less. */
static void a_mirror_shows_what_its_image_of_the_eye_sees_and_dims_it(void **state) {
    static const char *const layers[] = {"emission.", "direct.", "indirect."};
    static const float reflectance[3] = {0.9f, 0.6f, 0.3f};
    sl_image *mirrored = seen_from(1.5f, 0.0f, mirror_obj), *straight = seen_from(-1.5f, 0.0f, "");
    size_t differing = 0, lit[3] = {0}, darker = 0;
    for (int l = 0; l < 3; l++) {
        for (int c = 0; c < 3; c++) {
            char name[SL_CHANNEL_NAME_MAX];
            snprintf(name, sizeof name, "%s%c", layers[l], "RGB"[c]);
            const float *a = sl_image_channel(mirrored, name), *b = sl_image_channel(straight, name);
            for (int i = 0; i < PIXELS; i++) {
                const float shown = a[i], wanted = reflectance[c] * b[i - i % SIZE + SIZE - 1 - i % SIZE];
                lit[l] += wanted > 0.0f;
                if (l < 2) differing += fabsf(shown - wanted) > 1e-3f * (shown + wanted);
                else darker += shown < 0.99f * wanted;
            }
        }
    }
    print_message("%zu of %zu differ, %zu are darker\n", differing, lit[0] + lit[1], darker);
    assert_true(lit[0] > 0 && lit[1] > PIXELS / 4 && lit[2] > PIXELS / 4);
    assert_true(differing < (lit[0] + lit[1]) / 50 && darker < lit[2] / 50); /* rounding at edges */
    destroy_pictures(mirrored, straight);
}

/* A ray that neither ends nor leaves is black, and finite. */
static void mirrors_face_to_face_come_to_an_end(void **state) {
    sl_image *image =
        seen_from(1.5f, 0.0f,
                  "usemtl glass\nf 11 12 13 14\nv 2.9 -9 -9\nv 2.9 9 -9\nv 2.9 9 9\nv 2.9 -9 9\n"
                  "f 15 16 17 18\n");
    size_t lit = 0;
    for (size_t i = 0; i < 3 * PIXELS; i++) {
        assert_true(isfinite(image->planes[i]) && image->planes[i] >= 0.0f);
        lit += image->planes[i] > 0.0f;
    }
    assert_true(lit > PIXELS);
    sl_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mirror_shows_what_its_image_of_the_eye_sees_and_dims_it),
        cmocka_unit_test(mirrors_face_to_face_come_to_an_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
