/* Pass 4: environment cubes of curved mirrors. Each face is a picture of the scene like the camera's, planar
 * mirrors included, lit by the same passes. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"

#include <math.h>
#include <string.h>

enum { FACES = 6, TOGETHER = 4 /* cubes made at once: what they leave out is a byte a triangle each */ };

static void destroy_cubes(sl_environment_cube *cube, size_t count) {
    for (size_t n = 0; cube && n < count; n++) {
        for (int p = 0; p < SL_CUBE_PARTS; p++) sl_cube_map_destroy(cube[n].part[p]);
    }
    sl_free(cube);
}

/* ---- one face ---- */

typedef struct {
    const sl_mirror_pass *pass;
    const sl_mirror_objects *objects;
    sl_environment_cube *cube;          /* to be filled */
    size_t first;                    /* of the cubes that are made together */
    uint8_t *left_out[TOGETHER];
    sl_status status[TOGETHER * FACES];
    sl_error error[TOGETHER * FACES];
    sl_counters counters[TOGETHER * FACES];
} cubes_pass;

/* The planes of a face: three of each part, and which pixels are known. */
typedef struct {
    float *memory, *plane[SL_CUBE_PARTS][3], *known;
} face_planes;

static bool allocate_planes(face_planes *f, size_t pixels) {
    f->memory = sl_allocate((3 * SL_CUBE_PARTS + 1) * pixels, sizeof *f->memory);
    for (int p = 0; f->memory && p < SL_CUBE_PARTS; p++) {
        for (int k = 0; k < 3; k++) f->plane[p][k] = f->memory + (size_t)(3 * p + k) * pixels;
    }
    f->known = f->memory ? f->memory + 3 * SL_CUBE_PARTS * pixels : NULL;
    return f->memory != NULL;
}

/* The pixel shows a mirror that nothing tells about: a curved one, or a planar one beyond the nesting limit.
 */
static bool is_unknown_mirror(const sl_scene *scene, uint32_t id) {
    return id != SL_NO_INDEX && sl_material_is_mirror(&scene->materials[scene->material_index[id]]);
}

static void set_pixel(const face_planes *f, size_t i, sl_rgb value) {
    for (int p = 0; p < SL_CUBE_PARTS; p++) {
        f->plane[p][0][i] = value.r;
        f->plane[p][1][i] = value.g;
        f->plane[p][2][i] = value.b;
    }
}

/* Times the planar mirrors on the way. A mirror that is not known keeps the factor by which it will show the
 * cube's mean. */
static void finish_pixels(const cubes_pass *g, const sl_receivers *r, const face_planes *f) {
    const size_t pixels = (size_t)r->width * (size_t)r->height;
    const sl_scene *scene = g->pass->scene;
    for (size_t i = 0; i < pixels; i++) {
        const uint32_t id = r->gbuffer->id[i];
        const bool unknown = is_unknown_mirror(scene, id);
        f->known[i] = unknown ? 0.0f : 1.0f;
        if (unknown) set_pixel(f, i, scene->materials[scene->material_index[id]].mirror);
        for (int k = 0; k < 3 && r->throughput[k]; k++) {
            for (int p = 0; p < SL_CUBE_PARTS; p++) f->plane[p][k][i] *= r->throughput[k][i];
        }
    }
}

static sl_status light_face(const cubes_pass *g, const sl_receivers *r, const face_planes *f,
                            sl_counters *counters, sl_error *error) {
    sl_light_pass light = *g->pass->light;
    sl_lit_picture picture;
    light.threads = 1;
    light.trick_albedo = sl_grey(0.0f);
    memcpy(picture.direct, f->plane[SL_CUBE_DIRECT], sizeof picture.direct);
    memcpy(picture.indirect, f->plane[SL_CUBE_INDIRECT], sizeof picture.indirect);
    sl_add_emission(g->pass->scene, r, 1, f->plane[SL_CUBE_EMISSION], counters);
    sl_status status = sl_light_directly(&light, r, &picture, counters, error);
    if (status == SL_OK && g->pass->indirect)
        status = sl_light_indirectly(&light, r, &picture, NULL, counters, error);
    if (status != SL_OK) return status;
    finish_pixels(g, r, f);
    return SL_OK;
}

static void keep_face(sl_environment_cube *cube, int face, int size, const face_planes *f) {
    for (int p = 0; p < SL_CUBE_PARTS; p++) {
        sl_pbuffer planes = {.width = size, .height = size, .format = SL_PBUFFER_RGBA32F,
                             .channel = {f->plane[p][0], f->plane[p][1], f->plane[p][2], f->known}};
        if (cube->part[p]) sl_cube_map_set_face(cube->part[p], face, &planes);
    }
}

static sl_status make_face(const cubes_pass *g, size_t number, int face, sl_counters *counters,
                           sl_error *error) {
    const sl_mirror_pass *pass = g->pass;
    const int size = pass->cube_size;
    sl_view view =
        sl_view_cube_face(g->objects->object[number].centre, face, size, 1e-5f * pass->scene->scale);
    sl_receivers *r = NULL;
    face_planes planes;
    view.left_out = g->left_out[number - g->first];
    if (!allocate_planes(&planes, (size_t)size * (size_t)size))
        return sl_fail_memory(error, "a face of an environment cube");
    sl_status status = sl_receivers_render(pass->scene, pass->raster, &view, pass->planar, pass->reflections,
                                           1, &r, counters, error);
    if (status == SL_OK) status = light_face(g, r, &planes, counters, error);
    if (status == SL_OK) keep_face(&g->cube[number], face, size, &planes);
    sl_receivers_destroy(r);
    sl_free(planes.memory);
    return status;
}

static void make_face_task(void *context, size_t index, unsigned worker) {
    (void)worker;
    cubes_pass *g = context;
    g->status[index] =
        make_face(g, g->first + index / FACES, (int)(index % FACES), &g->counters[index], &g->error[index]);
}

/* ---- one cube, when its faces are there ---- */

typedef struct {
    double sum[3], weight;
} cube_mean;

/* By solid angle, which is proportional to (1 + x^2 + y^2)^(-3/2) at a point of the face. */
static void sum_face(const sl_cube_map *map, int face, cube_mean *mean) {
    const int n = map->size;
    for (int y = 0; y < n; y++) {
        const double v = (2.0 * y + 1.0) / n - 1.0;
        for (int x = 0; x < n; x++) {
            const float *texel = sl_cube_map_texel(map, 0, face, x, y);
            const double u = (2.0 * x + 1.0) / n - 1.0, squared = 1.0 + u * u + v * v;
            const double weight = texel[3] > 0.0f ? 1.0 / (squared * sqrt(squared)) : 0.0;
            for (int k = 0; k < 3; k++) mean->sum[k] += weight > 0.0 ? weight * (double)texel[k] : 0.0;
            mean->weight += weight;
        }
    }
}

static bool all_known(const sl_cube_map *map) {
    for (int face = 0; face < FACES; face++) {
        for (int y = 0; y < map->size; y++) {
            const float *texel = sl_cube_map_texel(map, 0, face, 0, y);
            for (int x = 0; x < map->size; x++) {
                if (!(texel[4 * x + 3] > 0.0f)) return false;
            }
        }
    }
    return true;
}

/* Mirrors that are not known show the mean of what is. */
static void fill_unknown(const sl_cube_map *map) {
    if (all_known(map)) return;
    cube_mean mean = {{0.0, 0.0, 0.0}, 0.0};
    for (int face = 0; face < FACES; face++) sum_face(map, face, &mean);
    const double over = mean.weight > 0.0 ? 1.0 / mean.weight : 0.0;
    for (int face = 0; face < FACES; face++) {
        for (int y = 0; y < map->size; y++) {
            float *texel = sl_cube_map_texel(map, 0, face, 0, y);
            for (int x = 0; x < map->size; x++, texel += 4) {
                if (texel[3] > 0.0f) continue;
                for (int k = 0; k < 3; k++) texel[k] *= (float)(mean.sum[k] * over);
                texel[3] = 1.0f;
            }
        }
    }
}

static void complete_cube_task(void *context, size_t index, unsigned worker) {
    (void)worker;
    const cubes_pass *g = context;
    for (int p = 0; p < SL_CUBE_PARTS; p++) {
        sl_cube_map *map = g->cube[g->first + index].part[p];
        if (!map) continue;
        fill_unknown(map);
        sl_cube_map_build(map, 1);
    }
}

/* ---- all cubes ---- */

static sl_status create_cubes(const sl_mirror_pass *pass, size_t count, sl_environment_cube **cubes,
                              sl_error *error) {
    const sl_scene *scene = pass->scene;
    const bool shines = scene->emitter_count > 0 || scene->environment.present;
    const bool wanted[SL_CUBE_PARTS] = {
        [SL_CUBE_EMISSION] = shines, [SL_CUBE_DIRECT] = true, [SL_CUBE_INDIRECT] = pass->indirect};
    *cubes = sl_allocate(count, sizeof **cubes);
    if (!*cubes) return sl_fail_memory(error, "environment cubes");
    for (size_t n = 0; n < count; n++) {
        for (int p = 0; p < SL_CUBE_PARTS; p++) {
            sl_status status =
                wanted[p] ? sl_cube_map_create(pass->cube_size, false, &(*cubes)[n].part[p], error) : SL_OK;
            if (status != SL_OK) return status;
        }
    }
    return SL_OK;
}

static sl_status make_together(cubes_pass *g, size_t count, sl_counters *counters, sl_error *error) {
    const unsigned threads = sl_thread_count(g->pass->light->threads);
    memset(g->counters, 0, sizeof g->counters);
    for (size_t n = 0; n < count; n++)
        sl_mirror_object_mark(g->pass->scene, &g->objects->object[g->first + n], g->left_out[n]);
    sl_parallel_for(threads, count * FACES, make_face_task, g);
    for (size_t i = 0; i < count * FACES; i++) {
        if (g->status[i] != SL_OK && error) *error = g->error[i];
        if (g->status[i] != SL_OK) return g->status[i];
        sl_counters_add(counters, &g->counters[i]);
    }
    sl_parallel_for(threads, count, complete_cube_task, g);
    return SL_OK;
}

static sl_status make_cubes(const sl_mirror_pass *pass, const sl_mirror_objects *objects,
                            sl_environment_cube **cubes, sl_counters *counters, sl_error *error) {
    sl_status status = create_cubes(pass, objects->count, cubes, error);
    cubes_pass *g = sl_allocate(1, sizeof *g);
    bool ok = g != NULL;
    for (size_t n = 0; ok && n < TOGETHER && n < objects->count; n++) {
        g->left_out[n] = sl_allocate(pass->scene->triangle_count, 1);
        ok = g->left_out[n] != NULL;
    }
    if (status == SL_OK && !ok) status = sl_fail_memory(error, "environment cubes");
    if (ok) {
        g->pass = pass;
        g->objects = objects;
        g->cube = *cubes;
    }
    for (size_t first = 0; status == SL_OK && first < objects->count; first += TOGETHER) {
        g->first = first;
        status = make_together(g, objects->count - first < TOGETHER ? objects->count - first : TOGETHER,
                               counters, error);
    }
    for (size_t n = 0; g && n < TOGETHER; n++) sl_free(g->left_out[n]);
    sl_free(g);
    return status;
}

sl_status sl_curved_mirrors_render(const sl_mirror_pass *pass, const sl_receivers *seen,
                                   sl_curved_mirrors **mirrors, sl_counters *counters, sl_error *error) {
    *mirrors = NULL;
    sl_curved_mirrors *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "the curved mirrors");
    *m = (sl_curved_mirrors){.scene = pass->scene, .planar = pass->planar};
    sl_status status = sl_mirror_objects_find(pass->scene, pass->planar, seen, &m->objects, error);
    if (status == SL_OK && m->objects.count)
        status = make_cubes(pass, &m->objects, &m->cube, counters, error);
    if (status == SL_OK && m->objects.count) *mirrors = m;
    else sl_curved_mirrors_destroy(m);
    return status;
}

void sl_curved_mirrors_destroy(sl_curved_mirrors *m) {
    if (!m) return;
    destroy_cubes(m->cube, m->objects.count);
    sl_mirror_objects_release(&m->objects);
    sl_free(m);
}

size_t sl_curved_mirrors_bytes(const sl_curved_mirrors *m) {
    if (!m) return 0;
    size_t bytes = sizeof *m + m->objects.count * (sizeof *m->cube + sizeof *m->objects.object);
    for (size_t n = 0; n < m->objects.count; n++) {
        for (int p = 0; p < SL_CUBE_PARTS; p++) {
            const sl_cube_map *map = m->cube[n].part[p];
            size_t side = map ? (size_t)map->size + 2 : 0; /* with its border */
            bytes += FACES * side * side * 4 * sizeof(float);
        }
    }
    return bytes;
}
