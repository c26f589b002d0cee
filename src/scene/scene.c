/* A scene's life after it is built: what it says of itself, its hash, its end. */
#include "scene/scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/print.h"
#include "base/random.h"
#include "scene/animation.h"
#include "scene/derive.h"

size_t sl_scene_warning_count(const sl_scene *scene) {
    return scene->warning_count + (scene->warnings_left_out > 0);
}
const char *sl_scene_warning(const sl_scene *scene, size_t index) {
    if (index < scene->warning_count) return scene->warnings[index];
    return index < sl_scene_warning_count(scene) ? scene->more_warnings : NULL;
}
size_t sl_scene_triangle_count(const sl_scene *scene) { return scene->triangle_count; }
void sl_scene_film(const sl_scene *scene, int *width, int *height) {
    *width = scene->film_width;
    *height = scene->film_height;
}

void sl_scene_arrays(sl_scene *s, sl_scene_array list[SL_SCENE_ARRAYS]) {
    void *const by_vertex[] = {&s->position_x, &s->position_y, &s->position_z, &s->normal_x,
                               &s->normal_y,   &s->normal_z,   &s->texture_u,  &s->texture_v};
    void *const by_triangle[] = {&s->vertex[0],
                                 &s->vertex[1],
                                 &s->vertex[2],
                                 &s->material_index,
                                 &s->object_index,
                                 &s->geometric_normal_x,
                                 &s->geometric_normal_y,
                                 &s->geometric_normal_z,
                                 &s->emitter_of_triangle};
    for (int k = 0; k < 8; k++)
        *list++ = (sl_scene_array){by_vertex[k], s->vertex_count * sizeof(float), k < 6};
    for (int k = 0; k < 9; k++)
        *list++ = (sl_scene_array){by_triangle[k], s->triangle_count * sizeof(uint32_t), k >= 5};
    *list++ = (sl_scene_array){&s->emitters, s->emissive_count * sizeof *s->emitters, true};
    *list++ = (sl_scene_array){&s->opaque_share, s->emissive_count * sizeof *s->opaque_share, false};
    *list++ = (sl_scene_array){&s->lights, s->light_count * sizeof *s->lights, true};
    *list = (sl_scene_array){&s->bicubics, s->bicubic_count * sizeof *s->bicubics, true};
}

static size_t animation_bytes(const sl_scene *s) {
    const size_t a_vertex = sizeof *s->animation->track_of_vertex + sizeof *s->animation->rest_position +
                            sizeof *s->animation->rest_normal;
    return s->animation
               ? s->vertex_count * a_vertex + s->bicubic_count * 16 * sizeof *s->animation->rest_control
               : 0;
}

size_t sl_scene_memory_bytes(const sl_scene *scene) {
    sl_scene s = *scene; /* whose pointers are listed, and not followed */
    sl_scene_array arrays[SL_SCENE_ARRAYS];
    const sl_environment *e = &s.environment;
    const size_t texels = (size_t)e->width * (size_t)e->height;
    size_t bytes = sizeof s + s.material_count * sizeof *s.materials + animation_bytes(&s) +
                   texels * (3 * sizeof *e->texels + sizeof *e->column_cdf + sizeof *e->column_guide) +
                   (size_t)e->height * (sizeof *e->row_cdf + sizeof *e->row_guide + sizeof *e->row_edge);
    sl_scene_arrays(&s, arrays);
    for (int k = 0; k < SL_SCENE_ARRAYS; k++) bytes += arrays[k].bytes;
    for (size_t i = 0; i < s.texture_count; i++)
        bytes += sizeof *s.textures + 4 * (size_t)s.textures[i].width * (size_t)s.textures[i].height;
    return bytes;
}

char *sl_string_copy(const char *text) {
    if (!text) text = "";
    return sl_copy_of(text, strlen(text) + 1, 1);
}

void sl_strings_free(char **list, size_t count) {
    for (size_t i = 0; list && i < count; i++) sl_free(list[i]);
    sl_free(list);
}

void sl_scene_leave_out_warnings(sl_scene *scene, size_t count) {
    scene->warnings_left_out += count;
    snprintf(scene->more_warnings, sizeof scene->more_warnings, "and %zu more of such lines",
             scene->warnings_left_out);
}

/* Without memory for it the warning is lost, never the scene. */
void sl_scene_warn(sl_scene *scene, const char *format, ...) {
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    sl_print_list(line, sizeof line, format, arguments);
    va_end(arguments);
    for (char *c = line; *c; c++) *c = *c == '\n' || *c == '\r' ? ' ' : *c;
    for (size_t i = 0; i < scene->warning_count; i++) {
        if (strcmp(scene->warnings[i], line) == 0) return; /* once is enough */
    }
    if (scene->warning_count >= (scene->is_read ? 2 * SL_WARNINGS : SL_WARNINGS)) {
        sl_scene_leave_out_warnings(scene, 1);
        return;
    }
    char *copy = sl_string_copy(line);
    if (copy &&
        sl_regrow(&scene->warnings, scene->warning_count, scene->warning_count + 1, sizeof *scene->warnings))
        scene->warnings[scene->warning_count++] = copy;
    else sl_free(copy);
}

/* ---- the end --------------------------------------------------------------------------------- */

void sl_scene_release(sl_scene *s) {
    sl_scene_array arrays[SL_SCENE_ARRAYS];
    sl_scene_arrays(s, arrays);
    for (int k = 0; k < SL_SCENE_ARRAYS; k++) sl_free(sl_scene_array_at(&arrays[k]));
    for (size_t i = 0; i < s->material_count; i++) sl_free(s->materials[i].name);
    sl_free(s->materials);
    for (size_t i = 0; i < s->texture_count; i++) {
        sl_free(s->textures[i].file);
        sl_free(s->textures[i].texels);
    }
    sl_free(s->textures);
    sl_environment_release(&s->environment);
    sl_animation_destroy(s->animation);
    sl_strings_free(s->object_names, s->object_count);
    sl_strings_free(s->warnings, s->warning_count);
    sl_strings_free(s->files, s->file_count);
}

void sl_scene_destroy(sl_scene *scene) {
    if (scene) sl_scene_release(scene);
    sl_free(scene);
}

/* ---- the hash -------------------------------------------------------------------------------- */

/* The length closes, so that lists cannot run into each other. */
static void hash_bytes(uint64_t *hash, const void *data, size_t bytes) {
    *hash = sl_hash64(sl_hash_bytes(*hash, data, bytes) ^ bytes);
}

static void hash_rgb(uint64_t *hash, sl_rgb c) {
    hash_bytes(hash, (float[3]){c.r, c.g, c.b}, 3 * sizeof(float));
}
static void hash_vec3(uint64_t *hash, sl_vec3 v) {
    hash_bytes(hash, (float[3]){v.x, v.y, v.z}, 3 * sizeof(float));
}

static void hash_geometry(uint64_t *hash, const sl_scene *scene) {
    sl_scene s = *scene;
    sl_scene_array arrays[SL_SCENE_ARRAYS];
    sl_scene_arrays(&s, arrays);
    for (int k = 0; k < SL_HASHED_ARRAYS; k++) hash_bytes(hash, sl_scene_array_at(&arrays[k]), arrays[k].bytes);
    for (size_t i = 0; i < s.bicubic_count; i++) {
        const sl_bicubic *b = &s.bicubics[i];
        for (int k = 0; k < 16; k++) hash_vec3(hash, b->point[k / 4][k % 4]);
        hash_bytes(hash, (uint32_t[3]){b->first_vertex, b->first_triangle, (uint32_t)b->steps},
                   3 * sizeof(uint32_t));
    }
}

static void hash_material(uint64_t *hash, const sl_material *m) {
    hash_rgb(hash, m->diffuse);
    hash_rgb(hash, m->specular);
    hash_bytes(hash, &m->exponent, sizeof m->exponent);
    hash_rgb(hash, m->mirror);
    hash_rgb(hash, m->emission);
    hash_bytes(hash, (uint32_t[3]){m->emission_two_sided, m->texture, m->alpha_texture},
               3 * sizeof(uint32_t));
    if (m->height_map == SL_NO_INDEX) return;
    hash_bytes(hash, &m->height_map, sizeof m->height_map);
    hash_bytes(hash, &m->bump_depth, sizeof m->bump_depth);
}

static void hash_light(uint64_t *hash, const sl_light *l) {
    hash_bytes(hash, (uint32_t[1]){(uint32_t)l->type}, sizeof(uint32_t));
    hash_vec3(hash, l->position);
    hash_vec3(hash, l->direction);
    hash_rgb(hash, l->intensity);
    hash_bytes(hash, (float[2]){l->cos_inner, l->cos_outer}, 2 * sizeof(float));
}

static void hash_environment(uint64_t *hash, const sl_environment *e) {
    hash_bytes(hash, (int32_t[3]){e->present, e->width, e->height}, 3 * sizeof(int32_t));
    hash_rgb(hash, e->constant);
    if (e->width > 0) hash_bytes(hash, e->texels, 3 * (size_t)e->width * (size_t)e->height * sizeof(float));
}

static void hash_camera(uint64_t *hash, const sl_camera *c) {
    hash_vec3(hash, c->eye);
    hash_vec3(hash, c->right);
    hash_vec3(hash, c->up);
    hash_vec3(hash, c->back);
    hash_bytes(hash, &c->vertical_fov, sizeof c->vertical_fov);
}

uint64_t sl_scene_light_hash(const sl_scene *scene) {
    uint64_t hash = 0x736f66746c7578u; /* "softlux" */
    hash_geometry(&hash, scene);
    for (size_t i = 0; i < scene->material_count; i++) hash_material(&hash, &scene->materials[i]);
    for (size_t i = 0; i < scene->texture_count; i++) {
        const sl_texture *t = &scene->textures[i];
        hash_bytes(&hash, (int32_t[3]){t->width, t->height, t->has_alpha}, 3 * sizeof(int32_t));
        hash_bytes(&hash, t->texels, 4 * (size_t)t->width * (size_t)t->height);
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        if (sl_light_is_lit(&scene->lights[i])) hash_light(&hash, &scene->lights[i]);
    }
    hash_environment(&hash, &scene->environment);
    return hash;
}

uint64_t sl_scene_hash_of(const sl_scene *scene, uint64_t light_hash) {
    uint64_t hash = light_hash;
    hash_camera(&hash, &scene->camera);
    hash_bytes(&hash, (int32_t[2]){scene->film_width, scene->film_height}, 2 * sizeof(int32_t));
    return hash;
}

uint64_t sl_scene_hash(const sl_scene *scene) { return sl_scene_hash_of(scene, sl_scene_light_hash(scene)); }

/* ---- sub-frames ---- */

enum { CLEARED = 1 << 16 }; /* pixels of a plane, by one thread */

typedef struct clearing {
    const sl_sub_frame *at;
    float *plane;
    size_t pixels, parts; /* of each plane */
} clearing;

static void clear_part(void *context, size_t index, unsigned worker) {
    (void)worker;
    const clearing *c = context;
    float *plane = c->plane + index / c->parts * c->pixels;
    const size_t first = index % c->parts * CLEARED, end = sl_fewer(first + CLEARED, c->pixels);
    for (sl_pixel_run r = sl_sub_frame_run(c->at, first, end); r.first < r.end;
         r = sl_sub_frame_run(c->at, r.end, end))
        memset(plane + r.first, 0, (r.end - r.first) * sizeof *plane);
}

void sl_sub_frame_clear(const sl_sub_frame *at, unsigned threads, float *plane, size_t planes,
                        size_t pixels) {
    clearing c = {at, plane, pixels, (pixels + CLEARED - 1) / CLEARED};
    sl_parallel_for(threads, planes * c.parts, clear_part, &c);
}
