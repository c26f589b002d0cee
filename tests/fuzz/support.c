#include "support.h"

#include "least_settings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FILES_MAX = 64, DRAWN_TRIANGLES = 600, DRAWN_UPDATES = 6 };

_Noreturn void fuzz_fail(const char *what) {
    fprintf(stderr, "fuzz: %s\n", what);
    abort();
}

/* ---- files ----------------------------------------------------------------------------------- */

static char folder[128], written[FILES_MAX][32];
static size_t written_count;

static void remove_folder(void) {
    for (size_t i = 0; i < written_count; i++) unlink(fuzz_path(written[i]));
    rmdir(folder);
}

const char *fuzz_path(const char *name) {
    static char paths[4][256];
    static unsigned next;
    if (!folder[0]) {
        const char *base = getenv("TMPDIR");
        snprintf(folder, sizeof folder, "%.80s/softlux-fuzz-XXXXXX", base ? base : "/tmp");
        if (!mkdtemp(folder)) fuzz_fail("cannot make a folder");
        atexit(remove_folder);
    }
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%.100s", folder, name);
    return path;
}

static void remember(const char *name) {
    for (size_t i = 0; i < written_count; i++) {
        if (strcmp(written[i], name) == 0) return;
    }
    if (written_count == FILES_MAX || strlen(name) >= sizeof written[0])
        fuzz_fail("too many files, or too long a name");
    strcpy(written[written_count++], name);
}

void fuzz_write(const char *name, const void *data, size_t size) {
    FILE *file = fopen(fuzz_path(name), "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) fuzz_fail("cannot write a file");
    remember(name);
}

/* ---- numbers --------------------------------------------------------------------------------- */

uint32_t fuzz_take(fuzz_bytes *bytes, unsigned count) {
    uint32_t value = 0;
    for (unsigned i = 0; i < count && bytes->at < bytes->end; i++) value |= (uint32_t)*bytes->at++ << (8 * i);
    return value;
}

float fuzz_take_float(fuzz_bytes *bytes) {
    uint32_t head = fuzz_take(bytes, 1);
    if (head % 8 != 7) return ((float)(head / 8) - 8.0f) * 0.25f;
    uint32_t bits = fuzz_take(bytes, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

uint32_t fuzz_hash(const uint8_t *data, size_t size) { /* FNV-1a */
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < size; i++) hash = (hash ^ data[i]) * 16777619u;
    return hash ^ hash >> 15;
}

/* ---- what must hold -------------------------------------------------------------------------- */

void fuzz_check_error(const sl_error *error) {
    if (error->status == SL_OK || !error->message[0]) fuzz_fail("an error that says nothing");
    if (strpbrk(error->message, "\n\r")) fuzz_fail("an error of several lines");
}

static bool is_unit(sl_vec3 n) {
    float square = sl_dot(n, n);
    return square > 0.99f && square < 1.01f;
}

static void check_promises(const sl_scene *s) {
    if (s->triangle_count == 0 || s->material_count == 0 || !(s->diagonal > 0.0f))
        fuzz_fail("an empty scene");
    for (size_t t = 0; t < s->triangle_count; t++) {
        if (s->material_index[t] >= s->material_count || s->object_index[t] >= s->object_count)
            fuzz_fail("a triangle of no material or object");
        if (!is_unit(sl_scene_geometric_normal(s, (uint32_t)t)))
            fuzz_fail("a geometric normal that is no unit vector");
        for (int c = 0; c < 3; c++) {
            if (s->vertex[c][t] >= s->vertex_count) fuzz_fail("a corner without a vertex");
        }
    }
    for (uint32_t v = 0; v < s->vertex_count; v++) {
        if (!sl_is_finite(sl_scene_position(s, v))) fuzz_fail("a vertex that is not finite");
        if (!is_unit(sl_scene_normal(s, v))) fuzz_fail("a normal that is no unit vector");
    }
    for (size_t i = 0; i < s->material_count; i++) {
        const sl_material *m = &s->materials[i];
        const float sums[3] = {m->diffuse.r + m->specular.r, m->diffuse.g + m->specular.g,
                               m->diffuse.b + m->specular.b};
        for (int c = 0; c < 3; c++) {
            if (!(sums[c] >= 0.0f && sums[c] <= 1.0f))
                fuzz_fail("a material that reflects more than it gets");
        }
        if (m->texture != SL_NO_INDEX && m->texture >= s->texture_count) fuzz_fail("a texture that is none");
        if (m->alpha_texture != SL_NO_INDEX && m->alpha_texture >= s->texture_count)
            fuzz_fail("a mask that is none");
        if (m->height_map != SL_NO_INDEX && m->height_map >= s->texture_count)
            fuzz_fail("a height map that is none");
    }
}

/* Lights of 1e-6 to 1e12, rooms of 1e-3 to 1e6, not farther away than a million times their size. */
static bool within_reason(const sl_scene *s) {
    float brightest = 0.0f, farthest = 0.0f;
    for (size_t i = 0; i < s->emitter_count; i++)
        brightest = fmaxf(brightest, sl_rgb_max(s->emitters[i].radiance));
    for (size_t i = 0; i < s->light_count; i++) {
        brightest = fmaxf(brightest, sl_rgb_max(s->lights[i].intensity));
        farthest = fmaxf(farthest, sl_length(s->lights[i].position));
    }
    for (size_t i = 0; i < 3 * (size_t)s->environment.width * (size_t)s->environment.height; i++)
        brightest = fmaxf(brightest, s->environment.texels[i]);
    brightest = fmaxf(brightest, sl_rgb_max(s->environment.constant));
    farthest = fmaxf(farthest, fmaxf(sl_length(s->box_min), sl_length(s->box_max)));
    farthest = fmaxf(farthest, sl_length(s->camera.eye));
    return brightest < 1e12f && s->diagonal > 1e-3f && s->diagonal < 1e6f && farthest < 1e3f * s->diagonal;
}

static sl_settings settings_of(uint32_t choice) {
    size_t count = 0;
    while (sl_method_name(count)) count++;
    sl_settings s = least_settings(sl_method_name(choice % count), 4, 4);
    s.multi_mesh.coarse_edge = 1e12; /* scenes may be of any size */
    return s;
}

static void check_pixels(const sl_image *image, bool finite) {
    size_t values = 3 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < values; i++) {
        if (image->planes[i] < 0.0f) fuzz_fail("a negative pixel");
        if (finite && !isfinite(image->planes[i])) fuzz_fail("a pixel that is not finite");
    }
}

static void draw(const sl_scene *scene, const sl_settings *settings) {
    sl_method *method = NULL;
    sl_image *image = NULL;
    sl_progress progress = {0};
    sl_error error = {0};
    sl_status status = sl_method_create(scene, settings, &method, &error);
    for (int i = 0; i < DRAWN_UPDATES && status == SL_OK && !progress.done; i++)
        status = sl_method_update(method, &progress, &error);
    if (status == SL_OK) status = sl_method_resolve(method, &image, &error);
    if (status == SL_OK) check_pixels(image, within_reason(scene));
    else fuzz_check_error(&error);
    if (status == SL_ERROR_USAGE) fuzz_fail(error.message);
    sl_image_destroy(image);
    sl_method_destroy(method);
}

void fuzz_check_scene(sl_scene *scene, uint32_t choice) {
    check_promises(scene);
    sl_scene_hash(scene);
    if (scene->triangle_count > DRAWN_TRIANGLES) return;
    sl_settings settings = settings_of(choice);
    sl_error error = {0};
    char *plan = NULL;
    if (sl_method_plan(scene, &settings, &plan, &error) != SL_OK) fuzz_check_error(&error);
    free(plan);
    if (choice / 64 % 4 == 0) draw(scene, &settings);
    if (!scene->animation) return;
    error = (sl_error){0};
    if (sl_scene_set_time(scene, 0.5 + choice % 5, NULL, &error) != SL_OK) {
        fuzz_check_error(&error);
        return;
    }
    check_promises(scene);
    if (choice / 64 % 4 == 1) draw(scene, &settings);
}
